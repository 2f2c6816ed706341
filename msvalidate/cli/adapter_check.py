"""What ``msvalidate adapter check`` does: a simulator tried, its law read, its bodies judged."""

from __future__ import annotations

import argparse
from dataclasses import dataclass, field
from typing import Any

from msvalidate.cli.arguments import FAILED, HELD, MISSED, NOTHING, PROGRAM
from msvalidate.cli.cases import Progress
from msvalidate.cli.terminal import print_lines, tell_error
from msvalidate.problem import Isotropic, ProblemError
from msvalidate.problem.checks import format_value
from msvalidate.simulators.bodies import BodyRow
from msvalidate.simulators.causes import AGREES
from msvalidate.simulators.gate import PASSED, STOPPED, GateRow
from msvalidate.simulators.judgement import Judgement, judge_simulator
from msvalidate.simulators.laws import LAWS, predicted
from msvalidate.simulators.program import Program, label_of
from msvalidate.simulators.protocol import (
    Answer,
    CannotRepresent,
    OutOfTime,
    Request,
    SimulatorError,
)
from msvalidate.simulators.record import record_of, text_of
from msvalidate_check import exchange

TRIES = 3
"""Questions that fail one after another from the first on, before the rest is left unasked."""
NEXT = {
    "gate": "mend what stopped it; docs/simulators.md tells what each row asks for",
    "not explained": f"{PROGRAM} simulate CASE --with ADAPTER shows one body whole",
    "differs with cause": "if its documents say so, give --law NAME (see adapter laws)",
}
"""State -> what to do then."""


class NoAnswerError(Exception):
    """A simulator that answers nothing, or not in time; nothing can be said of it."""


@dataclass
class Asked:
    """A program that is not asked on where it leaves no hope, and what it was asked.

    Parameters
    ----------
    program, show
        Asked; told what is asked now.
    count, answers
        Of questions so far, and of those that were answered.
    refusals
        What it said that it cannot represent.
    """

    program: Program
    show: Progress
    count: int = 0
    answers: int = 0
    failures: int = 0
    refusals: list[str] = field(default_factory=list)

    def __call__(self, request: Request) -> Answer:
        """Ask; raise `NoAnswerError` where there is no sense in asking on."""
        self.count += 1
        self.show(f"question {self.count}, {request.task} of {request.name or 'a block'}")
        try:
            answer = self.program(request)
        except OutOfTime as error:
            raise NoAnswerError(f"question {self.count}, {request.task}: {error}") from error
        except CannotRepresent as error:
            self.refusals.append(str(error))
            raise
        except SimulatorError as error:
            self.failures += 1
            if not self.answers and self.failures >= TRIES:
                raise NoAnswerError(f"{TRIES} questions and no answer: {error}") from error
            raise
        self.answers += 1
        return answer


def tell_laws() -> int:
    """Names that --law takes, each with what it is to first order for E = 1 and nu = 0.3."""
    width = max(map(len, LAWS))
    lines = [f"{'law':<{width}}  E over asked  nu for 0.3"]
    for name in LAWS:
        law = predicted(name, 1.0, 0.3)
        none = law.E is None or law.nu is None
        E, nu = (
            ("none", "none") if none else (f"{law.E:.4f}", f"{round(law.nu or 0.0, 4) + 0.0:.4f}")
        )
        lines.append(f"{name:<{width}}  {E:>12}  {nu:>10}")
    return print_lines(lines)


