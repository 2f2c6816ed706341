"""What ``msvalidate simulate`` and ``msvalidate adapter`` do."""

from __future__ import annotations

import argparse
import hashlib
import json
import math
import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from msvalidate.case import building, files, run
from msvalidate.case.case import Case
from msvalidate.case.results import Result
from msvalidate.cli.adapter_check import Steps, check_adapter, tell_laws
from msvalidate.cli.arguments import FAILED, HELD, NOTHING, PROGRAM, USAGE
from msvalidate.cli.cases import new_path, said, tell_judged, tell_ratio
from msvalidate.cli.terminal import tell, tell_error
from msvalidate.problem import ProblemError, SolverError
from msvalidate.problem.checks import format_value
from msvalidate.simulators.exchange.export import export_case, on_mesh
from msvalidate.simulators.exchange.program import LOG, OUT, Program, label_of
from msvalidate.simulators.exchange.protocol import (
    Answer,
    CannotRepresent,
    Request,
    stated_residual_motion,
)
from msvalidate.simulators.exchange.template import adapter_template
from msvalidate.simulators.probe.bench import ROUNDING
from msvalidate_check import exchange
from msvalidate_check.checking import ACCURACY

COMMAND = ("msvalidate", "simulate", "CASE", "--with", "ADAPTER")
RUN = "-run"
"""End of the name of the folder that a run is kept in, beside its results."""


def act(args: argparse.Namespace) -> int:
    """Do what the command line asks for; return the exit code."""
    with np.errstate(over="ignore", invalid="ignore"):  # what overflows is refused in words
        if args.command == "simulate":
            return _simulate(args)
        acts: dict[str, Callable[[], int]] = {
            "new": lambda: _new(args),
            "check": lambda: _check(args),
            "laws": tell_laws,
        }
        return acts[args.act]()


def _check(args: argparse.Namespace) -> int:
    try:
        return check_adapter(args)
    except ProblemError as error:
        return tell_error(f"adapter check: {error}", USAGE)


def _new(args: argparse.Namespace) -> int:
    name = Path(args.name).name.removesuffix(".py")
    if not name or files.folder_name(name) != name:
        raise ProblemError(
            f"adapter new: {format_value(args.name)} is no name; give letters, digits, - and _"
        )
    path = new_path("adapter new", Path(args.name).parent / f"{name}.py")
    exchange.replace_file(path, lambda: adapter_template(name).encode())
    tell(f"{path} written; it runs as it is: {PROGRAM} adapter check {path}")
    return HELD


def _simulate(args: argparse.Namespace) -> int:
    """Ask, judge, and write the page; what the adapter left stays beside it."""
    try:
        folder = args.out / _name(args)
        whose = " ".join([f"{args.file.name} and {format_value(args.adapter)}", *_told(args)])
        files.refuse_foreign(folder, whose)
        kept = folder.with_name(f"{folder.name}{RUN}")
        program = Program(args.adapter, args.limit, kept)
        case = building.read_case(args.file)
        request = export_case(
            case, cells=args.cells, shape=args.shape, springs=args.springs, settings=dict(args.set)
        )
        if args.springs and not args.quiet:
            tell_ratio(case)
        show = Steps(case.name, shown=not args.quiet)
        show("simulator; judging is left")
        began = time.perf_counter()
        answer = program(request)
        show.done(f"simulator, 1 question: {time.perf_counter() - began:.2g} s; judging is left")
        show("judging")
        result, residual_motion = _result(request, answer), stated_residual_motion(request, answer)
        found, content = run.judged_files(
            _described(case, request, answer),
            result,
            residual_motion=None if math.isnan(residual_motion) else residual_motion,
            plots=args.plots,
            command=COMMAND,
            progress=show,
        )
    except CannotRepresent as error:
        return tell_error(f"{args.file.name}: cannot represent: {error}", NOTHING)
    except SolverError as error:
        text = said(args.file, error)
        log = kept / OUT / LOG
        return tell_error(f"{text} ({log})" if log.is_file() else text, FAILED)
    except ProblemError as error:
        return tell_error(said(args.file, error), USAGE)
    files.publish(folder, content, whose)
    show.clear()
    if not args.quiet:
        tell(f"{result.name}: {kept / OUT}")
    return tell_judged(found, folder, quiet=args.quiet)


def _told(args: argparse.Namespace) -> list[str]:
    """Settings as words, in one order."""
    return [f"{name}={json.dumps(value)}" for name, value in sorted(dict(args.set).items())]


def _name(args: argparse.Namespace) -> str:
    """Of the folder of results, one for each of case, adapter and settings."""
    name = f"{files.folder_name(args.file.stem)}-{files.folder_name(label_of(args.adapter))}"
    told = files.folder_name("-".join([name, *_told(args)]).replace("=", "-").replace('"', ""))
    if not args.set:
        return told
    mark = hashlib.sha256("\0".join(_told(args)).encode()).hexdigest()[:8]
    return f"{told[: files.LONGEST_FOLDER - 9]}-{mark}"


def _result(request: Request, answer: Answer) -> Result:
    """An answer as what is read from files of displacements."""
    move, points = np.asarray(answer.displacement), np.array(request.mesh.points)
    name = _line(answer.about.get("simulator", "simulator"))
    accuracy = ROUNDING.get(str(answer.about.get("precision")), 0.0)  # of positions
    accuracy *= float(np.abs(points + move).max() / (np.abs(move).max() or 1.0))
    known = {f"linear elements on its {request.mesh.shape} mesh": partial(on_mesh, request)}
    return Result(name, move, points, None, math.nan, accuracy or ACCURACY, known)


def _described(case: Case, request: Request, answer: Answer) -> Case:
    """The case with what its page tells of the simulator."""
    about = answer.about
    told = {key: _line(about[key]) for key in ("simulator", "version", "law") if about.get(key)}
    told["nodes"] = f"{len(request.mesh.points)} of {len(request.mesh.cells)} {request.mesh.shape}"
    settings: Mapping[str, Any] = about.get("settings", {})
    for name, (value, unit) in settings.items():
        told[f"setting {_line(name)}"] = _line(f"{value} {unit}".strip())
    for key in ("steps", "dt", "precision", "at_rest", "seconds", "notes"):
        if about.get(key):
            told[key.replace("_", " ")] = _line(about[key])
    return replace(case, notes={**case.notes, **told})


def _line(value: object) -> str:
    """A value in one short line."""
    if isinstance(value, Mapping):
        value = ", ".join(f"{key} {each}" for key, each in value.items())
    if isinstance(value, list):
        value = " ".join(map(str, value))
    text = " ".join(str(value).split())
    return "".join(c for c in text if c.isprintable())[:300]
