"""From what a case file holds to a `Case`: units, places by name, supports and loads."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterable, Mapping
from itertools import chain
from pathlib import Path
from typing import Any

from msgspec.structs import asdict

from msvalidate.case.file.case import EDGE_ROUTES, GEOMETRIES, MESH_EDGES, Case
from msvalidate.case.file.fracture import Fracture
from msvalidate.case.file.places import (
    named_part,
    node_region,
    region_by_coordinates,
    side_error,
    unit_in_metres,
)
from msvalidate.case.file.reading import Keys, Source, read_source
from msvalidate.case.file.schema import Contact, Load, PartOfBody, Place, Support
from msvalidate.problem import (
    AXES,
    OBSTACLES,
    Ball,
    Box,
    CellSet,
    Domain,
    Isotropic,
    Mesh,
    Obstacle,
    Part,
    PointForce,
    Polygon,
    Problem,
    ProblemError,
    Region,
    Traction,
    Weight,
    Zone,
)
from msvalidate.problem import Contact as ProblemContact
from msvalidate.problem import Load as ProblemLoad
from msvalidate.problem import Support as ProblemSupport
from msvalidate.problem.checks import (
    finite_coordinates,
    finite_number,
    format_value,
    require_one_of,
)
from msvalidate.problem.normals import pressure
from msvalidate.problem.records import replace
from msvalidate.springs.bodies.mesh_file import read_mesh

STATES = ("plane_stress", "plane_strain")
SPRINGS_ON = ("lattice", "mesh")
LOADS = ("traction", "pressure", "force", "gravity")


def read_case(path: str | Path) -> Case:
    r"""Read a case from a TOML file.

    Parameters
    ----------
    path
        Case file; a mesh file that it names lies beside it or below.

    Returns
    -------
    Case
        Comparison task in SI units.

    Raises
    ------
    ProblemError
        If the file is no valid case. The message names the file, line, key, value and remedy.

    Examples
    --------
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> from msvalidate import read_case
    >>> body = "schema = 1\n[body]\nbox = [400, 100]\nunit = 'mm'\n"
    >>> material = "[material]\nE = 1e5\nnu = 0.3\nstate = 'plane_strain'\nthickness = 200\n"
    >>> rest = "[[support]]\non = 'left'\n[[load]]\non = 'right'\ntraction = [0, -10]\n"
    >>> with TemporaryDirectory() as folder:
    ...     file = Path(folder) / "beam.toml"
    ...     _ = file.write_text(body + material + rest)
    ...     case = read_case(file)
    >>> case.problem.domain.size, case.problem.material.thickness
    ((0.4, 0.1), 0.2)
    """
    case = build_case(read_source(path))
    return replace(case, linear_theory="frozen") if _is_frozen(Path(path)) else case


def _is_frozen(path: Path) -> bool:
    """True for an unchanged file of a frozen set, whose checksums lie beside the case's folder."""
    sums = path.resolve().parent.parent / "SHA256SUMS"
    try:
        return hashlib.sha256(path.read_bytes()).hexdigest() in sums.read_text(encoding="utf-8")
    except (OSError, ValueError):
        return False


def build_case(source: Source) -> Case:
    """The case that a file's content asks for; errors as `read_case`."""
    data = source.data
    with source.at("body", "unit"):
        unit = unit_in_metres("unit", data.body.unit)
    with source.at("body"):
        domain = _domain(source, unit)
    material = _material(source, domain, unit)
    parts: dict[str, list[tuple[Any, ...]]] = {
        "region": [(_zone(source, i, z, domain, material),) for i, z in enumerate(data.region)],
        "support": [_support(source, i, each, domain) for i, each in enumerate(data.support)],
    }
    if not data.support:
        raise side_error(source, ("support",), "none; add [[support]] with a side", domain)
    parts["load"] = [(_load(source, i, each, domain),) for i, each in enumerate(data.load)]
    parts["contact"] = [(_contact(source, i, c, domain),) for i, c in enumerate(data.contact)]
    return _case(source, _problem(source, domain, material, parts), unit)


