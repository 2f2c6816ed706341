"""A case solved, judged and laid out: all files that it leaves."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from datetime import UTC, datetime
from time import perf_counter

from msvalidate.case import comparison, files, page
from msvalidate.case.case import Case
from msvalidate.case.figures import figures
from msvalidate.output.provenance import collect_provenance


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
    progress("budget")
    tables = comparison.tables(found)
    progress("pictures")
    drawn = figures(found, tables["budget"], tables["lattices"]) if plots else {}
    content, pictures = files.picture_files(drawn)
    fields = files.field_files(found)
    seconds = perf_counter() - began
    origin = collect_provenance(command, 0, started, seconds, form="case")
    head, said = page.sentences(found)
    shown = page.Page(
        name=case.name,
        verdict=page.overall(found.rows),
        sentence=head,
        sentences=said,
        candidate="Springs",
        band=page.percent(case.band),
        rows=page.shown_rows(found.rows),
        notes=found.notes,
        pictures=page.shown_pictures(pictures),
        tables=page.shown_tables(tables),
        fields=tuple(fields),
        asked=page.asked(case),
        origin=origin,
    )
    verdict = verdict_content(found, head, said, origin)
    content |= files.table_files(tables) | fields
    content |= {"case.html": page.render(shown).encode(), "verdict.json": files.json_bytes(verdict)}
    return found, content


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
        "quantities": [vars(row) for row in found.rows],
        "reference": {
            "error": found.reference.error,
            "asked": found.reference.accuracy,
            "resolved": found.reference.resolved,
            "nodes": len(found.reference.finest.body.points),
        },
        "notes": found.notes,
        "origin": dict(origin),
    }
