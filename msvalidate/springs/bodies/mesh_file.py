"""Meshes from files of Gmsh, VTK or Abaqus; no other module uses meshio.

Names of boundaries are what the file holds for them:

- Gmsh: physical groups of lines or surfaces, by name, or by number where they have none.
- Abaqus: element sets of line or surface elements, and node sets. `*SURFACE` is not read, nor are
  hexahedra of 27 nodes.
- VTK: lines or surface cells by any array of whole numbers in the cell data, as ``ARRAY:VALUE``;
  and arrays of point data that hold 0 and 1 alone, as sets of points.

A set of points stands for the facets of the surface all of whose nodes are in it. Sets of points
that make no facet name no boundary.

Groups and sets of the body's own cells name zones of it in the same way, in VTK's arrays of cell
data by zeros and negative numbers too. An array of more than `MOST_ZONES` values numbers cells: it
names none.
"""

from __future__ import annotations

import base64
import contextlib
import importlib
import io
import lzma
import re
import tempfile
import zlib
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from xml.parsers import expat

import meshio
import numpy as np

from msvalidate.problem import SHAPES, Array, Index, Mesh, ProblemError
from msvalidate.problem.checks import (
    LONGEST_NAME,
    finite,
    finite_coordinates,
    format_value,
    positive_number,
)
from msvalidate.springs.bodies.geometry_file import GEOMETRIES, meshed_geometry

FORMATS = {".msh": "gmsh", ".vtu": "vtu", ".vtk": "vtk", ".inp": "abaqus"}
"""Suffix -> meshio's name of the format."""
LARGEST_FILE = 1_000_000_000
"""Bytes of a mesh file beyond which it is not read."""
MOST_UNPACKED, UNPACKED = 100_000_000, 20
"""Maximum size of unpacked blocks: in bytes, and relative to the file.

The larger of both applies, up to `LARGEST_FILE`.
"""
PARAMETRIC = b"$ParametricNodes"
"""Section of a .msh 2.2 file that takes the place of $Nodes."""
DEEPEST = 100
"""Elements of XML in each other, beyond which a file is refused."""
PLANE = 1e-9
"""Relative variation of the third coordinate of a 2D mesh."""
MOST_ZONES = 200
"""Values of an array of cell data up to which each is a zone's name."""


def read_mesh(path: str | Path, unit: float = 1.0, cell: float | None = None) -> Mesh:
    r"""Read a mesh with its named boundaries and zones from a file.

    Cells of the highest dimension form the body; named cells of one dimension less become
    boundaries. A 2D mesh may have a constant third coordinate, which is dropped.

    Parameters
    ----------
    path
        File in the format of Gmsh (.msh, 2.2 or 4.1), VTK (.vtu, .vtk) or Abaqus (.inp). STEP and
        STL files (.step, .stl) are meshed if gmsh is installed.
    unit
        Length (m) of the unit of the file's coordinates: 1e-3 for mm.
    cell
        Largest size (m) of the cells that are generated for STEP and STL files. Default: 1/25 of
        the body's diagonal. Files with cells of their own must be read without it.

    Returns
    -------
    Mesh
        Body with its coordinates in m.

    Raises
    ------
    ProblemError
        If the file is missing, unreadable, incomplete or of another format, its cells are of
        several or of unsupported kinds, or they form no valid `Mesh`; if a STEP or STL file cannot
        be meshed, or gmsh is not installed; or if `unit` or `cell` is out of its range.

    Examples
    --------
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> from msvalidate import read_mesh
    >>> nodes = "*NODE\n1, 0, 0\n2, 370, 0\n3, 0, 200\n"  # in mm
    >>> elements = "*ELEMENT, TYPE=CPS3\n1, 1, 2, 3\n"
    >>> with TemporaryDirectory() as folder:
    ...     file = Path(folder) / "triangle.inp"
    ...     _ = file.write_text(nodes + elements)
    ...     mesh = read_mesh(file, unit=1e-3)
    >>> print(mesh)
    mesh of 1 triangle cells, 0.37 x 0.2 m
    """
    positive_number("mesh file: unit", unit, "m")
    file = _check_path(path)
    said = f"mesh file {format_value(file.name)}"
    if file.suffix.lower() in GEOMETRIES:
        size = None if cell is None else positive_number("mesh file: cell", cell, "m") / unit
        with meshed_geometry(file, size) as made:
            return read_mesh(made, unit)
    if cell is not None:
        raise ProblemError(f"{said}: has cells of its own; leave out cell, which is of .step files")
    content = _read_content(file, said)
    shape, cells = _body_cells(content, said)
    try:
        points = _coordinates(content.points, SHAPES[shape].dim, unit, _group_hint(content))
        cells = _orient_cells(points, cells, shape)
        mesh = Mesh(points, cells, shape)
        return mesh.named(_boundaries(content, file, mesh), _zones(content, file, mesh))
    except ProblemError as error:
        raise ProblemError(f"{said}: {error}") from error


