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

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from msvalidate import figures
from msvalidate.body import lattice_network
from msvalidate.candidate import Answer
from msvalidate.compare import worst
from msvalidate.evidence import Evidence, Tables, Tolerance
from msvalidate.problem import Array
from studies.displacement import load_cases
from studies.displacement.elastic import Bodies
from studies.displacement.load_cases import CASES
from studies.displacement.measuring import Block, Measured
from studies.displacement.models import MODELS, Model, homogenised

FINENESS = 5
SETTING: tuple[str, Answer] = ("equal", "relaxed")
SQUARE = tuple(model for model in MODELS if model.lattice == "square")
DRAWN = next(model for model in SQUARE if not model.is_target)
"""The report's k2 = 2 k1."""
SOURCES = ("springs", "homogenised body", "target")
NUMBERS = {case: number for number, case in enumerate(CASES, start=4)}
"""Load case -> the report's figure."""
EXAGGERATED = {"pressure": 10, "two-sided pressure": 10, "shear": 10, "bending": 20}
LIKE = 0.05
"""A line is like a curve if it misses it by less than this part of its height, which a reader of a
printed figure just about sees."""
TOLERANCES = (
    Tolerance(
        "Figures 4 to 6: changes of length that the words name, springs over FEM",
        0.5,
        "1",
        "nearer to the elastic body's change than to no change, or to twice as much",
    ),
    Tolerance(
        "Figures 4 and 5: swelling over shrinking, springs against FEM",
        0.07,
        "1",
        "half of what separates the homogenised body from the target at k2 = 2 k1, 0.14 or more: "
        "nearer to the body that the springs are",
    ),
    Tolerance(
        "Figure 7: deflection line over its height, springs - FEM, rms",
        0.02,
        "1",
        "misfits to a curve differ by no more than the lines do; those of half a wave and of a "
        "whole wave to the FEM line differ by 0.046 or more: which is nearer cannot turn",
    ),
)
COLUMNS = {
    **load_cases.COLUMNS,
    "point": "number of a particle",
    "start": "particle at which a spring starts",
    "end": "particle at which it ends",
    "ux": "displacement along x (m)",
    "uy": "displacement along y (m)",
    "held_components": "components of the displacement that are held at the particle",
    "load_x": "force on the particle along x (N)",
    "load_y": "force on the particle along y (N)",
    "source": "whose displacement: of springs, of the homogenised body or of the target (by FEM)",
    "fit_half_wave": "sin(pi x/L), fitted to uy by a factor (m)",
    "fit_whole_wave": "(1 - cos(2 pi x/L))/2, fitted to uy by a factor (m)",
    "fit_clamped_beam": "clamped beam under a force in its middle, fitted to uy by a factor (m)",
    "fit_shear_beam": "the same plus straight lines from the ends to the middle: two factors (m)",
    "figure": "number of the report's figure",
    "statement": "what the report says, shortened; or a curve for comparison",
    "measured": "what of the picture is measured",
    "unit": "unit of the row's numbers",
    "in_springs": "the number in the springs, where Algorithm 1 comes to rest with equal weights",
    "in_homogenised": "the same in the homogenised body, linear, by FEM",
    "in_target": "the same in the target, linear, by FEM",
    "judgement": "of which of the three the statement holds. A line is like a curve if the misfit "
    f"is below {LIKE:g}",
}


class Claim(NamedTuple):
    """A statement as a number, of points (m) and displacements (m): above a bound or below it."""

    statement: str
    measured: str
    number: Callable[[Array, Array], float]
    above: bool
    bound: float = 0.0
    unit: str = "m"

    def judge(self, values: list[float]) -> str:
        """Of which of the sources it holds, in words."""
        sign = 1 if self.above else -1
        true = [s for s, v in zip(SOURCES, values, strict=True) if sign * (v - self.bound) > 0]
        if len(true) == len(SOURCES):
            return "holds"
        return f"holds of {' and '.join(true)} only" if true else "does not hold"


def gap(points: Array, move: Array, axis: int) -> Array:
    """Change (m) of the distance along an axis of two opposite sides, particle by particle."""
    along = points[:, axis]
    low, high = np.isclose(along, along.min()), np.isclose(along, along.max())
    return np.asarray(move[high, axis] - move[low, axis])


def lower_row(points: Array, move: Array) -> tuple[Array, Array]:
    """Places along x (m) and deflection (m) of the lowest row of particles."""
    low = points[:, 1] == 0
    return points[low, 0], move[low, 1]


def clamped_beam(xi: Array) -> Array:
    """Deflection of a clamped beam under a force in its middle, 1 there; xi = x/L."""
    near = np.minimum(xi, 1 - xi)
    return np.asarray(4 * near**2 * (3 - 4 * near))


