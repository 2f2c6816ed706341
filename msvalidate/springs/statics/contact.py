"""A network at rest against rigid obstacles, without friction.

Contact forces are external forces. With candidate points i, gap g_i to the obstacle, its normal n_i
and the force f_i along it,

    g_i >= 0,    f_i >= 0,    f_i g_i = 0,

which to first order is the minimum of ½ f·C f + f·g0 over f >= 0, C_ij what a unit force at j along
n_j moves i by along n_i. It is found by conjugate gradients that are restarted whenever the set of
touching points changes ([PolonskyKeer1999]), of an obstacle pressed by a force P with Σ f_i n_i·a =
P beside, a its way. The network's own equilibrium under these forces then says what gaps are left;
from these, and normals where the points are now, the next round begins. Linear networks take one
round where their tangent is factorised, and some where it is solved for by multigrid.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np

from msvalidate.problem import (
    Array,
    Index,
    Mask,
    Obstacle,
    ProblemError,
    SolverError,
    refuse_free_motions,
)
from msvalidate.problem.checks import require_one_of
from msvalidate.problem.records import dataclass, replace
from msvalidate.springs.network import Configuration, Network
from msvalidate.springs.network.inverse import Once, Solver
from msvalidate.springs.statics.equilibrium import Equilibrium, equilibrium, equilibrium_at
from msvalidate.springs.statics.tangents import Tangent, tangent_at
from msvalidate.springs.statics.unilateral import CLOSED, Unilateral

ACCEPTED = 1e-7
"""Relative contact violation that is accepted if rounding allows no less.

It is relative to the depth.
"""
ROUNDS = 40
"""Linear networks take 1 to 4, others 5 to 15."""
IN_A_ROUND = 1e-3
"""Relative violation after a round whose tangent is not the last one."""
SMALLEST_PART = 2.0**-6
"""Smallest fraction of an obstacle's path for a step."""
TINY = float(np.finfo(float).tiny)
CONSTRAINED = 1e-9
"""Smallest free part of a normal for which a candidate point can move."""


@dataclass(frozen=True, eq=False)
class ContactCandidates:
    """Points of a network that an obstacle may touch.

    Parameters
    ----------
    points
        (c,) numbers.
    share
        (c,) force (N) on each by a unit pressure (1 Pa) on the surface: area, or length times
        thickness.
    obstacle, depth, force, friction
        As in `problem.Contact`.
    """

    points: Index
    share: Array
    obstacle: Obstacle
    depth: float = 0.0
    force: float | None = None
    friction: float = 0.0


@dataclass(frozen=True, eq=False)
class ContactForces:
    """An obstacle's contact with a network at rest.

    Parameters
    ----------
    points, share
        Candidates (c,), as in `ContactCandidates`.
    force, gap
        (c,) in N along the obstacle's normals, and in m.
    depth
        How far (m) the obstacle was lowered.
    total
        Force (N) along its way.
    half_width
        Half-width (m) or radius of the patch from the forces' second moment, 0 where nothing
        touches: `Obstacle.half_width`.
    """

    points: Index
    share: Array
    force: Array
    gap: Array
    depth: float
    total: float
    half_width: float

    @property
    def pressure(self) -> Array:
        """Pressure (c,) in Pa: force by share."""
        return np.asarray(self.force / self.share)


@dataclass(frozen=True, eq=False)
class ContactEquilibrium:
    """A network at rest against obstacles.

    Parameters
    ----------
    equilibrium
        Under its loads and the contact forces, with its own error.
    load
        Contact forces (n, d) in N on the points.
    contacts
        One for each obstacle.
    complementarity
        Largest penetration, or gap under a force, over the largest depth of an obstacle in the body
        as it was, or part of a force that is not along the normal: how far the answer is from exact
        unilateral contact.
    rounds, applications
        That it took: small problems, and solves with the tangent in them.
    """

    equilibrium: Equilibrium
    load: Array
    contacts: tuple[ContactForces, ...]
    complementarity: float
    rounds: int
    applications: int


