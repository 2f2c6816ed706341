"""Command ``msvalidate case``: run, judge, export and schema."""

from __future__ import annotations

import argparse
import contextlib
import json
import re
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from functools import partial
from io import BytesIO
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pandas as pd

from msvalidate.bench.judging.workers import Cluster, Workers, run_all
from msvalidate.bench.output.stored import csv_bytes, draw_files
from msvalidate.case.compare.body_advice import body_lines
from msvalidate.case.file import building, places
from msvalidate.case.file.case import Case, spacing_of
from msvalidate.case.file.reading import CaseError
from msvalidate.case.file.schema import CaseFile
from msvalidate.case.judge.results import Result, read_result
from msvalidate.case.report import files, run, screen, sweep
from msvalidate.case.report.sides import draw_sides
from msvalidate.case.springs import lattice_springs, network_files
from msvalidate.cli import gating
from msvalidate.cli.arguments import FAILED, HELD, MISSED, SIMULATOR, USAGE
from msvalidate.cli.progress import Progress, log_path
from msvalidate.cli.terminal import (
    attempt,
    naming,
    print_lines,
    tell,
    tell_error,
)
from msvalidate.problem import ProblemError
from msvalidate.problem.checks import finite_number, positive_number, whole_number
from msvalidate.problem.progress import report_step
from msvalidate.problem.records import replace
from msvalidate.simulators.exchange.export import export_case, lammps_of, ratio_words
from msvalidate.simulators.exchange.folders import write_request
from msvalidate.simulators.exchange.protocol import Request
from msvalidate_check import exchange
from msvalidate_check.verdict import AGREES

COMMAND = ("msvalidate", "case", "judge", "FILE", "RESULT")
PAGE = "case.html"
STORED = ("quantities", "constants")
"""Tables of a case that a baseline stores; of a field, the first."""
SWEPT = (sweep.ROWS, "sweep.csv", "sweep.png", "sweep.svg")
"""Entries of a sweep's folder."""
SWEEP_CODES = {sweep.REFUSED: USAGE} | dict.fromkeys((sweep.FAILED, sweep.LATE, sweep.DIED), FAILED)
"""Exit codes of rows that have no verdict."""
overflowing = np.errstate(over="ignore", invalid="ignore")
"""Context without NumPy's warnings of overflow, which messages report."""


def of_case(file: Path) -> AbstractContextManager[None]:
    """Let errors name a case's file, if they name nothing themselves."""
    named = ("case ", "adapter", "answer: ", "folder ", "result ")
    return naming(f"case {file.name}", but=named)


def print_schema(args: argparse.Namespace) -> int:
    """Print the schema of case files, or of network.json."""
    made = msgspec.json.schema(network_files.NetworkFile if args.kind == "network" else CaseFile)
    quantity = r'"title": "quantity",\s+"type": "number"'
    text = json.dumps(made, indent=2)
    return print_lines([re.sub(quantity, '"type": ["number", "string"]', text)])


@overflowing
def export(args: argparse.Namespace) -> int:
    """Write what a simulator is asked, or the case's springs at rest as tables or for LAMMPS."""
    with of_case(args.file), progress_of(args.file, args.folder, args):
        case = building.read_case(args.file)
        own = {"case.toml": args.file.read_bytes()}
        if args.to == SIMULATOR:
            asked = request_of(case, args)
            write_request(asked, args.folder, own)
            tell(f"{args.folder}: {asked.mesh}, {len(asked.mesh.points)} nodes")
            return HELD
        for name in ("shape", "springs", "setting"):
            if getattr(args, name):
                raise ProblemError(f"--{name}: is of --to {SIMULATOR}; with {args.to} leave it out")
        files.refuse_foreign(args.folder, args.file.name)
        if args.cells is not None:
            case = replace(case, cells=args.cells, spacing=None)
        if args.to == "lammps":
            tell_ratio(case)
            answer, content = lammps_of(case)
        else:
            answer = lattice_springs.solve_springs(case, spacing_of(case))
            content = {"network.json": network_files.network_json(answer, case)}
            if args.to == "csv":
                whole = network_files.network_files(answer, case)
                content = {name: each for name, each in whole.items() if name.endswith(".csv")}
        files.publish(args.folder, content | own, args.file.name)
    network = answer.network
    count = f"{len(network.points)} points, {len(network.springs)} springs"
    tell(f"{args.folder}: {answer.lattice.name}, {count}, {len(network.resisting)} cells")
    return HELD


def request_of(case: Case, args: argparse.Namespace) -> Request:
    """Request that a simulator receives for a case."""
    if args.springs and not args.quiet:
        tell_ratio(case)
    shape = {"cells": args.cells, "shape": args.shape, "springs": args.springs}
    return export_case(case, **shape, settings=dict(args.setting))


