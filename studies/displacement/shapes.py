"""Shapes: are the report's Figures 4 to 7 and its words about them right?

Question   Under pressure on one side (Fig. 4) or two (Fig. 5) "on the y-axis, material slightly
           swells, while on x-axis, it shrinks"; under shear (Fig. 6) "the upper edge is compressed,
           while the bottom edge elongates"; a bar held at both ends and loaded in the middle
           (Fig. 7) is "a sine-like curve". Is it so, of these springs and of an elastic body?
Candidate  6 x 6 particles, the bar 26 x 6, all springs of a kind alike, where Algorithm 1 rests:
           the report's own setting.
Reference  Finite elements, linear: the body with the lattice's homogenised tensor, and the target.
Expected   The signs hold on the mean, not on every line of particles. The bar is a clamped beam 5
           times as long as high, so a good part of its deflection is shear: no sine, but nearer to
           a whole wave 1 - cos, which has no slope at its ends, than to half a wave.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from typing import Any

import numpy as np
import pandas as pd

from msvalidate import kit
from msvalidate.springs.bodies.lattice_network import lattice_network

from . import load_cases, redrawn
from .claims import (
    CLAIMS,
    CURVES,
    FREE,
    LOADED,
    MISFIT,
    NAMED,
    SLIGHTLY,
    SOURCES,
    fitted,
    lower_row,
    rms,
)
from .elastic import Bodies
from .load_cases import CASES
from .measuring import Block, Measurement
from .models import MODELS, Model, homogenised

FINENESS = 5
SETTING: tuple[str, kit.Answer] = ("equal", "relaxed")
SQUARE = tuple(model for model in MODELS if model.lattice == "square")
DRAWN = next(model for model in SQUARE if not model.is_target)
"""The report's k2 = 2 k1."""
TOLD = (*NAMED, SLIGHTLY, LOADED, FREE, MISFIT)
"""What of the statements is told in words."""
SWELLING = kit.Rule(
    "Figures 4 and 5: swelling over shrinking, springs against FEM", 0.07, "1",
    "half of what separates the homogenised body from the target at k2 = 2 k1, 0.14 or more: "
    "nearer to the body that the springs are",
    layer="agreement", table="statements", rows={"measured": SLIGHTLY},
    value="in_springs", reference="in_homogenised",
)  # fmt: skip


def run(measured: Mapping[Block, Measurement], bodies: Bodies) -> kit.Evidence:
    """Redraw the figures and put numbers to the words, from what the study has solved."""

    def moves(case: str, model: Model) -> tuple[kit.Array, list[kit.Array]]:
        seen = measured[Block(case, model, FINENESS)]
        solids = [body.at_points[FINENESS] for body in bodies[case, model, FINENESS]]
        return seen.points, [seen.moves[SETTING], *solids]

    found = {(case, model): moves(case, model) for case in CASES for model in SQUARE}
    statements = pd.DataFrame(
        row for (case, model), fields in found.items() for row in judge_claims(case, model, *fields)
    )
    springs = [deformed_shapes(case, found[case, DRAWN][1][0]) for case in CASES]
    away = [distance_between(*found["bending", model]) for model in SQUARE]
    deflection = kit.Tolerance(
        "Figure 7: deflection line over its height, springs - FEM, rms", 0.02, "1",
        "misfits to a curve differ by no more than the lines do; those of half a wave and of a "
        "whole wave to the FEM line differ by 0.046 or more: which is nearer cannot turn",
        layer="agreement", observed=kit.farthest_value(away, 0.0),
    )  # fmt: skip
    return kit.Evidence(
        tables={
            "statements": statements,
            "deformed": pd.concat([points for points, _ in springs], ignore_index=True),
            "deformed_springs": pd.concat([pairs for _, pairs in springs], ignore_index=True),
            "outline": outlines(bodies),
        },
        tolerances=(SWELLING, deflection),
        drawn={"bent_line": bent_lines(*found["bending", DRAWN])},
        figures={"shapes": redrawn.figures_4_to_7, "bent_line": redrawn.bent_line},
        columns=kit.columns(__file__),
        findings=findings(statements),
    )


