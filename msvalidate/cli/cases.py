"""What ``msvalidate case`` does: new, run, judge, export, schema."""

from __future__ import annotations

import argparse
import json
import math
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from msvalidate.case import (
    building,
    files,
    network_files,
    page,
    places,
    results,
    run,
    springs,
    sweep,
)
from msvalidate.case.body_advice import body_lines
from msvalidate.case.case import Case, spacing_of
from msvalidate.case.judge import Judgement
from msvalidate.case.schema import json_schema
from msvalidate.case.template import template
from msvalidate.cli.arguments import FAILED, HELD, MISSED, PROGRAM, USAGE
from msvalidate.cli.case_arguments import SIMULATOR
from msvalidate.cli.terminal import announce_compilation, print_lines, tell, tell_error
from msvalidate.output.stored import csv_bytes, draw_files
from msvalidate.problem import ProblemError, SolverError
from msvalidate.problem.checks import finite_number, format_value, positive_number, whole_number
from msvalidate.problem.records import replace
from msvalidate.simulators.exchange.export import export_case, lammps_of, ratio_words
from msvalidate.simulators.exchange.folders import write_request
from msvalidate_check import exchange
from msvalidate_check.words import AGREES


def act(args: argparse.Namespace) -> int:
    """Do what the command line asks for; return the exit code."""
    if not getattr(args, "quiet", True):
        announce_compilation()
    acts = {"new": _new, "run": _run, "judge": _judge, "export": _export, "schema": _schema}
    with np.errstate(over="ignore", invalid="ignore"):  # what overflows is refused in words
        return acts[args.command](args)


def _new(args: argparse.Namespace) -> int:
    name = Path(args.name).name.removesuffix(".toml")
    bad = not name.strip(" .") or not name.isprintable() or '"' in name or "\\" in name
    if bad:
        raise ProblemError(
            f"case new: {format_value(args.name)} is no name; give letters and digits"
        )
    path = new_path("case new", Path(args.name).parent / f"{name}.toml")
    exchange.replace_file(path, lambda: template(path.name, name).encode())
    tell(f"{path} written; change it, then: {PROGRAM} case run {path}")
    return HELD


def new_path(said: str, path: Path) -> Path:
    """The path of a file to be written; raise `ProblemError` if it is taken or has no folder."""
    if path.exists() or path.is_symlink():
        raise ProblemError(f"{said}: {path} is there already; give another name")
    if not path.parent.is_dir():
        raise ProblemError(f"{said}: no folder {path.parent}; make it first")
    return path


def _schema(args: argparse.Namespace) -> int:
    made = network_files.network_schema() if args.network else json_schema()
    return print_lines([json.dumps(made, indent=2)])


def _export(args: argparse.Namespace) -> int:
    """Write what a simulator is asked, or the case's springs."""
    try:
        case = building.read_case(args.file)
        own = {"case.toml": args.file.read_bytes()}
        if args.to != SIMULATOR:
            return _export_springs(case, args, own)
        request = export_case(
            case, cells=args.cells, shape=args.shape, springs=args.springs, settings=dict(args.set)
        )
        if args.springs:
            tell_ratio(case)
        write_request(request, args.folder, own)
    except ProblemError as error:
        return tell_error(said(args.file, error), USAGE)
    except SolverError as error:
        return tell_error(said(args.file, error), FAILED)
    tell(f"{args.folder}: {request.mesh}, {len(request.mesh.points)} nodes")
    return HELD


def _export_springs(case: Case, args: argparse.Namespace, own: dict[str, bytes]) -> int:
    """Write a case's springs at rest as tables, JSON, or for LAMMPS."""
    for name in ("shape", "springs", "set"):
        if getattr(args, name):
            raise ProblemError(f"--{name}: is of --to {SIMULATOR}; with {args.to} leave it out")
    files.refuse_foreign(args.folder, args.file.name)
    if args.cells is not None:
        case = replace(case, cells=args.cells, spacing=None)
    if args.to == "lammps":
        tell_ratio(case)
        answer, content = lammps_of(case)
    else:
        answer = springs.solve_springs(case, spacing_of(case))
        every = network_files.network_files(answer, case)
        content = {name: each for name, each in every.items() if name.endswith(".csv")}
        if args.to == "json":
            content = {"network.json": network_files.network_json(answer, case)}
    files.publish(args.folder, content | own, args.file.name)
    count = f"{len(answer.network.points)} points, {len(answer.network.springs)} springs"
    tell(f"{args.folder}: {answer.lattice.name}, {count}, {len(answer.network.resisting)} cells")
    return HELD


def tell_ratio(case: Case) -> None:
    """Say what the ratio of springs alone costs, if it is another than the case's."""
    words = ratio_words(case)
    if words:
        tell(f"{case.name}: {words}")


def _run(args: argparse.Namespace) -> int:
    """Each case in turn: one that is refused does not keep the others from being solved."""
    if args.set:
        return _sweep(args)
    codes = []
    folders: dict[str, Path] = {}
    for file in args.files:
        name = files.folder_name(file.stem)
        if name in folders:
            text = f"case {file.name}: results of {folders[name]} go to the same folder {name}"
            codes.append(tell_error(f"{text}; run it with another --out", USAGE))
            continue
        folders[name] = file
        try:
            files.refuse_foreign(args.out / name, file.name)
            codes.append(_solve(building.read_case(file), args.out / name, file.name, args))
        except ProblemError as error:
            codes.append(tell_error(said(file, error), USAGE))
        except SolverError as error:
            codes.append(tell_error(said(file, error), FAILED))
    return max(codes)


