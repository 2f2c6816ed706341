"""Floor 3: the only module that writes files: tables, figures and one page that a person can read.

Each file is written beside its place and moved there, so that it is whole or not there at all.
"""

from __future__ import annotations

import io
import os
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib as mpl
import pandas as pd
from matplotlib.figure import Figure

from msvalidate.evidence import Evidence, held
from msvalidate.figures import STYLE
from msvalidate.problem import ProblemError

ROWS_SHOWN = 40
"""Longer tables are shown by their first rows; the CSV has them all."""
FORMATS = ("png", "svg")


@dataclass(frozen=True, eq=False)
class Result:
    """A study that ran: its name, docstring, evidence and judgement."""

    name: str
    question: str
    evidence: Evidence
    verdict: pd.DataFrame


def refuse_unwritable(out: Path, names: Sequence[str] = ()) -> None:
    """Raise `ProblemError`, before any work is done, if results could not be written to `out`.

    Parameters
    ----------
    out
        The folder for results.
    names
        Studies whose folders will lie in it.
    """
    for name in names:
        if (out / name).exists() and not (out / name).is_dir():
            raise ProblemError(f"--out {out}: {out / name} is a file; name another folder")
    if (out / "report.md").is_dir():
        raise ProblemError(f"--out {out}: {out / 'report.md'} is a folder; name another one")
    if out.is_symlink() and not out.exists():
        raise ProblemError(f"--out {out}: a link to nowhere; name another folder")
    for folder in (out, *out.parents):
        if folder.is_dir():
            if os.access(folder, os.W_OK | os.X_OK):
                return
            raise ProblemError(f"--out {out}: no permission to write there; name another folder")
        if folder.exists():
            raise ProblemError(f"--out {out}: {folder} is a file; name a folder")
    raise ProblemError(f"--out {out}: no such place; name another folder")


def write_study(result: Result, out: Path, *, plots: bool = True) -> None:
    """Write a study's CSV, PNG and SVG files to `out`/name; without plots, old ones are removed."""
    folder = out / result.name
    pages: dict[str, bytes] = {
        f"{name}.csv": table.to_csv(index=False, lineterminator="\n").encode()
        for name, table in {**result.evidence.tables, "verdict": result.verdict}.items()
    }
    stale = []
    for name, draw in result.evidence.figures.items():
        if plots:
            with mpl.rc_context(STYLE):
                figure = draw(result.evidence.tables)
                _lay_out(figure)
                pages |= {f"{name}.{kind}": _rendered(figure, kind) for kind in FORMATS}
        else:
            stale += [folder / f"{name}.{kind}" for kind in FORMATS]
    folder.mkdir(parents=True, exist_ok=True)
    for name, content in pages.items():
        _write(folder / name, content)
    for path in stale:  # a picture of other numbers than those beside it would mislead
        path.unlink(missing_ok=True)


def write_report(
    results: list[Result],
    unfinished: Mapping[str, str],
    origin: Mapping[str, str],
    out: Path,
    *,
    plots: bool = True,
) -> None:
    """Write `out`/report.md on the studies of one command.

    Parameters
    ----------
    results
        Studies that ran.
    unfinished
        Study -> the error that ended it.
    origin
        Provenance, label -> value.
    """
    parts = ["# msvalidate report", "", *_summary(results, unfinished)]
    for result in results:
        parts += ["", *_section(result, plots=plots)]
    parts += ["", "## Provenance", "", "| | |", "| --- | --- |"]
    parts += [f"| {label} | {value} |" for label, value in origin.items()]
    out.mkdir(parents=True, exist_ok=True)
    _write(out / "report.md", ("\n".join(parts) + "\n").encode())


def text_table(table: pd.DataFrame, rows: int | None = ROWS_SHOWN) -> str:
    """Aligned text of a table; beyond `rows`, how many more there are."""
    text = table.head(rows).to_string(index=False, float_format=_number) if rows else ""
    if rows is None:
        return table.to_string(index=False, float_format=_number)
    return text + (f"\n… {len(table) - rows} more rows" if len(table) > rows else "")


def _summary(results: list[Result], unfinished: Mapping[str, str]) -> list[str]:
    lines = ["| study | verdict | tolerances held |", "| --- | --- | --- |"]
    for result in results:
        passed = int((result.verdict["verdict"] == "pass").sum())
        word = "**pass**" if held(result.verdict) else "**FAIL**"
        lines.append(f"| {result.name} | {word} | {passed} of {len(result.verdict)} |")
    lines += [f"| {name} | **not finished** | {why} |" for name, why in unfinished.items()]
    return lines


def _section(result: Result, *, plots: bool) -> list[str]:
    evidence = result.evidence
    lines = [f"## {result.name}", "", result.question]
    if evidence.findings:
        lines += ["", "### Findings", "", *(f"- {finding}" for finding in evidence.findings)]
    lines += ["", "### Tolerances", "", _markdown(result.verdict)]
    if plots and evidence.figures:
        lines += ["", "### Figures", ""]
        for name, draw in evidence.figures.items():
            caption = (draw.__doc__ or name).partition("\n")[0]
            lines += [f"![{caption}]({result.name}/{name}.png)", "", f"*{caption}*", ""]
    lines += ["", "### Tables"]
    for name, table in evidence.tables.items():
        lines += ["", f"**{name}** ([CSV]({result.name}/{name}.csv), {len(table)} rows)", ""]
        lines.append(_markdown(table.head(ROWS_SHOWN)))
        if len(table) > ROWS_SHOWN:
            lines.append(f"\n… {len(table) - ROWS_SHOWN} more rows in the CSV")
    used = {column for table in evidence.tables.values() for column in table}
    lines += ["", "### Columns", "", "| column | meaning |", "| --- | --- |"]
    lines += [f"| {c} | {text} |" for c, text in evidence.columns.items() if c in used]
    return lines


def _markdown(table: pd.DataFrame) -> str:
    # As text: the writer would read numbers out of words such as 0.2000, and drop their digits.
    shown = table.map(lambda value: _number(value) if isinstance(value, float) else str(value))
    align = ["right" if kind.kind in "if" else "left" for kind in table.dtypes]
    return str(shown.to_markdown(index=False, disable_numparse=True, colalign=align))


def _number(value: float) -> str:
    return f"{value:.6g}"


def _lay_out(figure: Figure) -> None:
    """Lay out once, not again for each format."""
    engine = figure.get_layout_engine()
    if engine is not None:
        engine.execute(figure)
        figure.set_layout_engine("none")


def _rendered(figure: Figure, kind: str) -> bytes:
    page = io.BytesIO()
    # A date inside the file would make two equal pictures differ.
    figure.savefig(page, format=kind, metadata={"Date": None} if kind == "svg" else None)
    return page.getvalue()


def _write(path: Path, content: bytes) -> None:
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        Path(name).chmod(0o644)
        Path(name).replace(path)
    except OSError as error:  # named after the file that was wanted, not the one beside it
        Path(name).unlink(missing_ok=True)
        raise OSError(error.errno, error.strerror, str(path)) from error
    except BaseException:
        Path(name).unlink(missing_ok=True)
        raise
