"""Floor 5: the command line, ``python -m msvalidate.study NAME``.

It defines no types and is imported by nobody: run as a module it is ``__main__``, and whatever it
defined would exist twice. Heavy imports wait until a study is really run.
"""

from __future__ import annotations

import argparse
import gc
import os
import sys
import traceback
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

from msvalidate import __version__, catalogue

if TYPE_CHECKING:
    from msvalidate.report import Result

HELD, MISSED, USAGE, FAILED, INTERRUPTED = 0, 1, 2, 3, 130
PROGRAM = "python -m msvalidate.study"
EPILOG = f"""\
examples:
  {PROGRAM} list                   what can be studied
  {PROGRAM} poisson                one study, results in reports/latest
  {PROGRAM} all --quick --out new  every study in its small form, results in new

exit codes:
  0  every tolerance held       2  wrong usage or bad input
  1  a tolerance was missed     3  a solver failed or a study crashed   130  interrupted
"""


def main(arguments: Sequence[str]) -> int:
    """Run what the command line asks for; return the exit code."""
    args = _parser().parse_args(arguments)
    if args.names == ["list"]:
        width = max(map(len, catalogue.names()))
        for name in catalogue.names():
            print(f"{name:<{width}}  {catalogue.question(name)}")
        return HELD
    for alone in ("list", "all"):
        if alone in args.names and len(args.names) > 1:
            return _error(f"{alone!r} stands alone; leave the other names out", USAGE)
    known = catalogue.names()
    names = known if args.names == ["all"] else list(dict.fromkeys(args.names))
    for name in names:
        if name not in known:
            return _error(f"unknown study {name!r}: {catalogue.suggestion(name)}", USAGE)
    return _run(names, args, arguments)


def _run(names: list[str], args: argparse.Namespace, arguments: Sequence[str]) -> int:
    # One thread for dense algebra: the sparse solves here gain nothing from more, and sums come out
    # the same on any number of cores.
    for library in ("OPENBLAS", "MKL", "OMP"):
        os.environ.setdefault(f"{library}_NUM_THREADS", "1")
    from msvalidate import report
    from msvalidate.evidence import held
    from msvalidate.problem import ProblemError
    from msvalidate.provenance import provenance

    started = datetime.now(UTC)
    try:
        report.refuse_unwritable(args.out, names)
        for name in names:
            catalogue.load(name)
        gc.freeze()  # the libraries' objects stay: no use in looking through them again and again
        results, unfinished, codes = _studied(names, args)
        origin = provenance(_command(arguments), args.seed, started)
        for result in results:
            report.write_study(result, args.out, plots=args.plots)
        report.write_report(results, unfinished, origin, args.out, plots=args.plots)
    except (ProblemError, ImportError) as error:
        return _error(str(error), USAGE)
    except OSError as error:
        return _error(f"--out {args.out}: {error.strerror}: {error.filename}", USAGE)
    missed = any(not held(result.verdict) for result in results)
    try:
        for result in results:
            _show(result, args)
        print(end="", flush=True)
    except BrokenPipeError:  # the reader left; the verdict stands
        sys.stdout = None
    if not args.quiet:
        print(f"results in {args.out}", file=sys.stderr)
    return max([*codes, MISSED if missed else HELD])


def _studied(
    names: list[str], args: argparse.Namespace
) -> tuple[list[Result], dict[str, str], list[int]]:
    """Run the studies: those that finished, the errors of those that did not, and exit codes.

    One that fails does not keep the others from running.
    """
    from msvalidate.evidence import judge
    from msvalidate.problem import ProblemError, SolverError
    from msvalidate.report import Result
    from msvalidate.sweep import Setting

    setting = Setting(quick=args.quick, seed=args.seed, progress=not args.quiet)
    results, unfinished, codes = [], {}, []
    for name in names:
        if args.verbose:
            print(f"{name}: {catalogue.question(name)}", file=sys.stderr)
        try:
            module = catalogue.load(name)
            evidence = module.run(setting=setting)
            results.append(Result(name, module.__doc__ or "", evidence, judge(evidence)))
        except (ProblemError, SolverError) as error:
            unfinished[name] = str(error)
            codes.append(USAGE if isinstance(error, ProblemError) else FAILED)
        except Exception as error:  # noqa: BLE001  a crash is reported as one, and spoils nothing else
            # What a crash says may hold paths of this machine: for the terminal, not the report.
            unfinished[name] = f"crashed: {type(error).__name__}"
            codes.append(_error(f"study {name}: crashed: {type(error).__name__}: {error}", FAILED))
            if args.verbose:
                traceback.print_exc()
            continue
        if name in unfinished:
            _error(f"study {name}: {unfinished[name]}", FAILED)
    return results, unfinished, codes


