"""Hanging: a published comparison of soft-body solvers with finite elements, predicted.

Question   A bar of 0.6 x 0.6 x 1.6 m hangs under its own weight. Published: tips 3.680, 3.230 and
           1.967 times those of finite elements, by three solvers of Newton, explained by the
           solvers. What do law and masses alone predict, with nothing run but elements?
Candidate  Linear tetrahedra with the law that the explicit solver's source has, and the mass of a
           full cell on each node, as the grid's helper gives it.
Reference  The published tips (AustrianTradingMachine/Newton, figures/hanging_bar_report.txt, 2026;
           settings: common/params.py).
Expected   The explicit solver's tip is predicted within 5 %: mass times 833/576, law times 1.32.
           The other two are 1.45 times as heavy as well; what is left of them is not explained
           here: one law has no shear stiffness at rest, the other had not converged, as its own
           authors say.

A draft until the comparison's author has been told. The law was read in Newton 1.8.0; which version
was run is not published.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pandas as pd

from msvalidate import kit
from msvalidate.simulators.bodies.laws import LAWS, lame, predicted
from msvalidate.simulators.bodies.tetrahedra import Stress, at_rest
from msvalidate.simulators.exchange.protocol import Request
from msvalidate.simulators.probe.block import Block

from .gaps import fill_gaps, with_none

CELLS, CELL = (6, 6, 16), 0.1
"""Of the grid: cubes along each axis, and their side (m)."""
FIVES = (
    ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)),
    ((1, 1, 0), (0, 1, 0), (1, 0, 0), (1, 1, 1)),
    ((1, 0, 1), (0, 0, 1), (1, 1, 1), (1, 0, 0)),
    ((0, 1, 1), (0, 1, 0), (1, 1, 1), (0, 0, 1)),
    ((1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 1)),
)
"""Corners of the five tetrahedra of a cube: four cut off, and what they leave."""
MU, LAM, DENSITY, GRAVITY = 1e4, 5e4, 100.0, 9.80665
PUBLISHED = {"XPBD": 158.98, "VBD": 139.53, "explicit": 84.99}
"""Solver -> tip, mm downwards."""
PUBLISHED_ELEMENTS = 43.20
OWN = "neo-Hookean, log J"
SOLVERS = {
    "XPBD": "two constraints, I - 3 and J - 1",
    "VBD": "neo-Hookean without logarithm, lam + mu",
    "explicit": "Smith's neo-Hookean, Lamé's constants as they stand",
}
"""Solver -> its law, as `laws` names it."""
COLUMNS = {
    "solver": "of Newton, as published",
    "published_tip": "mm downwards",
    "published_ratio": "over the published tip of finite elements",
    "mass_alone_factor": "times the displacement, by a full cell's mass on each node",
    "law_alone_factor": "times the displacement, by the law to first order",
    "predicted_tip_ratio": "the two multiplied",
    "predicted_at_strain": "the same by elements of that law and mass at full strain",
    "published_over_predicted": "published over predicted",
    "status": "draft until the author has been told",
}
GAPS = (
    "law_alone_factor", "predicted_tip_ratio", "predicted_at_strain", "published_over_predicted",
)  # fmt: skip
"""Columns that have no number where a law is no solid."""


def run() -> kit.Evidence:
    """Predict the three tips."""
    elements = _tip(OWN, heavy=False)
    mass = _linear_tip(heavy=True) / _linear_tip(heavy=False)
    rows = [_row(name, elements, mass) for name in SOLVERS]
    table = pd.DataFrame(rows)
    explicit = float(rows[-1]["published_over_predicted"])  # type: ignore[arg-type]
    own = (
        kit.Tolerance(
            "hanging: tip of linear tetrahedra over the published one of the same elements",
            0.01, "1",
            "the same cells and law; which way their diagonals run may be mirrored",
            "agreement",
            observed=kit.Observed(elements / PUBLISHED_ELEMENTS, 1.0),
        ),
        kit.Tolerance(
            "hanging: published tip of the explicit solver over the predicted one", 0.05, "1",
            "its energy at the stop, 1 %; damping that rings on, 1 %; a law of another version, 3 "
            "%",
            "agreement",
            observed=kit.Observed(explicit, 1.0),
        ),
    )  # fmt: skip
    return kit.Evidence(
        tables={"hanging": fill_gaps(table)},
        tolerances=own,
        findings=(_finding(explicit, mass),),
        columns=with_none(COLUMNS, *GAPS),
        rounding=dict.fromkeys(("mass_alone_factor", *GAPS), 1e-7),
    )  # fmt: skip


def _finding(explicit: float, mass: float) -> str:
    published = PUBLISHED["explicit"] / PUBLISHED_ELEMENTS
    return (
        f"A hanging bar's tip, published as {published:.3f} times that of elements, is "
        f"{published / explicit:.3f} times by law and masses alone; of the other two tips "
        f"{mass:.2f} times is mass (a draft: the author has still to be told)."
    )


def _row(name: str, elements: float, mass: float) -> dict[str, object]:
    law = predicted(SOLVERS[name], *_modulus_and_ratio())
    asked = _modulus_and_ratio()[0]
    softer = np.nan if law.E is None else asked / law.E
    ratio = PUBLISHED[name] / PUBLISHED_ELEMENTS
    full = _tip(SOLVERS[name], heavy=True) / elements if law.E is not None else np.nan
    values = (
        name, PUBLISHED[name], ratio, mass, softer, mass * softer, full, ratio / full, "draft",
    )  # fmt: skip
    return dict(zip(COLUMNS, values, strict=True))


def _modulus_and_ratio() -> tuple[float, float]:
    """E (Pa) and nu of the published Lamé's constants."""
    return MU * (3 * LAM + 2 * MU) / (LAM + MU), LAM / (2 * (LAM + MU))


