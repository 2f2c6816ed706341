"""Compiled kernels that are kept: never older than any of their sources, never half a file."""

from __future__ import annotations

import ast
import os
import shutil
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest
from numba import types
from numba.core import config
from numba.core.registry import cpu_target

import msvalidate
from msvalidate.springs.kernels import cache
from msvalidate.springs.kernels.compiling import compiled

PACKAGE = Path(msvalidate.__file__).parent
TYPES = {"Array", "Index"}
"""What annotations alone name: no part of compiled code."""
COMPARED = """
import numpy as np
from msvalidate import kernels
from msvalidate.springs.kernels import sweep
from msvalidate.springs.network import internal_force, spring_network
points = 0.37 * np.random.default_rng(0).random((12, 2))
springs = [(i, j) for i in range(12) for j in range(i)]
network = spring_network(points, springs, 3.0)
move = 0.01 * np.sin(np.arange(24.0)).reshape(12, 2)
out = np.zeros_like(points)
kernels.Motion(network).force_and_energy(move, out)
plain = internal_force(network, points + move)
found = "same" if np.allclose(out, plain, rtol=0, atol=1e-12 * abs(plain).max()) else "another"
print(found, "compiled" if sum(sweep.force._cache_misses.values()) else "loaded")
"""


def test_a_changed_source_is_seen_both_ways(tmp_path):
    """A fault in a function that those of other files have taken into themselves, and its end."""
    shutil.copytree(PACKAGE, tmp_path / "msvalidate", ignore=shutil.ignore_patterns("__pycache__"))
    kept = {"NUMBA_CACHE_DIR": str(tmp_path / "kept"), "PYTHONDONTWRITEBYTECODE": "1"}
    environment = os.environ | kept | {"PYTHONPATH": str(tmp_path)}

    def ran():
        done = subprocess.run(
            [sys.executable, "-c", COMPARED],
            env=environment,
            cwd=tmp_path,
            capture_output=True,
            text=True,
            check=True,
        )
        return done.stdout.split()

    assert ran() == ["same", "compiled"]
    source = tmp_path / "msvalidate" / "kernels" / "turning.py"
    right = source.read_text(encoding="utf-8")
    line = "return x, first_halves(ab, cd) + second_halves(ab, cd)"
    assert line in right
    source.write_text(right.replace(line, line.replace("+", "-")), encoding="utf-8")
    assert ran() == ["another", "compiled"]
    source.write_text(right, encoding="utf-8")
    assert ran() == ["same", "loaded"]


def test_the_stamp_names_every_source():
    """Each file that compiled code is made of, and each of ours that it takes constants from."""
    known = cache.stamp()
    for path in cache.HERE.glob("*.py"):
        inside = {p for p in cache.HERE.glob("*.py") if p != path}
        assert cache.stamp(Path("/nowhere"), (*sorted(inside), *cache.OUTSIDE)) != known, path
    sources = {*cache.HERE.glob("*.py"), *cache.OUTSIDE}
    outside = set()
    for path in sources:
        text = path.read_text(encoding="utf-8")
        if "compiled(" in text or "@intrinsic" in text:
            nodes = [n for n in ast.walk(ast.parse(text)) if isinstance(n, ast.ImportFrom)]
            outside |= {(n.module, a.name) for n in nodes for a in n.names}
    ours = {m for m, name in outside if m.startswith("msvalidate.") and name not in TYPES}
    assert {PACKAGE.parent / f"{m.replace('.', '/')}.py" for m in ours} <= sources
    for path in PACKAGE.rglob("*.py"):
        compiles = "msvalidate.springs.kernels.compiling import" in path.read_text(encoding="utf-8")
        assert path in sources or not compiles, path


def test_a_byte_of_any_source_changes_the_stamp(tmp_path):
    (tmp_path / "a.py").write_text("x = 1\n", encoding="utf-8")
    seen = {cache.stamp(tmp_path, ())}
    (tmp_path / "a.py").write_text("x = 2\n", encoding="utf-8")
    seen.add(cache.stamp(tmp_path, ()))
    (tmp_path / "a.py").rename(tmp_path / "b.py")
    seen.add(cache.stamp(tmp_path, ()))
    assert len(seen) == 3


