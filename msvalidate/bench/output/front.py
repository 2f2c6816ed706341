"""The first screen of the page: the source report in a table, and what springs are good for."""

from __future__ import annotations

import math
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass

import pandas as pd

from msvalidate.bench.judging.summary import TOLERANCE
from msvalidate.bench.output.baseline import baseline_folder
from msvalidate.bench.output.results import FULL
from msvalidate.bench.output.stored import Stored, read_csv
from msvalidate.bench.output.summary import is_number
from msvalidate_check.text import percent as text_of_part
from msvalidate_check.verdict import AGREES, DIFFERS

OVERVIEW, ROWS = "overview", "good_for"
FIGURE = "displacement/emblem.svg"
LEDGER, SENTENCES = "claims", "ledger"
COMMITTED = "the committed baseline of full mode"
SHORTER = {
    "true where the source says": "true only where stated",
    "false as said, true if": "false as worded, true if read otherwise",
}
"""Verdicts of the ledger as they are counted here."""
TOPIC = ("topic", "says", "topic_verdict", "found", "studies")
ROUNDING = 1e-9
"""A number of the ledger below this is shown as 0."""
MEASURED = ("number", "unit", "side", "bound", "measure")
SHOWN = ("body", "springs", "verdict", "condition", "study", "table")
"""Columns of the rows that are shown as they are."""
COLUMNS = {
    *SHOWN,
    *("error_coarse", "error_at_20", "across_fine", "error_fine", "uncertainty_fine"),
}
AXIS, TICKS = (1e-4, 1.0), ("0.0001", "0.001", "0.01", "0.1", "1")
"""Ends of the chart's logarithmic axis of relative errors, and its ticks."""
ADVICE = (
    "Use a square lattice with k2 = k1/2 (in 3D a cubic one with 18 neighbours) and give boundary "
    "springs half of the stiffness. Poisson's ratio is then 1/3 in plane stress and 1/4 in plane "
    "strain and 3D; for another ratio add a volume energy to each cell. Use finite elements if "
    "your program has no such energy, or if a wall is one or two cells thick."
)
"""General recommendation; its exceptions are rows of the chart."""


@dataclass(frozen=True)
class Line:
    """Row of the first screen, as words; places of its errors on the chart's axis (%)."""

    body: str
    springs: str
    middle: str
    fine: str
    verdict: str
    condition: str
    study: str
    table: str
    coarse_at: float = math.nan
    fine_at: float = math.nan


@dataclass(frozen=True)
class Topic:
    """Topic of the source report: its claim, the verdict, the result, and the studies."""

    topic: str
    says: str
    verdict: str
    found: str
    studies: str

    @property
    def sentence(self) -> str:
        """First sentence on the topic."""
        return self.found.partition(". ")[0].removesuffix(".") + "."


@dataclass(frozen=True)
class Entry:
    """A sentence of the source report in the ledger, as words."""

    sentence: str
    verdict: str
    number: str
    study: str
    table: str


@dataclass(frozen=True)
class Front:
    """The first screen: the report's topics, advice and rows, and where they come from."""

    lines: tuple[Line, ...]
    advice: str
    source: str
    topics: tuple[Topic, ...]
    sentences: str
    judged_from: str
    verdict: str = ""
    ticks: tuple[tuple[str, float], ...] = ()
    band: float = 0.0


def first_screen(studies: Sequence[Stored]) -> Front:
    """The rows that were stored, else those of the committed baseline, else none."""
    rows, source = _table(studies, OVERVIEW, ROWS, COLUMNS)
    topics, judged_from = _table(studies, LEDGER, "topics", set(TOPIC))
    verdicts, _ = _table(studies, LEDGER, "verdicts", {"verdict", "sentences"})
    lines = tuple(_line(row) for row in rows.astype(str).to_dict("records"))
    heads = tuple(Topic(*row) for row in topics.reindex(columns=TOPIC).to_numpy())
    counts = [f"{n} {SHORTER.get(verdict, verdict)}" for verdict, n in verdicts.to_numpy()]
    sentences = "; ".join(counts)
    ticks = tuple((percent(tick), axis_place(tick)) for tick in TICKS)
    band = axis_place(str(TOLERANCE))
    chart = (chart_sentence(lines), ticks, band)
    return Front(lines, _advice(lines), source, heads, sentences, judged_from, *chart)