def judge_claims(
    case: str, model: Model, points: kit.Array, moves: list[kit.Array]
) -> list[dict[str, object]]:
    """Rows of the statements about one figure, for one model."""
    rows = []
    for claim in CLAIMS[case]:
        values = [float(claim.number(points, move)) for move in moves]
        row: dict[str, object] = {"figure": CASES[case].figure, "statement": claim.statement}
        row |= {"k1": model.k[0], "k2": model.k[1], "measured": claim.measured, "unit": claim.unit}
        row |= dict(zip(("in_springs", "in_homogenised", "in_target"), values, strict=True))
        rows.append(row | {"judgement": claim.judge(values)})
    return rows


def distance_between(points: kit.Array, moves: list[kit.Array]) -> float:
    """Distance (rms) of springs' and homogenised body's deflection lines, each over its height."""
    springs, body = (lower_row(points, move)[1] for move in moves[:2])
    return rms(springs / np.abs(springs).max() - body / np.abs(body).max())


def bent_lines(points: kit.Array, moves: list[kit.Array]) -> pd.DataFrame:
    """Deflection lines of the bar's lowest row, and what is fitted to them."""
    tables = []
    for source, move in zip(SOURCES, moves, strict=True):
        x, line = lower_row(points, move)
        fits = {curve: fitted(x, line, curve) for curve in CURVES}
        tables.append(pd.DataFrame({"source": source, "x": x, "uy": line} | fits))
    return pd.concat(tables, ignore_index=True)


def deformed_shapes(case: str, move: kit.Array) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Particles of a redrawn figure, and its springs."""
    shape = load_cases.body("square", case, FINENESS)
    problem = load_cases.problem(case, shape, homogenised(DRAWN))
    network = lattice_network(problem, shape.grid(), DRAWN.constants, weights=SETTING[0])
    words = np.array([["no", "uy"], ["ux", "ux and uy"]])
    held = network.fixed.astype(int)
    particles = {
        "case": case,
        "point": np.arange(len(move)),
        **dict(zip("xy", network.points.T, strict=True)),
        **dict(zip(("ux", "uy"), move.T, strict=True)),
        "held_components": words[held[:, 0], held[:, 1]],
        **dict(zip(("load_x", "load_y"), network.force.T, strict=True)),
    }
    start, end = network.springs.T
    return pd.DataFrame(particles), pd.DataFrame({"case": case, "start": start, "end": end})


def outline_points(points: kit.Array) -> kit.Array:
    """Numbers of the points on a rectangle's edges, counter-clockwise from the origin."""
    (x, y), (width, height) = points.T, points.max(axis=0)
    sides = [np.isclose(y, 0), np.isclose(x, width), np.isclose(y, height), np.isclose(x, 0)]
    travelled = [x, width + y, 2 * width + height - x, 2 * (width + height) - y]
    # The first side that a point lies on counts; the origin is where the way starts, not its end.
    way = np.select(sides, travelled, np.inf)
    order = np.argsort(way, kind="stable")
    return np.asarray(order[: np.isfinite(way).sum()])


def outlines(bodies: Bodies) -> pd.DataFrame:
    """The elastic bodies' outlines in order round them, as finely as they were sampled."""
    tables = []
    for case in CASES:
        finest = max(n for c, model, n in bodies if (c, model) == (case, DRAWN))
        points = load_cases.body("square", case, finest).grid().points
        ring = outline_points(points)
        for source, body in zip(SOURCES[1:], bodies[case, DRAWN, finest], strict=True):
            (x, y), (ux, uy) = points[ring].T, body.at_points[finest][ring].T
            row = {"case": case, "source": source, "x": x, "y": y, "ux": ux, "uy": uy}
            tables.append(pd.DataFrame(row))
    return pd.concat(tables, ignore_index=True)


def findings(statements: pd.DataFrame) -> tuple[str, ...]:
    """What the table says of each figure as it is drawn: one sentence a figure."""
    told = statements[statements["measured"].isin(TOLD) & (statements["k2"] == DRAWN.k[1])]
    sentences = []
    for figure, rows in told.groupby("figure"):
        parts = [
            f'"{row["statement"]}" {row["judgement"]} ({row["measured"]}: '
            f"{_format_outline(row, 'in_springs')} in the springs, "
            f"{_format_outline(row, 'in_homogenised')} in FEM)"
            for row in rows.to_dict("records")
        ]
        sentences.append(f"Figure {figure} at k2 = 2 k1: {'; '.join(parts)}.")
    return tuple(sentences)


def _format_outline(row: Mapping[Hashable, Any], source: str) -> str:
    return f"{1e3 * row[source]:+.2f} mm" if row["unit"] == "m" else f"{row[source]:.3f}"
