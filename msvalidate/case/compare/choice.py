"""Spacing and mesh that reach differences of 5 and 1 %.

It also reports where elements do better at the same cost.

Near a target the difference of springs from elasticity is a power of their spacing: a straight line
through the logarithms of what was solved, and of coarser lattices where all of that is better than
the target; the nearer to the target, the more a lattice counts. The largest deviation of a solved
lattice above this line is added to it. What is advised is a number of cells that a case takes, of
lattices like those solved: filled or cut to the body, which err differently. A lattice that is not
finer than all of them is solved before it is advised. Cost is the number of unknowns, components of
all points or nodes: the same on every machine.
"""

from __future__ import annotations

import math
from contextlib import suppress
from typing import Any

import numpy as np
import shapely
from scipy.spatial import KDTree

from msvalidate.case.compare.budget import lattice_row, mesh_rows
from msvalidate.case.compare.comparison import Comparison
from msvalidate.case.compare.quantities import POINT_STRESS
from msvalidate.case.file.case import MAX_REQUESTED, MESH_EDGES, Case, is_filled, spacing_of
from msvalidate.case.file.units import quantity_text
from msvalidate.case.springs.lattice_springs import (
    CAUTION,
    HIGHEST_ORDER,
    LOWEST_ORDER,
    ROUNDING,
    SpringAnswer,
    at_other_cells,
    compared_points,
    solve_springs,
)
from msvalidate.linear_algebra.norms import max_length
from msvalidate.problem import Array, Box, ProblemError, SolverError
from msvalidate.problem.records import dataclass, replace
from msvalidate.springs.lattice import PatternLattice
from msvalidate.springs.lattice.cut import joins_corners
from msvalidate.springs.lattice.outline import outline
from msvalidate.springs.lattice.patterns import all_patterns
from msvalidate_check.text import duration, percent
from msvalidate_check.verdict import DIFFERS

TARGETS = (0.05, 0.01)
"""Differences, over the largest displacement, for which spacing and mesh are sought."""
NEAR = math.log(4)
"""Width of weights in the logarithm of difference over target.

A lattice at this distance counts 1/e, because the straight line holds near the target only.
"""
ORDER_DOUBT = 0.3
"""Uncertainty of the order of convergence beyond the solved spacings.

The order still changes there.
"""
ALIKE = math.log(1.5)
"""Largest distance of a lattice from the requested spacing, in the logarithm of the spacing.

A lattice cut to a box is preferred to one that fills it and is farther off.
"""
KNOWN = 0.2
"""Fraction of a target that is left for the error of the elements.

An error beyond this accuracy grows by up to `CAUTION` at points of other lattices.
"""
MOST_TRIED, REFINED = 6, 0.9
"""Lattices that are solved for one target, and the ratio of their spacings."""
GROWTH = 1.2
"""Exponent of the springs that seconds grow with: factors and multigrid, at most."""
BETTER, MAIN, THIN = 3.0, 0.5, 5.0
"""Thresholds of the advice on elements and of its reasons.

Elements are advised if they are nearer by the first factor. A part of the difference from the
second on is its main part, and a wall with at most so many cells as the third is thin.
"""
BETWEEN, BEYOND, COARSEST, NONE = "between", "beyond", "coarsest", "none"
BRIDGED = "bridged"
"""Positions of the answer relative to the solved lattices.

It lies between them or beyond the finest; the coarsest meets the target; no spacing does; or no
lattice shows it, as springs bridge a gap of the body on each of them.
"""
HEADS = ("estimate", "spacing", "springs", "time", "elements", "time")
"""Columns of `need_rows`."""


@dataclass(frozen=True)
class Need:
    """Springs or elements that reach a target.

    Parameters
    ----------
    target, where
        Difference over the largest displacement, and where what it takes lies.
    count, seconds
        Springs or nodes, and what solving them takes; 0 where they are not known.
    cells, spacing, least, most
        Of springs: for a case's `cells`, 0 if none can be laid, the spacing (m) that comes of it,
        and between which the target's may lie. If springs bridge a gap, its width is the spacing.
    """

    target: float
    where: str
    count: int = 0
    seconds: float = math.nan
    cells: int = 0
    spacing: float = math.nan
    least: float = math.nan
    most: float = math.nan