CURVES: dict[str, Callable[[Array], list[Array]]] = {
    "fit_half_wave": lambda xi: [np.sin(np.pi * xi)],
    "fit_whole_wave": lambda xi: [(1 - np.cos(2 * np.pi * xi)) / 2],
    "fit_clamped_beam": lambda xi: [clamped_beam(xi)],
    "fit_shear_beam": lambda xi: [clamped_beam(xi), np.minimum(xi, 1 - xi)],
}


def fitted(x: Array, line: Array, curve: str) -> Array:
    """Least-squares fit of a curve to a deflection line (m) at places x (m)."""
    shapes = np.column_stack(CURVES[curve](x / x.max()))
    return np.asarray(shapes @ np.linalg.lstsq(shapes, line, rcond=None)[0])


def rms(values: Array) -> float:
    """Root of the mean square."""
    return float(np.sqrt(np.mean(values**2)))


def misfit(x: Array, line: Array, curve: str) -> float:
    """Root mean square by which a line misses a curve, over the line's height."""
    return float(rms(line - fitted(x, line, curve)) / np.abs(line).max())


def like(statement: str, curve: str) -> Claim:
    """The claim that the lowest row is like a curve."""

    def number(points: Array, move: Array) -> float:
        return misfit(*lower_row(points, move), curve)

    return Claim(statement, "rms misfit over height", number, above=False, bound=LIKE, unit="1")


NAMED = ("mean change of height", "mean change of width", "change of length along x")
SLIGHTLY = "mean swelling over mean shrinking"
LOADED, FREE = "change of height at x = 0, loaded", "change of width at y = 1 m, free"
SWELLS, SHRINKS = "swells along y", "shrinks along x"
UPPER, BOTTOM = "upper edge is compressed", "bottom edge elongates"
PRESSED = (
    Claim(SWELLS, NAMED[0], lambda x, u: gap(x, u, 1).mean(), above=True),
    Claim(SWELLS, "change of height at x = 0.4 m", lambda x, u: gap(x, u, 1)[2], above=True),
    Claim(SWELLS, LOADED, lambda x, u: gap(x, u, 1)[0], above=True),
    Claim(SHRINKS, NAMED[1], lambda x, u: gap(x, u, 0).mean(), above=False),
    Claim(SHRINKS, "change of width at y = 0.4 m", lambda x, u: gap(x, u, 0)[2], above=False),
    Claim(SHRINKS, FREE, lambda x, u: gap(x, u, 0)[-1], above=False),
    Claim(
        "swells slightly: less than it shrinks",
        SLIGHTLY,
        lambda x, u: -gap(x, u, 1).mean() / gap(x, u, 0).mean(),
        above=False,
        bound=1.0,
        unit="1",
    ),
)
CLAIMS = {
    "pressure": PRESSED,
    "two-sided pressure": PRESSED,
    "shear": (
        Claim(UPPER, NAMED[2], lambda x, u: gap(x, u, 0)[-1], above=False),
        Claim(BOTTOM, NAMED[2], lambda x, u: gap(x, u, 0)[0], above=True),
    ),
    "bending": (
        like("sine-like: half a wave", "fit_half_wave"),
        like("sine-like: a whole wave, 1 - cos", "fit_whole_wave"),
        like("for comparison: a clamped beam", "fit_clamped_beam"),
        like("for comparison: a clamped beam that shears", "fit_shear_beam"),
    ),
}


def run(measured: Mapping[Block, Measured], bodies: Bodies) -> Evidence:
    """Redraw the figures and put numbers to the words, from what the study has solved."""

    def moves(case: str, model: Model) -> tuple[Array, list[Array]]:
        seen = measured[Block(case, model, FINENESS)]
        solids = [body.at_points[FINENESS] for body in bodies[case, model, FINENESS]]
        return seen.points, [seen.moves[SETTING], *solids]

    found = {(case, model): moves(case, model) for case in CASES for model in SQUARE}
    statements = pd.DataFrame(
        row for (case, model), fields in found.items() for row in judged(case, model, *fields)
    )
    springs = [deformed(case, found[case, DRAWN][1][0]) for case in CASES]
    named = statements[statements["measured"].isin(NAMED)]
    slightly = statements[statements["measured"] == SLIGHTLY]
    away = [apart(*found["bending", model]) for model in SQUARE]
    values = (
        worst(named["in_springs"] / named["in_homogenised"], 1.0),
        worst(slightly["in_springs"], slightly["in_homogenised"]),
        worst(away, 0.0),
    )
    return Evidence(
        tables={
            "statements": statements,
            "bent_line": bent_lines(*found["bending", DRAWN]),
            "deformed": pd.concat([points for points, _ in springs], ignore_index=True),
            "deformed_springs": pd.concat([pairs for _, pairs in springs], ignore_index=True),
            "outline": outlines(bodies),
        },
        observed={t.quantity: value for t, value in zip(TOLERANCES, values, strict=True)},
        tolerances=TOLERANCES,
        figures={"shapes": draw, "bent_line": draw_line},
        columns=COLUMNS,
        findings=findings(statements),
    )


