"""What ``msvalidate adapter check`` does: a simulator tried, its law read, its bodies judged."""

from __future__ import annotations

import argparse
import difflib
import sys

from msvalidate.case import files
from msvalidate.cli.arguments import FAILED, HELD, MISSED, NOTHING
from msvalidate.cli.cases import Progress
from msvalidate.cli.terminal import print_lines, tell, tell_error
from msvalidate.problem import Isotropic, ProblemError
from msvalidate.problem.checks import format_value
from msvalidate.simulators.asked import Asked, NoAnswerError
from msvalidate.simulators.causes import AGREES
from msvalidate.simulators.judgement import PARTS, Judgement, judge_simulator
from msvalidate.simulators.laws import LAWS, law_named, predicted
from msvalidate.simulators.program import LOG, OUT, Program, label_of
from msvalidate.simulators.record import record_of, text_of
from msvalidate.simulators.sheet import Sheet, sheet_of
from msvalidate_check import exchange


class Steps(Progress):
    """Steps of something that takes minutes.

    A terminal shows the one that is taken now, written over; elsewhere each that was done is a line
    of stderr.
    """

    def __init__(self, name: str, *, shown: bool) -> None:
        super().__init__(name, shown=shown)
        self._tells = shown and not sys.stderr.isatty()

    def done(self, said: str) -> None:
        """Say what was done."""
        if self._tells:
            tell(f"{self._name}: {said}")


def tell_laws() -> int:
    """Names that --law takes, each with what it is to first order for E = 1 and nu = 0.3."""
    width, wide = max(map(len, LAWS)), max(len(law.key) for law in LAWS.values())
    lines = [f"{'--law':<{wide}}  {'law':<{width}}  E over asked  nu for 0.3"]
    for name in LAWS:
        law = predicted(name, 1.0, 0.3)
        none = law.E is None or law.nu is None
        E, nu = (
            ("none", "none") if none else (f"{law.E:.4f}", f"{round(law.nu or 0.0, 4) + 0.0:.4f}")
        )
        lines.append(f"{LAWS[name].key:<{wide}}  {name:<{width}}  {E:>12}  {nu:>10}")
    return print_lines(lines)


def check_adapter(args: argparse.Namespace) -> int:
    """Ask ten to two hundred questions and tell what came of them; the exit code.

    Raises
    ------
    ProblemError
        For options that cannot be, before anything is asked.
    """
    name = label_of(args.adapter)
    _refuse(args)
    kept = None if args.out is None else args.out / files.folder_name(name)
    material = Isotropic(args.modulus, args.ratio, "solid", args.density)
    parts = tuple(args.only or PARTS)
    show = Steps(name, shown=not args.quiet)
    asked = Asked(Program(args.adapter, args.limit, kept), show, show.done)
    try:
        found = judge_simulator(
            asked, material, dict(args.set), law=args.law, probed=dict(args.probe_set), parts=parts
        )
        sheet = sheet_of(found, asked, parts)
        if args.json is not None:
            record = {"adapter": name, "law": args.law, "word": sheet.word, **record_of(found)}
            exchange.replace_file(args.json, f"{text_of(record)}\n".encode)
    except NoAnswerError as error:
        show.clear()
        where = "" if kept is None else f" ({kept / OUT / LOG})"
        return tell_error(f"{name}: {error}{where}", FAILED)
    finally:  # also when we are interrupted
        show.clear()
    return _tell(args, name, found, sheet, asked)


def _refuse(args: argparse.Namespace) -> None:
    """Raise `ProblemError` for a law or a place that cannot be."""
    args.law = law_named(args.law)
    if args.law and args.law not in LAWS:
        near = [name for name in LAWS if args.law.lower() in name.lower()]
        near = near or difflib.get_close_matches(args.law, LAWS, n=1, cutoff=0.5)
        meant = f" (meant: {' | '.join(near)}?)" if near else ""
        raise ProblemError(f"--law {format_value(args.law)}: not known; see adapter laws{meant}")
    if args.json is not None and not args.json.parent.is_dir():
        raise ProblemError(f"--json {args.json}: no folder {args.json.parent}; make it first")


def _tell(
    args: argparse.Namespace,
    name: str,
    found: Judgement,
    sheet: Sheet,
    asked: Asked,
) -> int:
    code = _exit_code(found, asked)
    if args.quiet:
        if code != HELD:
            tell(f"{name}: {sheet.word}")
        return code
    if code == NOTHING:
        return tell_error(f"{name}: cannot represent: {asked.refusals[-1]}", NOTHING)
    return print_lines(sheet.lines(name)) or code


def _exit_code(found: Judgement, asked: Asked) -> int:
    if asked.failures:
        return FAILED
    if not asked.answers:
        return NOTHING
    return HELD if found.state == AGREES else MISSED
