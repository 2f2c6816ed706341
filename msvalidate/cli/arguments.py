"""What the command line takes: commands and options as data, and what is wrong usage."""

from __future__ import annotations

import argparse
import json
import math
import re
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple, NoReturn

from msvalidate import __version__
from msvalidate.case.units import DENSITY, LENGTH, PRESSURE, STIFFNESS
from msvalidate.judging import catalogue

HELD, MISSED, USAGE, FAILED, NOTHING, INTERRUPTED = 0, 1, 2, 3, 4, 130
DOCUMENTED = "python -m msvalidate.study"
"""The program's name in files, whose reader may have started it otherwise."""
CALLS = {"msvalidate": "msvalidate", "__main__": "python -m msvalidate"}
PROGRAM = CALLS.get(Path(sys.argv[0]).stem, DOCUMENTED)
"""Its name as it was called, for hints and help."""
SIMULATOR = "simulator"
EXPORTS = {
    SIMULATOR: "a mesh with masses, forces and supports",
    "csv": "tables of points, springs and cells",
    "json": "these in one file",
    "lammps": "springs alone, at the nearest ratio that these have, as data and input",
}
CONSTANTS = ("k1", "k2", "k3")
LATEST, CANDIDATES = Path("reports/latest"), Path("reports/candidate")
"""Where results go: those of a candidate do not take the place of our own."""


class Option(NamedTuple):
    """An option or, without dashes, a word: its names, settings of argparse, and whose it is.

    It is told in the help of the commands `of`, of all for none.
    """

    names: Sequence[str]
    settings: Mapping[str, Any]
    of: Sequence[str]


class Command(NamedTuple):
    """A command: what it does, its function as "module:name", options, and commands below it.

    `about` and `ending` stand in its help, first and last.
    """

    said: str
    act: str = ""
    options: Sequence[Option] = ()
    commands: Mapping[str, Command] = {}
    about: str = ""
    ending: str | None = None
    check: Callable[[argparse.ArgumentParser, argparse.Namespace], None] = lambda *_: None


def option(names: str, said: str, metavar: str = "", of: str = "", **settings: Any) -> Option:
    """An option with a value that `metavar` names, without one if that is empty."""
    if metavar:
        settings["metavar"] = metavar
    elif not settings.keys() & {"action", "choices"}:
        settings["action"] = "store_true"
    return Option(names.split(), {"help": said, **settings}, of.split())


# What a word may be -------------------------------------------------------------------------------

NUMBER = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(\S*)\s*")


def word(read: Callable[[str], Any], said: str) -> Callable[[str], Any]:
    """What reads a word; where that gives None or a ValueError, `said` is why it is refused."""

    def read_word(text: str) -> Any:
        try:
            value = read(text)
        except ValueError:
            value = None
        if value is None:
            raise argparse.ArgumentTypeError(said.format(text))
        return value

    return read_word


def whole(least: int) -> Callable[[str], Any]:
    """What reads a whole number, so large or larger."""
    return word(
        lambda text: int(text) if text.isdecimal() and int(text) >= least else None,
        f"{{!r}} is not a whole number, {least} or more",
    )


def in_si(units: Mapping[str, float]) -> Callable[[str], Any]:
    """What reads a number with one of some units as one in SI units."""
    factors = {"": 1.0, **units}

    def read(text: str) -> float | None:
        match = NUMBER.fullmatch(text)
        return float(match[1]) * factors[match[2]] if match and match[2] in factors else None

    unit = f", or one with {', '.join(units)}" if units else ""
    return word(read, f"{{!r}}; give a number in SI units{unit}")


def _setting(text: str) -> tuple[str, Any] | None:
    """A name and a value: a number, true, false or list as in JSON, else a text."""
    name, equals, value = text.partition("=")
    if not equals or not name.strip() or not text.isprintable():
        return None
    try:
        return name.strip(), json.loads(value, parse_constant=_finite, parse_float=_finite)
    except (ValueError, RecursionError):
        return name.strip(), value


def _finite(text: str) -> float:
    if not math.isfinite(float(text)):
        raise argparse.ArgumentTypeError(f"{text} is no number that can be handed on; give another")
    return float(text)


def _names(text: str) -> tuple[str, ...] | None:
    found = tuple(dict.fromkeys(name.strip() for name in text.split(",")))
    return found if all(found) and text.isprintable() else None


def _line(text: str) -> str | None:
    return text.strip() if text.isprintable() and text.strip() else None


