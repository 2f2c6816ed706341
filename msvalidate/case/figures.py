"""Pictures of a case: the body as held and loaded, springs over elements, difference, budget."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from msvalidate.case.comparison import Comparison
from msvalidate.case.fracture import draw_breaks
from msvalidate.case.judge import Judged
from msvalidate.output.body_drawing import (
    ARROW,
    MOST_ARROWS,
    SHOWN,
    body_axes,
    draw_held_and_loaded,
)
from msvalidate.output.figures import COLOURS, UPWARDS, add_shared_legend, new_figure
from msvalidate.problem import (
    SHAPES,
    Array,
    Index,
    Mask,
    PointForce,
    Traction,
    materials_at,
    vectors_at,
)
from msvalidate.problem.cells import surface_facets
from reference_fem.body import Solution
from reference_fem.converged import Reference


def figures(
    found: Comparison, budget: pd.DataFrame, lattices: pd.DataFrame
) -> dict[str, tuple[str, Callable[[], Figure]]]:
    """Name of each picture -> its caption, and what draws it."""
    pressed = {}
    if found.reference.contact is not None:
        pressed["pressure"] = (
            "Pressure of the obstacle on springs and elements",
            lambda: draw_pressure(found),
        )
    growth = found.springs[0].growth
    if growth is not None:
        words = "Springs that broke as the loads were raised"
        pressed["breaks"] = (words, lambda: draw_breaks(growth))
    return pressed | {
        "body": ("The body, its supports and its loads", lambda: draw_body(found)),
        "field": (
            "Springs over elements, displacements enlarged",
            lambda: draw_fields(found),
        ),
        "difference": (
            "Difference of springs and elasticity over the largest displacement",
            lambda: draw_difference(found.points, found.relative, _drawn(found.reference)),
        ),
        "spacing": (
            "Difference of springs and elasticity against their spacing",
            lambda: draw_spacing(found, lattices),
        ),
        "budget": (
            "What makes up the difference where it is largest",
            lambda: draw_budget(budget, found.case.band),
        ),
    }


def judged_figures(
    found: Judged, budget: pd.DataFrame
) -> dict[str, tuple[str, Callable[[], Figure]]]:
    """Name of each picture of a judgement -> its caption, and what draws it."""
    solution = _drawn(found.reference)
    return {
        "matching": ("Points of the result in the body", lambda: draw_matching(found)),
        "difference": (
            "Difference of result and elasticity over the largest displacement",
            lambda: draw_difference(found.matched.places, found.relative, solution),
        ),
        "budget": (
            "What makes up the difference where it is largest",
            lambda: draw_budget(budget, found.case.band),
        ),
    }


def draw_matching(found: Judged) -> Figure:
    """Compared points, and those outside, doubled or missing, over the body's outline."""
    solution, matched = found.reference.solutions[0], found.matched
    x = solution.body.points
    size = float(np.ptp(x, axis=0).max())
    near = matched.outside
    if len(near):  # far ones would leave the body a dot
        low, high = x.min(axis=0) - size, x.max(axis=0) + size
        near = near[((near > low) & (near < high)).all(axis=1)]
    figure, axis = body_axes(np.concatenate([x, near]), 0.05 * size)
    _draw_edges(axis, x, solution, "#666666", "body")
    order = UPWARDS if x.shape[1] == 3 else [0, 1]
    groups = [
        (matched.places, ".", COLOURS[0], "compared", 2.5),
        (near, "x", COLOURS[1], f"outside ({len(matched.outside)})", 6.0),
        (matched.doubled, "s", COLOURS[3], f"twice in the file ({len(matched.doubled)})", 6.0),
        (matched.missing, "o", COLOURS[2], f"not in the file ({len(matched.missing)})", 6.0),
    ]
    for at, mark, colour, label, ms in groups:
        if len(at):
            style: dict[str, Any] = {"color": colour, "ms": ms, "label": label, "mfc": "none"}
            axis.plot(*at[:, order].T, mark, rasterized=len(at) > MOST_ARROWS, **style)
    axis.legend(
        loc="upper center", bbox_to_anchor=(0.5, 0.02 if len(order) == 3 else -0.16), ncols=3
    )
    return figure


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


