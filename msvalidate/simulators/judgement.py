"""A simulator judged: gate, probe, bodies at rest, and the causes of what differs.

Nothing is said of a simulator that the gate stops. Else its law is read by the probe, bodies of
the frozen set are brought to rest, and each is held against linear elements of the law that was
read, on the same mesh with the masses that were measured: what these explain has a cause, and what
they do not is told as not explained.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from msvalidate.problem import Array, Isotropic, ProblemError, SolverError
from msvalidate.simulators import blocks, laws
from msvalidate.simulators.blocks import AtRest, Effective, at_rest_both_ways, linear_elements
from msvalidate.simulators.factors import UNEXPLAINED, Factors, factors
from msvalidate.simulators.gate import Gate, gate
from msvalidate.simulators.large_strain import AtLargeStrain, at_large_strain
from msvalidate.simulators.masses import patterns
from msvalidate.simulators.moduli import SHOWN
from msvalidate.simulators.probe import probe
from msvalidate.simulators.probe_mesh import Block
from msvalidate.simulators.protocol import (
    Answer,
    CannotRepresent,
    Request,
    Simulator,
    SimulatorError,
)
from msvalidate.simulators.reading import Reading
from msvalidate.simulators.rest import stated_unrest
from msvalidate_check.diagnosis import Field, explain

AGREES = "agrees"
CAUSE = "differs with cause"
NOT_EXPLAINED = "not explained"
STOPPED = "gate"
STATES = (AGREES, CAUSE, NOT_EXPLAINED, STOPPED)
BAND = 0.01
"""Of masses and displacements: what is off by less agrees. Of a law's prediction too."""
MESHES = ("tet4", "tet4_2")
BODIES: Mapping[str, tuple[str, ...]] = {
    "pulled": (blocks.ROLLERS["pulled"], blocks.CLAMPED["pulled"], "block_gravity_space"),
    "sheared": (blocks.ROLLERS["sheared"], blocks.CLAMPED["sheared"]),
    "bent": (blocks.BENT["bent"],),
}
"""What a body is asked for -> cases of the set, the first that a program can represent counts."""
LOADED = ("pulled", "sheared")
"""Bodies that answer for law and masses; the bent one is judged under "resolution" alone."""


@dataclass(frozen=True, eq=False)
class BodyRow:
    """One body on one mesh.

    Parameters
    ----------
    body, case, mesh
        What was asked.
    error
        Largest difference from elasticity as asked, over the largest displacement.
    on_mesh
        The material that it is the linear elements of, on its own mesh.
    rest
        Part of the displacement that may still change, as stated; NaN if nobody says.
    factors
        Causes, multiplied; None where the law is not known.
    shape
        What else would explain what is left: points swapped, axes, signs; "" if nothing.
    """

    body: str
    case: str
    mesh: str
    error: float
    on_mesh: Effective
    rest: float
    factors: Factors | None
    shape: str = ""


@dataclass(frozen=True, eq=False)
class Judgement:
    """What is said of a simulator with one law and one material.

    Parameters
    ----------
    asked
        The material.
    predicted
        Modulus (Pa) and ratio that its documented law is to first order; None if not known.
    gate, reading
        What it passed, and what the probe read; None where it could not be probed.
    bodies
        At rest.
    large
        A body at 5 % strain beside elements of its documented law; None where that is not known.
    state
        One of `STATES`.
    causes
        In words, the largest first; none where it agrees.
    notes
        What could not be asked, and why.
    """

    asked: Isotropic
    predicted: tuple[float, float] | None
    gate: Gate
    reading: Reading | None
    bodies: tuple[BodyRow, ...]
    state: str
    causes: tuple[str, ...]
    notes: tuple[str, ...]
    large: AtLargeStrain | None = None


