"""Write docs/studies: a page a study, from the results of a full run.

    python -m msvalidate.study all        # in the full form, results in reports/latest
    python docs/write_studies.py          # from there; another folder may be named

Each page says what the study finds and asks, and what it holds itself to; tables are named, with
where their columns are explained. Its pictures are drawn by `docs/draw_pictures.py`.
"""

from __future__ import annotations

import inspect
import sys
import tomllib
from collections.abc import Iterable
from pathlib import Path

from msvalidate.bench.output import front
from msvalidate.bench.output.front import SENTENCES
from msvalidate.bench.output.report import stored_studies
from msvalidate.bench.output.stored import Stored

HERE = Path(__file__).resolve().parent
PICTURED = """## Pictures

Drawn from the committed baseline, which leaves out what depends on the machine."""
EXPLAINED = """Columns are explained in [{0}](../../studies/{0}) and in
[that of all studies](../../msvalidate/bench/judging/columns.toml), and under each table of the
report's page; reasons of limits stand beside them on the page and in `verdict.json`."""


def main(results: Path) -> None:
    """Write the pages of all studies that left results."""
    studies = [study for study in stored_studies(results) if not study.error]
    (HERE / "studies").mkdir(exist_ok=True)
    for study in studies:
        (HERE / "studies" / f"{study.name}.md").write_text(page(study), encoding="utf-8")
    sys.stdout.write(f"{len(studies)} pages in {HERE / 'studies'}\n")


def page(study: Stored) -> str:
    """A study's page as Markdown."""
    question, _, about = inspect.cleandoc(study.question).partition("\n")
    parts = [
        f"# {study.name}: {question}",
        "Made from the study's own results by `docs/write_studies.py`; not to be edited.",
        "## Findings",
        "\n".join(f"- {finding}" for finding in study.findings),
        *sentences(study),
        *pictures(study),
        "## What is asked",
        about.strip(),
        "## What it is held to",
        tolerances(study),
        "## Tables",
        ", ".join(table_link(study.name, name) for name in study.tables) + ".",
        EXPLAINED.format(source(study.name)),
    ]
    return "\n\n".join(part for part in parts if part) + "\n"


def sentences(study: Stored) -> list[str]:
    """The ledger in four columns."""
    if SENTENCES not in study.tables:
        return []
    rows = [
        (
            entry.sentence,
            entry.verdict,
            entry.number,
            entry.number and table_link(entry.study, entry.table, f"{entry.study}/{entry.table}"),
        )
        for entry in front.ledger(study.tables[SENTENCES])
    ]
    return ["## The ledger", grid(("sentence", "verdict", "number", "table"), rows)]


def grid(heads: Iterable[str], rows: Iterable[Iterable[object]]) -> str:
    """A table of Markdown."""
    lines = [" | ".join(cell(str(each)) for each in row) for row in rows]
    heads = list(heads)
    return "\n".join(
        f"| {line} |" for line in (" | ".join(heads), " | ".join("---" for _ in heads), *lines)
    )


def pictures(study: Stored) -> list[str]:
    """The pictures that `pictures.toml` names, each above what it shows."""
    names = tomllib.loads((HERE / "pictures.toml").read_text("utf-8")).get(study.name, [])
    shown = [f"![{n}]({study.name}/{n}.svg)\n\n*{study.pictures[n][0]}*" for n in names]
    return [PICTURED, *shown] if shown else []


def tolerances(study: Stored) -> str:
    """The rules of a study, a row each."""
    rows = study.verdict[study.verdict["layer"] != "baseline"].to_dict("records")
    return grid(
        ("quantity", "at most", "layer"),
        ((r["quantity"], f"{r['limit']:.3g}{unit(r['unit'])}", r["layer"]) for r in rows),
    )


def source(study: str) -> str:
    """Where a study's own columns are explained."""
    name = f"{study}/columns.toml"
    return name if (HERE.parent / "studies" / name).is_file() else study


def table_link(study: str, name: str, shown: str = "") -> str:
    """A link to the committed rows of a table."""
    return f"[{shown or name}](../../reports/baseline/full/{study}/{name}.csv)"


def unit(text: str) -> str:
    """A unit behind a number; a bare number has none."""
    return "" if text == "1" else f" {text}"


def cell(text: str) -> str:
    """A text as a cell of a table."""
    return " ".join(text.split()).replace("|", "\\|")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path("reports/latest"))
