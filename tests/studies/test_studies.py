"""Every study that there is: it fails under its faults; what its small form says is in order.

That it holds in its small form is what `check` says, which runs each study once: here it is run
again among the slow tests alone, for what `check` does not look at.
"""

import csv
import importlib.util
import tomllib
from pathlib import Path

import pytest
from matplotlib.figure import Figure

from msvalidate.bench.judging import catalogue
from msvalidate.bench.judging.columns import common_columns
from msvalidate.bench.judging.evidence import UNGATED, all_passed, judge
from msvalidate.bench.judging.sweep import Setting
from msvalidate.cli.program import main
from msvalidate.problem import ProblemError

QUICK = Setting(quick=True)
ROOT = Path(__file__).resolve().parents[2]
TELLING = {
    "actuator": "half of the electrodes' force in a stretched film",
    "benchmarks": "patch with one spring missing",
    "claims": "every damping costs the same",
    "convergence": "a wrong kick: half the force",
    "cost": "a solver that stops early and states no error",
    "damping": "forces a fiftieth of a step late",
    "displacement": "every spring 0.1 % softer",
    "electrostatics": "segments seen as points",
    "large_strain": "rest lengths of diagonals 0.1 % off",
    "lattices": "one neighbour direction missing",
    "overview": "energy of volumes left out",
    "poisson": "wrong boundary weights",
    "pull_in": "a voltage beyond pull-in is held",
    "stability": "a thousandth of Verlet's second kick missing",
}
"""Study -> the fault that says most for the least time, asked at each change; of other studies the
first. All are asked in the slow tests."""


def faults():
    """Each study and fault; all but one a study are slow."""
    found = []
    for name in catalogue.names():
        known = list(catalogue.load(name).FAULTS)
        fast = TELLING.get(name, known[0])
        for fault in known:
            marks = [] if fault == fast else [pytest.mark.slow]
            found.append(pytest.param(name, fault, marks=marks))
    return found


@pytest.fixture(scope="module", params=catalogue.names())
def name(request):
    return request.param


@pytest.fixture(scope="module")
def study(name):
    return catalogue.load(name)


@pytest.fixture(scope="module")
def evidence(name, small_form):
    return small_form(name)


@pytest.mark.slow
def test_passes_in_its_small_form(evidence):
    verdict = judge(evidence)
    assert all_passed(verdict), verdict[verdict["verdict"] == "fail"].to_string()


@pytest.mark.slow
def test_tolerances_have_units_and_reasons(evidence):
    for tolerance in evidence.tolerances:
        assert tolerance.unit
        assert len(tolerance.because) > 10, tolerance.quantity


@pytest.mark.slow
def test_figures_are_functions_of_the_tables(name, evidence):
    assert bool(evidence.figures) == (name != "claims")  # a ledger: tables alone
    for draw in evidence.figures.values():
        figure = draw({**evidence.tables, **evidence.drawn})
        assert isinstance(figure, Figure)
        for axis in figure.axes:
            place = axis.get_subplotspec()
            if place is None:  # a colour bar
                assert axis.get_xlabel() or axis.get_ylabel()
                continue
            assert axis.get_xlabel() or not place.is_last_row()
            assert axis.get_ylabel() or not place.is_first_col()


def test_names_its_topic(study):
    title = study.__doc__.splitlines()[0]
    assert 2 <= len(title.split()) <= 8
    assert title[-1] not in ".?"
    assert study.FAULTS, "a study without a negative control proves nothing"


def test_telling_faults_are_those_of_studies():
    assert all(fault in catalogue.load(name).FAULTS for name, fault in TELLING.items())


@pytest.mark.parametrize(("name", "fault"), faults())
def test_fails_under_a_known_fault(name, fault):
    study = catalogue.load(name)
    verdict = judge(study.run(**study.FAULTS[fault], setting=QUICK))
    assert not all_passed(verdict)


def test_a_candidate_that_is_none_is_refused_in_one_line(study):
    reads = getattr(study, "READS_RESULTS", False)  # of the committed baseline, if none is given
    for candidate in (*(() if reads else (None,)), 3, [], {"a": 1}):
        with pytest.raises(ProblemError, match=r"^candidate: ") as refused:
            study.run(candidate=candidate, setting=QUICK)
        assert "\n" not in str(refused.value)


def test_each_study_answers_some_of_its_questions(study):
    with pytest.raises(ProblemError, match=r"questions: 'no such'; choose from \w+"):
        study.run(setting=QUICK, questions=("no such",))


def test_a_new_study_is_one_of_all_these(tmp_path):
    place = tmp_path / "plate.py"
    assert main(["study", "new", str(place)]) == 0
    assert main(["study", "new", str(place)]) == main(["study", "new", "poisson"]) == 2
    spec = importlib.util.spec_from_file_location("plate", place)
    study = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(study)
    test_names_its_topic(study)
    test_a_candidate_that_is_none_is_refused_in_one_line(study)
    test_each_study_answers_some_of_its_questions(study)
    evidence = study.run(setting=QUICK)
    test_passes_in_its_small_form(evidence)
    test_figures_are_functions_of_the_tables("plate", evidence)
    for fault in study.FAULTS.values():
        assert not all_passed(judge(study.run(**fault, setting=QUICK)))


def test_words_are_of_columns_that_there_are():
    """Columns of times are in no baseline."""
    heads = {}
    for path in (ROOT / "reports" / "baseline").glob("*/*/*.csv"):
        head = path.read_text(encoding="utf-8").partition("\n")[0]
        heads.setdefault(path.parent.name, set()).update(next(csv.reader([head])))
    for path in (ROOT / "studies").rglob("columns.toml"):
        there = heads[path.relative_to(ROOT / "studies").parts[0]]
        words = tomllib.loads(path.read_text(encoding="utf-8"))
        names = {one.rpartition(".")[2] for one in words}
        assert {one for one in names if one not in there and not one.endswith(UNGATED)} == set()
    common = {one.rpartition(".")[2] for one in common_columns()}
    assert common <= set.union(*heads.values())
