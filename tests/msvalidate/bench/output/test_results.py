"""Tables of other studies: of this run, else stored, else committed; the same whichever it is."""

from __future__ import annotations

import pandas as pd
import pytest

from msvalidate.bench.judging.evidence import Evidence, Observed, Tolerance, judge
from msvalidate.bench.output import stored
from msvalidate.bench.output.results import BASELINE, STORED, THIS_RUN, Results, check_results
from msvalidate.problem import ProblemError

TABLE = pd.DataFrame({"n": [1, 2], "x": [0.1, "none"], "word": ["a", "1e"], "flag": [True, False]})
MEANING = {"n": "number (1)", "x": 'length (m), or "none"', "word": "a word", "flag": "yes or no"}


@pytest.fixture
def folder(tmp_path):
    """Results of `poisson`, whole, and of `lattices`, of which the last run did not finish."""
    evidence = Evidence(
        {"t": TABLE}, {"gap": Observed(0.0)}, (Tolerance("gap", 1.0, "m", "so"),), columns=MEANING
    )
    files = stored.result_files(stored.Result("s", "?", evidence, judge(evidence)), {}, plots=False)
    for name in ("poisson", "lattices"):
        (tmp_path / name).mkdir()
        for file, content in files.items():
            (tmp_path / name / file).write_bytes(content)
    broken = stored.unfinished_files(tmp_path / "lattices", "?", {}, "diverged")
    for file, content in broken.items():
        (tmp_path / "lattices" / file).write_bytes(content)
    (tmp_path / "stability").mkdir()
    return tmp_path


def test_a_table_is_the_same_from_a_run_and_from_files(folder):
    run, kept = Results("quick", {"poisson": {"t": TABLE}}), Results("quick", folder=folder)
    assert (run.source("poisson"), kept.source("poisson")) == (THIS_RUN, STORED)
    pd.testing.assert_frame_equal(run.table("poisson", "t"), kept.table("poisson", "t"))
    assert list(kept.table("poisson", "t")["n"]) == [1.0, 2.0]
    assert list(kept.table("poisson", "t")["x"]) == [0.1, "none"]


def test_what_did_not_finish_is_read_from_the_committed_baseline(folder):
    results = Results("quick", folder=folder)
    for study in ("lattices", "stability", "damping"):
        assert results.source(study) == BASELINE
    assert len(results.table("lattices", "uniform")) > 10


def test_a_table_that_there_is_not_is_refused_in_one_line():
    for results, where in (
        (Results("quick", {"poisson": {}}), THIS_RUN),
        (Results("quick"), BASELINE),
    ):
        said = f"^{where}: no table poisson/none; run poisson again$"
        with pytest.raises(ProblemError, match=said):
            results.table("poisson", "none")


def test_a_candidate_is_results_or_nothing():
    assert check_results(None, quick=True) == Results("quick")
    with pytest.raises(ProblemError, match=r"^candidate: 3; give a Results"):
        check_results(3, quick=True)
