"""Advice on the next step after a judgement of a simulator."""

from __future__ import annotations

from collections.abc import Collection
from functools import reduce

from msvalidate.simulators.exchange.asked import Asked
from msvalidate.simulators.gate.rows import AGAIN, FREE_FALL, LENGTH, STEP
from msvalidate.simulators.probe.reading import BAND, SHOWN
from msvalidate.simulators.verdict.causes import CAUSE, NOTHING, STOPPED
from msvalidate.simulators.verdict.judgement import PARTS, Judgement
from msvalidate.simulators.verdict.sentences import Cause
from msvalidate_check.causes import Phrase, phrase
from msvalidate_check.text import percent
from msvalidate_check.verdict import AGREES, NOT_AT_REST

CONVERGED_BY = {"iterations": (LENGTH, STEP), "steps": (LENGTH,), "dt": (STEP,)}
"""Setting -> causes that it is a remedy for."""
HELPED = ("rest stays at rest", FREE_FALL, "small turn", "twice the modulus", AGAIN)
"""Rows for which it is known what helps."""


def _advice(kind: str, **values: object) -> Cause:
    return Cause(kind, of=phrase(kind, **values))


def mesh_errors(result: Judgement) -> dict[str, str]:
    """Errors of the body for which the mesh matters most, or none."""
    coarse = max(result.bodies, key=lambda row: row.error, default=None)
    if result.word != AGREES or coarse is None or coarse.error <= BAND:
        return {}
    body = f"{coarse.body} {'beam' if coarse.body == 'bent' else 'block'}"
    rows = [row for row in result.bodies if row.case == coarse.case]
    errors = ", ".join(f"{percent(row.error)} on {row.mesh}" for row in rows)
    return {"body": body, "coarse": percent(coarse.error), "errors": errors}


def next_step(found: Judgement, asked: Asked, parts: Collection[str] = PARTS) -> Cause:
    """Choose the most useful next step by the judgement."""
    kinds = [each.kind for each in found.causes]
    if asked.ended or (asked.failures and "units" not in kinds):
        return _advice("ended" if asked.ended else "failed")
    first = found.causes[0] if found.causes else Cause("")
    if first.of.key.startswith("lattice "):
        return _advice(f"mend {first.of.key}", **dict(first.of.values))
    if found.word in {STOPPED, NOT_AT_REST} and not found.gate.shows_units:
        return _at_gate(found, asked) if found.word == STOPPED else _converge(found)
    if "units" in kinds:
        return _advice("give units")
    if found.word == AGREES or found.is_accepted:
        return _after_agreement(found, parts)
    return _of_cause(found) if found.word == CAUSE else _of_rest(found)


def _after_agreement(result: Judgement, parts: Collection[str]) -> Cause:
    """Recommend a finer mesh, the other parts, or a body of the user."""
    if errors := mesh_errors(result):
        return _advice("refine", **errors)
    rest = " --only ".join(part for part in PARTS if part not in parts)
    if rest:
        return _advice("ask the rest", rest=rest)
    cells = [body.request.mesh.shape for body in result.lattice.bodies] if result.lattice else []
    return _advice("own body", shape=f" --shape {cells[0]}" if cells else "")


def _at_gate(found: Judgement, asked: Asked) -> Cause:
    if not found.gate.stops:
        return _advice("answer a task")
    gate, own = found.gate, asked.about.get("settings", {})
    further = [
        phrase("set", name=name, value=value / 4 if name == "dt" else 8 * value)
        for name, causes in CONVERGED_BY.items()
        if isinstance(value := (own.get(name) or [None])[0], int | float)
        and set(causes) & set(gate.remedies)
    ]
    if gate.unconverged:
        either = reduce(lambda one, other: phrase("or", one=one, other=other), further or [NOTHING])
        settle = _advice("settle", row=gate.unconverged.name, settings=either)
        return settle if further else _converge(found)
    if gate.units:
        return _advice("give units")
    first = next((row for row in gate.stops if row.name == AGAIN), gate.stops[0])
    key = first.name if first.name in HELPED and first.unit else "mend row"
    if first.because == Phrase("diverges"):
        key = "give masses and k"
    elif first.name == FREE_FALL and round(first.value, 1) == 2:  # as fast, and the other way
        key = "falls up"
    return _advice(key, row=first.name)


def _converge(found: Judgement) -> Cause:
    return _advice(f"converge {' or '.join(found.gate.remedies)}")


def _of_cause(found: Judgement) -> Cause:
    masses = found.reading.masses if found.reading else None
    if masses is not None and any(each.kind == "mass" for each in found.causes):
        return _advice("give masses")
    return _advice("see source" if found.predicted is None else "say so")


def _of_rest(found: Judgement) -> Cause:
    reading = found.reading
    if reading is not None and not reading.is_valid:
        flag = next((f for f in reading.flags if f.refuses and not f.holds), None)
        if flag is None:
            return _advice("double")
        return _advice("see flag", name=flag.name, because=flag.because)
    if any(each.kind == "documents" for each in found.causes):
        return _advice("name another")
    if not found.bodies:
        return _advice("answer rest")
    if reading is None and found.predicted is None and not _is_asked(found):
        return _advice("answer motion")
    return _advice("whole body")


def _is_asked(found: Judgement) -> bool:
    """Return True if all pulled bodies have the requested modulus."""
    pulled = [row.on_mesh.E for row in found.bodies if row.body == "pulled"]
    return all(abs(E / found.asked.E - 1) <= SHOWN for E in pulled)
