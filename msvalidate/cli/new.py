"""Commands ``case new``, ``study new`` and ``adapter new``, which write a runnable file."""

from __future__ import annotations

import argparse
import keyword
from pathlib import Path

from msvalidate import studies
from msvalidate.bench.judging import catalogue
from msvalidate.case import file
from msvalidate.case.report.files import folder_name
from msvalidate.cli.arguments import HELD, PROGRAM
from msvalidate.cli.terminal import tell
from msvalidate.problem import ProblemError
from msvalidate.problem.checks import format_value
from msvalidate.simulators.exchange.template import adapter_template
from msvalidate_check import exchange

TEMPLATE = Path(file.__file__).with_name("template.toml")
EXAMPLE = studies.OURS.parent / "examples" / "study.py"
ENDS = {"case": ".toml", "study": ".py", "adapter": ".py"}


def write_new(args: argparse.Namespace) -> int:
    """Write the file; what is there stays."""
    said, end = f"{args.verb} new", ENDS[args.verb]
    name = Path(args.name).name.removesuffix(end)
    path = Path(args.name).parent / f"{name}{end}"
    if args.verb == "case":
        plain = name.strip(" .") and name.isprintable() and not set(name) & {'"', "\\"}
        form = "; give letters and digits"
        content = TEMPLATE.read_text("utf-8").replace("NAME", name).encode()
        then = f"change it, then: {PROGRAM} case run {path}"
    elif args.verb == "adapter":
        plain = name and folder_name(name) == name
        form, content = "; give letters, digits, - and _", adapter_template(name).encode()
        then = f"it runs as it is: {PROGRAM} adapter check {path}"
    else:
        plain = name.isascii() and name.isidentifier() and not name.startswith("_")
        plain = plain and not keyword.iskeyword(name)
        form = " of a module; give letters, digits and _, such as my_study"
        content = EXAMPLE.read_bytes()
        then = f"change it, then: {PROGRAM} {name} --studies {path.parent}"
    if not plain:
        raise ProblemError(f"{said}: {format_value(args.name)} is no name{form}")
    if args.verb == "study" and name in (*catalogue.RESERVED, *catalogue.names()):
        raise ProblemError(f"{said}: {name!r} is taken by a study or command; give another name")
    if path.exists() or path.is_symlink():
        raise ProblemError(f"{said}: {path} is there already; give another name")
    if not path.parent.is_dir():
        raise ProblemError(f"{said}: no folder {path.parent}; make it first")
    exchange.replace_file(path, lambda: content)
    tell(f"{path} written; {then}")
    return HELD
