"""The report's load cases as data: bodies, loads, supports, probes and bands.

Side 1 m, thickness 1 m, E = 100 kPa (the report gives none of them); total forces make a nominal
strain of about 1 %. The report loads its "two central particles": here a traction on the middle
fifth of the edge, whose consistent forces on 6 x 6 particles are exactly two equal forces, and
which is the same load on every lattice and in FEM.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd

from msvalidate import kit
from msvalidate.problem.checks import whole_number
from msvalidate.springs.lattice import Lattice, square, trapezium, triangular, zigzag_block

MODULUS = 1e5
"""Young's modulus (Pa) of the target; what the lattice's axial modulus is set to."""
THICKNESS = 1.0
DENSITY = 1000.0
"""Sets time scales of Algorithm 1 and no displacement (kg/m³)."""
FIFTH = 0.2
"""Part of the side that is loaded: two central particles of six."""
LOW, HIGH = 0.5 - FIFTH / 2, 0.5 + FIFTH / 2
"""Where the loaded fifth of a side of 1 m begins and ends."""
LENGTH = 5.0
"""Of the bar, in heights."""
BAND = 0.05
"""Largest |total| + reference of the error budget that counts as agreement. A spring model in use
replaces a material known to some percent: closer than that, nobody could tell the two apart."""


@dataclass(frozen=True)
class LoadCase:
    """One load case, the same on every body.

    `figure`: number of the report's figure. `magnification`: of the redrawn displacements.
    `loads`: named part of the body -> total force (N) on it. `supports`: named part -> components
    held. `strain`: nominal strain.
    """

    name: str
    figure: int
    magnification: int
    loads: dict[str, tuple[float, float]]
    supports: dict[str, tuple[bool, bool]]
    strain: float
    strain_is: str


CASES = {
    case.name: case
    for case in (
        LoadCase(
            "pressure",
            4,
            10,
            {"middle fifth of left": (1000.0, 0.0)},
            {"right": (True, True)},
            0.01,
            "force / (E · side · thickness)",
        ),
        LoadCase(
            "two-sided pressure",
            5,
            10,
            {"middle fifth of left": (1000.0, 0.0), "middle fifth of right": (-1000.0, 0.0)},
            {"lower inner point": (True, True), "upper inner point": (True, False)},
            0.01,
            "force / (E · side · thickness)",
        ),
        LoadCase(
            "shear",
            6,
            10,
            {"left": (0.0, 375.0)},
            {"right": (True, True)},
            0.01,
            "force / (G · side · thickness), nu = 1/3",
        ),
        LoadCase(
            "bending",
            7,
            20,
            {"middle of top": (0.0, -250.0)},
            {"left": (True, True), "right": (True, True)},
            250.0 * LENGTH / 8 / (MODULUS * THICKNESS / 6),
            "beam theory: F·L/8 at the held ends over E·W, L = 5 m, W = height²·thickness/6",
        ),
    )
}
LATTICES = ("square", "triangular")


@dataclass(frozen=True)
class Body:
    """A body and the lattice that fills it.

    `cells` = (cells_x, cells_y). Square: cells along x and y. Triangular block: strips of triangles
    along x, triangle sides along the straight left edge. Triangular bar: triangle sides along the
    top, rows of triangles. `places`: names of parts; `probes`: name -> coordinates (m).
    """

    lattice: str
    domain: kit.Box | kit.Polygon
    spacing: float
    cells: tuple[int, int]
    places: dict[str, kit.Part]
    probes: dict[str, tuple[float, float]]

    def grid(self) -> Lattice:
        """The lattice."""
        if isinstance(self.domain, kit.Polygon):
            return triangular(self.domain, self.spacing)
        return square(self.domain, self.cells)

    def at_probes(self, points: kit.Array) -> kit.Index:
        """Numbers of the points (n, 2) at the probes, in their order.

        Raises
        ------
        ProblemError
            If a probe meets no point: one nearby would move differently.
        """
        away = np.linalg.norm(points[:, None] - np.array(list(self.probes.values())), axis=2)
        at = away.argmin(axis=0)
        for name, distance in zip(self.probes, away.min(axis=0), strict=True):
            if distance > self.domain.tolerance:
                raise kit.ProblemError(
                    f"probe {name!r}: the nearest point is {distance:.3g} m away"
                )
        return np.asarray(at)


def body(lattice: str, case: str, fineness: int) -> Body:
    """Body of a case with `fineness` spacings on a side of 1 m; a multiple of 5.

    Triangular bodies are unions of whole triangles: the block 1.039 m wide with straight ends, the
    bar a trapezium with a height of 1.039 m and 5.004 times as long at mid-height, so that all that
    is loaded or held is straight.
    """
    if lattice not in LATTICES:
        raise kit.ProblemError(f"lattice {lattice!r}: choose from {', '.join(LATTICES)}")
    if case not in CASES:
        raise kit.ProblemError(f"load case {case!r}: choose from {', '.join(CASES)}")
    if whole_number("fineness", fineness, 5) % 5:
        raise kit.ProblemError(
            f"fineness: {fineness}; give a multiple of 5, so that loads and probes meet points"
        )
    make = {
        ("square", False): _square_block,
        ("square", True): _square_beam,
        ("triangular", False): _triangular_block,
        ("triangular", True): _triangular_bar,
    }
    return make[lattice, case == "bending"](fineness)


def _square_block(n: int) -> Body:
    box = kit.Box((1.0, 1.0))
    probes = {"upper": (0.4, 0.8), "inside": (0.6, 0.6)}
    return Body("square", box, 1 / n, (n, n), _sides(1.0, 0.4), probes)


def _triangular_block(n: int) -> Body:
    cells = (6 * n // 5, n)
    outline = zigzag_block(1.0, cells)
    width = outline.span[0][1]
    probes = {"upper": (width / 3, 0.8), "inside": (2 * width / 3, 0.6)}
    return Body("triangular", outline, 1 / n, cells, _sides(width, width / 3), probes)


def _sides(width: float, inner: float) -> dict[str, kit.Part]:
    """Named parts of a block 1 m high with straight left and right sides."""
    return {
        "left": kit.Segment((0.0, 1.0), (0.0, 0.0)),
        "right": kit.Segment((width, 0.0), (width, 1.0)),
        "middle fifth of left": kit.Segment((0.0, HIGH), (0.0, LOW)),
        "middle fifth of right": kit.Segment((width, LOW), (width, HIGH)),
        "lower inner point": kit.Region((inner, LOW)),
        "upper inner point": kit.Region((inner, HIGH)),
    }


def _square_beam(n: int) -> Body:
    places: dict[str, kit.Part] = {
        "left": kit.Segment((0.0, 1.0), (0.0, 0.0)),
        "right": kit.Segment((LENGTH, 0.0), (LENGTH, 1.0)),
        "middle of top": kit.Segment((LENGTH / 2 + FIFTH / 2, 1.0), (LENGTH / 2 - FIFTH / 2, 1.0)),
    }
    probes = {"bottom": (2.4, 0.0), "quarter": (1.2, 0.4)}
    return Body("square", kit.Box((LENGTH, 1.0)), 1 / n, (5 * n, n), places, probes)


def _triangular_bar(n: int) -> Body:
    cells = (23 * n // 5, 6 * n // 5)
    outline = trapezium(1 / n, cells)
    a, b, c, d = outline.vertices
    middle = 0.5 * (a[0] + b[0])
    places: dict[str, kit.Part] = {
        "left": kit.Segment(d, a),
        "right": kit.Segment(b, c),
        "middle of top": kit.Segment((middle + FIFTH / 2, c[1]), (middle - FIFTH / 2, c[1])),
    }
    probes = {"bottom": (middle - FIFTH / 2, 0.0), "quarter": (1.4, c[1] / 3)}
    return Body("triangular", outline, 1 / n, cells, places, probes)


def problem(case: str, shape: Body, material: kit.Material) -> kit.Problem:
    """The problem of a case on a body of some material."""
    asked = CASES[case]
    supports = tuple(
        kit.Support(shape.places[name], tuple(0.0 if component else None for component in held))
        for name, held in asked.supports.items()
    )
    loads = []
    for name, force in asked.loads.items():
        area = shape.places[name].measure(shape.domain.span) * material.thickness
        loads.append(kit.Traction(shape.places[name], tuple(f / area for f in force)))
    return kit.Problem(
        shape.domain, material, supports, tuple(loads), name=f"{case}, {shape.lattice}"
    )


def table() -> pd.DataFrame:
    """The load cases as they are, one row per load and lattice."""
    rows = []
    for case in CASES.values():
        for lattice in LATTICES:
            shape = body(lattice, case.name, 5)
            for name, force in case.loads.items():
                row: dict[str, object] = {
                    "case": case.name,
                    "lattice": lattice,
                    "body": str(shape.domain),
                }
                row |= {"area": shape.domain.volume, "loaded": name}
                row |= {"where": str(shape.places[name]), "force_x": force[0], "force_y": force[1]}
                held = [
                    f"{part} {shape.places[part]}: {' and '.join(_named(components))}"
                    for part, components in case.supports.items()
                ]
                row |= {"held": "; ".join(held), "nominal_strain": case.strain}
                rows.append(row | {"nominal_strain_is": case.strain_is, "band": BAND})
    return pd.DataFrame(rows)


def _named(components: tuple[bool, bool]) -> list[str]:
    return [name for name, held in zip(("ux", "uy"), components, strict=True) if held]


def probe_table() -> pd.DataFrame:
    """Where the probes are, on every lattice of the body."""
    rows = []
    for case in CASES:
        for lattice in LATTICES:
            for name, (x, y) in body(lattice, case, 5).probes.items():
                rows.append({"case": case, "lattice": lattice, "probe": name, "x": x, "y": y})
    return pd.DataFrame(rows)
