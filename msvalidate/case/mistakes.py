"""Catalogue of known mistakes, each with a model that is solved on the body in question.

A mistake is a record: its kind, its model, and its sentence, which is the phrase of that kind in
`msvalidate_check.causes.PHRASES`. `advise`, `case judge`, `case run`, `simulate` and `adapter
check` use this one catalogue, so a field is compared with what a mistake gives and none is guessed.
The kinds that change the size of the field alone (unit of k, thickness, load, modulus) and the
plane state need no model of their own: `msvalidate_check.scales` and `changes` have them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence

import numpy as np
from scipy.sparse import csc_array
from scipy.sparse.linalg import SuperLU, splu

from msvalidate.constants.homogenise import homogenise
from msvalidate.constants.routes import calibrate_by_route
from msvalidate.constants.stiffness import CAUCHY, moduli
from msvalidate.lattice import Constants, CutLattice, Lattice
from msvalidate.lattice.edges import EdgeLattice
from msvalidate.lattice.patterns import all_patterns
from msvalidate.network import Network
from msvalidate.network.configuration import Configuration
from msvalidate.problem import Array, Isotropic
from msvalidate.problem.records import dataclass, replace
from msvalidate_check.causes import PHRASES, Phrase, say
from msvalidate_check.mistakes import mistake_phrase

Factor = Callable[[Network], Array]
"""Displacement (n, d) in m of a network whose springs are those of a factor."""

MIN_PIVOT = 1e-12
"""Smallest pivot of a factor relative to the largest of a network that is stable."""
SAME = 1e-6
"""Relative difference up to which constants are the same: six digits, as people write them."""
REST_STEP = 1e-6
"""Relative change of rest lengths from which their first-order effect is taken."""
REST_RANGE = 0.5
"""Largest relative change of a rest length that is considered."""


@dataclass(frozen=True, eq=False)
class CorrectSprings:
    """Springs that stand for a material, which a mistake changes.

    Parameters
    ----------
    law, gravity
        The material, and the acceleration (d,) in m/s² that gives the masses their weight.
    lattice, network
        The points and springs of the body, and the network with supports and loads.
    constants
        Spring constants (N/m) by kind.
    spacing
        Spacing h (m).
    """

    law: Isotropic
    gravity: Array
    lattice: Lattice
    network: Network
    constants: Constants
    spacing: float

    def with_constants(self, constants: Constants, *, whole: bool) -> Network:
        """The network with other constants by kind; `whole`: springs on the boundary count 1.

        A mesh's edges have the right constants in their factors, which others do not get.
        """
        lattice = self.lattice
        k = np.asarray(constants, dtype=float)[lattice.kind]
        if isinstance(lattice, EdgeLattice):
            return replace(self.network, stiffness=k)
        inner = np.array([lattice.factor[lattice.kind == i].max() for i in range(lattice.kinds)])
        k *= inner[lattice.kind]
        if isinstance(lattice, CutLattice):
            share = lattice.factor / inner[lattice.kind]
        else:
            share = lattice.share
        return replace(self.network, stiffness=k * (1.0 if whole else share))


def bar_constant(law: Isotropic, spacing: float) -> float:
    """E·h in 3D and E·t in 2D, in N/m."""
    return law.E * (spacing if law.dim == 3 else law.thickness)


def own_constants(own: Constants, _bar: float) -> Constants:
    """The right constants."""
    return own


def doubled_diagonals(own: Constants, _bar: float) -> Constants:
    """Diagonals twice as stiff as the axes; further kinds as they are."""
    return (own[0], 2 * own[0], *own[2:])


def alike(own: Constants, bar: float) -> Constants:
    """E·h, or E·t, on every spring."""
    return (bar,) * len(own)


def axes_alone(own: Constants, bar: float) -> Constants:
    """E·h, or E·t, along the axes, and no other springs."""
    return (bar, *(0.0,) * (len(own) - 1))


OF_DIAGONALS = (doubled_diagonals, axes_alone)
"""Constants that other kinds of springs than the first have."""


@dataclass(frozen=True)
class SpringMistake:
    """A mistake that people make with springs.

    Parameters
    ----------
    kind
        Key of its sentence in `msvalidate_check.causes.PHRASES`.
    constants
        Constants by kind (N/m) from the right ones and `bar_constant`.
    whole
        Whether springs on the boundary count as much as those inside.
    mass
        "shared" by the cells around a point, which is right, "equal" on all points, or "double".
    rest
        Whether all springs, or those of other kinds than the first, have another rest length.
    scaled
        Whether it is a mistake in the ratio of constants, whose size is then fitted.
    """

    kind: str
    constants: Callable[[Constants, float], Constants] = own_constants
    whole: bool = False
    mass: str = "shared"
    rest: str = ""
    scaled: bool = False

    @property
    def beside(self) -> str:
        """Kind of the second mistake, if there are two."""
        return "whole boundary springs" if self.whole and self.has_other_constants else ""

    @property
    def simpler(self) -> str:
        """Kind of the mistake that it contains, where constants or rest lengths happen to fit."""
        return self.beside or ("coarse springs" if self.scaled or self.rest else "")

    @property
    def has_other_constants(self) -> bool:
        """Whether the constants are not the right ones; then no cell resists a change of volume."""
        return self.constants is not own_constants

    def network(self, springs: CorrectSprings) -> Network:
        """The network with this mistake; rest lengths are left to `rest_length_force`."""
        made = springs.network
        if self.has_other_constants or self.whole:
            bar = bar_constant(springs.law, springs.spacing)
            constants = self.constants(springs.constants, bar)
            made = springs.with_constants(constants, whole=self.whole)
        if self.has_other_constants:
            made = replace(made, volumes=None)
        mass = made.mass
        other = {"shared": mass, "equal": np.full(len(mass), mass.mean()), "double": 2 * mass}
        heavier = np.outer(other[self.mass] - mass, springs.gravity)
        return replace(made, mass=other[self.mass], force=made.force + heavier)

    def applies(self, kinds: int, *, heavy: bool) -> bool:
        """Whether it changes a static field, on so many kinds of springs and under weight.

        A mesh's edges are of 0 kinds: their constants have the part of the cells in them.
        """
        if self.mass != "shared":
            return heavy
        of_diagonals = self.rest == "diagonals" or self.constants in OF_DIAGONALS
        return kinds > (1 if of_diagonals else 0 if self.whole else -1)


SPRING_MISTAKES = (
    SpringMistake("coarse springs"),
    SpringMistake("whole boundary springs", whole=True),
    SpringMistake("k2 = 2 k1", doubled_diagonals, scaled=True),
    SpringMistake("k2 = 2 k1", doubled_diagonals, whole=True, scaled=True),
    SpringMistake("k alike", alike, scaled=True),
    SpringMistake("k alike", alike, whole=True, scaled=True),
    SpringMistake("axes alone", axes_alone, scaled=True),
    SpringMistake("equal masses", mass="equal"),
    SpringMistake("doubled mass", mass="double"),
    SpringMistake("rest length", rest="all"),
    SpringMistake("rest length", rest="diagonals"),
)
"""Mistakes with springs; the first is none but the spacing."""


def rest_length_force(springs: CorrectSprings, rest: str) -> Array:
    """Forces (n, d) in N at rest lengths longer by their own length, to first order."""
    network = springs.network
    longer = np.ones(len(network.springs), dtype=bool)
    if rest == "diagonals":
        longer = springs.lattice.kind > 0
    length = network.rest_length * (1 + REST_STEP * longer)
    change = replace(network, rest_length=length).rest_force - network.rest_force
    return np.asarray(change / REST_STEP)


def solve_mistakes(
    springs: CorrectSprings, records: Sequence[SpringMistake]
) -> Iterator[tuple[Network, Array | None]]:
    """Network and displacement (n, d) in m of each mistake to first order; None if not stable.

    Mistakes that share their springs share one factor. For those in rest lengths the result is the
    change per relative change of the rest length.
    """
    factors: dict[tuple[object, bool], Factor | None] = {}
    for record in records:
        network = record.network(springs)
        shared = record.constants, record.whole
        if shared not in factors:
            factors[shared] = factorise(network)
        factor = factors[shared]
        if record.rest:
            none = np.zeros(network.points.shape)
            network = replace(
                network, displacement=none, force=rest_length_force(springs, record.rest)
            )
        if factor is None:
            yield network, None
        else:
            yield network, factor(network)


def factorise(network: Network) -> Factor | None:
    """Factor of the tangent of a network at rest; None if the network is not stable.

    A plain sparse factor: a mistake's field needs no bound of its own error, and takes a fifth of
    the time of `statics.equilibrium`.
    """
    K, free = csc_array(Configuration(network).tangent()), ~network.held.ravel()
    inner = csc_array(K[free][:, free])
    try:
        factor = symmetric_factor(inner)
    except RuntimeError:  # singular
        return None
    pivots = factor.U.diagonal()
    if pivots.min() <= MIN_PIVOT * pivots.max():
        return None

    def solve(other: Network) -> Array:
        u = other.displacement.ravel().copy()
        right = (other.force + other.rest_force).ravel() - K @ np.where(free, 0.0, u)
        u[free] = factor.solve(right[free])
        return np.asarray(u.reshape(other.points.shape))

    return solve


def symmetric_factor(matrix: csc_array) -> SuperLU:
    """Sparse factor without pivoting; raises `RuntimeError` if a pivot is 0."""
    options = {"SymmetricMode": True}
    return splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options)


def named_factors(record: SpringMistake, law: Isotropic) -> Mapping[str, Callable[[float], float]]:
    """Factors, by the spacing (m), of a scaled mistake that have sentences of their own."""
    if record.constants is not alike:
        return {}
    return {"k = E h": lambda _: 1.0, "k = E": lambda h: law.E / bar_constant(law, h)}


def mistake_lines(law: Isotropic, lattice: str, spacing: float) -> list[str]:
    """The known mistakes with springs of a lattice, and which solids other constants are.

    Raises
    ------
    ProblemError
        If no constants make the lattice a solid.
    """
    pattern = all_patterns()[lattice]()
    own = calibrate_by_route(replace(law, nu=CAUCHY[law.dim]), pattern, spacing, "springs")
    lines = []
    for record in SPRING_MISTAKES[1:]:
        if record.rest or record.beside or not record.applies(pattern.kinds, heavy=True):
            continue
        line = say(mistake_phrase(record.kind, 1.0, spacing, named_factors(record, law)), PHRASES)
        if record.has_other_constants:
            wrong = record.constants(own.constants, bar_constant(law, spacing))
            solid = moduli(homogenise(pattern, wrong, spacing).tensor)
            line += (
                f" ({lattice}: E {solid.E / (law.E * law.thickness):.4g} times, nu = "
                f"{solid.nu:.4g} along the axes, Zener ratio {solid.zener:.4g})"
            )
        lines.append(line)
    return lines


def name_constants(
    law: Isotropic, own: Constants, constants: Sequence[float], spacing: float
) -> Phrase | None:
    """Sentence of the known mistake that constants (N/m) are; None if they are none.

    Parameters
    ----------
    law, own, constants, spacing
        The material, the right constants by kind, those in question, and the spacing (m).
    """
    bar = bar_constant(law, spacing)
    k = np.asarray(constants, dtype=float)
    for record in SPRING_MISTAKES:
        wrong = np.array(record.constants(own, bar))
        if record.has_other_constants and len(wrong) == len(k) > 1 and k[0] > 0:
            times = float(k[0] / wrong[0])
            if np.abs(k - times * wrong).max() <= SAME * k.max():
                return mistake_phrase(record.kind, times, spacing, named_factors(record, law))
    return None
