"""Data classes whose repr is one short line, whatever arrays, tables and lists they hold."""

from __future__ import annotations

from dataclasses import field, fields, replace
from reprlib import recursive_repr
from typing import TYPE_CHECKING, Any

import numpy as np

__all__ = ["LONGEST_REPR", "dataclass", "field", "replace", "short_repr"]

LONGEST_REPR = 160
"""Letters of a repr: two lines of a terminal."""
FEW = 12
"""Numbers, items or keys that a repr shows one by one where there is room."""
_PLAIN = (str, bool, int, float, complex, type(None))


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


@recursive_repr()  # "..." for a record that holds itself
def short_repr(record: Any) -> str:
    """One line, ``Name(field=value, ...)``, of at most `LONGEST_REPR` letters.

    The standard one where it has room. Else fields that are None are left out, arrays and
    tables show their shape, lists their number of items, and records in it their names; as much as
    there is room for, from the first field on, is whole, and real numbers show their range.
    """
    named = {each.name: getattr(record, each.name, "?") for each in fields(record) if each.repr}
    whole = {name: f"{name}={_whole(value)}" for name, value in named.items()}
    head = f"{type(record).__qualname__}("
    if len(text := f"{head}{', '.join(whole.values())})") <= LONGEST_REPR:
        return text
    texts = {name: f"{name}={_brief(of)}" for name, of in named.items() if of is not None}
    for name, brief in texts.items():
        texts[name] = whole[name]
        if len(f"{head}{', '.join(texts.values())})") > LONGEST_REPR:
            texts[name] = brief
    shown = list(texts.values())
    while len(text := f"{head}{', '.join(shown)})") > LONGEST_REPR and len(shown) > 1:
        shown[-2:] = ["..."]
    return text


def _brief(value: Any) -> str:
    """A value in a few letters: the shape of an array, the length of a list, the name of a type."""
    kind = type(value).__name__
    if isinstance(value, _PLAIN):
        text = f"{value:.4g}" if isinstance(value, float) else _whole(value)
        return text if len(text) <= 40 else f"{text[:36]}...{text[:1]}"
    if hasattr(value, "__dataclass_fields__"):
        return f"{kind}(...)"
    if hasattr(value, "shape"):
        shape = "x".join(map(str, value.shape))
        return f"<{shape}>" if isinstance(value, np.ndarray) else f"<{shape} {kind}>"
    if hasattr(value, "__len__"):
        kinds = {type(each).__name__ for each in value} if isinstance(value, tuple | list) else ()
        if kinds == {"float"} and len(value) in {2, 3}:
            return f"({', '.join(map(_brief, value))})"
        return f"<{len(value)} {''.join(kinds) if len(kinds) == 1 else 'items'}>"
    return f"<{getattr(value, '__qualname__', kind)}>"  # functions go by their own name


def _whole(value: Any) -> str:
    """A value as `repr` has it; of long arrays the shape and range, of long lists the length."""
    if isinstance(value, np.ndarray) and value.size and value.dtype.kind in "biuf":
        if value.size <= FEW:
            return " ".join(np.array2string(value, separator=", ").split())
        ends = f"{value.min():g} to {value.max():g}"
        return f"{_brief(value)[:-1]}: {ends}>" if value.dtype.kind == "f" else _brief(value)
    if isinstance(value, dict) and len(value) <= FEW:
        return f"{{{', '.join(f'{_whole(key)}: {_whole(of)}' for key, of in value.items())}}}"
    if type(value) in (tuple, list) and len(value) <= FEW:
        first, last = ("(", ",)"[len(value) != 1 :]) if isinstance(value, tuple) else "[]"
        return f"{first}{', '.join(map(_whole, value))}{last}"
    if isinstance(value, (*_PLAIN, np.generic)) or hasattr(value, "__dataclass_fields__"):
        return repr(value.item() if isinstance(value, np.generic) else value)
    return _brief(value)
