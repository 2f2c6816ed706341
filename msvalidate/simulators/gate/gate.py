"""The gate: what a simulator must do right before any number of it counts.

Rest stays at rest, free fall gives g, a turn is free of stress, twice the modulus halves what
forces move, what it says of its own rest is true, and the same question has the same answer. None
of it asks for a right modulus: a simulator of another law passes, one that cannot be read does not.
Sizes that only wrong units explain are reported beside what stops it, as they can be its cause.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import cache, partial
from typing import Any

import numpy as np

from msvalidate.case.file.case import Case
from msvalidate.linear_algebra.norms import max_abs, max_length
from msvalidate.problem import (
    Array,
    Box,
    Isotropic,
    Problem,
    SolverError,
    Support,
    Traction,
    Weight,
)
from msvalidate.problem.checks import require_type
from msvalidate.problem.records import replace
from msvalidate.simulators.exchange.export import export_case
from msvalidate.simulators.exchange.protocol import (
    ROUNDING,
    Answer,
    CannotRepresent,
    NotAskedError,
    Request,
    Simulator,
    SimulatorError,
    ask,
    solves_to,
    stated_residual_motion,
)
from msvalidate.simulators.gate.rows import (
    AGAIN,
    DIVERGED,
    FREE_FALL,
    HALF_STEP,
    ITERATIONS,
    LEFT_OUT,
    MODULUS,
    MORE_STEPS,
    MOVING,
    PASSED,
    STOPPED,
    STRETCHED,
    TOLD,
    UNSTATED,
    Gate,
    GateRow,
    Word,
    remedies_of,
    size_rows,
)
from msvalidate.simulators.probe.block import wave_speed
from msvalidate.simulators.probe.reading import BAND
from msvalidate.springs.constants.stiffness import axes_moduli, lame
from msvalidate_check.beside import best_scale
from msvalidate_check.causes import Phrase, phrase

ACROSS = 4
"""Cells across the block, whose side is 1 m: quarters are exact in float32."""
ONE_STEP, MANY_STEPS = 0.5, 0.1
"""Time step over the time that a pressure wave takes through a cell. One step from rest is stable
whatever it is, and the longer it is the more of its velocity is above rounding."""
STRAIN = 2.0**-10
"""Strain of the pulled block.

It is far above rounding in float32 and small compared with 1.
"""


def stretched_block(
    material: Isotropic,
    settings: Mapping[str, Any],
    shape: str | None = None,
    *,
    hanging: bool = False,
) -> Request:
    """A block of side 1 m, clamped at its left, stretched to the right by about `STRAIN`.

    It is pulled at its right; `hanging`, it is as much under a weight, for programs without forces
    on nodes.
    """
    box, none = Box((1.0,) * material.dim), (0.0,) * material.dim
    pull = STRAIN * material.E
    load: Traction | Weight = Traction(box.side("right"), (pull, *none[1:]))
    if hanging:
        load = Weight((pull / material.density, *none[1:]))  # over a side of 1 m
    problem = Problem(box, material, (Support(box.side("left"), none),), (load,), "block")
    return export_case(Case(problem), cells=ACROSS, shape=shape, settings=settings)


def motion(block: Request, start: Array, steps: int = 1) -> Request:
    """The block let go from positions (n, d) in m, in steps short enough to be stable."""
    part = ONE_STEP if steps == 1 else MANY_STEPS
    dt = part / ACROSS / wave_speed(block.material)
    none = np.zeros_like(block.force)
    return replace(
        block,
        task="motion",
        start=start,
        # A power of two, so that floats of either kind hold it.
        dt=2.0 ** math.floor(math.log2(dt)),
        steps=steps,
        gravity=np.zeros(block.mesh.dim),
        force=none,
        held=none.astype(bool),
        value=none,
    )


def epsilon(answer: Answer) -> float:
    """Rounding of the floats that an answer was reckoned in; of float64, where it does not say."""
    return 2 * ROUNDING.get(answer.about.get("precision", ""), ROUNDING["float64"])


def turned(points: Array, angle: float) -> Array:
    """Places (n, d) turned in the plane of the first two axes about their middle."""
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    turn = np.eye(points.shape[1])
    turn[:2, :2] = [[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]]
    return np.asarray((points - middle) @ turn.T + middle)


def forces(request: Request, answer: Answer) -> Array:
    """Force (n, d) in N that the body puts on its nodes, from what one step does to velocities."""
    if answer.force is not None:
        return answer.force
    move = np.asarray(answer.velocity) / float(request.dt or 1.0)
    return np.asarray(request.mass[:, None] * (move - request.gravity))


STEPS = 10
"""Number of steps of a motion."""
FALL = 0.25
"""Fall relative to the side of the block.

