"""Linear systems of a body: orderings, factors, multigrid, and the choice between these."""

from reference_fem.systems.factor import Factor, factorised, has_cholmod, signed
from reference_fem.systems.solver import Solved, Solver

__all__ = ["Factor", "Solved", "Solver", "factorised", "has_cholmod", "signed"]
