"""What is raised when a check cannot be made."""

from __future__ import annotations


class CheckError(ValueError):
    """A case, mesh or field that cannot be judged; one line: what, the value, the remedy."""
