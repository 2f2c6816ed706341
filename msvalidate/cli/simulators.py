"""Commands ``msvalidate simulate`` and ``msvalidate adapter``."""

from __future__ import annotations

import argparse
import hashlib
import json
import math
import textwrap
from collections.abc import Mapping
from dataclasses import replace
from datetime import UTC, datetime
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd

from msvalidate.bench.judging import catalogue
from msvalidate.bench.output.provenance import collect_provenance
from msvalidate.case.file import building
from msvalidate.case.file.case import Case
from msvalidate.case.judge.results import Result
from msvalidate.case.report import files
from msvalidate.cli import gating
from msvalidate.cli.arguments import FAILED, HELD, MISSED, NOTHING, UNCONVERGED
from msvalidate.cli.cases import judge_and_tell, of_case, overflowing, progress_of, request_of
from msvalidate.cli.progress import Progress, log_path
from msvalidate.cli.terminal import naming, print_lines, tell, tell_error
from msvalidate.problem import Array, Isotropic, ProblemError
from msvalidate.problem.checks import finite_number, format_value
from msvalidate.problem.material import State
from msvalidate.problem.progress import report_step
from msvalidate.simulators.bodies.blocks import RATIOS
from msvalidate.simulators.bodies.laws import LAWS, law_named, predicted
from msvalidate.simulators.exchange.asked import Asked, NoAnswerError
from msvalidate.simulators.exchange.export import on_mesh
from msvalidate.simulators.exchange.program import LOG, OUT, Program, label_of
from msvalidate.simulators.exchange.protocol import (
    ROUNDING,
    Answer,
    CannotRepresent,
    Request,
    SimulatorError,
    stated_residual_motion,
)
from msvalidate.simulators.gate.gate import convergence_tests
from msvalidate.simulators.gate.rows import LENGTH, MOVING, PASSED, STEP, STOPPED, TOLD
from msvalidate.simulators.probe.reading import BAND
from msvalidate.simulators.verdict.causes import convergence_causes
from msvalidate.simulators.verdict.judgement import PARTS, Judgement, judge_simulator
from msvalidate.simulators.verdict.lattice import declared_cells, judge_lattice, with_lattice
from msvalidate.simulators.verdict.page import PAGE, sheet_files
from msvalidate.simulators.verdict.record import json_of, record_of
from msvalidate.simulators.verdict.sentences import text_of
from msvalidate.simulators.verdict.sheet import sheet_of
from msvalidate.springs.constants.stiffness import CAUCHY
from msvalidate_check.checking import ACCURACY
from msvalidate_check.text import WIDTH
from msvalidate_check.verdict import AGREES, NOT_AT_REST, NOT_RESOLVED

GATE, BODIES = ["question", "verdict"], ["body", "mesh", "error", "unexplained"]
"""Columns of the tables that a baseline stores."""
THICKNESS = 0.2
"""Thickness (m) of plane bodies: any but 1, which hides that it is forgotten."""
TETRA_RATIO = 0.3
"""Default ratio of elements."""
RUN = "-run"
"""End of the name of the folder in which the latest question stays, beside its page."""


@overflowing
def simulate(args: argparse.Namespace) -> int:
    """Ask, judge, and write the page; what the adapter left stays beside it."""
    told = [f"{name}={json.dumps(value)}" for name, value in sorted(dict(args.setting).items())]
    folder = args.out / _name(args, told)
    gating.refuse_outputs(args, gating.CASES)
    failing = gating.failures(args, folder.name)
    with failing, of_case(args.file), progress_of(args.file, folder, args):
        whose = " ".join([f"{args.file.name} and {format_value(args.adapter)}", *told])
        files.refuse_foreign(folder, whose)
        kept = folder.with_name(f"{folder.name}{RUN}")
        program = Program(args.adapter, args.limit, kept)
        case = building.read_case(args.file)
        request = request_of(case, args)
        report_step("simulator, 1 question; judging is left")
        try:
            answer = program(request)
        except CannotRepresent as error:
            code = tell_error(f"{args.file.name}: cannot represent: {error}", NOTHING)
            unanswered = gating.unfinished(folder.name, f"cannot represent: {error}")
            return gating.conclude(args, gating.CASES, [unanswered], code)
        except SimulatorError as error:
            error.args = (f"{error} ({kept / OUT / LOG})",)
            raise
        first = _convergence(args, request, answer)
        result, motion = _result(request, answer), stated_residual_motion(request, answer)
        return judge_and_tell(
            _described(case, request, answer, first),
            result,
            folder,
            whose,
            args,
            notes=(str(kept / OUT),),
            first=first,
            residual_motion=None if math.isnan(motion) else motion,
            command=("msvalidate", "simulate", "CASE", "--with", "ADAPTER"),
        )


