"""Bending: who follows a block whose ends turn, springs or linear elements?

Question   Displacement and end moment of a block 4 x 1 whose ends turn as rigid plates on an arc,
           up to 40 % strain at its outer side.
Candidate  Square-8 cells of linear springs, N through the height.
Reference  Finite elements of degree 2 of the neo-Hookean law with the same moduli; beside it those
           of St. Venant-Kirchhoff's law, of the lattice's own energy, and linear elasticity.
Expected   Linear elements do not know that a turned end is turned; springs do, and beat them in
           displacement from strains below 1 %. Elements with the lattice's energy follow the
           springs: what is left is the spacing.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from itertools import product
from typing import NamedTuple

import numpy as np
import pandas as pd
from scipy.sparse.linalg import spsolve

from msvalidate import kit
from msvalidate.bench.judging.singularity import clamped_free_exponent
from msvalidate.problem import Array
from msvalidate.springs.bodies.calibrate import calibrate_material
from msvalidate.springs.bodies.lattice_network import lattice_network
from msvalidate.springs.constants.stiffness import square_tensor
from msvalidate.springs.lattice import square
from msvalidate.springs.network import Configuration, Network
from msvalidate.springs.statics.equilibrium import equilibrium
from reference_fem.elasticity import stiffness
from reference_fem.large_strain.by_cell import st_venant_kirchhoff
from reference_fem.large_strain.equilibrium import deform
from reference_fem.large_strain.hyperelastic import Law, NeoHookean, square_fibres
from reference_fem.large_strain.solid import Solid
from reference_fem.mesh.boxes import box_discretisation
from reference_fem.mesh.discretisation import Discretisation

from . import fibres

BOX = kit.Box((4.0, 1.0))
STRAINS = (0.005, 0.02, 0.05, 0.1, 0.3, 0.4)
"""At the outer side, one after the other: each start is from the one before."""
CELLS, QUICK = (6, 12, 24), (6, 12)
"""Of springs, through the height."""
MOST = 12
"""Cells up to which the candidate reaches all strains from rest; others are the network's own
equilibria along a path of turned ends: raised in proportion, ends move along chords, and fold the
small cells beside them."""
LEAST = 1e-9
"""Strain for which the arc still has a radius."""
MESH, FINER = (32, 8), (64, 16)
MOMENTS = {0.02: 0.008901, 0.05: 0.022008, 0.1: 0.042628, 0.3: 0.114563, 0.4: 0.149000}
"""N·m of the neo-Hookean block, by an independent program."""
KNOWN = {
    "springs": {0.02: 0.011, 0.05: 0.022, 0.1: 0.051, 0.3: 0.126, 0.4: 0.109},
    "St. Venant-Kirchhoff": {0.02: 0.005, 0.05: 0.027, 0.1: 0.087, 0.3: 0.14},
    "linear elasticity": {0.02: 0.01, 0.05: 0.06, 0.1: 0.23, 0.3: 1.47, 0.4: 1.84},
}
"""Moments over that, less 1, of the same program; springs have 12 cells."""
DIFFERENCES = {
    "springs": {0.02: 0.0009, 0.05: 0.0053, 0.1: 0.0184, 0.3: 0.0574, 0.4: 0.0663},
    "St. Venant-Kirchhoff": {0.02: 0.0023, 0.05: 0.0123, 0.1: 0.0388, 0.3: 0.126},
    "linear elasticity": {0.02: 0.0144, 0.05: 0.0364, 0.1: 0.0735, 0.3: 0.210, 0.4: 0.272},
}
"""Largest difference of a component to even elements over the largest, by the same program."""
CORNER = clamped_free_exponent(square_tensor(2.0, 1.0), np.pi / 2)
NONE, TENSION = "none", "springs of no rest length"
LIKE = {"strain": tuple(MOMENTS)}


def _moments(rows: pd.DataFrame) -> list[float]:
    """Distance of each known moment from its row's, in units of the known one's last digit."""
    return _apart(rows, "moment", KNOWN, 1.0, (0.05, 0.01, 0.001))


def _differences(rows: pd.DataFrame) -> list[float]:
    """The same of the differences of displacements."""
    return _apart(rows, "from_even", DIFFERENCES, 0.0, (0.1, 0.001, 0.0001))


def _apart(
    rows: pd.DataFrame,
    column: str,
    known: dict[str, dict[float, float]],
    less: float,
    digits: tuple[float, float, float],
) -> list[float]:
    """Digits are: from which size on a value has the first, what it has there, and below."""
    size, coarse, fine = digits
    seen = rows[rows["cells"].isin((12, MESH[1]))].set_index(["model", "strain"])[column]
    return [
        (float(seen[model, strain]) - less - value)
        / (coarse if value > size and round(value / coarse, 6) % 1 == 0 else fine)
        for model, own in known.items()
        for strain, value in own.items()
    ]


RULES = (
    kit.Rule(
        "moment of the neo-Hookean block: an independent program, relative", 1e-4, "1",
        "half a unit of the last of its four digits is 6e-5", table="blocks",
        value=kit.Quotient("moment_fem", "known"), reference=1.0, rows=LIKE,
    ),
    kit.Rule(
        "moments of springs and elements: an independent program, in its last digit", 1.0, "1",
        "its values are rounded to a tenth or a whole of one percent", table="bending",
        value=_moments,
    ),
    kit.Rule(
        "differences of springs and elements: an independent program, in its last digit", 1.0, "1",
        "its values are rounded to a hundredth or a tenth of one percent, and are differences to "
        "even cells, as theirs are", table="bending",
        value=_differences,
    ),
    kit.Rule(
        "refined elements: neo-Hookean moment by twice as many cells, relative", 1e-3, "1",
        "elements of degree 2 err by the corners of the clamped ends, of which a block's moment "
        "has little", table="blocks", value=kit.Quotient("moment_finer", "moment_fem"),
        reference=1.0,
    ),
    kit.Rule(
        "springs beside linear elasticity: displacement difference over its", 0.5, "1",
        "a turned end is a rotation, which springs know and linear elasticity does not: from 2 % "
        "strain on the springs' law is the smaller error", layer="agreement", table="bending",
        rows={"model": "springs", "cells": 12, **LIKE},
        value=kit.Quotient("difference", "difference_linear"),
    ),
    kit.Rule(
        "springs of no rest length against neo-Hookean elements at 10 %: order in cells", 0.3, "1",
        "the farthest point is next to a clamped corner, where bilinear elements err as "
        "the spacing to the corner's own exponent; one pair of sizes shows it to a third (an order "
        "of 1.6, that of points further off, was expected first)", table="bending",
        rows={"model": TENSION, "strain": 0.1}, last=2, value="difference",
        power_of=kit.Quotient(1, "cells"), reference=CORNER,
    ),
    kit.Rule(
        "springs against elements of their own energy, displacement", 2e-3, "1",
        "what is left is the spacing: (1/12)² times the strains' curvature", layer="agreement",
        table="bending", rows={"model": "springs", "cells": 12}, value="from_own",
    ),
)  # fmt: skip


def _stop_early(problem: kit.Problem, network: Network, answer: kit.Answer) -> Array:
    u = kit.solve_springs(problem, network, answer)
    return np.where(network.fixed, u, 0.999 * u)


FAULTS: dict[str, dict[str, object]] = {
    "free points stop a thousandth short": {"candidate": _stop_early, "questions": ("bending",)},
}
FIGURES = {
    "bending": kit.series(
        "bending", title="A block whose ends turn: difference to neo-Hookean elements",
        size=(6.4, 4.0), x="strain", y="difference", by="model", log="xy",
        rows={"cells": (12, MESH[1])},
        labels=("strain at the outer side (1)", "difference over largest displacement (1)"),
    ),
    "moment": kit.series(
        "bending", title="A block whose ends turn: moment", size=(6.4, 4.0), x="strain", y="moment",
        by="model", rows={"cells": (12, MESH[1])},
        labels=("strain at the outer side (1)", "moment over neo-Hookean moment (1)"),
    ),
}  # fmt: skip


def arc(points: Array, strain: float) -> Array:
    """Displacement (n, 2) in m onto an arc that keeps the middle line's length."""
    (length, height), turn = BOX.size, 2 * strain * BOX.size[0] / BOX.size[1]
    x, y = points[:, 0] - length / 2, points[:, 1] - height / 2
    radius, angle = length / turn, x / length * turn
    bent = np.stack([(radius - y) * np.sin(angle), radius - (radius - y) * np.cos(angle)], axis=1)
    return np.asarray(bent - np.stack([x, y], axis=1))


