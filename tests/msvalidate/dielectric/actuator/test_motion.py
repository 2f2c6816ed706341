"""Motion to rest with charges that follow."""

from __future__ import annotations

import numpy as np
import pytest

from msvalidate.dielectric.actuator import at_voltage, motion, relax_actuator, slab
from msvalidate.problem import ProblemError, SolverError
from tests.table import table


@pytest.mark.parametrize("every", [1, 7])
def test_motion_comes_to_rest_at_the_equilibrium(film, every):
    run = relax_actuator(film, 1.0, charges_every=every)
    rest = at_voltage(film, 1.0)
    assert np.abs(run.displacement - rest.displacement).max() <= 1e-6


def test_motion_beyond_pull_in_says_so(plates):
    with pytest.raises(SolverError, match=r"actuator moving at 8 V") as caught:
        relax_actuator(plates, 8.0)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("name", "value", "said"),
    [
        ("DIVERGED", 0.0, "actuator moving at 1 V diverged by step 0; take a lower voltage"),
        ("step_limit", lambda _: 3, "actuator moving at 1 V is not at rest after 3 steps"),
    ],
)
def test_motion_that_diverges_or_is_not_at_rest_in_time_says_so(
    film, monkeypatch, name, value, said
):
    monkeypatch.setattr(motion, name, value)
    with pytest.raises(SolverError, match=said):
        relax_actuator(film, 1.0)


def test_a_start_of_another_network_is_refused(film):
    other = at_voltage(slab(2.0, 1.0, 1), 0.1)
    with pytest.raises(ProblemError, match=r"start: displacements \(6, 2\) of another network"):
        relax_actuator(film, 0.1, start=other)


@table(
    "given",
    [{"charges_every": 0}, {"tolerance": 1.0}, {"start": 1}],
)
def test_motion_refuses(film, given):
    with pytest.raises(ProblemError):
        relax_actuator(film, 1.0, **given)