def tell_ratio(case: Case) -> None:
    """Say what the ratio of springs alone costs, if it is another than the case's."""
    if words := ratio_words(case):
        tell(f"{case.name}: {words}")


@overflowing
def run_cases(args: argparse.Namespace) -> int:
    """Each case in turn: one that is refused does not keep the others from being solved."""
    if args.set:
        return _sweep(args)
    gating.refuse_outputs(args, gating.CASES)
    codes, results = [], dict[str, gating.Judged]()
    for file in args.files:
        name = files.folder_name(file.stem)
        if name in results:
            said = f"case {file.name}: results of another case go to the same folder {name}"
            codes.append(tell_error(f"{said}; run it with another --out", USAGE))
            continue
        codes.append(attempt(partial(_solve, file, args.out / name, args, results)))
        results.setdefault(name, gating.unfinished(name, f"no result, exit code {codes[-1]}"))
    return gating.conclude(args, gating.CASES, [*results.values()], max(codes), many=True)


@contextlib.contextmanager
def progress_of(file: Path, folder: Path, args: argparse.Namespace) -> Iterator[None]:
    """Context of a command on a case file: its progress, whose log lies beside its results.

    If a side has to be chosen, a picture with the names of all sides is written there, too.
    """
    with Progress(file.stem, shown=not args.quiet, log=log_path(folder)):
        try:
            yield
        except CaseError as error:
            if error.mesh is not None and error.mesh.dim == 3:
                path = folder.with_name(f"{folder.name}-sides.png")
                draw = partial(draw_sides, error.mesh, error.length)
                drawn = draw_files("sides", f"Sides of {file.name}", draw, margin=files.MARGIN)
                with contextlib.suppress(OSError):
                    exchange.replace_file(path, partial(bytes, drawn["sides.png"]))
                    error.add_note(f"picture: {path}")
            raise


def _solve(
    file: Path, folder: Path, args: argparse.Namespace, results: dict[str, gating.Judged]
) -> int:
    """Solve a case, write its files, print its first screen and add it to the results."""
    began = time.perf_counter()
    with of_case(file):
        files.refuse_foreign(folder, file.name)
        with progress_of(file, folder, args):
            case = building.read_case(file)
            command = ("msvalidate", "case", "run", "FILE")
            found, chosen, content = run.case_files(case, plots=args.plots, command=command)
            files.publish(folder, content, file.name)
    verdict = json.loads(content["verdict.json"])
    verdict["reasons"] += body_lines(found.advice)
    lines = screen.case_lines(found, chosen, verdict)
    seconds = time.perf_counter() - began
    results[folder.name] = _judged(folder.name, verdict, content, STORED, seconds)
    return _print_screen(case.name, verdict, lines, folder, [f"{seconds:.1f} s"], args)


def _judged(
    name: str,
    verdict: Mapping[str, Any],
    content: Mapping[str, bytes],
    stored: Sequence[str],
    seconds: float,
) -> gating.Judged:
    """Return a judged case or field: its verdict, then one row per quantity."""
    word, band = verdict["verdict"], verdict["band"]
    rows = [gating.row("verdict", "verdict", word, " ".join(verdict["reasons"]))]
    for each in verdict["quantities"]:
        candidate = next(each[key] for key in ("springs", "found") if key in each)
        reference = next(each[key] for key in ("elasticity", "wanted") if key in each)
        numbers = {"observed": candidate, "reference": reference, "error": each["difference"]}
        kind = each["quantity"], each["verdict"], verdict["headline"]
        rows.append(gating.row("agreement", *kind, **numbers, limit=band, unit=each["unit"]))
    frame = pd.DataFrame(rows).astype(dict.fromkeys(("observed", "reference", "error"), float))
    tables = {each: pd.read_csv(BytesIO(content[f"{each}.csv"])) for each in stored}
    return gating.Judged(name, frame, verdict, tables, seconds=seconds)


def _print_screen(
    name: str,
    verdict: Mapping[str, Any],
    lines: Sequence[str],
    folder: Path,
    notes: Sequence[str],
    args: argparse.Namespace,
) -> int:
    """Print a first screen, reasons if they are requested, and notes; return the exit code."""
    word = verdict["verdict"]
    if not (args.quiet or args.json):
        reasons = [f"  {each}" for each in verdict["reasons"]] if args.verbose else []
        print_lines([*lines, f"page: {folder / PAGE}", *reasons])
    for note in notes if not args.quiet else [word] if word != AGREES else []:
        tell(f"{name}: {note}")
    return _code(word)


def _code(word: str) -> int:
    """Exit code of a verdict."""
    return HELD if word == AGREES else MISSED


