"""The page of all results, made from what the studies left. Returns text, writes nothing.

The page is one HTML text that loads nothing and runs nothing: styles and pictures are inside it.
What a study says reaches the template as plain text and is escaped there; nothing is marked safe.
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from msvalidate.bench.judging.columns import column_key
from msvalidate.bench.judging.evidence import OPEN, is_missed
from msvalidate.bench.judging.summary import NAME as SUMMARY
from msvalidate.bench.output.excerpt import TABLES_FIRST, Table, format_number, table_excerpt
from msvalidate.bench.output.front import FIGURE, SENTENCES, first_screen, ledger
from msvalidate.bench.output.pictures import Picture, embed_pictures
from msvalidate.bench.output.rendering import Block, paragraphs_and_lists
from msvalidate.bench.output.screen import FirstScreen, Summary, agreement_badge, render_screen
from msvalidate.bench.output.stored import NUMBERS, Stored
from msvalidate.bench.output.summary import summary_sentence, summary_texts
from msvalidate_check.verdict import AGREES, DIFFERS, NOT_RESOLVED

PICTURES = 1_500_000
"""Bytes of pictures inside the page, shared out evenly among the studies."""
LAYERS = {
    "theory": "formulas, orders, identities and the reference's own accuracy",
    "agreement": "a band between springs and elasticity",
    "regression": "a limit set from a measurement: notices a change, proves nothing",
    "baseline": "the values of the committed tables",
}
"""Layer of judgement -> what it holds values to, in the order of the page."""
SUMMARISED = "baseline"
"""Layer of which only failures are listed, since it has every number."""
EYEBROW = "msvalidate: spring networks compared with elasticity"
HEADING = "How accurate are mass-spring networks?"
CLAIM = "Claim: "
"""Beginning of the finding that the first screen shows as the verdict on a claim."""
LIST_OF_QUESTIONS = " One question a file:"
"""Introduction of the list of questions in a study's docstring."""
GLANCED = 3
"""Findings, and failures, above all else on the page of one study."""
PASS, FAIL, NOT_FINISHED = "pass", "FAIL", "not finished"
MISSES = (FAIL, DIFFERS)
STATES = (FAIL, DIFFERS, NOT_FINISHED, NOT_RESOLVED, PASS, AGREES)
"""Possible states of a study, the most important first."""

ADVICE = re.compile(r"^Recommendation: (.*?)(?:\n\s*\n|\Z)", re.DOTALL | re.MULTILINE)
"""Paragraph of a study's docstring that its first screen shows as the recommendation."""


Judged = Mapping[str, str]
"""A row of a verdict as it is shown, with its study and status."""


@dataclass(frozen=True)
class Layer:
    """The rows of one layer, which of them are listed, and how many are not resolved."""

    name: str
    meaning: str
    judged: int
    missed: int
    listed: tuple[Judged, ...]
    open: int = 0


@dataclass(frozen=True)
class Section:
    """A study as the page shows it."""

    name: str
    anchor: str
    status: str
    title: str
    question: str
    about: tuple[Block, ...]
    error: str
    findings: tuple[str, ...]
    pictures: tuple[Picture, ...]
    tables: tuple[Table, ...]
    layers: tuple[Layer, ...]
    failed: tuple[Judged, ...]
    origin: Mapping[str, str]
    seconds: float
    cover: Picture | None
    summary: Summary | None
    sentence: str
    advice: str

    @property
    def candidate(self) -> str:
        """Whom it judged; "" for our own springs."""
        return self.origin.get("candidate", "")

    @property
    def asked(self) -> str:
        """Questions of the study that ran; "" for all."""
        return self.origin.get("questions", "")

    @property
    def open(self) -> int:
        """Number of quantities that were not resolved."""
        return sum(layer.open for layer in self.layers)

    @property
    def judged(self) -> int:
        """Number of quantities that were judged."""
        return sum(layer.judged for layer in self.layers)

    @property
    def missed(self) -> int:
        """Number of quantities that failed."""
        return sum(layer.missed for layer in self.layers)


