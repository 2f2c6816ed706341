"""Boundary value problem: domain, material, supports, loads and contacts."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, get_args

import numpy as np

from msvalidate.problem.arrays import AXES, PLACEMENT, Array, Field, Index, Mask
from msvalidate.problem.checks import (
    check_name,
    finite,
    finite_coordinates,
    finite_number,
    format_value,
    require_type,
)
from msvalidate.problem.contact import Contact
from msvalidate.problem.domain import Box, Domain, Polygon, corners_of, refuse_off_body
from msvalidate.problem.errors import ProblemError
from msvalidate.problem.loads import (
    BodyForce,
    Load,
    Traction,
    Weight,
    as_tuple,
    check_region,
    check_vector,
)
from msvalidate.problem.material import Isotropic, Material
from msvalidate.problem.mesh import Mesh
from msvalidate.problem.motions import format_point, refuse_free_motions
from msvalidate.problem.records import dataclass, field, replace
from msvalidate.problem.region import Boundary, Part, Region
from msvalidate.problem.shapes import facet_middles
from msvalidate.problem.zone import Zone, refuse_other_state


@dataclass(frozen=True)
class Support:
    """Prescribed displacement components on a region: a Dirichlet boundary condition.

    Parameters
    ----------
    region
        Part of the body: a point, edge, face or interval as `Region`, a segment, a named boundary
        of a `Mesh`, or the name of a side of the problem's domain.
    displacement
        One entry per axis: a value (m), a function of points (n, d) in m that returns (n,) in m, or
        None for a free component. One number applies to all axes. Default: clamped, 0.

    Raises
    ------
    ProblemError
        If there is not one entry per axis, every entry is None, or a value is not a finite number.

    Examples
    --------
    >>> from msvalidate import Box, Support
    >>> box = Box((0.4, 0.1))
    >>> clamp = Support("left")
    >>> roller = Support(box.side("bottom"), (None, 0.0))
    """

    region: Part
    displacement: tuple[float | Field | None, ...]

    def __init__(
        self, region: Part | str, displacement: Sequence[float | Field | None] | float = 0.0
    ) -> None:
        given: Any = as_tuple(displacement)
        object.__setattr__(self, "region", region)
        object.__setattr__(self, "displacement", given)
        if isinstance(region, str):  # which the problem resolves
            return
        check_region("support", region)
        name = f"support on {region}"
        if not isinstance(given, tuple):
            given = (finite_number(name, given),) * region.dim
            object.__setattr__(self, "displacement", given)
        if len(given) != self.region.dim:
            raise ProblemError(
                f"{name}: {len(given)} components for {self.region.dim} axes; give a value, a "
                "field or None for each"
            )
        if all(value is None for value in given):
            raise ProblemError(f"{name}: holds no component; leave it out")
        for value in given:
            if value is None or callable(value):
                continue
            if finite_coordinates(name, value).ndim:
                raise ProblemError(
                    f"{name}: component {format_value(value)}; give one number, a field or None"
                )


SLIGHT = 1e-8
"""Indentation relative to the body from which rounding of gaps leaves it seven digits."""


@dataclass(frozen=True, eq=False)
class Problem:
    """Boundary value problem: a body with its material, supports, loads and contacts.

    Parameters
    ----------
    domain
        The body: a `Box`, `Polygon` or `Mesh`.
    material
        Material of the body outside its zones, `Isotropic` or `Anisotropic`.
    supports
        Prescribed displacements (Dirichlet boundary conditions): `Support`, one or several.
    loads
        `PointForce`, `Traction`, `BodyForce` and `Weight`, one or several.
    name
        Name of the problem in messages.
    zones
        Parts of other materials, `Zone`. Where zones overlap, the last one counts.
    contacts
        Rigid obstacles that the body may touch.

    Raises
    ------
    ProblemError
        If the parts do not fit together, such as a 3D material in a 2D domain or a load off the
        body. Rigid-body motion is not excluded here: see `refuse_free_body`.

    Examples
    --------
    >>> from msvalidate import Box, Isotropic, Problem, Support, Traction
    >>> beam = Box((0.4, 0.1))
    >>> problem = Problem(
    ...     domain=beam,
    ...     material=Isotropic(E=1e5, nu=1 / 3, thickness=0.2),
    ...     supports=(Support(beam.side("left"), (0.0, 0.0)),),
    ...     loads=(Traction(beam.side("right"), (0.0, -10.0)),),
    ... )
    >>> problem.refuse_free_body()  # raises ProblemError if the body could move rigidly
    """

    domain: Domain
    material: Material
    supports: tuple[Support, ...]
    loads: tuple[Load, ...] = ()
    name: str = field(default="problem")
    zones: tuple[Zone, ...] = ()
    contacts: tuple[Contact, ...] = ()

    def __post_init__(self) -> None:
        check_name("problem name", self.name)
        require_type(f"{self.name}: material", self.material, Material)
        require_type(f"{self.name}: domain", self.domain, Domain)
        for name, kind in (
            ("supports", Support),
            ("loads", Load),
            ("zones", Zone),
            ("contacts", Contact),
        ):
            value = getattr(self, name)
            parts = (value,) if isinstance(value, kind) else as_tuple(value)
            if not isinstance(parts, tuple) or not all(isinstance(part, kind) for part in parts):
                one = " or ".join(k.__name__ for k in get_args(kind) or (kind,))
                raise ProblemError(
                    f"{self.name}: {name} {format_value(value)}; give a list of {one}"
                )
            object.__setattr__(self, name, tuple(map(self._resolve_side, parts)))
        d = self.domain.dim
        if self.material.dim != d:
            raise ProblemError(f"{self.name}: a {self.material.dim}D material in a {d}D domain")
        for zone in self.zones:
            refuse_other_state(zone, self.material)
            refuse_off_body(zone, self.domain)
        for load in self.loads:
            if isinstance(load, BodyForce):
                check_vector("body force", load.force, d)
                continue
            if isinstance(load, Weight):
                check_vector("weight", load.acceleration, d)
                continue
            corners = corners_of(load.region, self.domain)
            if isinstance(load, Traction):
                _refuse_off_side("traction", load.region, self.domain, corners)
        for contact in self.contacts:
            corners = corners_of(contact.region, self.domain)
            _refuse_off_side("contact", contact.region, self.domain, corners)
            _refuse_centre_inside(contact, self.domain)
        self._support_corners()

    def _resolve_side(self, part: Any) -> Any:
        """Return a support or load whose region, if named, is the domain's side of that name."""
        name = getattr(part, "region", None)
        if not isinstance(name, str):
            return part
        if isinstance(self.domain, Polygon):
            raise ProblemError(
                f"{self.name}: side {format_value(name)}: a polygon has no names; give a Segment"
            )
        return replace(part, region=self.domain.side(name))

    @property
    def materials(self) -> tuple[Material, ...]:
        """The body's material, then that of each zone."""
        return (self.material, *(zone.material for zone in self.zones))

    def refuse_slight_force(self) -> None:
        """Raise `ProblemError` if rounding of gaps hides what an obstacle's force indents.

        The indentation is estimated from the largest modulus and compared with 1e-8 of the body's
        length. Solvers call it only after a failure: an obstacle that starts near the surface may
        have a solution for a smaller force.
        """
        length = float(np.ptp(self.domain.span, axis=1).max())
        side = length if self.domain.dim == 3 else self.material.thickness
        E = (m.E if isinstance(m, Isotropic) else float(np.abs(m.C).max()) for m in self.materials)
        stiffness = max(E) * side
        for contact in self.contacts:
            if contact.force is not None and contact.force < SLIGHT * stiffness * length:
                raise ProblemError(
                    f"contact on {contact.region}: {contact.force:g} N indent the body by about "
                    f"{contact.force / stiffness:.1g} m, which rounding of the gaps hides; take "
                    f"{2 * SLIGHT * stiffness * length:.1g} N or more"
                )

    def _support_corners(self) -> tuple[Array, Mask]:
        """Corners of the supported regions and their fixed components.

        They are (k, d) in m, and a mask (k, d). A rigid motion is affine, so it vanishes on a
        region if it vanishes on its corners.

        Raises `ProblemError` if a support is not on one side of the body.
        """
        corners: list[Array] = []
        held: list[list[bool]] = []
        for support in self.supports:
            ends = corners_of(support.region, self.domain)
            # A plane that cuts a box holds it wherever it is; other bodies may end on its way.
            inner = isinstance(self.domain, Box) and isinstance(support.region, Region)
            if support.region.is_facet and not inner:
                _refuse_off_side("support", support.region, self.domain, ends)
            corners.extend(ends)
            held += [[value is not None for value in support.displacement]] * len(ends)
        d = self.domain.dim
        return np.array(corners).reshape(-1, d), np.array(held, dtype=bool).reshape(-1, d)

    def refuse_free_body(self) -> None:
        """Raise `ProblemError` if the body, or a piece of it, can move rigidly.

        The message names each. What solves for rest asks it before it meshes.
        """
        refuse_free_motions(self.name, *self._support_corners())
        mesh = self.domain
        if not isinstance(mesh, Mesh) or not mesh.pieces.any():
            return
        held = np.zeros(mesh.points.shape, dtype=bool)
        for support in self.supports:
            on = support.region.select(mesh.points, mesh.tolerance)
            held |= on[:, None] & [value is not None for value in support.displacement]
        many = int(mesh.pieces.max()) + 1
        for piece in range(many):
            own = mesh.pieces == piece
            at = format_point(mesh.points[own].mean(axis=0))
            said = f"{self.name}: the mesh is in {many} pieces, and of that around {at} m"
            refuse_free_motions(said, mesh.points[own], held[own])