def _problem(
    source: Source, domain: Domain, material: Isotropic, parts: Mapping[str, list[tuple[Any, ...]]]
) -> Problem:
    """The problem; what is wrong with one of its parts stands at the line of that part."""
    name, whole = source.data.name, dict[str, Any]()
    bare: dict[str, Any] = {"supports": (), "loads": ()}
    bare["name"] = Path(source.name).stem if name is None else name
    with source.at("name"):
        Problem(domain, material, **bare)
    words = {"region": "zones", "load": "loads", "contact": "contacts", "support": "supports"}
    for table, word in words.items():
        for i, each in enumerate(parts[table]):
            with source.at(table, i):
                Problem(domain, material, **bare | {word: each})
        whole[word] = tuple(chain.from_iterable(parts[table]))
    with source.at("support"):
        held = whole["supports"]
        Problem(domain, material, held, (), "all together").refuse_free_body()
    return Problem(domain, material, **bare | whole)


def _domain(source: Source, unit: float) -> Domain:
    body = source.data.body
    kind = _one_of(source, ("body",), body, "shape", ("box", "polygon", "mesh"))
    if body.cell is not None and body.mesh is None:
        raise source.error(("body", "cell"), f"of a {kind}; it is of .step and .stl files")
    with source.at("body", kind):
        if body.box is not None:
            return Box(tuple(unit * edge for edge in body.box))
        if body.polygon is not None:
            return Polygon(tuple(tuple(unit * x for x in corner) for corner in body.polygon))  # type: ignore[misc]
        cell = None if body.cell is None else unit * body.cell
        return read_mesh(mesh_path(source.folder, str(body.mesh)), unit, cell)


def _one_of(source: Source, path: Keys, table: object, what: str, keys: Iterable[str]) -> str:
    """The one of some keys that a table has; `what` they are."""
    there = [key for key in keys if getattr(table, key) is not None]
    if len(there) != 1:
        said = " and ".join(there) or f"no {what}"
        raise source.error(path, f"{said}; give one of {', '.join(keys)}")
    return there[0]


def mesh_path(folder: Path, name: str) -> Path:
    """Path of a mesh, or of a link to one, in a case's folder."""
    path = Path(os.path.normpath(folder / name))
    if not path.is_relative_to(folder):
        raise ProblemError(
            f"{format_value(name)}: outside the case's own folder; put the mesh beside the case"
        )
    return path


def _material(source: Source, domain: Domain, unit: float) -> Isotropic:
    given, plane = source.data.material, domain.dim == 2
    state = given.state if plane or given.state is not None else "solid"
    if state not in (STATES if plane else ("solid",)):
        said = "missing" if state is None else format_value(state)
        how = "a plane body is in" if state is None else "choose"
        need = f"{how} {' or '.join(STATES)}" if plane else "a body in space is solid"
        raise source.error(("material", "state"), f"{said}; {need}")
    where = ("material", "thickness")
    if not plane and given.thickness is not None:
        raise source.error(where, "a body in space has none; leave it out")
    if plane and given.thickness is None and unit != 1:
        raise source.error(where, "missing; give it in the unit of the body's lengths")
    with source.at("material"):
        thickness = 1.0 if given.thickness is None else unit * given.thickness
        density = Isotropic.density if given.density is None else given.density
        return Isotropic(given.E, given.nu, state, density, thickness)  # type: ignore[arg-type]


def _zone(
    source: Source, number: int, zone: PartOfBody, domain: Domain, material: Isotropic
) -> Zone:
    """A part of the body of another material."""
    path = ("region", number)
    place = _one_of(source, path, zone, "place", ("cells", "box", "ball"))
    with source.at(*path, place):
        where = _zone_region(source, path, zone, domain)
    with source.at(*path):
        density = material.density if zone.density is None else zone.density
        own = Isotropic(zone.E, zone.nu, material.state, density, material.thickness)
        return Zone(where, own)


