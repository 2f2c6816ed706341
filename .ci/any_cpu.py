"""`check` as other x86-64 processors run it: `make any-cpu`, with `ARGS=poisson` for some studies.

Sorts, elementary functions, sums and compiled loops go by the processor: NumPy and OpenBLAS choose
among theirs at import, numba compiles for what it finds. Each can be told to take another's, so one
machine answers for several. What it lacks is said, and left out. Kernels are kept by the name and
the features of the processor that they are for, so that none of another is taken.
"""

from __future__ import annotations

import argparse
import os
import platform
import subprocess
import sys
import tempfile
import time

import numpy as np

NOTHING = 4
"""Exit code if nothing was checked, as of `check`; else the largest of its own."""
PROCESSORS = {
    "old": "NumPy's baseline alone, OpenBLAS for Nehalem, kernels for any x86-64",
    "haswell": "OpenBLAS for Haswell",
    "no-avx512": "NumPy without AVX-512",
}
CORE = """
import ctypes, pathlib, numpy
for place in pathlib.Path(numpy.__path__[0] + ".libs").glob("*openblas*"):
    for name in ("scipy_openblas_get_corename64_", "scipy_openblas_get_corename"):
        ask = getattr(ctypes.CDLL(str(place)), name, None)
        if ask:
            ask.restype = ctypes.c_char_p
            print(ask().decode())
            break
"""
"""A program that prints which processor NumPy's OpenBLAS works for, and nothing without one."""


def asked(processor: str, found: list[str], baseline: list[str]) -> dict[str, str]:
    """Environment that emulates a processor.

    Parameters
    ----------
    processor
        One of `PROCESSORS`.
    found, baseline
        NumPy's names of the features that it has loops for and this processor has, beyond those
        that it was built for.
    """
    if processor == "haswell":
        able = {"AVX2", "X86_V3", "X86_V4"} & {*found, *baseline}
        return {"OPENBLAS_CORETYPE": "Haswell"} if able else {}
    if processor == "no-avx512":
        found = [name for name in found if "AVX512" in name or name == "X86_V4"]
    wanted = {"NPY_DISABLE_CPU_FEATURES": " ".join(found)} if found else {}
    if processor == "old":
        wanted["OPENBLAS_CORETYPE"] = "Nehalem"
        wanted |= {"NUMBA_CPU_NAME": "generic", "NUMBA_CPU_FEATURES": ""}
    return wanted


def taken(wanted: dict[str, str]) -> dict[str, str]:
    """The environment without the OpenBLAS that does not come of it."""
    if "OPENBLAS_CORETYPE" not in wanted:
        return wanted
    command = [sys.executable, "-c", CORE]
    said = subprocess.run(
        command, env=os.environ | wanted, capture_output=True, text=True, check=True
    )
    core = said.stdout.strip()
    if core == wanted["OPENBLAS_CORETYPE"]:
        return wanted
    _say(f"OPENBLAS_CORETYPE={wanted['OPENBLAS_CORETYPE']} left out: OpenBLAS is {core or 'none'}")
    return {name: value for name, value in wanted.items() if name != "OPENBLAS_CORETYPE"}


def check(processor: str, studies: list[str], options: list[str]) -> int | None:
    """Exit code of `check` under an emulation; None if this machine has nothing to emulate it."""
    known = np.show_config("dicts")["SIMD Extensions"]
    wanted = taken(asked(processor, known.get("found", []), known.get("baseline", [])))
    if not wanted:
        _say(f"{processor} left out: this machine runs as one, or can do nothing of it")
        return None
    _say(f"{processor}: {PROCESSORS[processor]}")
    _say(" ".join(f'{name}="{value}"' for name, value in wanted.items()))
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "msvalidate.study", "check", *studies]
        command += ["--no-plots", "--out", folder, *options]
        started = time.perf_counter()
        code = subprocess.run(command, env=os.environ | wanted, check=False).returncode
    held = "held" if code == 0 else f"FAILED, exit code {code}"
    _say(f"{processor}: {held}, {time.perf_counter() - started:.0f} s")
    return code


def main(arguments: list[str]) -> int:
    """Check as each processor; the largest exit code."""
    parser = argparse.ArgumentParser(prog="any-cpu", description=__doc__.partition("\n")[0])
    parser.add_argument("studies", nargs="*", metavar="STUDY", help="by default all")
    parser.add_argument("--as", dest="processors", action="append", choices=[*PROCESSORS])
    parser.add_argument("--full", action="store_true", help="the full form, as of `check`")
    parser.add_argument("--jobs", default="1", metavar="N", help="studies at once, as of `check`")
    args = parser.parse_args(arguments)
    if platform.machine().lower() not in {"x86_64", "amd64"}:
        _say(f"nothing checked: this is {platform.machine()}, what is emulated are x86-64")
        return NOTHING
    options = ["--jobs", args.jobs, *(["--full"] if args.full else [])]
    codes = [check(name, args.studies, options) for name in args.processors or PROCESSORS]
    return max((code for code in codes if code is not None), default=NOTHING)


def _say(text: str) -> None:
    print(f"any-cpu: {text}", file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
