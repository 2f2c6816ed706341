"""Command line arguments: commands and options of arguments.toml, and usage errors."""

from __future__ import annotations

import argparse
import json
import math
import re
import sys
import tomllib
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NoReturn

from msvalidate import __version__
from msvalidate.bench.judging import catalogue
from msvalidate.case.file.units import DENSITY, LENGTH, PRESSURE, STIFFNESS, TIME, read_quantity

HELD, MISSED, USAGE, FAILED, NOTHING, UNCONVERGED, INTERRUPTED = 0, 1, 2, 3, 4, 5, 130
DOCUMENTED = "python -m msvalidate.study"
"""The program's name in files, whose reader may have started it otherwise."""
CALLS = {"msvalidate": "msvalidate", "__main__": "python -m msvalidate"}
PROGRAM = CALLS.get(Path(sys.argv[0]).stem, DOCUMENTED)
"""Name by which the program was called, for hints and help."""
SIMULATOR = "simulator"
CONSTANTS = ("k1", "k2", "k3")
LATEST, CANDIDATES = Path("reports/latest"), Path("reports/candidate")
"""Default folders of results; those of a candidate do not replace the built-in ones."""
TEXT = Path(__file__).with_suffix(".toml").read_text(encoding="utf-8")
TABLE = tomllib.loads(TEXT.replace("{program}", PROGRAM).replace("{version}", __version__))
"""Commands, options that several share, and texts of help."""
COMMANDS: dict[str, dict[str, Any]] = TABLE["commands"]
"""By name; one below another by both names."""


def options_of(name: str) -> dict[str, dict[str, Any]]:
    """Options of a command: names -> settings, those that all commands share included."""
    options = dict(COMMANDS[name].get("options", {}))
    for shared in (*COMMANDS[name].get("with", ()), "everywhere"):
        options |= TABLE["shared"][shared]
    return {names: TABLE["options"].get(names, {}) | own for names, own in options.items()}


STUDIES = options_of("run")
"""Options of commands about studies."""
VALUED = {name: settings for name, settings in STUDIES.items() if "metavar" in settings}
"""Options that take a value."""
PLACES = {
    name: settings["metavar"]
    for name, settings in VALUED.items()
    if settings.get("type") == "path" or name == "--candidate"
}
"""Options with private values -> text that a report shows instead."""

# What a word may be -------------------------------------------------------------------------------


def word(read: Callable[[str], Any], said: str) -> Callable[[str], Any]:
    """Return a function that reads a word and rejects invalid ones.

    The word is invalid if the given function returns None or raises ValueError; `said` is the
    reason.
    """

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
    """Return a function that reads a whole number of at least a minimum."""
    return word(
        lambda text: int(text) if text.isdecimal() and int(text) >= least else None,
        f"{{!r}} is not a whole number, {least} or more",
    )


def in_si(units: Mapping[str, float]) -> Callable[[str], Any]:
    """Return a function that reads a number with a unit and converts it to SI."""
    unit = f", or one with {', '.join(units)}" if units else ""
    return word(
        lambda text: read_quantity(text, {"": 1.0, **units}),
        f"{{!r}}; give a number in SI units{unit}",
    )


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


TYPES: Mapping[str, Callable[[str], Any]] = {
    "int": int,
    "float": float,
    "file": Path,
    "path": word(lambda text: Path(text) if _line(text) else None, "{!r} is no name; name a place"),
    "line": word(_line, "{!r}; say why in one line"),
    "part": word(
        lambda text: value if 0 <= (value := float(text)) < 1 else None,
        "{!r} is no number from 0 to below 1, such as 6e-8",
    ),
    "names": word(_names, "{!r}; give names with commas between them"),
    "setting": word(_setting, "{!r}; give NAME=VALUE"),
    "from 0": whole(0),
    "from 1": whole(1),
    "number": in_si({}),
    "pressure": in_si(PRESSURE),
    "length": in_si(LENGTH),
    "density": in_si(DENSITY),
    "time": in_si(TIME),
    "stiffness": in_si(STIFFNESS),
    "kappa": lambda text: (in_si(STIFFNESS | PRESSURE)(text), text),
}
"""Name in arguments.toml -> what reads a word."""

# What goes together -------------------------------------------------------------------------------