@overflowing
def judge_file(args: argparse.Namespace) -> int:
    """Displacements from a file beside a case's elasticity."""
    folder = args.out / files.folder_name(f"{args.file.stem}-{args.result.stem}")
    gating.refuse_outputs(args, gating.CASES)
    failing = gating.failures(args, folder.name)
    with failing, of_case(args.file), progress_of(args.file, folder, args):
        with contextlib.suppress(ValueError):
            args.unit = float(args.unit)
        unit = places.unit_in_metres("--unit", args.unit)
        if args.at_rest is not None:
            finite_number("--at-rest", args.at_rest, least=0.0)
        whose = f"{args.file.name} and {args.result.name}"
        files.refuse_foreign(folder, whose)
        case = building.read_case(args.file)
        result = read_result(args.result, case.problem.domain.dim, args.field)
        if args.accuracy is not None:
            result = replace(result, accuracy=args.accuracy)
        return judge_and_tell(
            case,
            result,
            folder,
            whose,
            args,
            unit=unit,
            residual_motion=args.at_rest,
            command=COMMAND,
            network=args.network,
        )


def judge_and_tell(
    case: Case,
    result: Result,
    folder: Path,
    whose: str,
    args: argparse.Namespace,
    notes: Sequence[str] = (),
    first: Sequence[str] = (),
    **options: Any,
) -> int:
    """Judge displacements with options of `run.judged_files`, write the files and the verdict.

    The sentences `first` are printed after the verdict.
    """
    began = time.perf_counter()
    found, content = run.judged_files(case, result, plots=args.plots, **options)
    files.publish(folder, content, whose)
    verdict = json.loads(content["verdict.json"])
    first = (*first, *verdict.get("network", {}).get("sentences", ()))
    lines = screen.field_lines(found, verdict, first)
    notes = (*notes, *found.matched.notes)
    code = _print_screen(result.name, verdict, lines, folder, notes, args)
    seconds = time.perf_counter() - began
    judged = _judged(folder.name, verdict, content, STORED[:1], seconds)
    return gating.conclude(args, gating.CASES, [judged], code)


def _sweep(args: argparse.Namespace) -> int:
    """Every combination of keys' values, as rows of one table; the exit code of its worst row."""
    values = sweep.read_values(args.set)
    limit = positive_number("--limit", args.limit, "s")
    whole_number("--jobs", args.jobs, 1, 1000)
    requests = {each.key: each for each in sweep.combinations(args.files, values)}
    stem = "sweep" if len(args.files) > 1 else f"{files.folder_name(args.files[0].stem)}-sweep"
    folder = args.out / stem
    files.claim(folder, SWEPT, ", ".join(dict.fromkeys(each.label for each in requests.values())))
    rows, damaged = sweep.read_rows(folder / sweep.ROWS, requests)
    for path in damaged:
        tell(f"{path}: no record of a row; the combination is solved again")
    todo = [(each, key) for key, each in requests.items() if key not in rows]
    here = partial(Workers, args.jobs, sweep.program_stamp)
    start = partial(Cluster, args.scheduler) if args.scheduler else here
    ended = run_all(sweep.solve, todo, start(), limit) if todo else ()
    began, known = time.perf_counter(), len(rows)
    try:
        with progress_of(Path(stem), folder, args):
            report_step("combinations, %d of %d known", known, len(requests))
            for (one, key), future in ended:
                rows[key] = row = sweep.finished_row(future)
                sweep.write_row(folder / sweep.ROWS, key, row)
                done, count = len(rows), len(requests)
                if not args.quiet:
                    words = ", ".join(f"{name} {value}" for name, value in one.values)
                    what = row.verdict or f"{row.outcome}: {row.message}"
                    tell(f"{done}/{count} {one.label} {words}: {what}, {row.seconds} s")
                left = (time.perf_counter() - began) / (done - known) * (count - done)
                report_step("combinations, %d of %d known, about %.0f s left", done, count, left)
    finally:  # also of those that are known when the scheduler is lost
        table = sweep.sweep_table(requests, rows)
        exchange.replace_file(folder / "sweep.csv", partial(csv_bytes, table))
    for name in SWEPT[2:]:  # of an earlier table
        (folder / name).unlink(missing_ok=True)
    if args.plots and (table["outcome"] == sweep.SOLVED).any():
        draw = partial(sweep.draw_sweep, table, list(values))
        for name, content in draw_files("sweep", "Springs beside elasticity", draw).items():
            exchange.replace_file(folder / name, partial(bytes, content))
    counts = ", ".join(f"{n} {word}" for word, n in table["outcome"].value_counts().items())
    tell(f"{len(requests)} combinations: {counts}; {folder / 'sweep.csv'}")
    return max(SWEEP_CODES.get(row.outcome, _code(row.verdict)) for row in rows.values())
