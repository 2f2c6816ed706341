"""Data classes whose repr is one short line, whatever arrays, tables and lists they hold."""

from __future__ import annotations

from dataclasses import field, fields, replace
from reprlib import Repr, recursive_repr
from typing import TYPE_CHECKING, Any

import numpy as np

__all__ = ["LONGEST_REPR", "ReadOnly", "dataclass", "field", "replace", "short_repr"]

LONGEST_REPR = 160
"""Letters of a repr: two lines of a terminal."""
FEW = 12
"""Numbers or items that a repr shows one by one."""


if TYPE_CHECKING:
    from dataclasses import dataclass
else:
    import dataclasses

    def dataclass(cls: type | None = None, /, **options: bool) -> Any:
        """As the standard one, with `short_repr` where the class has no repr of its own."""
        if cls is None:
            return lambda decorated: dataclass(decorated, **options)
        if "__repr__" not in vars(cls):
            cls.__repr__ = short_repr
        return dataclasses.dataclass(cls, **options)


class ReadOnly:
    """Base of records whose arrays are made read-only."""

    def __post_init__(self) -> None:
        for value in vars(self).values():
            if isinstance(value, np.ndarray):
                value.setflags(write=False)


class _Short(Repr):
    """Short repr: few values in full, large arrays by shape and range.

    Arrays of 1 to `FEW` elements are shown in full. Other arrays show their shape, and those of
    floats their range. Records show their own repr, or their name alone at the last level. Other
    objects show their kind, and their shape if they have one.
    """

    def __init__(self, levels: int) -> None:
        super().__init__()
        self.maxlevel, self.maxtuple, self.maxstring = levels, FEW, 40

    def repr_ndarray(self, x: Any, _: int) -> str:
        if 0 < x.size <= FEW:
            return " ".join(np.array2string(x, separator=", ").split())
        ends = f": {x.min():g} to {x.max():g}" if x.size and x.dtype.kind == "f" else ""
        return f"<{'x'.join(map(str, x.shape))}{ends}>"

    def repr_float(self, x: float, level: int) -> str:
        return repr(x) if level > 1 else f"{x:.4g}"

    def repr_instance(self, x: Any, level: int) -> str:
        kind = getattr(x, "__qualname__", type(x).__name__)  # functions go by their own name
        if hasattr(x, "__dataclass_fields__"):
            return repr(x) if level > 1 else f"{kind}(...)"
        if isinstance(x, np.generic | bool | complex | None):
            return repr(x.item() if isinstance(x, np.generic) else x)
        return f"<{'x'.join(map(str, x.shape))} {kind}>" if hasattr(x, "shape") else f"<{kind}>"


_WHOLE, _BRIEF = _Short(6), _Short(1)


@recursive_repr()  # "..." for a record that holds itself
def short_repr(record: Any) -> str:
    """Return ``Name(field=value, ...)`` in at most `LONGEST_REPR` letters.

    Where all is too much, records in it show their names, numbers four digits, and as many fields
    are shown as there is room for.
    """
    named = {each.name: getattr(record, each.name, "?") for each in fields(record) if each.repr}
    head = f"{type(record).__qualname__}("
    whole = [f"{name}={_WHOLE.repr(of)}" for name, of in named.items()]
    if len(text := f"{head}{', '.join(whole)})") <= LONGEST_REPR:
        return text
    shown = [f"{name}={_BRIEF.repr(of)}" for name, of in named.items()]
    while len(text := f"{head}{', '.join(shown)})") > LONGEST_REPR and len(shown) > 1:
        shown[-2:] = ["..."]
    return text