MODULI = ({"E", "nu"}, {"K", "mu"}, {"lame", "mu"})
"""Pairs of moduli that give a material."""
OF_MATERIAL = {"E", "nu", "K", "lame", "mu", "engine", "json", "state", "step"}
OF_LATTICE = ("lattice", "spacing", *CONSTANTS, "kappa")


def check_advise(parser: argparse.ArgumentParser, args: argparse.Namespace) -> None:
    """End the program if options are missing or do not go together."""
    given = _given(parser, args)
    advises, own = args.identify is None, [name in given for name in CONSTANTS]
    first = CONSTANTS[own.index(False)] if False in own else ""
    pairs = given & {"E", "nu", "K", "lame", "mu"}
    needed = ("E", "nu", "spacing") if pairs <= {"E", "nu"} else ("spacing",)
    missing = [name for name in needed if advises and name not in given]
    of_other = {*CONSTANTS, "kappa", "period", "cubic"} if advises else OF_MATERIAL
    others, of_lattice = sorted(given & of_other), [n for n in OF_LATTICE if n in given]
    where = "goes with" if advises else "does not go with"
    _refuse(parser, {
        f"--{_first(missing)} is missing; give --E, --nu and --spacing": missing,
        "moduli: give --E and --nu, or --K and --mu, or --lambda and --mu":
            advises and pairs not in MODULI,
        f"--{_first(others)} {where} --identify; leave one of them out": others,
        f"--{_first(of_lattice)} is of a lattice, and {args.identify!r} a file; leave it out":
            args.identify and of_lattice,
        "--cubic stands alone with --identify; leave springs.csv and the lattice out":
            args.cubic and (args.identify or of_lattice),
        f"--{first} is missing; give the kinds before it too": own != sorted(own, reverse=True),
    })  # fmt: skip


def check_sweep(parser: argparse.ArgumentParser, args: argparse.Namespace) -> None:
    """End the program if options of a sweep come without its values."""
    words = {each.partition("=")[0] for each in args.words}
    for option in ("--jobs", "--limit", "--scheduler"):
        if option in words and not args.set:
            parser.error(f"{option} is of combinations; give --set too, or leave it out")
    for option in ("--json", "--junit", "--baseline"):
        if option in words and args.set:
            parser.error(f"{option} is of single cases; a sweep writes sweep.csv; leave it out")
    if {"--jobs", "--scheduler"} <= words:
        parser.error("--jobs is of this machine; with --scheduler leave it out")


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
    given = _given(parser, args)
    foreign = [name for name in args.studies if "update" in given and not catalogue.is_ours(name)]
    misplaced = [
        f"{names} goes with {' and '.join(map(repr, settings['of']))} only; leave it out"
        for names, settings in STUDIES.items()
        if names.startswith("-")
        and settings.get("dest", names[2:]) in given
        and verb not in settings.get("of", [verb])
        and not (names == "--junit" and args.candidate)
    ]
    _refuse(parser, {
        f"--update: {_first(foreign)} is a study of your own and has no baseline among ours; give "
        "--baseline DIR, or leave it out": foreign and not args.baseline,
        _first(misplaced): misplaced,
        "--accuracy is that of a candidate; give --candidate too, or leave it out":
            "accuracy" in given and "candidate" not in given,
        "--candidate: name the studies that can judge it, such as displacement":
            "candidate" in given and not args.named,
        "--questions are those of one study; name it alone":
            "questions" in given and not (args.named and len(args.studies) == 1),
    })  # fmt: skip
    args.out = args.out or (CANDIDATES if args.candidate else LATEST)
    args.form = "quick" if args.quick or (checks and not args.full) else "full"


def _given(parser: argparse.ArgumentParser, args: argparse.Namespace) -> set[str]:
    """Names of what is not as it is where nothing is said."""
    return {name for name, value in vars(args).items() if value != parser.get_default(name)}


def _first(found: Sequence[str]) -> str:
    return found[0] if found else ""


def _refuse(parser: argparse.ArgumentParser, wrong: Mapping[str, object]) -> None:
    """End the program with the first words that are true."""
    for said, is_so in wrong.items():
        if is_so:
            parser.error(said)


