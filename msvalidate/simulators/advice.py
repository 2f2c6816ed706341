"""What to do next with what was found of a simulator, in one line."""

from __future__ import annotations

from msvalidate.simulators.asked import Asked
from msvalidate.simulators.causes import AGREES, CAUSE, STOPPED
from msvalidate.simulators.judgement import Judgement
from msvalidate.simulators.moduli import SHOWN

AT_GATE = {
    "rest stays at rest": "in a motion let nothing but the body's own forces act: no damping, "
    "contact, floor or support",
    "free fall": "take gravity from request.json at each question, and switch damping off",
    "small turn": "hold no node in a motion, and ask for double precision where there is one",
    "twice the modulus": "hand on E of request.json at each question; where loads move too much "
    "for small strain, see the units",
    "dt / 2": "go on until nothing moves, and state in at_rest how far it is from that",
    "twice the iterations": "go on until nothing moves, and state in at_rest how far it is from "
    "that",
    "twice the steps": "go on until nothing moves, and state in at_rest how far it is from that",
    "the same again": "start each question from nothing, and make sums in one order",
}
"""Row of the gate -> what helps."""


def next_step(found: Judgement, asked: Asked) -> str:
    """What helps most, by what was found."""
    if asked.ended:
        return "give it longer by --limit, or mend what hangs; the rest was left out"
    if asked.failures:
        return "mend what it says; what it has no way to do, it ends with exit code 77 and a reason"
    if found.state == STOPPED:
        return _at_gate(found)
    if found.state == AGREES:
        return "`simulate CASE --with ADAPTER` judges a body of your own"
    return _of_cause(found) if found.state == CAUSE else _of_rest(found)


def _at_gate(found: Judgement) -> str:
    if not found.gate.stops:
        return "answer one of the two tasks, rest or motion, on a mesh of tetrahedra"
    name = found.gate.stops[0].name
    return AT_GATE.get(name, "mend what stopped it: no number counts before that")


def _of_cause(found: Judgement) -> str:
    masses = found.reading.masses if found.reading else None
    if any(each.startswith("mass") for each in found.causes) and masses is not None:
        return "give it the masses of nodal.csv, or say in its documents whose masses it takes"
    if found.predicted is None:
        return (
            "see how its source takes E and nu; a documented law is named by --law (`adapter laws`)"
        )
    return (
        "it is the law that its documents have, and not the E and nu that it is asked for: say so"
    )


def _of_rest(found: Judgement) -> str:
    reading = found.reading
    if reading is not None and not reading.is_valid:
        flag = next((f for f in reading.flags if f.refuses and not f.holds), None)
        return (
            f"see {flag.name}: {flag.because}" if flag else "take double precision, if it has any"
        )
    if not found.bodies:
        return "answer the task rest too; `--only gate --only probe` judges the law alone"
    if any(each.startswith("law: read as") for each in found.causes):
        return "see how its source takes E and nu, or name another law of `adapter laws`"
    if reading is None and found.predicted is None and not _is_asked(found):
        return (
            "answer motion of one step too, or name its law by --law, so that law is told from rest"
        )
    return "`simulate CASE --with ADAPTER` shows one body whole: where it differs, and how"


def _is_asked(found: Judgement) -> bool:
    """Whether all pulled bodies are of the modulus asked for."""
    pulled = [row.on_mesh.E for row in found.bodies if row.body == "pulled"]
    return all(abs(E / found.asked.E - 1) <= SHOWN for E in pulled)
