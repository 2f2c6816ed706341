"""What is said on the terminal: results to stdout, messages to stderr, both in few lines."""

from __future__ import annotations

import contextlib
import logging
import math
import os
import re
import sys
import textwrap
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO

from msvalidate.cli.arguments import FAILED, HELD, PROGRAM, USAGE

if TYPE_CHECKING:
    from msvalidate.cli.outcome import Outcome
    from msvalidate.output.stored import Result, Stored

WIDTH = 100
"""Of findings, in characters."""
FINDINGS = 8
"""Lines of findings a study: with its question and what was left out, ten."""
FIRST_SENTENCE = re.compile(r"(?<=[.!?]) (?=[A-Z])")
FAILURES = 5
"""Failures a study that are told one by one."""


def tell(message: str) -> None:
    """A line to stderr; one that cannot be read any more is not missed."""
    with contextlib.suppress(OSError):
        print(message, file=sys.stderr, flush=True)  # a killed run has said all that it could
        return
    sys.stderr = nowhere()


def tell_error(message: str, code: int) -> int:
    """An error in one line; its exit code."""
    tell(f"{PROGRAM}: error: {message}")
    return code


def attempt(act: Callable[[], int]) -> int:
    """The exit code of what is done; bad input, or no answer, is said in one line."""
    try:
        return act()
    except ImportError as error:
        return tell_error(str(error), USAGE)
    except OSError as error:
        from msvalidate.problem.checks import format_value

        name = format_value(str(error.filename)).strip("'")
        return tell_error(f"{error.strerror}: {name}" if error.filename else str(error), USAGE)
    except (ValueError, RuntimeError) as error:
        from msvalidate.problem import ProblemError, SolverError

        if not isinstance(error, ProblemError | SolverError):
            raise
        return tell_error(str(error), USAGE if isinstance(error, ProblemError) else FAILED)


@contextlib.contextmanager
def naming(said: str, but: tuple[str, ...] = ()) -> Iterator[None]:
    """Let errors begin with what they are about, `but` for those that begin with such words."""
    from msvalidate.problem import ProblemError, SolverError

    try:
        yield
    except (ProblemError, SolverError) as error:
        text = " ".join(str(error).split())
        error.args = (text if text.startswith(but or ("\0",)) else f"{said}: {text}",)
        raise


def print_lines(lines: Sequence[str]) -> int:
    """Lines to stdout; the exit code of a place where they do not fit."""
    try:
        for line in lines:
            print(line)
        print(end="", flush=True)
    except BrokenPipeError:  # the reader left; the verdict stands
        sys.stdout = nowhere()
    except OSError as error:  # a full disk; results are in files
        sys.stdout = nowhere()
        return tell_error(f"stdout: {error.strerror}", USAGE)
    return HELD


def nowhere() -> TextIO:
    """A stream that leads nowhere."""
    return open(os.devnull, "w", encoding="utf-8")  # noqa: PTH123  as long as the process


def summary_lines(result: Result) -> list[str]:
    """What a study asks, and the first sentences of what it finds, in at most ten lines."""
    lines = [f"{result.name}: {result.question.partition(chr(10))[0]}"]
    findings = result.evidence.findings
    wrap = textwrap.TextWrapper(WIDTH, "  - ", "    ", break_on_hyphens=False).wrap
    for place, finding in enumerate(findings):
        wrapped = wrap(FIRST_SENTENCE.split(finding, maxsplit=1)[0])
        if place and len(lines) + len(wrapped) > FINDINGS + 1:
            left = len(findings) - place
            return [*lines, f"  … {left} more finding{'s' * (left > 1)} in the report"]
        lines += wrapped[:FINDINGS]
    return lines


def table_lines(result: Result, names: Sequence[str]) -> list[str]:
    """The tables of these names, whole and aligned; all of them for none."""
    tables: dict[str, Any] = {**result.evidence.tables}
    tables["verdict"] = result.verdict.drop(columns="because")
    return [
        f"\n{result.name}/{name}\n"
        f"{tables[name].to_string(index=False, float_format='{:.6g}'.format)}"
        for name in names or tables
        if name in tables
    ]