def read_points(path: str | Path) -> tuple[Array, dict[str, Any]]:
    """Read the points (n, 3) of a file, and its point data by name.

    The values of point data are (n, ...); units are those of the file.

    Raises
    ------
    ProblemError
        As `read_mesh`, but for what no mesh can be made of.
    """
    file = _check_path(path)
    content = _read_content(file, f"mesh file {format_value(file.name)}")
    return np.asarray(content.points, dtype=float), dict(content.point_data)


def _check_path(path: object) -> Path:
    if not isinstance(path, str | Path):
        raise ProblemError(f"mesh file: {format_value(path)}; give a path")
    file = Path(path)
    known = (*FORMATS, *GEOMETRIES)
    if file.suffix.lower() not in known:
        raise ProblemError(f"mesh file {format_value(file.name)}: give one of {', '.join(known)}")
    try:
        with file.open("rb") as opened:
            empty = not opened.read(1)
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", None) or str(error)
        raise ProblemError(
            f"mesh file {format_value(str(path))}: {why}; give a file to read"
        ) from error
    if empty:
        raise ProblemError(f"mesh file {format_value(file.name)}: empty; write it again")
    return file


def _read_content(file: Path, label: str) -> Any:
    """Read a file with meshio, without its output and its exits."""
    form = FORMATS[file.suffix.lower()]
    _refuse_before_reading(file, form, label)
    heard = io.StringIO()
    try:
        with (
            contextlib.redirect_stdout(heard),
            contextlib.redirect_stderr(heard),
            _bounded(file),
            _plain_nodes(file, form) as plain,
        ):
            content = meshio.read(plain, file_format=form)
    except ProblemError as error:
        raise ProblemError(f"{label}: {error}") from error
    except (Exception, SystemExit) as error:  # whatever its parsers stumble over
        lines = [line for line in heard.getvalue().splitlines() if "Couldn't read" not in line]
        why = str(error) if isinstance(error, meshio.ReadError) else "".join(lines[:1])
        what = format_value(why).strip("'\"") or "it ends too soon, or is of another format"
        remedy = (
            "write it with Mesh.SaveParametric = 0" if "parametric" in what else "write it again"
        )
        raise ProblemError(f"{label}: not a whole {form} file: {what}; {remedy}") from error
    if "not closed" in heard.getvalue() or _announced_cells(file, form) > sum(
        map(len, content.cells)
    ):
        raise ProblemError(f"{label}: it ends too soon; write it again")
    if not len(content.points) or not len(content.cells):
        raise ProblemError(f"{label}: no {'cells' if len(content.points) else 'points'} in it")
    return content


@contextlib.contextmanager
def _plain_nodes(file: Path, form: str) -> Iterator[Path]:
    """The file, or of Gmsh a copy without the parameters of nodes, which meshio does not read."""
    head, _, rest = (file.read_bytes() if form == "gmsh" else b"").partition(PARAMETRIC)
    nodes, end, last = rest.partition(b"$EndParametricNodes")
    if not end:
        yield file
        return
    if b"\n2.2 0 " not in head:
        raise ProblemError("parameters of nodes in binary; write without: Mesh.SaveParametric = 0")
    plain = b"\n".join(b" ".join(line.split()[:4]) for line in nodes.split(b"\n"))
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / "plain.msh"
        copy.write_bytes(b"".join((head, b"$Nodes", plain, b"$EndNodes", last)))
        yield copy


