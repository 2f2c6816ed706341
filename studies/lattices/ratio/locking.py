"""Locking: which models of a bent block lose their deflection as nu goes to 1/2, and why?

Question   What of the deflection is lost from nu = 0.45 to the largest ratio, at one size.
Candidate  The bent blocks of `rubber`: springs with a volume for every cell, or for its halves.
Reference  Conditions of volume at nu = 1/2, counted over the freedoms of the points. Linear
           elements on the same triangles.
Expected   One volume a cell is one condition for every two (plane) or three (space) freedoms of the
           points, as many as the solid has: no locking. Two triangles a square, of a volume each,
           make as many conditions as freedoms: such cells lock, as linear elements do. So does Q1,
           which resists the change of volume at every point of its cell.
"""

from __future__ import annotations

import numpy as np
import pandas as pd

import reference_fem
from msvalidate.bodies.calibrate import calibrate_material
from msvalidate.bodies.lattice_network import lattice_network
from msvalidate.judging.compare import farthest_value
from msvalidate.judging.evidence import Evidence, Observed, Tolerance, by_quantity
from msvalidate.network import tangent
from msvalidate.problem import Isotropic
from reference_fem.elasticity import stiffness

from . import stretch
from .bent import HALVES, RATIOS, SPRINGS

FINE = {2: 16, 3: 4}
"""Cells through the height, at which models are told apart."""
RUBBER = 0.4
"""Least ratio that is called nearly incompressible."""
LOCKS = 0.05
"""Of the deflection, which a model loses more of, from the least such ratio to the largest, if it
locks."""
TOLERANCES = (
    Tolerance(
        "volume energy: part of the deflection lost from nu = 0.45 to the largest", 0.03, "1",
        "at 1/2 the clamped end's exponent is 0.595, at 0.45 0.64: differences of 0.14 at 4 cells "
        "of a cube change by 1 - 4^-0.09, 12 % of themselves",
    ),
    Tolerance(
        "models that lock in plane strain and space, or do not, against expectation", 0, "1",
        "conditions of volume for every freedom tell: half of them, or a third, in cells of one "
        "volume; one and more in halves, tetrahedra, and cells that resist at every point",
    ),
    Tolerance(
        "triangular lattice with its triangles' volumes, plane strain: stiffness from P1's, "
        "relative to its largest entry", 1e-12, "1",
        "springs are P1 elements of λ = μ, and a linear element's dilatation is its area's: an "
        "identity; left is rounding",
    ),
)  # fmt: skip
COLUMNS = {
    "state": stretch.COLUMNS["state"],
    "nu_rubber": "Poisson's ratio of the nearly incompressible material (1)",
    "model": "lattice with the volume energy of its cells, or of their halves, or a displacement "
    "element on as many cells",
    "lost": "deflection_difference at the largest nu less that at 0.45, at 16 cells of the plane "
    "and 4 of space (1)",
    "volumes_a_freedom": "conditions of volume at nu = 1/2 over the components of displacement, in "
    "a large body (1)",
    "locks": "whether the model loses more than 0.05 of the deflection",
    "p1_difference": "largest entry of the triangular lattice's stiffness less that of P1 elements "
    "on its triangles, over the largest entry (1)",
}
CONDITIONS = {
    "square": 1 / 2,
    HALVES: 1.0,
    "Q1": 3 / 2,
    "P1": 1.0,
    "cubic18": 1 / 3,
    "cubic26": 1 / 3,
    "H1": 7 / 3,
    "T1": 2.0,
}
"""Conditions of volume over freedoms: a cell of Q1 has 3 of them (its dilatation is linear), of H1
7, triangles and tetrahedra one, of which there are 2 and 6 for every point."""


def run(table: pd.DataFrame) -> Evidence:
    """Judge who locks, from the table `rubber`."""
    locks, p1 = locking(table), against_p1()
    counted = locks[locks["state"] != "plane_stress"]
    wrong = (counted["locks"] == "yes") != (counted["volumes_a_freedom"] >= 1)
    values = (
        farthest_value(locks[locks["model"].isin(SPRINGS)]["lost"], 0.0),
        Observed(float(wrong.sum())),
        farthest_value(p1["p1_difference"], 0.0),
    )
    return Evidence(
        tables={"rubber_locking": locks, "rubber_p1": p1},
        observed=by_quantity(TOLERANCES, values),
        tolerances=TOLERANCES,
        columns=COLUMNS,
        rounding={"lost": 1e-7, "p1_difference": 1e-12},
        findings=findings(locks),
    )


def locking(table: pd.DataFrame) -> pd.DataFrame:
    """The table `rubber_locking`."""
    rows = []
    rubber = table[table["nu_rubber"] > RUBBER]
    for (state, model), mine in rubber.groupby(["state", "model"], sort=False):
        fine = mine[mine["cells_through"] == FINE[3 if state == "solid" else 2]]
        by_nu = fine.set_index("nu_rubber")["deflection_difference"].sort_index()
        lost = float(by_nu.iloc[-1] - by_nu.iloc[0])
        rows.append(
            {"state": state, "model": model, "volumes_a_freedom": CONDITIONS[str(model)]}
            | {"lost": lost, "locks": "yes" if lost < -LOCKS else "no"}
        )
    return pd.DataFrame(rows)


def against_p1() -> pd.DataFrame:
    """The table `rubber_p1`: triangles with volumes against linear elements on them."""
    lattice = stretch.body("triangular")
    mesh = reference_fem.make_discretisation(lattice.points, lattice.cells, "P1")
    order = np.arange(lattice.points.size).reshape(-1, 2).T.ravel()
    rows = []
    for nu in RATIOS["plane_strain"]:
        material = Isotropic(1.0, nu, "plane_strain")
        network = lattice_network(
            stretch.pull_loads(lattice, material), lattice, calibrate_material(material, lattice)
        )
        K = stiffness(mesh, material)
        own = tangent(network, network.points)[order][:, order]
        rows.append({"nu_rubber": nu, "p1_difference": float(abs(own - K).max() / abs(K).max())})
    return pd.DataFrame(rows)


def findings(locks: pd.DataFrame) -> tuple[str, ...]:
    """Who locks."""
    locked = list(dict.fromkeys(locks["model"][locks["locks"] == "yes"]))
    free = "; ".join(m for m in dict.fromkeys(locks["model"]) if m in SPRINGS and m not in locked)
    stiff = "; ".join(locked)
    said = (
        f"Volume energy of whole cells that does not lock: {free or 'none'}. What locks, in plane "
        f"strain and space: {stiff}. Equilateral triangles with a volume each are P1 elements "
        "exactly, and lock as those do."
    )
    return (said,)