def _name(args: argparse.Namespace, told: list[str]) -> str:
    """Name of the results folder for a case, adapter and settings."""
    name = f"{files.folder_name(args.file.stem)}-{files.folder_name(label_of(args.adapter))}"
    name = files.folder_name("-".join([name, *told]).replace("=", "-").replace('"', ""))
    if not told:
        return name
    mark = hashlib.sha256("\0".join(told).encode()).hexdigest()[:8]
    return f"{name[: files.LONGEST_FOLDER - 9]}-{mark}"


def _result(request: Request, answer: Answer) -> Result:
    """An answer as what is read from files of displacements."""
    move, points = np.asarray(answer.displacement), np.array(request.mesh.points)
    name = _line(answer.about.get("simulator", "simulator"))
    accuracy = ROUNDING.get(str(answer.about.get("precision")), 0.0)  # of positions
    accuracy *= float(np.abs(points + move).max() / (np.abs(move).max() or 1.0))

    def elements(nu: float) -> Array:
        return on_mesh(request, replace(request.material, nu=nu))

    known = {f"linear elements on its {request.mesh.shape} mesh": elements}
    return Result(name, move, points, None, math.nan, accuracy or ACCURACY, known)


def _convergence(args: argparse.Namespace, request: Request, answer: Answer) -> tuple[str, ...]:
    """Sentences on a displacement that depends on the time step.

    Explicit programs come to a rest that depends on neither, so that they are not asked again.
    """
    if answer.about.get("forces_at") != "end":
        return ()
    tests = convergence_tests(Program(args.adapter, args.limit), request, answer)
    return tuple(map(str, convergence_causes(tests)))


def _described(case: Case, request: Request, answer: Answer, first: tuple[str, ...]) -> Case:
    """The case with what its page tells of the simulator."""
    told = {"convergence": " ".join(first), **answer.about}
    for name, (value, unit) in told.pop("settings", {}).items():
        told[f"setting {_line(name)}"] = f"{value} {unit}".strip()
    told["nodes"] = f"{len(request.mesh.points)} of {len(request.mesh.cells)} {request.mesh.shape}"
    shown = {key.replace("_", " "): _line(value) for key, value in told.items() if value}
    return replace(case, notes={**case.notes, **shown})


def _line(value: object) -> str:
    """A value in one short line."""
    if isinstance(value, Mapping):
        value = ", ".join(f"{key} {each}" for key, each in value.items())
    if isinstance(value, list):
        value = " ".join(map(str, value))
    text = " ".join(str(value).split())
    return "".join(c for c in text if c.isprintable())[:300]


def print_laws(_args: argparse.Namespace) -> int:
    """Names that --law takes, each with what it is to first order for E = 1 and nu = 0.3."""
    width, wide = max(map(len, LAWS)), max(len(law.key) for law in LAWS.values())
    lines = [f"{'--law':<{wide}}  {'law':<{width}}  E ratio  nu"]
    for name, each in LAWS.items():
        law, E, nu = predicted(name, 1.0, 0.3), "none", "none"
        if law.E is not None and law.nu is not None:
            E, nu = f"{law.E:.4f}", f"{round(law.nu, 4) + 0.0:.4f}"
        lines.append(f"{each.key:<{wide}}  {name:<{width}}  {E:<7}  {nu}")
    return print_lines(lines)