def _sweep(args: argparse.Namespace) -> int:
    """Every combination of keys' values, as rows of one table; exit code 3 if one died."""
    values = sweep.read_values(args.set)
    limit = positive_number("--limit", args.limit, "s")
    whole_number("--jobs", args.jobs, 1, 1000)
    name = "sweep" if len(args.files) > 1 else f"{files.folder_name(args.files[0].stem)}-sweep"
    folder = args.out / name
    count = len(args.files) * math.prod(map(len, values.values()))
    next(sweep.combinations(args.files, values))

    def asked() -> Iterator[sweep.Combination]:
        return sweep.combinations(args.files, values)

    def workers() -> sweep.Workers | sweep.Cluster:
        return sweep.Cluster(args.scheduler) if args.scheduler else sweep.Workers(args.jobs)

    def show(done: int, one: sweep.Combination, row: sweep.Row) -> None:
        if not args.quiet:
            said = ", ".join(f"{key} {value}" for key, value in one.values)
            what = row["verdict"] or f"{row['outcome']}: {row['said']}"
            tell(f"{done}/{count} {one.file.name} {said}: {what}, {row['seconds']} s")

    table = sweep.sweep(asked, folder / "journal.jsonl", workers, limit, show)
    exchange.replace_file(folder / "sweep.csv", lambda: csv_bytes(table))
    if args.plots and (table["outcome"] == sweep.SOLVED).any():
        drawn = draw_files("sweep", "Springs beside elasticity", lambda: sweep.draw_sweep(
            table, list(values)))  # fmt: skip
        for file, content in drawn.items():
            exchange.replace_file(folder / file, lambda content=content: content)  # type: ignore[misc]
    counts = table["outcome"].value_counts().to_dict()
    tell(f"{count} combinations: {', '.join(f'{n} {word}' for word, n in counts.items())}; "
         f"{folder / 'sweep.csv'}")  # fmt: skip
    return FAILED if {sweep.DIED, sweep.LATE} & set(counts) else HELD


def _judge(args: argparse.Namespace) -> int:
    """Displacements from a file beside a case's elasticity."""
    try:
        unit = _unit(args.unit)
        if args.at_rest is not None:
            finite_number("--at-rest", args.at_rest, least=0.0)
        folder = args.out / files.folder_name(f"{args.file.stem}-{args.result.stem}")
        whose = f"{args.file.name} and {args.result.name}"
        files.refuse_foreign(folder, whose)
        case = building.read_case(args.file)
        result = results.read_result(args.result, case.problem.domain.dim, args.field)
        if args.accuracy is not None:
            known = finite_number("--accuracy", args.accuracy, least=0.0)
            result = replace(result, accuracy=known)
        show = Progress(case.name, shown=not args.quiet)
        command = ("msvalidate", "case", "judge", "FILE", "RESULT")
        found, content = run.judged_files(
            case,
            result,
            unit=unit,
            residual_motion=args.at_rest,
            plots=args.plots,
            command=command,
            progress=show,
        )
    except SolverError as error:
        return tell_error(said(args.file, error), FAILED)
    except ProblemError as error:
        text = str(error)
        return tell_error(text if text.startswith("result ") else said(args.file, error), USAGE)
    files.publish(folder, content, whose)
    show.clear()
    return tell_judged(found, folder, quiet=args.quiet)


def tell_judged(found: Judgement, folder: Path, *, quiet: bool) -> int:
    """Say what displacements are beside elasticity; return the exit code."""
    result, word = found.result, found.row.verdict
    if not quiet:
        head, reasons = page.judged_sentences(found)
        lines = [f"{result.name}: {word}", f"  {head}", *(f"  {each}" for each in reasons)]
        print_lines(lines)
        for note in found.matched.notes:
            tell(f"{result.name}: {note}")
        tell(f"{result.name}: {folder / 'case.html'}")
    elif word != AGREES:
        tell(f"{result.name}: {word}")
    return HELD if word == AGREES else MISSED


def _unit(given: str) -> float:
    """A unit by name, or as a number in m."""
    try:
        return places.unit_in_metres("--unit", float(given))
    except ValueError:
        return places.unit_in_metres("--unit", given)


def said(file: Path, error: Exception) -> str:
    """An error that names the case file."""
    text = " ".join(str(error).split())
    named = text.startswith(("case ", "adapter", "answer: ", "folder "))
    return text if named else f"case {file.name}: {text}"


def _solve(case: Case, folder: Path, whose: str, args: argparse.Namespace) -> int:
    began = time.perf_counter()
    command = ("msvalidate", "case", "run", "FILE")
    show = Progress(case.name, shown=not args.quiet)
    found, content = run.case_files(case, plots=args.plots, command=command, progress=show)
    files.publish(folder, content, whose)
    show.clear()
    word = page.overall(found.rows)
    if not args.quiet:
        told = json.loads(content["verdict.json"])
        more = (told["sentence"], *told["reasons"], *body_lines(found.advice))
        print_lines([f"{case.name}: {word}", *(f"  {each}" for each in more)])
        tell(f"{case.name}: {time.perf_counter() - began:.1f} s, {folder / 'case.html'}")
    elif word != AGREES:
        tell(f"{case.name}: {word}")
    return HELD if word == AGREES else MISSED


class Progress:
    """What is being done, in one line that is written over; nothing where nobody looks."""

    def __init__(self, name: str, *, shown: bool) -> None:
        self._name = name
        self._shown = shown and sys.stderr.isatty()

    def __call__(self, step: str) -> None:
        """Say what is being done now."""
        if self._shown:
            sys.stderr.write(f"\r\033[K{self._name}: {step} ...")
            sys.stderr.flush()

    def clear(self) -> None:
        """Take the line away."""
        if self._shown:
            sys.stderr.write("\r\033[K")
            sys.stderr.flush()
