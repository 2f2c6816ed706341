"""How the package compiles."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from numba import njit


def compiled(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile at the first call; keep the result on disk where there is a place for it."""
    try:
        return njit(error_model="numpy", cache=True)(function)
    except RuntimeError:  # neither the package's folder nor the user's home can be written
        return njit(error_model="numpy")(function)