path = word(lambda text: Path(text) if _line(text) else None, "{!r} is no name; name a place")
line = word(_line, "{!r}; say why in one line")
part = word(
    lambda text: value if 0 <= (value := float(text)) < 1 else None,
    "{!r} is no number from 0 to below 1, such as 6e-8",
)
names = word(_names, "{!r}; give names with commas between them")
setting = word(_setting, "{!r}; give NAME=VALUE")

# Options and commands -----------------------------------------------------------------------------

VERBOSE = option("-v --verbose", "tracebacks of crashes")
STUDIES = (
    option("names", "studies, or 'all' of them; check judges all if none is named", "NAME",
           "run check", nargs="*"),
    option("--quick", "the small form: fewer sizes", of="run"),
    option("--out", f"folder for tables, figures, report.html and verdict.json (default: {LATEST}; "
           f"of a run with --candidate {CANDIDATES})", "DIR", "run check report", type=path),
    option("--studies", "a folder with studies of your own, each a module with a function run; may "
           "be given again for another", "DIR", dest="folders", action="append", type=path,
           default=[]),
    option("--seed", "where random numbers start (default: %(default)s)", "N", "run", type=whole(0),
           default=0),
    option("--jobs", "studies that run at once, each in a process of its own, on one thread; those "
           "that compare times run last and alone; numbers do not depend on it (default: "
           "%(default)s)", "N", "run check", type=whole(1), default=1),
    option("--no-plots", "write tables and report only", of="run check", dest="plots",
           action="store_false"),
    option("--table", "print this table alone, and whole; may be given again for another", "TABLE",
           "run", dest="tables", action="append", default=[]),
    option("--candidate", "judge this in the place of our springs; file.py:function too. It is run",
           "MODULE:FUNCTION", "run", type=line),
    option("--accuracy", "error of the candidate's positions over the largest coordinate; by "
           "default 6e-8, that of single precision", "A", "run", type=part),
    option("--questions", "only these questions of the one study that is named", "A,B", "run",
           type=names),
    option("--full", "the full form, not the small one", of="check"),
    option("--update", "make what is found the baseline of the studies that were run, if all holds",
           of="check"),
    option("--reason", "why it moved, for REASONS.md beside it", "TEXT", "check", type=line),
    option("--baseline", "a baseline of your own in the place of ours; its REASONS.md says why it "
           "moved", "DIR", "check", type=path),
    option("--junit", "write a JUnit file for a CI", "FILE", "check", type=path),
    option("-q --quiet", "print failures only"),
    option("-v --verbose", "print all tables, and tracebacks of crashes"),
    option("--version", "show program's version number and exit", action="version",
           version=f"msvalidate {__version__}"),
)  # fmt: skip
"""Of commands about studies: each knows all, so that what is misplaced can be told."""
VALUED = {name: each for each in STUDIES for name in each.names if "metavar" in each.settings}
"""Those that take the next word."""
PLACES = {
    name: each.settings["metavar"]
    for name, each in VALUED.items()
    if each.settings.get("type") is path or name == "--candidate"
}
"""Those whose value is the reader's own affair: what a report shows in its place."""
ADAPTER = "a program, or a .py file, and its words"
SETTINGS = option(
    "--set", "a setting of the simulator, handed on; again for another", "NAME=VALUE",
    type=setting, action="append", default=[],
)  # fmt: skip
LIMIT = option(
    "--limit", "time after which it is ended, for each question (default: %(default)g)", "SECONDS",
    type=float, default=300.0,
)  # fmt: skip
EXPORT = (
    option("--cells", "cells across the narrowest side; a mesh file's are halved until so small",
           "N", type=int),
    option("--shape", "of the cells: tetra, hexahedron, triangle, quad", "SHAPE",
           choices=("tetra", "hexahedron", "triangle", "quad")),
    option("--springs", "the case's own springs too, if their ratio is its own to 0.01"),
    SETTINGS,
)  # fmt: skip
"""What a simulator is given."""


def pages(said: str, folder: str | None = None) -> tuple[Option, ...]:
    """Options of commands that leave pages; `said` is about their folder."""
    return (
        option("--out", said, "DIR", type=Path, default=folder and Path(folder)),
        option("--no-plots", "no pictures", dest="plots", action="store_false"),
        option("-q --quiet", "say failures only"),
        VERBOSE,
    )


OF_CASES = pages("folder in which each case gets a folder of its own (default: %(default)s)",
                 "reports/cases")  # fmt: skip

