"""The cases of the study `lattices`: every lattice that is known, under each of its rules."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from scipy.sparse import coo_array
from scipy.sparse.linalg import eigsh

from msvalidate import kit
from msvalidate.springs.constants.homogenise import Homogenised, homogenise
from msvalidate.springs.lattice import Constants, Lattice, Pattern, PatternLattice, fill, patterns

Solid = Callable[..., Homogenised]
"""From a pattern, its constants (N/m) and a spacing (m) to the solid that it is."""
STIFF = 1e-10
"""Energy of a strain, relative to that of the stiffest, below which it costs none."""
NEAR_CUBE = 0.25
"""Part by which the edges of a box may differ."""
STANDS = "stands"
TRIED = {2: 4, 3: 2}
"""Cells along an edge, about, of the body that is tried whether it stands."""
SHIFT = 1e-3
"""Below the stiffness 0 of a free motion, where its matrix can be factored; per spring constant."""
FREE = 1e-9
"""Stiffness of a motion, per spring constant, that is rounding; slow waves have 1e-3 and more."""
LINES = ("-", "--", "-.", (0, (1, 1)))
"""Of the cases in a figure, a round of colours each."""
MOVED = 1e-9
"""Part of the affine tensor that points release by moving, above which it is no rounding."""
MOST_CELLS = 12
"""Cells along an edge of the smallest box that is looked for."""


class Case(NamedTuple):
    """A lattice, by the name of its function, and one of its rules: what workers are handed."""

    lattice: str
    rule: str

    @property
    def pattern(self) -> Pattern:
        """What repeats."""
        known = patterns.all_patterns()
        if self.lattice not in known:
            raise kit.ProblemError(f"lattice: {self.lattice!r}; choose from {', '.join(known)}")
        return known[self.lattice]()

    @property
    def constants(self) -> Constants:
        """Spring constants (N/m), one a kind."""
        rules = self.pattern.rules
        if self.rule not in rules:
            raise kit.ProblemError(
                f"{self.lattice}: rule {self.rule!r}; choose from {', '.join(rules)}"
            )
        return rules[self.rule]

    @property
    def head(self) -> dict[str, object]:
        """The first columns of its rows."""
        return {"lattice": self.pattern.name, "rule": self.rule}


def all_cases() -> list[Case]:
    """Every known lattice under each of its rules, those of the plane first."""
    found = [(make().dim, name, make().rules) for name, make in patterns.all_patterns().items()]
    found.sort(key=lambda entry: entry[0])
    return [Case(name, rule) for _, name, rules in found for rule in rules]


def resists_shear(tensor: kit.Array) -> str:
    """Whether every strain costs energy, in words."""
    values, modes = np.linalg.eigh(tensor)
    free = modes[:, values <= STIFF * max(values[-1], np.finfo(float).tiny)]
    if not free.shape[1]:
        return "every strain"
    normal = 2 if len(tensor) == 3 else 3
    return "gives way" if np.abs(free[:normal]).max() > STIFF else "shears freely"


def stiff(solid: Solid = homogenise) -> list[Case]:
    """The cases whose solid resists every strain and whose bodies stand."""
    return [case for case in all_cases() if body(solid, case) == STANDS]


def body(solid: Solid, case: Case) -> str:
    """Whether a body can be made of a case and stands under a load, or why not, in words."""
    if resists_shear(tensor_of(solid, case)) != "every strain":
        return "no body"
    pattern = case.pattern
    if not (np.abs(pattern.points) <= STIFF * np.array(pattern.size)).all(axis=1).any():
        return "no corner point"
    try:
        lattice = fill_box(case, TRIED[pattern.dim])
    except kit.ProblemError:
        return "no box"
    return STANDS if is_stable(case, lattice) else "mechanism"


def is_stable(case: Case, lattice: Lattice) -> bool:
    """Whether a piece of lattice resists every motion but those of a rigid body."""
    m, (n, d) = len(lattice.springs), lattice.points.shape
    vector = lattice.vectors
    k = np.array(case.constants)[lattice.kind] * lattice.factor
    way = vector * (np.sqrt(k / k.max()) / np.linalg.norm(vector, axis=1))[:, None]
    place = lattice.springs[:, :, None] * d + np.arange(d)  # (m, 2, d) of ends in a row of motion
    row = np.broadcast_to(np.arange(m)[:, None, None], place.shape)
    ends = (np.stack([-way, way], axis=1).ravel(), (row.ravel(), place.ravel()))
    stretch = coo_array(ends, shape=(m, n * d)).tocsc()
    rigid = d * (d + 1) // 2
    start = np.random.default_rng(0).normal(size=n * d)
    least = eigsh(stretch.T @ stretch, rigid + 1, sigma=-SHIFT, v0=start, return_eigenvectors=False)
    return bool(least.max() > FREE)


def tensor_of(solid: Solid, case: Case, spacing: float = 1.0) -> kit.Array:
    """Voigt tensor, (3, 3) in N/m or (6, 6) in Pa, of a case at a spacing (m), points at rest."""
    return solid(case.pattern, case.constants, spacing).tensor


def fill_box(case: Case, across: int) -> PatternLattice:
    """A box of whole cells, nearly a unit square or cube, about so many cells along its edges."""
    pattern = case.pattern
    base = proportions(pattern.size)
    cells = np.array(base) * max(1, round(across / max(base)))
    edges = cells * pattern.size
    return fill(pattern, kit.Box(tuple((edges / edges.max()).tolist())), tuple(cells.tolist()))


def sizes(case: Case, wanted: tuple[int, ...]) -> list[int]:
    """As many different sizes (cells along the box's edges, ascending) as wanted, and nearly those.

    Bodies are multiples of a base, so a size that the base skips would be a body twice.
    """
    base, found = max(proportions(case.pattern.size)), [0]
    for across in wanted:
        found.append(max(found[-1] + 1, round(across / base)))
    return [times * base for times in found[1:]]


def box_of(lattice: Lattice) -> kit.Box:
    """The box that a lattice fills."""
    if not isinstance(lattice.domain, kit.Box):
        raise kit.ProblemError(f"{lattice.name} lattice in a {lattice.domain}; fill a box")
    return lattice.domain


def cells_along(lattice: Lattice) -> int:
    """Cells along the x axis of a box."""
    if not isinstance(lattice, PatternLattice):
        raise kit.ProblemError(f"{lattice.name} lattice: no piece of a pattern; give one that is")
    return round(box_of(lattice).size[0] / (lattice.spacing * lattice.pattern.size[0]))


def proportions(size: tuple[float, ...]) -> tuple[int, ...]:
    """Fewest cells along each axis that make a box with nearly equal edges."""
    best, least = (1,) * len(size), np.inf
    for count in range(1, MOST_CELLS + 1):
        cells = np.maximum(1, np.round(count * min(size) / np.array(size))).astype(int)
        edges = cells * size
        spread = float(edges.max() / edges.min() - 1)
        if spread < least - STIFF:
            best, least = tuple(cells.tolist()), spread
        if least <= NEAR_CUBE:
            break
    return best


def material(solid: Solid, case: Case, lattice: PatternLattice) -> kit.Anisotropic:
    """The elastic body that a piece of lattice stands for.

    Raises
    ------
    SolverError
        If some strain of it costs no energy.
    """
    tensor = tensor_of(solid, case, lattice.spacing)
    if resists_shear(tensor) != "every strain":
        raise kit.SolverError(
            f"{lattice.name}, {case.rule}: {resists_shear(tensor)}; no body to compare"
        )
    return kit.Anisotropic(tensor)


def support_releases(solid: Solid, case: Case) -> bool:
    """Whether points move inside a cell under uniform strain: less stiff than the affine bound."""
    found = solid(case.pattern, case.constants, 1.0)
    return bool(np.abs(found.affine - found.tensor).max() > MOVED * np.abs(found.affine).max())


def springs_a_point(case: Case) -> float:
    """Springs with stiffness that meet at a point, on average."""
    pattern = case.pattern
    stiffness = pattern.stiffness(case.constants)
    return float(2 * (stiffness > 0).sum() / len(pattern.points))


def numbers(column: str) -> Callable[[pd.DataFrame], Any]:
    """What reads the numbers of a column without its words; NaN, which fails, where none is."""

    def read(rows: pd.DataFrame) -> Any:
        found = pd.to_numeric(rows[column], errors="coerce").dropna()
        return found if len(found) else math.nan

    return read


def style(number: int) -> dict[str, Any]:
    """How the case of a number is drawn, in every figure the same; of 24 no two are alike.

    After each round of the colours every colour has its next marker and its next line.
    """
    around = number // len(kit.figures.COLOURS)
    return {
        "marker": kit.figures.MARKERS[(number + around) % len(kit.figures.MARKERS)],
        "color": kit.figures.COLOURS[number % len(kit.figures.COLOURS)],
        "linestyle": LINES[around % len(LINES)],
    }
