"""Catalogue of known mistakes, each with a model that is solved on the body in question.

A mistake is a record: its kind, its model, and its sentence, which is the phrase of that kind in
`msvalidate_check.causes.PHRASES`. `advise`, `case judge`, `simulate` and `adapter
check` use this one catalogue, so a field is compared with what a mistake gives and none is guessed.
The kinds that change the size of the field alone (unit of k, thickness, load, modulus) and the
plane state need no model of their own: `msvalidate_check.scales` and `changes` have them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cache, partial

import numpy as np
from scipy.sparse import csr_array

from msvalidate.linear_algebra.factor import factorise
from msvalidate.problem import Array, Isotropic, Mask, Mesh
from msvalidate.problem.records import dataclass, replace
from msvalidate.springs.constants.stiffness import central_modulus, springs_ratio
from msvalidate.springs.lattice import EDGE_RULES, Constants, Lattice, mesh_lattice
from msvalidate.springs.lattice.edges import EdgeLattice
from msvalidate.springs.lattice.patterns import all_patterns
from msvalidate.springs.network import Network, spring_network
from msvalidate.springs.network.configuration import Configuration
from msvalidate_check.beside import Mistake
from msvalidate_check.causes import PHRASES, say
from msvalidate_check.mistakes import mistake_phrase

Factor = Callable[[Network], Array]
"""Displacement (n, d) in m of a network whose springs are those of a factor."""

Path = list[tuple[float, Array]]
"""Pairs of a parameter and displacements (p, d) in m at the points of a result."""
Solved = list[tuple[float, list[Array | None]]]
"""Spacing (m), and displacement (p, d) in m of each mistake there, from fine to coarse."""

MIN_PIVOT = 1e-12
"""Smallest pivot of a factor relative to the largest of a network that is stable."""
REST_STEP = 1e-6
"""Relative change of rest lengths from which their first-order effect is taken."""
MAX_SPACINGS = {2: 3, 3: 2}
"""Spacings at which springs are solved, by dimension."""
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
        weight = lattice.share * lattice.factor  # of a cut lattice the factor has the share in it
        if whole:
            kinds = range(lattice.kinds)
            inner = np.array([lattice.factor[lattice.kind == i].max() for i in kinds])
            weight = inner[lattice.kind]
        return replace(self.network, stiffness=k * weight)


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
        """Return True if the constants are not the right ones.

        No cell then resists a change of volume.
        """
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
        """Return True if the mistake changes a static field.

        This depends on the number of kinds of spring and on a weight among the loads.

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
            factors[shared] = factorise_network(network)
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


def factorise_network(network: Network) -> Factor | None:
    """Factor of the tangent of a network at rest; None if the network is not stable.

    A plain sparse factor: a mistake's field needs no bound of its own error, and takes a fifth of
    the time of `springs.statics.equilibrium`.
    """
    K, free = csr_array(Configuration(network).tangent()), ~network.fixed.ravel()
    try:
        factor = factorise(csr_array(K[free][:, free]))
    except RuntimeError:  # singular
        return None
    pivots = factor.lu.U.diagonal()
    if pivots.min() <= MIN_PIVOT * pivots.max():
        return None

    def solve(other: Network) -> Array:
        u = other.displacement.ravel().copy()
        right = (other.force + other.rest_force).ravel() - K @ np.where(free, 0.0, u)
        u[free] = factor.solve(right[free])
        return np.asarray(u.reshape(other.points.shape))

    return solve


def named_factors(record: SpringMistake, law: Isotropic) -> Mapping[str, Callable[[float], float]]:
    """Factors of the stiffness, by the spacing (m), that have sentences of their own."""
    if record.kind == "coarse springs" and law.dim == 3:
        return {"k without h": lambda h: 1 / h if h else np.inf}
    if record.constants is not alike:
        return {}
    return {"k = E h": lambda _: 1.0, "k = E": lambda h: law.E / bar_constant(law, h)}


def of_records(
    records: Sequence[SpringMistake], law: Isotropic, solved: Callable[[], Solved], elastic: Array
) -> Iterator[Mistake]:
    """Yield mistakes with springs, with their paths over spacings or rest lengths."""
    for number, record in enumerate(records):
        paths = [partial(_spring_path, solved, number, elastic)]
        if record.rest:
            spacings = range(MAX_SPACINGS[law.dim])
            paths = [partial(_rest_path, solved, number, which) for which in spacings]
        for path in paths:
            yield Mistake(
                record.kind,
                cache(path),
                scaled=record.scaled,
                named=named_factors(record, law),
                beside=record.beside,
                simpler=record.simpler,
            )


def mistakes_on_mesh(
    mesh: Mesh,
    law: Isotropic,
    elastic: Array,
    *,
    mass: Array,
    gravity: Array,
    force: Array,
    fixed: Mask,
    value: Array,
) -> tuple[Mistake, ...]:
    """Return the known mistakes with a spring on each edge of a mesh, at its nodes.

    Parameters
    ----------
    mesh, law
        The mesh of linear cells, and the material; the right springs have Cauchy's ratio.
    elastic
        Elasticity (n, d) in m at the nodes.
    mass, gravity, force
        Masses (n,) in kg, acceleration (d,) in m/s², other forces (n, d) in N.
    fixed, value
        Components (n, d) that supports hold, and their displacements (m).
    """
    records = tuple(e for e in SPRING_MISTAKES if e.applies(0, heavy=bool(gravity.any())))

    def solved() -> Solved:
        lattice = mesh_lattice(mesh, EDGE_RULES[0], positive=True)
        own = replace(law, nu=springs_ratio(law))
        constants = (central_modulus(own, law.dim, "springs on a mesh's edges"),)
        network = spring_network(
            mesh.points, lattice.springs, constants[0] * lattice.factor, mass=mass, fixed=fixed,
            displacement=np.where(fixed, value, 0.0), force=force + np.outer(mass, gravity),
        )  # fmt: skip
        spacing = mesh.mean_edge
        springs = CorrectSprings(law, gravity, lattice, network, constants, spacing)
        return [(spacing, [u for _, u in solve_mistakes(springs, records)])]

    return tuple(of_records(records, law, cache(solved), elastic))


def _spring_path(solved: Callable[[], Solved], number: int, elastic: Array) -> Path:
    """Displacements with one mistake at each spacing.

    Right springs are number 0 and converge to elasticity, which begins their path.
    """
    path = [(h, u) for h, each in solved() if (u := each[number]) is not None]
    return path if number or not path else [(0.0, elastic), *path]


def _rest_path(solved: Callable[[], Solved], number: int, which: int) -> Path:
    """Right springs at one spacing, by the relative excess of rest lengths over their lengths."""
    path: Path = []
    for _, fields in solved()[which : which + 1]:
        right, change = fields[0], fields[number]
        if right is not None and change is not None:
            path = [(part, right + part * change) for part in (-REST_RANGE, REST_RANGE)]
    return path


def mistake_lines(law: Isotropic, lattice: str, spacing: float) -> list[str]:
    """Sentences of the known mistakes with springs of a lattice."""
    kinds = all_patterns()[lattice]().kinds
    return [
        say(mistake_phrase(each.kind, 1.0, spacing, named_factors(each, law)), PHRASES)
        for each in SPRING_MISTAKES[1:]
        if each.applies(kinds, heavy=True) and not (each.rest or each.beside)
    ]