def moment(points: Array, u: Array, force: Array) -> float:
    """Moment (N·m) of forces (n, 2) in N on the right end about its middle."""
    right = points[:, 0] > BOX.size[0] * (1 - 1e-9)
    x = (points + u)[right]
    arm = x - (x.max(axis=0) + x.min(axis=0)) / 2
    return float((arm[:, 0] * force[right, 1] - arm[:, 1] * force[right, 0]).sum())


class Answer(NamedTuple):
    """Displacement (n, 2) in m at the lattice's points, and the moment (N·m) at an end."""

    at: Callable[[Array], Array]
    moment: float


def run(candidate: kit.DisplacementSolver, setting: kit.Setting) -> kit.Evidence:
    """Bend blocks of springs and of elements, from strain to strain."""
    law = NeoHookean(1.0, 1.0)
    neo, near, finer = (
        bend_elements(law, mesh, grading)
        for mesh, grading in ((MESH, 1.0), (MESH, 2.0), (FINER, 2.0))
    )
    plane = kit.Isotropic(2.5, 0.25, "plane_strain")  # λ = μ = 1 Pa
    others = {
        "St. Venant-Kirchhoff": bend_elements(st_venant_kirchhoff(plane), MESH),
        "lattice's energy": bend_elements(square_fibres(2.0, 1.0), MESH),
        "linear elasticity": {strain: bend_linear(strain) for strain in STRAINS},
    }
    rows = []
    for cells in QUICK if setting.quick else CELLS:
        points, springs = bend_springs(candidate, cells)
        models = {"springs": springs, TENSION: bend_springs(candidate, cells, "neo-Hookean")[1]}
        models |= others if cells == 12 else {}
        for (model, found), strain in product(models.items(), STRAINS):
            lattice = model in ("springs", TENSION)
            if strain not in finer:
                continue
            answer, wanted = found.get(strain), finer[strain].at(points)
            size = np.abs(wanted).max()

            def off(
                one: Answer | None, other: Array, size: float = size, x: Array = points
            ) -> object:
                return NONE if one is None else np.abs(one.at(x) - other).max() / size

            own = others["lattice's energy"].get(strain)
            row = {"model": model, "cells": cells if lattice else MESH[1]}
            row |= {"strain": strain, "difference": off(answer, wanted)}
            row["from_even"] = off(answer, neo[strain].at(points))
            row["reference"] = off(near[strain], wanted)
            row["moment"] = NONE if answer is None else answer.moment / neo[strain].moment
            row["difference_linear"] = off(others["linear elasticity"][strain], wanted)
            row["from_own"] = NONE if own is None else off(answer, own.at(points))
            rows.append(row)
    blocks = [
        {"strain": strain, "moment_fem": neo[strain].moment, "moment_finer": finer[strain].moment,
         "known": MOMENTS.get(strain, NONE)}
        for strain in STRAINS if strain in neo and strain in finer
    ]  # fmt: skip
    bending = pd.DataFrame(rows)
    laws = {"neo-Hookean": neo, **others, "springs": springs}
    del laws["linear elasticity"]
    reached = pd.DataFrame({"law": list(laws), "reached": [max(found) for found in laws.values()]})
    at = bending[(bending["cells"].isin((12, MESH[1]))) & (bending["strain"] == 0.1)]
    left = 100 * at.set_index("model")["difference"].astype(float)
    far = reached.set_index("law")["reached"]
    finding = (
        "A block bent to 10 % strain at its outer side: springs on square-8 cells are "
        f"{left['springs']:.1f} % off neo-Hookean elements, springs of no rest length beside cells "
        f"under pressure {left[TENSION]:.2f} %, elements of Saint Venant-Kirchhoff's law "
        f"{left['St. Venant-Kirchhoff']:.1f} %, linear elasticity {left['linear elasticity']:.1f} "
        "%: it takes a turned end for a strained one. Elements of Saint Venant-Kirchhoff's law "
        f"fold beyond {100 * far['St. Venant-Kirchhoff']:.0f} %, where neo-Hookean ones and "
        f"springs come to rest, at {100 * far['springs']:.0f} % too."
    )
    return kit.Evidence(
        {"bending": bending, "blocks": pd.DataFrame(blocks), "reached": reached},
        tolerances=RULES,
        columns=kit.columns(__file__), findings=(finding,), figures=FIGURES,
    )  # fmt: skip