def judge_simulator(
    simulator: Simulator,
    material: Isotropic,
    settings: Mapping[str, Any] | None = None,
    *,
    law: str = "",
    predicted: tuple[float, float] | None = None,
    converged: Mapping[str, Any] | None = None,
    meshes: tuple[str, ...] = MESHES,
    probed: Mapping[str, Any] | None = None,
) -> Judgement:
    """Judge a simulator.

    Parameters
    ----------
    simulator
        Asked some two hundred times, each time anew.
    material
        Of state "solid", with a ratio of `blocks.RATIOS`.
    settings
        Of the simulator.
    law
        Its documented law, a name of `laws.LAWS`, which the bodies at large strain are of too; ""
        if it is none of them.
    predicted
        Modulus (Pa) and ratio of the documented law to first order; by default what `law` says.
    converged
        Settings at which steps and iterations change nothing any more, where the given ones do not
        go so far: what is between the two is the cause "solver".
    meshes
        Of the bodies, tetrahedra.
    probed
        Settings of the probe's steps beside the others.

    Raises
    ------
    ProblemError
        For another material, or a law that is not there.
    """
    low, high = blocks.RATIOS
    if material.state != "solid" or not low <= material.nu <= high:
        raise ProblemError(
            f"judge_simulator: {material}; give a solid with a ratio from {low:g} to {high:g}, "
            "for which elasticity is known"
        )
    own = dict(settings or {})
    predicted = predicted or _first_order(law, material)
    gated = gate(simulator, material, own)
    if not gated.passed:
        causes = tuple(f"{row.name}: {row.because}" for row in gated.stops) or ("nothing passed",)
        return Judgement(material, predicted, gated, None, (), STOPPED, causes, ())
    notes: list[str] = []
    reading = _probed(simulator, material, own | dict(probed or {}), notes)
    found = _bodies(simulator, material, own, meshes, notes)
    settled = _settled(simulator, own, converged, found)
    read, total = _law(reading, found, predicted)
    rows = tuple(_row(body, each, read, reading, total, settled) for body, each in found)
    large = _large(simulator, material, law, own, (reading, total), notes) if law else None
    state, causes = _state(material, predicted, reading, read, rows, large)
    return Judgement(material, predicted, gated, reading, rows, state, causes, tuple(notes), large)


def _first_order(law: str, material: Isotropic) -> tuple[float, float] | None:
    """Modulus (Pa) and ratio of a documented law; None where it is no solid."""
    if not law:
        return None
    known = laws.predicted(law, material.E, material.nu)
    return None if known.E is None or known.nu is None else (known.E, known.nu)


def _large(
    simulator: Simulator,
    material: Isotropic,
    law: str,
    settings: Mapping[str, Any],
    weighed: tuple[Reading | None, float],
    notes: list[str],
) -> AtLargeStrain | None:
    """A body at large strain beside elements of the documented law."""
    mu, lam = laws.lame(material.E, material.nu)
    try:
        return at_large_strain(
            simulator,
            material,
            lambda F: laws.LAWS[law].stress(F, mu, lam),
            settings,
            mass_of=lambda request: masses_on(request, *weighed),
        )
    except (CannotRepresent, SolverError) as error:
        notes.append(f"large strain: {error}")
        return None


def _probed(
    simulator: Simulator, material: Isotropic, settings: Mapping[str, Any], notes: list[str]
) -> Reading | None:
    try:
        return probe(simulator, material, settings=settings)
    except (CannotRepresent, SimulatorError) as error:
        notes.append(f"probe: {error}")
        return None


def _bodies(
    simulator: Simulator,
    material: Isotropic,
    settings: Mapping[str, Any],
    meshes: tuple[str, ...],
    notes: list[str],
) -> list[tuple[str, AtRest]]:
    """Each body at rest, by the first of its cases that the program can represent."""
    found: list[tuple[str, AtRest]] = []
    for body, cases in BODIES.items():
        for case in cases:
            try:
                each = [
                    (body, at_rest_both_ways(simulator, case, mesh, material, settings))
                    for mesh in meshes
                ]
            except (CannotRepresent, SolverError) as error:
                notes.append(f"{case}: {error}")
                continue
            found += each
            break
    return found


def _settled(
    simulator: Simulator,
    settings: Mapping[str, Any],
    converged: Mapping[str, Any] | None,
    found: list[tuple[str, AtRest]],
) -> Mapping[tuple[str, str], AtRest]:
    """The same bodies with settings that change nothing any more."""
    if not converged:
        return {}
    return {
        (each.case.name, each.case.mesh): at_rest_both_ways(
            simulator,
            each.case.name,
            each.case.mesh,
            each.request.material,
            {**settings, **converged},
        )
        for _, each in found
    }


def _law(
    reading: Reading | None,
    found: list[tuple[str, AtRest]],
    predicted: tuple[float, float] | None,
) -> tuple[tuple[float, float] | None, float]:
    """Modulus (Pa) and ratio of the law, and the body's mass over what is asked.

    The probe sees E over mass alone. A body pulled by forces sees E alone. So their quotient is the
    mass; it is taken for 1 where it is so within `BAND`.
    """
    if reading is None or reading.E is None or reading.nu is None:
        return predicted, 1.0
    pulled = [each for body, each in found if body == "pulled" and each.case.driven == "loads"]
    if not pulled or reading.masses is None:
        return (reading.E, reading.nu), 1.0
    near = blocks.effective_on_mesh(pulled[-1])
    total = near.E / reading.E
    if near.left > BAND or not total > 0 or abs(total - 1) <= BAND:
        return (reading.E, reading.nu), 1.0
    return (reading.E * total, reading.nu), total


def masses_on(request: Request, reading: Reading | None, total: float) -> Array | None:
    """(n,) kg on a request's mesh by the pattern that the probe measured; None if as asked."""
    if reading is None or reading.masses is None:
        return None if total == 1 else request.mass * total
    known = patterns(Block(request.mesh, request.material))
    pattern = known.get(reading.masses.pattern)
    if pattern is None:
        return None if total == 1 else request.mass * total
    return np.asarray(pattern * (total * request.mass.sum() / pattern.sum()))