def check_adapter(args: argparse.Namespace) -> int:
    """Ask fifty to two hundred questions and tell what came of them; the exit code."""
    if args.law and args.law not in LAWS:
        raise ProblemError(f"--law {format_value(args.law)}: not known; see adapter laws")
    if args.json is not None and not args.json.parent.is_dir():
        raise ProblemError(f"--json {args.json}: no folder {args.json.parent}; make it first")
    material = Isotropic(args.modulus, args.ratio, "solid", args.density)
    name = label_of(args.adapter)
    show = Progress(name, shown=not args.quiet)
    asked = Asked(Program(args.adapter, args.limit), show)
    try:
        found = judge_simulator(
            asked, material, dict(args.set), law=args.law, probed=dict(args.probe_set)
        )
    except NoAnswerError as error:
        show.clear()
        return tell_error(f"{name}: {error}", FAILED)
    finally:
        show.clear()
    if not asked.answers and asked.refusals and len(asked.refusals) == asked.count:
        return tell_error(f"{name}: cannot represent: {asked.refusals[-1]}", NOTHING)
    if args.json is not None:
        record = {"adapter": args.adapter, "law": args.law, **record_of(found)}
        exchange.replace_file(args.json, (text_of(record) + "\n").encode)
    code = HELD if found.state == AGREES else MISSED
    if args.quiet:
        return code
    return (
        print_lines([f"{name}: {found.state}", *_lines(found), f"{asked.count} questions asked"])
        or code
    )


def _lines(found: Judgement) -> list[str]:
    """All that is said of a simulator."""
    lines = [f"  {cause}" for cause in found.causes]
    lines += ["", "gate", *map(_gate_line, found.gate.rows)]
    lines += ["", "law", f"  asked       E {found.asked.E:.6g} Pa, nu {found.asked.nu:.4g}"]
    if found.predicted is not None:
        lines.append(f"  documented  E {found.predicted[0]:.6g} Pa, nu {found.predicted[1]:.4g}")
    if found.reading is not None:
        lines += [f"  {line}" for line in _reading_lines(found)]
    if found.bodies:
        lines += [
            "",
            f"{'bodies at rest':<40}{'error':>9}  owed to",
            *map(_body_line, found.bodies),
        ]
    if found.large is not None:
        large = found.large
        lines.append(
            f"  {large.case} at {large.strain:.1%} strain: {large.apart:.2%} from elements of its "
            f"law, which are {large.from_linear:.2%} from linear ones"
        )
    lines += ["", *(f"not asked: {note}" for note in found.notes)]
    if found.state in NEXT:
        lines.append(f"next: {NEXT[found.state]}")
    return lines


def _gate_line(row: GateRow) -> str:
    head = f"  {row.verdict:<8} {row.name:<24}"
    if row.verdict == PASSED:
        return f"{head} {row.value:.1e} {row.unit}, at most {row.limit:.1e}"
    if row.verdict == STOPPED and row.unit:
        return f"{head} {row.value:.1e} {row.unit}, at most {row.limit:.1e}: {row.because}"
    return f"{head} {row.because}"


def _reading_lines(found: Judgement) -> list[str]:
    reading = found.reading
    assert reading is not None  # noqa: S101  as the only caller sees to
    e = reading.elastic
    if e.E is None or e.nu is None:
        read = [f"read        none: {e.because}"]
    else:
        read = [f"read        E {e.E:.6g} ± {e.E_error:.1g} Pa, nu {e.nu:.4g} ± {e.nu_error:.1g}"]
    masses = "not observed" if reading.masses is None else reading.masses.line()
    flags = [f"flag        {f.line()}" for f in reading.flags if f.refuses and not f.holds]
    return [*read, f"masses      {masses.removeprefix('masses: ')}", *flags]


def _body_line(row: BodyRow) -> str:
    head = f"  {row.body + ', ' + row.case + ' ' + row.mesh:<38}{row.error:>9.2%}"
    if row.factors is None:
        return f"{head}  no law to hold it against"
    f = row.factors
    parts: dict[str, Any] = {"law": f.law, "mesh": f.resolution, "mass": f.mass, "solver": f.solver}
    owed = [f"{name} {part:.4g}" for name, part in parts.items() if abs(part - 1) >= 5e-4]
    left = f"not explained {f.apart:.2%}"
    return f"{head}  {', '.join([*owed, left])}"
