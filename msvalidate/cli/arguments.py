"""What the command line takes: names, options, exit codes, and how a report shows it."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any, NoReturn

from msvalidate import __version__
from msvalidate.judging import catalogue

HELD, MISSED, USAGE, FAILED, NOTHING, INTERRUPTED = 0, 1, 2, 3, 4, 130
DOCUMENTED = "python -m msvalidate.study"
"""The program's name in files, whose reader may have started it otherwise."""
CALLS = {"msvalidate": "msvalidate", "__main__": "python -m msvalidate"}
PROGRAM = CALLS.get(Path(sys.argv[0]).stem, DOCUMENTED)
"""Its name as it was called, for hints and help."""
VERBS = {
    "run": "run studies; the word may be left out: `poisson` is `run poisson`",
    "check": "judge studies against theory, agreement bands and the committed baseline",
    "list": "what can be studied",
    "report": "report.html again, from stored results",
}
"""Commands, and what each does."""
PLACES = {
    "--out": "DIR",
    "--junit": "FILE",
    "--studies": "DIR",
    "--baseline": "DIR",
    "--candidate": "MODULE:FUNCTION",
}
"""Options whose value is the reader's own affair: option -> what a report shows in its place."""
VALUED = {*PLACES, "--seed", "--jobs", "--table", "--reason", "--accuracy", "--questions"}
"""Options that take the next word."""
LATEST, CANDIDATES = Path("reports/latest"), Path("reports/candidate")
"""Where results go: those of a candidate do not take the place of our own."""
OTHERS = {
    "advise": "spring constants, masses and steps for a material, without a body",
    "case": "your own body: case new, case run, case judge, case export, case schema",
    "study": "a study of your own: study new NAME writes one that runs",
    "simulate": "your own simulator on a case, judged",
    "adapter": "your own simulator: adapter new, adapter check, adapter laws",
}
"""Commands with a line of their own."""
COMMANDS = "\n".join(f"  {verb:<10}{said}" for verb, said in {**VERBS, **OTHERS}.items())
FIRST = f"""\
What are springs good for, and how wrong are they? First try:

  {PROGRAM} poisson      one study, ten seconds: its findings, and a page to read
  {PROGRAM} list         what can be studied
  {PROGRAM} case new my  a body of your own: writes my.toml
  {PROGRAM} all --quick  every study in its small form, two minutes
  {PROGRAM} --help       all commands
"""
EXIT_CODES = """\
exit codes:
  0  every tolerance held       2  wrong usage or bad input             4  nothing to compare with
  1  a tolerance was missed     3  a solver failed or a study crashed   130  interrupted
"""
EPILOG = f"""\
commands:
{COMMANDS}

  {PROGRAM} COMMAND --help tells the options of one.

examples:
  {PROGRAM} poisson                one study, results in reports/latest
  {PROGRAM} all --quick --out new  every study in its small form, results in new
  {PROGRAM} check --jobs 2         every study judged, two at once

{EXIT_CODES}"""


class Parser(argparse.ArgumentParser):
    """One that ends the program with one line for wrong usage, and knows the nearest choice."""

    def __init__(self, **options: Any) -> None:
        # A report shows the command, and must know where a path is in it: no abbreviations.
        raw = argparse.RawDescriptionHelpFormatter
        super().__init__(formatter_class=raw, allow_abbrev=False, **options)

    def error(self, message: str) -> NoReturn:
        """End the program."""
        self.exit(USAGE, f"{PROGRAM}: error: {message}; see {self.prog} --help\n")

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        if action.choices is not None and value not in action.choices:
            said = f"invalid choice: {value!r}: {catalogue.suggestion(value, [*action.choices])}"
            raise argparse.ArgumentError(action, said)


def parse(arguments: Sequence[str]) -> argparse.Namespace:
    """The command line's options, and `verb` (one of `VERBS`), `studies` and `form`.

    `named` is whether the studies were named one by one. Wrong usage ends the program with one line
    and exit code 2; no word at all, with what to do first.
    """
    if not arguments:
        sys.stdout.write(FIRST)
        sys.exit(USAGE)
    verb, words = _verb(arguments)
    parser = _parser(verb)
    args = parser.parse_intermixed_args(words)  # names may follow options
    args.verb = verb or "run"
    _refuse_mixed(parser, args.verb, args.names)
    _join(parser, args.folders)
    known = catalogue.names()
    args.named = args.names not in ([], ["all"])
    args.studies = list(dict.fromkeys(args.names)) if args.named else known
    for name in args.studies:
        if name not in known:
            parser.error(f"unknown study {name!r}: {catalogue.suggestion(name)}")
    foreign = [name for name in args.studies if args.update and not catalogue.is_ours(name)]
    if foreign and not args.baseline:
        parser.error(
            f"--update: {foreign[0]} is a study of your own and has no baseline among ours; give "
            "--baseline DIR, or leave it out"
        )
    _refuse_partial(parser, args)
    args.out = args.out or (CANDIDATES if args.candidate else LATEST)
    args.form = "quick" if args.quick or (args.verb == "check" and not args.full) else "full"
    _refuse_misplaced(parser, args)
    return args


