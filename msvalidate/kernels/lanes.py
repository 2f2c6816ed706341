"""Several numbers side by side as one value of compiled code: what one machine instruction takes.

The loops of `stencil` say by hand what is computed together, for compilers see it only in loops
whose arrays cannot overlap. `load` and `store` move `WIDTH` neighbours of a flat array; `+`, `-`
and `*` are between values, or between a value and a number, and may be fused to one rounding.
Nothing else may be assumed of the numbers: a NaN stays one. LLVM cuts a value to what the machine
has.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from llvmlite import ir
from numba.core import cgutils, types
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import intrinsic, lower_builtin, models, register_model

from msvalidate.kernels.values import Builder, Code, Context, Instruction, Lane, Signature, Type

WIDTH = 4
"""Numbers in a value: 256 bits, a register of AVX2 and half of one of AVX-512."""

_DOUBLE, _INDEX = ir.DoubleType(), ir.IntType(64)
_VECTOR, _BITS = ir.VectorType(_DOUBLE, WIDTH), ir.VectorType(_INDEX, WIDTH)
_FUSED = ("contract",)


class Lanes(types.Type):
    """Numba's type of such a value."""

    def __init__(self) -> None:
        super().__init__(name="Lanes")


LANES = Lanes()


def instruction(function: Callable[..., Instruction]) -> Callable[..., Any]:
    """Numba's intrinsic, of no type: calls have other arguments than the function that makes it."""
    return intrinsic(function)


def _model(manager: Any, kind: Type) -> Any:
    model: Any = models.PrimitiveModel
    return model(manager, kind, _VECTOR)


register_model(Lanes)(_model)


def _constant(value: float) -> Code:
    return ir.Constant(_VECTOR, [ir.Constant(_DOUBLE, value)] * WIDTH)


def _pointer(builder: Builder, start: Code, index: Code) -> Code:
    return builder.bitcast(builder.gep(start, [index]), _VECTOR.as_pointer())


@instruction
def start(_typing: Context, array: Type) -> Instruction:
    """Where an array's numbers begin: what inner functions take, since arrays count who holds them.

    The array must outlive it.
    """

    def code(
        context: Context, builder: Builder, signature: Signature, values: Sequence[Code]
    ) -> Code:
        return context.make_array(signature.args[0])(context, builder, values[0]).data

    pointer: Any = types.CPointer
    return pointer(array.dtype)(array), code


@instruction
def load(_typing: Context, begin: Type, index: Type) -> Instruction:
    """The `WIDTH` float64 from an int64 index behind a `start` on, unchecked."""

    def code(
        context: Context, builder: Builder, signature: Signature, values: Sequence[Code]
    ) -> Code:
        loaded = builder.load(_pointer(builder, *values))
        loaded.align = 8
        return loaded

    return LANES(begin, types.int64), code


@instruction
def store(_typing: Context, begin: Type, index: Type, value: Type) -> Instruction:
    """Put a value to an int64 index behind a `start`, unchecked."""

    def code(
        context: Context, builder: Builder, signature: Signature, values: Sequence[Code]
    ) -> Code:
        builder.store(values[2], _pointer(builder, *values[:2])).align = 8
        return context.get_dummy_value()

    return types.void(begin, types.int64, LANES), code


def _widened(builder: Builder, value: Code) -> Code:
    """A number as a value with it in every place; a value as it is."""
    if value.type == _VECTOR:
        return value
    one = builder.insert_element(ir.Constant(_VECTOR, ir.Undefined), value, _INDEX(0))
    places = ir.Constant(ir.VectorType(ir.IntType(32), WIDTH), [0] * WIDTH)
    return builder.shuffle_vector(one, ir.Constant(_VECTOR, ir.Undefined), places)


@instruction
def spread(_typing: Context, number: Type) -> Instruction:
    """A number in every place."""

    def code(
        context: Context, builder: Builder, signature: Signature, values: Sequence[Code]
    ) -> Code:
        return _widened(builder, values[0])

    return LANES(types.float64), code


@instruction
def one_on(_typing: Context, before: Type, value: Type) -> Instruction:
    """A value moved one place up: the last number of `before`, then all but its own last."""

    def code(
        context: Context, builder: Builder, signature: Signature, values: Sequence[Code]
    ) -> Code:
        places = [WIDTH - 1 + place for place in range(WIDTH)]
        moved = ir.Constant(ir.VectorType(ir.IntType(32), WIDTH), places)
        return builder.shuffle_vector(*values, moved)

    return LANES(LANES, LANES), code


