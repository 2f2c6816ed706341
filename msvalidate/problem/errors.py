"""Errors that a user meets: an ill-posed problem, and a missing solution."""


class ProblemError(ValueError):
    """Error raised for an ill-posed problem or an argument out of range.

    The command line exits with code 2. It is a `ValueError` whose message names the value and a
    remedy.

    Examples
    --------
    >>> from msvalidate import Box, ProblemError
    >>> try:
    ...     Box((0.0, 1.0))
    ... except ProblemError as error:
    ...     print(error)
    box size along x: 0.0 m; it must be above zero
    """


class SolverError(RuntimeError):
    """Error raised when a well-posed problem has no trustworthy solution.

    The command line exits with code 3. It is a `RuntimeError`, for example for a mechanism or an
    iteration that diverges.

    Examples
    --------
    >>> from msvalidate import Box, Isotropic, Problem, SolverError, Support
    >>> from msvalidate import equilibrium, lattice_network, square
    >>> box = Box((0.4, 0.1))
    >>> clamp = Support(box.side("left"), (0.0, 0.0))
    >>> problem = Problem(box, Isotropic(E=1e5, nu=1 / 3), supports=(clamp,))
    >>> without_diagonals = lattice_network(problem, square(box, (4, 1)), (1e5, 0.0))
    >>> try:
    ...     equilibrium(without_diagonals)
    ... except SolverError as error:
    ...     print("mechanism" in str(error))
    True
    """


class UnstableError(SolverError):
    """No stable equilibrium under the whole load; `reached` is the largest part that has one."""

    def __init__(self, message: str, reached: float = 0.0) -> None:
        super().__init__(message)
        self.reached = reached
