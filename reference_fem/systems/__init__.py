"""Linear systems of a body: orderings, factors, multigrid, and the choice between these."""

from reference_fem.systems.solver import Solver, SystemSolution

__all__ = ["Solver", "SystemSolution"]
