"""Mutation run: which small faults do the tests and the quick questions miss?

    python tests/mutation/run.py                 a seeded sample of every module, then the table
    python tests/mutation/run.py volumes compare these modules
    python tests/mutation/run.py --again         survivors once more, against the tests as they are
    python tests/mutation/run.py --questions     survivors, by the quick questions concerned
    python tests/mutation/run.py --unchecked     without a first run of the tests without faults
    python tests/mutation/run.py --table         the table alone

Faults are put into a copy of the tree, one at a time. A first run of the tests without a fault
tells which tests reach which line and how long they take; a fault is asked of the tests that reach
its line, the quickest first, then of the other tests of its module. Compiled code is compiled anew
for each fault, into an empty cache. The share is of the faults that are not equivalent: those that
change no answer beyond rounding, judged one by one in `equivalent.csv`. Results are lines of JSON
under `build/mutants`; a run that was cut off goes on where it was.
"""

from __future__ import annotations

import argparse
import csv
import json
import shutil
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))
from operators import Mutant, mutants, sample  # noqa: E402
from processes import forked, prepare, tested_by, traced  # noqa: E402

ROOT = HERE.parents[1]
T, F = "tests/msvalidate", "tests/reference_fem"


def _files(*names: str) -> list[str]:
    """Patterns of the files of tests of these names, in the folder of whatever package."""
    return [f"{T}/**/test_{name}.py" for name in names]


