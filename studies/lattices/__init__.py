"""Effective elastic moduli of lattices

Every lattice that `springs.lattice.patterns` knows, under each of its rules for the constants of
its springs. One question a file:

- `solids`: tensor, modulus, ratio and anisotropy of the endless lattice, and its fastest wave;
- `orthotropic`: a solid whose three shears differ, told apart;
- `uniform`: bodies under uniform stress: which are exact, and at what order others converge;
- `clamped`: bodies with singular stress, against finite elements;
- `cost`: steps to rest;
- `choice`: one table of it all, to choose a lattice by;
- `controls`: the smallest fault that this study notices;
- `voronoi`: the same of random lattices, and how a ratio of zero comes about;
- `ratio`: whether any Poisson's ratio is reached, and what becomes of rubber.

Candidate: displacements predicted for a problem and its network, and the solid that a lattice is
said to be. Reference: closed forms, differences of energy, scikit-fem finite elements.
"""

from __future__ import annotations

from functools import cache, partial

from msvalidate import kit
from msvalidate.springs.constants.homogenise import homogenise

from . import choice, clamped, cost, lattices_controls, orthotropic, solids, uniform
from .cases import Solid
from .ratio import any_ratio, near_half
from .ratio import faults as ratio_faults
from .voronoi import bodies, faults, zero
from .voronoi import solids as random_solids

FAULTS = {
    "one neighbour direction missing": {
        "solid": lattices_controls.solid_with(1.0),
        "questions": ("solids",),
    },
    "every spring 1 % stiffer": {
        "candidate": lattices_controls.body_with("stiffness of every spring", 0.01),
        "questions": ("uniform",),
    },
    "clamped bodies 1 % stiffer": {
        "candidate": lattices_controls.body_with("stiffness of every spring", 0.01),
        "questions": ("clamped",),
    },
    "one spring missing": {
        "candidate": lattices_controls.body_with("one spring", 1.0),
        "questions": ("uniform",),
    },
    "wrong boundary weights": {
        "candidate": lattices_controls.body_with("boundary weights", 1.0),
        "questions": ("uniform",),
    },
    **faults.FAULTS,
    **ratio_faults.FAULTS,
}
"""Negative controls: arguments of `run` under which a tolerance must fail, asked of the question
that should notice."""


def run(
    candidate: kit.DisplacementSolver = kit.solve_springs,
    setting: kit.Setting = kit.FULL,
    questions: tuple[str, ...] | None = None,
    solid: Solid = homogenise,
) -> kit.Evidence:
    """All questions, or those named, for one candidate and one way to homogenise."""
    candidate = kit.check_displacements(candidate)
    endless = cache(partial(solids.solid_tables, solid, setting))
    stretched = cache(lambda: uniform.run(candidate, solid, setting))
    held = cache(lambda: clamped.run(candidate, solid, setting))
    rested = cache(lambda: cost.run(solid, setting, endless()["solids"]))
    return kit.gather_evidence(
        {
            "solids": lambda: solids.run(endless()),
            "orthotropic": lambda: orthotropic.run(candidate, solid, setting),
            "uniform": stretched,
            "clamped": held,
            "cost": rested,
            "choice": lambda: choice.run(
                {**endless(), **stretched().tables, **held().tables, **rested().tables}
            ),
            "controls": lattices_controls.run,
            "random_solids": lambda: random_solids.run(solid, setting),
            "random_bodies": lambda: bodies.run(candidate, setting, solid),
            "zero": lambda: zero.run(candidate, setting, solid),
            "any_ratio": lambda: any_ratio(candidate, setting),
            "rubber": lambda: near_half(candidate, setting),
        },
        questions,
    )