@dataclass(frozen=True)
class Choice:
    """Springs and elements that reach each target.

    Parameters
    ----------
    springs, elements
        One need a target; none of springs on a mesh's edges, and none of either if the reference
        has no known error or is out of the range of its theory.
    unknowns, times
        At how many unknowns elements are how many times nearer than springs; NaN if not known.
    reasons
        Why they are, as far as the case shows it.
    no_coarser
        Reason why a coarser lattice has no answer; empty if none is missing.
    """

    springs: tuple[Need, ...] = ()
    elements: tuple[Need, ...] = ()
    unknowns: int = 0
    times: float = math.nan
    reasons: tuple[str, ...] = ()
    no_coarser: str = ""


def choose(found: Comparison) -> Choice:
    """Estimate the springs and elements that reach each target in a case.

    The estimate uses the solved lattices and coarser ones.
    """
    decided = any(each.decides for each in found.limitations)  # by the range of the theory
    if decided or not math.isfinite(found.reference.error):
        return Choice()
    (rows, no_coarser), meshes = _lattices(found), mesh_rows(found)
    return Choice(
        tuple(_springs(found, rows, t) for t in TARGETS if found.case.lattice != MESH_EDGES),
        tuple(_elements(meshes, found.reference.error, t) for t in TARGETS),
        *_equal_cost(found, rows, meshes),
        _reasons(found),
        no_coarser,
    )


def _lattices(found: Comparison) -> tuple[list[dict[str, Any]], str]:
    """Lattices from coarse to fine, two at least, with coarser ones beyond the largest target.

    The text is the reason why a coarser one has no answer; empty if none is missing.
    """
    wanted = found.reference.displacement.value
    rows = [_measured(found, answer, found.points, wanted) for answer in found.springs]
    try:
        while found.case.lattice != MESH_EDGES and (
            len(rows) < 2 or _column(rows, "difference").max() < max(TARGETS)
        ):
            laid = _laid(found, 2 * rows[0]["spacing"])
            if laid is None or spacing_of(laid) <= rows[0]["spacing"]:
                break
            rows.insert(0, _solved(found, laid))
    except (ProblemError, SolverError) as error:  # coarser ones are then fewer
        return rows, str(error)
    return rows, ""


def _measured(
    compared: Comparison, answer: SpringAnswer, points: Array, elastic: Array
) -> dict[str, Any]:
    """A lattice with "off": its larger difference of displacements and of the strain energy."""
    row = lattice_row(compared, answer, points, elastic)
    energies = [
        abs(answer.energy / each.wanted - 1)
        for each in compared.differences
        if each.quantity == "strain energy" and each.wanted > 0
    ]
    return row | {"off": max([row["difference"], *energies])}


def _solved(compared: Comparison, laid: Case) -> dict[str, Any]:
    """A further lattice, solved and compared at its own points."""
    answer = solve_springs(laid, spacing_of(laid))
    points = compared_points(laid, answer.lattice)
    return _measured(compared, answer, points, compared.reference.finest.at(points))


def _column(rows: list[dict[str, Any]], name: str) -> Array:
    return np.array([max(row[name], ROUNDING) for row in rows])


def _laid(found: Comparison, wanted: float) -> Case | None:
    """Case at the number of cells nearest to a spacing (m), and not coarser."""
    case, filled = found.case, is_filled(found.case, found.springs[0].spacing)
    cuttable = joins_corners(all_patterns()[str(case.lattice)]())
    other = None
    for laid in at_other_cells(case, wanted):
        spacing = spacing_of(laid)
        fills = is_filled(laid, spacing)
        near = 0 <= math.log(wanted / spacing) <= ALIKE
        if near and (cuttable or fills):
            if fills == filled:
                return laid
            other = other or laid
    return other


