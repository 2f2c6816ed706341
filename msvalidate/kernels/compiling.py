"""How the package compiles."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from numba import njit


def compiled(
    function: Callable[..., Any], *, fused: bool = False, inner: bool = False
) -> Callable[..., Any]:
    """Compile at the first call; keep the result on disk where there is a place for it.

    What is kept is as old as the function's own file: after a change in a function that those of
    other files call (`segments`, `turning`), remove `kernels/__pycache__`, or these still run the
    old one.

    `fused` lets a product and a sum be one operation with one rounding. No other liberty is ever
    given: a NaN must come out as one. An `inner` function is called by compiled ones alone, and
    becomes part of them.
    """
    options: Any = {"error_model": "numpy", "nogil": True, "no_cfunc_wrapper": True}
    if fused:
        options["fastmath"] = {"contract"}
    if inner:
        options |= {"forceinline": True, "no_cpython_wrapper": True}
    try:
        machine: Callable[..., Any] = njit(cache=True, **options)(function)
    except RuntimeError:  # neither the package's folder nor the user's home can be written
        machine = njit(**options)(function)
    return machine
