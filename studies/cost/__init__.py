"""Run time of springs and finite elements

Springs are chosen for their speed, so both sides are timed beside the programs that others use, in
the same process and in turn. One question a file:

- `agreement`: whether all paths of the kernel make the same motion;
- `kernel`: nanoseconds a spring and step, beside NumPy, SciPy and LAMMPS;
- `limits`: what holds each path, instructions or memory, and up to what size it is real time;
- `fem`: seconds to assemble and to solve, beside SciPy and NGSolve;
- `relaxation`: steps and seconds to rest, and their growth;
- `solvers`: seconds, memory and steps of an equilibrium by a factor or multigrid; whether its
  stated error is true;
- `large`: large networks by Newton's method with multigrid, and bytes a point;
- `targets`: what was aimed at, and what this machine reached;
- `machine`: processor, caches, versions.

Candidate: the kernel's `Motion`, the table of relaxations and the ways to solve elements.
Reference: plain forms of the same steps, predictions from frequencies, `spsolve`, another solver.
Times are told and never judged; agreement, counts of steps and their growth are. Peers (LAMMPS,
NGSolve) are left out where they are not installed.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cache, partial
from typing import Any

from msvalidate import kit
from msvalidate.springs import kernels
from msvalidate.springs.dynamics.relaxations import RELAXATIONS
from msvalidate.springs.dynamics.run import Method

from . import (
    agreement,
    fem,
    fem_ways,
    kernel,
    large,
    limits,
    machine,
    relaxation,
    solvers,
    spoilt,
    targets,
)
from .fem_ways import Solve
from .kernel import Moving


@dataclass(frozen=True)
class Implementations:
    """What is timed and held to its counts.

    Parameters
    ----------
    motion
        A network made ready for steps, as `springs.kernels.Motion`.
    relaxations
        Name -> way to rest.
    elements
        Name -> way to solve a finite element body; "auto" is the one that is timed.
    rest
        The linear equilibrium of a network by the solver of a name.
    multigrid_steps
        Steps of conjugate gradients that multigrid takes to it.
    """

    motion: Moving = kernels.Motion
    relaxations: Mapping[str, Method] = field(default_factory=lambda: dict(RELAXATIONS))
    elements: Mapping[str, Solve] = field(default_factory=lambda: dict(fem_ways.WAYS))
    rest: solvers.Rest = solvers.solve_refined
    multigrid_steps: Callable[[kit.Network], int] = solvers.steps


OURS = Implementations()
ALONE = True
"""It compares times: what runs beside it would take some of them."""
FAULTY: dict[str, tuple[str, dict[str, Any]]] = {
    "a kernel that drops a spring": ("agreement", {"motion": spoilt.drop_spring}),
    "a kernel that makes numbers of what is none": ("agreement", {"motion": spoilt.Blind}),
    "a relaxation that tells of half its steps": (
        "relaxation",
        {"relaxations": spoilt.HALF_COUNTED},
    ),
    "a relaxation whose steps grow as the points": (
        "relaxation",
        {"relaxations": spoilt.EVER_SHORTER},
    ),
    "elements solved in single precision": (
        "fem",
        {"elements": fem_ways.WAYS | {"auto": spoilt.round_positions}},
    ),
    "a solver that stops early and states no error": ("solvers", {"rest": spoilt.careless_steps}),
    "a solver without coarse levels": ("solvers", {"multigrid_steps": spoilt.without_levels}),
}
"""Fault -> the question that notices it, and what of the candidate has it."""
FAULTS = {
    name: {"candidate": replace(OURS, **fault), "questions": (question,)}
    for name, (question, fault) in FAULTY.items()
}
"""Negative controls: arguments of `run` under which a tolerance must fail. One question that
notices is enough, so the rest is left out."""


def run(
    candidate: Implementations = OURS,
    setting: kit.Setting = kit.FULL,
    questions: tuple[str, ...] | None = None,
) -> kit.Evidence:
    """All questions, or those named."""
    candidate = kit.check_functions(candidate, Implementations)
    asked: dict[str, Callable[[], kit.Evidence]] = {
        "agreement": partial(agreement.run, candidate.motion, setting),
        "kernel": partial(kernel.run, candidate.motion, setting),
        "fem": partial(fem.run, candidate.elements, setting),
        "relaxation": partial(relaxation.run, candidate.relaxations, setting),
        "solvers": partial(solvers.run, candidate.rest, candidate.multigrid_steps, setting),
        "large": partial(
            large.run, candidate.relaxations[large.METHOD], candidate.elements, setting
        ),
        "machine": machine.run,
        "limits": lambda: limits.run(asked["kernel"]().tables["kernel"], setting),
    }
    # `limits` and `targets` look at what others measured.
    asked = {name: cache(answer) for name, answer in asked.items()}
    told = {name: asked[name] for name in targets.FROM}
    return kit.gather_evidence(asked | {"targets": partial(targets.run, told, setting)}, questions)