def _show(result: Result, args: argparse.Namespace) -> None:
    """Print a study's tables to stdout, and what failed to stderr."""
    from msvalidate.report import text_table

    if not args.quiet:
        tables: dict[str, Any] = {**result.evidence.tables}
        tables["verdict"] = result.verdict.drop(columns="because")
        for name, table in tables.items():
            print(f"\n{result.name}/{name}")
            print(text_table(table, None if args.verbose else 40))
        print()
        for finding in result.evidence.findings:
            print(f"- {finding}")
    for row in result.verdict.itertuples():
        if row.verdict != "pass":
            print(
                f"{result.name}: FAIL {row.quantity}: observed {row.observed:.9g}, reference "
                f"{row.reference:.9g}, error {row.error:.3g} > limit {row.limit:.3g} {row.unit}",
                file=sys.stderr,
            )
    passed = int((result.verdict["verdict"] == "pass").sum())
    if not args.quiet:
        word = "held" if passed == len(result.verdict) else "FAILED"
        summary = f"{result.name}: {word}, {passed} of {len(result.verdict)} tolerances"
        print(summary, file=sys.stderr)


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
        help="studies to run, 'all' of them, or 'list' to see what there is",
    )
    parser.add_argument("--quick", action="store_true", help="the small form: fewer sizes")
    parser.add_argument(
        "--out",
        type=_folder,
        default=Path("reports/latest"),
        metavar="DIR",
        help="folder for tables, figures and report.md (default: %(default)s)",
    )
    parser.add_argument(
        "--seed",
        type=_seed,
        default=0,
        metavar="N",
        help="where random numbers start (default: %(default)s)",
    )
    parser.add_argument(
        "--no-plots", dest="plots", action="store_false", help="write tables and report only"
    )
    volume = parser.add_mutually_exclusive_group()
    volume.add_argument("-q", "--quiet", action="store_true", help="print failures only")
    volume.add_argument(
        "-v", "--verbose", action="store_true", help="print whole tables, and tracebacks of crashes"
    )
    parser.error = _usage_error  # type: ignore[method-assign]  # one line, without the usage
    parser.add_argument("--version", action="version", version=f"msvalidate {__version__}")
    return parser


def _folder(text: str) -> Path:
    if not text.strip() or "\0" in text:
        raise argparse.ArgumentTypeError(f"{text!r} is no name; name a folder")
    return Path(text)


def _seed(text: str) -> int:
    try:
        seed = int(text)
    except ValueError:
        seed = -1
    if seed < 0:
        raise argparse.ArgumentTypeError(f"{text!r} is not a whole number, 0 or more")
    return seed


def _command(arguments: Sequence[str]) -> list[str]:
    """The command as a report shows it: the folder after --out is the reader's own affair."""
    shown: list[str] = []
    for argument in arguments:
        if shown and shown[-1] == "--out":
            shown.append("DIR")
        else:
            shown.append("--out=DIR" if argument.startswith("--out=") else argument)
    return [*PROGRAM.split(), *shown]


def _usage_error(message: str) -> NoReturn:
    sys.exit(_error(f"{message}; see --help", USAGE))


def _error(message: str, code: int) -> int:
    print(f"{PROGRAM}: error: {message}", file=sys.stderr)
    return code


if __name__ == "__main__":
    for stream in (sys.stdout, sys.stderr):
        stream.reconfigure(errors="replace")  # type: ignore[union-attr]
    try:
        code = main(sys.argv[1:])
        print(end="", flush=True)
        sys.exit(code)
    except OSError as error:  # a closed pipe or a full disk behind stdout; results are in files
        sys.stdout = None  # nothing more is flushed at exit
        broken = isinstance(error, BrokenPipeError)
        sys.exit(HELD if broken else _error(f"stdout: {error.strerror}", USAGE))
    except KeyboardInterrupt:
        sys.exit(_error("interrupted; files already written are whole", INTERRUPTED))
