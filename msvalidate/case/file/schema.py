"""Tables and keys of a case file: their types, units and defaults.

A case is one TOML file. All lengths in it, and in the mesh that it names, are multiples of
`Body.unit`; all else is in SI units. A text with a unit, such as "70 GPa", stands for a number. The
classes are data alone: what the values mean is in `msvalidate.case.file.building`.
"""

from __future__ import annotations

from typing import Annotated

import msgspec
from msgspec import Struct

SCHEMA = 1
"""Version of the format. Files of older versions are read for ever, but for what is gone: route
"shear springs" is refused, and the message says what to take instead."""
QUANTITIES = ("displacement", "reactions", "strain energy", "mean stress", "point stress")
"""Quantities by which springs and elements are compared."""

Numbers = list[float]
Quantity = Annotated[float, msgspec.Meta(extra_json_schema={"title": "quantity"})]
"""Number, or in a file a text with a unit."""
Quantities = list[Quantity]
Interval = Quantity | tuple[Quantity, Quantity]


class Place(Struct, forbid_unknown_fields=True):
    """Coordinates of a part of the body: a number, an interval, or nothing for any."""

    x: Interval | None = None
    y: Interval | None = None
    z: Interval | None = None


class Ball(Struct, forbid_unknown_fields=True):
    """A disc in the plane, a ball in space."""

    centre: Quantities
    radius: Quantity


class Body(Struct, forbid_unknown_fields=True):
    """The body: a box with a corner at the origin, an outline, or a file of a mesh or geometry."""

    box: Quantities | None = None
    polygon: list[Quantities] | None = None
    mesh: str | None = None
    cell: Quantity | None = None
    unit: str | float = "m"


class Material(Struct, forbid_unknown_fields=True):
    """Isotropic: E in Pa, density in kg/m³, thickness in units of length; law at large strain."""

    E: Quantity
    nu: float
    state: str | None = None
    density: Quantity | None = None
    thickness: Quantity | None = None
    law: str = "st-venant-kirchhoff"


class PartOfBody(Struct, forbid_unknown_fields=True):
    """A part of the body of another material: cells of a mesh by name, a box or a ball."""

    E: Quantity
    nu: float
    density: Quantity | None = None
    cells: str | None = None
    box: Place | None = None
    ball: Ball | None = None


class Support(Struct, forbid_unknown_fields=True):
    """Components held on a named side, at a place, or at nodes of the mesh."""

    on: str | None = None
    at: Place | None = None
    nodes: list[int] | None = None
    components: list[str] | None = None
    value: Quantity | Quantities = 0.0


class Load(Struct, forbid_unknown_fields=True):
    """A traction or pressure (Pa), a force (N) at a point, or gravity (m/s²)."""

    on: str | None = None
    at: Place | None = None
    point: Quantities | None = None
    node: int | None = None
    traction: Quantities | None = None
    pressure: Quantity | None = None
    force: Quantities | None = None
    gravity: Numbers | None = None


class Obstacle(Struct, forbid_unknown_fields=True):
    """Foremost point, radius and direction of an obstacle.

    The default direction is across the side that it meets.
    """

    at: Quantities
    radius: Quantity | None = None
    towards: Numbers | None = None


class Contact(Struct, forbid_unknown_fields=True):
    """A rigid obstacle at a side, lowered by a depth or pressed by a force (N)."""

    on: str | None = None
    at: Place | None = None
    half_space: Obstacle | None = None
    disc: Obstacle | None = None
    ball: Obstacle | None = None
    parabola: Obstacle | None = None
    paraboloid: Obstacle | None = None
    depth: Quantity | None = None
    force: Quantity | None = None
    friction: float = 0.0


class Fracture(Struct, forbid_unknown_fields=True):
    """Springs that break: a critical stretch, or a fracture energy (J/m²) and a rule for it."""

    critical_stretch: float | None = None
    G_c: float | None = None
    rule: str = "growth"
    direction: tuple[float, float] = (1.0, 0.0)
    raised: float = 1.0


class Springs(Struct, forbid_unknown_fields=True):
    """The spring network: its lattice, and one of spacing and cells across the narrowest side."""

    on: str = "lattice"
    lattice: str | None = None
    spacing: Quantity | None = None
    cells: int | None = None
    route: str | None = None
    constants: Quantities | None = None
    volume: float | None = None


class Compare(Struct, forbid_unknown_fields=True):
    """At which points, by what, how far apart still agrees, and whether displacements are large."""

    points: str | list[Quantities] = "lattice"
    quantities: list[str] = msgspec.field(default_factory=lambda: list(QUANTITIES))
    band: float = 0.05
    geometry: str | None = None
    memory: float = 4.0


class Reference(Struct, forbid_unknown_fields=True):
    """Accuracy of the elements, relative to the largest displacement."""

    accuracy: float = 1e-3


class CaseFile(Struct, forbid_unknown_fields=True):
    """A whole case file."""

    schema: int
    body: Body
    material: Material
    name: str | None = None
    support: list[Support] = msgspec.field(default_factory=list)
    load: list[Load] = msgspec.field(default_factory=list)
    contact: list[Contact] = msgspec.field(default_factory=list)
    region: list[PartOfBody] = msgspec.field(default_factory=list)
    springs: Springs = msgspec.field(default_factory=Springs)
    fracture: Fracture | None = None
    compare: Compare = msgspec.field(default_factory=Compare)
    reference: Reference = msgspec.field(default_factory=Reference)