OF_MATERIAL = {"E", "nu", "route", "engine", "json", "state"}
OF_LATTICE = ("lattice", "spacing", "density", *CONSTANTS, "kappa")


def check_advise(parser: argparse.ArgumentParser, args: argparse.Namespace) -> None:
    """End the program if options are missing or do not go together."""
    given = {name for name, value in vars(args).items() if value != parser.get_default(name)}
    advises, own = args.identify is None, [name in given for name in CONSTANTS]
    first = CONSTANTS[own.index(False)] if False in own else ""
    missing = [name for name in ("E", "nu", "spacing") if advises and name not in given]
    of_other = {*CONSTANTS, "kappa", "period"} if advises else OF_MATERIAL
    others, of_lattice = sorted(given & of_other), [n for n in OF_LATTICE if n in given]
    where = "goes with" if advises else "does not go with"
    _refuse(parser, {
        f"--{_first(missing)} is missing; give --E, --nu and --spacing": missing,
        f"--{_first(others)} {where} --identify; leave one of them out": others,
        f"--{_first(of_lattice)} is of a lattice, and {args.identify!r} a file; leave it out":
            args.identify and of_lattice,
        f"--{first} is missing; give the kinds before it too": own != sorted(own, reverse=True),
    })  # fmt: skip


def check_studies(parser: argparse.ArgumentParser, args: argparse.Namespace) -> None:
    """End the program for what does not go together; find `studies`, `named`, `form` and `out`.

    `named` is whether the studies were named one by one.
    """
    verb, told = args.verb, args.names
    runs, checks = verb == "run", verb == "check"
    word = _first([each for each in told if each in COMMANDS])
    _refuse(parser, {
        "no study named; name some, or 'all'": runs and not told,
        f"{verb!r} stands alone; leave the other names out": not (runs or checks) and told,
        "'all' stands alone; leave the other names out": "all" in told and len(told) > 1,
        f"{word!r} stands alone; leave the other names out": word in {"list", "report"},
        f"{word!r} comes first, and once; move it before the studies": word,
    })  # fmt: skip
    try:
        catalogue.check_joined()
        for folder in args.folders:
            catalogue.join(folder)
    except ImportError as error:
        parser.error(str(error))
    known = catalogue.names()
    args.named = told not in ([], ["all"])
    args.studies = list(dict.fromkeys(told)) if args.named else known
    unknown = _first([name for name in args.studies if name not in known])
    if unknown:
        parser.error(f"unknown study {unknown!r}: {catalogue.suggestion(unknown)}")
    given = {name for name, value in vars(args).items() if value != parser.get_default(name)}
    foreign = [name for name in args.studies if "update" in given and not catalogue.is_ours(name)]
    part = [name for name in ("candidate", "accuracy", "questions") if name in given]
    rest = ["full", "update", "baseline", *(["junit"] if args.candidate is None else [])]
    of_check = [name for name in rest if name in given]
    _refuse(parser, {
        f"--update: {_first(foreign)} is a study of your own and has no baseline among ours; give "
        "--baseline DIR, or leave it out": foreign and not args.baseline,
        f"--{_first(part)} goes with 'run' only: check holds our own whole studies to their "
        "baseline; leave it out": part and not runs,
        "--accuracy is that of a candidate; give --candidate too, or leave it out":
            "accuracy" in given and "candidate" not in given,
        "--candidate: name the studies that can judge it, such as displacement":
            "candidate" in given and not args.named,
        "--questions are those of one study; name it alone":
            "questions" in given and not (args.named and len(args.studies) == 1),
        f"--{_first(of_check)} goes with 'check' only; leave it out": of_check and not checks,
        f"{verb} prints no tables; leave --table out": args.tables and not runs,
        f"{verb} solves nothing; leave --quick, --seed, --jobs and --no-plots out":
            given & {"quick", "seed", "jobs", "plots"} and not (runs or checks),
        '--update and --reason "..." go together; give both or none':
            args.update != (args.reason is not None),
        "check has its own form and seed; leave --quick and --seed out":
            checks and given & {"quick", "seed"},
    })  # fmt: skip
    args.out = args.out or (CANDIDATES if args.candidate else LATEST)
    args.form = "quick" if args.quick or (checks and not args.full) else "full"


def _first(found: Sequence[str]) -> str:
    return found[0] if found else ""


