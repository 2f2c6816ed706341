"""CHANGELOG.md tells the truth of moved and renamed names: each that it points to is there."""

from __future__ import annotations

import importlib
import re
from pathlib import Path

LOG = (Path(__file__).resolve().parents[1] / "CHANGELOG.md").read_text(encoding="utf-8")
PACKAGES = ("msvalidate", "reference_fem")
MOVE = re.compile(r"`([\w.]+)` → `([\w.]+)`")
"""Old name, new name: in the bullet's module, a member of the old one's class, or dotted."""


def bullets(text, section="Layout"):
    """The bullets of the newest section of that name, each on one line."""
    part = re.split(r"^### ", text.split(f"### {section}\n", 1)[1], maxsplit=1, flags=re.M)[0]
    return [" ".join(bullet.split()) for bullet in re.split(r"^ *- ", part, flags=re.M)[1:]]


def find(name):
    """What a dotted name stands for: a module, or what is in one; AttributeError if nothing."""
    parts = name.split(".")
    for cut in range(len(parts), 0, -1):
        try:
            found = importlib.import_module(".".join(parts[:cut]))
        except ModuleNotFoundError as error:
            if not name.startswith(f"{error.name}"):
                raise
            continue
        for part in parts[cut:]:
            fields = {**getattr(found, "__dataclass_fields__", {})}
            fields |= dict.fromkeys(getattr(found, "__annotations__", ()))
            found = fields[part] if part in fields else getattr(found, part)
        return found
    raise AttributeError(name)


def exists(name):
    try:
        find(name)
    except AttributeError:
        return False
    return True


def modules(bullet):
    """Dotted modules that a bullet of folders lists: `msvalidate.folder`: `a`, `b` (now `c`)."""
    head, _, rest = bullet.partition("`: ")
    if not head.startswith("`msvalidate") or "→" in rest:
        return []
    listed = re.findall(r"`(\w+)`(?: \(now `(\w+)`\))?", rest)
    return [f"{head[1:]}.{now or name}" for name, now in listed]


def targets(bullet):
    """Dotted names that a bullet's arrows point to."""
    head, _, _ = bullet.partition("`: ")
    home = head[1:] if head.startswith(tuple(f"`{package}" for package in PACKAGES)) else ""
    moves = MOVE.findall(bullet)
    classes = {old: new for old, new in moves if "." not in old}
    found = []
    for old, new in moves:
        owner = old.rpartition(".")[0]
        if new.startswith(tuple(f"{package}." for package in PACKAGES)):
            found.append(new)
        elif "." in new:
            found.append(f"msvalidate.{new}")
        elif owner and home:
            found.append(f"{home}.{classes.get(owner, owner)}.{new}")
        else:
            found.append(f"{home}.{new}")
    return found


def test_every_name_that_the_layout_points_to_is_there():
    lines = bullets(LOG)
    listed = [name for line in lines for name in modules(line)]
    moved = [name for line in lines for name in targets(line)]
    assert len(listed) > 60
    assert len(moved) > 300
    gone = set(re.findall(r"`(\w+)`", " ".join(bullets(LOG, "Removed"))))
    there = [name for name in listed + moved if not gone & set(name.split("."))]
    assert [name for name in there if not exists(name)] == []


def test_what_was_renamed_is_gone():
    # Names that moved may still be imported where they were.
    renamed = [
        f"{line.partition('`: ')[0][1:]}.{old}"
        for line in bullets(LOG)
        for old, new in MOVE.findall(line)
        if "." not in old + new
    ]
    assert [name for name in renamed if exists(name)] == []


def test_a_wrong_target_is_noticed():
    text = (
        "### Layout\n\n- `msvalidate.statics`: `path`, `no_such`\n"
        "  - `msvalidate.statics.path`: `Way` → `LoadPath`, `Way.moved` → `prescribed`,\n"
        "    `way_of` → `no_path`, `Way.gone` → `nowhere`, `x` → `linear_algebra.norms.nothing`\n"
        "### Numbers\n- `a` → `b`\n"
    )
    lines = bullets(text)
    assert len(lines) == 2
    names = [name for line in lines for name in [*modules(line), *targets(line)]]
    wrong = ("no_such", "no_path", "nowhere", "nothing")
    assert [name.rpartition(".")[2] for name in names if not exists(name)] == list(wrong)
