"""Several numbers side by side as one value of compiled code: what one machine instruction takes.

The loops of `stencil` say by hand what is computed together, for compilers see it only in loops
whose arrays cannot overlap. `load` and `store` move `WIDTH` neighbours of a flat array; `+`, `-`,
`*` and `/` are between values, or between a value and a number, and may be fused to one rounding.
Nothing else may be assumed of the numbers: a NaN stays one. LLVM cuts a value to what the machine
has.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Sequence
from functools import partial, wraps
from typing import Any

from llvmlite import ir
from numba.core import cgutils, types
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import intrinsic, lower_builtin, models, register_model

from msvalidate.springs.kernels.values import (
    Builder,
    Code,
    Context,
    Instruction,
    Lane,
    Signature,
    Type,
)

WIDTH = 4
"""Numbers in a value: 256 bits, a register of AVX2 and half of one of AVX-512."""

_DOUBLE, _INDEX = ir.DoubleType(), ir.IntType(64)
_VECTOR, _BITS = ir.VectorType(_DOUBLE, WIDTH), ir.VectorType(_INDEX, WIDTH)
_FUSED = ("contract",)
UNDEFINED = ir.Constant(_VECTOR, ir.Undefined)
ZEROS = ir.Constant(_VECTOR, [ir.Constant(_DOUBLE, 0.0)] * WIDTH)


class Lanes(types.Type):
    """Numba's type of such a value."""

    def __init__(self) -> None:
        super().__init__(name="Lanes")


LANES = Lanes()


def instruction(function: Callable[..., Instruction]) -> Callable[..., Any]:
    """Numba's intrinsic, of no type: calls have other arguments than the function that makes it."""
    return intrinsic(function)


def operation(kind: Type, *taken: Type) -> Callable[[Callable[..., Code]], Callable[..., Any]]:
    """The same of fixed types, from a function that writes its code from a builder and values.

    It gives a `kind` from values of the types `taken`, None for one that is taken as it comes.
    """

    def made(write: Callable[..., Code]) -> Callable[..., Any]:
        @wraps(write)
        def typed(_typing: Context, *given: Type) -> Instruction:
            def code(
                context: Context, builder: Builder, _signature: Signature, values: Sequence[Code]
            ) -> Code:
                written = write(builder, *values)
                return context.get_dummy_value() if written is None else written

            return kind(*(a or b for a, b in zip(taken, given, strict=True))), code

        return instruction(typed)

    return made


def _model(manager: Any, kind: Type) -> Any:
    model: Any = models.PrimitiveModel
    return model(manager, kind, _VECTOR)


register_model(Lanes)(_model)


def _pointer(builder: Builder, start: Code, index: Code) -> Code:
    return builder.bitcast(builder.gep(start, [index]), _VECTOR.as_pointer())


def loaded(builder: Builder, pointer: Code) -> Code:
    """Load the value at a pointer, aligned as a float64."""
    value = builder.load(pointer)
    value.align = 8
    return value


@instruction
def start(_typing: Context, array: Type) -> Instruction:
    """Pointer to the numbers of an array, for inner functions.

    Passing arrays would count references.

    The array must outlive it.
    """

    def code(
        context: Context, builder: Builder, signature: Signature, values: Sequence[Code]
    ) -> Code:
        return context.make_array(signature.args[0])(context, builder, values[0]).data

    pointer: Any = types.CPointer
    return pointer(array.dtype)(array), code


@operation(LANES, None, types.int64)
def load(builder: Builder, begin: Code, index: Code) -> Code:
    """The `WIDTH` float64 from an int64 index behind a `start` on, unchecked."""
    return loaded(builder, _pointer(builder, begin, index))


@operation(types.void, None, types.int64, LANES)
def store(builder: Builder, begin: Code, index: Code, value: Code) -> None:
    """Put a value to an int64 index behind a `start`, unchecked."""
    builder.store(value, _pointer(builder, begin, index)).align = 8


def _widened(builder: Builder, value: Code) -> Code:
    """A number as a value with it in every place; a value as it is."""
    if value.type == _VECTOR:
        return value
    one = builder.insert_element(UNDEFINED, value, _INDEX(0))
    return shuffled(builder, one, UNDEFINED, [0] * WIDTH)


def shuffled(builder: Builder, a: Code, b: Code, places: Sequence[int]) -> Code:
    """The numbers of two values at such places, the second's counted on from the first's."""
    kind = ir.VectorType(ir.IntType(32), len(places))
    return builder.shuffle_vector(a, b, ir.Constant(kind, list(places)))


@operation(LANES, types.float64)
def spread(builder: Builder, number: Code) -> Code:
    """A number in every place."""
    return _widened(builder, number)


def picked(*places: int) -> Callable[[Lane, Lane], Lane]:
    """Function of two values: the numbers at such places, the second's counted on from 4."""
    return operation(LANES, None, None)(lambda builder, a, b: shuffled(builder, a, b, places))


one_on = picked(*range(WIDTH - 1, 2 * WIDTH - 1))
"""A value moved one place up: the last number of one before, then all but its own last."""


@operation(LANES, LANES, LANES, LANES)
def where_positive(builder: Builder, condition: Code, value: Code, other: Code) -> Code:
    """`value` where `condition` is above 0, `other` elsewhere, NaN included."""
    return builder.select(builder.fcmp_ordered(">", condition, ZEROS), value, other)


@operation(types.boolean, LANES)
def any_positive(builder: Builder, value: Code) -> Code:
    """Compute whether any number is above 0; NaN is not."""
    above = builder.fcmp_ordered(">", value, ZEROS)
    bits = ir.IntType(WIDTH)
    return builder.icmp_unsigned("!=", builder.bitcast(above, bits), bits(0))


@operation(types.float64, LANES)
def total(builder: Builder, value: Code) -> Code:
    """Sum of the numbers of a value, first to last."""
    added = builder.extract_element(value, _INDEX(0))
    for place in range(1, WIDTH):
        added = builder.fadd(added, builder.extract_element(value, _INDEX(place)))
    return added


@operation(LANES, None, types.int64)
def load_half(builder: Builder, begin: Code, index: Code) -> Code:
    """The two float64 from an int64 index behind a `start` on, then two zeros, unchecked."""
    half = ir.VectorType(_DOUBLE, 2)
    pointer = builder.bitcast(builder.gep(begin, [index]), half.as_pointer())
    return shuffled(builder, loaded(builder, pointer), ir.Constant(half, [0.0, 0.0]), range(4))


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
_combining(operator.truediv, "fdiv")
