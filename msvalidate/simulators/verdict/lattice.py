"""Judge a lattice: gate, steps, cantilever, effective solid, and the mistake in it."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from functools import partial
from typing import Any

import numpy as np

from msvalidate.linear_algebra.norms import max_abs
from msvalidate.problem import Array, Isotropic, ProblemError
from msvalidate.problem.checks import format_value
from msvalidate.problem.records import replace
from msvalidate.simulators.exchange.asked import Note
from msvalidate.simulators.exchange.protocol import (
    DIMENSION,
    Answer,
    CannotRepresent,
    Request,
    Simulator,
    SimulatorError,
    ask,
)
from msvalidate.simulators.gate.gate import STEPS, gate, motion, stretched_block
from msvalidate.simulators.gate.rows import (
    CONVERGENCE,
    FREE_FALL,
    HALF_STEP,
    ITERATIONS,
    LENGTH,
    MORE_STEPS,
    PASSED,
    SCALE,
    STEP,
    UNSTATED,
    Gate,
)
from msvalidate.simulators.lattice.bodies import (
    WEIGHT,
    LatticeBody,
    LatticeReport,
    bring_to_rest,
    make_report,
)
from msvalidate.simulators.lattice.measure import MeasuredLattice, is_mechanism, measure_lattice
from msvalidate.simulators.lattice.regular import SPACING
from msvalidate.simulators.probe.reading import BAND, SHOWN
from msvalidate.simulators.verdict.causes import (
    CAUSE,
    NOT_EXPLAINED,
    convergence_causes,
    stop_verdict,
)
from msvalidate.simulators.verdict.judgement import PARTS, Judgement, try_or_note
from msvalidate.simulators.verdict.sentences import Cause
from msvalidate_check.causes import phrase
from msvalidate_check.verdict import AGREES, NOT_AT_REST

PRESTRAIN = 1e-4
"""Smallest relative excess of rest lengths that is a mistake."""
LOST = 1e-6
"""Smallest part of a velocity that damping takes in ten steps: more than rounding."""
CREEPS = 0.2
"""Relative difference of half the damping from twice the steps in a creeping body."""


def declared_cells(simulator: Simulator) -> tuple[str, int]:
    """Return the first of the cells that an adapter declares, and the number of axes.

    An adapter that does not answer the question has tetrahedra.

    Raises
    ------
    ProblemError
        If the cells are unknown, or points have no dimension.
    """
    block = replace(stretched_block(Isotropic(1e7, 0.3, "solid"), {}), task="declare")
    try:
        about = simulator(block).about
    except (CannotRepresent, SimulatorError):
        about = {}
    (cells, *_) = about.get("cells") or ["tetra"]
    dim = DIMENSION.get(cells, about.get("dimension") if cells == "points" else None)
    if dim not in {2, 3}:
        raise ProblemError(
            f"declared cells {format_value(cells)}: give some of {', '.join(DIMENSION)}, or points "
            "and a dimension, 2 or 3"
        )
    return cells, int(dim)


def judge_lattice(
    simulator: Simulator,
    cells: str,
    material: Isotropic,
    settings: Mapping[str, Any] | None = None,
    *,
    parts: Collection[str] = PARTS,
    spacing: float = SPACING,
) -> Judgement:
    """Judge a simulator on regular blocks of its own cells.

    Parameters
    ----------
    simulator
        Asked some hundred times.
    cells
        Declared: "quad", "triangle", "hexahedron", "tetra" or "points".
    material
        Of a plane state or a solid, as the cells are.
    settings
        Of the simulator.
    parts
        Those of `PARTS` that it is asked.
    spacing
        Spacing (m) of the blocks.
    """
    own, dim, notes = dict(settings or {}), material.dim, list[Note]()
    shape = {2: "quad", 3: "hexahedron"}[dim] if cells == "points" else cells

    def send(request: Request) -> Answer:
        return simulator(replace(request, points_only=cells == "points"))

    gated = gate(send, material, own, shape) if "gate" in parts else Gate(())
    size = {row.name: row.value for row in gated.rows}
    passed = {name for name in CONVERGENCE if size.get(name, 1.0) <= UNSTATED}
    by_step = {name for name in (HALF_STEP, ITERATIONS) if size.get(name, 0.0) > UNSTATED}
    block = stretched_block(material, own, shape)
    if by_step == {HALF_STEP} and not _depends_on_step(send, block):
        passed, by_step = {*passed, HALF_STEP}, set()
    rows = (replace(row, verdict=PASSED) if row.name in passed else row for row in gated.rows)
    gated = replace(gated, rows=tuple(rows))
    if by_step and MORE_STEPS in passed:
        gated, parts = replace(gated, remedies=(STEP,)), ()  # nothing is read of such steps
    steps, bodies = None, list[LatticeBody]()
    if "probe" in parts:
        act = partial(measure_lattice, send, shape, material, own, notes, spacing)
        steps = try_or_note("steps", notes, act)
    if "bodies" in parts:
        precision = steps.precision if steps else "float64"
        place = partial(bring_to_rest, send, shape, material, own, precision, spacing)
        bodies = try_or_note("cantilever", notes, place) or []
    make = partial(make_report, shape, material, spacing, steps, bodies)
    report = try_or_note("lattice", notes, make)
    causes = _causes(send, block, material, gated, report, steps, bodies)
    causes = list({each.kind: each for each in reversed(causes)}.values())[::-1]
    word, stopped = CAUSE if causes else AGREES, list[Any]()
    if gated.rows and not gated.passed:
        known = {each.kind for each in causes}
        word, stopped = "gate", [c for c in stop_verdict(gated).causes if c.kind not in known]
    elif any(each.kind in {LENGTH, STEP} for each in causes):
        word = NOT_AT_REST
    elif any(each.kind == "body" for each in causes) or (report is None and set(parts) - {"gate"}):
        word = NOT_EXPLAINED
    return Judgement(
        word,
        (*causes, *stopped),
        asked=material,
        predicted=None,
        gate=gated,
        notes=tuple(notes),
        lattice=report,
    )


def with_lattice(
    judgement: Judgement, simulator: Simulator, settings: Mapping[str, Any]
) -> Judgement:
    """Add the solid of a regular block to the judgement of springs on tetrahedra."""
    if judgement.reading is None or not judgement.reading.is_bound:
        return judgement
    other = judge_lattice(simulator, "tetra", judgement.asked, settings, parts=("probe",))
    notes = (*judgement.notes, *other.notes)
    causes = (*judgement.causes, *other.causes)
    return replace(judgement, lattice=other.lattice, causes=causes, notes=notes)


# Causes, the first of which is to be mended first ------------------------------------------------


def _cause(kind: str, value: float = math.nan, **values: object) -> Cause:
    return Cause(kind, value, phrase(f"lattice {kind}", value=value, **values))


def _causes(
    simulator: Simulator,
    block: Request,
    law: Isotropic,
    gated: Gate,
    report: LatticeReport | None,
    steps: MeasuredLattice | None,
    bodies: list[LatticeBody],
) -> list[Cause]:
    """Causes in the order in which they hide each other."""
    found: list[Cause] = []
    if steps is not None and steps.over_density:
        found.append(_cause("over density"))
    times = report.mean.E / report.requested[0] if report else 1.0
    if not found and not 1 / SCALE < times < SCALE:
        found.append(_cause("units", times))
    longest = max((body.prestrain for body in bodies), default=0.0, key=abs)
    prestrain = steps.prestrain if steps else longest
    if abs(prestrain) > (PRESTRAIN if steps else 10 * PRESTRAIN):
        found.append(_cause("rest length", prestrain))
    if steps is not None and is_mechanism(steps.C):
        found.append(_cause("mechanism"))
    still = _of_convergence(simulator, block, gated, bodies)
    found += [*_falling(simulator, block, gated), *still]
    if report is None:
        return found
    if found and found[0].kind == "rest length":  # the stiffness changes by as much
        return found
    masses = steps.masses if steps else None
    if abs(report.total - 1) > BAND:
        found.append(_cause("total mass", report.total))
    if masses is not None and masses.off > max(BAND, masses.error):
        found.append(_cause("masses", masses.off, pattern=masses.words))
    found += _of_springs(report, law, times)
    return found if still else [*found, *_of_bodies(report)]


def _of_convergence(
    simulator: Simulator, block: Request, gated: Gate, bodies: list[LatticeBody]
) -> list[Cause]:
    """Causes of displacements that are not converged, too much damping first."""
    change = max([gated.moving, *(body.rest for body in bodies if body.rest > BAND)])
    still = convergence_causes(gated, change)
    if still and still[0].kind == LENGTH and _creeps(simulator, block):
        return [_cause("damping"), *still]
    return still


def _of_springs(report: LatticeReport, law: Isotropic, times: float) -> list[Cause]:
    """Causes in the constants and the boundary weight, or in the moduli."""
    found, mean, springs, right = [], report.mean, report.springs, report.right
    alone = all(body.residual <= BAND or body.rest > BAND for body in report.bodies)
    central = alone and max(springs.misfit, right.misfit) <= BAND
    (k1, k2), (right1, right2) = springs.constants[:2], right.constants[:2]
    ratio = report.requested[1]
    if report.misfit > BAND:
        found.append(
            _cause(
                "ratio of constants" if central else "anisotropic",
                report.misfit,
                zener=mean.zener,
                k1=k1,
                k2=k2,
                right1=right1,
                right2=right2,
                ratio=k2 / k1,
                right=right2 / right1,
            )
        )
    elif abs(times - 1) > SHOWN and 1 / SCALE < times < SCALE:
        thin = abs(times * law.thickness - 1) <= SHOWN
        found.append(_cause("thickness" if thin else "modulus", times))
    if report.misfit <= BAND and abs(mean.nu - ratio) > SHOWN:
        found.append(_cause("nu", mean.nu, requested=ratio))
    if alone and abs(springs.weight - 0.5) > BAND and springs.misfit <= BAND:
        found.append(_cause("boundary weight", springs.weight))
    return found


def _of_bodies(report: LatticeReport) -> list[Cause]:
    """Causes that cantilevers show, compared with their solid."""
    found = []
    for body in report.bodies:
        on_mesh = body.mesh_error > BAND and body.errors["solid"] <= 2 * body.mesh_error
        if body.factor < 0:
            found.append(_cause("gravity sign" if body.load == WEIGHT else "load sign"))
        elif body.residual <= BAND:
            if abs(body.factor - 1) > BAND:
                found.append(_cause(body.load, body.factor))
        elif not on_mesh:
            of = phrase("lattice left", body=body.load)
            if body.causes:
                of = phrase("lattice body", body=body.load, cause=body.causes[0].said)
            found.append(Cause("body", body.residual, of))
    return found


def _falling(simulator: Simulator, block: Request, gated: Gate) -> list[Cause]:
    """Causes in the velocity of a free fall after one step and after ten, relative to g t."""
    if not any(row.name == FREE_FALL and row.unit for row in gated.stops):
        return []
    g = np.zeros(block.mesh.dim)
    g[-1] = -1.0
    whole = replace(motion(block, block.mesh.points, STEPS), gravity=g)

    def part(count: int) -> float:
        velocity = np.asarray(ask(simulator, replace(whole, steps=count)).velocity)[:, -1].mean()
        return -float(velocity) / (count * float(whole.dt or 1.0))

    one, ten = part(1), part(STEPS)
    if one < 0:
        return [_cause("gravity sign")]
    if ten < one * (1 - LOST):
        return [_cause("damping in motion", 1 - ten)]
    return [_cause("gravity", one)] if abs(one - 1) > BAND else []


def _moves(simulator: Simulator, block: Request, *changes: Mapping[str, float]) -> list[Array]:
    """Displacements (n, d) in m as it is, and with settings multiplied.

    The list is empty if an answer does not name such a setting, or there is none.
    """
    moves: list[Array] = []
    stated: Mapping[str, Any] = {}
    try:
        for times in ({}, *changes):
            own = {name: type(stated[name][0])(x * stated[name][0]) for name, x in times.items()}
            answer = ask(simulator, replace(block, settings={**block.settings, **own}))
            moves.append(np.asarray(answer.displacement))
            stated = stated or answer.about.get("settings", {})
    except (KeyError, CannotRepresent, SimulatorError):
        return []
    return moves


def _depends_on_step(simulator: Simulator, block: Request) -> bool:
    """Return true if a run of the same length in half the time step ends elsewhere."""
    moves = _moves(simulator, block, {"dt": 0.5, "steps": 2})
    return not moves or max_abs(moves[1] - moves[0]) > UNSTATED * max_abs(moves[0])


def _creeps(simulator: Simulator, block: Request) -> bool:
    """Return true if half the damping moves a body as far as twice the steps do."""
    moves = _moves(simulator, block, {"steps": 2}, {"damping": 0.5})
    if not moves:
        return False
    before, longer, looser = (float(abs(u).sum()) for u in moves)
    return longer > before * (1 + UNSTATED) and abs(looser - longer) <= CREEPS * (longer - before)