class _Growing(bytearray):
    """Bytes that grow in place; meshio would copy all of them for each block."""

    def __iadd__(self, more: Any) -> _Growing:  # type: ignore[misc]
        self.extend(more)
        return self

    def __radd__(self, before: bytes) -> bytearray:  # type: ignore[misc]
        return bytearray(before) + bytes(self) if before else self


class _Unpacking:
    """Decompressor of a file's blocks that limits their total size."""

    def __init__(self, start: Callable[[], Any], most: int) -> None:
        self._start, self._budget, self._most = start, most, most

    def decompress(self, block: bytes) -> bytearray:
        unpacked = _Growing(self._start().decompress(block, self._budget + 1))
        self._budget -= len(unpacked)
        if self._budget < 0:
            raise ProblemError(f"more than {self._most:g} bytes when unpacked; write fewer fields")
        return unpacked


@contextlib.contextmanager
def _bounded(file: Path) -> Iterator[None]:
    """Limit the bytes that meshio unpacks from a .vtu file.

    In the context, all blocks of zlib, and all of LZMA, may each unpack to the larger of
    `MOST_UNPACKED` and `UNPACKED` times the file's size, at most `LARGEST_FILE`: one packed byte
    may hold a thousand. Beyond that `ProblemError` is raised. Base64 text is read to its first
    padding.
    """
    most = min(LARGEST_FILE, max(MOST_UNPACKED, UNPACKED * file.stat().st_size))
    reader: Any = importlib.import_module("meshio.vtu._vtu")
    own = reader.zlib, reader.lzma, reader.base64
    reader.base64 = SimpleNamespace(b64encode=base64.b64encode, b64decode=_first_decoded)
    reader.zlib = _Unpacking(zlib.decompressobj, most)
    reader.lzma = _Unpacking(lzma.LZMADecompressor, most)
    try:
        yield
    finally:
        reader.zlib, reader.lzma, reader.base64 = own


def _first_decoded(text: str) -> bytes:
    """The first of texts in base64, up to its padding, where Python 3.14 on its own reads on."""
    return base64.b64decode(text.partition("=")[0] + "==")


def _refuse_before_reading(file: Path, form: str, label: str) -> None:
    """Refuse what would take much memory, or lead to other files: meshio follows any path."""
    size = file.stat().st_size
    if size > LARGEST_FILE:
        raise ProblemError(f"{label}: {size:g} bytes; the most is {LARGEST_FILE:g}")
    if form == "vtu":
        _refuse_deep(file, label)
    elif form == "abaqus":
        with file.open(encoding="utf-8", errors="replace") as lines:
            for number, line in enumerate(lines, 1):
                if line.lstrip().upper().replace(" ", "").startswith(("*INCLUDE", "*MANIFEST")):
                    raise ProblemError(
                        f"{label}: line {number} includes another file; join the files into one"
                    )


def _refuse_deep(file: Path, label: str) -> None:
    """Refuse elements in elements without end: the tree of them takes a hundred times the file."""
    outer: list[str] = []

    def begin(name: str, _: object) -> None:
        outer.append(name)
        if len(outer) > DEEPEST:
            raise ProblemError(f"{label}: more than {DEEPEST} elements in each other; write again")

    parser = expat.ParserCreate("iso-8859-1")  # of which all bytes are
    parser.StartElementHandler, parser.EndElementHandler = begin, lambda _: outer.pop()
    with contextlib.suppress(expat.ExpatError), file.open("rb") as data:
        parser.ParseFile(data)


def _announced_cells(file: Path, form: str) -> int:
    """Number of cells that a VTK file of the old kind promises; meshio may come back with less."""
    if form != "vtk":
        return 0
    counts = re.findall(rb"^CELL_TYPES\s+(\d+)", file.read_bytes(), re.MULTILINE)
    return int(counts[0]) if counts else 0


