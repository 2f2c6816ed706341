"""Electrode charges and electrostatic forces

The report puts even charges on springs, with the kernel 1/(4πεr) of space in a plane body, and sums
Coulomb's forces between their middles, half to each end. One question a file:

- `strips`: capacitance of facing strips against its closed form, with orders;
- `edge`: how charge gathers at an edge;
- `plates`: capacitance of a square and of a disc in space;
- `virtual_work`: forces and their tangent against the energy, on flat and on wavy electrodes;
- `in_air`: a slab of rubber with air around it, against finite elements;
- `field`: potential and field lines around it;
- `models`: the report's model, the plane model and the dielectric in air, side by side;
- `shortcuts`: what becomes of forces that are not the derivative of the energy;
- `nodes`: charge on springs against charge on the points between them;
- `scaling`: seconds;
- `controls`: faulty solvers, and the smallest fault that this study notices.

Candidate: charges and forces, the method of moments in `msvalidate.dielectric.charges` by default.
Reference: closed forms, differences of energy, accepted values, and the finite elements of
`reference_fem`, which share no code with it.
"""

from __future__ import annotations

from functools import partial

from msvalidate import kit

from . import (
    edge,
    electrostatics_controls,
    field,
    in_air,
    models,
    nodes,
    plates,
    scaling,
    shortcuts,
    strips,
    virtual_work,
)
from .common import MOMENTS, ChargeSolver

ASKED = {
    "strips": strips.run,
    "edge": edge.run,
    "plates": plates.run,
    "virtual_work": virtual_work.run,
    "in_air": in_air.run,
    "field": field.run,
    "models": models.run,
    "shortcuts": shortcuts.run,
    "nodes": nodes.run,
    "scaling": scaling.run,
}
"""Question -> who answers it for a candidate."""
FAULTS = electrostatics_controls.FAULTS
"""Negative controls: arguments of `run` under which a tolerance must fail."""


def run(
    candidate: ChargeSolver = MOMENTS,
    setting: kit.Setting = kit.FULL,
    questions: tuple[str, ...] | None = None,
) -> kit.Evidence:
    """All questions, or those named, for one candidate."""
    candidate = kit.check_functions(candidate, ChargeSolver)
    asked = {name: partial(ask, candidate, setting) for name, ask in ASKED.items()}
    return kit.gather_evidence(asked | {"controls": electrostatics_controls.run}, questions)