Positions in float32 then determine the velocity.
"""
SMALL_TURN = 2.0**-8
"""Angle (rad) of the turn that every program must see as one."""
LARGE_TURN = math.pi / 6
ROUNDINGS = 100
"""Roundings of a coordinate that a force or a displacement may be off by: it is a sum of some tens
of terms, each rounded a few times."""
ORDERS = 5
"""Largest deviation from proportion at large strain, relative to the strain.

It covers laws and shapes.
"""


def gate(
    simulator: Simulator,
    material: Isotropic,
    settings: Mapping[str, Any] | None = None,
    shape: str | None = None,
) -> Gate:
    """Try a simulator on a small block of a material.

    Parameters
    ----------
    simulator
        What is tried; it is asked some ten times.
    material
        Of which the block is.
    settings
        Of the simulator.
    shape
        Of the block's cells; the default is triangles in 2D and tetrahedra in 3D.
    """
    require_type("gate: material", material, Isotropic)
    own = dict(settings or {})
    block = stretched_block(material, own, shape)
    stiffness = cache(partial(_stretched_step, simulator, block))
    rows = _tried({
        "rest stays at rest": partial(_at_rest, simulator, block),
        FREE_FALL: partial(_free_fall, simulator, block),
        "small turn": partial(_small_turn, simulator, block, stiffness),
        "turn by 30°": partial(_large_turn, simulator, block),
        STRETCHED: lambda: size_rows("step", _out_of_range(block.material, stiffness())),
    })  # fmt: skip
    tested = Gate(())
    hanging = stretched_block(material, own, shape, hanging=True)
    for name, asked in (("pulled block at rest", block), ("hanging block at rest", hanging)):
        try:
            first = ask(simulator, asked)
        except CannotRepresent as error:
            rows.append(_untried(name, error))
            continue
        except SolverError as error:
            rows.append(_untried(name, error))
        else:
            given, size = (simulator, asked, first), max_length(np.asarray(first.displacement))
            rows += _tried(
                {
                    "pulled block": partial(size_rows, "rest", size / STRAIN),
                    MODULUS: partial(_twice_the_modulus, *given),
                }
            )
            tested = convergence_tests(*given)
            rows += [*tested.rows, *_tried({AGAIN: partial(_same_again, *given)})]
        break
    return replace(tested, rows=tuple(rows))


def convergence_tests(simulator: Simulator, request: Request, first: Answer) -> Gate:
    """Compare a first answer at rest with half the time step, more iterations and more steps."""
    given = (simulator, request, first)
    rows = _tried({
        HALF_STEP: partial(_changed, *given, "dt", 0.5),
        ITERATIONS: partial(_changed, *given, "iterations", 2),
        MORE_STEPS: partial(_changed, *given, "steps", 2),
    })  # fmt: skip
    return Gate(tuple(rows), remedies_of({row.name: row for row in rows}, first))


def _tried(tried: Mapping[str, Callable[[], list[GateRow]]]) -> list[GateRow]:
    """Rows of what is tried, by name: what has no answer, or no way to one, is a row too."""
    rows = []
    for name, act in tried.items():
        try:
            rows += [replace(row, name=f"{name}{row.name}") for row in act()]
        except (CannotRepresent, SolverError) as error:
            rows.append(_untried(name, error))
    return rows


def _untried(name: str, error: CannotRepresent | SolverError) -> GateRow:
    word: Word = LEFT_OUT if isinstance(error, NotAskedError) else STOPPED
    word = "cannot" if isinstance(error, CannotRepresent) else word
    return GateRow(name, math.nan, "", math.nan, str(error), word)


def _judged(value: float, unit: str, limit: float, because: Phrase) -> list[GateRow]:
    return [GateRow("", value, unit, limit, because, PASSED if value <= limit else STOPPED)]


# Motions ------------------------------------------------------------------------------------------


def _at_rest(simulator: Simulator, block: Request) -> list[GateRow]:
    points = block.mesh.points
    try:
        answer = ask(simulator, motion(block, points, STEPS))
    except CannotRepresent:  # a static program, which may still tell forces
        answer = ask(simulator, motion(block, points))
    limit = ROUNDINGS * STEPS * epsilon(answer)
    because = phrase("limit of rest", roundings=ROUNDINGS, steps=STEPS)
    if answer.position is None:
        strain = _as_strain(block, forces(motion(block, points), answer))
        return _judged(strain, "strain", limit, because)
    off = max_abs(answer.position - points)
    times = best_scale(answer.position, points)
    return [*_judged(off, "of its size", limit, because), *size_rows("positions", times)]


def _free_fall(simulator: Simulator, block: Request) -> list[GateRow]:
    points = block.mesh.points
    plain = motion(block, points, STEPS)
    time = STEPS * float(plain.dt or 0.0)
    g = np.zeros(block.mesh.dim)
    g[-1] = -2 * FALL / time**2
    answer = ask(simulator, replace(plain, gravity=g))
    if answer.position is None or answer.velocity is None:
        raise CannotRepresent("it answers by forces, and moves nothing")
    wanted = g * time
    off = max_abs(answer.velocity - wanted) / max_abs(wanted)
    # Velocities may be differences of positions: these are rounded, and one step is a part of them.
    stated = solves_to(answer.about)
    limit = ROUNDINGS * STEPS * epsilon(answer) / FALL + stated
    fallen = float((answer.position - points)[:, -1].mean() / (g[-1] * float(plain.dt or 1) ** 2))
    kind = Phrase(_integrator(fallen, stated))
    because = phrase("limit of fall", roundings=ROUNDINGS, stated=stated)
    # Forces between nodes keep the momentum.
    mean = float(np.average(answer.velocity[:, -1], weights=block.mass) / wanted[-1])
    if abs(mean - 1) <= DIVERGED * off:
        because = Phrase("diverges")
    integrator = GateRow(": integrator", fallen, "g dt²", math.nan, kind, TOLD)
    return [*_judged(off, "of g t", limit, because), integrator, *size_rows("fall", mean)]


def _stretched_step(simulator: Simulator, block: Request) -> float:
    """Stiffness in one step of a uniform strain, relative to the requested modulus E."""
    stretched = motion(block, block.mesh.points * [1 + STRAIN, *[1] * (block.mesh.dim - 1)])
    return _as_strain(block, forces(stretched, ask(simulator, stretched))) / STRAIN


def _out_of_range(law: Isotropic, stiffness: float) -> float:
    """Factor by which a relative stiffness lies outside the range of E to the wave modulus M.

    Elements resist a uniform strain with M = λ + 2μ, and springs with about E whatever the ratio.
    """
    second, mu = lame(law.dim, *axes_moduli(law, law.dim, "gate"))
    most = (second + 2 * mu) / (law.E * law.thickness)
    return stiffness / min(max(stiffness, 1.0), most)


def _integrator(fallen: float, stated: float) -> str:
    """Kind of the integrator that falls so far, in g dt²."""
    known = {
        STEPS * (STEPS + 1) / 2: "semi-implicit",
        STEPS**2 / 2: "mean velocity",
        STEPS * (STEPS - 1) / 2: "old velocity",
    }
    near = min(known, key=lambda each: abs(each - fallen))
    return known[near] if abs(near - fallen) < 0.1 + stated * near else "no known integrator"


def _small_turn(
    simulator: Simulator, block: Request, stiffness: Callable[[], float]
) -> list[GateRow]:
    """Forces' odd part: what a turn forwards and one back put differently, without its square.

    Rounding of positions is a force in proportion to the program's own stiffness.
    """
    found, answers = [], []
    for sign in (1, -1):
        asked = motion(block, turned(block.mesh.points, sign * SMALL_TURN))
        answers.append(ask(simulator, asked))
        found.append(forces(asked, answers[-1]))
    strain = _as_strain(block, (found[0] - found[1]) / 2) / SMALL_TURN / max(1.0, stiffness())
    # Of a coordinate over a cell. Where velocities are differences of positions, rounding of these
    # over a step is up to 250 of them, at a ratio of 0.45.
    limit = ROUNDINGS * ACROSS * epsilon(answers[0]) / SMALL_TURN
    because = phrase("limit of turn", roundings=ROUNDINGS)
    return _judged(strain, "strain over angle", limit, because)


def _large_turn(simulator: Simulator, block: Request) -> list[GateRow]:
    asked = motion(block, turned(block.mesh.points, LARGE_TURN))
    strain = _as_strain(block, forces(asked, ask(simulator, asked)))
    because = phrase("large turn", linear=1 - math.cos(LARGE_TURN))
    return [GateRow("", strain, "strain", math.nan, because, TOLD)]


def _as_strain(block: Request, force: Array) -> float:
    """Largest nodal force as the strain that would put it on a face of a cell."""
    side = 1.0 / ACROSS
    face = side ** (block.mesh.dim - 1) * block.material.thickness
    return max_abs(force) / (block.material.E * face)


# Rest ---------------------------------------------------------------------------------------------


def _twice_the_modulus(simulator: Simulator, block: Request, first: Answer) -> list[GateRow]:
    stiff = replace(block, material=replace(block.material, E=2 * block.material.E))
    answer = ask(simulator, stiff)
    away = _change(first.displacement, 2 * np.asarray(answer.displacement))
    rest = _left(block, first) + 2 * _left(stiff, answer)
    limit = ORDERS * STRAIN + rest + ROUNDINGS * epsilon(first) / STRAIN
    because = phrase("limit of modulus", orders=ORDERS, roundings=ROUNDINGS)
    return _moving(_judged(away, "of u", limit, because), rest)


def _changed(
    simulator: Simulator, block: Request, first: Answer, name: str, times: float
) -> list[GateRow]:
    """The same with another setting, where the answer names it and takes another."""
    before = _named(first, name)
    if before is None:
        raise CannotRepresent(f"its settings name no {name}, so that it cannot be changed")
    wanted: float = before * times if name == "dt" else round(before * times)
    other = replace(block, settings={**block.settings, name: wanted})
    answer = ask(simulator, other)
    if _named(answer, name) == before:
        raise CannotRepresent(f"asked for {name} {wanted:g}, it took {before:g} again")
    away = _change(first.displacement, answer.displacement)
    stated = stated_residual_motion(block, first)
    rest = _left(block, first) + _left(other, answer)
    limit = rest + ROUNDINGS * epsilon(first) / STRAIN
    if math.isnan(stated):
        because = phrase("unstated rest", each=UNSTATED)
    else:
        because = phrase("stated rest", stated=stated, away=away, name=name, wanted=wanted)
    return _moving(_judged(away, "of u", limit, because), rest)


def _moving(rows: list[GateRow], rest: float) -> list[GateRow]:
    """The row, "not at rest" where what is stated of that alone lets it pass."""
    (row,) = rows
    if row.verdict != PASSED or row.value <= max(BAND, row.limit - rest):
        return rows
    return [replace(row, verdict=MOVING, because=Phrase("may change"))]


def _same_again(simulator: Simulator, block: Request, first: Answer) -> list[GateRow]:
    away = _change(first.displacement, ask(simulator, block).displacement)
    limit = ROUNDINGS * epsilon(first) / STRAIN
    return _judged(away, "of u", limit, phrase("limit of state", roundings=ROUNDINGS))


def _named(answer: Answer, name: str) -> float | None:
    """A number among the settings that an answer tells: those it takes."""
    given = (answer.about.get("settings", {}).get(name) or [None])[0]
    number = isinstance(given, int | float) and not isinstance(given, bool)
    return float(given) if number and given > 0 else None


def _change(before: Array | None, after: Array | None) -> float:
    """Largest difference of displacements over the largest before."""
    before, after = np.asarray(before), np.asarray(after)
    size = max_length(before)
    if not size:
        raise SimulatorError("answer: the pulled block does not move")
    return max_length(after - before) / size


def _left(request: Request, answer: Answer) -> float:
    stated = stated_residual_motion(request, answer)
    return UNSTATED if math.isnan(stated) else stated
