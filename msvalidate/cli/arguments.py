"""What the command line takes: names, options, exit codes, and how a report shows it."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from pathlib import Path

from msvalidate import __version__
from msvalidate.judging import catalogue

HELD, MISSED, USAGE, FAILED, NOTHING, INTERRUPTED = 0, 1, 2, 3, 4, 130
PROGRAM = "python -m msvalidate.study"
VERBS = ("list", "check", "report")
"""Names that are no studies."""
PLACES = {"--out": "DIR", "--junit": "FILE", "--studies": "DIR"}
"""Options whose value is the reader's own affair: option -> what a report shows in its place."""
EPILOG = f"""\
examples:
  {PROGRAM} list                   what can be studied
  {PROGRAM} poisson                one study, results in reports/latest
  {PROGRAM} all --quick --out new  every study in its small form, results in new
  {PROGRAM} check                  every study against theory, bands and baseline
  {PROGRAM} check poisson          one study against them
  {PROGRAM} check --jobs 2         every study, two at once
  {PROGRAM} report                 report.html again, from stored results

exit codes:
  0  every tolerance held       2  wrong usage or bad input             4  nothing to compare with
  1  a tolerance was missed     3  a solver failed or a study crashed   130  interrupted
"""


def parse(arguments: Sequence[str]) -> argparse.Namespace:
    """The command line's options, and `verb` ("run" or one of `VERBS`), `studies` and `form`.

    `named` is whether the studies were named one by one. Wrong usage ends the program with one line
    and exit code 2.
    """
    parser = _parser()
    args = parser.parse_intermixed_args(arguments)  # names may follow options
    args.verb = args.names[0] if args.names[0] in VERBS else "run"
    asked = args.names[args.verb != "run" :]
    _refuse_mixed(parser, args.names, asked)
    _join(parser, args.folders)
    known = catalogue.names()
    args.named = asked not in ([], ["all"])
    args.studies = list(dict.fromkeys(asked)) if args.named else known
    for name in args.studies:
        if name not in known:
            parser.error(f"unknown study {name!r}: {catalogue.suggestion(name)}")
    foreign = [name for name in args.studies if args.update and not catalogue.is_ours(name)]
    if foreign:
        parser.error(
            f"--update: {foreign[0]} is a study of your own and has no baseline; leave it out"
        )
    args.form = "quick" if args.quick or (args.verb == "check" and not args.full) else "full"
    _refuse_misplaced(parser, args)
    return args


def _join(parser: argparse.ArgumentParser, folders: Sequence[Path]) -> None:
    """Let a user's own studies be found, or end the program with the reason why not."""
    try:
        catalogue.check_joined()
        for folder in folders:
            catalogue.join(folder)
    except ImportError as error:
        parser.error(str(error))


def _refuse_mixed(
    parser: argparse.ArgumentParser, names: Sequence[str], asked: Sequence[str]
) -> None:
    """End the program if a word that is no study stands where it does not belong."""
    for alone, among in (("list", names), ("report", names), ("all", asked)):
        if alone in among and len(among) > 1:
            parser.error(f"{alone!r} stands alone; leave the other names out")
    if "check" in asked:
        parser.error("'check' comes first, and once; move it before the studies")


def _refuse_misplaced(parser: argparse.ArgumentParser, args: argparse.Namespace) -> None:
    for option, value in (
        ("--full", args.full),
        ("--update", args.update),
        ("--junit", args.junit),
    ):
        if value and args.verb != "check":
            parser.error(f"{option} goes with 'check' only; leave it out")
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


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog=PROGRAM,
        description="Run studies that compare spring networks with elasticity theory and finite "
        "elements, and judge them by their tolerances.",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,  # a report shows the command, and must know where a path is in it
    )
    parser.add_argument(
        "names",
        nargs="+",
        metavar="NAME",
        help="studies to run, 'all' of them; 'list' to see what there is, 'check' to judge all, or "
        "those named after it, by theory, agreement bands and the committed baseline, 'report' to "
        "make report.html again",
    )
    parser.add_argument("--quick", action="store_true", help="the small form: fewer sizes")
    parser.add_argument(
        "--out",
        type=_path,
        default=Path("reports/latest"),
        metavar="DIR",
        help="folder for tables, figures, report.html and verdict.json (default: %(default)s)",
    )
    parser.add_argument(
        "--studies",
        dest="folders",
        action="append",
        type=_path,
        default=[],
        metavar="DIR",
        help="a folder with studies of your own, each a module with a function run; may be given "
        "again for another",
    )
    parser.add_argument(
        "--seed",
        type=_whole(0),
        default=0,
        metavar="N",
        help="where random numbers start (default: %(default)s)",
    )
    parser.add_argument(
        "--jobs",
        type=_whole(1),
        default=1,
        metavar="N",
        help="studies that run at once, each in a process of its own, on one thread; those that "
        "compare times run last and alone; numbers do not depend on it (default: %(default)s)",
    )
    parser.add_argument(
        "--no-plots", dest="plots", action="store_false", help="write tables and report only"
    )
    parser.add_argument(
        "--table",
        dest="tables",
        action="append",
        default=[],
        metavar="TABLE",
        help="print this table alone, and whole; may be given again for another",
    )
    _add_check(parser)
    volume = parser.add_mutually_exclusive_group()
    volume.add_argument("-q", "--quiet", action="store_true", help="print failures only")
    volume.add_argument(
        "-v", "--verbose", action="store_true", help="print whole tables, and tracebacks of crashes"
    )
    # One line, without the usage.
    parser.error = lambda message: parser.exit(  # type: ignore[method-assign]
        USAGE, f"{PROGRAM}: error: {message}; see --help\n"
    )
    parser.add_argument("--version", action="version", version=f"msvalidate {__version__}")
    return parser


def _add_check(parser: argparse.ArgumentParser) -> None:
    check = parser.add_argument_group("with check")
    check.add_argument("--full", action="store_true", help="the full form, not the small one")
    check.add_argument(
        "--update",
        action="store_true",
        help="make what is found the baseline of the studies that were run, if all holds",
    )
    check.add_argument(
        "--reason", type=_line, metavar="TEXT", help="why it moved, for CHANGELOG.md"
    )
    check.add_argument("--junit", type=_path, metavar="FILE", help="write a JUnit file for a CI")


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
    return [*PROGRAM.split(), *words]


def _path(text: str) -> Path:
    if not text.strip() or not text.isprintable():
        raise argparse.ArgumentTypeError(f"{text!r} is no name; name a place")
    return Path(text)


def _line(text: str) -> str:
    if not text.strip() or not text.isprintable():
        raise argparse.ArgumentTypeError(f"{text!r}; say why in one line")
    return text.strip()


def _whole(least: int) -> Callable[[str], int]:
    def number(text: str) -> int:
        try:
            value = int(text)
        except ValueError:
            value = least - 1
        if value < least:
            raise argparse.ArgumentTypeError(f"{text!r} is not a whole number, {least} or more")
        return value

    return number
