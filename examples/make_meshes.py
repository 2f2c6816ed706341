"""The meshes of the examples, made by Gmsh 4 (`pip install gmsh`), in the units of their cases.

    python examples/make_meshes.py

They are committed; Gmsh is needed to change them only.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import gmsh

HERE = Path(__file__).parent


def bracket() -> None:
    """L-shaped plate with a rounded inner corner and a hole; triangles with bent sides."""
    occ = gmsh.model.occ
    whole = occ.addRectangle(0, 0, 0, 60, 60)
    cut = occ.addRectangle(20, 20, 0, 60, 60, roundedRadius=6)
    hole = occ.addDisk(45, 10, 0, 4, 4)
    occ.cut([(2, whole)], [(2, cut), (2, hole)])
    occ.synchronize()
    name_lines({"clamp": lambda _, y: abs(y - 60) < 1e-6, "pull": lambda x, _: abs(x - 60) < 1e-6})
    name_body()
    mesh(size=5, order=2, dim=2)


def ring() -> None:
    """Quarter of a ring of radii 1 and 2 m; quadrilaterals with bent sides."""
    occ = gmsh.model.occ
    outer, inner = occ.addDisk(0, 0, 0, 2, 2), occ.addDisk(0, 0, 0, 1, 1)
    quarter = occ.addRectangle(0, 0, 0, 2, 2)
    ring_, _ = occ.cut([(2, outer)], [(2, inner)])
    occ.intersect(ring_, [(2, quarter)])
    occ.synchronize()
    name_lines(
        {
            "inner": lambda x, y: abs(math.hypot(x, y) - 1) < 0.2,
            "bottom": lambda _, y: abs(y) < 1e-6,
            "left": lambda x, _: abs(x) < 1e-6,
        }
    )
    name_body()
    for _, line in gmsh.model.getEntities(1):
        x, y, _ = gmsh.model.occ.getCenterOfMass(1, line)
        straight = abs(x) < 1e-6 or abs(y) < 1e-6
        gmsh.model.mesh.setTransfiniteCurve(line, 4 if straight else 7)
    for _, face in gmsh.model.getEntities(2):
        gmsh.model.mesh.setTransfiniteSurface(face)
        gmsh.model.mesh.setRecombine(2, face)
    mesh(size=0.5, order=2, dim=2)


def plate() -> None:
    """Plate 40 x 20 x 8 mm with a hole through it; tetrahedra with bent sides."""
    occ = gmsh.model.occ
    block = occ.addBox(0, 0, 0, 40, 20, 8)
    hole = occ.addCylinder(20, 10, 0, 0, 0, 8, 5)
    occ.cut([(3, block)], [(3, hole)])
    occ.synchronize()
    for name, at in {"clamp": 0.0, "pull": 40.0}.items():
        faces = [
            face
            for _, face in gmsh.model.getEntities(2)
            if abs(gmsh.model.occ.getCenterOfMass(2, face)[0] - at) < 1e-6
        ]
        gmsh.model.setPhysicalName(2, gmsh.model.addPhysicalGroup(2, faces), name)
    name_body()
    mesh(size=6, order=2, dim=3)


def name_lines(tests: dict[str, Callable[[float, float], bool]]) -> None:
    """Give the lines whose middles pass a test its name."""
    for name, test in tests.items():
        lines = []
        for _, line in gmsh.model.getEntities(1):
            low, high = gmsh.model.getParametrizationBounds(1, line)
            x, y, _ = gmsh.model.getValue(1, line, [(low[0] + high[0]) / 2])
            if test(x, y):
                lines.append(line)
        gmsh.model.setPhysicalName(1, gmsh.model.addPhysicalGroup(1, lines), name)


def name_body() -> None:
    """Name all cells of the highest dimension: without, named lines alone would be written."""
    dim = gmsh.model.getDimension()
    parts = [part for _, part in gmsh.model.getEntities(dim)]
    gmsh.model.setPhysicalName(dim, gmsh.model.addPhysicalGroup(dim, parts), "body")


def mesh(size: float, order: int, dim: int) -> None:
    """Mesh the model."""
    gmsh.option.setNumber("Mesh.MeshSizeMax", size)
    gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", 16)
    gmsh.option.setNumber("Mesh.SecondOrderIncomplete", 0)
    gmsh.model.mesh.generate(dim)
    gmsh.model.mesh.setOrder(order)


def main() -> None:
    """Write all meshes."""
    for make in (bracket, ring, plate):
        gmsh.initialize()
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.model.add(make.__name__)
        make()
        gmsh.write(str(HERE / f"{make.__name__}.msh"))
        gmsh.finalize()


if __name__ == "__main__":
    main()