@instruction
def where_positive(_typing: Context, condition: Type, value: Type, other: Type) -> Instruction:
    """`value` where `condition` is above 0, `other` elsewhere, NaN included."""

    def code(
        context: Context, builder: Builder, signature: Signature, values: Sequence[Code]
    ) -> Code:
        above = builder.fcmp_ordered(">", values[0], _constant(0.0))
        return builder.select(above, *values[1:])

    return LANES(LANES, LANES, LANES), code


@instruction
def total(_typing: Context, value: Type) -> Instruction:
    """Sum of the numbers of a value, first to last."""

    def code(
        context: Context, builder: Builder, signature: Signature, values: Sequence[Code]
    ) -> Code:
        added = builder.extract_element(values[0], _INDEX(0))
        for place in range(1, WIDTH):
            added = builder.fadd(added, builder.extract_element(values[0], _INDEX(place)))
        return added

    return types.float64(LANES), code


@instruction
def load_half(_typing: Context, begin: Type, index: Type) -> Instruction:
    """The two float64 from an int64 index behind a `start` on, then two zeros, unchecked."""

    def code(
        context: Context, builder: Builder, signature: Signature, values: Sequence[Code]
    ) -> Code:
        half = ir.VectorType(ir.DoubleType(), 2)
        loaded = builder.load(
            builder.bitcast(builder.gep(*values[:1], [values[1]]), half.as_pointer())
        )
        loaded.align = 8
        places = ir.Constant(ir.VectorType(ir.IntType(32), 4), [0, 1, 2, 3])
        return builder.shuffle_vector(loaded, ir.Constant(half, [0.0, 0.0]), places)

    return LANES(begin, types.int64), code


def picked(*places: int) -> Callable[[Lane, Lane], Lane]:
    """Function of two values: the numbers at such places, the second's counted on from 4."""

    @instruction
    def chosen(_typing: Context, a: Type, b: Type) -> Instruction:
        def code(
            context: Context, builder: Builder, signature: Signature, values: Sequence[Code]
        ) -> Code:
            kind = ir.VectorType(ir.IntType(32), len(places))
            return builder.shuffle_vector(*values, ir.Constant(kind, places))

        return LANES(a, b), code

    return chosen


@instruction
def root_and_quotient(_typing: Context, value: Type, square: Type) -> Instruction:
    """√square and value/√square.

    Processors divide and take roots in a unit of its own, beside what they load, add and multiply:
    loops that do much else between wait for it little. To make 1/√square of multiplications alone,
    from a guess by bits, took longer in both sweeps.
    """

    def code(
        context: Context, builder: Builder, signature: Signature, values: Sequence[Code]
    ) -> Code:
        find: Any = cgutils.get_or_insert_function
        kind = ir.FunctionType(_VECTOR, [_VECTOR])
        length = builder.call(find(builder.module, kind, f"llvm.sqrt.v{WIDTH}f64"), [values[1]])
        both = length, builder.fdiv(values[0], length)
        return context.make_tuple(builder, signature.return_type, both)

    pair: Any = types.UniTuple
    return pair(LANES, 2)(LANES, LANES), code


def _combining(sign: Callable[..., object], name: str) -> None:
    """Teach Numba `sign` of two values, or of a value and a float64."""

    def generic(_self: object, args: tuple[Type, ...], _keywords: object) -> Signature | None:
        made: Any = signature
        return made(LANES, *args) if set(args) in ({LANES}, {LANES, types.float64}) else None

    def code(
        context: Context, builder: Builder, signature: Signature, values: Sequence[Code]
    ) -> Code:
        return getattr(builder, name)(*map(partial(_widened, builder), values), flags=_FUSED)

    lower: Any = lower_builtin
    learn: Any = infer_global
    learn(sign)(type(f"Lanes_{name}", (AbstractTemplate,), {"generic": generic}))
    for kinds in ((LANES, LANES), (LANES, types.float64), (types.float64, LANES)):
        lower(sign, *kinds)(code)


_combining(operator.add, "fadd")
_combining(operator.sub, "fsub")
_combining(operator.mul, "fmul")
