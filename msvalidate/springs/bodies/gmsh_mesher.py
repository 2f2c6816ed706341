"""Program that meshes a .step or .stl file by gmsh: ``gmsh_mesher.py FILE MESH SIZE``.

It runs in a process of its own, because gmsh can crash, take all memory and ignore interrupts. So
it imports no module of this package. A size of 0 takes a part of the body's diagonal. If there is
no mesh, the last line on stderr is the reason and the exit code is 1, or 2 without gmsh.
"""

from __future__ import annotations

import math
import re
import sys
from pathlib import Path
from typing import Any

import numpy as np

CELLS, ROUND = 25, 12
"""Cells along a body's diagonal, and round a circle, if no size is given."""
COARSE = 8
"""Cells round a circle, at least, if a size is given.

A second mesh of nearly incompressible elements needs a coarse first one."""
MOST = 200_000
"""Cells' sizes cubed, in 2D squared, that a body may hold."""
LONGEST = 3000
"""Maximum diagonal of an .stl file, relative to its median facet.

A body with so many equal facets along its diagonal would have 1e7 of them."""
ANGLE = math.radians(40)
"""Between triangles of an .stl file, from which on they belong to different faces."""
NO_GMSH = 2
UNITS = {
    "INCH": "'INCH'",
    "FT": "'FOOT'",
    "CM": r"\.CENTI\.,\.METRE",
    "M": r"LENGTH_UNIT\(\)[^;]*SI_UNIT\(\$,\.METRE",
    "MM": "",
}
"""OpenCASCADE's names of units -> patterns in .step files without blanks."""


def main(file: Path, mesh: str, size: float) -> None:
    """Mesh a file; end the program with a reason if that fails."""
    try:
        import gmsh  # noqa: PLC0415  an extra
    except (ImportError, OSError) as error:
        sys.stderr.write(f"{error}\n")
        sys.exit(NO_GMSH)
    try:
        gmsh.initialize(interruptible=False)
        gmsh.option.setNumber("General.Terminal", 0)
        _mesh(gmsh, file, size)
        gmsh.write(mesh)
    except Exception as error:  # noqa: BLE001  any message of gmsh, as one line
        words = str(error) or type(error).__name__
        sys.exit(" ".join(words.split()).replace(str(file), file.name))


def _mesh(gmsh: Any, file: Path, size: float) -> None:
    model = gmsh.model
    faceted = file.suffix.lower() == ".stl"
    if faceted:
        gmsh.merge(str(file))
        _refuse_stray_vertices(model)
        model.mesh.classifySurfaces(ANGLE, True, True, math.pi)
        model.mesh.createGeometry()
        loop = model.geo.addSurfaceLoop([tag for _, tag in model.getEntities(2)])
        model.geo.addVolume([loop])
        model.geo.synchronize()
    else:
        gmsh.option.setString("Geometry.OCCTargetUnit", _length_unit(file))
        model.occ.importShapes(str(file))
        model.occ.synchronize()
    dim = 3 if model.getEntities(3) else 2
    bodies = [tag for _, tag in model.getEntities(dim)]
    if not bodies:
        sys.exit("no solid and no face in it; export one")
    model.addPhysicalGroup(dim, bodies, name="body")
    word = "face" if dim == 3 else "edge"
    for number, (_, tag) in enumerate(model.getEntities(dim - 1), 1):
        model.addPhysicalGroup(dim - 1, [tag], name=f"{word} {number}")
    low_high = model.getBoundingBox(-1, -1)
    largest = size or math.dist(low_high[:3], low_high[3:]) / CELLS
    room = math.prod(b - a for a, b in zip(low_high[:dim], low_high[3:], strict=False))
    whole = room if faceted else sum(model.occ.getMass(dim, tag) for tag in bodies)
    if whole / largest**dim > MOST:
        sys.exit(
            f"cell: some {whole / largest**dim:.2g} cells of {largest:g}, and the most is "
            f"{MOST:g}; give a larger one"
        )
    gmsh.option.setNumber("Mesh.MeshSizeMax", largest)
    gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", COARSE if size else ROUND)
    gmsh.option.setNumber("Mesh.HighOrderOptimize", 2)
    model.mesh.generate(dim)
    model.mesh.setOrder(1 if faceted else 2)


def _length_unit(file: Path) -> str:
    """Unit of a .step file: coordinates are its own numbers, which would become millimetres."""
    text = "".join(file.read_text(encoding="utf-8", errors="replace").split())
    return next(unit for unit, pattern in UNITS.items() if re.search(pattern, text))


def _refuse_stray_vertices(model: Any) -> None:
    """End the program if vertices lie far from all others: gmsh would mesh the way to them."""
    facets = np.reshape(model.mesh.getNodesByElementType(2)[1], (-1, 3, 3))
    if not len(facets):
        sys.exit("no facets in it; export it again")
    edge = np.median(np.linalg.norm(facets - np.roll(facets, 1, axis=1), axis=2).max(axis=1))
    points = facets.reshape(-1, 3)
    diagonal = np.linalg.norm(np.ptp(points, axis=0))
    if not diagonal <= LONGEST * edge:
        far = points[np.linalg.norm(points - np.median(points, axis=0), axis=1).argmax()]
        sys.exit(
            f"its diagonal {diagonal:.3g} is {diagonal / edge:.2g} times its median facet, and "
            f"{LONGEST:g} is the most; correct the vertex at {far.tolist()}"
        )


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2], float(sys.argv[3]))
