"""Tables and sentences of a judgement, for the terminal and a page."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable

from msvalidate.problem.records import dataclass
from msvalidate.simulators.bodies.bodies import BodyRow
from msvalidate.simulators.exchange.asked import Asked, Note
from msvalidate.simulators.gate.rows import LEFT_OUT, LENGTH, PASSED, STEP, GateRow
from msvalidate.simulators.lattice.bodies import LatticeReport
from msvalidate.simulators.probe.reading import BAND, Reading, anisotropy
from msvalidate.simulators.verdict.advice import mesh_errors, next_step
from msvalidate.simulators.verdict.causes import NOTHING, STOPPED
from msvalidate.simulators.verdict.judgement import PARTS, Judgement
from msvalidate.simulators.verdict.sentences import text_of
from msvalidate_check.causes import Phrase, phrase
from msvalidate_check.text import align_table, percent
from msvalidate_check.verdict import AGREES

FIRST = (LENGTH, STEP, "units")
"""Kinds of causes that the headline names."""
LAW_COLUMNS = ("", "E (Pa)", "nu", "E over asked", "nu less asked")
REFERENCES = {
    "elasticity": "elasticity",
    "solid": "its solid",
    "elements": "linear elements",
    "network": "its springs",
}
"""Key of a body's differences -> what it differs from."""
FAILED = "gate failed"
"""Kind of a cause that is a question's failure."""


@dataclass(frozen=True)
class SheetTable:
    """A table of texts, and what is said below it."""

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    below: tuple[str, ...] = ()

    def lines(self) -> list[str]:
        """As aligned text; the last column is as wide as it is."""
        lines = align_table(self.columns, self.rows)[not any(self.columns) :]
        return [self.title, *(f"  {each}" for each in (*lines, *self.below))]


@dataclass(frozen=True)
class Sheet:
    """All that is said of a simulator.

    Parameters
    ----------
    word
        Its state, or that some question was not answered at all.
    agrees
        Whether it agrees, and all was asked and is near elasticity.
    who
        Simulator, version and law, as it says itself, and how often it was asked.
    causes
        Sentences.
    tables
        Gate, law and bodies, as far as they were asked.
    notes
        What could not be asked, and why.
    next
        What to do now.
    """

    word: str
    agrees: bool
    who: str
    causes: tuple[str, ...]
    tables: tuple[SheetTable, ...]
    notes: tuple[str, ...]
    next: str

    def lines(self, name: str) -> list[str]:
        """As text."""
        lines = [f"{name}: {self.word}", *(f"  {each}" for each in (self.who, *self.causes))]
        for table in self.tables:
            lines += ["", *table.lines()]
        notes = [f"not asked: {each}" for each in self.notes]
        return [*lines, "", *notes, f"next: {self.next}"]


def sheet_of(found: Judgement, asked: Asked, parts: Collection[str] = PARTS) -> Sheet:
    """A judgement in words; `parts` are those that were asked for."""
    tables = [_gate_table(found)] if found.gate.rows else []
    if found.lattice is not None:
        tables += _lattice_tables(found.lattice)
    elif found.word != STOPPED and set(parts) - {"gate"}:
        tables.append(_law_table(found))
    if found.bodies:
        tables.append(_bodies_table(found))
    known = {failure.why for failure in asked.failures}
    causes = [c for c in found.causes if not (c.kind == FAILED and c.of["because"] in known)]
    failures = [phrase("note", what=each.what, why=each.why) for each in asked.failures]
    word, first = _word(found, asked, parts), next((each.kind for each in found.causes), "")
    agrees = word == phrase("state", state=AGREES, some=NOTHING)
    if agrees and found.lattice is not None:
        word = phrase("lattice agrees", **vars(found.lattice.mean))
    word = phrase(f"first {first}", state=word) if first in FIRST else word
    return Sheet(
        word=text_of(word),
        agrees=agrees,
        who=text_of(_who(asked)),
        causes=(*(each.said for each in causes), *map(text_of, dict.fromkeys(failures))),
        tables=tuple(tables),
        notes=_by_reason(found.notes),
        next=next_step(found, asked, parts).said,
    )


