"""Strained: does Newton's method converge quadratically where springs turn and stretch?

Question   Order of Newton's method, and the rest that it finds, at strains of 5 to 10 %: at the
           small strains of the other questions a wrong geometric part of the tangent, which is the
           tension over the length, takes one step more and shows nowhere.
Candidate  The table of relaxations: its Newton's method.
Reference  Its own last position, to which distances are taken; nonlinear conjugate gradients, which
           ask for no tangent.
Expected   Order 2 with the tangent that is the force's derivative (Kantorovich); 1 with another,
           however near, at a rate of about the strain.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from contextlib import suppress

import numpy as np
import pandas as pd

from msvalidate import kit
from msvalidate.springs.bodies.lattice_network import lattice_network
from msvalidate.springs.dynamics.relax import relax
from msvalidate.springs.dynamics.run import Method
from msvalidate.springs.lattice import square
from msvalidate.springs.network import Configuration

from . import bodies

BOX, CELLS = kit.Box((0.74, 0.37)), (12, 6)
PULL = 0.07
"""Traction over the modulus."""
TOLERANCE = 1e-13
FLOOR = 1e-13
"""Distance, over the largest displacement, at which what is left is rounding."""
ORDER = kit.Rule(
    "order of Newton's method at 5 to 10 % strain, last three distances", 0.1, "1",
    "2; what the square is multiplied by changes on the last steps by a factor of two at most, "
    "ln 2 over the logarithm of a step's gain, from 2 % of the way to its square over a few "
    "tens: 7.5",
    table="strained", last=1, value=lambda rows: pd.to_numeric(rows["gain"], errors="coerce"),
    reference=2.0,
)  # fmt: skip


def run(candidate: Mapping[str, Method], setting: kit.Setting) -> kit.Evidence:
    """Pull the plate and watch the steps."""
    network = pulled_plate()
    seen = follow_displacements(candidate["newton"], network)
    other = follow_displacements(candidate["conjugate_gradients"], network)
    table = pd.DataFrame(rows(network, seen))
    away = bodies.relative_error(seen[-1], other[-1]) if seen and other else math.nan
    rest = kit.Tolerance(
        "rest at 5 to 10 % strain: Newton's method against conjugate gradients, relative",
        1e-10, "1",
        "both stop at 1e-13 of the forces that meet at a point, times the condition number, which "
        "of 12 clamped cells is (4·12/π)² or a few times as much", observed=kit.Observed(away),
    )  # fmt: skip
    return kit.Evidence(
        tables={"strained": table},
        tolerances=(ORDER, rest),
        columns=kit.columns(__file__),
    )


def pulled_plate() -> kit.Network:
    """A plate, clamped on the left and pulled on the right by `PULL` of its modulus."""
    problem = kit.Problem(
        BOX,
        kit.Isotropic(E=1.0, nu=bodies.NU),
        (kit.Support(BOX.side("left"), (0.0, 0.0)),),
        (kit.Traction(BOX.side("right"), (PULL, 0.0)),),
        name="plate at large strain",
    )
    return lattice_network(problem, square(BOX, CELLS))


def follow_displacements(method: Method, network: kit.Network) -> list[kit.Array]:
    """Displacements (n, 2) in m after every step; none if it did not come to rest."""
    seen: list[kit.Array] = []

    def watch(run: object) -> bool:
        seen.append(np.array(run.displacement))  # type: ignore[attr-defined]
        return False

    with suppress(kit.SolverError):
        relax(network, method, tolerance=TOLERANCE, watch=watch, look_every=1)
        return seen
    return []


def rows(network: kit.Network, seen: list[kit.Array]) -> list[dict[str, object]]:
    """Rows of the table: what is left after each step, and the order of the last three."""
    if len(seen) < 2:
        return [{"steps": 0, "distance": 1.0, "strain": 0.0, "gain": "none"}]
    left = [bodies.relative_error(each, seen[-1]) for each in seen[:-1]]
    left = [each for each in left if each > FLOOR]
    found: list[dict[str, object]] = []
    for i, distance in enumerate(left):
        gain: float | str = "none"
        if i > 1:
            gain = math.log(distance / left[i - 1]) / math.log(left[i - 1] / left[i - 2])
        length = Configuration(network, seen[i]).length
        strain = float(np.abs(length / network.rest_length - 1).max())
        found.append({"steps": i, "distance": distance, "strain": strain, "gain": gain})
    return found
