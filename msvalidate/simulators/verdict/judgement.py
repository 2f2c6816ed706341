"""A simulator judged: gate, probe, bodies at rest, and the causes of what differs.

Nothing is said of a simulator that the gate stops. Else its law is read by the probe, bodies of
the frozen set are brought to rest, and each is held against linear elements of the law that was
read, on the same mesh with the masses that were measured: what these explain has a cause, and what
they do not is told as not explained.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping
from typing import Any, TypeVar

from msvalidate.problem import Isotropic, ProblemError, SolverError
from msvalidate.problem.records import dataclass
from msvalidate.simulators.bodies import blocks, laws
from msvalidate.simulators.bodies.blocks import AtRest, Elements
from msvalidate.simulators.bodies.bodies import (
    MESHES,
    BodyRow,
    body_row,
    bring_further,
    bring_to_rest,
    load_more,
    masses_of,
    masses_on,
    of_one_kind,
)
from msvalidate.simulators.bodies.large_strain import AtLargeStrain, at_large_strain
from msvalidate.simulators.bodies.tetrahedra import linear_elements
from msvalidate.simulators.exchange.asked import Note, note_of
from msvalidate.simulators.exchange.protocol import CannotRepresent, Simulator
from msvalidate.simulators.gate.gate import gate
from msvalidate.simulators.gate.rows import Gate
from msvalidate.simulators.lattice.bodies import LatticeReport
from msvalidate.simulators.probe.probe import probe
from msvalidate.simulators.probe.reading import BAND, Reading
from msvalidate.simulators.verdict.causes import (
    CAUSE,
    is_over_density,
    rows_verdict,
    stop_verdict,
)
from msvalidate_check.beside import best_scale
from msvalidate_check.verdict import Verdict

Found = TypeVar("Found")
PARTS = ("gate", "probe", "bodies")
"""Groups of requests to a simulator, in this order."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Judgement(Verdict):
    """Judgement of a simulator with one law and one material.

    Its word is one of `verdict.causes`.

    Parameters
    ----------
    asked
        The material.
    predicted
        Modulus (Pa) and ratio that its documented law is to first order; None if not known.
    gate, reading
        What it passed, without rows where it was not asked; what the probe read, None where it was
        not or could not be probed.
    bodies
        At rest.
    large
        A body at 5 % strain beside elements of its documented law; None where that is not known.
    notes
        What could not be asked, and why.
    mass
        Mass of the bodies relative to the requested one, as forces and steps show it together.
    lattice
        Solid, springs and bodies of a simulator that was asked on cells of its own.
    """

    asked: Isotropic
    predicted: tuple[float, float] | None
    gate: Gate
    reading: Reading | None = None
    bodies: tuple[BodyRow, ...] = ()
    large: AtLargeStrain | None = None
    notes: tuple[Note, ...] = ()
    mass: float = 1.0
    lattice: LatticeReport | None = None

    @property
    def is_accepted(self) -> bool:
        """True if all that differs from the requested solid is the documented law."""
        causes = {each.kind for each in self.causes}
        return self.word == CAUSE and self.predicted is not None and causes == {"law"}