def draw_body(found: Comparison) -> Figure:
    """The undeformed body: surface, particles, supports, loads."""
    solution = found.reference.solutions[0]
    x = solution.body.points
    size = float(np.ptp(x, axis=0).max())
    figure, axis = body_axes(x, 1.3 * ARROW * size)
    _draw_materials(axis, found)
    _draw_edges(axis, x, solution, "#666666", "body")
    lattice = found.springs[0].lattice
    if x.shape[1] == 2:
        axis.plot(
            *lattice.points.T,
            ".",
            ms=1.5,
            color="#9aa6b2",
            label="particles",
            zorder=1,
            rasterized=True,
        )
    at, force = _arrows(found)
    draw_held_and_loaded(
        axis, lattice.points, found.springs[0].network.held, at, force, ARROW * size
    )
    below = {"loc": "upper center", "bbox_to_anchor": (0.5, -0.16), "ncols": 4}
    axis.legend(**below if x.shape[1] == 2 else {"loc": "upper left"})
    return figure


def _draw_materials(axis: Axes, found: Comparison) -> None:
    """Cells, in space the sides round them, of each region that is of another material."""
    problem, body = found.case.problem, found.reference.solutions[0].body
    corners = body.cells[:, : body.element.corners]
    number = materials_at(problem, body.points[corners].mean(axis=1))
    for zone in np.unique(number[number > 0]).tolist():
        own = corners[number == zone]
        if body.dim == 3:
            own = surface_facets(own, SHAPES[body.element.shape].straight)
        colour, places = COLOURS[(zone + 1) % len(COLOURS)], body.points[own]
        style: dict[str, Any] = {"color": colour, "alpha": 0.35, "lw": 0}
        if body.dim == 2:
            axis.add_collection(PolyCollection(list(places), **style, zorder=0))
        else:
            axis.add_collection3d(Poly3DCollection(places[..., UPWARDS], **style))  # type: ignore[attr-defined]
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
        at = at[:: max(1, -(-len(at) // MOST_ARROWS))]
        (name,) = (each for each in ("traction", "force", "acceleration") if hasattr(load, each))
        both = np.hstack([at, vectors_at(name, getattr(load, name), at)])
        groups.setdefault(type(load), []).append(both)
    drawn = [np.empty((0, 2 * d)), *map(np.concatenate, groups.values())]
    for both in drawn[1:]:
        both[:, d:] /= np.linalg.norm(both[:, d:], axis=1).max() or 1.0
    arrows = np.concatenate(drawn)
    return arrows[:, :d], arrows[:, d:]


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
    figure, axis = body_axes(np.concatenate([moved, springs, x]), 0.02 * size)
    order = UPWARDS if x.shape[1] == 3 else [0, 1]
    elements = "elements" if found.reference.large is None else "elements, to first order"
    _draw_edges(axis, moved, solution, COLOURS[1], elements)
    marks = lattice.points.shape[1] == 2
    if marks:
        lines = LineCollection(
            list(springs[lattice.springs]),
            color=COLOURS[4],
            lw=0.35,
            alpha=0.7,
            label="springs",
            rasterized=True,
        )
        axis.add_collection(lines)
    else:
        axis.plot(
            *springs[:, order].T, ".", ms=1.5, color=COLOURS[0], label="springs", rasterized=True
        )
    if not marks:
        facets = solution.body.surface[:, : _corners(solution.body.surface)]
        shown = moved[facets][..., UPWARDS]
        axis.add_collection3d(Poly3DCollection(shown, color=COLOURS[1], alpha=0.08, lw=0))
    _draw_edges(axis, x, solution, "#999999", "at rest", "--")
    axis.set_title(f"displacements {times:.3g} times as large", loc="left")
    axis.legend(loc="upper center", bbox_to_anchor=(0.5, -0.16 if marks else 0.02), ncols=3)
    return figure


def _drawn(reference: Reference) -> Solution:
    """The finest solution; in space on the first mesh, of whose sides there are few to draw."""
    first, finest = reference.solutions[0], reference.finest
    if first.body.dim == 2:
        return finest
    return Solution(first.body, finest.at(first.body.points))


def draw_difference(points: Array, relative: Array, solution: Solution) -> Figure:
    """Difference (p,) at points (p, d) in m, on one colour scale, over the body's outline."""
    x = solution.body.points
    size = float(np.ptp(x, axis=0).max())
    figure, axis = body_axes(np.concatenate([x, points]), 0.03 * size)
    _draw_edges(axis, x, solution, "#666666", "body")
    order = np.argsort(relative, kind="stable")
    at = points[order][:, UPWARDS] if x.shape[1] == 3 else points[order]
    dots = axis.scatter(
        *at.T,
        c=100 * relative[order],
        cmap="viridis",
        s=_dot_size(len(points)),
        vmin=0.0,
        rasterized=True,
    )
    figure.colorbar(
        dots, ax=axis, label="difference (%)", shrink=0.8, pad=0.1 if x.shape[1] == 3 else 0.02
    )
    worst = at[-1]
    axis.plot(
        *[[c] for c in worst], "o", ms=9, mfc="none", mec=COLOURS[1], label="largest", zorder=4
    )
    low = -0.16 if len(worst) == 2 else 0.02
    axis.legend(loc="upper center", bbox_to_anchor=(0.5, low), ncols=2)
    return figure


def _dot_size(count: int) -> float:
    return float(np.clip(6000 / count, 2.0, 36.0))


def draw_spacing(found: Comparison, lattices: pd.DataFrame) -> Figure:
    """Difference of each lattice and of their limit, with the band and elasticity's own error."""
    figure, (axis,) = new_figure(size=(5.2, 3.4))
    there = lattices[lattices["spacing"] > 0]
    axis.loglog(
        there["spacing"], 100 * there["difference"], "o-", color=COLOURS[0], label="springs"
    )
    if found.on_mesh is not None:
        own = found.on_mesh.table
        axis.loglog(
            own["spacing"],
            100 * own["difference"],
            "s--",
            color=COLOURS[3],
            label="on its own mesh",
        )
    if len(there) < len(lattices):
        limit = 100 * float(lattices["difference"].iloc[-1])
        axis.axhline(limit, color=COLOURS[2], ls="-.", label="what they close in on")
    axis.axhline(100 * found.case.band, color=COLOURS[1], ls="--", label="band")
    if found.reference.error > 0:
        axis.axhline(
            100 * found.reference.error, color="grey", ls=":", label="elasticity's own error"
        )
    axis.set(xlabel="spacing (m)", ylabel="difference (%)")
    add_shared_legend(figure, [axis], 2)
    return figure


def draw_budget(budget: pd.DataFrame, band: float) -> Figure:
    """Bars of the parts, with their uncertainties, and the band."""
    figure, (axis,) = new_figure(size=(6.0, 3.0))
    known = budget[np.isfinite(budget["value"].to_numpy(dtype=float))]
    place = np.arange(len(known))[::-1]
    value, uncertainty = 100 * known["value"], 100 * known["uncertainty"]
    colour = [COLOURS[1] if part == "total" else COLOURS[0] for part in known["part"]]
    axis.barh(
        place, value, xerr=uncertainty, color=colour, height=0.6, error_kw={"capsize": 3, "lw": 1}
    )
    axis.set_yticks(place, list(known["part"]))
    axis.axvline(0, color="black", lw=0.8)
    for sign in (-1, 1):
        axis.axvline(
            sign * 100 * band, color="grey", ls="--", lw=1, label="band" if sign > 0 else None
        )
    axis.set_xlabel("part of the difference over the largest displacement (%)")
    axis.legend(loc="lower right")
    return figure


def _draw_edges(
    axis: Axes, places: Array, solution: Solution, colour: str, label: str, style: str = "-"
) -> None:
    """Outline of a body in the plane, sharp edges and rims in space, its nodes at places (n, d)."""
    body = solution.body
    facets = body.surface
    if body.dim == 2:
        ends = facets[:, [0, 2, 1]] if facets.shape[1] == 3 else facets
        lines = list(places[ends])
        axis.add_collection(
            LineCollection(lines, colors=colour, linewidths=1.1, linestyles=style, label=label)
        )
        return
    edges = sharp_edges(body.points, facets[:, : _corners(facets)])
    for number, (a, b) in enumerate(edges):
        line = places[[a, b]][:, UPWARDS].T
        axis.plot(*line, style, color=colour, lw=0.9, label=label if not number else None)


def _corners(facets: Index) -> int:
    return 3 if facets.shape[1] in (3, 6) else 4


def sharp_edges(points: Array, facets: Index, angle: float = 0.5) -> Index:
    """Edges (e, 2) between facets (f, 3 or 4) that meet at more than an angle (rad)."""
    x = points[facets]
    normal = np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    pairs = np.sort(np.stack([facets, np.roll(facets, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    owner = np.repeat(np.arange(len(facets)), facets.shape[1])
    order = np.lexsort(pairs.T[::-1])
    pairs, owner = pairs[order], owner[order]
    same: Mask = (pairs[1:] == pairs[:-1]).all(axis=1)
    first = np.flatnonzero(same)
    cosine = (normal[owner[first]] * normal[owner[first + 1]]).sum(axis=1)
    return np.asarray(pairs[first[cosine < np.cos(angle)]])