def _refuse(parser: argparse.ArgumentParser, wrong: Mapping[str, object]) -> None:
    """End the program with the first words that are true."""
    for said, is_so in wrong.items():
        if is_so:
            parser.error(said)


SOLVED = """\
exit codes:
  0  every tolerance held       2  wrong usage or bad input             4  nothing to compare with
  1  a tolerance was missed     3  a solver failed or a study crashed   130  interrupted
"""
JUDGED = """\
exit codes:
  0  agrees in every quantity         2  wrong usage or bad input
  1  differs, or is not resolved      3  a solver failed
"""
SIMULATED = """\
exit codes:
  0  agrees with elasticity           2  wrong usage or bad input
  1  differs, or is not resolved      3  the simulator failed, or left no answer
                                      4  it cannot represent the case
"""
CHECKED = """\
exit codes:
  0  the solid asked for             2  wrong usage or bad input
  1  another solid, not explained,   3  a question crashed it, had no answer, or not in time
     or stopped at the gate          4  it can represent nothing that was asked
"""
CHECKS = """\
Ask a simulator ten to two hundred small questions: does it pass the gate, which law does one step
of it show, and what of its bodies at rest has no cause? Nothing is installed for it.
"""
ADVISED = f"""\
values may have units, else they are in SI: 6mm, 2.8GPa, 1.2g/cm3, 5kN/m

examples:
  {PROGRAM} advise --E 2.8GPa --nu .4 --thickness 6mm --spacing 2mm   a sheet
  {PROGRAM} advise --E 2e11 --nu .3 --spacing 1cm --engine springs    a solid, springs alone
  {PROGRAM} advise --identify --lattice square --k1 1e6 --k2 1e6 --spacing 2mm
  {PROGRAM} advise --identify reports/cases/my/springs.csv            points.csv beside it
"""
CASES = {
    "new": Command("write a commented case file", "new:write_new", (
        option("name", "of the case; NAME.toml is written", "NAME"),)),
    "run": Command("solve cases with springs and with elements, and compare", "cases:run_cases", (
        option("files", "case files", "FILE", nargs="+", type=Path),
        option("--set", "a key's values: every combination is a row of one table, no page; again "
               "for another key", "KEY=V,V", action="append", default=[]),
        option("--jobs", "combinations at once (default: 1)", "N", type=int, default=1),
        option("--scheduler", "combinations on a Dask cluster, as tcp://host:8786", "URL"),
        option("--limit", "for a combination (3600)", "SECONDS", type=float, default=3600.0),
        *OF_CASES), ending=JUDGED),
    "judge": Command("compare displacements from a file with a case's elasticity",
        "cases:judge_file", (
        option("file", "case file", "FILE", type=Path),
        option("result", "displacements: .csv (x, y, z or id; ux, uy, uz), .npz (points or id; "
               "displacement), .vtu", "RESULT", type=Path),
        option("--unit", "of its lengths: m, mm, in ... or a number in m", "UNIT", default="m"),
        option("--field", "the displacements' name, where there are several fields", "NAME"),
        option("--at-rest", "how much they may still change, over the largest", "PART", type=float),
        option("--accuracy", "how far they may be off by their digits, over the largest (1e-6)",
               "PART", type=float),
        *OF_CASES), ending=JUDGED),
    "export": Command("write a case for a simulator, or its springs as CSV, JSON or for LAMMPS",
        "cases:export", (
        option("file", "case file", "CASE", type=Path),
        option("folder", "folder that is made, or whose export is replaced", "DIR", type=Path),
        option("--to", f"{'; '.join(f'{to}: {what}' for to, what in EXPORTS.items())} (default: "
               "%(default)s)", choices=EXPORTS, default=SIMULATOR),
        *EXPORT)),
    "schema": Command("the JSON schema of case files, for editors", "cases:print_schema", (
        option("--network", "of network.json, which export --to json writes"),)),
}  # fmt: skip
ADAPTERS = {
    "new": Command("write a commented template that runs as it is", "new:write_new", (
        option("name", "of the simulator; NAME.py is written", "NAME"),)),
    "laws": Command("names of laws, and what each is at small strain", "simulators:print_laws"),
    "check": Command("which elastic solid does a simulator simulate?", "simulators:check_adapter", (
        option("adapter", f"its command, as of a shell: {ADAPTER}", "ADAPTER"),
        option("--E", "(default: %(default)g)", "PA", dest="modulus", type=float, default=1e7),
        option("--nu", "Poisson's ratio, 0 to 0.45 (default: %(default)g)", "NU", dest="ratio",
               type=float, default=0.3),
        option("--density", "(default: %(default)g)", "KG/M3", type=float, default=1000.0),
        option("--law", "its documented law; see adapter laws", "NAME", default=""),
        SETTINGS,
        option("--probe-set", "a setting for the steps alone from which the law is read",
               "NAME=VALUE", type=setting, action="append", default=[]),
        LIMIT,
        option("--only", "gate, probe or bodies alone; again for another (default: all three)",
               "PART", action="append", choices=("gate", "probe", "bodies")),
        option("--json", "all of it as a file too", "FILE", type=Path),
        *pages("a page in a folder of its own there, and beside it the latest question and "
               "answer")), about=CHECKS, ending=CHECKED),
}  # fmt: skip
COMMANDS = {
    "run": Command("run studies; the word may be left out: `poisson` is `run poisson`",
        "run:run_studies", STUDIES, ending=SOLVED, check=check_studies),
    "check": Command("judge studies against theory, agreement bands and the committed baseline",
        "run:run_studies", STUDIES, ending=SOLVED, check=check_studies),
    "list": Command("what can be studied", "run:list_studies", STUDIES, check=check_studies),
    "report": Command("report.html again, from stored results", "run:make_report", STUDIES,
        check=check_studies),
    "advise": Command("spring constants, masses and steps for a material, without a body",
        "advise:print_advice", (
        option("--E", "Young's modulus, 2.8GPa", "E", type=in_si(PRESSURE)),
        option("--nu", "Poisson's ratio", "NU", type=in_si({})),
        option("--spacing", "of the lattice, 2mm", "H", type=in_si(LENGTH)),
        option("--thickness", "of a plane body, 6mm", "T", type=in_si(LENGTH)),
        option("--density", "1000kg/m3 if none is given", "RHO", type=in_si(DENSITY)),
        option("--state", "plane_stress with a thickness, else solid",
               choices=("plane_stress", "plane_strain", "solid")),
        option("--lattice", "this one alone", "NAME"),
        option("--route", "springs, or 'volume energy' (cells beside them)", "ROUTE"),
        option("--engine", "springs: an engine without cells, at the nearest ratio it has; cells: "
               "with them", choices=("springs", "cells")),
        option("--json", "print JSON, in SI units"),
        option("--identify", "which solid a network is: springs.csv (points.csv, cells.csv beside "
               "it), or --lattice", "FILE", nargs="?", const=""),
        option("--period", "edges of a periodic sample: --period 2cm 2cm", "L", nargs="+",
               type=in_si(LENGTH)),
        *(option(f"--{name}", "of a lattice to identify", "K", type=in_si(STIFFNESS))
          for name in CONSTANTS),
        option("--kappa", "of its cells: N/m in the plane, Pa in space", "K",
               type=lambda text: (in_si(STIFFNESS | PRESSURE)(text), text)),
        VERBOSE),
        about="Spring constants, masses and steps for a material, of every lattice that can.",
        ending=ADVISED, check=check_advise),
    "case": Command("your own body: case new, case run, case judge, case export, case schema",
        about="Your own body: from a file to springs, elements, and a verdict.", ending=JUDGED,
        commands=CASES),
    "study": Command("a study of your own: study new NAME writes one that runs",
        about="A study of your own.", commands={
        "new": Command("write a first study, which runs as it is", "new:write_new", (
            option("name", "of the study; NAME.py is written", "NAME"),))}),
    "simulate": Command("your own simulator on a case, judged", "simulators:simulate", (
        option("file", "case file", "CASE", type=Path),
        option("--with", f"command of the adapter, as of a shell: {ADAPTER}", "ADAPTER",
               dest="adapter", required=True),
        *EXPORT, LIMIT,
        *pages("folder in which each case and adapter get a folder of their own (default: "
               "%(default)s)", "reports/simulators")),
        about="Ask a simulator for a case through its adapter, and judge what it answers.",
        ending=SIMULATED),
    "adapter": Command("your own simulator: adapter new, adapter check, adapter laws",
        about="Adapters: programs that run a simulator, as ADAPTER CASE_DIR OUT_DIR.",
        commands=ADAPTERS),
}  # fmt: skip
FIRST = f"""\
What are springs good for, and how wrong are they? First try:

  {PROGRAM} poisson      one study, ten seconds: its findings, and a page to read
  {PROGRAM} list         what can be studied
  {PROGRAM} case new my  a body of your own: writes my.toml
  {PROGRAM} all --quick  every study in its small form, two minutes
  {PROGRAM} --help       all commands
"""
WITHOUT_WORD = COMMANDS["run"]._replace(
    about="Run studies that compare spring networks with elasticity theory and finite elements, "
    "and judge them by their tolerances.",
    ending=f"""\
commands:
{chr(10).join(f"  {name:<10}{command.said}" for name, command in COMMANDS.items())}

  {PROGRAM} COMMAND --help tells the options of one.

examples:
  {PROGRAM} poisson                one study, results in reports/latest
  {PROGRAM} all --quick --out new  every study in its small form, results in new
  {PROGRAM} check --jobs 2         every study judged, two at once

{SOLVED}""",
)


