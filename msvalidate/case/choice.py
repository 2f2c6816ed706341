"""Which spacing and which mesh 5 % and 1 % take, and where elements do better at the same cost.

Near a target the difference of springs from elasticity is a power of their spacing: a straight line
through the logarithms of what was solved, and of coarser lattices where all of that is better than
the target; the nearer to the target, the more a lattice counts. What is advised is a number of
cells that a case takes, of lattices like those solved: filled or cut to the body, which err
differently. Cost is the number of unknowns, components of all points or nodes: the same on every
machine.
"""

from __future__ import annotations

import math
from contextlib import suppress
from typing import Any

import numpy as np

from msvalidate.case.budget import lattice_row, mesh_rows
from msvalidate.case.case import (
    MESH_EDGES,
    MOST_ASKED,
    Case,
    compared_points,
    is_filled,
    make_lattice,
    spacing_by_cells,
    spacing_of,
)
from msvalidate.case.comparison import Comparison
from msvalidate.case.springs import solve_springs
from msvalidate.lattice.outline import outline
from msvalidate.linear_algebra.norms import max_length
from msvalidate.problem import Array, Box, Domain, ProblemError, SolverError
from msvalidate.problem.domain import SIDES
from msvalidate.problem.records import dataclass, replace
from msvalidate_check.words import DIFFERS

TARGETS = (0.05, 0.01)
"""Differences, over the largest displacement, for which a spacing is sought."""
NEAR = 4.0
"""Factor between difference and target at which a lattice counts less by e."""
ORDERS, ORDER_DOUBT = (0.5, 3.0), 0.3
"""Of the spacing: orders that are believed, and what one may be off beyond what was solved."""
UNCERTAIN = 4.0
"""Factor that a spacing may be off from which it is called uncertain."""
ALIKE, TRIED = 1.5, 30
"""Factor from a wanted spacing within which a lattice must lie, and how many are looked at."""
GROWTH = 1.2
"""Exponent of the springs that seconds grow with."""
BETTER = 3.0
"""Times by which elements are nearer at equal cost, from which they are advised."""
MAIN, THIN = 0.5, 6.0
"""Part of the difference that is most of it, and cells across a wall that is thin."""
BETWEEN, BEYOND, COARSEST, NONE = "between", "beyond", "coarsest", "none"
"""Where a target's spacing lies: between those solved; beyond the finest; it is met by the coarsest
that there is; or no spacing meets it."""


@dataclass(frozen=True)
class Spacing:
    """The spacing that a target takes.

    Parameters
    ----------
    target, where
        Difference over the largest displacement, and where its spacing lies.
    cells, spacing
        For a case's `cells`, and the spacing (m) that comes of it; 0 cells where none can be laid.
    least, most
        Spacings (m) between which the target's may lie.
    springs, seconds
        Of that lattice.
    """

    target: float
    where: str
    cells: int = 0
    spacing: float = math.nan
    least: float = math.nan
    most: float = math.nan
    springs: int = 0
    seconds: float = math.nan

    @property
    def uncertain(self) -> bool:
        """Whether it may be off by a factor of `UNCERTAIN` or more."""
        return max(self.most / self.spacing, self.spacing / self.least) >= UNCERTAIN


@dataclass(frozen=True)
class Nodes:
    """The first mesh that met a target, 0 nodes where none did; fewer may do if it is the coarsest.

    Parameters
    ----------
    target, nodes, seconds, coarsest
        Difference over the largest displacement, and the mesh.
    """

    target: float
    nodes: int = 0
    seconds: float = math.nan
    coarsest: bool = False


@dataclass(frozen=True)
class Choice:
    """What to take for each target.

    Parameters
    ----------
    spacings, meshes
        One a target; no spacings for springs on a mesh's edges.
    unknowns, times
        At how many unknowns elements are how many times nearer than springs; NaN if not known.
    reasons
        Why they are, as far as the case shows it.
    """

    spacings: tuple[Spacing, ...]
    meshes: tuple[Nodes, ...]
    unknowns: int
    times: float
    reasons: tuple[str, ...]

    @property
    def use_elements(self) -> bool:
        """Whether elements are `BETTER` at equal cost."""
        return self.times >= BETTER