class Parser(argparse.ArgumentParser):
    """Argument parser that reports wrong usage in one line with the nearest choice."""

    is_bare = False
    """True if the command line has none of the arguments that the command needs."""

    def __init__(self, **options: Any) -> None:
        # A report shows the command, and must know where a path is in it: no abbreviations.
        raw = argparse.RawDescriptionHelpFormatter
        super().__init__(formatter_class=raw, allow_abbrev=False, **options)
        self._negative_number_matcher = re.compile(r"-\.?\d")  # -.5e3, -1kPa are values

    def error(self, message: str) -> NoReturn:
        """End the program; a command without its arguments prints its help."""
        if self.is_bare:
            self.print_help()
            self.exit(USAGE)
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
        sys.stdout.write(TABLE["first"])
        sys.exit(USAGE)
    if [*words[:2]] == ["study", "list"]:
        words = words[1:]
    first = next((i for i, each in enumerate(words)
                  if not (each.startswith("-") or (i and words[i - 1] in VALUED))), 0)  # fmt: skip
    verb, rest = words[first], [*words[:first], *words[first + 1 :]]
    if verb not in COMMANDS or " " in verb or (first and not _is_of_studies(COMMANDS[verb])):
        verb, rest = "", [*words]
    command = COMMANDS[verb] if verb else COMMANDS["run"] | _without_word()
    parser = Parser(prog=f"{PROGRAM} {verb}".strip(), **_words_of(command))
    parser.set_defaults(verb=verb or "run", words=words, jobs=1, quiet=False, verbose=False)
    _add(parser, verb or "run", [*words])
    of_studies = _is_of_studies(command)  # whose names may follow options
    read = parser.parse_known_intermixed_args if of_studies else parser.parse_known_args
    args, left = read(rest)
    if left:
        name = f"{verb} {args.command}" if "command" in args else verb or "run"
        near = catalogue.suggestion(left[0].partition("=")[0], " ".join(options_of(name)).split())
        unit = "; quote a value with its unit, '6 mm'" if verb in {"advise", "adapter"} else ""
        hint = f"; {near}" if left[0].startswith("-") and near.startswith("did") else unit
        parser.error(f"unrecognized arguments: {' '.join(left)}{hint}")
    if of_studies:
        check_studies(parser, args)
    elif "update" in args and args.update and not args.baseline:
        parser.error("--update: no --baseline DIR to write to; name one")
    if "update" in args and args.update != (args.reason is not None):
        parser.error('--update and --reason "..." go together; give both or none')
    if verb == "advise":
        check_advise(parser, args)
    elif "scheduler" in args:
        check_sweep(parser, args)
    return args


def _is_of_studies(command: dict[str, Any]) -> bool:
    return "studies" in command.get("with", ())


def _without_word() -> dict[str, str]:
    """Help of the program itself, which lists the commands."""
    lines = [f"  {name:<10}{c['summary']}" for name, c in COMMANDS.items() if " " not in name]
    about, ending = TABLE["without_word"].values()
    told = ending.format(commands="\n".join(lines), solved=TABLE["endings"]["solved"])
    return {"about": about, "ending": told}


def _add(parser: Parser, name: str, words: Sequence[str]) -> None:
    """Add a command's options, and commands below it; what others alone take is silent."""
    parser.set_defaults(act=COMMANDS[name].get("act"))
    parser.is_bare = words == name.split() and "complete" not in COMMANDS[name]
    options = options_of(name)
    volume = parser.add_mutually_exclusive_group() if "-q --quiet" in options else parser
    for names, given in options.items():
        settings = dict(given)
        default = settings.pop("otherwise", settings.get("default"))
        if name not in settings.pop("of", [name]):
            settings["help"] = argparse.SUPPRESS
        elif default not in (None, "", []):
            settings["help"] += f" (default: {default})"
        if "type" in settings:
            settings["type"] = TYPES[settings["type"]]
        elif not settings.keys() & {"metavar", "choices", "action"}:
            settings["action"] = "store_true"
        (volume if names[:2] in {"-q", "-v"} else parser).add_argument(*names.split(), **settings)
    below = [each for each in COMMANDS if each.startswith(f"{name} ")]
    if below:
        commands = parser.add_subparsers(dest="command", metavar="COMMAND", required=True)
        for each in below:
            texts, summary = _words_of(COMMANDS[each]), COMMANDS[each]["summary"]
            _add(commands.add_parser(each.split()[1], help=summary, **texts), each, words)


def _words_of(command: dict[str, Any]) -> dict[str, Any]:
    """First and last words of a command's help."""
    ending = command.get("ending", "")
    about = command.get("about", f"{command['summary']}.")
    ending = TABLE["endings"].get(ending, ending)
    return {"description": about, "epilog": f"{ending}\ndocumentation: {command['docs']}"}


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