def judge_simulator(
    simulator: Simulator,
    material: Isotropic,
    settings: Mapping[str, Any] | None = None,
    *,
    law: str = "",
    converged: Mapping[str, Any] | None = None,
    meshes: tuple[str, ...] = MESHES,
    probed: Mapping[str, Any] | None = None,
    parts: Collection[str] = PARTS,
    elements: Elements = linear_elements,
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
    converged
        Settings at which steps and iterations change nothing any more, where the given ones do not
        go so far: what is between the two is the cause "solver".
    meshes
        Of the bodies, tetrahedra.
    probed
        Settings of the probe's steps beside the others.
    parts
        Those of `PARTS` that it is asked; what is said is of them alone.
    elements
        What its bodies should be on their meshes; only linear ones are asked at large strain.

    Raises
    ------
    ProblemError
        For another material, or a law that is not there.
    """
    _refuse_material(material)
    own = dict(settings or {})
    predicted = _first_order(law, material)
    gated = gate(simulator, material, own) if "gate" in parts else Gate(())
    if "gate" in parts and not gated.passed:
        stopped = vars(stop_verdict(gated))
        return Judgement(**stopped, asked=material, predicted=predicted, gate=gated)
    notes: list[Note] = []
    reading = None
    if "probe" in parts:
        stepped = own | dict(probed or {})
        reading = try_or_note("probe", notes, lambda: probe(simulator, material, settings=stepped))
    bodies = "bodies" in parts
    found = bring_to_rest(simulator, material, own, meshes, notes, elements) if bodies else []
    read, total = _law(reading, found, predicted, material)
    rows = _body_rows(simulator, found, (read, reading, total), own, converged, notes)
    large, furthest = None, own | dict(converged or {})
    linear = elements is linear_elements
    if law and bodies and linear and all(map(_is_of_linear_elements, rows)):
        large = try_or_note("large strain", notes, lambda: at_large_strain(
            simulator, material, laws.stress_of(law, material.E, material.nu), furthest,
            lambda asked: masses_on(asked, reading, total),
        ))  # fmt: skip
    verdict = rows_verdict(
        material, predicted, reading, read, rows if bodies else None, large,
        linear=linear, gate=gated,
    )  # fmt: skip
    return Judgement(
        **vars(verdict), asked=material, predicted=predicted, gate=gated, reading=reading,
        bodies=rows, large=large, notes=tuple(notes), mass=total,
    )  # fmt: skip


def _body_rows(
    simulator: Simulator,
    found: list[tuple[str, AtRest]],
    known: tuple[tuple[float, float] | None, Reading | None, float],
    own: Mapping[str, Any],
    converged: Mapping[str, Any] | None,
    notes: list[Note],
) -> tuple[BodyRow, ...]:
    """A row a body, brought further to rest; of single precision under more load too."""
    law, reading, total = known
    settled = try_or_note(
        "brought further to rest", notes, lambda: bring_further(simulator, own, converged, found)
    )
    rows = of_one_kind(
        tuple(body_row(body, each, law, reading, total, settled or {}) for body, each in found)
    )
    if law is None:
        return rows
    settings, each = {**own, **(converged or {})}, []
    for row, (_, body) in zip(rows, found, strict=True):
        expected = body.of_elements(*law, masses_of(body, law, reading, total))
        each.append(load_more(simulator, row, body, expected, settings))
    return tuple(each)


def _is_of_linear_elements(row: BodyRow) -> bool:
    """Return True if a body consists of linear elements of its law.

    Elements at large strain may then apply as well.
    """
    return row.is_rounded or (row.is_explained and not row.finer)


def _refuse_material(material: Isotropic) -> None:
    low, high = blocks.RATIOS
    if material.state != "solid":
        raise ProblemError(f"judge_simulator: state {material.state}; give a solid")
    if not low <= material.nu <= high:
        raise ProblemError(
            f"judge_simulator: ratio {material.nu:g}; give one from {low:g} to {high:g}, for which "
            "elasticity is known"
        )


def try_or_note(what: str, notes: list[Note], act: Callable[[], Found]) -> Found | None:
    """Return the result of an action, or None and a note if it fails."""
    try:
        return act()
    except (CannotRepresent, SolverError) as error:
        notes.append(note_of(what, error))
        return None


def _first_order(law: str, material: Isotropic) -> tuple[float, float] | None:
    """Modulus (Pa) and ratio of a documented law; None where it is no solid."""
    if not law:
        return None
    known = laws.predicted(law, material.E, material.nu)
    return None if known.E is None or known.nu is None else (known.E, known.nu)


def _law(
    reading: Reading | None,
    found: list[tuple[str, AtRest]],
    predicted: tuple[float, float] | None,
    material: Isotropic,
) -> tuple[tuple[float, float] | None, float]:
    """Modulus (Pa) and ratio of the law, and the body's mass over what is asked.

    The probe sees E over mass alone. A body pulled by forces sees E alone. So their quotient is the
    mass; it is taken for 1 where it is so within `BAND`, or where the probe alone reads the law
    that was meant, unless bodies show E and masses that are both over the density. Where nothing
    was probed the law is the documented one, or else what the finest pulled body is the elements
    of: the other bodies are then held against it.
    """
    asked = (material.E, material.nu)
    pulled = [each for body, each in found if body == "pulled" and each.case.driven == "loads"]
    if reading is None:
        return predicted or _law_of(pulled) or asked, 1.0
    if reading.E is None or reading.nu is None:
        return predicted, 1.0
    if not pulled or reading.masses is None:
        return (reading.E, reading.nu), 1.0
    near, band = blocks.effective_on_mesh(pulled[-1]), max(BAND, reading.shown)
    total = near.E / reading.E
    if near.left > BAND or not total > 0 or abs(total - 1) <= band:
        return (reading.E, reading.nu), 1.0
    # Where steps are of the law that was meant and the pulled body is not, this is no mass.
    meant = abs(reading.E / (predicted or asked)[0] - 1) <= band
    if meant and not (is_over_density(total, material.density) and _weighs(found, reading)):
        return (reading.E, reading.nu), 1.0
    return (reading.E * total, reading.nu), total


def _weighs(found: list[tuple[str, AtRest]], reading: Reading) -> bool:
    """Return True if a body under its weight has the measured law."""
    for _, each in found:
        if each.case.driven == "weight":
            expected = each.of_elements(float(reading.E or 0), float(reading.nu or 0))
            return abs(best_scale(each.move, expected) - 1) <= BAND
    return False


def _law_of(pulled: list[AtRest]) -> tuple[float, float] | None:
    """Modulus (Pa) and ratio of the elements that the last body is; None if it is none's."""
    if not pulled:
        return None
    near = blocks.effective_on_mesh(pulled[-1])
    known = near.left <= BAND and math.isfinite(near.E) and math.isfinite(near.nu)
    return (near.E, near.nu) if known else None