def choose(found: Comparison) -> Choice:
    """What targets take in a case, from what was solved and lattices that are coarser."""
    rows, meshes = _lattices(found), mesh_rows(found)
    spacings = () if found.case.lattice == MESH_EDGES else TARGETS
    return Choice(
        tuple(_spacing(found, rows, target) for target in spacings),
        tuple(_nodes(meshes, found.reference.error, target) for target in TARGETS),
        *_equal_cost(found, rows, meshes),
        _reasons(found),
    )


def _lattices(found: Comparison) -> list[dict[str, Any]]:
    """Lattices from coarse to fine, with coarser ones until the largest target is between them."""
    wanted, at = found.reference.displacement.value, found.reference.finest.at
    rows = [lattice_row(found, answer, found.points, wanted) for answer in found.springs]
    with suppress(ProblemError, SolverError):  # coarser ones are then fewer
        while found.case.lattice != MESH_EDGES and _column(rows, "difference").max() < max(TARGETS):
            laid = _laid(found, 2 * rows[0]["spacing"])
            if laid is None or spacing_of(laid) < ALIKE * rows[0]["spacing"]:
                break
            answer = solve_springs(laid, spacing_of(laid))
            points = compared_points(laid, answer.lattice)
            rows.insert(0, lattice_row(found, answer, points, at(points)))
    return rows


def _column(rows: list[dict[str, Any]], name: str) -> Array:
    return np.array([row[name] for row in rows], dtype=float)


def _laid(found: Comparison, wanted: float) -> Case | None:
    """The case at the number of cells nearest to a spacing (m), laid as it was if it can be."""
    case, filled = found.case, is_filled(found.case, found.springs[0].spacing)
    one = spacing_by_cells(replace(case, cells=1, spacing=None)) / wanted
    many = sorted(range(1, math.ceil(ALIKE * one) + 1), key=lambda n: abs(n - one))[:TRIED]
    near = []
    for cells in many:
        laid = replace(case, cells=cells, spacing=None)
        far = abs(math.log(spacing_of(laid) / wanted))
        if far <= math.log(ALIKE):
            near.append((is_filled(laid, spacing_of(laid)) != filled, far, cells, laid))
    return min(near)[-1] if near else None


def _spacing(found: Comparison, rows: list[dict[str, Any]], target: float) -> Spacing:
    """The spacing that a target takes."""
    wanted, size = found.reference.displacement.value, found.size or 1.0
    left = max_length(found.limit.displacement - wanted) - found.limit.uncertainty
    if found.homogenised:
        left = max(left, max_length(found.homogenised.displacement.value - wanted))
    if left / size - found.reference.error > target:
        return Spacing(target, NONE)
    s, e = np.log(_column(rows, "spacing")), np.log(_column(rows, "difference"))
    t = math.log(target)
    if len(rows) == 1 or (e <= t).all():
        where = COARSEST if (e <= t).all() else BEYOND
        return _costed(found, rows, Spacing(target, where, spacing=math.exp(s[0])))
    weight = np.exp(-(((e - t) / math.log(NEAR)) ** 2))
    middle_s, middle_e = np.average([s, e], axis=1, weights=weight)
    order = (weight * (s - middle_s) * (e - middle_e)).sum()
    order = np.clip(order / (weight * (s - middle_s) ** 2).sum(), *ORDERS)
    best = middle_s + (t - middle_e) / order
    ends = [best, s[e > t].min()]
    if (e > t).all():
        slow_fast = np.clip([order - ORDER_DOUBT, order + ORDER_DOUBT], *ORDERS)
        ends, where = [best, *(s[-1] + (t - e[-1]) / slow_fast)], BEYOND
    else:
        ends, where = [best, s[e > t].min(), s[e <= t].max()], BETWEEN
    least, most = math.exp(min(ends)), math.exp(max(ends))
    return _costed(found, rows, Spacing(target, where, 0, math.exp(best), least, most))


def _costed(found: Comparison, rows: list[dict[str, Any]], wanted: Spacing) -> Spacing:
    """What can be laid near a wanted spacing, and what it costs."""
    laid, dim = _laid(found, wanted.spacing), found.case.problem.domain.dim
    if laid is None or found.case.problem.domain.volume / spacing_of(laid) ** dim > MOST_ASKED[dim]:
        return wanted
    spacing = spacing_of(laid)
    finest = rows[-1]
    if spacing >= finest["spacing"]:
        springs = len(make_lattice(laid, spacing).springs)
    else:
        springs = round(finest["springs"] * (finest["spacing"] / spacing) ** dim)
    # The lattice asked for was solved first: its seconds are of loading and compiling too.
    timed = [row for row in rows if row["seconds"] != found.springs[0].seconds] or rows
    near = min(timed, key=lambda row: abs(math.log(row["springs"] / springs)))
    seconds = near["seconds"] * (springs / near["springs"]) ** GROWTH
    return replace(wanted, cells=laid.cells or 0, spacing=spacing, springs=springs, seconds=seconds)