def doubled(x):
    """What is compiled here."""
    return x + x


@pytest.fixture
def home(tmp_path, monkeypatch):
    """A folder of this test's own."""
    place = tmp_path / "kernels" / f"{cache.NAMED}{cache.stamp()}"
    monkeypatch.setattr(cache, "folder", lambda: place)
    return place


def hits(value):
    """Twice a value by a function compiled or loaded afresh, and how often it was loaded."""
    machine = compiled()(doubled)
    return machine(value), sum(machine._cache_hits.values())


def test_what_is_kept_is_found_again_and_damage_costs_one_file(home):
    assert [hits(2), hits(0.5), hits(2), hits(0.5)] == [(4, 0), (1.0, 0), (4, 1), (1.0, 1)]
    one, other = sorted(home.iterdir())
    content = one.read_bytes()
    for damage in (b"", content[:40], content[:-1] + bytes([content[-1] ^ 1])):
        one.write_bytes(damage)
        found = [hits(2), hits(0.5)]
        assert [value for value, _ in found] == [4, 1.0]
        assert sum(loaded for _, loaded in found) == 1
    assert sorted(home.iterdir()) == [one, other]


@pytest.mark.usefixtures("home")
def test_two_that_compile_at_once_keep_both(monkeypatch):
    """One writes while the other is about to, each a form that the other has not seen."""
    write = Path.write_bytes
    first = []

    def interrupted(path, content):
        if not first:
            first.append(path)
            assert hits(0.5) == (1.0, 0)
        return write(path, content)

    monkeypatch.setattr(Path, "write_bytes", interrupted)
    assert hits(2) == (4, 0)
    assert [hits(2), hits(0.5)] == [(4, 1), (1.0, 1)]


def test_another_processor_has_a_file_of_its_own(home, monkeypatch):
    codegen = cpu_target.target_context.codegen()
    kept = cache.KernelCache(doubled, {})
    signature = (types.int64,)
    seen = {kept._path(signature, codegen)}
    monkeypatch.setattr(config, "CPU_NAME", "another")
    seen.add(kept._path(signature, codegen))
    features = codegen.magic_tuple()[:2]
    seen.add(kept._path(signature, SimpleNamespace(magic_tuple=lambda: (*features, ""))))
    monkeypatch.setattr(config, "BOUNDSCHECK", 1)
    seen.add(cache.KernelCache(doubled, {})._path(signature, codegen))
    assert len(seen) == 4
    assert {path.parent for path in seen} == {home}


def test_what_was_compiled_from_a_source_changed_since_is_not_kept(home, monkeypatch):
    monkeypatch.setattr(cache, "stamp", lambda: "0" * 16)
    assert hits(2) == (4, 0)
    assert not home.exists()


def test_a_full_disk_costs_a_compilation_and_no_more(home, monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(cache.Path, "write_bytes", full)
    assert [hits(2), hits(2)] == [(4, 0), (4, 0)]
    assert not list(home.iterdir())


def test_old_folders_are_cleared_away(home):
    names = [f"{cache.NAMED}{number:016x}" for number in range(6)]
    for age, name in enumerate(reversed(names)):
        (home.parent / name).mkdir(parents=True)
        os.utime(home.parent / name, (age, age))
    mine = home.parent / f"{cache.NAMED}mine"
    mine.mkdir()
    hits(2)
    assert {path.name for path in home.parent.iterdir()} == {home.name, mine.name, *names[:3]}


def test_places_where_nothing_can_be_written_are_passed_over(tmp_path, monkeypatch):
    (tmp_path / "file").touch()
    (tmp_path / "loop").symlink_to("loop")
    for place in ("file", "file/below", "loop/below", "x" * 300):
        assert not cache._writable(tmp_path / place / "folder"), place
    assert cache._writable(tmp_path / "not" / "yet")
    monkeypatch.setattr(config, "CACHE_DIR", str(tmp_path / "file"))
    ours = (tmp_path, cache.HERE)
    monkeypatch.setattr(
        cache.os, "access", lambda path, _: not any(path.is_relative_to(own) for own in ours)
    )
    found = cache.folder.__wrapped__()
    assert found is not None
    assert cache.HERE not in found.parents, "the user's own cache"