def _verb(arguments: Sequence[str]) -> tuple[str, list[str]]:
    """The command, "" for none, and the other words: it is the first that is no option's."""
    for place, word in enumerate(arguments):
        if word.startswith("-") or (place and arguments[place - 1] in VALUED):
            continue
        if word in VERBS:
            return word, [*arguments[:place], *arguments[place + 1 :]]
        break
    return "", list(arguments)


def _join(parser: argparse.ArgumentParser, folders: Sequence[Path]) -> None:
    """Let a user's own studies be found, or end the program with the reason why not."""
    try:
        catalogue.check_joined()
        for folder in folders:
            catalogue.join(folder)
    except ImportError as error:
        parser.error(str(error))


def _refuse_mixed(parser: argparse.ArgumentParser, verb: str, names: Sequence[str]) -> None:
    """End the program if a word stands where it does not belong, or one is missing."""
    if verb == "run" and not names:
        parser.error("no study named; name some, or 'all'")
    if verb in {"list", "report"} and names:
        parser.error(f"{verb!r} stands alone; leave the other names out")
    if "all" in names and len(names) > 1:
        parser.error("'all' stands alone; leave the other names out")
    for word in (*OTHERS, *VERBS):
        if word in names and word in {"list", "report"}:
            parser.error(f"{word!r} stands alone; leave the other names out")
        if word in names:
            parser.error(f"{word!r} comes first, and once; move it before the studies")


def _refuse_misplaced(parser: argparse.ArgumentParser, args: argparse.Namespace) -> None:
    options = ("full", "update", "baseline", *(() if args.candidate else ("junit",)))
    given = [option for option in options if getattr(args, option)]
    if given and args.verb != "check":
        parser.error(f"--{given[0]} goes with 'check' only; leave it out")
    if args.tables and args.verb != "run":
        parser.error(f"{args.verb} prints no tables; leave --table out")
    solves = args.quick or args.seed or not args.plots or args.jobs > 1
    if args.verb in {"list", "report"} and solves:
        parser.error(
            f"{args.verb} solves nothing; leave --quick, --seed, --jobs and --no-plots out"
        )
    if args.update != (args.reason is not None):
        parser.error('--update and --reason "..." go together; give both or none')
    if args.verb == "check" and (args.quick or args.seed):
        parser.error("check has its own form and seed; leave --quick and --seed out")


def _refuse_partial(parser: argparse.ArgumentParser, args: argparse.Namespace) -> None:
    """End the program if a candidate, or some questions, are asked for where they cannot be."""
    options = ("candidate", "accuracy", "questions")
    given = [option for option in options if getattr(args, option) is not None]
    if given and args.verb != "run":
        parser.error(
            f"--{given[0]} goes with 'run' only: check holds our own whole studies to their "
            "baseline; leave it out"
        )
    if args.accuracy is not None and args.candidate is None:
        parser.error("--accuracy is that of a candidate; give --candidate too, or leave it out")
    if args.candidate is not None and not args.named:
        parser.error("--candidate: name the studies that can judge it, such as displacement")
    if args.questions is not None and (not args.named or len(args.studies) > 1):
        parser.error("--questions are those of one study; name it alone")