def _nodes(meshes: list[dict[str, Any]], error: float, target: float) -> Nodes:
    """The first mesh that met a target."""
    for number, mesh in enumerate(meshes):
        if mesh["difference"] + error <= target:
            return Nodes(target, mesh["nodes"], mesh["seconds"], coarsest=not number)
    return Nodes(target)


def _equal_cost(
    found: Comparison, rows: list[dict[str, Any]], meshes: list[dict[str, Any]]
) -> tuple[int, float]:
    """Unknowns of the mesh nearest in cost to the springs asked for, and how much nearer it is."""
    points, differences = np.log(_column(rows, "points")), np.log(_column(rows, "difference"))
    asked = len(found.springs[0].lattice.points)
    mesh = min(meshes, key=lambda each: abs(math.log(each["nodes"] / asked)))
    if math.log(mesh["nodes"]) > points[-1]:
        return 0, math.nan
    springs = math.exp(float(np.interp(math.log(mesh["nodes"]), points, differences)))
    error = found.reference.error
    times = (springs - error) / (mesh["difference"] + error)
    return mesh["nodes"] * found.points.shape[1], times


def _reasons(found: Comparison) -> tuple[str, ...]:
    """What in a case elements do better than springs."""
    domain, away = found.case.problem.domain, found.displacement
    away = away - found.reference.displacement.value
    worst = away[int(np.linalg.norm(away, axis=1).argmax())]
    own = found.support[int(np.linalg.norm(away, axis=1).argmax())]
    walls = 2 * domain.volume / _surface(domain) / found.springs[0].spacing
    stress = any(r.verdict == DIFFERS and r.quantity.startswith("stress at") for r in found.rows)
    fits = {
        "a support that no line of the lattice runs along": own @ worst >= MAIN * (worst @ worst),
        f"walls {walls:.2g} cells thick": walls < THIN,
        "a corner that points inwards": len(getattr(domain, "reentrant", ())) > 0,
        "stress is asked for": stress,
    }
    return tuple(why for why, fit in fits.items() if fit)


def _surface(domain: Domain) -> float:
    """Length (m) of a plane body's outline, area (m²) of a solid's surface."""
    if domain.dim == 2:
        return float(outline(domain).length)
    if isinstance(domain, Box):
        return math.fsum(domain.side(name).measure(domain.span) for name in SIDES)
    return domain.whole_surface.measure(domain.span)  # type: ignore[union-attr]


def choice_sentences(chosen: Choice) -> tuple[str, ...]:
    """What to take, in words."""
    lattices = [f"for {100 * each.target:g} %: {_lattice_words(each)}" for each in chosen.spacings]
    meshes = [f"for {100 * each.target:g} %: {_mesh_words(each)}" for each in chosen.meshes]
    said = [f"Springs {'; '.join(lattices)}."] if lattices else []
    said.append(f"Elements {'; '.join(meshes)}.")
    if chosen.use_elements:
        why = f": {', '.join(chosen.reasons)}" if chosen.reasons else ""
        said.append(
            f"Use elements: at {chosen.unknowns:,} unknowns they are {chosen.times:.2g} times "
            f"nearer than springs{why}."
        )
    return tuple(said)


def _lattice_words(each: Spacing) -> str:
    if each.where == NONE:
        return "no spacing does"
    if not each.cells:
        return "more cells than can be laid" if each.least else "not known from one lattice"
    said = f"cells = {each.cells} ({each.spacing:.3g} m), {each.springs:,} springs, "
    said += f"{each.seconds:.2g} s"
    between = f"{each.least:.2g} to {each.most:.2g} m"
    if each.uncertain:
        return f"uncertain, {between}, perhaps {said}"
    if each.where == COARSEST:
        return f"{said}, or coarser if that can be laid"
    return f"{said}, finer than was solved ({between})" if each.where == BEYOND else said


def _mesh_words(each: Nodes) -> str:
    if not each.nodes:
        return "more nodes than were tried"
    return f"{'at most ' if each.coarsest else ''}{each.nodes:,} nodes, {each.seconds:.2g} s"
