"""Sentences about loaded bodies: pressure, shear and bending of section 6, and of section 8."""

from __future__ import annotations

from functools import partial

import numpy as np
import pandas as pd

from msvalidate.output.results import Results
from msvalidate.problem import Array

from .record import (
    AT_LEAST,
    AT_MOST,
    HOLDS,
    ONLY_IF,
    Check,
    Claim,
    numbers,
    rows,
    unjudged,
)

STATEMENTS = "displacement/statements"
SWELLS, SHRINKS, MEAN = "swells along y", "shrinks along x", "mean change of height"
LOADED, FREE = "change of height at x = 0, loaded", "change of width at y = 1 m, free"
HALF_WAVE, WHOLE_WAVE = "sine-like: half a wave", "sine-like: a whole wave, 1 - cos"
LIKE = 0.05
"""Misfit of a line to a curve, over its height, that a reader of a figure just sees."""


def in_body(table: pd.DataFrame) -> Array:
    """What springs show (2n,), and after it elasticity of the same body."""
    return np.concatenate([numbers(table, "in_springs"), numbers(table, "in_homogenised")])


def said(results: Results, figure: int, statement: str) -> Array:
    """What a statement measures (n,) in springs and in elasticity of the same body."""
    return in_body(rows(results, STATEMENTS, figure=figure, statement=statement))


def deforms_as_said(results: Results, figure: int, leave_out: tuple[str, ...]) -> float:
    """Least swelling along y or shrinking along x (m) of a figure, where it is not left out."""
    table = rows(results, STATEMENTS, figure=figure)
    table = table[~table["measured"].isin(leave_out)]
    swell, shrink = (in_body(table[table["statement"] == words]) for words in (SWELLS, SHRINKS))
    return float(min(swell.min(), (-shrink).min()))


def swelling_by_ratio(results: Results) -> float:
    """Mean swelling of Figure 4 with the larger ratio (k2 = 2 k1) over that with 1/3."""
    table = rows(results, STATEMENTS, figure=4, measured=MEAN)
    ratio = numbers(table, "k2") / numbers(table, "k1")
    swell = numbers(table, "in_springs")
    return float(swell[ratio.argmax()] / swell[ratio.argmin()])


def sheared_edges(results: Results) -> float:
    """Least shortening of the upper edge and lengthening of the lower (m) in Figure 6."""
    upper = said(results, 6, "upper edge is compressed")
    lower = said(results, 6, "bottom edge elongates")
    return float(min((-upper).min(), lower.min()))


def half_wave_misfit(results: Results) -> float:
    """Largest misfit of half a sine to Figure 7's lower side, over its height."""
    return float(said(results, 7, HALF_WAVE).max())


def whole_wave_misfit(results: Results) -> float:
    """The same of a whole wave, 1 - cos."""
    return float(said(results, 7, WHOLE_WAVE).max())


def pressed(
    number: int, figure: int, pressed_from: str, condition: str, leave_out: tuple[str, ...]
) -> Claim:
    """The sentence that a pressed block shrinks and swells, of a figure."""

    def check(words: str, leave_out: tuple[str, ...]) -> Check:
        return Check(
            "displacement", "statements", f"least swelling or shrinking, {words}", "m",
            partial(deforms_as_said, figure=figure, leave_out=leave_out), AT_LEAST, 0,
            "heights grow and widths fall; springs and elasticity of the same body",
        )  # fmt: skip

    return Claim(
        number, f"6.1, Figure {figure}",
        f"Pressed from {pressed_from}, the block shrinks along x and swells along y.",
        ONLY_IF, "the block widens by Poisson's ratio, but a load on two nodes draws them together",
        check("everywhere", ()),
        f"{condition} left out",
        check(f"{condition} left out", leave_out),
    )  # fmt: skip


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
    pressed(33, 4, "one side", "the loaded column is", (LOADED,)),
    pressed(34, 5, "both sides", "the loaded column and free sides are", (LOADED, FREE)),
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
