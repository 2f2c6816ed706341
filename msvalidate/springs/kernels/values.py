"""Names for the types of what compiled code takes and gives, and of what generates it.

Numba finds types by itself, from the values of a call, and goes by no annotation: these are for
readers, and for whatever checks types before anything runs.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

Number_co = TypeVar("Number_co", int, float, covariant=True)

Complex = NDArray[np.complex128]
"""Points and vectors of the plane, x + iy."""
Small = NDArray[np.uint32]
"""Places in tables, in half of the bytes of an `Index`."""


class Lane(Protocol):
    """`WIDTH` float64 side by side: see `lanes`."""

    def __add__(self, other: Lane | float) -> Lane:
        """Place by place, as all that follow."""

    def __radd__(self, other: float) -> Lane: ...

    def __sub__(self, other: Lane | float) -> Lane: ...

    def __rsub__(self, other: float) -> Lane: ...

    def __mul__(self, other: Lane | float) -> Lane: ...

    def __rmul__(self, other: float) -> Lane: ...

    def __truediv__(self, other: Lane | float) -> Lane: ...


class Pointer(Protocol[Number_co]):
    """Pointer to the numbers of a flat array: see `lanes.start`.

    No index is checked.
    """

    def __getitem__(self, index: int) -> Number_co: ...


Axes = tuple[int, ...]
"""Tuple whose length d is a constant of the compiled form.

Its entries do not count.
"""
Corners = tuple[int, ...]
"""The same of the k corners of a cell."""
Vector = tuple[Lane, ...]
"""The d components of `WIDTH` vectors."""
Padded = tuple[Lane, Lane, Lane]
"""The same as three, of which in the plane the last is not used."""
Body = tuple[Vector, ...]
"""`WIDTH` cells side by side: their k - 1 corners after the first, or vectors there (`corners`)."""

Spring = tuple[float, float, float, float, float]
"""Kind of spring of a lattice: k, k·L0 and vector at rest.

The units are N/m, N and m; the vector is X, Y, Z.
"""
Done = tuple[int, float, bool]
"""Steps done, kinetic energy of the last, and whether it ended there because that fell."""

Type = Any
"""`numba.types.Type` of a value."""
Builder = Any
"""`llvmlite.ir.IRBuilder`: what writes machine code."""
Code = Any
"""`llvmlite.ir.Value`: a value of machine code."""
Context = Any
"""`numba.core.base.BaseContext`: what lays out the values of Numba's types."""
Signature = Any
"""`numba.core.typing.templates.Signature`: types of what a function takes and gives."""
Generator = Callable[[Context, Builder, Signature, Sequence[Code]], Code]
"""Writes the machine code of a call, from the values given."""
Instruction = tuple[Signature, Generator]
"""Result of an instruction's maker, from the types of its arguments."""
