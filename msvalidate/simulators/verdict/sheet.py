"""What was found of a simulator as tables and sentences, for the terminal and for a page."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable

from msvalidate.problem.records import dataclass
from msvalidate.simulators.bodies.blocks import BENT
from msvalidate.simulators.bodies.bodies import BAND, BodyRow
from msvalidate.simulators.exchange.asked import UNASKED, Asked
from msvalidate.simulators.gate.gate import PASSED, GateRow
from msvalidate.simulators.probe.moduli import anisotropy
from msvalidate.simulators.probe.reading import Flag, Reading
from msvalidate.simulators.verdict.advice import next_step
from msvalidate.simulators.verdict.causes import AGREES, STOPPED
from msvalidate.simulators.verdict.judgement import PARTS, Judgement

NO_ANSWER = "no answer"
ISOTROPIC = 0.01
"""Anisotropy beyond which that is told: at it E and nu differ by direction by about as much as a
law is asked to be told apart."""
NOTICED = 5e-4
"""Of a factor: what is nearer to 1 is left blank."""


@dataclass(frozen=True)
class SheetTable:
    """A table of texts, and what is said below it."""

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    below: tuple[str, ...] = ()

    def lines(self) -> list[str]:
        """As aligned text; the last column is as wide as it is."""
        every = [self.columns, *self.rows]
        widths = [max(len(row[k]) for row in every) for k in range(len(self.columns))]
        text = [
            "  " + "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True))
            for row in every
        ]
        if not any(self.columns):
            text = text[1:]
        return [self.title, *(line.rstrip() for line in text), *(f"  {b}" for b in self.below)]


@dataclass(frozen=True)
class Sheet:
    """All that is said of a simulator.

    Parameters
    ----------
    word
        Its state, or `NO_ANSWER` where some question was not answered at all.
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
    if found.state != STOPPED and set(parts) - {"gate"}:
        tables.append(_law_table(found))
    if found.bodies:
        tables.append(_bodies_table(found))
    plain = [each for each in found.causes if not any(_why(each) in f for f in asked.failures)]
    seen = [each for each in (*plain, *asked.failures) if UNASKED not in each]
    return Sheet(
        word=_word(found, asked, parts),
        who=_who(asked),
        causes=tuple(dict.fromkeys(seen)),
        tables=tuple(tables),
        notes=_by_reason(each for each in found.notes if UNASKED not in each),
        next=next_step(found, asked, parts),
    )


def _why(said: str) -> str:
    """What stands behind the first colon, or all of it."""
    what, colon, why = said.partition(": ")
    return why if colon else what


def _by_reason(notes: Iterable[str]) -> tuple[str, ...]:
    """Notes "what: why" with what has the same reason together."""
    found: dict[str, list[str]] = {}
    for each in notes:
        what, _, why = each.partition(": ")
        found.setdefault(why, []).append(what)
    return tuple(f"{', '.join(what)}: {why}" for why, what in found.items())


def _word(found: Judgement, asked: Asked, parts: Collection[str]) -> str:
    left = [part for part in PARTS if part not in parts]
    some = f", of {' and '.join(p for p in PARTS if p in parts)} alone" if left else ""
    if asked.failures:
        return f"{NO_ANSWER} to {len(asked.failures)} of {asked.count} questions{some}"
    if found.state == STOPPED:
        return f"{'stopped at the gate' if found.gate.stops else 'nothing could be tried'}{some}"
    if found.state == AGREES and set(parts) == {"gate"}:
        return "passes the gate; nothing else was asked"
    coarse = max(found.bodies, key=lambda row: row.error, default=None)
    if found.state == AGREES and coarse is not None and coarse.error > BAND:
        body = f"{coarse.body} {'beam' if coarse.body in BENT else 'block'}"
        return f"the law agrees; {100 * coarse.error:.0f} % of the {body} is its mesh{some}"
    return f"{found.state}{some}"


def _who(asked: Asked) -> str:
    said = [str(asked.about.get(key, "")) for key in ("simulator", "version")]
    own = ", ".join(each for each in (" ".join(said).strip(), asked.about.get("law", "")) if each)
    return f"{own or 'it says nothing of itself'}; {asked.count} questions"


# Gate ---------------------------------------------------------------------------------------------


