"""Compare the code of two commits after a map of module paths and names; docstrings are ignored.

    python tests/tools/same_code.py OLD NEW MAP.json

MAP has `modules` and `names` (old -> new, or a list of new ones) and `exceptions` (new path ->
reason). Order of imports does not count. Exit code 1 if any other file differs.
"""

import ast
import json
import re
import subprocess
import sys
from itertools import zip_longest
from pathlib import Path

OLD, NEW, MAP = *sys.argv[1:3], json.loads(Path(sys.argv[3]).read_text("utf-8"))
PATHS = {k.replace(".", s): v.replace(".", s) for k, v in MAP["modules"].items() for s in "./"}
KEYS = "|".join(map(re.escape, sorted(PATHS, key=len, reverse=True))) or "(?!)"
NAMES = {old: {new} if isinstance(new, str) else {*new} for old, new in MAP["names"].items()}
for one, two in MAP["modules"].items():
    NAMES.setdefault(one.rpartition(".")[2], set()).add(two.rpartition(".")[2])


def git(*arguments):
    return subprocess.run(["git", *arguments], check=True, capture_output=True).stdout.decode()


def moved(text):
    """Replace all paths of modules, dotted or of files, by those in the new commit."""
    pattern = rf"(?<![\w.])(?:({KEYS})|(tests[./])({KEYS}))(?!\w)"
    return re.sub(pattern, lambda m: PATHS[m[1]] if m[1] else m[2] + PATHS[m[3]], text)


def tokens(node, path, mapped):
    """Yield kinds of nodes, identifiers and constants; the imports of a block as one set."""
    if isinstance(node, list):
        imports = [each for each in node if isinstance(each, ast.Import | ast.ImportFrom)]
        yield {mapped(name) for each in imports for name in bound(each, path)}
        for each in node:
            text = isinstance(each, ast.Expr) and isinstance(each.value, ast.Constant)
            if each not in imports and not (text and isinstance(each.value.value, str)):
                yield from tokens(each, path, mapped)
    elif isinstance(node, ast.Subscript) and "__file__" in (text := ast.unparse(node)):
        yield re.sub(r"parents\[(\d+)\]", lambda m: str(int(m[1]) - path.count("/")), text)
    elif isinstance(node, ast.AST):
        yield type(node).__name__
        for _, value in ast.iter_fields(node):
            yield from tokens(value, path, mapped)
    else:
        yield mapped(node) if isinstance(node, str) else node


def bound(node, path):
    """Return what an import binds: dotted names, made absolute, with their aliases."""
    home, level = ("msvalidate/" + path).split("/"), getattr(node, "level", 0)
    stem = [*home[: -level or None], node.module or ""] if level else [getattr(node, "module", "")]
    return [f"{'.'.join([*stem, a.name]).strip('.')} as {a.asname}" for a in node.names]


def same(old, new):
    """Return True if a token is the old one, word by word in the map of names."""
    if isinstance(old, set) and isinstance(new, set):
        return len(old) == len(new) and all(any(same(x, y) for y in new) for x in old)
    if not (isinstance(old, str) and isinstance(new, str)):
        return old == new and type(old) is type(new)
    pairs = zip_longest(*(re.findall(r"\w+|\W+", text) for text in (old, new)))
    return old == new or all(x == y or y in NAMES.get(x, ()) for x, y in pairs)


wrong, rows = 0, git("diff", "-M30%", "-l9999", "--name-status", OLD, NEW, "--", "*.py")
for status, *paths in (row.split("\t") for row in rows.splitlines()):
    sides = {"A": [(NEW, paths[0], str)], "D": [(OLD, paths[0], moved)]}
    sides = sides.get(status, [(OLD, paths[0], moved), (NEW, paths[-1], str)])
    code = (tokens(ast.parse(git("show", f"{c}:{p}")).body, p, m) for c, p, m in sides)
    pairs = zip_longest(*code, *([[set()]] if status in "AD" else []))
    if off := next((pair for pair in pairs if not same(*pair)), None):
        wrong += paths[-1] not in MAP["exceptions"]
        print(f"{paths[-1]}: {MAP['exceptions'].get(paths[-1], 'DIFFERS')}: {off}")
sys.exit(wrong > 0)
