# SPDX-License-Identifier: MIT
"""Rest states of one body at several time steps and numbers of iterations, beside what they near.

A state at rest of a solid depends on neither. Where a program's does, this tells by how much, also
of programs that the gate stops. The body is the gate's block, clamped at one side and hung by its
weight (10 m/s² if E is 1e7 Pa and the density 1000 kg/m³), which all programs can represent.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np

from msvalidate.linear_algebra.norms import max_length
from msvalidate.problem import Array, Isotropic, SolverError
from msvalidate.simulators.bodies.laws import stress_of
from msvalidate.simulators.bodies.tetrahedra import at_rest
from msvalidate.simulators.exchange.protocol import (
    Answer,
    CannotRepresent,
    Request,
    Simulator,
    ask,
    stated_residual_motion,
)
from msvalidate.simulators.gate.gate import stretched_block
from msvalidate.simulators.probe.block import Block
from msvalidate.simulators.probe.masses import patterns

OWN_SHARE = "each node's own share"
LENT = (1.0, 0.3, 0.1, 0.03, 0.01, 3e-3, 1e-3, 3e-4, 1e-4, 1e-5)
"""Parts of Hooke's law, with the asked constants, that lead a law without a stiffness to rest."""
EQUAL = "equal masses on all nodes"


@dataclass(frozen=True)
class Sweep:
    """Which rest states are asked for.

    Parameters
    ----------
    dts
        Time steps, s; none: the adapter's own, and half of it.
    iterations
        Of a step; none for programs that have no such number.
    law
        Of `msvalidate.simulators.bodies.laws`, that the states should near.
    masses
        Of its nodes, as documented: a key of `msvalidate.simulators.probe.masses.patterns`.
    settings
        Beside those of the job.
    label
        What tells this sweep from others of a job.
    """

    dts: tuple[float, ...] = ()
    iterations: tuple[int, ...] = ()
    law: str = "linear"
    masses: str = OWN_SHARE
    settings: Mapping[str, Any] = field(default_factory=dict)
    label: str = ""


def rest_states(
    simulator: Simulator, material: Isotropic, settings: Mapping[str, Any], sweep: Sweep
) -> list[dict[str, Any]]:
    """A row a state, for JSON: `iterations`, `dt` (s), `error`, `rest`, changes, `seconds`.

    `error` is the largest difference from elements of the sweep's law at rest on the same mesh with
    its masses; `rest` what the program says may still change; `by_iterations` and `by_dt` the
    largest change from the state with the iterations before and with the dt before. All are over
    the largest displacement of those elements; None where there is none.
    """
    block = stretched_block(material, {**settings, **sweep.settings}, hanging=True)
    wanted = _elements(block, sweep)
    size = max_length(wanted)
    answers: dict[tuple[int, int], Answer] = {}
    rows = []
    numbers: tuple[int | None, ...] = sweep.iterations or (None,)
    for at, dt in enumerate(_time_steps(simulator, block, sweep)):
        for turn, count in enumerate(numbers):
            row: dict[str, Any] = {"label": sweep.label, "beside": sweep.law}
            row |= {"iterations": count, "dt": dt, "precision": None, "seconds": None}
            row |= dict.fromkeys(("error", "rest", "by_iterations", "by_dt")) | {"because": ""}
            rows.append(row)
            try:
                answer = ask(simulator, _asked(block, count, dt))
            except (CannotRepresent, SolverError) as error:
                row["because"] = str(error)
                continue
            answers[turn, at] = answer
            row |= {"precision": answer.about["precision"], "seconds": answer.about.get("seconds")}
            row["error"] = max_length(_moved(answer) - wanted) / size
            row["rest"] = _known(stated_residual_motion(block, answer))
            row["by_iterations"] = _change(answer, answers.get((turn - 1, at)), size)
            row["by_dt"] = _change(answer, answers.get((turn, at - 1)), size)
    return rows


def _asked(block: Request, iterations: int | None, dt: float) -> Request:
    own = {} if iterations is None else {"iterations": iterations}
    return replace(block, settings={**block.settings, **own, "dt": dt})


def _time_steps(simulator: Simulator, block: Request, sweep: Sweep) -> tuple[float, ...]:
    if sweep.dts:
        return sweep.dts
    own = float(ask(simulator, block).about["dt"])
    return own, own / 2


def _elements(block: Request, sweep: Sweep) -> Array:
    """(n, 3) m of linear tetrahedra of the law at rest, with its large strains and its masses."""
    pattern = patterns(Block(block.mesh, block.material))[sweep.masses]
    weighed = replace(block, mass=pattern * (block.mass.sum() / pattern.sum()))
    E, nu = block.material.E, block.material.nu
    law, hooke = stress_of(sweep.law, E, nu), stress_of("linear", E, nu)
    try:
        return at_rest(weighed, law)[0]
    except SolverError:  # it has no stiffness where it begins: less and less of another's is lent
        move = None
        for part in LENT:
            move = at_rest(weighed, partial(_sum_of, law, hooke, part), move)[0]
        return at_rest(weighed, law, move)[0]


def _sum_of(
    law: Callable[[Array], Array], hooke: Callable[[Array], Array], part: float, F: Array
) -> Array:
    """A law's stress of F, and a part of Hooke's."""
    return law(F) + part * hooke(F)


def _change(answer: Answer, before: Answer | None, size: float) -> float | None:
    return None if before is None else max_length(_moved(answer) - _moved(before)) / size


def _moved(answer: Answer) -> Array:
    assert answer.displacement is not None  # noqa: S101  as `ask` sees to
    return answer.displacement


def _known(value: float) -> float | None:
    return value if np.isfinite(value) else None