def render_page(studies: Sequence[Stored]) -> str:
    """The page of all studies, in their order: HTML, complete in itself."""
    room = PICTURES // max(1, len(studies))
    sections = [study_section(study, room) for study in studies]
    status, sentence = overall_verdict(sections)
    common, own = common_provenance(sections)
    # What our own springs are good for is no part of what is said of somebody else's.
    alone = len(sections) == 1 and not sections[0].error
    foreign = bool(sections) and all(s.candidate for s in sections)
    front = None if alone or foreign else first_screen(studies)
    glance = sections[0] if alone else None
    emblem = next((p for s in sections for p in s.pictures if p.file == FIGURE), None)
    bodies = [line.verdict for line in front.lines] if front else ()
    screen = FirstScreen(
        EYEBROW,
        HEADING,
        agreement_badge(status, bodies, "springs agree with elasticity in {} of {} bodies"),
        front.verdict if front and front.lines else sentence,
        front.advice if front else "",
        picture=emblem,
        remarks=[sentence] * bool(front and front.lines),
    )
    if glance:
        screen = _screen_of(glance)
    return render_screen(
        "report.html",
        screen,
        {"verdict": "verdict"} | {section.anchor: section.name for section in sections},
        status=status,
        sentence=sentence,
        heading=verdict_heading(sections),
        sections=sections,
        glance=glance,
        shown=GLANCED,
        front=front,
        ledger=next((ledger(s.tables[SENTENCES]) for s in studies if SENTENCES in s.tables), ()),
        there={section.name: section.anchor for section in sections},
        # An unfinished study's rows are of the run before: they say nothing about this one.
        failed=[row for s in sections if not s.error for row in s.failed],
        unjudged=[s for s in sections if s.error or not s.judged],
        layers=LAYERS,
        summarised=SUMMARISED,
        common=common,
        own=own,
    )


def _screen_of(study: Section) -> FirstScreen:
    """First screen of the page of one study."""
    verdict, *remarks = [*filter(None, [study.sentence]), *study.findings[:GLANCED], ""]
    summary = study.summary or Summary("", [""] * 3, [], [])
    rows = [row[-1] for row in summary.rows]
    words = f"springs agree with {summary.heads[2]} in {{}} of {{}} rows"
    claim = next((each for each in study.findings if each.startswith(CLAIM)), "")
    checks = overall_verdict([study])[1]
    if claim:
        remarks = [f"{checks} {verdict}"]
        verdict = f"{claim.removeprefix(CLAIM).partition('. ')[0].removesuffix('.')}."
    return FirstScreen(
        " · ".join(filter(None, (EYEBROW, study.origin.get("command", "")))),
        study.title,
        agreement_badge(study.status, rows, words),
        verdict if claim else f"{checks} {verdict}",
        study.advice,
        study.summary,
        study.cover,
        remarks[:1] if study.summary else remarks[:-1],
        study.question,
    )


def study_section(study: Stored, room: int = PICTURES) -> Section:
    """A study as the page shows it, with so much room (bytes) for pictures."""
    title, _, rest = inspect.cleandoc(study.question).partition("\n")
    question = " ".join(rest.strip().partition("\n\n")[0].split())
    advice = ADVICE.search(rest)
    rows = judgements(study)
    first = {name: made for name, made in study.pictures.items() if name == study.cover}
    pictures = embed_pictures(study.name, {**first, **study.pictures}, room)
    inside = [each for each in pictures if each.source]
    summary, sentence = _summary(study)
    cover = f"{study.name}/{study.cover}.svg"
    return Section(
        name=study.name,
        anchor="study-" + re.sub(r"[^\w-]+", "-", study.name),
        status=study_status(study),
        title=title or study.name,
        question="" if question.startswith("-") else question.removesuffix(LIST_OF_QUESTIONS),
        about=paragraphs_and_lists(ADVICE.sub("", rest)),
        error=study.error,
        findings=study.findings,
        pictures=pictures,
        tables=tables(study),
        layers=tuple(layer_judgements(name, rows) for name in layer_names(rows)),
        failed=tuple(row for row in rows if row["status"] in MISSES),
        origin=study.origin,
        seconds=study.seconds,
        cover=next((each for each in inside if each.file == cover), next(iter(inside), None)),
        summary=summary,
        sentence=sentence,
        advice=" ".join(advice[1].split()) if advice else "",
    )


def _summary(study: Stored) -> tuple[Summary | None, str]:
    """Table `summary` of a study for its first screen, and its verdict as one sentence."""
    table = study.tables.get(SUMMARY)
    if table is None or "difference" not in table:
        return None, ""
    quantity = study.columns.get(column_key(SUMMARY, "springs", study.columns), "")
    caption = f"{quantity[:1].upper()}{quantity[1:] or SUMMARY}."
    made = Summary(caption, *summary_texts(table, study.labels))
    return made, summary_sentence(table)