def _zone_region(
    source: Source, path: Keys, zone: PartOfBody, domain: Domain
) -> Region | Ball | CellSet:
    unit = unit_in_metres("unit", source.data.body.unit)
    if zone.cells is not None:
        if not isinstance(domain, Mesh):
            raise ProblemError(
                f"{format_value(zone.cells)}: the body is no mesh; give a box or ball"
            )
        return domain.zone(zone.cells)
    if zone.ball is not None:
        centre = tuple(unit * x for x in zone.ball.centre)
        return Ball(centre, unit * zone.ball.radius)
    return region_by_coordinates(source, (*path, "box"), zone.box or Place(), domain)


# Supports and loads -------------------------------------------------------------------------------


def _support(
    source: Source, number: int, support: Support, domain: Domain
) -> tuple[ProblemSupport, ...]:
    path = ("support", number)
    with source.at(*path):
        components = _components(source, number, support, domain.dim)
        if support.nodes is not None:
            if support.on is not None or support.at is not None:
                raise ProblemError("nodes and a place; give one of on, at and nodes")
            regions: list[Part] = [
                node_region(source, (*path, "nodes"), node, domain) for node in support.nodes
            ]
            if not regions:
                raise source.error((*path, "nodes"), "none; give at least one")
        else:
            regions = [named_part(source, path, support, domain)]
        return tuple(ProblemSupport(region, components) for region in regions)


def _components(
    source: Source, number: int, support: Support, dim: int
) -> tuple[float | None, ...]:
    """Displacement (m) of each axis that a support holds; None where it does not."""
    unit, axes = unit_in_metres("unit", source.data.body.unit), list(AXES[:dim])
    held = axes if support.components is None else support.components
    with source.at("support", number, "components"):
        for name in held:
            require_one_of("component", name, axes)
        if not held or len(set(held)) < len(held):
            raise ProblemError(
                f"{format_value(held)}; name each of {', '.join(axes)} once or not at all"
            )
    with source.at("support", number, "value"):
        values = support.value if isinstance(support.value, list) else [support.value] * len(held)
        if len(values) != len(held):
            raise ProblemError(
                f"{len(values)} values for {len(held)} components, {', '.join(held)}; give one each"
            )
        moved = dict(zip(held, (unit * finite_number("value", v) for v in values), strict=True))
    return tuple(moved.get(axis) for axis in axes)


def _load(source: Source, number: int, load: Load, domain: Domain) -> ProblemLoad:
    path = ("load", number)
    kind = _one_of(source, path, load, "load", LOADS)
    _refuse_place(source, path, load, kind)
    if kind in {"traction", "pressure"}:
        region = named_part(source, path, load, domain)
        with source.at(*path, kind):
            if load.pressure is not None:
                return pressure(region, domain, load.pressure)
            return Traction(region, tuple(load.traction or ()))
    if load.force is not None:
        at = _point(source, path, load, domain)
        with source.at(*path, "force"):
            return PointForce(at, tuple(load.force))
    with source.at(*path, "gravity"):
        return Weight(tuple(load.gravity or ()))


def _refuse_place(source: Source, path: Keys, load: Load, kind: str) -> None:
    """Refuse a place that does not go with a kind of load."""
    goes = {"force": ("point", "node"), "gravity": ()}.get(kind, ("on", "at"))
    for key in ("on", "at", "point", "node"):
        if getattr(load, key) is not None and key not in goes:
            need = f"it acts at {' or '.join(goes)}" if goes else "it acts on the whole body"
            raise source.error((*path, key), f"goes with no {kind}: {need}; leave {key} out")


def _point(source: Source, path: Keys, load: Load, domain: Domain) -> tuple[float, ...]:
    """The place (m) of a point force."""
    if (load.point is None) == (load.node is None):
        raise source.error((*path, "force"), "give its place, by point or by node")
    if load.node is not None:
        place = node_region(source, (*path, "node"), load.node, domain).extent
        return tuple(float(x) for x in place)  # type: ignore[arg-type]
    unit = unit_in_metres("unit", source.data.body.unit)
    return tuple(unit * x for x in load.point or ())


