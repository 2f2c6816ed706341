"""A spring network from any list of points and springs.

Beside the springs may stand cells that resist a change of volume (`laws.volumes`).
`configuration` has its energy, forces and tangent.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Any, Concatenate, NamedTuple, ParamSpec, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from msvalidate.linear_algebra.norms import EPS
from msvalidate.problem import LONGEST, Array, Index, Mask, Problem, ProblemError
from msvalidate.problem.checks import (
    boolean_mask,
    finite,
    finite_coordinates,
    integers,
    require_type,
)
from msvalidate.problem.records import dataclass, replace
from msvalidate.springs.network.blocks import Blocks, blocks_of
from msvalidate.springs.network.checks import (
    broadcast_values,
    check_cells,
    check_springs,
    refuse_first_bad,
)
from msvalidate.springs.network.folds import Simplices, simplices_of
from msvalidate.springs.network.laws import volumes as of_volumes
from msvalidate.springs.network.laws.law import Coefficients, SpringLaw
from msvalidate.springs.network.laws.linear import LINEAR
from msvalidate.springs.network.laws.volumes import Volumes
from msvalidate.springs.network.layout import Layout, make_layout

P = ParamSpec("P")
T = TypeVar("T")

AT_REST = 2.0**-50
"""Largest pull, relative to the axial stiffness, that counts as rounding.