@cache
def _bar() -> Request:
    """The bar as a request: its top held, its weight downwards, the published grid's own cells."""
    E, nu = _modulus_and_ratio()
    mesh = _grid_in_fives()
    material = kit.Isotropic(E, nu, "solid", DENSITY)
    none = np.zeros(mesh.points.shape)
    top = mesh.points[:, 2] == mesh.points[:, 2].max()
    return Request(
        "rest",
        mesh,
        material,
        mass=Block(mesh, material).lumped,
        gravity=np.array([0.0, 0.0, -GRAVITY]),
        force=none,
        held=np.repeat(top[:, None], 3, axis=1),
        value=none,
        name="hanging bar",
    )


def _grid_in_fives() -> kit.Mesh:
    """Cubes of five tetrahedra, mirrored from cube to cube so that their diagonals meet."""
    nodes = np.stack(np.meshgrid(*(np.arange(k + 1) for k in CELLS), indexing="ij"), axis=-1)
    number = np.arange(nodes[..., 0].size).reshape(nodes.shape[:3])
    cells = []
    for first in np.ndindex(*CELLS):
        odd = sum(first) % 2
        for corners in FIVES:
            cell = [
                number[tuple(np.add(first, (corner[0] ^ odd, *corner[1:])))] for corner in corners
            ]
            swapped = [cell[1], cell[0], *cell[2:]]  # a mirrored cell would be inside out
            cells.append(swapped if odd else cell)
    return kit.Mesh(CELL * nodes.reshape(-1, 3).astype(float), np.array(cells), "tetra")


def _weighed(request: Request, *, heavy: bool) -> Request:
    if not heavy:
        return request
    cells = float(np.prod(CELLS))
    return replace(request, mass=np.full(len(request.mass), request.mass.sum() / cells))


def _tip(law: str, *, heavy: bool) -> float:
    """Largest downward displacement (mm), at full strain: what is published as the tip."""
    mu, lam = lame(*_modulus_and_ratio())
    return _solved(lambda F: LAWS[law].stress(F, mu, lam), heavy=heavy)


def _linear_tip(*, heavy: bool) -> float:
    mu, lam = lame(*_modulus_and_ratio())
    return _solved(lambda F: LAWS["linear"].stress(F, mu, lam), heavy=heavy)


def _solved(stress: Stress, *, heavy: bool) -> float:
    request = _weighed(_bar(), heavy=heavy)
    move, _ = at_rest(request, stress)
    return float(-1e3 * move[:, 2].min())