MODULES: dict[str, tuple[list[str], list[str], int]] = {
    # name: files, tests, faults
    "integrators": ([f"msvalidate/springs/dynamics/{name}.py" for name in ("integrators",
        "variants", "step_limits", "implicit")],
        _files("integrators", "integrators_on_networks", "integrate"), 28),
    "homogenise": (["msvalidate/springs/constants/homogenise.py"], _files("homogenise"), 28),
    "calibrate": (["msvalidate/springs/bodies/calibrate.py",
        "msvalidate/springs/constants/routes.py"],
        _files("calibrate", "uniform_tension"), 28),
    "volumes": (["msvalidate/springs/network/laws/volumes.py"], _files("volumes", "volumes_by_hand",
        "network", "spectrum"), 25),
    "compare": (["msvalidate/bench/judging/compare.py"], _files("evidence", "compare"), 25),
    "rules": (["msvalidate/bench/judging/rules.py"], _files("rules"), 25),
    "baseline": (["msvalidate/bench/output/baseline.py", "checker/msvalidate_check/baseline.py"],
        [*_files("baseline"), "tests/checker/test_plugin.py"], 25),
    "stiffness": (["msvalidate/springs/constants/stiffness.py"],
        _files("stiffness", "calibrate"), 25),
    "network": (["msvalidate/springs/network/network.py"], _files("network", "spectrum",
        "lattice_network", "body_exact", "supports", "unstable"), 25),
    "charges": (["msvalidate/dielectric/charges/*.py"], [f"{T}/dielectric/charges"], 25),
    "kernels": (["msvalidate/springs/kernels/*.py", "msvalidate/dielectric/kernels/*.py"], [], 25),
    "reference_fem": (["reference_fem/**/*.py"], [F], 25),
    "equilibrium": (["msvalidate/springs/statics/equilibrium.py"],
        _files("equilibrium*", "unstable", "path", "refinement"), 25),
    "unilateral": (["msvalidate/springs/statics/unilateral.py"],
        _files("unilateral", "contact"), 25),
    "linear_algebra": (["msvalidate/linear_algebra/*.py", "reference_fem/systems/direct.py"],
        [*_files("factor", "order", "multigrid", "inverse"), f"{F}/systems"], 60),
    "checker": (["checker/msvalidate_check/*.py"], ["tests/checker",
        *_files("baseline", "report", "report_interrupted", "judging")], 40),
    "simulators": (["msvalidate/simulators/*/*.py"], [f"{T}/simulators"], 40),
    "case": (["msvalidate/case/*/*.py"], [f"{T}/case"], 40),
}  # fmt: skip
KT, CT = f"{T}/springs/kernels", f"{T}/dielectric/charges"
CELLS = [
    [f"{KT}/test_kernels.py::test_{n}" for n in (
        "cells_push_as_in_the_plain_form", "cells_add_to_what_is_there_whatever_their_groups",
        "a_number_that_is_none_comes_out_as_none",
    )],
    [f"{KT}/test_kernels.py::test_{n}" for n in (
        "force_and_energy_are_those_of_the_plain_form", "curvature_is_that_of_the_tangent",
    )],
]  # fmt: skip
FORCES = f"{KT}/test_general.py::test_forces_and_steps_are_those_of_the_plain_form"
LISTS = [[f"{FORCES}[2-none-False]", f"{FORCES}[3-none-False]"], [f"{KT}/test_general.py"]]
GRIDS = [[f"{KT}/test_stencil.py"]]
KERNELS = {
    "__init__": [*LISTS, [f"{KT}/test_stencil.py", f"{KT}/test_kernels.py"]],
    "cache": [[f"{KT}/test_cache.py"]],
    "bending": [[f"{KT}/test_kernels.py::test_curvature_is_that_of_the_tangent"]],
    "cells": CELLS,
    "charges": [
        [f"{KT}/test_charges.py"],
        [f"{CT}/test_forces.py", f"{CT}/test_electrodes.py"],
    ],
    "compiling": [[f"{KT}/test_segments.py"]],
    "corners": CELLS,
    "fluxes": [[f"{KT}/test_fluxes.py"]],
    "general": LISTS,
    "grid": GRIDS,
    "lanes": GRIDS + LISTS[:1],
    "polygons": [[f"{CT}/test_faces.py"], [f"{CT}/test_patches.py"]],
    "rows": GRIDS + LISTS,
    "segments": [[f"{KT}/test_segments.py"], [f"{KT}/test_charges.py"]],
    "stencil": GRIDS,
    "sweep": LISTS,
    "turning": LISTS,
    "values": GRIDS,
}
"""File of compiled code -> tests that reach it, those that compile the least first; of other
modules they are found by the lines that tests run, which compiled code does not tell."""
PLAIN = {"__init__", "cache", "general", "grid", "rows", "values"}
"""Files of `kernels` without compiled functions: what is compiled stays as it is."""
QUESTIONS: dict[str, list[tuple[str, tuple[str, ...]]]] = {
    "integrators": [("stability", ("limits", "order"))],
    "homogenise": [("lattices", ("solids",))],
    "calibrate": [("lattices", ("uniform",))],
    "stiffness": [("lattices", ("solids",))],
    "volumes": [("benchmarks", ("patch",)), ("lattices", ("rubber",))],
    "network": [("benchmarks", ("patch",)), ("displacement", ("identities",))],
    "equilibrium": [("benchmarks", ("patch",)), ("pull_in", ("sweep",))],
    "linear_algebra": [("cost", ("agreement",))],
    "kernels": [("cost", ("agreement",))],
    "charges": [("electrostatics", ("strips",)), ("electrostatics", ("shortcuts",))],
    "reference_fem": [("benchmarks", ("patch",)), ("benchmarks", ("ring",))],
}
"""Module -> quick questions whose theory or agreement rows should notice."""
LIMIT = 60
"""Seconds of processor time, after which a fault counts as noticed: the tests take far less."""
REACHING, OTHERS = 5.0, 2.0
"""Seconds of tests that reach the line, and of the module's others."""


