"""Write docs/studies: a page a study, from the results of a full run.

    python -m msvalidate.study all        # in the full form, results in reports/latest
    python docs/write_studies.py          # from there; another folder may be named

Each page says what the study finds and asks, what it holds itself to, and what every column of its
tables means. Its pictures are drawn by `docs/draw_pictures.py`.
"""

from __future__ import annotations

import inspect
import sys
import tomllib
from collections.abc import Iterable
from pathlib import Path

from msvalidate.output import front
from msvalidate.output.front import SENTENCES
from msvalidate.output.report import stored_studies
from msvalidate.output.stored import Stored

HERE = Path(__file__).resolve().parent
PICTURED = """## Pictures

Drawn from the committed baseline, which leaves out what depends on the machine."""


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
        *(table(study, name) for name in study.tables),
    ]
    return "\n\n".join(part for part in parts if part) + "\n"


def sentences(study: Stored) -> list[str]:
    """The ledger in four columns, and below it the rest, folded."""
    if SENTENCES not in study.tables:
        return []
    ledger = study.tables[SENTENCES]
    rows = [
        (
            entry.sentence,
            entry.verdict,
            entry.number,
            entry.number and f"[{entry.study}/{entry.table}]({entry.study}.md#{entry.table})",
        )
        for entry in front.ledger(ledger)
    ]
    rest = ledger[["sentence", "place", "theory", "because"]].itertuples(index=False)
    folded = "<details><summary>where each stands, and why that verdict and that bound</summary>"
    return [
        "## The ledger",
        grid(("sentence", "verdict", "number", "link"), rows),
        f"{folded}\n\n{grid(('sentence', 'place', 'theory', 'bound'), rest)}\n\n</details>",
    ]


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
    captions = [(name, study.pictures[name][0]) for name in names]
    shown = [f"![{said}]({study.name}/{name}.svg)\n\n*{said}*" for name, said in captions]
    return [PICTURED, *shown] if shown else []


def tolerances(study: Stored) -> str:
    """The tolerances of a study, a row each."""
    rows = study.verdict[study.verdict["layer"] != "baseline"].to_dict("records")
    return grid(
        ("layer", "quantity", "limit", "because"),
        (
            (
                row["layer"],
                row["quantity"],
                f"{row['limit']:.3g}{unit(row['unit'])}",
                row["because"],
            )
            for row in rows
        ),
    )


def table(study: Stored, name: str) -> str:
    """A table's columns and what they mean."""
    columns = [str(column) for column in study.tables[name]]
    said = [f"- `{column}`: {study.columns.get(column, '')}" for column in columns]
    folded = f"<details><summary>{len(said)} columns</summary>"
    return "\n".join([f"### {name}", "", folded, "", *said, "", "</details>"])


def unit(text: str) -> str:
    """A unit behind a number; a bare number has none."""
    return "" if text == "1" else f" {text}"


def cell(text: str) -> str:
    """A text as a cell of a table."""
    return " ".join(text.split()).replace("|", "\\|")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path("reports/latest"))
