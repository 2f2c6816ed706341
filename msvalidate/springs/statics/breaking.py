"""Quasi-static fracture: springs break one after the other under increasing loads.

Small displacements of a network of Hooke's springs that is at rest as it is. One factor serves many
breaks: with B the directions of the springs that broke since it was made, k their stiffness and
C = Bᵀ K⁻¹ B the compliance across them, Woodbury's formula ([GolubVanLoan2013], section 2.1.4) is

    (K - B k Bᵀ)⁻¹ f = K⁻¹ f + K⁻¹ B M⁻¹ Bᵀ K⁻¹ f,    M = 1/k - C.

Springs of elongations e release eᵀ M⁻¹ e / 2 = Σ k e e' / 2 at supports and loads that stay, e' how
far their points are apart after: their own energy Σ k e² / 2 and what the body around them gives
up. Nothing here is a difference of stored energies.
"""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import qr

from msvalidate.problem import Array, Index, ProblemError, SolverError, refuse_free_motions
from msvalidate.problem.checks import finite_number, indices, whole_number
from msvalidate.problem.records import dataclass, replace
from msvalidate.springs.network import Configuration, Network
from msvalidate.springs.network.breakage import critical_stretches
from msvalidate.springs.network.inverse import Once
from msvalidate.springs.statics.equilibrium import Equilibrium, equilibrium_at
from msvalidate.springs.statics.refinement import refine_linear

Ended = Literal["raised", "breaks", "falls", "parted"]
NONE = np.zeros(0, dtype=np.intp)
TIED = 1e-9
"""Relative difference of critical stretches within which springs break together."""
BREAKS_A_FACTOR = 50
"""After which the tangent is inverted anew: columns of as many springs are kept."""
NOTHING, LITTLE = 1e-11, 1e-3
"""Relative stiffness left by a broken spring: mechanism, and need of a new factor.

Between the two, only a new factor can detect a mechanism: Woodbury's formula would lose digits.
"""
UNHELD = 1e-10
"""Force on a mechanism that is rounding, relative to springs at the largest displacement."""
SLACK, LOOSE = 1e-10, 1e-6
"""Relative elongation without load, and smallest component of a mechanism's motion."""
CLOSED, ROUNDED = 1e-10, 1e-13
"""Tolerances of the energy balance, relative to the released energy and to the work."""


@dataclass(frozen=True, eq=False)
class Break:
    """Springs that break together.

    Parameters
    ----------
    load, needed
        Factor of the network's loads at which they break, which is never lowered; and that at
        which they would, below it where breaks before it have overloaded them.
    springs
        (b,) numbers.
    stored_energy, released
        Energy (J) that they held, and that left the body.
    """

    load: float
    needed: float
    springs: Index
    stored_energy: float
    released: float


@dataclass(frozen=True, eq=False)
class FractureResult:
    """Result of quasi-static fracture.

    Parameters
    ----------
    breaks
        In their order.
    network
        At the end: broken springs have no stiffness, and loads are those at the end.
    equilibrium
        Of that.
    critical_stretch
        (m,) as it was given.
    loose
        (l,) points that springs no longer hold in every direction, alone or with a piece of the
        body: without a force they stay where they were.
    load, work, stored
        At the end: factor of the loads, energy (J) by loads and supports so far, and in springs.
    ended
        "raised": no spring breaks up to the factor that was asked for; "breaks": there were as
        many as were asked for; "falls": the next break would leave a load on what nothing holds;
        "parted": no spring bears anything any more, however much is raised.
    """

    breaks: tuple[Break, ...]
    network: Network
    equilibrium: Equilibrium
    critical_stretch: Array
    loose: Index
    load: float
    work: float
    stored: float
    ended: Ended

    @property
    def broken(self) -> Index:
        """Numbers of the springs that broke, in their order."""
        return np.concatenate([NONE, *(one.springs for one in self.breaks)])

    @property
    def released(self) -> float:
        """Energy (J) that left the body in all breaks."""
        return math.fsum(one.released for one in self.breaks)

    @property
    def stored_energy(self) -> float:
        """Energy (J) that the springs stored when they broke: a part of `released`."""
        return math.fsum(one.stored_energy for one in self.breaks)

    @property
    def closure(self) -> float:
        """Error of the energy balance, relative to the released energy or else the work."""
        left = abs(self.work - self.stored - self.released)
        return left / (self.released or self.work or 1.0)


