"""What to do next with what was found of a simulator, in one line."""

from __future__ import annotations

from collections.abc import Collection

from msvalidate.simulators.exchange.asked import Asked
from msvalidate.simulators.probe.moduli import SHOWN
from msvalidate.simulators.verdict.causes import AGREES, CAUSE, NOT_AT_REST, STOPPED
from msvalidate.simulators.verdict.judgement import PARTS, Judgement

AT_GATE = {
    "rest stays at rest": "in a motion let nothing but the body's own forces act: no damping, "
    "contact, floor or support",
    "free fall": "take gravity from request.json at each question, switch damping off, and say in "
    "solves_to what the solve of a step leaves",
    "small turn": "hold no node in a motion, and ask for double precision where there is one",
    "twice the modulus": "hand on E of request.json at each question; where loads move too much "
    "for small strain, divide forces by the density too if E is, or see the units",
    "the same again": "start each question from nothing, and make sums in one order",
}
"""Row of the gate -> what helps."""
NEAR = 0.1
"""Of 2: how far off a fall is that goes the other way."""
SETTLES = ("twice the iterations", "twice the steps", "dt / 2")
"""Rows of the gate that only what is not at rest is stopped by: to be mended first."""


def next_step(found: Judgement, asked: Asked, parts: Collection[str] = PARTS) -> str:
    """What helps most, by what was found."""
    if asked.ended:
        return "give it longer by --limit, or mend what hangs; the rest was left out"
    if asked.failures:
        return "mend what it says; what it has no way to do, it ends with exit code 77 and a reason"
    if found.state == STOPPED:
        return _at_gate(found, asked)
    if found.state == NOT_AT_REST:
        return (
            "run it longer (more iterations or steps, a smaller dt or stop) until at_rest is < 1 %"
        )
    if found.state == AGREES:
        rest = " --only ".join(part for part in PARTS if part not in parts)
        more = f"`adapter check ADAPTER --only {rest}` asks the rest" if rest else ""
        return more or "`simulate CASE --with ADAPTER` judges a body of your own"
    return _of_cause(found) if found.state == CAUSE else _of_rest(found)


def _at_gate(found: Judgement, asked: Asked) -> str:
    stops = [row.name for row in found.gate.stops]
    if not stops:
        return "answer one of the two tasks, rest or motion, on a mesh of tetrahedra"
    own = asked.about.get("settings", {})
    further = {
        name: value / 4 if name == "dt" else 8 * value
        for name in ("iterations", "steps", "dt")
        if isinstance(value := (own.get(name) or [None])[0], int | float)
    }
    few = [name for name in SETTLES if name in stops]
    if few and further:
        each = " or ".join(f"--set {name}={value:.4g}" for name, value in further.items())
        return (
            f"{few[0]}: try {each}, until twice as many change nothing; and state in at_rest how "
            "far it is from that"
        )
    if stops[0] == "free fall" and abs(found.gate.stops[0].value - 2) < NEAR:
        return "free fall: it falls up: turn the sign of gravity"
    return f"{stops[0]}: {AT_GATE.get(stops[0], 'mend it first: no number counts before that')}"


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
    if any(each.startswith("law: read as") for each in found.causes):
        return "see how its source takes E and nu, or name another law of `adapter laws`"
    if not found.bodies:
        return "answer the task rest too; `--only gate --only probe` judges the law alone"
    if reading is None and found.predicted is None and not _is_asked(found):
        return (
            "answer motion of one step too, or name its law by --law, so that law is told from rest"
        )
    return "`simulate CASE --with ADAPTER` shows one body whole: where it differs, and how"


def _is_asked(found: Judgement) -> bool:
    """Whether all pulled bodies are of the modulus asked for."""
    pulled = [row.on_mesh.E for row in found.bodies if row.body == "pulled"]
    return all(abs(E / found.asked.E - 1) <= SHOWN for E in pulled)