def main() -> None:
    """Run, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("modules", nargs="*", choices=[[], *MODULES], default=[])
    parser.add_argument("--out", type=Path, default=ROOT / "build" / "mutants")
    parser.add_argument("--seed", default="18")
    parser.add_argument("--again", action="store_true")
    parser.add_argument("--questions", action="store_true")
    parser.add_argument("--unchecked", action="store_true")
    parser.add_argument("--table", action="store_true")
    asked = parser.parse_args()
    asked.out = asked.out.resolve()
    asked.out.mkdir(parents=True, exist_ok=True)
    names = asked.modules or list(MODULES)
    if not asked.table:
        prepare()
        tree = copied(asked.out / "tree")
        reach = reached(tree, asked.out / "reach.jsonl")
        for name in names:
            run(name, tree, reach, asked)
    print(table(asked.out / "results.jsonl", names))  # noqa: T201


def copied(tree: Path) -> Path:
    """Copy what git knows, and what is new, to a folder of its own."""
    shutil.rmtree(tree, ignore_errors=True)
    listed = ["git", "ls-files", "-co", "--exclude-standard"]
    for name in subprocess.run(
        listed, cwd=ROOT, check=True, capture_output=True, text=True
    ).stdout.split("\n"):
        if name and (ROOT / name).is_file():
            (tree / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, tree / name)
    return tree


def reached(tree: Path, store: Path) -> list[dict]:
    """Return what each test reaches, and its seconds; found by a run without faults."""
    if not store.exists():
        tests = ["tests/test_bad_input.py", *{t for _, tests, _ in MODULES.values() for t in tests}]
        code, _ = forked(lambda: traced(files_of(tests), store, tree), tree, store.parent, 7200)
        if code != 0:
            store.unlink(missing_ok=True)
            sys.exit(f"the tests fail without a fault; see {store.parent / 'output.txt'}")
    return [json.loads(line) for line in store.read_text().splitlines()]


def files_of(tests: list[str]) -> list[str]:
    """Return the files and folders of tests that there are."""
    return sorted({str(path.relative_to(ROOT)) for test in tests for path in ROOT.glob(test)})


def run(name: str, tree: Path, reach: list[dict], asked: argparse.Namespace) -> None:
    """Ask of each fault of a module's sample whether it is noticed; append what is found."""
    patterns, tests, count = MODULES[name]
    tests = files_of(tests)
    found = [
        one
        for pattern in patterns
        for file in sorted(ROOT.glob(pattern))
        for one in mutants(str(file.relative_to(ROOT)), file.read_text(encoding="utf-8"))
    ]
    results = asked.out / "results.jsonl"
    known = latest(results)
    if asked.again or asked.questions:
        left = {k for k, r in known.items() if r["module"] == name and r["how"] == "survived"}
        kept = left - equivalent()
        chosen = [one for one in found if place(one) in kept]
    else:
        chosen = [
            one for one in sample(found, count, f"{asked.seed}/{name}") if place(one) not in known
        ]
    if chosen and not asked.unchecked:
        refuse_failing(name, tests, chosen, tree, reach, asked)
    for one in chosen:
        if asked.questions:
            how, seconds, by = asked_of_questions(one, name, tree, asked.out)
        else:
            how, seconds, by = tested(one, name, tests, tree, reach, asked.out)
        line = {
            "place": place(one), "module": name, "file": one.file, "line": one.line,
            "kind": one.kind, "before": one.before, "after": one.after, "how": how,
            "by": by, "seconds": round(seconds, 1), "seed": asked.seed,
        }  # fmt: skip
        with results.open("a", encoding="utf-8") as file:
            file.write(json.dumps(line, ensure_ascii=False) + "\n")


def refuse_failing(
    name: str,
    tests: list[str],
    chosen: list[Mutant],
    tree: Path,
    reach: list[dict],
    asked: argparse.Namespace,
) -> None:
    """End the run if the tests, or the questions, fail without a fault."""
    if asked.questions:
        works = [lambda a=a: _question(*a) for a in QUESTIONS.get(name, [])]
    elif name == "kernels":
        asks = [group for one in chosen for group in KERNELS[Path(one.file).stem]]
        works = [lambda: tested_by(sorted({t for group in asks for t in group}))]
    else:
        groups = [group for one in chosen for group in chosen_tests(one, tests, reach)]
        works = [lambda: tested_by(sorted({t for group in groups for t in group}))]
    for work in works:
        code, seconds = forked(work, tree, asked.out, 600)
        if code:
            sys.exit(f"{name}: {code} without a fault; see {asked.out / 'output.txt'}")
        print(f"{name}: {len(chosen)} faults; {seconds:.0f} s without one", flush=True)  # noqa: T201