def ledger(table: pd.DataFrame) -> tuple[Entry, ...]:
    """The ledger's sentences in four columns: sentence, verdict, number, where it comes from."""
    return tuple(
        Entry(
            sentence=f"{row['sentence']}. {row['phrase']}",
            verdict=row["verdict"],
            number=_measured(**{name: row[name] for name in MEASURED}),
            study=row["study"],
            table=row["table"],
        )
        for row in table.astype(str).to_dict("records")
    )


def _measured(number: str, unit: str, side: str, bound: str, measure: str) -> str:
    """Measured error and its bound, with rounding set to 0.

    Rounding differs between machines.
    """
    if not is_number(number):
        return ""
    value = "0" if abs(float(number)) < ROUNDING else f"{float(number):.3g}"
    return f"{value}{'' if unit == '1' else ' ' + unit}: {measure} ({side} {float(bound):g})"


def _advice(lines: Sequence[Line]) -> str:
    """Recommendation in general terms, with the error of the first row, and what to avoid."""
    if not lines or lines[0].verdict != AGREES:
        return ""
    avoided = dict.fromkeys(line.springs for line in lines if line.verdict == DIFFERS)
    never = f" Do not use: {'; '.join(avoided)}." if avoided else ""
    return f"{ADVICE} Expect an error of about {lines[0].middle} with 20 cells across.{never}"


def _table(
    studies: Sequence[Stored], study: str, name: str, needed: set[str]
) -> tuple[pd.DataFrame, str]:
    """Return a table of full mode as text, and its source in words.

    A headline reads the same after a quick run as after a full one: the table of a quick run, or
    one that is damaged, is replaced by that of the baseline.
    """
    why = ""
    for stored in studies:
        if stored.name != study or stored.origin.get("form", FULL) != FULL:
            continue
        table = stored.tables.get(name, pd.DataFrame())
        if not stored.error and len(table) and needed <= set(table):
            time = stored.origin.get("time", "unknown time").partition(",")[0]
            return table, f"the full run of {time}"
        why = f", as what {study} left is not whole"
    path = baseline_folder(FULL) / study / f"{name}.csv"
    return (read_csv(path) if path.is_file() else pd.DataFrame()), COMMITTED + why


def _line(row: Mapping[Hashable, str]) -> Line:
    """A row in words, from its `COLUMNS` and `TIMES`."""
    return Line(
        **{name: row[name] for name in SHOWN},
        middle=percent(row["error_at_20"]),
        fine=_with_uncertainty(row["error_fine"], row["uncertainty_fine"])
        + f" at {row['across_fine']}",
        coarse_at=axis_place(row["error_coarse"]),
        fine_at=axis_place(row["error_fine"]),
    )


def axis_place(error: str) -> float:
    """Place of an error on the chart's logarithmic axis, in per cent of the axis; NaN of words."""
    if not is_number(error):
        return math.nan
    low, high = map(math.log10, AXIS)
    part = (math.log10(max(float(error), AXIS[0])) - low) / (high - low)
    return 100 * min(part, 1.0)


def chart_sentence(lines: Sequence[Line]) -> str:
    """Sentence that counts the bodies inside and outside the band on the fine lattice."""
    outside = [f"“{line.body}” ({line.fine} cells)" for line in lines if line.verdict == DIFFERS]
    agree = sum(line.verdict == AGREES for line in lines)
    rest = f" Outside: {', '.join(outside)}." if outside else ""
    return (
        f"On the fine lattice, {agree} of {len(lines)} bodies are within {percent(str(TOLERANCE))} "
        f"of elasticity.{rest}"
    )


def _with_uncertainty(error: str, uncertainty: str) -> str:
    """An error, and the reference's own where that is a tenth of it or more."""
    known = is_number(error) and is_number(uncertainty) and float(uncertainty) >= 0.1 * float(error)
    own = text_of_part(float(uncertainty), floor=0.0) if known else ""
    return f"{100 * float(error):.2g} ± {own}" if known else percent(error)


def percent(text: str) -> str:
    """A share in per cent with two digits."""
    return text_of_part(float(text)) if is_number(text) else text