def solve_contact(
    network: Network,
    touching: ContactCandidates | Sequence[ContactCandidates],
    geometry: Literal["linear", "nonlinear"] = "linear",
) -> ContactEquilibrium:
    """Static equilibrium of a network that obstacles are pressed on.

    Parameters
    ----------
    network
        Supports must hold every rigid motion; its loads act too.
    touching
        What may touch, such as `springs.bodies.lattice_network.contact_network` gives it.
    geometry
        "linear": gaps and springs to first order in the displacement. "nonlinear": the obstacle
        meets points where they are. What is too deep at once is lowered in parts.

    Raises
    ------
    ProblemError
        If a contact cannot be: nothing is reached, two claim one point, friction at rest, a
        parabola in nonlinear geometry; or as `equilibrium`.
    SolverError
        If no equilibrium is found, or gaps do not close.
    """
    require_one_of("geometry", geometry, ("linear", "nonlinear"))
    each = (touching,) if isinstance(touching, ContactCandidates) else tuple(touching)
    _refuse_other(network, each, geometry)
    refuse_free_motions("network", network.points, network.fixed)
    way = _ContactPath(network, each, geometry)
    part, done = 1.0, 0.0
    while done < 1:
        try:
            way.lower(min(1.0, done + part))
        except SolverError as error:
            if geometry == "linear" or part <= SMALLEST_PART:
                raise SolverError(
                    f"contact: no equilibrium beyond {done:.4g} of the obstacle's way; {error}"
                ) from error
            part /= 2
            continue
        done = min(1.0, done + part)
    return way.result()


def _refuse_other(network: Network, items: Sequence[ContactCandidates], geometry: str) -> None:
    """Raise `ProblemError` for contacts that are none."""
    if not items:
        raise ProblemError("contact: none; give one, or take equilibrium")
    numbers, times = np.unique(np.concatenate([one.points for one in items]), return_counts=True)
    if (times > 1).any():
        point = int(numbers[times > 1][0])
        raise ProblemError(
            f"contact: two contacts claim point {point} at {network.points[point].tolist()} m; "
            "give each its own part of the surface"
        )
    for one in items:
        shape = one.obstacle.shape
        if one.friction:
            raise ProblemError(
                f"contact with a {shape}: friction {one.friction:g} at rest depends on the way "
                "there; take `motion`, or friction 0"
            )
        if geometry == "nonlinear" and shape.startswith("parabol"):
            raise ProblemError(
                f"contact with a {shape}: its gap runs along its axis, which is so to first order "
                "only; take a disc or ball, or geometry 'linear'"
            )