def _springs(found: Comparison, rows: list[dict[str, Any]], target: float) -> Need:
    """The spacing that a target takes."""
    wanted, size = found.reference.displacement.value, found.size
    resolved = sum(not len(gaps) for gaps in found.gaps)  # the finest lattices
    bridges, left = resolved < len(found.gaps), 0.0
    if not bridges:
        left = max_length(found.limit.displacement - wanted) - found.limit.uncertainty
    if found.homogenised:
        left = max(left, max_length(found.own_material - wanted))
    if left / size - found.reference.error > target:
        return Need(target, NONE)
    error, accuracy = found.reference.error, found.case.accuracy
    most = CAUTION * error if error > accuracy else min(accuracy, KNOWN * target)
    limit = target - max(error, most)
    if limit <= 0:
        return Need(target, NONE)
    s, e = np.log(_column(rows, "spacing")), np.log(_column(rows, "off"))
    t = math.log(limit)
    if (e <= t).all():
        return _costed(found, rows, Need(target, COARSEST, spacing=rows[0]["spacing"]), limit)
    if bridges and (e > t).all():
        if resolved < 2:
            return Need(target, BRIDGED, spacing=found.gaps[0][0, 2])
        s, e = s[-resolved:], e[-resolved:]
    if len(rows) < 2:
        return Need(target, BEYOND)
    weight = np.exp(-(((e - t) / NEAR) ** 2))
    middle_s, middle_e = np.average([s, e], axis=1, weights=weight)
    order = (weight * (s - middle_s) * (e - middle_e)).sum()
    believed = LOWEST_ORDER, HIGHEST_ORDER
    order = np.clip(order / (weight * (s - middle_s) ** 2).sum(), *believed)
    scatter = (e - middle_e - order * (s - middle_s)).max()
    best = middle_s + (t - scatter - middle_e) / order
    if (e > t).all():
        slow_fast = np.clip([order - ORDER_DOUBT, order + ORDER_DOUBT], *believed)
        ends, where = [best, *(s[-1] + (t - e[-1]) / slow_fast)], BEYOND
    else:
        ends, where = [best, s[e > t].min(), s[e <= t].max()], BETWEEN
    uncertainty = math.log1p(error / target) / order
    best, least, most = np.exp([best, min(ends) - uncertainty, max(ends) + uncertainty]).tolist()
    return _costed(found, rows, Need(target, where, spacing=best, least=least, most=most), limit)


def _costed(found: Comparison, rows: list[dict[str, Any]], wanted: Need, limit: float) -> Need:
    """Find the buildable lattice nearest below a spacing that meets a target, and its cost.

    The difference `limit` is the target without the uncertainty of elasticity. A lattice that is
    finer than all of the solved ones is not solved.
    """
    domain = found.case.problem.domain
    failed = min((row["spacing"] for row in rows if row["off"] > limit), default=math.inf)
    below = min(failed * (1 - ROUNDING), wanted.spacing * (1 + ROUNDING))
    with suppress(ProblemError, SolverError):
        for _ in range(MOST_TRIED):
            laid = _laid(found, below)
            if laid is None:
                break
            h = spacing_of(laid)
            if domain.volume / h**domain.dim > MAX_REQUESTED[domain.dim]:
                break
            beyond = h < rows[-1]["spacing"] * (1 - ROUNDING)
            row = rows[-1] if beyond else _solved(found, laid)
            if beyond or row["off"] <= limit:
                times = (row["spacing"] / h) ** domain.dim
                return replace(
                    wanted,
                    where=BEYOND if beyond else wanted.where,
                    count=round(row["springs"] * times),
                    seconds=row["seconds"] * times**GROWTH,
                    cells=laid.cells or 0,
                    spacing=h,
                    least=min(wanted.least, h),
                )
            below = REFINED * h
    return replace(wanted, spacing=below)


def _elements(meshes: list[dict[str, Any]], error: float, target: float) -> Need:
    """The first mesh that met a target."""
    for number, mesh in enumerate(meshes):
        if mesh["difference"] + error <= target:
            where = BETWEEN if number else COARSEST
            return Need(target, where, mesh["nodes"], mesh["seconds"])
    return Need(target, BEYOND)


