"""The list of slow tests names tests that there are."""

import csv

from tests.conftest import SLOW


def test_every_line_names_a_test():
    with SLOW.open(encoding="utf-8", newline="") as file:
        listed = list(csv.DictReader(file))
    names = [row["test"] for row in listed]
    assert len(set(names)) == len(names)
    root = SLOW.parents[1]
    for row in listed:
        file, _, name = row["test"].partition("::")
        assert f"\ndef {name}(" in (root / file).read_text(encoding="utf-8"), row["test"]