@overflowing
def check_adapter(args: argparse.Namespace) -> int:
    """Test a simulator with ten to two hundred questions, write the results and report them."""
    with naming("adapter check"):
        name = label_of(args.adapter)
        args.law = _known_law(args.law)
        gating.refuse_outputs(args, gating.SIMULATORS)
        folder = _folder_of_check(args, name)
        kept = folder and folder.with_name(f"{folder.name}{RUN}")
        if args.ratio is not None:
            finite_number("--nu", args.ratio, least=RATIOS[0], most=RATIOS[1])
        parts = tuple(args.only or PARTS)
        log = folder and log_path(folder)
        program = Program(args.adapter, args.limit, kept)
        asked = Asked(program, parts)
        started, settings, probed = datetime.now(UTC), dict(args.setting), dict(args.probe_setting)
        try:
            with Progress(name, shown=not args.quiet, log=log):
                cells, dim = declared_cells(program)
                material = _material(args, cells, dim)
                if cells == "tetra":
                    found = judge_simulator(
                        asked, material, settings, law=args.law, probed=probed, parts=parts
                    )
                    found = with_lattice(found, asked, settings | probed)
                else:
                    found = judge_lattice(asked, cells, material, settings, parts=parts)
                sheet = sheet_of(found, asked, parts)
                record = {"adapter": name, "law": args.law, "word": sheet.word, **record_of(found)}
                seconds = (datetime.now(UTC) - started).total_seconds()
                if folder is not None:
                    report_step("page")
                    command = ("msvalidate", "adapter", "check", "ADAPTER")
                    origin = collect_provenance(command, 0, started, seconds, form="check")
                    shown = {key: str(value) for key, value in settings.items()}
                    own = sheet_files(name, found, sheet, shown, origin, plots=args.plots)
                    text = f"{json_of(record)}\n".encode()
                    files.publish(folder, {**own, "check.json": text}, format_value(args.adapter))
        except NoAnswerError as error:
            where = f" ({kept / OUT / LOG})" if kept else ""
            code = tell_error(f"{name}: {error}{where}", FAILED)
            return gating.conclude(
                args, gating.SIMULATORS, [gating.unfinished(name, str(error))], code
            )
    code = _code(found, asked)
    if args.quiet and code != HELD:
        tell(f"{name}: {sheet.word}")
    elif code == NOTHING:
        tell_error(f"{name}: cannot represent: {asked.refusals[-1]}", NOTHING)
    elif not (args.quiet or args.json):
        wrap = partial(textwrap.wrap, width=WIDTH, subsequent_indent="    ", break_on_hyphens=False)
        print_lines([each for line in sheet.lines(name) for each in wrap(line) or [""]])
    if folder is not None and not args.quiet:
        tell(f"{name}: {folder / PAGE}")
    result = _judged(name, found, sheet.word, accepted=code == HELD)
    failure = sheet.word if code in (FAILED, NOTHING) else ""
    result = replace(result, record=record, seconds=seconds, error=failure)
    return gating.conclude(args, gating.SIMULATORS, [result], code)


def _code(judgement: Judgement, questions: Asked) -> int:
    """Return the exit code of a judged simulator.

    A documented law (`--law`) that the simulator meets is accepted in place of the requested solid.
    """
    if questions.failures or not questions.answers:
        return FAILED if questions.failures else NOTHING
    if judgement.word == AGREES or judgement.is_accepted:
        return HELD
    first = judgement.causes[0].kind if judgement.causes else ""
    return UNCONVERGED if judgement.word == NOT_AT_REST or first in (LENGTH, STEP) else MISSED


GATE_WORDS = {PASSED: "pass", TOLD: "pass", STOPPED: "fail", MOVING: NOT_AT_REST}
"""Verdict of a row of the gate -> verdict of a judged quantity."""
BASELINE_TOLERANCE = 1e-3
"""Tolerance of a baseline, relative to E, to 1 and to the largest displacement.

A fifth of the error of a reading, and above the rounding of single precision."""