def propagate_crack(
    network: Network,
    critical_stretch: ArrayLike,
    raised: float = 1.0,
    *,
    crack: ArrayLike = (),
    most_breaks: int | None = None,
) -> FractureResult:
    """Raise a network's loads and prescribed displacements together, and let springs break.

    The most stretched spring breaks, over its own critical stretch, at the factor of the loads that
    takes it there; with it those that are as near to theirs within `TIED`, so that numbering does
    not matter. The factor is never lowered: what would have broken below it breaks next.

    Parameters
    ----------
    network
        Of Hooke's springs without cells, at rest as it is; supports must hold every rigid motion.
    critical_stretch
        Elongation over rest length at which a spring breaks in tension, > 0: one number or (m,),
        infinite of those that do not break.
    raised
        Factor up to which, from 0.
    crack
        Numbers of springs that are cut beforehand. What they leave without a hold is loose.
    most_breaks
        Events after which to stop.

    Raises
    ------
    ProblemError
        If the network is of another kind or bears nothing, or a critical stretch is none.
    SolverError
        If it is a mechanism, or the ledger does not close.
    """
    stretch = critical_stretches(network, critical_stretch)
    if network.prestressed:
        raise ProblemError(
            "breaking: springs that are stretched or pressed at rest; take rest lengths that are "
            "the distances of their points, or a motion"
        )
    refuse_free_motions("network", network.points, network.fixed)
    if not (network.force[~network.fixed].any() or network.displacement.any()):
        raise ProblemError("breaking: nothing is raised; give loads or prescribed displacements")
    if finite_number("raised", raised) <= 0:
        raise ProblemError(f"raised: {raised:g}; give a factor of the loads above 0")
    most = math.inf if most_breaks is None else whole_number("most breaks", most_breaks, 1)
    cut = NONE
    if np.size(crack):
        cut = np.unique(indices("crack", crack, len(network.springs), "k", what="springs"))
    found = BreakingPath(network, stretch, cut).follow(raised, most)
    left = abs(found.work - found.stored - found.released)
    if found.breaks and not left <= CLOSED * found.released + ROUNDED * found.work:
        raise SolverError(
            f"breaking: {left:.1g} J of {found.released:.4g} J released are not accounted for: the "
            "body is all but apart; stop before, by raised or most_breaks"
        )
    return found


