"""The study `fracture`: which turned lattices have rows that a crack follows."""

import pandas as pd
import pytest
from msvalidate.studies.fracture import paths

from msvalidate.bench.judging.sweep import Setting
from msvalidate.springs.statics.breaking import propagate_crack


@pytest.mark.parametrize("seed", [11])
def test_cracks_follow_rows_in_the_stated_ranges_at_random_turns_and_places(seed):
    """A seed other than the study's; limits are those of its rules."""
    cases = paths.draw_cases(Setting(quick=True, seed=seed), paths.ALONG)
    table = pd.DataFrame([paths.path_of(propagate_crack, case)[0] for case in cases])
    assert paths.follows(table).all()


def test_a_crack_outside_the_ranges_follows_no_row():
    """Square-8 turned by 40°, where the report had claimed the nearest row."""
    turns = paths.Turns("square-8", 40.0, 40.0, 0.0, 45.0)
    row, _ = paths.path_of(propagate_crack, (turns, 40.0, 0.013, 1.0, 0))
    assert abs(row["off_row"]) > paths.ON_ROW or row["width"] > paths.ONE_LINE
