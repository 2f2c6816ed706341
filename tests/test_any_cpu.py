"""`make any-cpu`: which environment emulates which processor, and what it says where it cannot."""

from __future__ import annotations

import importlib.util
import subprocess
from pathlib import Path

import pytest

PLACE = Path(__file__).resolve().parents[1] / ".ci" / "any_cpu.py"
FOUND = ["X86_V3", "X86_V4", "AVX512_ICL"]


@pytest.fixture
def any_cpu():
    spec = importlib.util.spec_from_file_location("any_cpu", PLACE)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def runs(any_cpu, monkeypatch):
    """Environments of the runs of `check`, whose exit codes are 0 but for the one as a Haswell."""
    seen = []

    def run(command, *, env, **_):
        core = env.get("OPENBLAS_CORETYPE", "")
        if command[1] == "-c":  # OpenBLAS is asked for whom it works: it knows all but Nehalem
            return subprocess.CompletedProcess(command, 0, "Zen" if core == "Nehalem" else core)
        seen.append(env | {"asked": " ".join(command)})
        return subprocess.CompletedProcess(command, int(core == "Haswell"))

    for name in ("NPY_DISABLE_CPU_FEATURES", "OPENBLAS_CORETYPE", "NUMBA_CPU_NAME"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(any_cpu.subprocess, "run", run)
    monkeypatch.setattr(any_cpu.platform, "machine", lambda: "x86_64")
    features = {"SIMD Extensions": {"found": FOUND, "baseline": ["X86_V2"]}}
    monkeypatch.setattr(any_cpu.np, "show_config", lambda _: features)
    return seen


def test_processors_are_emulated_by_names_that_this_numpy_has(any_cpu):
    generic = {"NUMBA_CPU_NAME": "generic", "NUMBA_CPU_FEATURES": ""}
    old = {"NPY_DISABLE_CPU_FEATURES": "X86_V3 X86_V4 AVX512_ICL", "OPENBLAS_CORETYPE": "Nehalem"}
    assert any_cpu.asked("old", FOUND, ["X86_V2"]) == old | generic
    assert any_cpu.asked("haswell", FOUND, ["X86_V2"]) == {"OPENBLAS_CORETYPE": "Haswell"}
    without = {"NPY_DISABLE_CPU_FEATURES": "X86_V4 AVX512_ICL"}
    assert any_cpu.asked("no-avx512", FOUND, ["X86_V2"]) == without
    # NumPy 1 has other names.
    names = ["AVX2", "FMA3", "AVX512F", "AVX512_SKX"]
    assert any_cpu.asked("no-avx512", names, []) == {
        "NPY_DISABLE_CPU_FEATURES": "AVX512F AVX512_SKX"
    }
    # A processor without AVX2 has nothing of a Haswell, and nothing to leave.
    assert any_cpu.asked("haswell", [], ["X86_V2"]) == {}
    assert any_cpu.asked("no-avx512", ["X86_V3"], ["X86_V2"]) == {}


def test_what_fails_on_one_processor_fails(any_cpu, runs, capsys):
    assert any_cpu.main(["poisson", "cost"]) == 1
    assert [" check poisson cost " in run["asked"] for run in runs] == [True] * 3
    said = capsys.readouterr().err
    assert "OPENBLAS_CORETYPE=Nehalem left out: OpenBLAS is Zen" in said
    assert "haswell: FAILED, exit code 1" in said
    assert "no-avx512: held" in said
    assert "OPENBLAS_CORETYPE" not in runs[0]
    assert runs[0]["NPY_DISABLE_CPU_FEATURES"] == " ".join(FOUND)
    assert runs[0]["NUMBA_CPU_NAME"] == "generic"
    assert any_cpu.main(["--as", "no-avx512", "--jobs", "2"]) == 0
    assert len(runs) == 4
    assert runs[3]["asked"].endswith(" --jobs 2")


def test_another_machine_is_told_in_one_line(any_cpu, runs, monkeypatch, capsys):
    monkeypatch.setattr(any_cpu.platform, "machine", lambda: "aarch64")
    assert any_cpu.main([]) == any_cpu.NOTHING == 4
    assert capsys.readouterr().err == (
        "any-cpu: nothing checked: this is aarch64, what is emulated are x86-64\n"
    )
    assert runs == []


def test_where_nothing_can_be_emulated_nothing_was_checked(any_cpu, runs, monkeypatch, capsys):
    features = {"SIMD Extensions": {"baseline": ["X86_V2"]}}
    monkeypatch.setattr(any_cpu.np, "show_config", lambda _: features)
    assert any_cpu.main(["--as", "haswell", "--as", "no-avx512"]) == any_cpu.NOTHING
    assert "haswell left out" in capsys.readouterr().err
    assert runs == []