def _equal_cost(
    found: Comparison, rows: list[dict[str, Any]], meshes: list[dict[str, Any]]
) -> tuple[int, float]:
    """Unknowns of the mesh nearest in cost to the springs asked for, and how much nearer it is."""
    points, differences = np.log(_column(rows, "points")), np.log(_column(rows, "difference"))
    asked, error = len(found.springs[0].lattice.points), found.reference.error
    mesh = min(meshes, key=lambda each: abs(math.log(each["nodes"] / asked)))
    if math.log(mesh["nodes"]) > points[-1]:
        return 0, math.nan
    springs = math.exp(float(np.interp(math.log(mesh["nodes"]), points, differences)))
    times = (springs - error) / (mesh["difference"] + error)
    return mesh["nodes"] * found.points.shape[1], times


def _reasons(found: Comparison) -> tuple[str, ...]:
    """Name the features of a case that elements represent better than springs."""
    domain, away = found.case.problem.domain, found.displacement
    away = away - found.reference.displacement.value
    worst = int(np.linalg.norm(away, axis=1).argmax())
    own, total = away[worst] @ found.support[worst], away[worst] @ away[worst]
    walls = _thickest(found.springs[0])
    fits = {
        "a support that no line of the lattice runs along": own >= MAIN * total,
        f"{walls:.2g} cells across where the body is thickest": walls <= THIN,
        "a corner that points inwards": len(getattr(domain, "reentrant", ())) > 0,
        "stress at points differs": any(
            row.word == DIFFERS and row.of == POINT_STRESS for row in found.rows
        ),
    }
    return tuple(why for why, fit in fits.items() if fit)


def _thickest(answer: SpringAnswer) -> float:
    """Cells across a body where it is thickest; of a mesh in space to about a cell."""
    lattice, domain, h = answer.lattice, answer.lattice.domain, answer.spacing
    if isinstance(domain, Box):
        return min(domain.size) / h
    if domain.dim == 2:
        return 2 * float(shapely.maximum_inscribed_circle(outline(domain)).length) / h
    if not isinstance(lattice, PatternLattice):
        return math.inf
    inner = answer.surrounded
    if not inner.any():
        return 1.0
    depth = KDTree(lattice.points[~inner]).query(lattice.points[inner])[0].max()
    return 2 * float(depth) / h + 1


def need_rows(chosen: Choice, unit: str) -> list[tuple[str, ...]]:
    """Texts of what the targets take, of springs and of elements, in the columns `HEADS`."""
    springs = chosen.springs or (None,) * len(chosen.elements)
    return [
        (percent(mesh.target), *_spring_texts(need, unit), *_element_texts(mesh))
        for need, mesh in zip(springs, chosen.elements, strict=True)
    ]


def choice_sentences(chosen: Choice, unit: str = "m") -> tuple[str, ...]:
    """Describe the springs and elements that reach each target."""
    lines = []
    for target, *texts in need_rows(chosen, unit):
        spacing, springs, time, nodes, more = texts
        counts = f", {springs} springs, {time}" if springs else ""
        mesh = f"{nodes}, {more}" if more else nodes
        lines.append(f"Estimated for {target}, springs: {spacing}{counts}; elements: {mesh}.")
    if chosen.no_coarser:
        lines.append(f"Coarser lattices are left out of this choice: {chosen.no_coarser}.")
    return tuple(lines)


def _spring_texts(need: Need | None, unit: str) -> tuple[str, str, str]:
    """Spacing, number of springs and time that a target takes."""
    if need is None or need.where == NONE:
        return "of the mesh" if need is None else "no spacing does", "", ""
    spacing = quantity_text(need.spacing, "m", unit)
    if need.where == BRIDGED:
        return f"resolve the gap of {spacing} first", "", ""
    if not need.count:
        return f"finer than tried {spacing}".rstrip(), "", ""
    more = {COARSEST: " or larger", BEYOND: ", not tried"}.get(need.where, "")
    if not math.isnan(need.least):
        low, high = (quantity_text(each, "m", unit).split()[0] for each in (need.least, need.most))
        more += f" ({low} to {high})"
    return f"{spacing}{more}", f"{need.count:,}", duration(need.seconds)


def _element_texts(need: Need) -> tuple[str, str]:
    """Number of nodes and time that a target takes."""
    if not need.count:
        return "finer than tried", ""
    fewer = " or fewer" if need.where == COARSEST else ""
    return f"{need.count:,} nodes{fewer}", duration(need.seconds)