def _body_cells(content: Any, label: str) -> tuple[str, Index]:
    """Shape and nodes (c, k) of the cells of most axes, which must be of one kind."""
    dim = max(block.dim for block in content.cells)
    blocks = [block for block in content.cells if block.dim == dim and len(block.data)]
    count: Counter[str] = Counter()
    for block in blocks:
        count[block.type] += len(block.data)
    found = ", ".join(f"{number} {name}" for name, number in count.items())
    if dim < 2:
        raise ProblemError(
            f"{label}: {found or 'no'} cells; give cells with an area or a volume"
            f"{_group_hint(content)}"
        )
    if len(count) != 1:
        raise ProblemError(f"{label}: cells of several kinds, {found}; mesh the body with one kind")
    (name,) = count
    if name not in SHAPES:
        raise ProblemError(f"{label}: {found} cells; {_remedy(name, dim)}")
    return name, np.concatenate([block.data for block in blocks]).astype(np.intp)


def _remedy(name: str, dim: int) -> str:
    """Recommend a replacement for an unsupported cell type of meshio."""
    family, number = name.rstrip("0123456789"), name.lstrip("abcdefghijklmnopqrstuvwxyz")
    shapes = [shape for shape in SHAPES.values() if shape.dim == dim]
    known = [shape.name for shape in shapes]
    for shape in shapes:
        fuller = shape.degree == 2 and shape.straight.name == family
        if fuller and number and int(number) < len(shape.nodes):
            return (
                f"its middles are missing; write {shape.name} (Gmsh: "
                "Mesh.SecondOrderIncomplete = 0)"
            )
    return f"write {', '.join(known[:-1])} or {known[-1]}"


def _group_hint(content: Any) -> str:
    """Explain that a Gmsh file with groups may lack one for the body."""
    if "gmsh:physical" not in content.cell_data:
        return ""
    return " (Gmsh writes what has a physical group alone: give the body one, or Mesh.SaveAll = 1)"


def _coordinates(points: Any, dim: int, unit: float, hint: str) -> Array:
    """Coordinates (n, dim) in m."""
    with np.errstate(over="ignore"):  # what is too long is refused
        given = finite_coordinates("mesh points", finite("mesh points", points) * unit)
    if given.ndim != 2 or given.shape[1] < dim:
        raise ProblemError(f"points: shape {given.shape}; give {dim} coordinates each")
    if dim == 2 and given.shape[1] == 3:
        off = np.abs(given[:, 2] - given[0, 2])
        if off.max() > PLANE * np.ptp(given[:, :2], axis=0).max():
            raise ProblemError(
                f"plane cells, but z = {given[off.argmax(), 2]:g} at point {off.argmax()} and "
                f"{given[0, 2]:g} at point 0; give solid cells, or one z{hint}"
            )
    return np.ascontiguousarray(given[:, :dim])


def _orient_cells(points: Array, cells: Index, shape: str) -> Index:
    """Plane cells counter-clockwise, if all of them were clockwise: seen from the other side."""
    kind = SHAPES[shape]
    if kind.dim != 2:
        return cells
    if cells.min() < 0 or cells.max() >= len(points):  # which `Mesh` refuses
        return cells
    x, y = np.moveaxis(points[cells[:, : kind.corners]], 2, 0)
    area = (x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1)).sum(axis=1)
    if not (area < 0).all():
        return cells
    swapped = kind.nodes[:, ::-1]
    mirror = [int(np.abs(kind.nodes - node).sum(axis=1).argmin()) for node in swapped]
    return np.ascontiguousarray(cells[:, mirror])


def _boundaries(content: Any, file: Path, mesh: Mesh) -> dict[str, Index]:
    """Facets (f, k) by name."""
    found: dict[str, list[Index]] = {}
    for name, block, chosen in _cell_groups(content, file):
        if block.dim != mesh.dim - 1 or not len(chosen):
            continue
        if block.data.shape[1] != mesh.surface.shape[1]:
            raise ProblemError(
                f"boundary {format_value(name)}: {block.type} cells on sides of {mesh.shape} "
                f"cells; mesh "
                "both to one order"
            )
        found.setdefault(name, []).append(np.asarray(block.data[chosen], dtype=np.intp))
    for name, points in _point_groups(content):
        inside = np.zeros(len(mesh.points), dtype=bool)
        inside[points] = True
        facets = mesh.surface[inside[mesh.surface].all(axis=1)]
        if len(facets) and name not in found:
            found[name] = [facets]
    return {name: np.concatenate(parts) for name, parts in found.items()}


