"""Write docs/verification.md: known answers beside ours, from the committed full baseline.

    python docs/write_verification.py

Which rows is data, in verification.toml. Every number is a stored result, a published target or
the limit of a test.
"""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

HERE = Path(__file__).resolve().parent
BASELINE = HERE.parent / "reports" / "baseline" / "full"


def page(baseline: Path = BASELINE) -> str:
    """The page as Markdown."""
    made = tomllib.loads((HERE / "verification.toml").read_text(encoding="utf-8"))
    groups = [made.get(group.get("like"), {}) | group for group in made["group"]]
    rows = (row(group, where, baseline) for group in groups for where in group["rows"])
    return "".join([made["head"], *rows, *map(tested, made["tested"])])


def tested(row: dict[str, Any]) -> str:
    """One row whose limit a test states and keeps."""
    text = (HERE.parent / row["test"]).read_text(encoding="utf-8")
    (limit,) = re.findall(rf"^{row['limit']} = (\S+)", text, re.MULTILINE)
    below, link = f"< {limit}", f"[test](../{row['test']})"
    known = (f"[{row['source']}]", row["case"], row["quantity"], row["side"])
    return f"| {' | '.join((*known, '0', below, below, '–', link))} |\n"


def row(group: dict[str, Any], where: dict[str, Any], baseline: Path) -> str:
    """One row of the page."""
    table = pd.read_csv(baseline / f"{group['table']}.csv")
    found = chosen(table, where)
    if found.empty or (len(found) > 1 and not group.get("worst")):
        raise SystemExit(f"{group['table']}: {len(found)} rows of {where}; name one")
    ours, target = numbers(found, group["ours"]), targets(table, found, group["target"])
    if group.get("ours_over_target"):
        ours = ours * target
    errors = (ours - target) / np.where(target == 0, 1.0, target)
    if not np.isfinite(errors).all():
        raise SystemExit(f"{group['table']}: a row of {where} has no number")
    far = int(np.argmax(np.abs(errors)))
    values = found.iloc[far].to_dict()
    stated = values[group.get("own") or group["known"]] if {"own", "known"} & set(group) else "none"
    by = str(values.get("method") or values.get("model") or values.get("route") or "springs")
    study = group["table"].partition("/")[0]
    cells = (
        " ".join(f"[{key}]" for key in group.get("source", ())) or "closed form",
        group["case"].format(**values) + (f" (worst of {len(found)})" if len(found) > 1 else ""),
        group["quantity"].format(**values),
        group.get("side") or ("elements" if by.startswith(("FEM", "elements")) else "springs"),
        *(f"{target[far]:.8g}", f"{ours[far]:.8g}", part(errors[far])),
        "–" if stated == "none" else part(float(stated)) + " (target)" * ("known" in group),
        f"[{study}](studies/{study}.md)",
    )
    return f"| {' | '.join(cells)} |\n"


def chosen(table: pd.DataFrame, where: dict[str, Any]) -> pd.DataFrame:
    """Rows whose columns have the values asked for, or one of those in a list."""
    for column, value in where.items():
        table = table[table[column].isin(value if isinstance(value, list) else [value])]
    return table


def targets(table: pd.DataFrame, found: pd.DataFrame, target: Any) -> Any:
    """Targets of the rows: a column of theirs or of one other row, or a published number."""
    if isinstance(target, dict):
        other = chosen(table, {key: value for key, value in target.items() if key != "column"})
        target = numbers(other, target["column"]).item()
    return numbers(found, target) if isinstance(target, str) else np.full(len(found), float(target))


def numbers(table: pd.DataFrame, column: str) -> Any:
    """A column as numbers; not a number where the table says that there is none."""
    return pd.to_numeric(table[column], errors="coerce").to_numpy(float)


def part(error: float) -> str:
    """A part of one: in percent where it can be read so."""
    return f"{100 * error:.2g} %" if abs(error) >= 1e-5 else f"{error:.1e}"


if __name__ == "__main__":
    (HERE / "verification.md").write_text(page(), encoding="utf-8")
