"""Critical stretch of the springs of a lattice for a given fracture energy.

By rule "springs": springs that cross a crack of normal n hold ½ s² Σ k L² |r·n|/A together when all
are at the critical stretch s, r their vectors and A the area that has each once. But a spring that
breaks takes along what the body around it gives up: a crack grows only at a multiple of that.

By rule "growth": a disc of the lattice whose rim is held at the field of a crack under a stress
intensity K ([Irwin1958]), raised until the crack has grown by one period of the lattice. The
largest of the K on the way counts, extrapolated in the disc's radius: lattice trapping,
[ThomsonHsiehRana1971], [Slepyan2002].
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from msvalidate.problem import Array, Index, Mask, ProblemError
from msvalidate.problem.checks import (
    finite,
    length_in_metres,
    positive_number,
    require_one_of,
    require_type,
)
from msvalidate.problem.records import dataclass
from msvalidate.springs.constants.calibration import Calibration
from msvalidate.springs.constants.homogenise import homogenise
from msvalidate.springs.constants.stiffness import moduli
from msvalidate.springs.lattice import Constants, Pattern
from msvalidate.springs.lattice.filled import number_springs
from msvalidate.springs.lattice.turned import rotation_matrix
from msvalidate.springs.network import Network, spring_network
from msvalidate.springs.statics.breaking import propagate_crack

RULES = ("growth", "springs")
RADII = (20, 40)
"""Radii of the disc, in spacings, for an extrapolation accurate to 0.2 %."""
BEHIND = 0.3
"""Distance behind the tip, in spacings, up to which crossing springs start cut."""
CELLS = 6
"""Number of unit cells in which the period of a row is searched."""
ISOTROPIC = 1e-6
"""Largest deviation of the Zener ratio from 1 for isotropic crack fields."""
AT_MOST = 1e12
"""Maximum stress intensity of the load path, always beyond that of growth.