def _by_reason(notes: Iterable[Note]) -> tuple[str, ...]:
    """Notes, what has the same reason together."""
    found: dict[str, list[str]] = {}
    for each in notes:
        if each.asked:
            found.setdefault(each.why, []).append(each.what)
    pairs = (phrase("note", what=", ".join(what), why=why) for why, what in found.items())
    return tuple(map(text_of, pairs))


def _word(found: Judgement, asked: Asked, parts: Collection[str]) -> Phrase:
    some = NOTHING
    if any(part not in parts for part in PARTS):
        some = phrase("some", parts=" and ".join(part for part in PARTS if part in parts))
    if asked.failures:
        counts = {"failures": len(asked.failures), "count": asked.count}
        return phrase("no answer", **counts, some=some)
    if found.word == STOPPED:
        return phrase("stopped" if found.gate.stops else "nothing", some=some)
    if found.word == AGREES and set(parts) == {"gate"}:
        return phrase("gate alone")
    if errors := mesh_errors(found):
        return phrase("its mesh", **errors, some=some)
    return phrase("accepted" if found.is_accepted else "state", state=found.word, some=some)


def _who(asked: Asked) -> Phrase:
    said = [str(asked.about.get(key, "")) for key in ("simulator", "version")]
    own = ", ".join(each for each in (" ".join(said).strip(), asked.about.get("law", "")) if each)
    return phrase("who", who=own or phrase("silent"), count=asked.count)


# Gate ---------------------------------------------------------------------------------------------


def _gate_table(found: Judgement) -> SheetTable:
    rows, before = [], ""
    for row in found.gate.rows:
        verdict = "" if row.verdict == LEFT_OUT else row.verdict
        words = _gate_words(row)
        rows.append((verdict, row.name, "the same" if words == before else words))
        before = words
    return SheetTable("gate", ("", "", ""), tuple(rows))


def _gate_words(row: GateRow) -> str:
    if math.isnan(row.limit):
        value = "" if math.isnan(row.value) else f"{row.value:.2g} {row.unit}: "
        return f"{value}{text_of(row.because)}"
    told = f"{row.value:.1e} {row.unit}, at most {row.limit:.1e}"
    return told if row.verdict == PASSED else f"{told}: {text_of(row.because)}"


# Law ----------------------------------------------------------------------------------------------


def _law_table(found: Judgement) -> SheetTable:
    asked = (found.asked.E, found.asked.nu)
    rows: list[tuple[str, ...]] = [("asked", *_pair(*asked), "", "")]
    if found.predicted is not None:
        rows.append(("documented", *_pair(*found.predicted), *_away(found.predicted, asked)))
    reading, below = found.reading, []
    if reading is None:
        pulled = [row.on_mesh for row in found.bodies if row.body == "pulled"]
        if pulled:
            E, nu = pulled[-1].E, pulled[-1].nu
            rows.append(("of the pulled body", *_pair(E, nu), *_away((E, nu), asked)))
        below.append(text_of(phrase("no reading")))
    else:
        by_forces = any(row.body == "pulled" and row.driven == "loads" for row in found.bodies)
        rows.append(_read_row(reading, asked, found.mass, pulled=by_forces))
        below = _reading_lines(reading)
    return SheetTable(
        "law at small strain", LAW_COLUMNS, tuple(rows), tuple(below),
    )  # fmt: skip


def _pair(E: float, nu: float) -> tuple[str, str]:
    return f"{E:.6g}", f"{nu:.5g}"


def _away(one: tuple[float, float], asked: tuple[float, float]) -> tuple[str, str]:
    away = round(one[1] - asked[1], 5) + 0.0
    return f"{one[0] / asked[0]:.5g}", f"{away:+.5f}"


def _read_row(
    reading: Reading, asked: tuple[float, float], mass: float, *, pulled: bool
) -> tuple[str, ...]:
    """Moduli by steps, which show E over the mass; `pulled` if a body shows E by forces too."""
    e, label = reading.elastic, "read"
    if reading.E is None or reading.nu is None:
        return (label, "none", "none", "", "")
    E = mass * reading.E
    if mass != 1:
        label = f"read, masses {mass:.3g} times"
    elif reading.masses is not None and not pulled:
        label = "read, masses as asked"
    return (label, f"{E:.6g} ± {mass * e.E_error:.1g}", f"{reading.nu:.5g} ± {e.nu_error:.1g}",
            *_away((E, reading.nu), asked))  # fmt: skip


