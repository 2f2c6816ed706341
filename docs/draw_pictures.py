"""Draw the pictures of docs/studies from the committed baseline, as docs/pictures.toml names them.

    python docs/draw_pictures.py

No study runs: a figure is a function of tables, which the baseline holds, all but times.
"""

from __future__ import annotations

import ast
import re
import tomllib
from collections.abc import Callable, Iterator
from functools import partial
from importlib import import_module
from operator import attrgetter
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from msvalidate.bench.judging import catalogue
from msvalidate.bench.output.baseline import baseline_folder
from msvalidate.bench.output.results import Results
from msvalidate.bench.output.stored import draw_files

HERE = Path(__file__).resolve().parent
PICTURES: dict[str, list[str]] = tomllib.loads((HERE / "pictures.toml").read_text("utf-8"))
"""Study -> names of its figures that its page shows."""
STRAIGHT = 0.06
"""Points (1/72 inch) by which a line may leave out a bend."""

UNREAD = re.compile(
    rb'<!--.*?-->|<metadata>.*?</metadata>|font-family: [^;"]*(?:; )?|(?<=<g) id="[^"]*"'
    rb'| transform="rotate\(-0 [^"]*"',
    re.DOTALL,
)
LIKE_NEXT = re.compile(
    rb'" (clip-path="[^"]*" style="fill: none[^"]*"/>)\s*<path d="([^"]*)(?=" \1)'
)
MARKS = re.compile(rb'(<g clip-path="[^"]*")>((?:\s*<use [^>]*/>)+)')
STYLE = re.compile(rb' style="[^"]*"')
LINE = re.compile(rb"M -?[\d.]+ -?[\d.]+(?:\s+L -?[\d.]+ -?[\d.]+)+")
PLACE = re.compile(rb'(?<= [xy]=")[\d.]+')


def main() -> None:
    """Draw all pictures."""
    for study, names in PICTURES.items():
        (HERE / "studies" / study).mkdir(exist_ok=True)
        offered, tables = dict(drawings(study)), committed(study)
        for name in names:
            draw = partial(offered[name], tables)
            svg = draw_files(name, caption(offered[name]), draw)[f"{name}.svg"]
            (HERE / "studies" / study / f"{name}.svg").write_bytes(compact(svg))


def drawings(study: str) -> Iterator[tuple[str, Callable[..., Any]]]:
    """Figures that a study's files offer by the name of a function, without running it."""
    package = catalogue.load(study)
    for path in sorted(Path(str(package.__file__)).parent.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if not (isinstance(node, ast.keyword) and node.arg == "figures"):
                continue
            inside = path.relative_to(Path(str(package.__file__)).parent).with_suffix("").parts
            module = import_module(".".join([package.__name__, *inside]).removesuffix(".__init__"))
            offered = node.value
            if not isinstance(offered, ast.Dict):
                offered = ast.Dict([None], [offered])
            for key, value in zip(offered.keys, offered.values, strict=True):
                if not key and isinstance(value, ast.Name):  # all of a table of them
                    yield from getattr(module, value.id, {}).items()
                elif key and isinstance(value, ast.Name | ast.Attribute):
                    yield ast.literal_eval(key), attrgetter(ast.unparse(value))(module)


def caption(draw: Callable[..., Any]) -> str:
    """What a figure shows."""
    return str(draw.__doc__).partition("\n")[0]


def committed(study: str) -> dict[str, pd.DataFrame]:
    """A study's tables as the full baseline has them, in the types of a run.

    Whole numbers are integers, and words where others of their column are, as the rule "1" is.
    """
    found = {}
    for path in sorted((baseline_folder("full") / study).glob("*.csv")):
        table = Results("full").table(study, path.stem)
        raw = pd.read_csv(path, keep_default_na=False)
        for name in raw:
            words, numbers = raw[name].astype(object), table[name].astype(object)
            whole = words.astype(str).str.fullmatch(r"-?\d+|True|False")
            table[name] = words.where(whole, numbers).infer_objects()
        found[path.stem] = table
    return found


def compact(svg: bytes) -> bytes:
    """The same picture in fewer bytes, to a tenth of a point.

    What no reader sees is left out; lines of one look are one path, in steps; looks are said once.
    """
    svg = PLACE.sub(lambda at: b"%.1f" % float(at[0]), UNREAD.sub(b"", svg))
    svg = svg.replace(b"<svg ", b'<svg font-family="DejaVu Sans, Verdana, sans-serif" ', 1)
    svg = MARKS.sub(_look_once, LINE.sub(_steps, LIKE_NEXT.sub(rb" \2", svg)))
    return re.sub(rb"\n\s*", b"\n", svg)


def _look_once(marks: re.Match[bytes]) -> bytes:
    looks = set(STYLE.findall(marks[2]))
    if len(looks) > 1:
        return marks[0]
    return b"".join([marks[1], looks.pop(), b">", STYLE.sub(b"", marks[2])])


def _steps(line: re.Match[bytes]) -> bytes:
    at = np.array(re.findall(rb"-?[\d.]+", line[0]), dtype=float).reshape(-1, 2)
    while len(at) > 2:  # every second point, where it lies between its neighbours
        back, ahead = at[1:-1:2] - at[:-2:2], at[2::2] - at[1:-1:2]
        off = np.abs(back[:, 0] * ahead[:, 1] - back[:, 1] * ahead[:, 0])
        between = (off <= STRAIGHT * np.hypot(*(back + ahead).T)) & ((back * ahead).sum(1) >= 0)
        if not between.any():
            break
        at = np.delete(at, 1 + 2 * np.flatnonzero(between), axis=0)
    first, *steps = np.diff(at.round(1), axis=0, prepend=np.zeros((1, 2)))
    moves = " ".join(f"{step:.1f}".removesuffix(".0") for step in np.ravel(steps))
    short = f"M{first[0]:g} {first[1]:g}l{moves}".replace(" -", "-")
    return re.sub(r"\b0\.", ".", short).encode()


if __name__ == "__main__":
    main()