def _zones(content: Any, file: Path, mesh: Mesh) -> dict[str, Index]:
    """Numbers of the body's cells (z,) by name."""
    first, count = {}, 0
    for block in content.cells:
        if block.dim == mesh.dim:
            first[id(block)], count = count, count + len(block.data)
    found: dict[str, list[Index]] = {}
    for name, block, chosen in _cell_groups(content, file):
        known = 0 < len(name) <= LONGEST_NAME and name.isprintable()
        if block.dim == mesh.dim and len(chosen) and known:
            found.setdefault(name, []).append(first[id(block)] + chosen)
    return {name: np.concatenate(parts) for name, parts in found.items()}


def _cell_groups(content: Any, file: Path) -> Iterator[tuple[str, Any, Index]]:
    """Name, block of cells, and which of them (k,)."""
    gmsh = FORMATS[file.suffix.lower()] == "gmsh"
    names = content.field_data.items() if gmsh else ()
    physical = {(int(tag), int(dim)): name for name, (tag, dim) in names}
    dim = max(block.dim for block in content.cells)
    for array, blocks in content.cell_data.items():
        for block, values in zip(content.cells, blocks, strict=True):
            if values.ndim != 1 or values.dtype.kind not in "iu" or (gmsh and "phys" not in array):
                continue
            for value in _labels(values, block.dim == dim and not gmsh):
                name = f"{value}" if gmsh else f"{array}:{value}"
                yield physical.get((value, block.dim), name), block, np.flatnonzero(values == value)
    sets = dict(content.cell_sets)
    if FORMATS[file.suffix.lower()] == "abaqus":
        sets |= _element_sets(content, file)
    for name, given in sets.items():
        members = [[] if each is None else each for each in given]
        flat = all(np.ndim(each) == 1 for each in members)
        if len(members) != len(content.cells) or not flat or name.startswith("gmsh:"):
            continue
        for block, chosen in zip(content.cells, members, strict=True):
            yield name, block, np.asarray(chosen, dtype=np.intp)


def _labels(values: Any, zones: bool) -> list[int]:
    """Values of an array that name something: of facets those above zero, of zones any but many."""
    found = np.unique(values) if zones else np.unique(values[values > 0])
    return [] if zones and len(found) > MOST_ZONES else found.tolist()


def _element_sets(content: Any, file: Path) -> dict[str, list[Index]]:
    """Sets that `*ELEMENT` lines name, with all cells of their blocks.

    meshio puts the first such set in the first block, and so on, whichever blocks they name.
    """
    named: list[str | None] = []
    for line in file.read_text(encoding="utf-8", errors="replace").splitlines():
        if line.partition(",")[0].strip().upper() == "*ELEMENT":
            options = [option.partition("=") for option in line.split(",")]
            sets = [value.strip() for key, _, value in options if key.strip().upper() == "ELSET"]
            named.append(sets[0] if sets else None)
    if any(named) and len(named) != len(content.cells):
        raise ProblemError("element sets in a file that includes others; join the files into one")
    return {
        name: [
            np.arange(len(block.data) if name == own else 0)
            for own, block in zip(named, content.cells, strict=True)
        ]
        for name in named
        if name
    }


def _point_groups(content: Any) -> Iterator[tuple[str, Index]]:
    """Name and points (k,): sets, and arrays of whole numbers that are 0 or 1."""
    for name, members in content.point_sets.items():
        yield name, np.asarray(members, dtype=np.intp)
    for name, values in content.point_data.items():
        if values.ndim == 1 and values.dtype.kind in "iub" and np.isin(values, (0, 1)).all():
            yield name, np.flatnonzero(values)
