"""The two errors that a user meets: a question without an answer, and an answer not found."""


class ProblemError(ValueError):
    """The question is ill posed, or an argument is out of its range (exit code 2)."""


class SolverError(RuntimeError):
    """A well-posed question to which no trustworthy answer was found (exit code 3)."""
