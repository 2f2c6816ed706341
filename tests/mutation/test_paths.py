"""What a mutation run names is there: files, tests of each, and the lines judged equivalent."""

import csv
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))
from run import KERNELS, MODULES, ROOT  # noqa: E402


def test_every_pattern_finds_files():
    patterns = [p for files, tests, _ in MODULES.values() for p in (*files, *tests)]
    assert [p for p in patterns if not list(ROOT.glob(p))] == []


def test_every_file_of_compiled_code_has_its_tests():
    files = {path.stem for pattern in MODULES["kernels"][0] for path in ROOT.glob(pattern)}
    assert set(KERNELS) == files
    named = {test for groups in KERNELS.values() for group in groups for test in group}
    for test in named:
        file, _, function = test.partition("::")
        assert f"def {function.partition('[')[0]}" in (ROOT / file).read_text(encoding="utf-8")


def test_every_line_judged_equivalent_is_there():
    with (HERE / "equivalent.csv").open(encoding="utf-8", newline="") as file:
        judged = [row["fault"].split(" | ", 1) for row in csv.DictReader(file)]
    for name, fault in judged:
        text = fault.rpartition(" #")[0]
        lines = (ROOT / name).read_text(encoding="utf-8").splitlines()
        assert text in [line.strip() for line in lines], name