def failure_lines(study: Stored | Outcome, where: str) -> list[str]:
    """What a study missed, the worst first and at most five, and where the others are."""
    from msvalidate.output.junit import failure_line

    missed = missed_rows(study)
    lines = []
    for row in missed[:FAILURES]:
        why = f" ({row['because']})" if row["layer"] == "baseline" else ""
        lines.append(f"{study.name}: FAIL {failure_line(row)}{why}")
    if len(missed) > FAILURES:
        lines.append(f"{study.name}: … {len(missed) - FAILURES} more in {where}")
    return lines


def missed_rows(study: Stored | Outcome) -> list[dict[Any, Any]]:
    """Rows of a verdict that were missed, worst first; what is no number, and baseline, last."""
    from msvalidate.judging.evidence import is_missed

    rows = study.verdict[is_missed(study.verdict) & (not study.error)]
    worst = (rows["error"] / rows["limit"]).where(rows["error"] < math.inf)
    rows = rows.assign(last=rows["layer"] == "baseline", worst=worst)
    return rows.sort_values(["last", "worst"], ascending=[True, False]).to_dict("records")


def ending(study: Stored | Outcome) -> str:
    """How a study ended, in one line."""
    rows = 0 if study.error else len(study.verdict)
    missed = len(missed_rows(study))
    said = f"{rows - missed} of {rows} held"
    if study.error:
        said = "not finished"
    elif "candidate" in study.origin:
        counts = Counter(study.verdict["verdict"])
        words = ", ".join(f"{word}: {many}" for word, many in sorted(counts.items()))
        said = f"{study.origin['candidate']}, {rows} rows, {words}"
    elif not study.held:
        said = f"FAILED, {rows} row{'s' * (rows != 1)}: {rows - missed} held, {missed} missed"
    return f"{study.name}: {said}" + (f", {study.seconds:.1f} s" if study.seconds else "")


def ending_of_all(outcomes: Sequence[Outcome], seconds: float) -> str:
    """How several studies ended together, layer by layer."""
    judged, held = Counter[str](), Counter[str]()
    for outcome in outcomes:
        judged.update(outcome.verdict["layer"])
        held.update(outcome.verdict.loc[outcome.verdict["verdict"] == "pass", "layer"])
    layers = [f"{layer} {held[layer]} of {many}" for layer, many in judged.items()]
    whole = f"{sum(each.held for each in outcomes)} of {len(outcomes)} studies held"
    return f"{', '.join([whole, *layers])}, {seconds:.1f} s"


def announce_compilation() -> None:
    """Let a first run say, once, that it compiles kernels, which only it has to wait for."""
    kernels = logging.getLogger("msvalidate.kernels.cache")

    def tell_once(_record: logging.LogRecord) -> bool:
        kernels.removeFilter(tell_once)
        tell("first run: compiling, some 5 to 20 s; later runs find it compiled")
        return False

    kernels.setLevel(logging.INFO)
    kernels.addFilter(tell_once)


class Progress:
    """Steps of something that takes a while: a terminal shows the one that is taken, written over.

    What was done is elsewhere a line of stderr, and a line of the file `log`.
    """

    def __init__(self, name: str, *, shown: bool, log: Path | None = None) -> None:
        self._name, self._shown, self._log = name, shown, log
        self._written_over = shown and sys.stderr.isatty()
        self._lines: list[str] = []

    def __call__(self, step: str) -> None:
        """Say what is being done now."""
        self._show(f"{self._name}: {step} ...")

    def done(self, said: str) -> None:
        """Say what was done."""
        self._lines.append(f"{self._name}: {said}")
        if self._shown and not self._written_over:
            tell(self._lines[-1])
        if self._log is not None:
            from msvalidate_check import exchange

            text = "\n".join([*self._lines, ""])
            with contextlib.suppress(OSError):
                exchange.replace_file(self._log, text.encode)

    def clear(self) -> None:
        """Take the line away."""
        self._show("")

    def _show(self, text: str) -> None:
        if self._written_over:
            sys.stderr.write(f"\r\033[K{text}")
            sys.stderr.flush()