def place(one: Mutant) -> str:
    """Return a name that lasts while other lines of the file change."""
    lines = (ROOT / one.file).read_text(encoding="utf-8").splitlines()
    text = lines[one.line - 1].strip()
    before = sum(line.strip() == text for line in lines[: one.line])
    column = one.start - sum(len(line.encode()) + 1 for line in lines[: one.line - 1])
    indent = len(lines[one.line - 1]) - len(lines[one.line - 1].lstrip())
    return f"{one.file} | {text} #{before} | {column - indent} | {one.kind} | {one.after}"


def tested(
    one: Mutant, module: str, tests: list[str], tree: Path, reach: list[dict], out: Path
) -> tuple[str, float, str]:
    """Whether tests notice a fault: those that reach its line, then the module's others."""
    stem = Path(one.file).stem
    groups = KERNELS[stem] if module == "kernels" else chosen_tests(one, tests, reach)
    compiled, spent = module == "kernels" and stem not in PLAIN, 0.0
    shutil.rmtree(out / "cold", ignore_errors=True)
    with fault_in(one, tree):
        for group in groups:
            if not group:
                continue
            code, seconds = forked(
                lambda group=group: tested_by(group), tree, out, LIMIT, cold=compiled
            )
            spent += seconds
            if code == "timeout":
                return "timeout", spent, ""
            if code:
                refuse_unknown(code, out)
                return "killed", spent, last_failure(out)
    return "survived", spent, ""


def refuse_unknown(code: object, out: Path) -> None:
    """End the run where it is not the fault that ended the tests.

    Failed tests give 1; modules that do not import any more give 2, or 4 where their tests were
    named.
    """
    if code not in (1, 2, 4, "crash"):
        sys.exit(f"pytest ended with {code}; see {out / 'output.txt'}")


def chosen_tests(one: Mutant, tests: list[str], reach: list[dict]) -> list[list[str]]:
    """Tests that reach the line, the module's own first, and others that reach its file.

    The quickest first in each: most faults are noticed at once, by few files of tests.
    """
    own = tuple(tests)
    known = sorted((t for t in reach if one.file in t["lines"]), key=lambda t: t["seconds"])
    groups: list[list[dict]] = [[], [], []]
    for test in known:
        at_line = one.line in test["lines"][one.file]
        groups[(0 if test["test"].startswith(own) else 1) if at_line else 2].append(test)
    groups[2].sort(key=lambda t: not t["test"].startswith(own))
    limits = (REACHING, OTHERS, OTHERS if groups[0] else REACHING)
    taken = [_within(group, limit) for group, limit in zip(groups, limits, strict=True)]
    return [[t["test"] for t in group] for group in taken]


def _within(tests: list[dict], seconds: float) -> list[dict]:
    taken, total = [], 0.0
    for one in tests:
        total += one["seconds"]
        if total > seconds and taken:
            break
        taken.append(one)
    return taken


class fault_in:  # noqa: N801
    """The tree with a fault in it; without, and without what was compiled from it, afterwards."""

    def __init__(self, one: Mutant, tree: Path) -> None:
        self.one, self.path = one, tree / one.file
        self.source = (ROOT / one.file).read_text(encoding="utf-8")

    def _write(self, text: str) -> None:
        for stale in self.path.parent.glob(f"__pycache__/{self.path.stem}.*.pyc"):
            stale.unlink()
        self.path.write_text(text, encoding="utf-8")

    def __enter__(self) -> None:
        self._write(self.one.applied(self.source))

    def __exit__(self, *_: object) -> None:
        self._write(self.source)


