"""Regions of a body by name, coordinates or node of its mesh."""

from __future__ import annotations

import difflib
from typing import Any

import numpy as np

from msvalidate.case.file.faces import face_lines
from msvalidate.case.file.reading import CaseError, Keys, Source
from msvalidate.case.file.schema import Contact, Interval, Load, Place, Support
from msvalidate.case.file.units import LENGTH as UNITS
from msvalidate.problem import (
    AXES,
    SIDES,
    Boundary,
    CellSet,
    Domain,
    Mesh,
    Part,
    Polygon,
    Problem,
    ProblemError,
    Region,
    Segment,
)
from msvalidate.problem.checks import format_value, positive_number

EDGE = "edge "
"""Prefix of the names of polygon sides.

"edge 1" is from the first vertex to the second.
"""


def unit_in_metres(name: str, given: str | float) -> float:
    """A unit of length in m, by its name or as a number; raise `ProblemError` for any other."""
    if isinstance(given, str) and given in UNITS:
        return UNITS[given]
    try:
        return positive_number(name, given, "m")  # type: ignore[arg-type]  # it refuses a text
    except ProblemError as error:
        raise ProblemError(
            f"{name}: {format_value(given)}; choose {', '.join(UNITS)}, or a number in m above zero"
        ) from error


def region_by_coordinates(source: Source, path: Keys, given: Place, domain: Domain) -> Region:
    """A region by coordinates."""
    unit = unit_in_metres("unit", source.data.body.unit)
    with source.at(*path):
        if domain.dim == 2 and given.z is not None:
            raise ProblemError("z: the body is plane; leave it out")
        entries = (given.x, given.y, given.z)[: domain.dim]
        return Region(tuple(_extent(entry, unit) for entry in entries))


def _extent(entry: Interval | None, unit: float) -> float | tuple[float, float] | None:
    if entry is None:
        return None
    if isinstance(entry, tuple):
        low, high = entry
        return (unit * low, unit * high)
    return unit * entry


def _side(source: Source, path: Keys, name: str, domain: Domain) -> Part:
    """A side by its name: a mesh's own, or left, right and so on at the ends of the body's span."""
    with source.at(*path):
        if isinstance(domain, Mesh) and name in domain.boundaries:
            return domain.side(name)
        if isinstance(domain, Polygon) and name.startswith(EDGE):
            return _edge(name, domain)
        known = [each for each, (axis, _) in SIDES.items() if axis < domain.dim]
        if name in known:
            return _end_of_span(name, domain)
        ends = ", ".join(known)
        if isinstance(domain, Mesh):
            known = [*domain.boundaries, *known]
        elif isinstance(domain, Polygon):
            known += [f"{EDGE}{i + 1}" for i in range(min(len(domain.vertices), 8))]
        near = difflib.get_close_matches(name, known, n=1)
        hint = f"did you mean {near[0]}? " if near else ""
        said = f"{format_value(name)}: {hint}the body has {', '.join(known)}"
        if isinstance(domain, Mesh) and domain.boundaries:
            said = f"{format_value(name)}: {hint}no such side; name another, or an end: {ends}"
        raise side_error(source, path, said, domain)


def side_error(source: Source, path: Keys, message: str, domain: Domain) -> CaseError:
    """Error with an example, whose note describes the named sides of a mesh."""
    mesh = isinstance(domain, Mesh) and list(domain.boundaries)
    side = mesh[0] if mesh else "left"
    error = source.error(path, f'{message}; for example on = "{side}"')
    if isinstance(domain, Mesh) and domain.boundaries:
        unit = source.data.body.unit
        error.mesh, error.length = domain, unit if isinstance(unit, str) else "m"
        error.add_note("\n".join(face_lines(domain, error.length)))
    return error


def _end_of_span(name: str, domain: Domain) -> Part:
    """The side at one end of the body's span: left is where x is least."""
    axis, end = SIDES[name]
    at = domain.span[axis][end]
    if not isinstance(domain, Polygon):
        return Region(tuple(at if a == axis else None for a in range(domain.dim)))
    ends = np.stack([domain.corners, np.roll(domain.corners, -1, axis=0)], axis=1)
    (there,) = np.nonzero((np.abs(ends[:, :, axis] - at) <= domain.tolerance).all(axis=1))
    if len(there) != 1:
        raise ProblemError(
            f"{name!r}: {len(there)} edges of the polygon lie at {AXES[axis]} = {at:g} m; name one "
            f"as edge 1 to edge {len(ends)}"
        )
    return _edge(f"{EDGE}{there[0] + 1}", domain)


def _edge(name: str, domain: Polygon) -> Segment:
    number = name.removeprefix(EDGE)
    count = len(domain.vertices)
    if not (number.isascii() and number.isdigit() and 1 <= int(number[:9]) <= count):
        raise ProblemError(f"{format_value(name)}: the polygon has edge 1 to edge {count}")
    start = domain.vertices[int(number) - 1]
    end = domain.vertices[int(number) % count]
    return Segment(start, end)


def named_part(source: Source, path: Keys, given: Support | Load | Contact, domain: Domain) -> Part:
    """The part that `on` or `at` names."""
    if (given.on is None) == (given.at is None):
        said = "both on and at" if given.on is not None else "no place"
        raise source.error(path, f"{said}; give one of on and at")
    if given.on is not None:
        return _side(source, (*path, "on"), given.on, domain)
    return region_by_coordinates(source, (*path, "at"), given.at or Place(), domain)


def mesh_names(problem: Problem) -> dict[str, str]:
    """Names in the mesh file of supports, loads and regions, by number."""
    parts: dict[str, list[Any]] = {
        "support": [each.region for each in problem.supports],
        "load": [getattr(each, "region", None) for each in problem.loads],
        "region": [each.region for each in problem.zones],
    }
    return {
        f"{word} {number}": part.name
        for word, regions in parts.items()
        for number, part in enumerate(regions, 1)
        if isinstance(part, Boundary | CellSet)
    }


def node_region(source: Source, path: Keys, number: int, domain: Domain) -> Region:
    """The place of a node of the mesh."""
    with source.at(*path):
        if not isinstance(domain, Mesh):
            raise ProblemError(f"{number}: the body is a {domain}; nodes are a mesh's")
        if not 0 <= number < len(domain.points):
            raise ProblemError(
                f"{number}: the mesh has nodes 0 to {len(domain.points) - 1}, in the file's order"
            )
        return Region(tuple(domain.points[number].tolist()))