def prescribed_displacements(problem: Problem, points: Array) -> tuple[Mask, Array]:
    """Components held (n, d) and the displacement (n, d) in m prescribed there, 0 elsewhere.

    Raises `ProblemError` if a support meets none of the points, or two supports contradict each
    other.
    """

    def on_region(support: Support) -> Mask:
        chosen = support.region.select(points, problem.domain.tolerance)
        if chosen.any():
            _refuse_cut_short(problem, support, points[chosen])
        return chosen

    return prescribed_displacements_at(problem, points, on_region)


def prescribed_displacements_at(
    problem: Problem, points: Array, holds: Callable[[Support], Mask]
) -> tuple[Mask, Array]:
    """As `prescribed_displacements`, at the points (n,) that `holds` selects.

    For bodies whose points do not lie on the supports.

    Raises `ProblemError` if a support holds none of the points, or two supports contradict each
    other.
    """
    require_type("problem", problem, Problem)
    shape: tuple[int, ...] = getattr(points, "shape", ())
    if len(shape) != 2 or shape[1] != problem.domain.dim:
        raise ProblemError(f"points: shape {shape}; give an array (n, {problem.domain.dim})")
    wishes: list[tuple[int, Index, Array]] = []
    for support in problem.supports:
        chosen = np.flatnonzero(holds(support))
        if not len(chosen):
            raise ProblemError(
                f"support on {support.region}: no point of the discretised body lies there; "
                "choose cells that put one there"
            )
        for axis, entry in enumerate(support.displacement):
            if entry is not None:
                wanted = _component_values(f"support on {support.region}", entry, points[chosen])
                wishes.append((axis, chosen, wanted))
    held = np.zeros(points.shape, dtype=bool)
    value = np.zeros(points.shape)
    # A field that should vanish where it meets another may come out as 1e-17 there.
    room = PLACEMENT * max((np.abs(wanted).max() for _, _, wanted in wishes), default=0.0)
    for axis, chosen, wanted in wishes:
        before = value[chosen, axis]
        clash = np.flatnonzero(held[chosen, axis] & (np.abs(before - wanted) > room))
        if len(clash):
            at = clash[0]
            raise ProblemError(
                f"supports contradict each other: {AXES[axis]} displacement {before[at]:g} and "
                f"{wanted[at]:g} m at {format_point(points[chosen[at]])}; prescribe it once"
            )
        held[chosen, axis], value[chosen, axis] = True, wanted
    return held, value


