"""The two errors that a user meets: a question without an answer, and an answer not found."""


class ProblemError(ValueError):
    """The question is ill posed, or an argument is out of its range (exit code 2)."""


class SolverError(RuntimeError):
    """A well-posed question to which no trustworthy answer was found (exit code 3)."""


class UnstableError(SolverError):
    """No stable equilibrium under the whole load; `reached` is the largest part that has one."""

    def __init__(self, message: str, reached: float = 0.0) -> None:
        super().__init__(message)
        self.reached = reached
