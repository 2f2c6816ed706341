"""Linear systems of a body: orderings, factors, multigrid, and the choice between these."""

from reference_fem.systems.factor import Factor, factorise, has_cholmod, signed_factor
from reference_fem.systems.solver import Solver, SystemSolution

__all__ = ["Factor", "Solver", "SystemSolution", "factorise", "has_cholmod", "signed_factor"]
