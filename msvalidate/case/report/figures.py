"""Pictures of a case: the body as held and loaded, springs over elements, difference, budget."""

from __future__ import annotations

import textwrap
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from msvalidate.bench.output.body_drawing import (
    ARROW,
    MOST_ARROWS,
    SHOWN,
    body_axes,
    draw_supports_and_loads,
)
from msvalidate.bench.output.figures import COLOURS, add_shared_legend, new_figure
from msvalidate.case.compare.comparison import Comparison
from msvalidate.case.file.fracture import draw_breaks
from msvalidate.case.file.places import mesh_names
from msvalidate.case.file.units import user_unit
from msvalidate.case.judge.judgement import Judged
from msvalidate.case.report.outlines import draw_surface, flat_facets, hidden, outline_edges
from msvalidate.problem import (
    SHAPES,
    Array,
    PointForce,
    Problem,
    Traction,
    materials_at,
    vectors_at,
)
from msvalidate.problem.cells import surface_facets
from msvalidate_check.text import number_text
from reference_fem.body import Solution
from reference_fem.converged import Reference
from reference_fem.mesh.discretisation import Discretisation

Drawn = dict[str, tuple[str, Callable[[], Figure]]]
"""Name of each picture -> its caption, and what draws it."""
EDGE = "#666666"
SURFACE = "#dedede"
LABEL = 40
"""Maximum number of letters of a label with names."""


def figures(found: Comparison, budget: pd.DataFrame, lattices: pd.DataFrame) -> Drawn:
    """Pictures of a comparison."""
    drawn: Drawn = {}
    if found.reference.contact is not None:
        words = "The obstacle presses on springs and elements with these pressures."
        drawn["pressure"] = (words, partial(draw_pressure, found))
    growth = found.springs[0].growth
    if growth is not None:
        words = "These springs broke as the loads were raised."
        drawn["breaks"] = (words, partial(draw_breaks, growth))
    words = "Deformed springs with supports and loads lie over deformed elements, enlarged alike."
    drawn["field"] = (words, partial(draw_fields, found))
    words = "The difference of springs and elasticity depends on the spacing."
    drawn["spacing"] = (words, partial(draw_spacing, found, lattices))
    return drawn | _difference_figures(found, "springs", found.points, budget)


def judged_figures(found: Judged, budget: pd.DataFrame) -> Drawn:
    """Pictures of a judgement."""
    drawn: Drawn = {
        "matching": ("These points of the result lie in the body.", partial(draw_matching, found))
    }
    return drawn | _difference_figures(found, "result", found.matched.places, budget)


def show_in_units(figure: Figure, length: str) -> None:
    """Label axes in m and Pa in the units of a case with a unit of length."""
    for axes in figure.axes:
        scales = [axes.xaxis, axes.yaxis, *([axes.zaxis] if hasattr(axes, "zaxis") else [])]
        for scale in scales:
            name, _, unit = scale.get_label_text().rpartition(" (")
            shown, size = user_unit(unit.rstrip(")"), length)
            if name and size != 1:
                scale.set_label_text(f"{name} ({shown})")
                scale.set_major_formatter(lambda at, _, size=size: f"{at / size:.4g}")
                scale.set_minor_formatter(NullFormatter())


def _difference_figures(
    found: Comparison | Judged, whose: str, points: Array, budget: pd.DataFrame
) -> Drawn:
    return {
        "difference": (
            f"Colour is the difference of {whose} and elasticity over the largest displacement.",
            partial(draw_difference, points, found.relative, found.reference),
        ),
        "budget": (
            "These parts make up the difference where it is largest.",
            partial(draw_budget, budget, found.case.band),
        ),
    }