class Parser(argparse.ArgumentParser):
    """One that ends the program with one line for wrong usage, and knows the nearest choice."""

    def __init__(self, **options: Any) -> None:
        # A report shows the command, and must know where a path is in it: no abbreviations.
        raw = argparse.RawDescriptionHelpFormatter
        super().__init__(formatter_class=raw, allow_abbrev=False, **options)
        self._negative_number_matcher = re.compile(r"-\.?\d")  # -.5e3, -1kPa are values

    def error(self, message: str) -> NoReturn:
        """End the program."""
        self.exit(USAGE, f"{PROGRAM}: error: {message}; see {self.prog} --help\n")

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        if action.choices is not None and value not in action.choices:
            said = f"invalid choice: {value!r}: {catalogue.suggestion(value, [*action.choices])}"
            raise argparse.ArgumentError(action, said)


def parse(words: Sequence[str]) -> argparse.Namespace:
    """The command line's options, the function that it asks for (`act`), `verb` and all `words`.

    Wrong usage ends the program with one line and exit code 2; no word at all, with what to do
    first.
    """
    if not words:
        sys.stdout.write(FIRST)
        sys.exit(USAGE)
    first = next((i for i, each in enumerate(words)
                  if not (each.startswith("-") or (i and words[i - 1] in VALUED))), 0)  # fmt: skip
    verb, rest = words[first], [*words[:first], *words[first + 1 :]]
    if verb not in COMMANDS or (first and COMMANDS[verb].options is not STUDIES):
        verb, rest = "", [*words]
    command = COMMANDS.get(verb, WITHOUT_WORD)
    parser = Parser(prog=f"{PROGRAM} {verb}".strip(), **_words_of(command))
    parser.set_defaults(verb=verb or "run", words=words, jobs=1, quiet=False, verbose=False)
    _add(parser, command, verb or "run")
    of_studies = command.options is STUDIES  # whose names may follow options
    read = parser.parse_known_intermixed_args if of_studies else parser.parse_known_args
    args, left = read(rest)
    if left:
        unit = "; write a value and its unit as one, 6mm" if verb == "advise" else ""
        parser.error(f"unrecognized arguments: {' '.join(left)}{unit}")
    command.check(parser, args)
    return args


