"""What ``msvalidate case`` takes: commands, files and options."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from msvalidate.cli.arguments import PROGRAM, Parser
from msvalidate.cli.simulator_arguments import add_export, add_output

FOLDER = Path("reports/cases")
SIMULATOR = "simulator"
EXPORTS = {
    SIMULATOR: "a mesh with masses, forces and supports",
    "csv": "tables of points, springs and cells",
    "json": "these in one file",
    "lammps": "springs alone, at the nearest ratio that these have, as data and input",
}
COMMANDS = {
    "new": "write a commented case file",
    "run": "solve cases with springs and with elements, and compare",
    "judge": "compare displacements from a file with a case's elasticity",
    "export": "write a case for a simulator, or its springs as CSV, JSON or for LAMMPS",
    "schema": "the JSON schema of case files, for editors",
}
EXIT_CODES = """\
exit codes:
  0  agrees in every quantity         2  wrong usage or bad input
  1  differs, or is not resolved      3  a solver failed
"""


def parse_case(words: Sequence[str]) -> argparse.Namespace:
    """The words after ``case``: `command` (one of `COMMANDS`) and its options.

    Wrong usage ends the program with one line and exit code 2.
    """
    args = _parser().parse_args(list(words))
    args.jobs, args.verbose = getattr(args, "jobs", 1), getattr(args, "verbose", False)
    return args


def _parser() -> argparse.ArgumentParser:
    parser = Parser(
        prog=f"{PROGRAM} case",
        description="Your own body: from a file to springs, elements, and a verdict.",
        epilog=EXIT_CODES,
    )
    commands = parser.add_subparsers(dest="command", metavar="COMMAND", required=True)
    each = {
        name: commands.add_parser(
            name,
            help=said,
            description=f"{said}.",
            epilog=EXIT_CODES if name in {"run", "judge"} else None,
        )
        for name, said in COMMANDS.items()
    }
    each["new"].add_argument("name", metavar="NAME", help="of the case; NAME.toml is written")
    each["run"].add_argument("files", nargs="+", type=Path, metavar="FILE", help="case files")
    add = each["run"].add_argument
    add("--set", action="append", default=[], metavar="KEY=V,V", help="a key's values: every "
        "combination is a row of one table, no page; again for another key")  # fmt: skip
    add("--jobs", type=int, default=1, metavar="N", help="combinations at once (default: 1)")
    add("--scheduler", metavar="URL", help="combinations on a Dask cluster, as tcp://host:8786")
    add("--limit", type=float, default=3600.0, metavar="SECONDS", help="for a combination (3600)")
    add = each["judge"].add_argument
    add("file", type=Path, metavar="FILE", help="case file")
    add(
        "result",
        type=Path,
        metavar="RESULT",
        help="displacements: .csv (x, y, z or id; ux, uy, uz), .npz (points or id; displacement), "
        ".vtu",
    )
    add(
        "--unit", default="m", metavar="UNIT", help="of its lengths: m, mm, in ... or a number in m"
    )
    add("--field", metavar="NAME", help="the displacements' name, where there are several fields")
    add(
        "--at-rest",
        type=float,
        metavar="PART",
        help="how much they may still change, over the largest",
    )
    add(
        "--accuracy",
        type=float,
        metavar="PART",
        help="how far they may be off by their digits, over the largest (1e-6)",
    )
    each["export"].add_argument("file", type=Path, metavar="CASE", help="case file")
    each["export"].add_argument(
        "folder", type=Path, metavar="DIR", help="folder that is made, or whose export is replaced"
    )
    what = "; ".join(f"{name}: {said}" for name, said in EXPORTS.items())
    each["export"].add_argument(
        "--to", choices=EXPORTS, default=SIMULATOR, help=f"{what} (default: %(default)s)"
    )
    add_export(each["export"])
    each["schema"].add_argument(
        "--network", action="store_true", help="of network.json, which export --to json writes"
    )
    for name in ("run", "judge"):
        said = "folder in which each case gets a folder of its own (default: %(default)s)"
        add_output(each[name], said, FOLDER)
    return parser
