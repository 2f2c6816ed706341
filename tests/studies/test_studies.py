"""Every study that there is: it passes, it fails under each of its faults, its figures draw."""

import pytest
from matplotlib.figure import Figure

from msvalidate.judging import catalogue
from msvalidate.judging.evidence import held, judge
from msvalidate.judging.sweep import Setting
from msvalidate.problem import ProblemError

QUICK = Setting(quick=True)
FAULTS = [(name, fault) for name in catalogue.names() for fault in catalogue.load(name).FAULTS]


@pytest.fixture(scope="module", params=catalogue.names())
def name(request):
    return request.param


@pytest.fixture(scope="module")
def study(name):
    return catalogue.load(name)


@pytest.fixture(scope="module")
def evidence(name, small_form):
    return small_form(name)


def test_passes_in_its_small_form(evidence):
    verdict = judge(evidence)
    assert held(verdict), verdict[verdict["verdict"] == "fail"].to_string()


def test_tolerances_have_units_and_reasons(evidence):
    for tolerance in evidence.tolerances:
        assert tolerance.unit
        assert len(tolerance.because) > 10, tolerance.quantity


def test_figures_are_functions_of_the_tables(evidence):
    assert evidence.figures
    for draw in evidence.figures.values():
        figure = draw(evidence.tables)
        assert isinstance(figure, Figure)
        for axis in figure.axes:
            place = axis.get_subplotspec()
            if place is None:  # a colour bar
                assert axis.get_xlabel() or axis.get_ylabel()
                continue
            assert axis.get_xlabel() or not place.is_last_row()
            assert axis.get_ylabel() or not place.is_first_col()


def test_says_what_it_asks(study):
    assert study.__doc__.splitlines()[0].endswith("?")
    assert study.FAULTS, "a study without a negative control proves nothing"


@pytest.mark.parametrize(("name", "fault"), FAULTS)
def test_fails_under_a_known_fault(name, fault):
    study = catalogue.load(name)
    verdict = judge(study.run(**study.FAULTS[fault], setting=QUICK))
    assert not held(verdict)


@pytest.mark.parametrize("candidate", [None, 3, [], {"a": 1}])
def test_a_candidate_that_is_none_is_refused_in_one_line(study, candidate):
    with pytest.raises(ProblemError, match=r"^candidate: ") as refused:
        study.run(candidate=candidate, setting=QUICK)
    assert "\n" not in str(refused.value)