A rest length that equals the distance of two points is rounded to a double. Taken literally, the
rounding would be a prestress that bends a slender body more than a small load does.
"""
BALANCED = 16.0
"""Out-of-balance force that counts as equilibrium, in units of rounding."""


class Body(NamedTuple):
    """Origin of a network: the problem and the lattice that it stands for.

    Parameters
    ----------
    problem
        Boundary value problem.
    lattice
        `springs.lattice.Lattice` of the points and springs.
    constants
        Spring constants per kind, or calibrations; with zones one entry per material.
    """

    problem: Problem
    lattice: Any
    constants: Any


@dataclass(frozen=True, eq=False)
class Network:
    """Points joined by springs, with masses, supports and loads.

    `spring_network` fills in defaults; `lattice_network` builds one from a problem. Arrays are made
    read-only.

    Parameters
    ----------
    points
        Reference positions (m), shape (n, d), from which displacements are measured.
    springs
        Pairs of different points, shape (m, 2).
    stiffness
        Stiffness (N/m, thickness included), shape (m,), >= 0. It may be negative for zero-length
        springs.
    rest_length
        Rest lengths (m), shape (m,), > 0. For zero-length springs it is only a length scale.
    mass
        Masses (kg), shape (n,), > 0.
    fixed
        Mask (n, d) of the components with prescribed displacement.
    displacement
        Prescribed displacements (m), shape (n, d), 0 where the component is free.
    force
        External forces (N), shape (n, d).
    volumes
        Cells with a volume energy on the same points, if any.
    cells
        Points of the cells that are checked for folding, shape (c, corners), in VTK order. Default:
        those of `volumes`, or the triangles that springs form in 2D.
    law
        Constitutive law of the springs; `volumes` have a law of their own.
    body
        Problem and lattice that the network stands for; None for any other network.

    Raises
    ------
    ProblemError
        If an array is invalid; the message names it and its first invalid entry.
    """

    points: Array
    springs: Index
    stiffness: Array
    rest_length: Array
    mass: Array
    fixed: Mask
    displacement: Array
    force: Array
    volumes: Volumes | None = None
    cells: Index | None = None
    law: SpringLaw = LINEAR
    body: Body | None = None

    def __post_init__(self) -> None:
        points = finite_coordinates("points", self.points, "n>0", (2, 3))
        n, d = points.shape
        springs = check_springs(self.springs, n)
        m = len(springs)
        for name, shape, checked in (
            ("points", (n, d), finite_coordinates),
            ("stiffness", (m,), finite),
            ("rest_length", (m,), finite_coordinates),
            ("mass", (n,), finite),
            ("displacement", (n, d), finite_coordinates),
            ("force", (n, d), finite),
        ):
            need = f"this network needs {shape}"
            object.__setattr__(self, name, checked(name, getattr(self, name), *shape, need=need))
        fixed, moved = boolean_mask("fixed", self.fixed, (n, d)), self.displacement
        require_type("law", self.law, SpringLaw)
        below = (self.stiffness < 0) & self.law.rests
        need = f"N/m; it must be 0 or more by the {self.law.name} law"
        refuse_first_bad("stiffness", self.stiffness, below, need)
        refuse_first_bad(
            "displacement", moved[~fixed], moved[~fixed] != 0, "m of what is not fixed; fix it too"
        )
        refuse_first_bad(
            "rest_length", self.rest_length, self.rest_length <= 0, "m; it must be above 0"
        )
        refuse_first_bad("mass", self.mass, self.mass <= 0, "kg; it must be above 0")
        size = np.abs(self.stiffness)
        small = 0 < size.max() < np.finfo(float).tiny  # no factor has digits then
        refuse_first_bad("stiffness", self.stiffness, small & (size > 0), "N/m; raise it")
        object.__setattr__(self, "springs", springs)
        distance = self.distance
        # Below 1/LONGEST a distance is rounded away when it is squared.
        together = distance <= max(1e-14 * float(np.abs(points).max()), 1 / LONGEST)
        refuse_first_bad("spring length", distance, together, "m; its two points coincide")
        object.__setattr__(self, "fixed", fixed)
        if self.volumes is not None:
            require_type("volumes", self.volumes, Volumes)
            if not np.array_equal(self.volumes.points, self.points):
                raise ProblemError("volumes: of other points than the network's; give its own")
        if self.cells is not None:
            object.__setattr__(self, "cells", check_cells(self.cells, n, d))
        for array in (self.springs, self.fixed):
            array.setflags(write=False)

    def __str__(self) -> str:
        size = f"network of {len(self.points):,} points and {len(self.springs):,} springs"
        if self.body is None:
            return size
        _, lattice, constants = self.body
        numbers = isinstance(constants, tuple) and isinstance(constants[0], float)
        text = f"k = {', '.join(f'{k:.6g}' for k in constants)} N/m" if numbers else f"{constants}"
        return f"{size} ({lattice.name}); {text}"

    @property
    def dim(self) -> int:
        """Number of axes, 2 or 3."""
        return int(self.points.shape[1])

    @property
    def start(self) -> Array:
        """Positions (n, d) in m with the prescribed displacements imposed and all else unmoved."""
        return self.points + self.displacement

    @property
    def size(self) -> float:
        """Largest extent (m) along an axis."""
        return float(np.ptp(self.points, axis=0).max())

    @cached_property
    def vector(self) -> Array:
        """Vectors (m, d) in m from the first point of each spring to the second."""
        vector = self.points[self.springs[:, 1]] - self.points[self.springs[:, 0]]
        vector.setflags(write=False)
        return vector

    @property
    def resisting(self) -> Index:
        """Points (c, corners) of the cells with a volume energy, or (0, 1) without."""
        none = np.zeros((0, 1), dtype=np.intp)
        return none if self.volumes is None else self.volumes.cells

    def of_cells(
        self, value: Callable[Concatenate[Volumes, P], T], *arguments: P.args, **named: P.kwargs
    ) -> T | float:
        """A value that adds up over springs and cells: the cells' part, 0.0 of none."""
        return 0.0 if self.volumes is None else value(self.volumes, *arguments, **named)

    @cached_property
    def distance(self) -> Array:
        """Distance (m,) in m of each spring's points."""
        return np.asarray(np.linalg.norm(self.vector, axis=1))

    @cached_property
    def square(self) -> Array:
        """Squared distance (m,) in m² of the points of each spring."""
        return self.distance**2

    @cached_property
    def coefficients(self) -> Coefficients:
        """Coefficients of the law for each spring."""
        return self.law.coefficients(self.stiffness, self.rest_length)

    @cached_property
    def axial_stiffness(self) -> Array:
        """Stiffness (m,) in N/m of each spring along itself, at the reference points."""
        return self.law.axial(self.coefficients, self.square)

    @cached_property
    def pull_at_rest(self) -> Array:
        """Tension over length (m,) in N/m at the reference positions.

        Compression is negative. Values up to `AT_REST` of the axial stiffness are 0.
        """
        pull = self.law.pull(self.coefficients, self.square)
        return np.where(np.abs(pull) > AT_REST * np.abs(self.axial_stiffness), pull, 0.0)

    @property
    def prestressed(self) -> bool:
        """True if springs carry force at the reference positions."""
        return bool(self.pull_at_rest.any())

    @cached_property
    def rest_force(self) -> Array:
        """Force (n, d) in N of springs and cells at the reference positions.

        It is 0 in equilibrium, up to rounding: for springs and cells under tension and pressure,
        and for a shape that was found under tension.
        """
        if not self.prestressed and self.volumes is None:
            return np.zeros(self.points.shape)
        force = self.assemble_forces(self.pull_at_rest[:, None] * self.vector)
        force = force + self.of_cells(of_volumes.rest_force)
        return np.where(np.abs(force) > BALANCED * self.rounding(0.0), force, 0.0)

    def rounding(self, reach: float) -> Array:
        """Force (n, 1) in N due to rounding of lengths and of `reach` (m).

        An eps of these, times the stiffness of the springs and cells that meet at a point.

        Source: rounding of sums, [Higham2002], chapter 4.
        """
        pull = np.abs(self.axial_stiffness) * (reach + self.distance)
        met = 1.0 * np.bincount(self.springs.ravel(), np.repeat(pull, 2), len(self.points))
        met = met + self.of_cells(of_volumes.roundoff_magnitudes, reach)
        return np.asarray(EPS * met)[:, None]

    @cached_property
    def layout(self) -> Layout:
        """Order of points and springs in memory for the compiled loops."""
        n, d = self.points.shape
        if self.law.loops is None:
            raise ProblemError(f"compiled loops: they have no {self.law.name} law; take path plain")
        each = *self.law.loops(self.coefficients), self.resisting
        return make_layout(n, d, self.springs, *each)

    @cached_property
    def blocks(self) -> Blocks:
        """The positions of the blocks of each spring and cell in the tangent."""
        return blocks_of(self.springs, len(self.points), self.resisting)

    @cached_property
    def simplices(self) -> Simplices | None:
        """Simplices that are checked for folding, or None."""
        cells = self.resisting if self.cells is None else self.cells
        return simplices_of(self.points, self.springs, cells)

    def assemble_forces(self, pull: Array) -> Array:
        """Sum the pulls (m, d) of springs to forces (n, d) in N on points.

        A pull acts on the first end of its spring, and with the opposite sign on the second.
        """
        force = np.zeros(self.points.shape)
        for axis in range(self.dim):
            for end, sign in ((0, 1.0), (1, -1.0)):
                weights = sign * pull[:, axis]
                force[:, axis] += np.bincount(self.springs[:, end], weights, len(force))
        return force

    def scaled(self, factor: Array | float) -> Network:
        """Multiply the stiffness of every spring by `factor`, a number or shape (m,).

        Raises `ProblemError` if the factor is of another shape or not finite, or if it makes a
        stiffness negative and the law forbids that.
        """
        times = finite("factor of the stiffness", factor)
        if times.shape not in {(), self.stiffness.shape}:
            raise ProblemError(
                f"factor of the stiffness: shape {times.shape}; give one number or "
                f"{self.stiffness.shape}"
            )
        return replace(self, stiffness=self.stiffness * times)


