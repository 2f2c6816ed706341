"""Compilation settings of the package."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

from numba import njit

from msvalidate.springs.kernels.cache import KernelCache

Kernel = TypeVar("Kernel", bound=Callable[..., object])
"""A function, by what it takes and gives."""


def compiled(*, fused: bool = False, inner: bool = False) -> Callable[[Kernel], Kernel]:
    """Compile at the first call; keep the result on disk where there is a place for it (`cache`).

    `fused` lets a product and a sum be one operation with one rounding. No other liberty is ever
    given: a NaN must come out as one. An `inner` function is called by compiled ones alone, and
    becomes part of them.
    """
    options: dict[str, Any] = {"error_model": "numpy", "nogil": True, "no_cfunc_wrapper": True}
    if fused:
        options["fastmath"] = {"contract"}
    if inner:
        options |= {"forceinline": True, "no_cpython_wrapper": True}

    def compile_function(function: Kernel) -> Kernel:
        machine = njit(**options)(function)
        machine._cache = KernelCache(function, options)
        return cast(Kernel, machine)

    return compile_function
