"""A case solved, judged and laid out: all files that it leaves."""

from __future__ import annotations

import math
from dataclasses import asdict
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pandas as pd

from msvalidate.bench.output.provenance import collect_provenance
from msvalidate.bench.output.screen import render_screen
from msvalidate.bench.output.stored import csv_bytes
from msvalidate.case.advise.advice import advice_record
from msvalidate.case.compare import budget, choice, comparison
from msvalidate.case.compare.body_advice import body_lines
from msvalidate.case.file.case import Case
from msvalidate.case.judge import judgement
from msvalidate.case.judge.own_network import judge_network, network_record
from msvalidate.case.judge.results import Result
from msvalidate.case.report import files, headline, page
from msvalidate.case.report.figures import Drawn, figures, judged_figures
from msvalidate.case.springs.network_files import network_files
from msvalidate.problem.progress import report_stage
from reference_fem.converged import Reference


def case_files(
    case: Case,
    *,
    plots: bool = True,
    command: tuple[str, ...] = (),
) -> tuple[comparison.Comparison, choice.Choice, dict[str, bytes]]:
    """Comparison of a case, the choice between springs and elements, and files: name -> content.

    Errors are those of `compare_case`.
    """
    started = datetime.now(UTC)
    found = comparison.compare_case(case)
    report_stage("time step", comparison.STAGES)
    springs = body_lines(found.advice)
    report_stage("budget", comparison.STAGES)
    tables = budget.tables(found)
    report_stage("coarser springs", comparison.STAGES)
    chosen = choice.choose(found)
    report_stage("pictures", comparison.STAGES)
    drawn = figures(found, tables["budget"], tables["lattices"]) if plots else {}
    fields = files.field_files(found) | network_files(found.springs[0], case)
    head, said = page.sentences(found)
    needs = choice.choice_sentences(chosen, case.unit)
    verdict = {
        "name": case.name,
        "verdict": headline.overall(found.rows),
        "headline": head,
        "recommendation": headline.recommend(found, chosen).sentence,
        "sentence": head,
        "reasons": (*said, *needs),
        "kind": found.kind,
        "limitations": [asdict(each) for each in found.limitations],
        "springs": [advice_record(each) for each in found.advice],
        "springs_alone": found.alone if math.isfinite(found.alone) else None,
        "on_mesh": found.on_mesh.table.to_dict("records") if found.on_mesh else [],
        "choice": asdict(chosen),
        "notes": list(map(str, found.notes)),
    }
    content = _laid_out(found, verdict, tables, fields, drawn, command, started, needs, springs)
    return found, chosen, content


def judged_files(
    case: Case,
    result: Result,
    *,
    unit: float = 1.0,
    residual_motion: float | None = None,
    plots: bool = True,
    command: tuple[str, ...] = (),
    network: Path | None = None,
) -> tuple[judgement.Judged, dict[str, bytes]]:
    """Judge displacements from a file against elasticity, and render the files.

    The result is the record and the content of each file by name.

    Errors are those of `judge_result`, which tells what `unit` and `residual_motion` are, and of
    `judge_network` for the folder `network`.
    """
    started = datetime.now(UTC)
    found = judgement.judge_result(case, result, unit=unit, residual_motion=residual_motion)
    own = {} if network is None else {"network": network_record(judge_network(found, network))}
    tables = judgement.tables(found)
    report_stage("pictures", judgement.STAGES)
    drawn = judged_figures(found, tables["budget"]) if plots else {}
    given = found.matched
    compared = files.compared_file(given.places, "result", given.displacement, found)
    head, said = page.judged_sentences(found)
    said = (*(each for one in own.values() for each in one["sentences"]), *said)
    verdict = {
        "name": case.name,
        "result": result.name,
        "verdict": found.verdict.word,
        "headline": headline.field_sentence(found),
        "recommendation": headline.recommend_for_field(found),
        "sentence": head,
        "reasons": said,
        "limitations": [asdict(each) for each in found.limitations],
        "causes": [each.row() for each in found.verdict.causes],
        "rest": found.displacement.residual_motion,
        "precision": result.accuracy,
        "points": {
            "compared": len(given.places),
            **{name: len(getattr(given, name)) for name in ("outside", "doubled", "missing")},
        },
        "notes": given.notes,
        **own,
    }
    fields = {"compared.vtu": compared}
    causes = tuple(each.said for each in found.verdict.causes)
    return found, _laid_out(found, verdict, tables, fields, drawn, command, started, causes)


def _laid_out(
    found: comparison.Comparison | judgement.Judged,
    verdict: dict[str, Any],
    tables: dict[str, pd.DataFrame],
    fields: dict[str, bytes],
    drawn: Drawn,
    command: tuple[str, ...],
    started: datetime,
    remarks: tuple[str, ...],
    springs: tuple[str, ...] = (),
) -> dict[str, bytes]:
    """Page, `verdict.json`, tables, fields and pictures, with what all pages and verdicts say."""
    content, pictures = files.picture_files(drawn, found.case.unit)
    seconds = (datetime.now(UTC) - started).total_seconds()
    origin = collect_provenance(command, 0, started, seconds, form="case")
    embedded = page.shown_pictures(pictures)
    screen = page.first_screen(found, verdict, embedded, remarks)
    html = render_screen(
        "case.html",
        screen,
        {name: name for name in page.PARTS if springs or name != "springs"},
        reasons=[
            *(each for each in verdict["reasons"] if not each.endswith(remarks)),
            *verdict["notes"],
        ],
        springs=springs,
        pictures=[each for each in embedded if each != screen.picture],
        tables=page.shown_tables(tables),
        fields=tuple(fields),
        request={**page.facts(found), **found.case.notes},
        origin=origin,
    )
    verdict |= {
        "band": found.case.band,
        "quantities": tables["quantities"].to_dict("records"),
        "reference": reference_content(found.reference),
        "origin": origin,
    }
    content |= {f"{name}.csv": csv_bytes(table) for name, table in tables.items()} | fields
    return content | {"case.html": html.encode(), "verdict.json": files.json_bytes(verdict)}


def reference_content(reference: Reference) -> dict[str, object]:
    """Record of elasticity's own error in `verdict.json`."""
    return {
        "error": reference.error,
        "asked": reference.accuracy,
        "resolved": reference.resolved,
        "nodes": len(reference.finest.body.points),
        "more": reference.more and vars(reference.more),
    }
