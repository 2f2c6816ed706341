"""What ``msvalidate study new NAME`` does: a first study that runs, to be changed."""

from __future__ import annotations

import argparse
import keyword
from collections.abc import Sequence
from pathlib import Path

from msvalidate import studies
from msvalidate.cli.arguments import HELD, PROGRAM, Parser
from msvalidate.judging import catalogue

EXAMPLE = studies.OURS.parent / "examples" / "study.py"


def parse_new_study(words: Sequence[str]) -> argparse.Namespace:
    """The words after ``study``: `new`, and the name."""
    parser = Parser(prog=f"{PROGRAM} study", description="A study of your own.")
    commands = parser.add_subparsers(dest="command", metavar="COMMAND", required=True)
    new = commands.add_parser("new", help="write a first study, which runs as it is")
    new.add_argument("name", metavar="NAME", help="of the study; NAME.py is written")
    return argparse.Namespace(**vars(parser.parse_args(list(words))), jobs=1, verbose=False)


def act(args: argparse.Namespace) -> int:
    """Write the study; what is there stays."""
    from msvalidate.cli.cases import new_path
    from msvalidate.cli.terminal import tell
    from msvalidate.problem import ProblemError
    from msvalidate.problem.checks import format_value
    from msvalidate_check import exchange

    name = Path(args.name).name.removesuffix(".py")
    plain = name.isascii() and name.isidentifier() and not name.startswith("_")
    if not plain or keyword.iskeyword(name):
        raise ProblemError(
            f"study new: {format_value(args.name)} is no name of a module; give letters, digits "
            "and _, such as my_study"
        )
    if name in (*catalogue.RESERVED, *catalogue.names()):
        raise ProblemError(f"study new: {name!r} is taken by a study or command; give another name")
    path = new_path("study new", Path(args.name).parent / f"{name}.py")
    exchange.replace_file(path, EXAMPLE.read_bytes)
    tell(f"{path} written; change it, then: {PROGRAM} {name} --studies {path.parent}")
    return HELD