def _parser(verb: str) -> argparse.ArgumentParser:
    """What takes all options, and helps with those of one command."""
    parser = Parser(
        prog=f"{PROGRAM} {verb}".strip(),
        description=f"{VERBS[verb]}."
        if verb
        else "Run studies that compare spring networks with "
        "elasticity theory and finite elements, and judge them by their tolerances.",
        epilog=EXIT_CODES if verb in {"run", "check"} else None if verb else EPILOG,
    )
    # Options of other commands are known, so that what is misplaced can be told; help is silent.
    runs, checks = verb in {"", "run"}, verb == "check"
    solves = runs or checks

    def told(shown: bool, text: str) -> str:
        return text if shown else argparse.SUPPRESS

    parser.add_argument(
        "names",
        nargs="*",
        metavar="NAME",
        help=told(solves, "studies, or 'all' of them; check judges all if none is named"),
    )
    add = parser.add_argument
    add("--quick", action="store_true", help=told(runs, "the small form: fewer sizes"))
    add(
        "--out",
        type=_path,
        default=None,
        metavar="DIR",
        help=told(
            verb != "list",
            f"folder for tables, figures, report.html and verdict.json (default: {LATEST}"
            + (f"; with --candidate {CANDIDATES})" if runs else ")"),
        ),
    )
    add(
        "--studies",
        dest="folders",
        action="append",
        type=_path,
        default=[],
        metavar="DIR",
        help="a folder with studies of your own, each a module with a function run; may be given "
        "again for another",
    )
    add(
        "--seed",
        type=_whole(0),
        default=0,
        metavar="N",
        help=told(runs, "where random numbers start (default: %(default)s)"),
    )
    add(
        "--jobs",
        type=_whole(1),
        default=1,
        metavar="N",
        help=told(
            solves,
            "studies that run at once, each in a process of its own, on one thread; those that "
            "compare times run last and alone; numbers do not depend on it (default: %(default)s)",
        ),
    )
    add(
        "--no-plots",
        dest="plots",
        action="store_false",
        help=told(solves, "write tables and report only"),
    )
    add(
        "--table",
        dest="tables",
        action="append",
        default=[],
        metavar="TABLE",
        help=told(runs, "print this table alone, and whole; may be given again for another"),
    )
    _add_candidate(add, partial(told, runs))
    _add_check(add, partial(told, checks))
    _add_volume(parser)
    return parser


def _add_volume(parser: argparse.ArgumentParser) -> None:
    volume = parser.add_mutually_exclusive_group()
    volume.add_argument("-q", "--quiet", action="store_true", help="print failures only")
    volume.add_argument(
        "-v", "--verbose", action="store_true", help="print all tables, and tracebacks of crashes"
    )
    parser.add_argument("--version", action="version", version=f"msvalidate {__version__}")


def _add_candidate(add: Callable[..., Any], told: Callable[[str], str]) -> None:
    add(
        "--candidate",
        type=_line,
        metavar="MODULE:FUNCTION",
        help=told("judge this in the place of our springs; file.py:function too. It is run"),
    )
    add(
        "--accuracy",
        type=_part,
        metavar="A",
        help=told(
            "error of the candidate's positions over the largest coordinate; by default 6e-8, "
            "that of single precision"
        ),
    )
    add(
        "--questions",
        type=_names,
        metavar="A,B",
        help=told("only these questions of the one study that is named"),
    )


def _add_check(add: Callable[..., Any], told: Callable[[str], str]) -> None:
    add("--full", action="store_true", help=told("the full form, not the small one"))
    add(
        "--update",
        action="store_true",
        help=told("make what is found the baseline of the studies that were run, if all holds"),
    )
    add("--reason", type=_line, metavar="TEXT", help=told("why it moved, for REASONS.md beside it"))
    add(
        "--baseline",
        type=_path,
        metavar="DIR",
        help=told("a baseline of your own in the place of ours; its REASONS.md says why it moved"),
    )
    add("--junit", type=_path, metavar="FILE", help=told("write a JUnit file for a CI"))


def as_shown(arguments: Sequence[str]) -> list[str]:
    """The command as a report shows it, without paths."""
    words: list[str] = []
    for argument in arguments:
        option, equals, _ = argument.partition("=")
        if words and words[-1] in PLACES:
            words.append(PLACES[words[-1]])
        elif equals and option in PLACES:
            words.append(f"{option}={PLACES[option]}")
        else:
            plain = (c if c.isprintable() else "\N{REPLACEMENT CHARACTER}" for c in argument)
            words.append("".join(plain))
    return [*DOCUMENTED.split(), *words]


def _path(text: str) -> Path:
    if not text.strip() or not text.isprintable():
        raise argparse.ArgumentTypeError(f"{text!r} is no name; name a place")
    return Path(text)


def _line(text: str) -> str:
    if not text.strip() or not text.isprintable():
        raise argparse.ArgumentTypeError(f"{text!r}; say why in one line")
    return text.strip()


def _part(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = -1.0
    if not 0 <= value < 1:
        raise argparse.ArgumentTypeError(f"{text!r} is no number from 0 to below 1, such as 6e-8")
    return value


def _names(text: str) -> tuple[str, ...]:
    found = tuple(dict.fromkeys(name.strip() for name in text.split(",")))
    if not all(found) or not text.isprintable():
        raise argparse.ArgumentTypeError(f"{text!r}; give names with commas between them")
    return found


def _whole(least: int) -> Callable[[str], int]:
    def number(text: str) -> int:
        if not text.isdecimal() or int(text) < least:
            raise argparse.ArgumentTypeError(f"{text!r} is not a whole number, {least} or more")
        return int(text)

    return number