def _gate_table(found: Judgement) -> SheetTable:
    rows, before = [], ""
    for row in found.gate.rows:
        verdict = "" if UNASKED in row.because else row.verdict
        words = _gate_words(row)
        rows.append((verdict, row.name, "the same" if words == before else words))
        before = words
    return SheetTable("gate", ("", "", ""), tuple(rows))


def _gate_words(row: GateRow) -> str:
    if math.isnan(row.limit):
        value = "" if math.isnan(row.value) else f"{row.value:.2g} {row.unit}: "
        return f"{value}{row.because}"
    told = f"{row.value:.1e} {row.unit}, at most {row.limit:.1e}"
    return told if row.verdict == PASSED else f"{told}: {row.because}"


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
        below.append("no step was read: the law is told from bodies at rest alone")
    else:
        rows.append(_read_row(reading, asked))
        below = _reading_lines(reading)
    return SheetTable(
        "law at small strain", ("", "E (Pa)", "nu", "E over asked", "nu less asked"),
        tuple(rows), tuple(below),
    )  # fmt: skip


def _pair(E: float, nu: float) -> tuple[str, str]:
    return f"{E:.6g}", f"{nu:.5g}"


def _away(one: tuple[float, float], asked: tuple[float, float]) -> tuple[str, str]:
    away = round(one[1] - asked[1], 5) + 0.0
    return f"{one[0] / asked[0]:.5g}", f"{away:+.5f}"


def _read_row(reading: Reading, asked: tuple[float, float]) -> tuple[str, ...]:
    e = reading.elastic
    if reading.E is None or reading.nu is None:
        return ("read", "none", "none", "", "")
    away = _away((reading.E, reading.nu), asked)
    return ("read", f"{reading.E:.6g} ± {e.E_error:.1g}", f"{reading.nu:.5g} ± {e.nu_error:.1g}",
            *away)  # fmt: skip


def _reading_lines(reading: Reading) -> list[str]:
    """Masses, and flags where they matter."""
    masses = "masses: not observed, as it told forces"
    if reading.masses is not None:
        masses = reading.masses.line()
    lines = [
        masses,
        *(_flag_line(flag) for flag in reading.flags if flag.refuses and not flag.holds),
    ]
    if not reading.is_known:
        lines += [line for line in reading.refusals() if line.startswith("C known")]
    if reading.is_valid and (reading.E is None or reading.nu is None):
        lines.append(f"no E and nu: {reading.elastic.because}")
    if reading.is_valid and (part := anisotropy(reading.C)) > ISOTROPIC:
        lines.append(f"anisotropy {part:.1e}: E and nu are of the isotropic part alone")
    return lines


def _flag_line(flag: Flag) -> str:
    value = "not asked" if flag.value is None else f"{flag.value:.1e}"
    return f"does not count: {flag.name} {value}, at most {flag.limit:.1e}: {flag.because}"


# Bodies -------------------------------------------------------------------------------------------


def _bodies_table(found: Judgement) -> SheetTable:
    rows = tuple(_body_row(row) for row in found.bodies)
    below = []
    if found.large is not None:
        large = found.large
        below.append(
            f"{large.case} at {large.strain:.1%} strain: {large.apart:.2%} from elements of its "
            f"documented law, which are {large.from_linear:.2%} from linear ones"
        )
    columns = (
        "body",
        "case",
        "mesh",
        "error",
        "law",
        "resolution",
        "mass",
        "solver",
        "not explained",
    )
    return SheetTable(
        "bodies at rest: error, and what each cause multiplies the displacement by", columns, rows,
        tuple(below),
    )  # fmt: skip


def _body_row(row: BodyRow) -> tuple[str, ...]:
    head = (row.body, row.case, row.mesh, f"{row.error:.2%}")
    f = row.factors
    if f is None:
        return (*head, "", "", "", "", "no law to hold it against")
    parts = [_factor(part) for part in (f.law, f.resolution, f.mass, f.solver)]
    if not parts[-1] and row.rest > BAND:
        parts[-1] = f"± {row.rest:.0%}" if row.rest < 1 else "± all"
    shape = f", {row.shape}" if row.shape and not f.is_explained and not row.may_settle else ""
    return (*head, *parts, f"{f.apart:.2%}{shape}")


def _factor(part: float) -> str:
    return "" if abs(part - 1) < NOTICED else f"{part:.4g}"