def bend_springs(
    candidate: kit.DisplacementSolver, cells: int, route: str = "springs"
) -> tuple[Array, dict[float, Answer]]:
    """Points (n, 2) in m of square-8 cells, and strain -> what they do."""
    material, grid = kit.Isotropic(fibres.E2, fibres.NU2), square(BOX, (4 * cells, cells))
    made = calibrate_material(material, grid, route=route)
    found: dict[float, Answer] = {}
    before, u = 0.0, None
    for strain in STRAINS:
        bent = tuple(partial(_component, strain, axis) for axis in (0, 1))
        held = tuple(kit.Support(BOX.side(side), bent) for side in ("left", "right"))
        problem = kit.Problem(BOX, material, held)
        network = lattice_network(problem, grid, made)
        if cells <= MOST:
            u = candidate(problem, network, "nonlinear")
        else:
            turn = partial(_turned, network, before, strain)
            u = equilibrium(network, "nonlinear", path=turn, start=u).displacement
        pull = moment(network.points, u, -Configuration(network, u).force())
        found[strain], before = Answer(partial(_same, u), pull), strain
    return grid.points, found


def _turned(network: Network, first: float, last: float, t: float) -> tuple[Array, Array]:
    """Force and prescribed displacement (n, 2) at t of a path from one strain to the next."""
    onto = arc(network.points, max(first + t * (last - first), LEAST))
    return network.force, np.where(network.fixed, onto, 0.0)


