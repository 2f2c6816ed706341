"""softer.vtu: what a simulator would leave of the bracket in a material 1 % softer, in mm.

python examples/make_field.py
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import reference_fem
from msvalidate.bench.output.vtu import vtu_bytes
from msvalidate.case.file.building import read_case
from reference_fem.mesh.subdivide import subdivide

HERE = Path(__file__).parent
MILLIMETRES = 1e3


def main() -> None:
    """Write the field."""
    problem = read_case(HERE / "bracket.toml").problem
    softer = replace(problem, material=replace(problem.material, E=problem.material.E / 1.01))
    body = reference_fem.mesh_discretisation(problem.domain)
    found = reference_fem.solve_problem(softer, subdivide(body, 2)).at(body.points)
    cells = {body.element.shape: body.cells}
    fields = {"displacement": MILLIMETRES * found}
    content = vtu_bytes(MILLIMETRES * body.points, cells, fields)
    (HERE / "softer.vtu").write_bytes(content)


if __name__ == "__main__":
    main()