def study_status(study: Stored) -> str:
    """State of a study in words, for the built-in springs or a candidate."""
    if study.error:
        return NOT_FINISHED
    if "candidate" not in study.origin:
        return PASS if study.held else FAIL
    if study.held:
        return AGREES
    return DIFFERS if is_missed(study.verdict).any() or study.verdict.empty else NOT_RESOLVED


def verdict_heading(sections: Sequence[Section]) -> str:
    """Whose verdict the page begins with."""
    names = ", ".join(dict.fromkeys(s.candidate for s in sections if s.candidate))
    if not names:
        return "The software's own verdict"
    ours = "" if all(s.candidate for s in sections) else ", and the software's own"
    return f"Verdict on {names}{ours}"


def overall_verdict(sections: Sequence[Section]) -> tuple[str, str]:
    """Verdict on all studies, and the sentence that says why."""
    finished = [s for s in sections if not s.error]
    judged, missed = sum(s.judged for s in finished), sum(s.missed for s in finished)
    unresolved = sum(s.open for s in finished)
    said = []
    if missed:
        said.append(f"{missed} of {plural(judged, 'tolerance')} missed")
    elif unresolved:
        said.append(f"{judged - unresolved} of {plural(judged, 'tolerance')} held, none missed")
    elif judged:
        all_of = f"all {judged} tolerances" if judged > 1 else "the one tolerance"
        said.append(f"{all_of} of {plural(len(finished), 'study')} held")
    if unresolved:
        said.append(f"{unresolved} not resolved by numbers of this accuracy")
    silent, stopped = [s for s in finished if not s.judged], [s for s in sections if s.error]
    for words, those in (("judged nothing", silent), ("did not finish", stopped)):
        if those:
            said.append(f"{words}: {', '.join(s.name for s in those)}")
    sentence = "; ".join(said) or "no study has been run"
    states = {s.status for s in sections} or {NOT_FINISHED}
    status = next(word for word in STATES if word in states)
    return status, f"{sentence[0].upper()}{sentence[1:]}."


def plural(count: int, noun: str) -> str:
    """A count and its noun: 1 study, 2 studies."""
    if count == 1:
        return f"1 {noun}"
    return f"{count} {noun[:-1]}ies" if noun.endswith("y") else f"{count} {noun}s"


def common_provenance(
    sections: Sequence[Section],
) -> tuple[dict[str, str], dict[str, dict[str, str]]]:
    """Provenance that all studies share, and the differences by study."""
    every = [s.origin for s in sections]
    common = {
        label: value
        for label, value in (every[0] if every else {}).items()
        if all(origin.get(label) == value for origin in every)
    }
    own = {s.name: {k: v for k, v in s.origin.items() if k not in common} for s in sections}
    return common, {name: origin for name, origin in own.items() if origin}


def judgements(study: Stored) -> list[Judged]:
    """The rows of a verdict, numbers with six digits."""
    found: list[Judged] = []
    for row in study.verdict.to_dict("records"):
        said = {str(key): value for key, value in row.items()}
        words = {k: str(said.get(k, "")) for k in ("layer", "quantity", "unit", "because")}
        numbers = {k: format_number(float(said[k])) for k in NUMBERS}
        word = str(said["verdict"])
        status = PASS if word == "pass" else word if word in (AGREES, DIFFERS, *OPEN) else FAIL
        which, many = str(said.get("at", "")), int(said.get("rows", 1))
        at = f"{which}, of {many} rows" if which and many > 1 else which
        found.append({"study": study.name, "status": status, "at": at} | words | numbers)
    return found


def layer_names(rows: Sequence[Judged]) -> list[str]:
    """All known layers, and any other that a row names: no row is left out."""
    return list(dict.fromkeys([*LAYERS, *(row["layer"] for row in rows)]))


def layer_judgements(name: str, rows: Sequence[Judged]) -> Layer:
    """The rows of one layer."""
    inside = tuple(row for row in rows if row["layer"] == name)
    missed = tuple(row for row in inside if row["status"] in MISSES)
    listed = missed if name == SUMMARISED else inside
    return Layer(
        name,
        LAYERS.get(name, ""),
        len(inside),
        len(missed),
        listed,
        sum(row["status"] in OPEN for row in inside),
    )


def tables(study: Stored) -> tuple[Table, ...]:
    """A study's tables, those first that a reader wants first."""
    names = sorted(study.tables, key=lambda name: name not in TABLES_FIRST)
    known = study.columns, study.labels
    return tuple(table_excerpt(name, study.tables[name], *known) for name in names)