def _refuse_cut_short(problem: Problem, support: Support, chosen: Array) -> None:
    """Refuse part of a side that ends between points: less than the given part would be fixed.

    Nodes of finer cells on a curve may reach beyond those that it was named by.
    """
    for axis, wanted in enumerate(corners_of(support.region, problem.domain).T):
        reached = chosen[:, axis].min(), chosen[:, axis].max()
        missed = max(reached[0] - wanted.min(), wanted.max() - reached[1])
        if missed > problem.domain.tolerance:
            raise ProblemError(
                f"support on {support.region}: the discretised body has points from "
                f"{AXES[axis]} = {reached[0]:g} to {reached[1]:g} m there, not at its ends; "
                "choose cells that put one at each"
            )


def _refuse_centre_inside(contact: Contact, domain: Domain) -> None:
    """Refuse a disc or ball so deep that it has no normal in the body."""
    if not contact.obstacle.is_round:
        return
    centre = contact.obstacle.centre(contact.depth)
    low, high = np.array(domain.span).T
    if ((centre > low) & (centre < high)).all() and domain.contains(centre).all():
        raise ProblemError(
            f"contact on {contact.region}: the centre of the {contact.obstacle.shape}, "
            f"{format_point(centre[0])} m, is in the body; lower it less, or place it outside"
        )


def _refuse_off_side(what: str, region: Part, domain: Domain, corners: Array) -> None:
    if isinstance(region, Boundary):  # all nodes of a facet may be on sides that it joins
        corners = np.concatenate([corners, facet_middles(region.places)])
    if not domain.on_boundary(corners):
        raise ProblemError(
            f"{what} on {region}: from {format_point(corners[0])} to {format_point(corners[-1])} m "
            "it is not on one side of the body all the way; give a part of a side, such as a "
            "Segment"
        )


def _component_values(name: str, entry: float | Field, points: Array) -> Array:
    """Evaluate a prescribed displacement component at the points: a field or a number."""
    if not callable(entry):
        return np.full(len(points), float(entry))
    values = finite_coordinates(name, entry(points))
    if values.shape != (len(points),):
        raise ProblemError(f"{name}: the field returned shape {values.shape}, not {(len(points),)}")
    return values


def vectors_at(name: str, entry: Sequence[float] | Field, points: Array) -> Array:
    """Vector quantity (n, d) at points (n, d): a field evaluated, a constant repeated.

    Raises `ProblemError` if a field returns another shape, or a value that is not finite.
    """
    if not callable(entry):
        return np.tile(finite(name, entry), (len(points), 1))
    values = finite(name, entry(points))
    if values.shape != points.shape:
        raise ProblemError(f"{name}: the field returned shape {values.shape}, not {points.shape}")
    return values