def last_failure(out: Path) -> str:
    """Return the test that noticed, as pytest names it."""
    text = (out / "output.txt").read_text(encoding="utf-8", errors="replace").splitlines()
    return next(
        (x for x in reversed(text) if x.startswith(("FAILED", "ERROR"))), "".join(text[-1:])
    )[:300]


def asked_of_questions(one: Mutant, module: str, tree: Path, out: Path) -> tuple[str, float, str]:
    """Whether a theory or agreement row of a quick question notices a fault."""
    compiled, spent = module == "kernels" and Path(one.file).stem not in PLAIN, 0.0
    shutil.rmtree(out / "cold", ignore_errors=True)
    with fault_in(one, tree):
        for study, questions in QUESTIONS.get(module, []):
            code, seconds = forked(
                lambda study=study, questions=questions: _question(study, questions),
                tree, out, LIMIT, cold=compiled,
            )  # fmt: skip
            spent += seconds
            if code == "timeout":
                return "timeout", spent, f"question {study} {' '.join(questions)}"
            if code:
                return "killed", spent, f"question {study} {' '.join(questions)}"
    return "survived", spent, ""


def _question(study: str, questions: tuple[str, ...]) -> int:
    from msvalidate.bench.judging import catalogue  # noqa: PLC0415
    from msvalidate.bench.judging.evidence import all_passed, judge  # noqa: PLC0415
    from msvalidate.bench.judging.sweep import Setting  # noqa: PLC0415

    given = {"questions": questions} if questions else {}
    evidence = catalogue.load(study).run(setting=Setting(quick=True), **given)
    return 0 if all_passed(judge(evidence)) else 1


def latest(results: Path) -> dict[str, dict]:
    """Return the last result of each fault."""
    lines = results.read_text(encoding="utf-8").splitlines() if results.exists() else []
    return {row["place"]: row for row in map(json.loads, lines)}


def equivalent() -> set[str]:
    """Return the faults that were judged to change no answer."""
    judged = HERE / "equivalent.csv"
    if not judged.exists():
        return set()
    with judged.open(encoding="utf-8", newline="") as file:
        return {row["fault"] for row in csv.DictReader(file)}


def table(results: Path, names: list[str]) -> str:
    """Return killed, late, surviving and equivalent faults by module, with Wilson's interval."""
    same = equivalent()
    groups: dict[str, list[dict]] = {name: [] for name in names}
    for row in latest(results).values():
        if row["module"] in groups:
            groups[row["module"]].append(row)
    lines = [
        "| module | faults | killed | too slow, in these | survive | equivalent | share | 95 % |",
        "|---|---:|---:|---:|---:|---:|---:|---:|",
    ]
    for name, rows in [*groups.items(), ("all", [r for g in groups.values() for r in g])]:
        late = sum(r["how"] == "timeout" for r in rows)
        left = [r for r in rows if r["how"] == "survived"]
        none = sum(r["place"] in same for r in left)
        killed, others = len(rows) - len(left), len(rows) - none
        if not others:
            continue
        low, high = wilson(killed, others)
        lines.append(
            f"| {name} | {len(rows)} | {killed} | {late} | {len(left) - none} | {none} | "
            f"{100 * killed / others:.0f} % | {100 * low:.0f} to {100 * high:.0f} % |"
        )
    return "\n".join(lines)


def wilson(count: int, of: int, z: float = 1.959964) -> tuple[float, float]:
    """Return Wilson's score interval of a share."""
    share, extra = count / of, z**2 / of
    middle = (share + extra / 2) / (1 + extra)
    reach = z * (share * (1 - share) / of + extra / (4 * of)) ** 0.5 / (1 + extra)
    return middle - reach, middle + reach


if __name__ == "__main__":
    main()