def draw_matching(found: Judged) -> Figure:
    """Compared points, and those outside, doubled or missing, over the body's outline."""
    solution, matched = found.reference.solutions[0], found.matched
    body = solution.body
    x = body.points
    size = float(np.ptp(x, axis=0).max())
    near = matched.outside
    if len(near):  # far ones would leave the body a dot
        low, high = body.points.min(axis=0) - size, body.points.max(axis=0) + size
        near = near[((near > low) & (near < high)).all(axis=1)]
    figure, axis = body_axes(np.concatenate([x, near]), 0.05 * size)
    _draw_edges(axis, x, solution, EDGE, "body")
    groups = [
        (matched.places, ".", COLOURS[0], "compared", 2.5),
        (near, "x", COLOURS[1], f"outside ({len(matched.outside)})", 6.0),
        (matched.doubled, "s", COLOURS[3], f"twice in the file ({len(matched.doubled)})", 6.0),
        (matched.missing, "o", COLOURS[2], f"not in the file ({len(matched.missing)})", 6.0),
    ]
    for at, mark, colour, label, ms in groups:
        if len(at):
            style: dict[str, Any] = {"color": colour, "ms": ms, "label": label, "mfc": "none"}
            axis.plot(*at.T, mark, rasterized=len(at) > MOST_ARROWS, **style)
    _legend_below(axis, x, 3)
    return figure


def _legend_below(axis: Axes, points: Array, columns: int) -> None:
    low = 0.02 if points.shape[1] == 3 else -0.16
    axis.legend(loc="upper center", bbox_to_anchor=(0.5, low), ncols=columns)


def draw_pressure(found: Comparison) -> Figure:
    """Pressure against the place along the surface, in space against the distance from the way."""
    answer, obstacle = found.springs[0], found.case.problem.contacts[0].obstacle
    assert answer.contact is not None  # noqa: S101  the reference has one
    one, (elements, _) = answer.contact.contacts[0], found.reference.contact

    def along(points: Array) -> Array:
        off = obstacle.across(points)
        far = np.linalg.norm(off, axis=1)
        if points.shape[1] == 3:
            return np.asarray(far)
        return np.asarray(off @ np.array([-obstacle.axis[1], obstacle.axis[0]]))

    figure, (axis,) = new_figure(size=(5.6, 3.8))
    reach, where = 2 * elements.half_width, along(elements.points)
    order = np.argsort(where, kind="stable")
    order = order[np.abs(where[order]) <= reach]
    style = "." if elements.points.shape[1] == 3 else "-"
    axis.plot(where[order], elements.pressure[order], style, color=COLOURS[1], label="elements")
    own = along(answer.lattice.points[one.points])
    near = np.abs(own) <= reach
    axis.plot(own[near], one.pressure[near], "o", ms=4, color=COLOURS[0], label="springs")
    side = "distance from its way" if elements.points.shape[1] == 3 else "place along the surface"
    axis.set(xlabel=f"{side} (m)", ylabel="pressure (Pa)")
    axis.legend()
    return figure


def _draw_materials(axis: Axes, problem: Problem, body: Discretisation, at: Array) -> None:
    """Cells, in space the sides round them, of each region of another material; nodes at (n, d)."""
    corners = body.cells[:, : body.element.corners]
    number = materials_at(problem, body.points[corners].mean(axis=1))
    for zone in np.unique(number[number > 0]).tolist():
        own = corners[number == zone]
        if body.dim == 3:
            own = surface_facets(own, SHAPES[body.element.shape].straight)
        colour, places = COLOURS[(zone + 1) % len(COLOURS)], at[own]
        style: dict[str, Any] = {"color": colour, "alpha": 0.35, "lw": 0}
        if body.dim == 2:
            axis.add_collection(PolyCollection(list(places), **style, zorder=0))
        else:
            axis.add_collection3d(Poly3DCollection(places, **style))  # type: ignore[attr-defined]
        axis.plot([], [], "s", color=colour, alpha=0.35, label=f"region {zone}")


