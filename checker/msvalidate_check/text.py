"""Numbers and tables as text, for terminals, pages and documents alike."""

from __future__ import annotations

import math
from collections.abc import Sequence

FLOOR = 1e-4
"""Smallest part that is shown as a number: below 0.01 % digits carry no information."""
WIDTH = 100
"""Characters of a line on a terminal."""
MANY = 10.0
"""Part from which a percentage is shown as a factor."""


def number_text(value: float, digits: int = 4) -> str:
    """Number with significant digits; thousands as whole numbers in groups.

    Examples
    --------
    >>> number_text(0.33333), number_text(12112.0), number_text(6847.2, 3), number_text(7e10)
    ('0.3333', '12,112', '6,847', '7e+10')
    """
    return f"{value:,.0f}" if 1000 <= abs(value) < 1e6 else f"{value:.{digits}g}"


def percent(part: float, floor: float = FLOOR) -> str:
    """Percentage of a part with two digits; "< 0.01 %" below the floor.

    Parameters
    ----------
    part
        Number without unit, 0.05 for 5 %. "not known" if it is not finite.
    floor
        Size below which no digits are shown, such as the uncertainty of the part.

    Examples
    --------
    >>> percent(0.0204), percent(-0.127), percent(3e-9), percent(12.0)
    ('2 %', '-13 %', '< 0.01 %', '12 times')
    """
    if not math.isfinite(part):
        return "not known"
    size = abs(part)
    if size < floor:
        return f"< {100 * floor:.2g} %"
    if size >= MANY:
        return f"{number_text(part, 3)} times"
    return f"{100 * part:.2g} %" if size < 0.995 else f"{100 * part:.0f} %"


def duration(seconds: float) -> str:
    """Duration with two digits, in seconds, minutes or hours."""
    if seconds < 99.5:
        return f"{seconds:.2g} s"
    return f"{seconds / 60:.0f} min" if seconds < 5970 else f"{seconds / 3600:.2g} h"


def align_table(
    heads: Sequence[str], rows: Sequence[Sequence[str]], right: Sequence[bool] | None = None
) -> list[str]:
    """Lines of a table of texts, with aligned columns and two spaces between them.

    Parameters
    ----------
    heads, rows
        Heads of the columns, and rows with as many texts each.
    right
        Columns that are aligned at their right end; none by default.
    """
    sides = right or [False] * len(heads)
    widths = [max(map(len, column)) for column in zip(heads, *rows, strict=True)]
    lines = []
    for row in (heads, *rows):
        cells = zip(row, widths, sides, strict=True)
        texts = [text.rjust(width) if side else text.ljust(width) for text, width, side in cells]
        lines.append("  ".join(texts).rstrip())
    return lines
