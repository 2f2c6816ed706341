"""Sweeps over voltages, and pull-in where the closed forms have it."""

from __future__ import annotations

import numpy as np
import pytest

from msvalidate.dielectric.actuator import slab, sweep, uniform
from msvalidate.problem import ProblemError
from tests.table import table


def test_uniform_slab_is_pulled_in_at_its_closed_form(plates):
    end = sweep(plates, np.linspace(0.5, 10, 20), bracket=1e-8)
    low, high = end.pull_in
    ratio, volts = uniform.pull_in()
    assert low <= volts <= high * (1 + 1e-12)
    assert high - low <= 1e-8 * high
    # Beside pull-in V falls by 25 V·(Δl)² or so: 6e-8 V are 5e-5 of the ratio.
    found = end.last.top[:, 1].mean() / 10
    assert found == pytest.approx(ratio, abs=1e-4)
    assert (round(low, 3), round(found, 3)) == (6.348, 0.692)


def test_prestretched_slab_is_pulled_in_at_its_closed_form():
    body = slab(5.0, 10.0, 4, sides="sliding", model="parallel_plates", prestretch=1.3)
    low, high = sweep(body, np.linspace(0.5, 10, 20), bracket=1e-6).pull_in
    assert low <= uniform.pull_in(stretch=1.3).voltage <= high


def test_steps_do_not_move_pull_in():
    """Every bracket holds the same voltage, however it was approached."""
    body = slab(12.0, 4.0, 4)
    brackets = [
        sweep(body, [2.0, 4.0, 6.0]).pull_in,
        sweep(body, np.linspace(0.12, 3.0, 25)).pull_in,
        sweep(body, [50.0]).pull_in,
    ]
    assert max(low for low, _ in brackets) < min(high for _, high in brackets)


def test_a_sweep_of_the_report_s_slab_takes_few_solves():
    """Newton's method from the last equilibrium: some four a step, a few more near its end."""
    body = slab(60.0, 10.0, 10)
    assert len(body.network.points) == 61 * 11
    run = sweep(body, np.linspace(0.14, 2.8, 20))
    assert len(run.equilibria) == 21
    assert sum(held.iterations for held in run.equilibria) <= 6 * 20


def test_sweep_keeps_what_it_held(plates):
    run = sweep(plates, [1.0, 3.0, 6.3, 6.5])
    assert run.voltages[:4].tolist() == [0, 1, 3, 6.3]
    assert 6.3 < run.last.voltage == run.pull_in[0] < run.pull_in[1] < 6.5
    assert run.pull_in[1] - run.pull_in[0] <= 1e-4 * 6.5
    reached = sweep(plates, [1.0, 2.0])
    assert reached.pull_in is None
    assert reached.voltages.tolist() == [0, 1, 2]


@table("voltages", [None, [2.0, 1.0], [0.0, 1.0], 1.0, [np.nan]])
def test_sweep_refuses(film, voltages):
    with pytest.raises(ProblemError):
        sweep(film, voltages)