def _arrows(found: Comparison) -> tuple[Array, Array]:
    """Places (k, d) in m and arrows (k, d) of loads; the longest of each kind of load is 1 long.

    Of tractions as they are, not of the forces on nodes, which are uneven where a pressure is even.
    """
    problem, x = found.case.problem, found.reference.solutions[0].body.points
    d, groups = x.shape[1], dict[type, list[Array]]()
    for load in problem.loads:
        at = x
        if isinstance(load, PointForce):
            at = np.array([load.at])
        elif isinstance(load, Traction):
            at = x[load.region.select(x, problem.domain.tolerance)]
        at = _spread(at, 1.1 * ARROW * float(np.ptp(x, axis=0).max()))
        at = at[: max(1, MOST_ARROWS // len(problem.loads))]
        (name,) = (each for each in ("traction", "force", "acceleration") if hasattr(load, each))
        both = np.hstack([at, vectors_at(name, getattr(load, name), at)])
        groups.setdefault(type(load), []).append(both)
    drawn = [np.empty((0, 2 * d)), *map(np.concatenate, groups.values())]
    for both in drawn[1:]:
        both[:, d:] /= np.linalg.norm(both[:, d:], axis=1).max() or 1.0
    arrows = np.concatenate(drawn)
    return arrows[:, :d], arrows[:, d:]


def _spread(points: Array, gap: float) -> Array:
    """Select points (p, d) in m farther apart than a gap (m)."""
    rest, chosen = points, [points[:0]]
    while len(rest):
        chosen.append(rest[:1])
        rest = rest[np.linalg.norm(rest - rest[0], axis=1) > gap]
    return np.concatenate(chosen)


def draw_fields(found: Comparison) -> Figure:
    """Deformed outlines of elements with deformed springs over them, both enlarged alike."""
    solution = _drawn(found.reference)
    rest = found.springs[0].rest.displacement
    lattice = found.springs[0].lattice
    x = solution.body.points
    size = float(np.ptp(x, axis=0).max())
    most = max(found.size, float(np.abs(rest).max())) or 1.0
    times = SHOWN * size / most
    moved = x + times * solution.displacement
    springs = lattice.points + times * rest
    figure, axis = body_axes(np.concatenate([moved, springs, x]), 1.3 * ARROW * size)
    elements = "elements" if found.reference.large is None else "elements, to first order"
    style: dict[str, Any] = {"label": "springs", "rasterized": True}
    shown = None
    if x.shape[1] == 2:
        style |= {"color": COLOURS[0], "lw": min(0.8, 35 * found.springs[0].spacing / size)}
        axis.add_collection(LineCollection(list(springs[lattice.springs]), **style))
    else:
        shown = moved[flat_facets(solution.body.surface)]
        draw_surface(axis, shown, SURFACE)
        axis.plot(*springs.T, ".", ms=1.5, color=COLOURS[0], **style)
    _draw_materials(axis, found.case.problem, solution.body, moved)
    _draw_edges(axis, x, solution, EDGE, "undeformed", "--", shown)
    _draw_edges(axis, moved, solution, COLOURS[1], elements, "-", shown)
    at, arrow = _arrows(found)
    loads = at + times * found.reference.finest.at(at), arrow, ARROW * size
    draw_supports_and_loads(axis, springs, found.springs[0].network.fixed, *loads)
    _name_parts(axis, found.case.problem)
    axis.set_title(f"displacements {number_text(times, 3)} times as large", loc="left")
    _legend_below(axis, x, 3)
    return figure


def _name_parts(axis: Axes, problem: Problem) -> None:
    """Add the mesh's own names to the labels of supports, loads and regions."""
    for handle, label in zip(*axis.get_legend_handles_labels(), strict=True):
        part = {"held": "support", "load": "load"}.get(label, label)
        parts = mesh_names(problem).items()
        names = [name for each, name in parts if part in (each, each.split()[0])]
        text = ": ".join([label, *[", ".join(dict.fromkeys(names))][: len(names)]])
        handle.set_label(textwrap.shorten(text, LABEL, placeholder=" …").replace("$", r"\$"))


def _drawn(reference: Reference) -> Solution:
    """The finest solution; in space on the first mesh, of whose sides there are few to draw."""
    first, finest = reference.solutions[0], reference.finest
    if first.body.dim == 2:
        return finest
    return Solution(first.body, finest.at(first.body.points))


def draw_difference(points: Array, relative: Array, reference: Reference) -> Figure:
    """Difference (p,) at points (p, d) in m, on one colour scale, over the body's outline."""
    solution = _drawn(reference)
    x = solution.body.points
    size = float(np.ptp(x, axis=0).max())
    figure, axis = body_axes(np.concatenate([x, points]), 0.03 * size)
    _draw_edges(axis, x, solution, EDGE, "body")
    order = np.argsort(relative, kind="stable")
    at, size = points[order].T, float(np.clip(6000 / len(points), 2.0, 36.0))
    style: dict[str, Any] = {"cmap": "viridis", "vmin": 0.0, "rasterized": True}
    dots = axis.scatter(*at, c=100 * relative[order], s=size, **style)
    pad = 0.1 if x.shape[1] == 3 else 0.02
    figure.colorbar(dots, ax=axis, label="difference (%)", shrink=0.8, pad=pad)
    style = {"ms": 9, "mfc": "none", "mec": COLOURS[1], "zorder": 4}
    axis.plot(*at[:, -1:], "o", label="largest", **style)
    _legend_below(axis, x, 2)
    return figure


def draw_spacing(found: Comparison, lattices: pd.DataFrame) -> Figure:
    """Difference of each lattice and of their limit, with the band and elasticity's own error."""
    figure, (axis,) = new_figure(size=(5.2, 3.4))
    there = lattices[lattices["spacing"] > 0]
    shown = [(there, "o-", COLOURS[0], "springs")]
    if found.on_mesh is not None:
        shown.append((found.on_mesh.table, "s--", COLOURS[3], "on its own mesh"))
    for own, style, colour, label in shown:
        axis.loglog(own["spacing"], 100 * own["difference"], style, color=colour, label=label)
    if len(there) < len(lattices):
        limit = 100 * float(lattices["difference"].iloc[-1])
        axis.axhline(limit, color=COLOURS[2], ls="-.", label="what they close in on")
    axis.axhline(100 * found.case.band, color=COLOURS[1], ls="--", label="band")
    if found.reference.error > 0:
        known = 100 * found.reference.error
        axis.axhline(known, color="grey", ls=":", label="elasticity's own error")
    axis.set(xlabel="spacing (m)", ylabel="difference (%)")
    add_shared_legend(figure, [axis], 2)
    return figure


def draw_budget(budget: pd.DataFrame, band: float) -> Figure:
    """Bars of the parts, with their uncertainties, and the band."""
    figure, (axis,) = new_figure(size=(6.0, 3.0))
    known = budget[np.isfinite(budget["value"].to_numpy(dtype=float))]
    place = np.arange(len(known))[::-1]
    colour = [COLOURS[1] if part == "total" else COLOURS[0] for part in known["part"]]
    style: dict[str, Any] = {"color": colour, "height": 0.6, "error_kw": {"capsize": 3, "lw": 1}}
    axis.barh(place, 100 * known["value"], xerr=100 * known["uncertainty"], **style)
    axis.set_yticks(place, list(known["part"]))
    axis.axvline(0, color="black", lw=0.8)
    for at, label in ((-100 * band, None), (100 * band, "band")):
        axis.axvline(at, color="grey", ls="--", lw=1, label=label)
    axis.set_xlabel("part of the difference over the largest displacement (%)")
    axis.legend(loc="lower right")
    return figure


def _draw_edges(
    axis: Any,
    places: Array,
    solution: Solution,
    colour: str,
    label: str,
    style: str = "-",
    surface: Array | None = None,
) -> None:
    """Outline of a 2D body, or sharp edges of a 3D body, with its nodes at places (n, d).

    Edges behind the facets (f, k, 3) of a drawn surface are left out.
    """
    edges = outline_edges(solution.body)
    if solution.body.dim == 2:
        drawn: dict[str, Any] = {"linewidths": 1.1, "linestyles": style, "label": label}
        axis.add_collection(LineCollection(list(places[edges]), colors=colour, **drawn))
        return
    if surface is not None:
        edges = edges[~hidden(axis, places[edges].mean(axis=1), surface)]
    for number, edge in enumerate(edges):
        own = label if not number else None
        axis.plot(*places[edge].T, style, color=colour, lw=0.9, label=own)
