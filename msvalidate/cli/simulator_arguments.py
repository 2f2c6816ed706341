"""What ``msvalidate simulate`` and ``msvalidate adapter`` take: files and options."""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from msvalidate.cli.arguments import PROGRAM, Parser

FOLDER = Path("reports/simulators")
SHAPES = ("tetra", "hexahedron", "triangle", "quad")
PARTS = ("gate", "probe", "bodies")
"""Of a check, as `simulators.verdict.judgement` has them: this module imports nothing heavy."""
SAID = {
    "simulate": "Ask a simulator for a case through its adapter, and judge what it answers.",
    "adapter": "Adapters: programs that run a simulator, as ADAPTER CASE_DIR OUT_DIR.",
}
EXIT_CODES = """\
exit codes:
  0  agrees with elasticity           2  wrong usage or bad input
  1  differs, or is not resolved      3  the simulator failed, or left no answer
                                      4  it cannot represent the case
"""
CHECK = """\
Ask a simulator ten to two hundred small questions: does it pass the gate, which law does one step
of it show, and what of its bodies at rest has no cause? Nothing is installed for it.
"""
CHECK_CODES = """\
exit codes:
  0  the solid asked for             2  wrong usage or bad input
  1  another solid, not explained,   3  a question crashed it, had no answer, or not in time
     or stopped at the gate          4  it can represent nothing that was asked
"""


def parse_simulators(words: Sequence[str]) -> argparse.Namespace:
    """The options of ``simulate`` or ``adapter``, the first of the words; `command` is which.

    Wrong usage ends the program with one line and exit code 2.
    """
    name = words[0]
    parser = Parser(
        prog=f"{PROGRAM} {name}",
        description=SAID[name],
        epilog=EXIT_CODES if name == "simulate" else None,
    )
    if name == "simulate":
        _add_simulate(parser)
    else:
        _add_adapter(parser)
    args = parser.parse_args(list(words[1:]))
    args.command, args.jobs = name, 1
    args.verbose = getattr(args, "verbose", False)
    return args


def _add_simulate(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add("file", type=Path, metavar="CASE", help="case file")
    add(
        "--with",
        dest="adapter",
        required=True,
        metavar="ADAPTER",
        help="command of the adapter, as of a shell: a program, or a .py file, and its words",
    )
    add_export(parser)
    _add_limit(add)
    said = "folder in which each case and adapter get a folder of their own (default: %(default)s)"
    add_output(parser, said, FOLDER)


def _add_adapter(parser: argparse.ArgumentParser) -> None:
    acts = parser.add_subparsers(dest="act", required=True, metavar="ACT")
    new = acts.add_parser("new", help="write a commented template that runs as it is")
    new.add_argument("name", metavar="NAME", help="of the simulator; NAME.py is written")
    acts.add_parser("laws", help="names of laws, and what each is at small strain")
    check = acts.add_parser(
        "check",
        help="which elastic solid does a simulator simulate?",
        description=CHECK,
        epilog=CHECK_CODES,
    )
    _add_check(check)


def _add_check(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add(
        "adapter",
        metavar="ADAPTER",
        help="its command, as of a shell: a program, or a .py file, and its words",
    )
    add("--E", dest="modulus", type=float, default=1e7, metavar="PA", help="(default: %(default)g)")
    add(
        "--nu",
        dest="ratio",
        type=float,
        default=0.3,
        metavar="NU",
        help="Poisson's ratio, 0 to 0.45 (default: %(default)g)",
    )
    add("--density", type=float, default=1000.0, metavar="KG/M3", help="(default: %(default)g)")
    add("--law", default="", metavar="NAME", help="its documented law; see adapter laws")
    _add_set(add, "--set", "a setting of the simulator, handed on; again for another")
    _add_set(add, "--probe-set", "a setting for the steps alone from which the law is read")
    _add_limit(add)
    add(
        "--only",
        action="append",
        choices=PARTS,
        metavar="PART",
        help="gate, probe or bodies alone; again for another (default: all three)",
    )
    add("--json", type=Path, metavar="FILE", help="all of it as a file too")
    add_output(
        parser, "a page in a folder of its own there, and beside it the latest question and answer"
    )


def _add_limit(add: Callable[..., Any]) -> None:
    add(
        "--limit",
        type=float,
        default=300.0,
        metavar="SECONDS",
        help="time after which it is ended, for each question (default: %(default)g)",
    )


def _add_set(add: Callable[..., Any], name: str, said: str) -> None:
    add(name, type=_setting, action="append", default=[], metavar="NAME=VALUE", help=said)


def add_output(parser: argparse.ArgumentParser, said: str, folder: Path | None = None) -> None:
    """Add the options of commands that leave pages; `said` is about their folder."""
    add = parser.add_argument
    add("--out", type=Path, default=folder, metavar="DIR", help=said)
    add("--no-plots", dest="plots", action="store_false", help="no pictures")
    add("-q", "--quiet", action="store_true", help="say failures only")
    add("-v", "--verbose", action="store_true", help="tracebacks of crashes")


def add_export(parser: argparse.ArgumentParser) -> None:
    """Add the options that say what a simulator is given."""
    add = parser.add_argument
    add(
        "--cells",
        type=int,
        metavar="N",
        help="cells across the narrowest side; a mesh file's are halved until so small",
    )
    add("--shape", choices=SHAPES, metavar="SHAPE", help=f"of the cells: {', '.join(SHAPES)}")
    add(
        "--springs",
        action="store_true",
        help="the case's own springs too, if their ratio is its own to 0.01",
    )
    _add_set(add, "--set", "a setting of the simulator, handed on; again for another")


def _setting(text: str) -> tuple[str, Any]:
    """A name and a value: a number, true, false or list as in JSON, else a text."""
    name, equals, value = text.partition("=")
    name = name.strip()
    if not equals or not name or not text.isprintable():
        raise argparse.ArgumentTypeError(f"{text!r}; give NAME=VALUE")
    try:
        return name, json.loads(value, parse_constant=_finite, parse_float=_finite)
    except (ValueError, RecursionError):
        return name, value


def _finite(text: str) -> float:
    if not math.isfinite(float(text)):
        raise argparse.ArgumentTypeError(f"{text} is no number that can be handed on; give another")
    return float(text)
