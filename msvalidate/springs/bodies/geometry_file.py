"""Meshes of .step and .stl files by gmsh, where it is installed.

Cells are quadratic, on a .step file's own faces; of an .stl file, which is its facets, linear.
"""

from __future__ import annotations

import contextlib
import math
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from msvalidate.linear_algebra.factor import silence_library
from msvalidate.problem import ProblemError
from msvalidate.problem.checks import format_value
from msvalidate.problem.progress import report_step

GEOMETRIES = (".step", ".stp", ".stl")
"""Suffixes of files that hold faces and no cells."""
CELLS, ROUND = 25, 12
"""Cells along a body's diagonal, and round a circle, where no size is given."""
MOST = 200_000
"""Cells' sizes cubed, in the plane squared, that a body may hold."""
ANGLE = math.radians(40)
"""Between triangles of an .stl file, from which on they belong to different faces."""


@contextlib.contextmanager
def meshed_geometry(file: Path, size: float | None = None) -> Iterator[Path]:
    """Context manager of a temporary Gmsh file with the meshed geometry.

    Its faces are named "face 1", "face 2" and so on.

    Parameters
    ----------
    file
        .step or .stl: a solid, or faces of one plane.
    size
        Of the cells, in the file's unit of length, by default a part of the body's diagonal, and
        smaller where it is bent.

    Raises
    ------
    ProblemError
        If gmsh is not installed, or makes no mesh of the file.
    """
    said = f"mesh file {format_value(file.name)}"
    try:
        import gmsh  # noqa: PLC0415  an extra
    except (ImportError, OSError) as error:
        raise ProblemError(
            f"{said}: gmsh makes meshes of {file.suffix} files, and is not installed; pip install "
            "'msvalidate[gmsh]', or write .msh, .vtu, .vtk or .inp"
        ) from error
    with tempfile.TemporaryDirectory() as folder:
        made = Path(folder) / f"{file.name}.msh"
        gmsh.initialize(interruptible=False)
        try:
            gmsh.option.setNumber("General.Terminal", 0)
            with silence_library():  # what reads .step files writes to the terminal by itself
                _mesh(gmsh, file, size)
                gmsh.write(str(made))
        except ProblemError as error:
            raise ProblemError(f"{said}: {error}") from error
        except Exception as error:  # whatever gmsh says, as one line
            why = " ".join(str(error).split()).replace(str(file), file.name)
            raise ProblemError(
                f"{said}: gmsh makes no mesh of it: {why}; export it again, whole and closed, or "
                "mesh it elsewhere"
            ) from error
        finally:
            gmsh.finalize()
        yield made


def _mesh(gmsh: Any, file: Path, size: float | None) -> None:
    model = gmsh.model
    faceted = file.suffix.lower() == ".stl"
    if faceted:
        gmsh.merge(str(file))
        model.mesh.classifySurfaces(ANGLE, True, True, math.pi)
        model.mesh.createGeometry()
        loop = model.geo.addSurfaceLoop([tag for _, tag in model.getEntities(2)])
        model.geo.addVolume([loop])
        model.geo.synchronize()
    else:
        model.occ.importShapes(str(file))
        model.occ.synchronize()
    dim = 3 if model.getEntities(3) else 2
    bodies = [tag for _, tag in model.getEntities(dim)]
    if not bodies:
        raise ProblemError("no solid and no face in it; export one")
    model.addPhysicalGroup(dim, bodies, name="body")
    word = "face" if dim == 3 else "edge"
    for number, (_, tag) in enumerate(model.getEntities(dim - 1), 1):
        model.addPhysicalGroup(dim - 1, [tag], name=f"{word} {number}")
    low_high = model.getBoundingBox(-1, -1)
    largest = size or math.dist(low_high[:3], low_high[3:]) / CELLS
    room = math.prod(b - a for a, b in zip(low_high[:dim], low_high[3:], strict=False))
    whole = room if faceted else sum(model.occ.getMass(dim, tag) for tag in bodies)
    if whole / largest**dim > MOST:
        raise ProblemError(
            f"cell: some {whole / largest**dim:.2g} cells of {largest:g}, and the most is "
            f"{MOST:g}; give a larger one"
        )
    gmsh.option.setNumber("Mesh.MeshSizeMax", largest)
    gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", ROUND)
    gmsh.option.setNumber("Mesh.HighOrderOptimize", 2)
    report_step("gmsh: cells of %.3g in a body of %d faces", largest, len(model.getEntities(2)))
    model.mesh.generate(dim)
    model.mesh.setOrder(1 if faceted else 2)