The spacing and the largest spring constant are 1 there.
"""


@dataclass(frozen=True, eq=False)
class Toughness:
    """When springs of a lattice are to break.

    Parameters
    ----------
    critical_stretch
        Elongation over rest length, by the rule. It falls as the spacing's root: no constant of
        the material.
    rule, direction
        As in `critical_stretch`.
    ratio
        Fracture energy at which a crack in that direction grows over what the springs hold: the
        critical stretch by rule "springs" over that by "growth" is its root. 1 by rule "springs",
        which does not look at growth.
    first
        The same at which the crack's first spring breaks.
    """

    critical_stretch: float
    rule: str
    direction: tuple[float, ...]
    ratio: float
    first: float


@dataclass(frozen=True, eq=False)
class CrackPatch:
    """A crack in a disc of a lattice.

    Parameters
    ----------
    network
        Its rim held at the displacement of K = 1.
    stretch
        (m,) critical stretch of each spring.
    crossing
        (m,) where (in spacings) a spring crosses the crack's line ahead of its tip, NaN of others.
    ahead
        (m,) springs that must break until the crack has grown by a period.
    """

    network: Network
    stretch: Array
    crossing: Array
    ahead: Mask


def critical_stretch(
    pattern: Pattern,
    constants: Constants | Calibration,
    G_c: float,
    *,
    spacing: float = 1.0,
    thickness: float = 1.0,
    direction: ArrayLike = (1.0, 0.0),
    rule: str = "growth",
) -> Toughness:
    """Stretch at which a plane lattice's springs break, so that it has a fracture energy.

    Parameters
    ----------
    pattern, constants
        What repeats, and its spring constants (N/m), of an isotropic solid by springs alone.
    G_c
        Fracture energy (J/m²) of the material.
    spacing, thickness
        Length (m) of the pattern's unit, and of the body across its plane; those of a calibration
        are its own.
    direction
        In which the crack runs, along a row of the lattice.
    rule
        "growth": a crack in that direction grows at `G_c`. "springs": the springs across it hold
        `G_c` when they break, which is what formulas in use ask for; the crack grows at more.

    Raises
    ------
    ProblemError
        If constants are not isotropic, cells stand beside the springs, or the crack would not stay
        in its plane.
    """
    require_type("pattern", pattern, Pattern)
    if pattern.dim != 2:
        raise ProblemError(f"{pattern.name}: critical stretch of a lattice in space; give a plane")
    require_one_of("rule", rule, RULES)
    if isinstance(constants, Calibration):
        if constants.volume or constants.pressure:
            raise ProblemError(
                f"{pattern.name}: cells beside the springs, which do not break; take square-8 or "
                "triangular at ratio 1/3 in plane stress, 1/4 in plane strain"
            )
        spacing, thickness = constants.spacing, constants.thickness
        constants = constants.constants
    a = length_in_metres("spacing", spacing)
    energy = positive_number("G_c", G_c, "J/m²") * positive_number("thickness", thickness, "m")
    way = finite("direction", direction, 2)
    if not way.any():
        raise ProblemError("direction: (0, 0); give a vector along a row of the lattice")
    along = tuple((way / np.linalg.norm(way)).tolist())
    k, ratios = pattern.stiffness(constants), np.ones(1)
    if rule == "growth":
        ratios = _growth(pattern, constants, along)
    stretch = math.sqrt(energy / (a * springs_energy(pattern, k, along) * ratios.max()))
    return Toughness(stretch, rule, along, float(ratios.max()), float(ratios[0]))


def _growth(pattern: Pattern, constants: Constants, along: tuple[float, ...]) -> Array:
    """Energy release rate at each event over what springs across hold, in the field of a crack."""
    made = moduli(homogenise(pattern, constants).tensor)
    if not abs(made.zener - 1) <= ISOTROPIC:
        raise ProblemError(
            f"{pattern.name}: constants {tuple(constants)} make no isotropic solid (Zener "
            f"ratio {made.zener:.6g}), so a crack has another field; take those of `calibrate`"
        )
    k = pattern.stiffness(constants)
    k, E = k / k.max(), made.E / k.max()  # no ratio depends on it, and K is of the order of 1
    K = starts(lambda radius: crack_patch(pattern, k, along, E, made.nu, radius))
    return np.asarray(K**2 / E / springs_energy(pattern, k, along))


def springs_energy(pattern: Pattern, stiffness: Array, direction: tuple[float, ...]) -> float:
    """Energy (J/m) per length of crack of the springs that cross it.

    They have a stretch of 1, at a spacing of 1 m.

    Times the spacing and the square of the stretch it is that of any lattice.
    """
    r = pattern.vectors
    across = np.abs(r @ (-direction[1], direction[0]))
    total = stiffness @ ((r**2).sum(axis=1) * across)
    return float(total) / (2 * math.prod(pattern.size))


def starts(patch: Callable[[int], CrackPatch], radii: tuple[int, int] = RADII) -> Array:
    """Stress intensity at each event until the crack has grown by a period, extrapolated.

    The squares in the inverse of the radius, to which they are linear: the rim is as far away.

    Raises
    ------
    ProblemError
        If a spring outside the crack's plane breaks, the crack does not grow, or different springs
        break in the two discs.
    """
    (a, coarse), (b, fine) = ((radius, _events(patch(radius))) for radius in radii)
    if [places for places, _ in coarse] != [places for places, _ in fine]:
        raise ProblemError(
            f"crack: other springs break in discs of radius {a} and {b}; take rule 'springs'"
        )
    squares = b * np.array([K for _, K in fine]) ** 2 - a * np.array([K for _, K in coarse]) ** 2
    return np.asarray(np.sqrt(squares / (b - a)))


def _events(patch: CrackPatch) -> list[tuple[tuple[float, ...], float]]:
    """Positions of springs that break together, and the load factors."""
    network, left = patch.network, patch.ahead.copy()
    found: list[tuple[tuple[float, ...], float]] = []
    way = propagate_crack(network, patch.stretch, AT_MOST, most_breaks=3 * int(left.sum()))
    for one in way.breaks:
        place = patch.crossing[one.springs]
        if np.isnan(place).any():
            i, j = network.springs[one.springs[np.isnan(place)][0]]
            ends = " to ".join(str(network.points[p].round(3).tolist()) for p in (i, j))
            raise ProblemError(
                f"crack: it leaves its plane, for the spring from {ends} breaks (in spacings from "
                "the tip, x along the crack); take a direction along another row, or rule 'springs'"
            )
        found.append((tuple(sorted(np.round(place, 6).tolist())), one.needed))
        left[one.springs] = False
        if not left.any():
            return found
    raise ProblemError("crack: it does not grow in its plane; take rule 'springs'")


def crack_patch(
    pattern: Pattern, k: Array, along: tuple[float, ...], E: float, nu: float, radius: int
) -> CrackPatch:
    """Crack between two rows of a lattice of spacing 1, with K = 1.

    The asymptotic field is prescribed on the rim.

    `k` (m,) are the pattern's springs, E (N/m) and nu what they make.
    """
    Q = rotation_matrix(-math.atan2(along[1], along[0]), 2)
    reach = float(np.linalg.norm(pattern.vectors, axis=1).max())
    half = np.ceil((radius + 2 * reach) / np.array(pattern.size)).astype(int) + 1
    cell = np.stack(
        np.meshgrid(
            np.arange(-half[1], half[1] + 1), np.arange(-half[0], half[0] + 1), indexing="ij"
        )[::-1],
        axis=-1,
    )[..., None, :]
    place = (cell * np.array(pattern.size) + pattern.points) @ Q.T
    period = _period(pattern, Q)
    place = place - _tip(place.reshape(-1, 2), reach)
    kept = np.linalg.norm(place, axis=-1) <= radius + reach
    number = np.full(kept.shape, -1)
    number[kept] = np.arange(int(kept.sum()))
    springs, which = number_springs(pattern, number)
    x = place[kept]
    at = crossings(x, springs)
    behind, ahead = at < -BEHIND, at >= -BEHIND
    rim = np.linalg.norm(x, axis=1) >= radius
    held = np.repeat(rim[:, None], 2, axis=1)
    network = spring_network(
        x,
        springs,
        np.where(behind, 0.0, k[which]),
        fixed=held,
        displacement=np.where(held, crack_field(x, E, nu), 0.0),
    )
    fixed = rim[springs].all(axis=1)
    return CrackPatch(
        network,
        np.where(fixed, np.inf, 1.0),
        np.where(ahead, at, np.nan),
        ahead & (at < period - BEHIND),
    )


def crossings(points: Array, springs: Index, height: float = 0.0) -> Array:
    """Positions (m,) in m along x where springs (m, 2) cross a height, or NaN.

    The points are (n, 2) in m.
    """
    (x, y), (x_end, y_end) = points[springs].transpose(1, 2, 0)
    with np.errstate(divide="ignore", invalid="ignore"):
        at = x + (height - y) * (x_end - x) / (y_end - y)
    return np.where((y - height) * (y_end - height) < 0, at, np.nan)


def _period(pattern: Pattern, Q: Array) -> float:
    """Length of the shortest translation along the crack; refused where there is none."""
    n = np.arange(-CELLS, CELLS + 1)
    each = np.stack(np.meshgrid(n, n), axis=-1).reshape(-1, 2) * np.array(pattern.size) @ Q.T
    on = each[(np.abs(each[:, 1]) <= 1e-9) & (each[:, 0] > 1e-9)]
    if not len(on):
        raise ProblemError(
            f"direction: along no row of the {pattern.name} lattice within {CELLS} cells; take "
            "one, such as (1, 0), or rule 'springs'"
        )
    return float(on[:, 0].min())


def _tip(x: Array, reach: float) -> Array:
    """Place (2,) halfway between two rows, where they are farthest apart, below a point."""
    near = x[np.abs(x).max(axis=1) <= 6 * reach]
    level = np.unique(np.round(near[:, 1], 9))
    level = level[np.abs(level) <= 3 * reach]
    gap = np.diff(level)
    widest = np.flatnonzero(gap >= gap.max() - 1e-6)
    low = int(widest[np.abs(level[widest]).argmin()])
    above = near[np.abs(near[:, 1] - level[low + 1]) <= 1e-6]
    return np.array([above[np.abs(above[:, 0]).argmin(), 0], (level[low] + level[low + 1]) / 2])


def crack_field(x: Array, E: float, nu: float) -> Array:
    """Displacement (n, 2) at places around an opening crack tip with K = 1.

    The crack lies along x < 0.

    `E` and `nu` are those of the plane: K²/E is the energy release rate.

    Source: [Irwin1958].
    """
    r, angle = np.hypot(*x.T), np.arctan2(x[:, 1], x[:, 0])
    kappa, mu = (3 - nu) / (1 + nu), E / (2 * (1 + nu))
    c, s = np.cos(angle / 2), np.sin(angle / 2)
    size = np.sqrt(r / (2 * np.pi)) / (2 * mu)
    return np.column_stack([size * c * (kappa - 1 + 2 * s**2), size * s * (kappa + 1 - 2 * c**2)])
