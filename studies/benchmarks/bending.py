"""Bending: how stiff is a beam of square cells in pure bending, at any Poisson's ratio?

Question   Moment over curvature of a beam of N square cells through its height.
Candidate  Linear equilibrium of springs with a volume energy, edges shared.
Reference  A closed form. Far from the ends every column of cells bends alike: a row of points at
           height y is stretched by its strain y, the springs inside a row of cells by y in its
           middle, and the row's height changes by -s y of itself. With axial springs k1, and with
           k2 + κ = C12 for diagonals and volume together, the energy of a unit square of cells is

               k1 T + M (k1 s² + C12 (1 - s)²),

           T = N³/12 + N/6 the trapezium rule of ∫y², M = N³/12 - N/12 the midpoint rule. It is
           least at s = C12/(k1 + C12) = C12/C11 = nu, where it is k1 (T + nu M); and Et = k1
           (1 + nu). So

               EI_eff/EI = (T + nu M)/((1 + nu) N³/12) = 1 + ((2 - nu)/(1 + nu))/N²,

           E and nu those of the plane: in plane strain E/(1 - nu²) and nu/(1 - nu) of the solid's.
Expected   The closed form to rounding, and no locking: as the plane's ratio nears 1 the beam is
           stiffer by 1/(2N²) and no more, for a cell resists the change of its whole area only and
           a bent cell keeps that. Stiffest against its solid at low nu: 2/N² at 0, 3/N² at -1/4.
"""

from __future__ import annotations

from functools import partial

import numpy as np
import pandas as pd

from msvalidate import kit
from msvalidate.springs.constants.stiffness import in_plane_moduli
from msvalidate.springs.lattice import square

from . import cases, models

HEIGHTS, QUICK_HEIGHTS = (1, 2, 4, 8), (1, 2, 4)
"""Cells through the height."""
LENGTH = 12
"""Heights. The consistent forces of a linear traction are not quite the network's own pure bending;
what they add decays as exp(-4.2·distance/height), to 1e-11 of itself at the middle."""
MODULUS, MOMENT = 1e5, 100.0
"""Pa and N·m, one metre thick and high; the answer is linear."""
MATERIALS = (
    *(kit.Isotropic(E=MODULUS, nu=nu) for nu in (-0.25, 0.0, 0.2, 1 / 3, 0.45, 0.49, 0.499)),
    *(kit.Isotropic(E=MODULUS, nu=nu, state="plane_strain") for nu in (0.4, 0.45, 0.49, 0.499)),
)
RULES = (
    kit.Rule(
        "pure bending at any ratio: EI_eff/EI against 1 + ((2 - nu)/(1 + nu))/N²", 1e-8, "1",
        "exact on a network, on a network: left are rounding, 1e-16 times a condition number of up "
        "to 1e6, and its loss in second differences of the deflection, (8·12/2)² over 8",
        table="bending", value="value", reference="accepted",
    ),
)  # fmt: skip
FIGURE = kit.series(
    "bending", title="Pure bending of beams of square cells",
    x="nu_plane", y="value", by="cells", line="", log="y", size=(4.8, 3.6),
    labels=("Poisson's ratio of the plane, nu (1)", "stiffness over the solid's, EI_eff/EI (1)"),
    beside={"accepted": "1 + ((2 - nu)/(1 + nu))/N²"},
    words={1: "N = 1 cell high", 2: "N = 2", 4: "N = 4", 8: "N = 8"},
)  # fmt: skip


def run(
    candidate: kit.DisplacementSolver = kit.solve_springs, setting: kit.Setting = kit.FULL
) -> kit.Evidence:
    """Compare the candidate's beams with the closed form."""
    sizes = QUICK_HEIGHTS if setting.quick else HEIGHTS
    rows: list[dict[str, object]] = []
    for material in MATERIALS:
        nu = in_plane_moduli(material)[1]
        found = setting.sweep(partial(bending_stiffness, candidate, material), sizes, "bent beams")
        for n, value in zip(sizes, found, strict=True):
            quantity = cases.Quantity(
                "pure bending",
                f"EI_eff/EI, {material.state.replace('_', ' ')}",
                "1",
                1 + (2 - nu) / (1 + nu) / n**2,
                "1 + ((2 - nu)/(1 + nu))/N², nu of the plane",
                material.nu,
            )
            (row,) = cases.rows(quantity, models.method("square", nu), (n,), (value,))
            rows.append(row | {"nu_plane": nu})
    table = pd.DataFrame(rows)
    low, high = table["nu_plane"].min(), table["nu_plane"].max()
    finding = (
        "Beams of springs with a volume energy bend as 1 + ((2 - nu)/(1 + nu))/N² says, to "
        f"rounding, for ratios of the plane from {low:.3g} to {high:.3g}: they do not lock."
    )
    return kit.Evidence(
        tables={"bending": table},
        tolerances=RULES,
        columns=kit.columns(__file__),
        figures={"bending": FIGURE},
        findings=(finding,),
    )


def bending_stiffness(
    candidate: kit.DisplacementSolver, material: kit.Isotropic, cells: int
) -> float:
    """EI_eff/EI of a beam 1 m high under end moments, from the curvature at its middle."""
    length = float(LENGTH)
    beam = kit.Box((length, 1.0))

    def pull(points: kit.Array) -> kit.Array:
        return 12 * MOMENT * np.outer(points[:, 1] - 0.5, (1.0, 0.0))

    def push(points: kit.Array) -> kit.Array:
        return -pull(points)

    problem = kit.Problem(
        beam,
        material,
        (
            kit.Support(kit.Region((0.0, 0.0)), (0.0, 0.0)),
            kit.Support(kit.Region((length, 0.0)), (None, 0.0)),
        ),
        (kit.Traction(beam.side("right"), pull), kit.Traction(beam.side("left"), push)),
        name="pure bending",
    )
    network = models.network_of(problem, square(beam, (LENGTH * cells, cells)))
    move = candidate(problem, network, "linear")
    bottom = network.points[:, 1] == 0
    deflection = move[bottom, 1][np.argsort(network.points[bottom, 0], kind="stable")]
    middle = LENGTH * cells // 2
    left, centre, right = deflection[middle - 1 : middle + 2]
    curvature = (left - 2 * centre + right) * cells**2
    return float(MOMENT / abs(curvature) / (in_plane_moduli(material)[0] / 12))
