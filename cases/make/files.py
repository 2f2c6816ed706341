"""The set's folders: case files, meshes, nodal numbers and answers as text."""

from __future__ import annotations

import csv
import io
import tempfile
from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from cases.make.answer import Answer
from cases.make.confirmed import Confirmation
from cases.make.meshes import MESHIO, linear_meshes
from cases.make.reference import body_mesh, problem_of, write_msh
from cases.make.statements import Statement
from msvalidate.bench.output.vtu import vtu_bytes
from msvalidate.problem import SHAPES, Isotropic, Mesh, Problem, Weight, prescribed_displacements
from msvalidate.problem.zones import materials_of_cells
from reference_fem.body import nodal_forces, solve_problem
from reference_fem.mesh.from_mesh import mesh_discretisation

Array = np.ndarray
AXES = "xyz"
ROUNDING = 1e-12
"""Of the largest value, below which another is 0."""
UNITS = {"displacement": "m", "reaction": "N", "strain": "J", "mean": "Pa"}
VOIGT = {2: ("xx", "yy", "xy"), 3: ("xx", "yy", "zz", "yz", "xz", "xy")}


class NodalMesh:
    """A linear mesh of a case, with what acts on its nodes."""

    def __init__(
        self, statement: Statement, kind: str, points: Array, cells: Array, nu: float | None = None
    ) -> None:
        self.kind, self.points, self.cells = kind, points, cells
        self.shape = MESHIO[kind.partition("_")[0]]
        nu = statement.own_ratio if nu is None else nu
        curved = (points, cells, self.shape) if statement.sides is not None else None
        self.problem = problem_of(statement, nu, curved)
        self.body = mesh_discretisation(Mesh(points, cells, self.shape))
        if not np.array_equal(self.body.points, points):
            raise ValueError(f"{statement.name} {kind}: nodes in another order")
        self.held, self.value = prescribed_displacements(self.problem, points)
        self.force = nodal_forces(self.problem, self.body)
        one = (1.0, *[0.0] * (points.shape[1] - 1))
        self.mass = nodal_forces(self._loaded(Weight(one)), self.body)[:, 0]

    def _loaded(self, load: Weight) -> Problem:
        return replace(self.problem, loads=(load,))

    @property
    def modulus(self) -> Array:
        """Young's modulus (c,) in Pa of each cell."""
        number = materials_of_cells(self.problem, self.points[self.cells], SHAPES[self.shape])
        found = [law.E for law in self.problem.materials if isinstance(law, Isotropic)]
        return np.array(found)[number]

    def solution(self) -> Array:
        """Displacement (n, d) in m of linear elements on this mesh, locked or not."""
        return solve_problem(self.problem, self.body, allow_locked=True).displacement


def nodal_meshes(statement: Statement, nu: float | None = None) -> list[NodalMesh]:
    """All frozen meshes of a case, coarse to fine."""
    made = linear_meshes(statement.grid, statement.meshes)
    return [NodalMesh(statement, kind, *mesh, nu) for kind, mesh in made.items()]


def case_files(statement: Statement, answers: dict[float, Answer]) -> dict[str, bytes]:
    """Name -> content of the files of a case's folder."""
    found = {"case.toml": case_toml(statement).encode()}
    with tempfile.TemporaryDirectory() as folder:
        if statement.sides is not None:
            path = Path(folder) / "body.msh"
            write_msh(path, statement, *body_mesh(statement))
            found["body.msh"] = path.read_bytes()
        for mesh in nodal_meshes(statement):
            path = Path(folder) / f"{mesh.kind}.msh"
            write_msh(path, statement, mesh.points, mesh.cells, mesh.shape)
            found[path.name] = path.read_bytes()
            found |= _mesh_files(mesh)
    found["displacement.csv"] = displacement_csv(statement, answers)
    found["quantities.csv"] = quantities_csv(statement, answers)
    made = [
        (f"{nu:g}", a.nodes, "" if np.isnan(a.order) else f"{a.order:.2f}")
        for nu, a in answers.items()
    ]
    found["made.csv"] = _csv(["nu", "nodes of the finest mesh of elements", "order seen"], made)
    return found


def case_toml(statement: Statement) -> str:
    """The case file of the set's own ratio, and the named points."""
    known = ", ".join(f"{nu:g}" for nu in statement.ratios)
    too = ", in every region too" if "[[region]]" in statement.text else ""
    head = f"# The set knows the answer for nu = {known}{too}.\n"
    points = linear_meshes(statement.grid, 1)
    first, _ = next(iter(points.values()))
    rows = ",\n  ".join(f"[{', '.join(_short(x) for x in row)}]" for row in first)
    return f"{head}{statement.case_file(statement.own_ratio)}[compare]\npoints = [\n  {rows},\n]\n"


def _short(x: float) -> str:
    return f"{x:g}" if float(f"{x:g}") == x else repr(float(x))


