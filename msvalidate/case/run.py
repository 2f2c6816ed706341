"""A case solved, judged and laid out: all files that it leaves."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict
from datetime import UTC, datetime
from time import perf_counter

from msvalidate.case import budget, choice, comparison, files, judge, page
from msvalidate.case.advice import advice_record
from msvalidate.case.body_advice import body_lines
from msvalidate.case.case import Case
from msvalidate.case.figures import figures, judged_figures
from msvalidate.case.network_files import network_files
from msvalidate.case.quantities import difference_row
from msvalidate.case.results import Result
from msvalidate.output.provenance import collect_provenance
from reference_fem.converged import Reference


def case_files(
    case: Case,
    *,
    plots: bool = True,
    command: tuple[str, ...] = (),
    progress: Callable[[str], None] = lambda _: None,
) -> tuple[comparison.Comparison, dict[str, bytes]]:
    """What springs and elements say of a case, and the files that show it: name -> content.

    Raises
    ------
    ProblemError
        If the case asks what has no answer.
    SolverError
        If there is no trustworthy answer.
    """
    started, began = datetime.now(UTC), perf_counter()
    found = comparison.compare_case(case, progress)
    progress("springs in hand")
    springs = body_lines(found.advice)
    progress("budget")
    tables = budget.tables(found)
    progress("coarser springs")
    chosen = choice.choose(found)
    progress("pictures")
    drawn = figures(found, tables["budget"], tables["lattices"]) if plots else {}
    content, pictures = files.picture_files(drawn)
    fields = files.field_files(found) | network_files(found.springs[0], case)
    seconds = perf_counter() - began
    origin = collect_provenance(command, 0, started, seconds, form="case")
    head, said = page.sentences(found)
    said = (*said, *choice.choice_sentences(chosen))
    shown = page.Page(
        name=case.name,
        verdict=page.overall(found.rows),
        sentence=head,
        sentences=said,
        springs=springs,
        candidate="Springs",
        band=page.band_words(case, found.rows),
        rows=page.shown_rows(found.rows),
        notes=tuple(map(str, found.notes)),
        pictures=page.shown_pictures(pictures),
        tables=page.shown_tables(tables),
        fields=tuple(fields),
        asked=page.asked(case),
        origin=origin,
    )
    verdict = verdict_content(found, head, said, origin) | {"choice": asdict(chosen)}
    content |= files.table_files(tables) | fields
    content |= {"case.html": page.render(shown).encode(), "verdict.json": files.json_bytes(verdict)}
    return found, content


def judged_files(
    case: Case,
    result: Result,
    *,
    unit: float = 1.0,
    residual_motion: float | None = None,
    plots: bool = True,
    command: tuple[str, ...] = (),
    progress: Callable[[str], None] = lambda _: None,
) -> tuple[judge.Judged, dict[str, bytes]]:
    """What displacements from a file are beside a case's elasticity, and the files that show it.

    Raises
    ------
    ProblemError
        If no point of the file lies in the body, or the case asks what has no answer.
    SolverError
        If there is no trustworthy reference.
    """
    started, began = datetime.now(UTC), perf_counter()
    found = judge.judge_result(
        case, result, unit=unit, residual_motion=residual_motion, progress=progress
    )
    tables = judge.tables(found)
    progress("pictures")
    drawn = judged_figures(found, tables["budget"]) if plots else {}
    content, pictures = files.picture_files(drawn)
    given = found.matched
    compared = files.compared_file(given.places, "result", given.displacement, found)
    fields = {"compared.vtu": compared}
    origin = collect_provenance(command, 0, started, perf_counter() - began, form="case")
    head, said = page.judged_sentences(found)
    shown = page.Page(
        name=f"{result.name} for {case.name}",
        verdict=found.verdict.word,
        sentence=head,
        sentences=said,
        springs=(),
        candidate="Result",
        band=page.band_words(case, found.verdict.differences),
        rows=page.shown_rows(found.verdict.differences),
        notes=found.matched.notes,
        pictures=page.shown_pictures(pictures),
        tables=page.shown_tables(tables),
        fields=tuple(fields),
        asked={"result": result.name} | page.asked(case),
        origin=origin,
    )
    verdict = judged_verdict_content(found, head, said, origin)
    content |= files.table_files(tables) | fields
    content |= {"case.html": page.render(shown).encode(), "verdict.json": files.json_bytes(verdict)}
    return found, content


def reference_content(reference: Reference) -> dict[str, object]:
    """What `verdict.json` says of elasticity's own error."""
    return {
        "error": reference.error,
        "asked": reference.accuracy,
        "resolved": reference.resolved,
        "nodes": len(reference.finest.body.points),
        "more": reference.more and vars(reference.more),
    }


def verdict_content(
    found: comparison.Comparison, head: str, said: tuple[str, ...], origin: Mapping[str, str]
) -> dict[str, object]:
    """What `verdict.json` says of a case."""
    return {
        "name": found.case.name,
        "verdict": page.overall(found.rows),
        "sentence": head,
        "reasons": said,
        "kind": found.kind,
        "band": found.case.band,
        "quantities": [difference_row(row) for row in found.rows],
        "springs": [advice_record(each) for each in found.advice],
        "reference": reference_content(found.reference),
        "on_mesh": found.on_mesh.table.to_dict("records") if found.on_mesh else [],
        "notes": list(map(str, found.notes)),
        "origin": dict(origin),
    }


def judged_verdict_content(
    found: judge.Judged, head: str, said: tuple[str, ...], origin: Mapping[str, str]
) -> dict[str, object]:
    """What `verdict.json` says of displacements from a file."""
    return {
        "name": found.case.name,
        "result": found.result.name,
        "verdict": found.verdict.word,
        "sentence": head,
        "reasons": said,
        "band": found.case.band,
        "quantities": [difference_row(found.displacement)],
        "causes": [each.row() for each in found.verdict.causes],
        "rest": found.displacement.residual_motion,
        "precision": found.result.accuracy,
        "reference": reference_content(found.reference),
        "points": {
            "compared": len(found.matched.places),
            "outside": len(found.matched.outside),
            "doubled": len(found.matched.doubled),
            "missing": len(found.matched.missing),
        },
        "notes": found.matched.notes,
        "origin": dict(origin),
    }