def _judged(name: str, judgement: Judgement, word: str, *, accepted: bool) -> gating.Judged:
    """Return the rows of a simulator, and the tables that a baseline stores of it."""
    because = " ".join([word, *(each.said for each in judgement.causes)])
    rows = [gating.row("verdict", "verdict", "pass" if accepted else "fail", because)]
    rows += [
        gating.row(
            "gate",
            each.name,
            GATE_WORDS.get(each.verdict, NOT_RESOLVED),
            text_of(each.because),
            observed=each.value,
            reference=0.0,
            error=each.value,
            limit=each.limit,
        )
        for each in judgement.gate.rows
    ]
    E, nu = judgement.predicted or (judgement.asked.E, judgement.asked.nu)
    gated = [(each.name, each.verdict) for each in judgement.gate.rows]
    tables = {"gate": pd.DataFrame(gated, columns=GATE)}
    expected = {"E": E, "nu": nu, "zener": 1.0, "weight": 0.5}
    rounding = dict.fromkeys((*expected, *BODIES[2:]), BASELINE_TOLERANCE)
    rounding["E"] *= E
    moduli = _moduli(judgement)
    for key, value in moduli.items():
        error = abs(value - expected[key]) / (E if key == "E" else 1.0)
        rows.append(
            gating.row(
                "law",
                key,
                "pass" if error <= BAND else "fail",
                word,
                observed=value,
                reference=expected[key],
                error=error,
                limit=BAND,
                unit="Pa" if key == "E" else "1",
            )
        )
    if moduli:
        tables["law"] = pd.DataFrame([moduli])
    bodies = []
    for each in judgement.bodies:
        part = math.nan if each.factors is None else each.factors.apart
        bodies.append((each.body, each.mesh, each.error, part))
        verdict = "pass" if each.is_explained or each.is_rounded else "fail"
        numbers = {"observed": part, "reference": 0.0, "error": part, "limit": BAND}
        rows.append(gating.row("body", f"{each.body}, {each.mesh}", verdict, word, **numbers))
    for lattice in judgement.lattice.bodies if judgement.lattice else ():
        part, away = lattice.residual, lattice.errors.get("elasticity", math.nan)
        if math.isfinite(part + away):
            bodies.append((lattice.load, "lattice", away, part))
    if bodies:
        tables["bodies"] = pd.DataFrame(bodies, columns=BODIES)
    return gating.Judged(name, pd.DataFrame(rows), {}, tables, rounding)


def _moduli(judgement: Judgement) -> dict[str, float]:
    """Return the measured moduli, of a lattice also its Zener ratio and boundary weight."""
    law, lattice = judgement.reading, judgement.lattice
    if lattice is not None:
        known = lattice.springs.misfit <= BAND and math.isfinite(lattice.springs.weight)
        return vars(lattice.mean) | ({"weight": lattice.springs.weight} if known else {})
    known = law is not None and law.E is not None and law.nu is not None
    return {"E": law.E, "nu": law.nu} if known else {}  # type: ignore[union-attr, dict-item]


def _material(args: argparse.Namespace, cells: str, dim: int) -> Isotropic:
    """Material of a check; the default ratio of lattices is that of springs alone."""
    ratio = args.ratio
    if ratio is None:
        ratio = TETRA_RATIO if cells == "tetra" else CAUCHY[dim]
    state: tuple[State, float] = ("solid", 1.0) if dim == 3 else ("plane_stress", THICKNESS)
    return Isotropic(args.modulus, ratio, state[0], args.density, state[1])


def _known_law(given: str) -> str:
    law = law_named(given)
    if law and law not in LAWS:
        hint = catalogue.suggestion(law, [each.key for each in LAWS.values()])
        raise ProblemError(f"--law {format_value(law)}: not known; {hint}; see adapter laws")
    return law


def _folder_of_check(args: argparse.Namespace, name: str) -> Path | None:
    """Folder of the page, if it is writable."""
    if args.out is None:
        return None
    folder: Path = args.out / files.folder_name(f"{name}-check")
    files.refuse_foreign(folder, format_value(args.adapter))
    return folder