def _add(parser: argparse.ArgumentParser, command: Command, verb: str) -> None:
    """Add a command's options, and commands below it; those of others are silent."""
    parser.set_defaults(act=command.act)
    quiet = any(each.names[0] == "-q" for each in command.options)
    volume = parser.add_mutually_exclusive_group() if quiet else parser
    for names, settings, of in command.options:
        shown = settings if verb in of or not of else {**settings, "help": argparse.SUPPRESS}
        (volume if names[0] in {"-q", "-v"} else parser).add_argument(*names, **shown)
    if command.commands:
        below = parser.add_subparsers(dest="command", metavar="COMMAND", required=True)
        for name, each in command.commands.items():
            _add(below.add_parser(name, help=each.said, **_words_of(each)), each, verb)


def _words_of(command: Command) -> dict[str, Any]:
    return {"description": command.about or f"{command.said}.", "epilog": command.ending}


def as_shown(arguments: Sequence[str]) -> list[str]:
    """The command as a report shows it, without paths."""
    shown: list[str] = []
    for argument in arguments:
        name, equals, _ = argument.partition("=")
        if shown and shown[-1] in PLACES:
            shown.append(PLACES[shown[-1]])
        elif equals and name in PLACES:
            shown.append(f"{name}={PLACES[name]}")
        else:
            plain = (c if c.isprintable() else "\N{REPLACEMENT CHARACTER}" for c in argument)
            shown.append("".join(plain))
    return [*DOCUMENTED.split(), *shown]
