"""What ``msvalidate adapter check`` does: a simulator tried, its law read, its bodies judged."""

from __future__ import annotations

import argparse
import contextlib
import difflib
import sys
from datetime import UTC, datetime
from pathlib import Path

from msvalidate.case import files
from msvalidate.cli.arguments import FAILED, HELD, MISSED, NOTHING
from msvalidate.cli.cases import Progress
from msvalidate.cli.terminal import print_lines, tell, tell_error
from msvalidate.output.provenance import collect_provenance
from msvalidate.problem import Isotropic, ProblemError
from msvalidate.problem.checks import format_value
from msvalidate.simulators.bodies.laws import LAWS, law_named, predicted
from msvalidate.simulators.exchange.asked import Asked, NoAnswerError
from msvalidate.simulators.exchange.program import LOG, OUT, Program, label_of
from msvalidate.simulators.verdict.causes import AGREES
from msvalidate.simulators.verdict.judgement import PARTS, Judgement, judge_simulator
from msvalidate.simulators.verdict.page import PAGE, sheet_files
from msvalidate.simulators.verdict.record import json_of, record_of
from msvalidate.simulators.verdict.sheet import Sheet, sheet_of
from msvalidate_check import exchange

COMMAND = ("msvalidate", "adapter", "check", "ADAPTER")
RUN = "-run"
"""End of the name of the folder in which its latest question stays, beside its page."""


class Steps(Progress):
    """Steps of something that takes minutes.

    A terminal shows the one that is taken now, written over; elsewhere each that was done is a line
    of stderr. `log` holds these lines too.
    """

    def __init__(self, name: str, *, shown: bool, log: Path | None = None) -> None:
        super().__init__(name, shown=shown)
        self._tells = shown and not sys.stderr.isatty()
        self._log, self._lines = log, list[str]()

    def done(self, said: str) -> None:
        """Say what was done."""
        self._lines.append(f"{self._name}: {said}")
        if self._tells:
            tell(self._lines[-1])
        if self._log is not None:
            text = "\n".join([*self._lines, ""])
            with contextlib.suppress(OSError):
                exchange.replace_file(self._log, text.encode)


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
    folder, kept = _folders(args, name)
    material = Isotropic(args.modulus, args.ratio, "solid", args.density)
    parts = tuple(args.only or PARTS)
    log = None if folder is None else folder.with_name(f"{folder.name}.log")
    show = Steps(name, shown=not args.quiet, log=log)
    asked = Asked(Program(args.adapter, args.limit, kept), show, show.done, parts)
    started = datetime.now(UTC)
    try:
        found = judge_simulator(
            asked, material, dict(args.set), law=args.law, probed=dict(args.probe_set), parts=parts
        )
        sheet = sheet_of(found, asked, parts)
        _write(args, name, folder, found, sheet, started, show)
    except NoAnswerError as error:
        show.clear()
        where = "" if kept is None else f" ({kept / OUT / LOG})"
        return tell_error(f"{name}: {error}{where}", FAILED)
    finally:  # also when we are interrupted
        show.clear()
    return _tell(args, name, folder, found, sheet, asked)


def _folders(args: argparse.Namespace, name: str) -> tuple[Path | None, Path | None]:
    """Where the page goes and where the latest question stays; refuses what cannot be."""
    args.law = law_named(args.law)
    if args.law and args.law not in LAWS:
        near = [name for name in LAWS if args.law.lower() in name.lower()]
        near = near or difflib.get_close_matches(args.law, LAWS, n=1, cutoff=0.5)
        meant = f" (meant: {' | '.join(near)}?)" if near else ""
        raise ProblemError(f"--law {format_value(args.law)}: not known; see adapter laws{meant}")
    if args.json is not None and not args.json.parent.is_dir():
        raise ProblemError(f"--json {args.json}: no folder {args.json.parent}; make it first")
    if args.out is None:
        return None, None
    folder = args.out / files.folder_name(f"{name}-check")
    files.refuse_foreign(folder, format_value(args.adapter))
    return folder, folder.with_name(f"{folder.name}{RUN}")


def _write(
    args: argparse.Namespace,
    name: str,
    folder: Path | None,
    found: Judgement,
    sheet: Sheet,
    started: datetime,
    show: Steps,
) -> None:
    """The record and the page, where they were asked for."""
    record = {"adapter": name, "law": args.law, "word": sheet.word, **record_of(found)}
    text = f"{json_of(record)}\n".encode()
    if args.json is not None:
        exchange.replace_file(args.json, lambda: text)
    if folder is None:
        return
    show("page")
    seconds = (datetime.now(UTC) - started).total_seconds()
    origin = collect_provenance(COMMAND, 0, started, seconds, form="check")
    settings = {name: str(value) for name, value in dict(args.set).items()}
    own = sheet_files(name, found, sheet, settings, origin, plots=args.plots)
    files.publish(folder, {**own, "check.json": text}, format_value(args.adapter))


def _tell(
    args: argparse.Namespace,
    name: str,
    folder: Path | None,
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
    printed = print_lines(sheet.lines(name))
    if folder is not None:
        tell(f"{name}: {folder / PAGE}")
    return printed or code


def _exit_code(found: Judgement, asked: Asked) -> int:
    if asked.failures:
        return FAILED
    if not asked.answers:
        return NOTHING
    return HELD if found.state == AGREES else MISSED