def _contact(source: Source, number: int, contact: Contact, domain: Domain) -> ProblemContact:
    """An obstacle at a side; lengths are in the unit of the body's."""
    path, unit = ("contact", number), unit_in_metres("unit", source.data.body.unit)
    if number:
        said = "a second one; elements meet one obstacle, leave the others out"
        raise source.error(path, said)
    shape = _one_of(source, path, contact, "obstacle", OBSTACLES)
    if contact.depth is None and contact.force is None:
        raise source.error(path, "neither depth nor force; give one of them")
    region = named_part(source, path, contact, domain)
    told = getattr(contact, shape)
    with source.at(*path, shape):
        towards = told.towards
        if towards is None:
            axis = next(iter(region.normal_axes), None) if isinstance(region, Region) else None
            if axis is None:
                raise ProblemError("towards: missing; give the way into the body")
            low, high = domain.span[axis]
            end = float(region.extent[axis])  # type: ignore[union-attr,arg-type]
            towards = [(-1.0 if 2 * end > low + high else 1.0) * (a == axis)
                       for a in range(domain.dim)]  # fmt: skip
        radius = None if told.radius is None else unit * told.radius
        at = tuple(unit * x for x in told.at)
        obstacle = Obstacle(shape, at, tuple(towards), radius)
    with source.at(*path):
        depth = unit * (contact.depth or 0.0)
        return ProblemContact(region, obstacle, depth, contact.force, contact.friction)


# The rest -----------------------------------------------------------------------------------------


def _is_on_mesh(source: Source, problem: Problem) -> bool:
    """Return True if a case requests springs on the body's own mesh.

    Other keys of the springs that such springs do not have are rejected.
    """
    given, where = source.data.springs, ("springs", "on")
    if given.on not in SPRINGS_ON:
        raise source.error(where, f"{format_value(given.on)}; choose {' or '.join(SPRINGS_ON)}")
    if given.on == SPRINGS_ON[0]:
        return False
    if not isinstance(problem.domain, Mesh):
        raise source.error(
            where, f"{problem.domain} has no mesh: give a file of one, or on = 'lattice'"
        )
    for name in ("lattice", "route", "constants", "volume"):
        value = getattr(given, name)
        if value not in (None, EDGE_ROUTES[1]):
            raise source.error(
                where, f"'mesh' with {name} {format_value(value)}; leave {name} out, as these "
                "springs are the material's, or take on = 'lattice'"
            )  # fmt: skip
    if source.data.fracture is not None:
        raise source.error(
            where, "'mesh' with [fracture]; springs that break rest at a length: on = 'lattice'"
        )
    return True


def _case(source: Source, problem: Problem, unit: float) -> Case:
    """The case; what is wrong with its values stands at the line of their table."""
    data = source.data
    springs, compare, given = data.springs, data.compare, data.compare.points
    with source.at("compare", "points"):
        points = given if isinstance(given, str) else unit * finite_coordinates("points", given)
    on_mesh = _is_on_mesh(source, problem)
    tables: dict[str, dict[str, Any]] = {
        "springs": {
            "lattice": MESH_EDGES if on_mesh else springs.lattice,
            "spacing": None if springs.spacing is None else unit * springs.spacing,
            "cells": springs.cells,
            "route": EDGE_ROUTES[1] if on_mesh else springs.route,
            "constants": None if springs.constants is None else tuple(springs.constants),
            "volume": springs.volume or 0.0,
        },
        "reference": {"accuracy": data.reference.accuracy},
        "material": {"law": data.material.law},
        "fracture": {},
        "compare": {
            "points": points,
            "quantities": tuple(compare.quantities),
            "band": compare.band,
            "memory": compare.memory,
            "geometry": GEOMETRIES[0] if compare.geometry is None else compare.geometry,
            "linear_theory": "requested" if compare.geometry == GEOMETRIES[0] else "",
        },
    }
    notes = {"file": source.name, "text": source.text}
    if data.material.density is None:
        notes["density"] = f"{Isotropic.density:g} kg/m³ (default)"
    values: dict[str, Any] = {"unit": data.body.unit if isinstance(data.body.unit, str) else "m"}
    for name, own in tables.items():
        with source.at(name):
            if name == "fracture" and data.fracture is not None:
                own["fracture"] = Fracture(**asdict(data.fracture))
            values |= own
            case = Case(problem, **values, notes=notes)
    return case