def judged(case: str, model: Model, points: Array, moves: list[Array]) -> list[dict[str, object]]:
    """Rows of the statements about one figure, for one model."""
    rows = []
    for claim in CLAIMS[case]:
        values = [float(claim.number(points, move)) for move in moves]
        row: dict[str, object] = {"figure": NUMBERS[case], "statement": claim.statement}
        row |= {"k1": model.k[0], "k2": model.k[1], "measured": claim.measured, "unit": claim.unit}
        row |= dict(zip(("in_springs", "in_homogenised", "in_target"), values, strict=True))
        rows.append(row | {"judgement": claim.judge(values)})
    return rows


def apart(points: Array, moves: list[Array]) -> float:
    """Distance (rms) of springs' and homogenised body's deflection lines, each over its height."""
    springs, body = (lower_row(points, move)[1] for move in moves[:2])
    return rms(springs / np.abs(springs).max() - body / np.abs(body).max())


def bent_lines(points: Array, moves: list[Array]) -> pd.DataFrame:
    """Deflection lines of the bar's lowest row, and what is fitted to them."""
    tables = []
    for source, move in zip(SOURCES, moves, strict=True):
        x, line = lower_row(points, move)
        fits = {curve: fitted(x, line, curve) for curve in CURVES}
        tables.append(pd.DataFrame({"source": source, "x": x, "uy": line} | fits))
    return pd.concat(tables, ignore_index=True)