class BreakingPath:
    """A network on its way, its displacement in proportion to the factor of its loads.

    Attributes
    ----------
    network
        Springs that broke have no stiffness; held too is what is loose.
    unit
        Displacement (n, d) in m under the whole load, but for what is loose.
    still
        Displacement (n, d) in m at which loose pieces stay.
    load, work
        Factor now, and the work (J) so far.
    """

    def __init__(self, network: Network, stretch: Array, crack: Index = NONE) -> None:
        self.initial_network = self.network = network
        self.stiffness = network.stiffness.copy()
        self.length = network.rest_length * stretch
        self.along = network.vector / network.distance[:, None]
        self.solver = Once(network)
        self.load = self.work = self.largest = 0.0
        self.still = np.zeros(network.points.shape)
        self.loose = np.zeros(len(network.points), dtype=bool)
        self.stiffness[crack] = 0.0
        try:
            self._factorise()
        except SolverError:  # the crack leaves parts without a hold: some springs at a time
            if not len(crack):
                raise
            self.stiffness = network.stiffness.copy()
            self._factorise()
            for springs in np.array_split(crack, -(-len(crack) // BREAKS_A_FACTOR)):
                if self.cut(springs, 0.0) is None:
                    raise ProblemError(
                        "crack: nothing holds what it leaves of a loaded part; make it shorter"
                    ) from None

    def _factorise(self) -> None:
        """Invert the tangent of what is whole now, and solve for the whole load."""
        self.solver.renew()
        self.network = replace(self.network, stiffness=self.stiffness.copy())
        refined = refine_linear(self.network, self.solver)
        self.error, self.unit = refined.error, refined.solution
        self._at = Configuration(self.network)
        self._cut = NONE
        self._columns = np.zeros((0, *self.unit.shape))

    def _unit_work(self) -> float:
        """Work (J) of loads and supports up to a factor of 1, twice."""
        pull = (self.stiffness * self.elongation(self.unit))[:, None] * self.along
        inner = self.network.assemble_forces(pull)
        outer = np.where(self.network.fixed, -inner, self.network.force)
        return float((outer * self.unit).sum())

    def elongation(self, u: Array, springs: Index | slice = slice(None)) -> Array:
        """Elongation (b,) in m of springs; (c, b) for displacements (c, n, d)."""
        i, j = self.network.springs[springs].T
        return np.asarray(((u[..., j, :] - u[..., i, :]) * self.along[springs]).sum(axis=-1))

    def follow(self, raised: float, most: float) -> FractureResult:
        """Break springs up to a factor of the loads, `most` times at the most."""
        breaks: list[Break] = []
        while len(breaks) < most:
            found = self.next()
            if found is None:
                return self.result(breaks, "parted")
            needed, springs = found
            load = min(needed, raised)
            if load > self.load:
                self.work += (load**2 - self.load**2) / 2 * self._unit_work()
                self.load = load
            if needed > raised:
                return self.result(breaks, "raised")
            event = self.cut(springs, needed)
            if event is None:
                return self.result(breaks, "falls")
            breaks.append(event)
        return self.result(breaks, "breaks")

    def next(self) -> tuple[float, Index] | None:
        """Factor at which springs break next, and the numbers of these springs.

        The factor is infinite if no spring that can break is stretched, and may be below the
        present one. None is returned if no spring bears anything.
        """
        e = np.where(self.stiffness > 0, self.elongation(self.unit), 0.0)
        self.largest = max(self.largest, float(np.abs(e).max()))
        if not np.abs(e).max() > SLACK * self.largest:
            return None
        part = e / self.length
        largest = float(part.max())
        if largest <= 0:
            return math.inf, NONE
        return 1 / largest, np.flatnonzero(part >= (1 - TIED) * largest)

    def cut(self, springs: Index, needed: float) -> Break | None:
        """Break springs at a factor `needed`; return None, undone, if a load would decrease."""
        if len(self._cut) >= BREAKS_A_FACTOR:
            self._factorise()
        k, e, before = self.stiffness[springs], self.elongation(self.unit, springs), self.unit
        columns, modes, pulled = self._modes(springs, NOTHING)
        if modes is None:  # a factor tells whether so little is in the way, or nothing
            self.stiffness[springs] = 0.0
            try:
                self._factorise()
            except SolverError:
                self.stiffness[springs] = k
                self._factorise()
                columns, modes, pulled = self._modes(springs, LITTLE)
        if modes is not None:
            reach = UNHELD * math.sqrt(k.max()) * np.abs(self.unit).max()
            if (np.abs(pulled) > reach).any():
                return None
            self.unit = self.unit + columns
            self.stiffness[springs] = 0.0
            if len(modes):
                self._hold(modes, self.load * before + self.still)
        self.work += self.load**2 * float((self.network.force * (self.unit - before)).sum())
        opened = self.elongation(self.unit, springs)
        return Break(
            load=self.load,
            needed=needed,
            springs=springs,
            stored_energy=self.load**2 / 2 * float(k @ e**2),
            released=self.load**2 / 2 * float(k * e @ opened),
        )

    def _modes(self, springs: Index, nothing: float) -> tuple[Array, Array | None, Array]:
        """Motions (n, d) from springs that break, and mechanisms (r, n, d).

        The mechanisms are the motions that these springs alone resist.

        And with which force; no motions where something resists, but little.
        """
        columns, cross = self._solve(springs)
        root, e = np.sqrt(self.stiffness[springs]), self.elongation(self.unit, springs)
        met = np.eye(len(springs)) - root[:, None] * (cross + cross.T) / 2 * root
        value, vector = np.linalg.eigh(met)
        part = vector.T @ (root * e)
        free = value <= nothing
        over = np.where(free, 0.0, part / np.where(free, 1.0, value))
        moved = np.tensordot(root * (vector @ over), columns, axes=1)
        if (~free & (value < LITTLE)).any():
            return moved, None, part[free]
        return moved, np.tensordot(root * vector[:, free].T, columns, axes=1), part[free]

    def _solve(self, springs: Index) -> tuple[Array, Array]:
        """Displacements (b, n, d) due to unit pulls, and the compliance (b, b)."""
        free = ~self.network.fixed
        columns = np.zeros((len(springs), *self.unit.shape))
        for column, spring in zip(columns, springs if free.any() else NONE, strict=False):
            inverse = self.solver.regular(self._at).inverse
            pull = np.zeros(self.unit.shape)
            i, j = self.network.springs[spring]
            pull[i], pull[j] = -self.along[spring], self.along[spring]
            column[free] = inverse.solve(pull[free])
            left = pull + self._at.force_change(column)
            column[free] += inverse.solve(left[free])
        self._columns = np.concatenate([self._columns, columns])
        before, self._cut = self._cut, np.concatenate([self._cut, springs])
        if len(before):
            k = self._at.network.stiffness[before]
            C = self.elongation(self._columns[: len(before)], before)
            across = self.elongation(columns, before)
            part = np.linalg.solve(np.diag(1 / k) - (C + C.T) / 2, across.T)
            columns = columns + np.tensordot(part.T, self._columns[: len(before)], axes=1)
        return columns, self.elongation(columns, springs)

    def _hold(self, modes: Array, at: Array) -> None:
        """Hold as many components as there are motions (r, n, d) that nothing resists any more.

        At a displacement (n, d) in m, those that tell the motions apart best: they bear no force.
        """
        size = np.abs(modes).max(axis=(1, 2), keepdims=True)
        self.loose |= (np.abs(modes) > LOOSE * size).any(axis=(0, 2))
        which = qr(modes.reshape(len(modes), -1), mode="r", pivoting=True)[1][: len(modes)]
        held = self.network.fixed.copy()
        held.ravel()[which] = True
        self.network = replace(self.network, fixed=held)
        self._factorise()
        # Without a force where the loads leave them: the rest of their pieces comes along.
        moved = np.where(held & ~self.initial_network.fixed, at, 0.0)
        alone = replace(self.network, force=0 * self.initial_network.force, displacement=moved)
        self.still = refine_linear(alone, self.solver).solution

    def result(self, breaks: list[Break], ended: Ended) -> FractureResult:
        """State at the end of the load path."""
        load, e = self.load, self.elongation(self.unit)
        network = replace(
            self.network,
            stiffness=self.stiffness.copy(),
            force=load * self.initial_network.force,
            displacement=np.where(self.network.fixed, load * self.unit + self.still, 0.0),
        )
        u, choice = load * self.unit + self.still, self.solver.choice
        return FractureResult(
            breaks=tuple(breaks),
            network=network,
            equilibrium=equilibrium_at(
                network, u, len(breaks), error=self.error, solver=choice, linear=True
            ),
            critical_stretch=self.length / self.initial_network.rest_length,
            loose=np.flatnonzero(self.loose),
            load=load,
            work=self.work,
            stored=load**2 / 2 * float(self.stiffness @ e**2),
            ended=ended,
        )
