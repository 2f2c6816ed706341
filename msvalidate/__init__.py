"""Validation of spring networks against elasticity theory and independent finite elements.

What most users need is offered here by name, ``from msvalidate import Box, equilibrium``; the
packages hold the rest. A name is imported when it is first used, as ``python -m msvalidate --help``
must not wait for numpy.
"""

from difflib import get_close_matches
from importlib import import_module

__version__ = "0.2.0"

with open(f"{__file__}i", encoding="utf-8") as stub:  # noqa: PTH123  pathlib takes milliseconds
    _HOMES = {line.split()[-1]: line.split()[1] for line in stub if line.startswith("from ")}
"""Name -> the module that defines it."""
_SYNONYMS = {"fem": "reference"}
"""Name that users try -> name that is offered."""

__all__ = ["__version__", *sorted(_HOMES)]  # noqa: PLE0604


def __getattr__(name: str) -> object:
    """A name of `__all__`, imported now (PEP 562)."""
    if name in _HOMES:
        globals()[name] = getattr(import_module(_HOMES[name]), name)
        return globals()[name]
    near = get_close_matches(_SYNONYMS.get(name, name), __all__, 1, 0.5)
    hint = f"; did you mean {near[0]!r}?" if near else ""
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}{hint}")


def __dir__() -> list[str]:
    return list(__all__)
