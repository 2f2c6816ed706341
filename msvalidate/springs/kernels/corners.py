"""Corners of `WIDTH` cells side by side, as values of compiled code.

Cells of k corners are a tuple of k - 1 vectors, their corners seen from their first, each a tuple
of d `Lanes`. Seen from the first corner, a cell far away has the digits of one near. `axes` and
`corners` are tuples whose lengths, d and k, are constants of the compiled form; every loop below is
unrolled while the code is generated. A corner of all cells is read as it lies and turned by
shuffles, which cost less than the machine's own gathers. Of fewer than `WIDTH` cells, `count`, the
last stands in the places left, without a stiffness.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from llvmlite import ir
from numba.core import cgutils, types
from numba.core.errors import TypingError

from msvalidate.problem import Array
from msvalidate.springs.kernels.lanes import (
    LANES,
    UNDEFINED,
    WIDTH,
    instruction,
    loaded,
    shuffled,
)
from msvalidate.springs.kernels.values import (
    Builder,
    Code,
    Context,
    Instruction,
    Lane,
    Signature,
    Type,
)

Ends = tuple[Code, Code | None]
"""Pointers to the first two components of a corner, and to its third in space."""

_DOUBLE, _INDEX = ir.DoubleType(), ir.IntType(64)


def _contiguous(*arrays: Type) -> None:
    if any(array.layout != "C" for array in arrays):
        raise TypingError("corners: arrays must be C-contiguous")


def _lanes(builder: Builder, first: Code, count: Code) -> list[Code]:
    """Numbers of the cells side by side, from the first on."""
    last = builder.sub(count, _INDEX(1))
    steps = [_INDEX(0)]
    for lane in map(_INDEX, range(1, WIDTH)):
        steps.append(builder.select(builder.icmp_signed("<", lane, last), lane, last))
    return [builder.add(first, step) for step in steps]


def _points(
    context: Context,
    builder: Builder,
    arrays: tuple[Type, Type],
    given: Sequence[Code],
    sizes: tuple[int, int],
) -> Callable[[int], list[Ends]]:
    """Function (corner) -> pointers to it in each cell: to its first two components and its third.

    `arrays` are the types of values and cells, `given` their values, first cell and count.
    """
    d, k = sizes
    values, cells = (
        context.make_array(kind)(context, builder, array).data
        for kind, array in zip(arrays, given[:2], strict=True)
    )
    widened = builder.sext if arrays[1].dtype.signed else builder.zext
    rows = [builder.mul(lane, _INDEX(k)) for lane in _lanes(builder, *given[2:])]
    pair = ir.VectorType(_DOUBLE, 2).as_pointer()

    def at(row: Code, corner: int) -> Ends:
        index = builder.load(builder.gep(cells, [builder.add(row, _INDEX(corner))]))
        whole = index if index.type == _INDEX else widened(index, _INDEX)
        first = builder.gep(values, [whole])
        return builder.bitcast(first, pair), builder.gep(first, [_INDEX(2)]) if d == 3 else None

    return lambda corner: [at(row, corner) for row in rows]


def _read(builder: Builder, pointers: list[Ends]) -> list[Code]:
    """A corner of all cells as it lies: [x0 y0 x2 y2], [x1 y1 x3 y3], in space [z0 z1 z2 z3]."""
    pairs = [loaded(builder, pair) for pair, _ in pointers]
    values = [shuffled(builder, pairs[i], pairs[i + 2], [0, 1, 2, 3]) for i in (0, 1)]
    if pointers[0][1] is None:
        return values
    third = UNDEFINED
    for lane, (_, pointer) in enumerate(pointers):
        third = builder.insert_element(third, loaded(builder, pointer), _INDEX(lane))
    return [*values, third]


def _turned(builder: Builder, read: list[Code]) -> list[Code]:
    """Results of `_read`, or differences of them, as a value per axis.

    The inverse is `_returned`.
    """
    places = [[axis, 4 + axis, 2 + axis, 6 + axis] for axis in (0, 1)]
    return [shuffled(builder, read[0], read[1], place) for place in places] + read[2:]


def _returned(builder: Builder, values: list[Code]) -> list[tuple[Code, Code | None]]:
    """Values per axis as (first two components, third) of each cell."""
    places = [0, 4, 2, 6], [1, 5, 3, 7]
    both = [shuffled(builder, values[0], values[1], order) for order in places]
    out = []
    for lane in range(WIDTH):
        half = [lane // 2 * 2, lane // 2 * 2 + 1]
        pair = shuffled(builder, both[lane % 2], UNDEFINED, half)
        third = builder.extract_element(values[2], _INDEX(lane)) if values[2:] else None
        out.append((pair, third))
    return out


@instruction
def gather(
    _typing: Context, axes: Type, corners: Type, values: Type, cells: Type, first: Type, count: Type
) -> Instruction:
    """Corners of cells (c, k) among values (n, d): of `count` of them from `first` on."""
    _contiguous(values, cells)
    d, k = len(axes), len(corners)
    tuple_of: Any = types.UniTuple
    body = tuple_of(tuple_of(LANES, d), k - 1)

    def code(
        context: Context, builder: Builder, signature: Signature, given: Sequence[Code]
    ) -> Code:
        points = _points(context, builder, (values, cells), given[2:], (d, k))
        first_corner, *others = [_read(builder, points(corner)) for corner in range(k)]
        vectors = []
        for corner in others:
            apart = [builder.fsub(*pair) for pair in zip(corner, first_corner, strict=True)]
            vectors.append(context.make_tuple(builder, body.dtype, _turned(builder, apart)))
        return context.make_tuple(builder, body, vectors)

    return body(axes, corners, values, cells, types.int64, types.int64), code


@instruction
def pull(
    _typing: Context,
    axes: Type,
    corners: Type,
    out: Type,
    cells: Type,
    first: Type,
    count: Type,
    force: Type,
    slope: Type,
) -> Instruction:
    """Take force · slope from `out` (n, d) at all corners but the first, which gets their sum.

    One cell after the other, for they may share a corner.
    """
    _contiguous(out, cells)
    d, k = len(axes), len(corners)

    def code(
        context: Context, builder: Builder, signature: Signature, given: Sequence[Code]
    ) -> Code:
        points = _points(context, builder, (out, cells), given[2:6], (d, k))
        unpacked: Any = cgutils.unpack_tuple
        slopes = [x for corner in unpacked(builder, given[7]) for x in unpacked(builder, corner)]
        back = [builder.fmul(given[6], value) for value in slopes]
        sums = back[:d]
        for i in range(d, len(back)):
            sums[i % d] = builder.fadd(sums[i % d], back[i])
        for corner in range(k):
            change = back[(corner - 1) * d : corner * d] if corner else sums
            combine = builder.fsub if corner else builder.fadd
            steps = zip(points(corner), _returned(builder, change), strict=True)
            for (pair, third), (by_pair, by_third) in steps:
                builder.store(combine(loaded(builder, pair), by_pair), pair).align = 8
                if third is not None:
                    builder.store(combine(loaded(builder, third), by_third), third).align = 8
        return context.get_dummy_value()

    return types.void(axes, corners, out, cells, types.int64, types.int64, force, slope), code


def _reader(beyond: bool) -> Callable[[Array, int, int], Lane]:
    @instruction
    def some(_typing: Context, values: Type, first: Type, count: Type) -> Instruction:
        _contiguous(values)

        def code(
            context: Context, builder: Builder, signature: Signature, given: Sequence[Code]
        ) -> Code:
            data = context.make_array(values)(context, builder, given[0]).data
            lanes, read = _lanes(builder, *given[1:]), UNDEFINED
            for lane, number in enumerate(lanes):
                value = loaded(builder, builder.gep(data, [number]))
                if not beyond:
                    inside = builder.icmp_signed("<", _INDEX(lane), given[2])
                    value = builder.select(inside, value, ir.Constant(_DOUBLE, 0.0))
                read = builder.insert_element(read, value, _INDEX(lane))
            return read

        return LANES(values, types.int64, types.int64), code

    return some


numbers = _reader(beyond=True)
"""Numbers (c,) of cells: of `count` from `first` on, the last standing in the places left."""

numbers_or_zero = _reader(beyond=False)
"""The same with 0 in the places left."""
