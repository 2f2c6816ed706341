"""Pull-in of a dielectric elastomer slab

Charges squeeze the slab, a thinner slab is squeezed more, and past some voltage no equilibrium is
left. Several instabilities share that name. One question a file:

- `sweep`: thickness against voltage up to pull-in, between walls and bonded, springs and elements;
- `permittivity`: a slab of another permittivity;
- `instability`: the lowest eigenvalue of K_mech - K_elec and its mode on several meshes, the
  electrode's edge told from the slab inside;
- `which`: which pull-in is which, closed forms beside computed values;
- `beyond`: what is said and kept at a voltage that no slab holds;
- `controls`: faulty ways to rest, and the smallest fault that this study notices.

Candidate: a way to rest at a voltage and its softest motions (`way`), by default the network's own,
and the laws of the films that `which` finds thresholds of.
Reference: the infinite slab in closed form and its waves (`infinite`), finite elements with the
lattice's energy, and the same slab pressed charge by charge (`pressed`).
"""

from __future__ import annotations

from functools import partial

from msvalidate import kit

from . import beyond, instability, permittivity, pull_in_controls, sweep, which
from .way import SPRINGS, PullInSolver

ASKED = {
    "sweep": sweep.run,
    "permittivity": permittivity.run,
    "instability": instability.run,
    "beyond": beyond.run,
    "which": which.run,
}
"""Question -> who answers it for a candidate."""
FAULTS = {
    name: {"candidate": way, "questions": (question,)}
    for name, (way, question) in pull_in_controls.FAULTS.items()
}
"""Negative controls: arguments of `run` under which a tolerance must fail. One question that
notices is enough, so the rest is left out."""


def run(
    candidate: PullInSolver = SPRINGS,
    setting: kit.Setting = kit.FULL,
    questions: tuple[str, ...] | None = None,
) -> kit.Evidence:
    """All questions, or those named, for one candidate."""
    candidate = kit.check_functions(candidate, PullInSolver)
    asked = {name: partial(ask, candidate, setting) for name, ask in ASKED.items()}
    return kit.gather_evidence(asked | {"controls": pull_in_controls.run}, questions)
