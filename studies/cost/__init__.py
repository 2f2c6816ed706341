"""Cost: what do springs and elements cost, and what limits them?

Springs are chosen for their speed, so both sides are timed beside the programs that others use, in
the same process and in turn. One question a file:

- `agreement`: whether all paths of the kernel make the same motion;
- `kernel`: nanoseconds a spring and step, beside NumPy, SciPy and LAMMPS;
- `limits`: what holds each path, instructions or memory, and up to what size it is real time;
- `fem`: seconds to assemble and to solve, beside SciPy and NGSolve;
- `relaxation`: steps and seconds to rest, and their growth;
- `refinement`: corrections of a linear solution, and their part of its time;
- `solvers`: seconds, memory and steps of an equilibrium by a factor or multigrid; whether its
  stated error is true;
- `solver_peers`: the same cubes by NGSolve and SciPy;
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

from msvalidate import kernels
from msvalidate.judging.candidate import of_kind
from msvalidate.judging.evidence import Evidence, answers
from msvalidate.judging.sweep import Setting
from msvalidate.network import Network
from msvalidate.relaxation.relax import Method
from msvalidate.relaxation.relaxations import RELAXATIONS

from . import (
    agreement,
    fem,
    fem_ways,
    kernel,
    large,
    limits,
    machine,
    refinement,
    relaxation,
    solver_peers,
    solvers,
    spoilt,
    targets,
)
from .fem_ways import Solve
from .kernel import Moving


@dataclass(frozen=True)
class Candidate:
    """What is timed and held to its counts.

    Parameters
    ----------
    motion
        A network made ready for steps, as `kernels.Motion`.
    relaxations
        Name -> way to rest.
    elements
        Name -> way to solve a finite element body; "auto" is the one that is timed.
    linear
        The linear equilibrium of a network.
    rest
        The same by the solver of a name.
    multigrid_steps
        Steps of conjugate gradients that multigrid takes to it.
    """

    motion: Moving = kernels.Motion
    relaxations: Mapping[str, Method] = field(default_factory=lambda: dict(RELAXATIONS))
    elements: Mapping[str, Solve] = field(default_factory=lambda: dict(fem_ways.WAYS))
    linear: refinement.Linear = refinement.solved
    rest: solver_peers.Rest = solvers.solved
    multigrid_steps: Callable[[Network], int] = solvers.steps


OURS = Candidate()
ALONE = True
"""It compares times: what runs beside it would take some of them."""
FAULTS = {
    "a kernel that drops a spring": {
        "candidate": replace(OURS, motion=spoilt.dropping),
        "questions": ("agreement",),
    },
    "a kernel that makes numbers of what is none": {
        "candidate": replace(OURS, motion=spoilt.Blind),
        "questions": ("agreement",),
    },
    "a relaxation that tells of half its steps": {
        "candidate": replace(
            OURS, relaxations=RELAXATIONS | {"viscous_leapfrog": spoilt.HALF_COUNTED}
        ),
        "questions": ("relaxation",),
    },
    "a relaxation whose steps grow as the points": {
        "candidate": replace(
            OURS, relaxations=RELAXATIONS | {"viscous_leapfrog": spoilt.EVER_SHORTER}
        ),
        "questions": ("relaxation",),
    },
    "elements solved in single precision": {
        "candidate": replace(OURS, elements=fem_ways.WAYS | {"auto": spoilt.rounded}),
        "questions": ("fem",),
    },
    "a linear solution that is not refined": {
        "candidate": replace(OURS, linear=refinement.unrefined),
        "questions": ("refinement",),
    },
    "a solver that stops early and states no error": {
        "candidate": replace(OURS, rest=spoilt.careless),
        "questions": ("solvers",),
    },
    "a solver without coarse levels": {
        "candidate": replace(OURS, multigrid_steps=spoilt.without_levels),
        "questions": ("solvers",),
    },
}
"""Negative controls: arguments of `run` under which a tolerance must fail. One question that
notices is enough, so the rest is left out."""


def run(
    candidate: Candidate = OURS,
    setting: Setting | None = None,
    questions: tuple[str, ...] | None = None,
) -> Evidence:
    """All questions, or those named."""
    setting = setting or Setting()
    candidate = of_kind(candidate, Candidate)
    asked: dict[str, Callable[[], Evidence]] = {
        "agreement": cache(partial(agreement.run, candidate.motion, setting)),
        "kernel": cache(partial(kernel.run, candidate.motion, setting)),
        "fem": cache(partial(fem.run, candidate.elements, setting)),
        "relaxation": cache(partial(relaxation.run, candidate.relaxations, setting)),
        "refinement": cache(partial(refinement.run, candidate.linear, setting)),
        "solvers": cache(partial(solvers.run, candidate.rest, candidate.multigrid_steps, setting)),
        "solver_peers": cache(partial(solver_peers.run, candidate.rest, setting)),
        "large": cache(
            partial(large.run, candidate.relaxations[large.METHOD], candidate.elements, setting)
        ),
        "machine": machine.run,
    }
    asked["limits"] = cache(lambda: limits.run(asked["kernel"]().tables["kernel"], setting))
    told = {name: asked[name] for name in targets.FROM}
    return answers(asked | {"targets": partial(targets.run, told, setting)}, questions)