def spring_network(
    points: ArrayLike,
    springs: ArrayLike,
    stiffness: ArrayLike,
    *,
    rest_length: ArrayLike | None = None,
    mass: ArrayLike = 1.0,
    fixed: ArrayLike | None = None,
    displacement: ArrayLike | None = None,
    force: ArrayLike | None = None,
    volumes: Volumes | None = None,
    cells: ArrayLike | None = None,
    law: SpringLaw = LINEAR,
    body: Body | None = None,
) -> Network:
    """Build a network from any list of points and springs.

    Parameters
    ----------
    points
        Reference positions (m), shape (n, d), d = 2 or 3.
    springs
        Pairs of different points, shape (m, 2).
    stiffness
        Stiffness (N/m) of the springs, shape (m,) or one number for all.
    rest_length
        Rest lengths (m), shape (m,) or one number. Default: the distances of the points, so that
        the network has no prestress.
    mass
        Masses (kg) of the points, shape (n,) or one number, > 0.
    fixed
        Components with prescribed displacement, boolean array of shape (n, d). Default: none.
    displacement
        Prescribed displacements (m), shape (n, d), 0 where the component is free. Default: zero.
    force
        External forces (N), shape (n, d). Default: zero.
    volumes
        Cells with a volume energy, on the same points. Default: none.
    cells
        Points of the cells that are checked for folding, shape (c, corners), in the order of VTK.
    law
        Constitutive law of the springs. Default: linear (Hooke).
    body
        Problem and lattice that the network stands for. Default: none.

    Returns
    -------
    Network
        Network with read-only arrays.

    Raises
    ------
    ProblemError
        If an array does not fit, a spring joins a point to itself, names a missing point or has
        zero length, or a value is out of its range.

    Examples
    --------
    >>> from msvalidate import spring_network
    >>> points = [[0.0, 0.0], [0.37, 0.0], [0.0, 0.2]]  # m
    >>> network = spring_network(points, [[0, 1], [1, 2], [2, 0]], stiffness=100.0)
    >>> network.rest_length.round(3).tolist()
    [0.37, 0.421, 0.2]
    """
    x = finite_coordinates("points", points, "n", (2, 3))
    pairs = check_springs(springs, len(x))
    distance = np.linalg.norm(x[pairs[:, 1]] - x[pairs[:, 0]], axis=1)
    zero = np.zeros(x.shape)
    return Network(
        points=x,
        springs=pairs,
        stiffness=broadcast_values("stiffness", stiffness, len(pairs)),
        # What has no length is refused for that, not for the rest length it would be given.
        rest_length=np.where(distance > 0, distance, 1.0)
        if rest_length is None
        else broadcast_values("rest_length", rest_length, len(pairs)),
        mass=broadcast_values("mass", mass, len(x)),
        fixed=boolean_mask("fixed", zero if fixed is None else fixed, x.shape),
        displacement=finite("displacement", zero if displacement is None else displacement),
        force=finite("force", zero if force is None else force),
        volumes=volumes,
        cells=None if cells is None else integers("cells", cells),
        law=law,
        body=body,
    )