class _ContactPath:
    """Obstacles on their way into a network, and where it has led to.

    Attributes
    ----------
    points, which
        Candidates (c,) of all obstacles, and the obstacle of each.
    gaps, depths
        Force (N) of each obstacle, NaN where its depth is given; and its depth (m) now.
    factorised, force, load
        The equilibrium there, forces (c,) in N along the normals, and what they are (n, d).
    """

    def __init__(
        self, network: Network, items: tuple[ContactCandidates, ...], geometry: str
    ) -> None:
        self.network, self.items = network, items
        self.nonlinear = geometry == "nonlinear"
        self.points = np.concatenate([one.points for one in items])
        self.which = np.repeat(np.arange(len(items)), [len(one.points) for one in items])
        self.gaps = np.array([np.nan if one.force is None else one.force for one in items])
        self.depths = np.array([one.depth for one in items])
        self.axes = np.array([one.obstacle.axis for one in items])
        self.force = np.zeros(len(self.points))
        self.load = np.zeros(network.points.shape)
        self.rounds = self.applications = 0
        self.misfit = np.inf
        bare = network.rest_force.any() or network.force.any() or network.displacement.any()
        still = np.zeros(network.points.shape)
        self._inverse = Solver(network) if self.nonlinear else Once(network)
        self.factorised = self._rest(None) if bare else equilibrium_at(network, still, 0, error=0.0)
        self._tangent: Tangent | None = None
        self.reach = self._reach()

    def _rest(self, start: Equilibrium | None) -> Equilibrium:
        """The network's own equilibrium under its loads and the contact forces."""
        loaded = replace(self.network, force=self.network.force + self.load)
        if not self.nonlinear:
            return equilibrium(loaded, solver=self._inverse)
        return equilibrium(loaded, "nonlinear", start=start)

    def _gaps(self) -> tuple[Array, Array]:
        """Gaps (c,) in m and normals (c, d): to first order in the displacement, or there."""
        x = self._places()
        gap, normal = np.empty(len(x)), np.empty(x.shape)
        for k, one in enumerate(self.items):
            own = self.which == k
            gap[own] = one.obstacle.gap(x[own], self.depths[k])
            normal[own] = one.obstacle.normal(x[own], self.depths[k])
        if not self.nonlinear:
            gap = gap + (normal * self.factorised.displacement[self.points]).sum(axis=1)
        return gap, normal

    def _places(self) -> Array:
        """Positions (c, d) in m of the candidates; reference positions in a linear problem."""
        x = self.network.points + (self.factorised.displacement if self.nonlinear else 0.0)
        return np.asarray(x[self.points])

    def _reach(self) -> Array:
        """Penetration (obstacles,) in m at a prescribed depth; 0 at a force.

        Raises `ProblemError` if a fixed point lies in an obstacle, or one with a prescribed depth
        reaches no point.
        """
        gap, normal = self._gaps()
        still = self._still(normal)
        if (gap[still] < 0).any():
            point = int(self.points[still][gap[still].argmin()])
            raise ProblemError(
                f"contact: point {point} at {self.network.points[point].tolist()} m is held inside "
                "the obstacle; give a part of the surface that may move"
            )
        reach = np.zeros(len(self.items))
        for k in np.flatnonzero(np.isnan(self.gaps)):
            reach[k] = -float(gap[self.which == k].min())
            if reach[k] <= 0:
                raise ProblemError(
                    f"contact with a {self.items[k].obstacle.shape}: no point of the region can be "
                    f"reached, the nearest is {-reach[k]:.4g} m away; lower it by more than that"
                )
        return reach

    def _still(self, normal: Array) -> Mask:
        """Candidates (c,) that supports hold along their normals (c, d)."""
        return np.asarray(
            (np.abs(normal) * ~self.network.fixed[self.points]).max(axis=1) < CONSTRAINED
        )

    def lower(self, part: float) -> None:
        """Lower the obstacles to a fraction of the path; undo it on failure."""
        before = dict(vars(self))
        given = np.array([one.depth for one in self.items]) - (1 - part) * self.reach
        self.depths = np.where(np.isnan(self.gaps), given, self.depths)
        best = np.inf
        for _ in range(ROUNDS):
            try:
                self._round(part * self.gaps)
            except SolverError:
                vars(self).update(before)
                raise
            if self.misfit <= CLOSED or best / 2 <= self.misfit <= ACCEPTED:  # no more to be had
                return
            best = min(best, self.misfit)
        left = self.misfit
        vars(self).update(before)
        raise SolverError(f"gaps of {left:.1g} of the depth are left after {ROUNDS} rounds")

    def _round(self, gaps: Array) -> None:
        """Forces that close the gaps to first order, and the equilibrium under them."""
        gap, normal = self._gaps()
        if self.nonlinear or self._tangent is None:
            u = self.factorised.displacement if self.nonlinear else None
            self._tangent = tangent_at(Configuration(self.network, u), self._inverse)
        exact = self._inverse.is_direct and not self.nonlinear
        turned = self._spread(self.force, normal) - self.load
        small = Unilateral(
            follow=lambda force: self._moved(self._spread(force, normal), normal),
            gap=gap + self._moved(turned, normal) if turned.any() else gap,
            start=self.force,
            along=(normal * self.axes[self.which]).sum(axis=1),
            which=self.which,
            prescribed_force=gaps,
        )
        self.force, raised = small.solve(0.0 if exact else IN_A_ROUND)
        if small.depth <= 0:
            top = self.force.argmax()
            if not self._still(normal)[top]:
                raise SolverError("the force indents less than rounding of the gaps; increase it")
            x = self._places()[top].tolist()
            raise ProblemError(
                f"contact: the obstacle rests on the point at {x} m, which is held, and presses "
                "nothing; move it, or give a part of the surface that may move"
            )
        self.depths = self.depths + raised
        self.load = self._spread(self.force, normal)
        self.rounds += 1
        self.factorised = self._rest(self.factorised)
        gap, now = self._gaps()
        touched = np.where(self.force > 0, np.abs(gap), np.maximum(-gap, 0.0))
        off = self.force * np.abs(now - normal).max(axis=1)
        self.misfit = max(
            float(touched.max()) / small.depth, float(off.max() / self.force.max(initial=TINY))
        )

    def _spread(self, force: Array, normal: Array) -> Array:
        """Forces (n, d) in N of forces (c,) along normals (c, d)."""
        out = np.zeros(self.network.points.shape)
        out[self.points] = force[:, None] * normal
        return out

    def _moved(self, load: Array, normal: Array) -> Array:
        """Displacements (c,) in m of the candidates along normals under forces (n, d) in N.

        They are of first order.
        """
        self.applications += 1
        assert self._tangent is not None  # noqa: S101
        u = self._tangent.move(load, np.zeros_like(load))
        return np.asarray((normal * u[self.points]).sum(axis=1))

    def result(self) -> ContactEquilibrium:
        """State at the end of the path."""
        gap, normal = self._gaps()
        x, contacts = self._places(), []
        for k, one in enumerate(self.items):
            own, axis = self.which == k, self.axes[k]
            force = self.force[own]
            contacts.append(
                ContactForces(
                    points=one.points,
                    share=one.share,
                    force=force,
                    gap=gap[own],
                    depth=float(self.depths[k]),
                    total=float(force @ (normal[own] @ axis)),
                    half_width=one.obstacle.half_width(x[own], force),
                )
            )
        return ContactEquilibrium(
            self.factorised, self.load, tuple(contacts), self.misfit, self.rounds, self.applications
        )