def deformed(case: str, move: Array) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Particles of a redrawn figure, and its springs."""
    shape = load_cases.body("square", case, FINENESS)
    problem = load_cases.problem(case, shape, homogenised(DRAWN))
    network = lattice_network(problem, shape.grid(), DRAWN.constants, weights=SETTING[0])
    words = np.array([["no", "uy"], ["ux", "ux and uy"]])
    held = network.held.astype(int)
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


def around(points: Array) -> Array:
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
        ring = around(points)
        for source, body in zip(SOURCES[1:], bodies[case, DRAWN, finest], strict=True):
            (x, y), (ux, uy) = points[ring].T, body.at_points[finest][ring].T
            row = {"case": case, "source": source, "x": x, "y": y, "ux": ux, "uy": uy}
            tables.append(pd.DataFrame(row))
    return pd.concat(tables, ignore_index=True)


def findings(statements: pd.DataFrame) -> tuple[str, ...]:
    """What the table says of the model drawn, in springs and homogenised body."""
    rows = statements[statements["k2"] == DRAWN.k[1]].to_dict("records")
    two = {
        (row["figure"], key): (row["in_springs"], row["in_homogenised"])
        for row in rows
        for key in (row["statement"], row["measured"])
    }

    def said(
        figure: int, key: str, form: str = "{:+.2f} mm in the springs, {:+.2f} mm in FEM"
    ) -> str:
        """Both numbers, in mm or percent."""
        factor = 1e3 if "mm" in form else 100
        return form.format(*(factor * value for value in two[figure, key]))

    slightly = [two[figure, SLIGHTLY][0] for figure in (4, 5)]
    misses = [said(7, claim.statement, "{:.1f} %") for claim in CLAIMS["bending"]]
    pressed = (
        "Figures 4 and 5: on the mean the block swells along y and shrinks along x, in springs and "
        f"FEM alike; at k2 = 2 k1 the springs swell by {slightly[0]:.2f} and {slightly[1]:.2f} of "
        "what they shrink, which is not slight. It is not so everywhere: in Figure 5 the height of "
        f"the loaded sides changes by {said(5, LOADED)}, the width at the free edges by "
        f"{said(5, FREE)}."
    )
    sheared = (
        f"Figure 6: the words hold. At k2 = 2 k1 the upper edge changes by {said(6, UPPER)}, the "
        f"bottom edge by {said(6, BOTTOM)}."
    )
    bent = (
        f"Figure 7: at k2 = 2 k1 half a sine wave misses the springs' deflection line by "
        f"{misses[0]} of its height (rms), a whole wave 1 - cos by {misses[1]}, a clamped beam by "
        f"{misses[2]} and one that also shears by {misses[3]}: sine-like is right of the whole "
        "wave only, and no better than a clamped beam."
    )
    return pressed, sheared, bent


def draw(tables: Tables) -> Figure:
    """Figures 4 to 7 at k2 = 2 k1 redrawn: 6 x 6 particles over the outlines of elastic bodies."""
    figure = Figure(figsize=(9.2, 7.2), layout="constrained")
    *blocks, bar = CASES
    layout: list[Any] = [blocks, [bar] * len(blocks)]
    axes = figure.subplot_mosaic(layout, height_ratios=(1.3, 1))
    blue, orange, green, *_ = figures.COLOURS
    for case, axis in axes.items():
        scale = EXAGGERATED[case]
        points, pairs, edge = (
            table[table["case"] == case]
            for table in (tables["deformed"], tables["deformed_springs"], tables["outline"])
        )
        rest = points[["x", "y"]].to_numpy()
        now = rest + scale * points[["ux", "uy"]].to_numpy()
        springs = pairs[["start", "end"]].to_numpy()
        for at, colour, state in ((rest, "#d4d4d4", "at rest"), (now, "#66a9d4", "deformed")):
            lines = LineCollection(list(at[springs]), color=colour, lw=0.8)
            lines.set_label(f"springs, {state}")
            axis.add_collection(lines)
        axis.plot(*now.T, "o", color=blue, ms=3.2, label="particles")
        for source, colour, line in zip(SOURCES[1:], (orange, green), ("-", "--"), strict=True):
            ring = edge[edge["source"] == source]
            at = ring[["x", "y"]].to_numpy() + scale * ring[["ux", "uy"]].to_numpy()
            axis.plot(*np.vstack([at, at[:1]]).T, line, color=colour, label=f"{source} (FEM)")
        held = (points["held_components"] != "no").to_numpy()
        axis.plot(*now[held].T, "s", color="black", ms=6, mfc="none", mew=1, label="held")
        draw_loads(axis, now, points[["load_x", "load_y"]].to_numpy())
        axis.set(aspect="equal", xlabel="x (m)", ylabel="y (m)")
        gap_in_title = ", " if case == bar else "\n"
        axis.set_title(f"Figure {NUMBERS[case]}: {case}{gap_in_title}displacement × {scale}")
        axis.grid(visible=False)
        if case != bar:
            axis.set(xlim=(-0.2, 1.15), ylim=(-0.1, 1.33), xticks=np.arange(6) / 5)
    figures.shared_legend(figure, list(axes.values()))
    return figure


def draw_loads(axis: Axes, at: Array, load: Array) -> None:
    """Arrows that end at the loaded particles; the longest is 0.2 m long."""
    size = np.linalg.norm(load, axis=1)
    on = size > 0
    arrow = 0.2 * load[on] / size.max()
    to_scale: dict[str, Any] = {"angles": "xy", "scale_units": "xy", "units": "xy", "scale": 1}
    axis.quiver(*at[on].T, *arrow.T, **to_scale, pivot="tip", width=0.016, zorder=3)
    axis.plot([], [], ls="", marker=r"$\rightarrow$", ms=11, color="black", label="load")


def draw_line(tables: Tables) -> Figure:
    """Deflection of the bar's lowest row at k2 = 2 k1, and by how much four curves miss it."""
    figure, (axis, missed) = figures.new(columns=2, size=(4.6, 3.7))
    lines = dict(list(tables["bent_line"].groupby("source")))
    springs = lines[SOURCES[0]]
    x, deflection = springs["x"], 1e3 * springs["uy"]
    height = deflection.abs().max()
    blue, *solids = figures.COLOURS[:3]
    for source, colour, style in zip(SOURCES[1:], solids, ("-", "--"), strict=True):
        axis.plot(x, 1e3 * lines[source]["uy"], style, color=colour, label=f"{source} (FEM)")
    curves = zip(CURVES, CLAIMS["bending"], (*figures.COLOURS[3:], "#444444"), strict=True)
    for (curve, claim, colour), marker in zip(curves, "^vDs", strict=True):
        fit = 1e3 * springs[curve]
        label = f"fit: {claim.statement.partition(': ')[2]}"
        axis.plot(x, fit, color=colour, lw=1, label=label)
        by = 100 * (deflection - fit) / height
        missed.plot(x, by, marker, ls="-", color=colour, lw=1, ms=3.5)
    axis.plot(x, deflection, "o", color=blue, mfc="white", ms=4, label="springs")
    axis.set(xlabel="x (m)", ylabel="deflection uy (mm)", title="Lowest row of the bar")
    missed.set(xlabel="x (m)", ylabel="springs - fit (% of height)", title="Misfit of the springs")
    figures.shared_legend(figure, [axis])
    return figure
