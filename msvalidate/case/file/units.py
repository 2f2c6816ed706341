"""Names of units, and what each is in SI units."""

import math
import re
from collections.abc import Mapping

LENGTH = {
    "m": 1.0,
    "km": 1e3,
    "cm": 1e-2,
    "mm": 1e-3,
    "um": 1e-6,
    "µm": 1e-6,
    "nm": 1e-9,
    "in": 0.0254,
    "ft": 0.3048,
}
PRESSURE = {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9}
DENSITY = {"kg/m3": 1.0, "kg/m³": 1.0, "g/cm3": 1e3}
TIME = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6}
STIFFNESS = {"N/m": 1.0, "N/mm": 1e3, "kN/m": 1e3}
FORCE = {"N": 1.0, "kN": 1e3}
_KEYS = (
    ("E traction pressure", PRESSURE),
    ("x y z at centre radius box polygon cell thickness value point points depth spacing", LENGTH),
    ("density", DENSITY),
    ("force", FORCE),
    ("constants", STIFFNESS),
)
UNITS = {key: units for keys, units in _KEYS for key in keys.split()}
"""Key of a quantity in a case file -> its units."""
NUMBER = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(\S*)\s*")
READABLE = {"mm": {"Pa": ("MPa", 1e6), "J": ("mJ", 1e-3)}}
"""Unit of length of a case -> SI unit -> unit in which a reader of that case expects a quantity."""


def read_quantity(text: str, units: Mapping[str, float]) -> float | None:
    """Number with a unit, in SI units; None for any other text.

    Parameters
    ----------
    text
        Number, a space or none, and a key of `units`.
    units
        Name of each unit -> its size in SI units; "" for a number alone.

    Examples
    --------
    >>> read_quantity("70 GPa", PRESSURE), read_quantity("70 GPa", LENGTH)
    (70000000000.0, None)
    """
    match = NUMBER.fullmatch(text)
    return float(match[1]) * units[match[2]] if match and match[2] in units else None


def user_unit(unit: str, length: str) -> tuple[str, float]:
    """Unit in which a quantity is shown, and its size in SI units.

    Parameters
    ----------
    unit
        SI unit of the quantity: "m", "Pa", "N", "J".
    length
        Unit of length of the case, a key of `LENGTH`.

    Examples
    --------
    >>> user_unit("m", "mm"), user_unit("Pa", "mm"), user_unit("N", "mm")
    (('mm', 0.001), ('MPa', 1000000.0), ('N', 1.0))
    """
    if unit == "m":
        return length, LENGTH[length]
    return READABLE.get(length, {}).get(unit, (unit, 1.0))


def quantity_text(value: float, unit: str, length: str) -> str:
    """Quantity with four digits in the units of a case; empty if it is not finite.

    Parameters
    ----------
    value
        Size in the SI unit `unit`.
    length
        As for `user_unit`.

    Examples
    --------
    >>> quantity_text(7.352e-05, "m", "mm"), quantity_text(5.82e6, "Pa", "mm")
    ('0.07352 mm', '5.82 MPa')
    """
    from msvalidate_check.text import number_text

    if not math.isfinite(value):
        return ""
    name, size = user_unit(unit, length)
    return f"{number_text(value / size)} {name}".strip()