def _component(strain: float, axis: int, points: Array) -> Array:
    return np.asarray(arc(points, strain)[:, axis])


def _same(u: Array, points: Array) -> Array:
    return u


def bend_elements(law: Law, mesh: tuple[int, int], grading: float = 1.0) -> dict[float, Answer]:
    """Strain -> what elements of degree 2 of a law do, up to where there is no equilibrium."""
    body = box_discretisation(BOX, mesh, grading=grading)
    solid = Solid(body, law, ends(body.points))
    found, u, before = {}, np.zeros(body.points.shape), 0.0
    for strain in STRAINS:
        onto = arc(body.points, strain)
        start = u + onto - (arc(body.points, before) if before else 0.0)
        try:
            u = deform(solid, onto, np.zeros(onto.shape), start=start).displacement
        except kit.SolverError:
            break
        before, pull = strain, moment(body.points, u, solid.internal_force(u)[0])
        found[strain] = Answer(partial(_interpolated, body, u), pull)
    return found


def _interpolated(body: Discretisation, u: Array, points: Array) -> Array:
    return np.asarray(body.interpolation(points) @ u)


def ends(points: Array) -> kit.Mask:
    """Components (n, 2) held at both ends."""
    length = BOX.size[0]
    at = (points[:, 0] < 1e-9 * length) | (points[:, 0] > (1 - 1e-9) * length)
    return np.repeat(at[:, None], 2, axis=1)


def bend_linear(strain: float) -> Answer:
    """What linear elements of degree 2 do, whose ends are put where the turned plates are."""
    body = box_discretisation(BOX, MESH)
    K, held = (
        stiffness(body, kit.Isotropic(fibres.E2, fibres.NU2)).tocsc(),
        ends(body.points).T.ravel(),
    )
    u = np.where(held, arc(body.points, strain).T.ravel(), 0.0)
    u[~held] = spsolve(K[~held][:, ~held], -K[~held] @ u)
    force, u = ((each.reshape(2, -1).T) for each in (K @ u, u))
    return Answer(partial(_interpolated, body, u), moment(body.points, u, force))