def _row(
    body: str,
    found: AtRest,
    law: tuple[float, float] | None,
    reading: Reading | None,
    total: float,
    settled: Mapping[tuple[str, str], AtRest],
) -> BodyRow:
    case, request = found.case, found.request
    wanted = blocks.elasticity_at(case, 1.0, request.material.nu)
    error = _largest(found.move[case.named] - wanted) / _largest(wanted)
    rest = stated_unrest(request, Answer(displacement=found.move, about=found.about))
    on_mesh = blocks.effective_on_mesh(found)
    taken, shape = None, ""
    if law is not None:
        mass = masses_on(request, reading, total)
        taken = factors(found, law, mass, settled.get((case.name, case.mesh)))
        if not taken.is_explained:
            shape = _shape(found, linear_elements(request, *law, mass))
    return BodyRow(body, case.name, case.mesh, error, on_mesh, rest, taken, shape)


def _shape(found: AtRest, expected: Array) -> str:
    """What else would explain a field, held against the elements that it should be."""
    points = found.request.mesh.points
    span = tuple(zip(points.min(axis=0), points.max(axis=0), strict=True))
    field = Field(points, found.move, expected, UNEXPLAINED / 10, found.case.driven, span)
    causes = explain(field)
    return causes[0].said if causes else ""


def _state(
    material: Isotropic,
    predicted: tuple[float, float] | None,
    reading: Reading | None,
    law: tuple[float, float] | None,
    rows: tuple[BodyRow, ...],
    large: AtLargeStrain | None,
) -> tuple[str, tuple[str, ...]]:
    """State and causes, from what differs from what was asked."""
    causes = [*_law_causes(material, reading, law), *_factor_causes(rows)]
    loaded = [row for row in rows if row.body in LOADED] or list(rows)
    open_rows = [row for row in loaded if row.factors is None or not row.factors.is_explained]
    unread = reading is not None and not reading.is_valid
    off = predicted is not None and law is not None and not _alike(law, predicted)
    if off and predicted is not None and law is not None:
        causes.append(
            f"law: read as E {law[0]:.4g} Pa, nu {law[1]:.4g}; its documents say "
            f"{predicted[0]:.4g} Pa, {predicted[1]:.4g}"
        )
    other = large is not None and large.apart > BAND
    if other and large is not None:
        causes.append(
            f"law: at {large.strain:.2g} strain {large.apart:.2g} of the displacement from "
            "elements of its documented law"
        )
    if open_rows or unread or off or other or not rows:
        causes += [_open_words(row) for row in open_rows]
        return NOT_EXPLAINED, tuple(dict.fromkeys(causes))
    return (CAUSE if causes else AGREES), tuple(dict.fromkeys(causes))


def _open_words(row: BodyRow) -> str:
    """What is said of a body that the causes do not explain."""
    where = f"{row.case} on {row.mesh}"
    if row.factors is None:
        return f"{where}: no law to hold it against"
    shape = f": {row.shape}" if row.shape else ""
    return f"{where}: {row.factors.apart:.2g} of the displacement not explained{shape}"


def _law_causes(
    material: Isotropic, reading: Reading | None, law: tuple[float, float] | None
) -> list[str]:
    found = []
    if reading is not None and not reading.is_valid:
        found.append(f"law: {'; '.join(reading.refusals())}")
    if reading is not None and reading.is_bound:
        found.append("law: uniform strain pulls at inner nodes, so it is of no one solid")
    if law is not None and not _alike(law, (material.E, material.nu), SHOWN):
        found.append(
            f"law: E {law[0] / material.E:.4g} times the asked, nu {law[1]:.4g} for {material.nu:g}"
        )
    if reading is not None and reading.masses is not None and reading.masses.off > BAND:
        found.append(f"mass: {reading.masses.pattern}")
    return found


def _factor_causes(rows: tuple[BodyRow, ...]) -> list[str]:
    """Mass and solver, where they do more than the band in a body that forces or weight load."""
    found = []
    for name in ("mass", "solver"):
        each = [getattr(row.factors, name) for row in rows if row.factors is not None]
        worst = max(each, key=lambda one: abs(one - 1), default=1.0)
        if abs(worst - 1) > BAND:
            found.append(f"{name}: {worst:.4g} times the displacement")
    return found


def _alike(one: tuple[float, float], other: tuple[float, float], band: float = BAND) -> bool:
    return abs(one[0] / other[0] - 1) <= band and abs(one[1] - other[1]) <= band


def _largest(vectors: Array) -> float:
    return float(np.linalg.norm(vectors, axis=1).max()) or math.nan
