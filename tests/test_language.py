"""Counts of words that hide the field's own: they fall, and never rise.

Openings and lengths of first lines of docstrings, names that cross a function, long sentences and
phrases of `language.toml`. Run as a program, it lowers the rows of `language.csv`.
"""

import ast
import re
import tomllib
from operator import gt
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
LIST = tomllib.loads((ROOT / "tests" / "language.toml").read_text("utf-8"))
ROWS, COLUMNS = ROOT / "tests/language.csv", ("openings", "names", "sentences", "phrases")
FOLDERS = "msvalidate reference_fem checker simulators cases/make studies tests examples docs"
ENDS, OLD = {".py", ".md"}, re.compile("docs/(decisions|letters)")
OPENING = re.compile(rf"({LIST['opening'].replace(' ', '|')})\b")
NAMES, SIDES = set(LIST["names"].split()), {"left", "own", "each"}
PHRASES = re.compile("|".join(r"\b" + r"\s+".join(p.split()) + r"\b" for p in LIST["phrases"]))
SENTENCE = re.compile(r"\n\s*\n|\n(?=\s*(?:[-*#]|\d+\.) )|\s\|\s|\n\||(?<=[.!?:])\s+(?=[A-Z`*])")
FUNCTION = ast.FunctionDef | ast.AsyncFunctionDef


def docstrings(parsed):
    for node in ast.walk(parsed):
        body = getattr(node, "body", None)
        for before, text in zip([node, *body], body) if isinstance(body, list) else ():  # noqa: B905
            owners = ast.Module | ast.ClassDef | FUNCTION if before is node else ast.Assign
            owned = isinstance(before, owners | ast.AnnAssign) and isinstance(text, ast.Expr)
            hidden = isinstance(before, FUNCTION) and before.name.startswith("_")
            if owned and isinstance(text.value, ast.Constant) and not hidden:
                yield str(text.value.value).strip().partition("\n")[0]


def crossing(parsed):
    """Names that other code sees: functions, parameters, classes, fields, attributes, constants."""
    for node in ast.walk(parsed):
        if isinstance(node, FUNCTION | ast.ClassDef):
            yield node.name
        elif isinstance(node, ast.arg):
            yield node.arg
        elif isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store):
            yield node.attr
        for each in node.body if isinstance(node, ast.Module | ast.ClassDef) else ():
            targets = getattr(each, "targets", [getattr(each, "target", None)])
            yield from (t.id for t in targets if isinstance(t, ast.Name))


def counts(name, text):
    """Openings, names, long sentences and phrases of one file."""
    text = "\n".join(x for x in text.split("\n") if f"{name}: {x.strip()}" not in LIST["exempt"])
    phrases = len(PHRASES.findall(re.sub(r"\s*\n\s*#? *", " ", text)))
    if not name.endswith(".py"):
        text = re.sub(r"\]\([^)]*\)", "]", re.sub(r"^```.*?^```", "", text, flags=re.S | re.M))
        return (0, 0, sum(len(part.split()) > 30 for part in SENTENCE.split(text)), phrases)
    parsed = ast.parse(text)
    names = [name.lower().strip("_") for name in crossing(parsed)]
    listed = NAMES - ({"left"} if "right" in names else set())  # both are sides
    names = [n for n in names if n in listed or {*n.split("_")} & (NAMES - SIDES)]
    first = [d for d in docstrings(parsed) if OPENING.match(d) or len(d.split()) > 15]
    return (len(first), len(names), 0, phrases)


def measured():
    paths = [
        *ROOT.glob("[AR]*.md"),
        ROOT / "CONTRIBUTING.md",
        ROOT / "msvalidate/cli/arguments.toml",
    ]
    paths += [p for f in FOLDERS.split() for p in (ROOT / f).rglob("*.*") if p.suffix in ENDS]
    names = {path.relative_to(ROOT).as_posix(): path for path in paths}
    return {n: counts(n, names[n].read_text("utf-8")) for n in sorted(names) if not OLD.match(n)}


def stored():
    lines = ROWS.read_text("utf-8").split()[1:] if ROWS.exists() else []
    return {name: tuple(map(int, row)) for name, *row in (line.split(",") for line in lines)}


def test_no_count_is_above_its_row():
    rows = stored()
    assert {n: c for n, c in measured().items() if any(map(gt, c, rows.get(n, (0,) * 4)))} == {}


def test_every_kind_is_counted():
    code = '"""What it is."""\ndef f(held, *, left): ...\nclass A:\n    told_once: int\n'
    assert counts("a.py", code + "# comes to\n# rest\n") == (1, 3, 0, 1)
    assert counts("a.py", "def f(left, right): ...\n'''Of x.'''") == (0, 0, 0, 0)
    assert counts("a.md", f"- {'word ' * 31}.\n- In the small form.\n") == (0, 0, 1, 1)
    assert (
        len(LIST["phrases"]) <= sum(40 * (" " in phrase) for phrase in LIST["phrases"]) / 40 <= 40
    )


if __name__ == "__main__":
    old, now = stored(), measured()
    rows = {n: tuple(map(min, c, old.get(n, c if not old else (0,) * 4))) for n, c in now.items()}
    lines = [("file", *COLUMNS), *((n, *row) for n, row in rows.items() if any(row))]
    ROWS.write_text("".join(",".join(map(str, each)) + "\n" for each in lines), "utf-8")
