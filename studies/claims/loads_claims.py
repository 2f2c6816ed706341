"""Sentences about loaded bodies: pressure, shear and bending of section 6, and of section 8."""

from __future__ import annotations

from typing import Any

import numpy as np

from msvalidate.output.results import Results
from msvalidate.problem import Array

from .record import (
    AT_LEAST,
    AT_MOST,
    HOLDS,
    ONLY_IF,
    Check,
    Claim,
    Reading,
    column,
    numbers,
    rows,
    unjudged,
)

STATEMENTS = "displacement/statements"
SWELLS, MEAN = "swells along y", "mean change of height"
LOADED = "change of height at x = 0, loaded"
HALF_WAVE, WHOLE_WAVE = "sine-like: half a wave", "sine-like: a whole wave, 1 - cos"
LIKE = 0.05


def swelling(results: Results, figure: int, loaded: bool) -> float:
    """Least change of height (m) in springs of a figure, with or without the loaded nodes."""
    table = rows(results, STATEMENTS, figure=figure, statement=SWELLS)
    return float(
        numbers(table if loaded else table[table["measured"] != LOADED], "in_springs").min()
    )


def swelling_4(results: Results) -> float:
    """Least change of height (m) of Figure 4, everywhere."""
    return swelling(results, 4, loaded=True)


def swelling_4_inside(results: Results) -> float:
    """The same away from the loaded nodes."""
    return swelling(results, 4, loaded=False)


def swelling_5(results: Results) -> float:
    """Least change of height (m) of Figure 5, everywhere."""
    return swelling(results, 5, loaded=True)


def swelling_5_inside(results: Results) -> float:
    """The same away from the loaded nodes."""
    return swelling(results, 5, loaded=False)


def in_springs(results: Results, figure: int, **where: Any) -> Array:
    """What springs show (n,) in a figure, of both pairs of constants."""
    return column(results, STATEMENTS, "in_springs", figure=figure, **where)


def swelling_by_ratio(results: Results) -> float:
    """Mean swelling of Figure 4 with the larger ratio (k2 = 2 k1) over that with 1/3."""
    table = rows(results, STATEMENTS, figure=4, measured=MEAN)
    ratio = numbers(table, "k2") / numbers(table, "k1")
    swell = numbers(table, "in_springs")
    return float(swell[ratio.argmax()] / swell[ratio.argmin()])


def sheared_edges(results: Results) -> float:
    """Least shortening of the upper edge and lengthening of the lower (m) in Figure 6."""
    upper = in_springs(results, 6, statement="upper edge is compressed")
    lower = in_springs(results, 6, statement="bottom edge elongates")
    return float(min((-upper).min(), lower.min()))


def half_wave_misfit(results: Results) -> float:
    """Largest misfit of half a sine to Figure 7's lower side, over its height."""
    return float(np.max(in_springs(results, 7, statement=HALF_WAVE)))


def whole_wave_misfit(results: Results) -> float:
    """The same of a whole wave, 1 - cos."""
    return float(np.max(in_springs(results, 7, statement=WHOLE_WAVE)))


def swells(number: int, figure: int, everywhere: Check, inside: Check) -> Claim:
    """The sentence that a pressed block swells, of a figure."""
    side = "one side" if figure == 4 else "both sides"
    return Claim(
        number, f"6.1, Figure {figure}",
        f"Pressed from {side}, the block shrinks along x and swells along y.",
        ONLY_IF, "Poisson's ratio widens the block; under the load its nodes are drawn together",
        everywhere, "the loaded nodes are left out", inside,
    )  # fmt: skip


def height(words: str, read: Reading, because: str) -> Check:
    """A check that heights grow."""
    measure = f"least change of height along the block, {words}"
    return Check("displacement", "statements", measure, "m", read, AT_LEAST, 0, because)


CLAIMS = (
    Claim(
        37, "6.1, first paragraph", "The Poisson effect makes the pressed block swell.",
        HOLDS, "swelling is the ratio times the shrinking, and the ratios are 1/3 and 2/3",
        Check(
            "displacement", "statements", "swelling at k2 = 2 k1 over that at k2 = k1/2", "1",
            swelling_by_ratio, AT_LEAST, 1.2, "another cause would not follow the ratio, which "
            "doubles; a fifth is beyond what load and clamp change",
        ),
    ),
    swells(
        33, 4,
        height("Figure 4, everywhere", swelling_4, "swelling is a growth"),
        height("Figure 4, not at the load", swelling_4_inside, "swelling is a growth"),
    ),
    swells(
        34, 5,
        height("Figure 5, everywhere", swelling_5, "swelling is a growth"),
        height("Figure 5, not at the load", swelling_5_inside, "swelling is a growth"),
    ),
    Claim(
        35, "6.2, Figure 6", "Sheared, the upper edge is compressed and the lower elongates.",
        HOLDS, "the load across the free end bends the block as well",
        Check(
            "displacement", "statements", "least of shortening above and lengthening below", "m",
            sheared_edges, AT_LEAST, 0, "one shortens and the other lengthens",
        ),
    ),
    Claim(
        36, "6.3, Figure 7", "Bent at three points, the bar takes a sine-like curve.",
        ONLY_IF, "held ends do not turn, as those of half a sine would",
        Check(
            "displacement", "statements", "misfit of half a sine over the line's height", "1",
            half_wave_misfit, AT_MOST, LIKE, "a twentieth is what a reader of a figure sees",
        ),
        "a whole wave, 1 - cos, is meant",
        Check(
            "displacement", "statements", "misfit of a whole wave over the line's height", "1",
            whole_wave_misfit, AT_MOST, LIKE, "a twentieth is what a reader of a figure sees",
        ),
    ),
    unjudged(
        53, "8, first paragraph", "Springs predict deformation easily even beyond 5 % of strain.",
        "work on large strain will judge it: load cases here are at 1 % beside linear elements",
    ),
    unjudged(
        62, "8, last paragraph", "Contact, fracture and other physics should be examined.",
        "work on contact and fracture will judge it: no study has either",
    ),
)  # fmt: skip