def _mesh_files(mesh: NodalMesh) -> dict[str, bytes]:
    d = mesh.points.shape[1]
    axes = AXES[:d]
    head = ["id", *axes, "mass", *[f"f{a}" for a in axes], *[f"held_{a}" for a in axes]]
    head += [f"value_{a}" for a in axes]
    rows = []
    for i, x in enumerate(mesh.points):
        row: list[Any] = [i, *map(_short, x), f"{mesh.mass[i]:.12g}"]
        row += [f"{f + 0.0:.12g}" for f in without_rounding(mesh.force)[i]]
        row += [int(h) for h in mesh.held[i]]
        row += [_short(v) if h else "0" for h, v in zip(mesh.held[i], mesh.value[i], strict=True)]
        rows.append(row)
    force, held = without_rounding(mesh.force), mesh.held.astype(float)
    fields = {"mass": mesh.mass, "force": force, "held": held}
    return {
        f"{mesh.kind}_nodes.csv": _csv(head, rows),
        f"{mesh.kind}_cells.csv": cells_csv(mesh),
        f"{mesh.kind}.vtu": vtu_bytes(mesh.points, {mesh.shape: mesh.cells}, fields),
    }


def cells_csv(mesh: NodalMesh) -> bytes:
    """Corners of the cells; and their modulus E (Pa), in bodies of more than one material."""
    head = ["id", *[f"n{k}" for k in range(mesh.cells.shape[1])]]
    rows: list[list[Any]] = [[i, *cell] for i, cell in enumerate(mesh.cells)]
    if mesh.problem.zones:
        head.append("E")
        rows = [[*row, _short(E)] for row, E in zip(rows, mesh.modulus, strict=True)]
    return _csv(head, rows)


def without_rounding(values: Array) -> Array:
    """Values of which those that are rounding beside the largest are 0."""
    size = float(np.abs(values).max(initial=0.0))
    return np.where(np.abs(values) < ROUNDING * size, 0.0, values)


def number(value: float, *, exact: bool) -> str:
    """A value as it is written: to 12 digits, which its error is far above; a formula's to all."""
    return _short(value + 0.0) if exact else f"{value + 0.0:.12g}"


def _csv(head: Sequence[str], rows: Iterable[Sequence[Any]]) -> bytes:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(head)
    writer.writerows(rows)
    return text.getvalue().encode()


def displacement_csv(statement: Statement, answers: dict[float, Answer]) -> bytes:
    """Displacement (m) and its slopes, by ratio and node of the coarsest mesh."""
    axes = AXES[: statement.dim]
    head = ["nu", "id", *[f"u{a}" for a in axes]]
    head += [f"E_du{a}_dE" for a in axes] + [f"du{a}_dnu" for a in axes]
    rows = []
    for nu, answer in answers.items():
        moves = without_rounding(answer.displacement)
        slopes = np.hstack([without_rounding(answer.by_modulus), without_rounding(answer.by_ratio)])
        for i in range(len(moves)):
            row: list[Any] = [f"{nu:g}", i]
            row += [number(u, exact=answer.exact) for u in moves[i]]
            row += [f"{u + 0.0:.7g}" for u in slopes[i]]
            rows.append(row)
    return _csv(head, rows)


def quantities_csv(statement: Statement, answers: dict[float, Answer]) -> bytes:
    """Reactions, energy and mean stress by ratio, and what each is uncertain by."""
    rows: list[list[Any]] = []
    for nu, answer in answers.items():
        rows.append(
            [f"{nu:g}", "displacement", "any", "", "m", f"{answer.uncertainty['displacement']:.3g}"]
        )
        for name, values in answer.quantities.items():
            labels = _labels(name, statement.dim, len(values))
            unit = UNITS[name.split()[0]]
            uncertainty = f"{answer.uncertainty[name]:.3g}"
            rows += [
                [f"{nu:g}", name, label, number(value, exact=answer.exact), unit, uncertainty]
                for label, value in zip(labels, without_rounding(values), strict=True)
            ]
    return _csv(["nu", "quantity", "component", "value", "unit", "uncertainty"], rows)


def _labels(name: str, d: int, count: int) -> Sequence[str]:
    if name == "mean stress":
        return VOIGT[d]
    return AXES[:d] if name.startswith("reaction") else [""] * count


def confirmed_csv(rows: list[Confirmation]) -> bytes:
    """Table of all quantities, in two ways each."""
    head = [
        "case", "nu", "quantity", "largest component", "way", "its own uncertainty", "second way",
        "second way's own uncertainty", "difference of the ways", "balance alone gives it",
        "stated uncertainty", "difference within both own uncertainties",
    ]  # fmt: skip
    words = {True: "yes", False: "NO"}
    return _csv(
        head,
        [
            [
                row.case, f"{row.nu:g}", row.quantity, f"{row.size:.6g}", row.way, f"{row.own:.3g}",
                row.second_way, f"{row.second_own:.3g}", f"{row.difference:.3g}",
                "yes" if row.balanced else "", f"{row.stated:.3g}", words[row.is_confirmed],
            ]
            for row in rows
        ],
    )  # fmt: skip