def _reading_lines(reading: Reading) -> list[str]:
    """Masses, and flags where they matter."""
    lines = [phrase("no masses") if reading.masses is None else reading.masses.line]
    for flag in reading.flags:
        if flag.refuses and not flag.holds:
            said = {"limit": flag.limit, "because": flag.because}
            lines.append(phrase("flag line", flag=flag.shown, **said))
    if not reading.is_known:
        lines.append(reading.uncertain)
    if reading.is_valid and (reading.E is None or reading.nu is None):
        lines.append(phrase("no moduli", because=reading.elastic.because))
    if reading.is_valid and (part := anisotropy(reading.C)) > BAND:
        lines.append(phrase("anisotropy", part=part))
    return list(map(text_of, lines))


# Lattices -----------------------------------------------------------------------------------------


def _lattice_tables(lattice: LatticeReport) -> list[SheetTable]:
    """Moduli of the lattice beside the requested ones, and its cantilevers."""
    mean, springs = lattice.mean, lattice.springs
    pairs = {"requested": lattice.requested, "nearest isotropic": (mean.E, mean.nu)}
    rows = [(name, *_pair(*pair), *_away(pair, lattice.requested)) for name, pair in pairs.items()]
    shares = {name: percent(getattr(lattice, name)) for name in ("misfit", "error")}
    below = [phrase("lattice of", **vars(mean), **shares)]
    if springs.misfit <= BAND:
        constants = ", ".join(f"{k:.5g}" for k in springs.constants if k)
        below.append(phrase("lattice springs", constants=constants, weight=springs.weight))
    if lattice.steps is not None:
        masses = lattice.steps.masses
        below.append(phrase("no masses") if masses is None else masses.line)
        below += [
            Phrase(f"lattice {name}") for name in ("relaxed", "bound") if vars(lattice.steps)[name]
        ]
    if math.isfinite(lattice.total):
        below.append(phrase("lattice total", total=lattice.total))
    tables = [
        SheetTable("law at small strain", LAW_COLUMNS, tuple(rows), tuple(map(text_of, below)))
    ]
    columns = ("load", *(f"from {name}" for name in REFERENCES.values()), "may still change")
    lines = [
        (
            b.load,
            *(percent(b.errors[n]) if n in b.errors else "" for n in REFERENCES),
            percent(b.rest),
        )
        for b in lattice.bodies
    ]
    if lines:
        tables.append(SheetTable("cantilever: differences", columns, tuple(lines)))
    return tables


# Bodies -------------------------------------------------------------------------------------------


def _bodies_table(found: Judgement) -> SheetTable:
    rows = tuple(_body_row(row) for row in found.bodies)
    below = []
    if found.large is not None:
        large = found.large
        said = {"case": large.case, "strain": large.strain, "apart": percent(large.apart)}
        below.append(text_of(phrase("large line", **said, linear=percent(large.from_linear))))
    columns = (
        "body", "case", "mesh", "error", "law", "resolution", "mass", "solver", "not explained",
    )  # fmt: skip
    return SheetTable(
        "bodies at rest: error, and factor of the displacement by each cause; _2: halved cells",
        columns, rows,
        tuple(below),
    )  # fmt: skip


def _body_row(row: BodyRow) -> tuple[str, ...]:
    head = (row.body, row.case, row.mesh, percent(row.error))
    f = row.factors
    if f is None:
        return (*head, "", "", "", "", "no law to hold it against")
    parts = [_factor(part) for part in (f.law, f.resolution, f.mass, f.solver)]
    if parts[-1] == "1" and row.rest > BAND:
        parts[-1] = f"± {row.rest:.0%}" if row.rest < 1 else "± all"
    return (*head, *parts, percent(f.apart))


def _factor(part: float) -> str:
    return "1" if round(part, 3) == 1 else f"{part:.4g}"
