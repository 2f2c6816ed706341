"""Equilibria at a voltage, and what is refused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from msvalidate.dielectric.actuator import ActuatorEquilibrium, PulledIn, at_voltage, slab, uniform
from msvalidate.problem import ProblemError, SolverError
from tests.table import table


def test_a_start_changes_the_way_but_not_the_end(film):
    half = at_voltage(film, 0.5)
    onwards = at_voltage(film, 1.0, start=half)
    direct = at_voltage(film, 1.0)
    back = at_voltage(film, 0.5, start=onwards)
    assert onwards.displacement == pytest.approx(direct.displacement, abs=1e-9)
    assert back.displacement == pytest.approx(half.displacement, abs=1e-9)
    again = at_voltage(film, 0.5, start=half)
    assert again.displacement == pytest.approx(half.displacement, abs=1e-9)


def test_uniform_slab_follows_its_closed_form(plates):
    for volts in (1.0, 4.0, 6.0):
        held = at_voltage(plates, volts)
        expected = 10 * uniform.thickness(volts)
        assert held.top[:, 1] == pytest.approx(expected, rel=1e-9)


def test_free_sides_of_a_stretched_film_draw_back():
    body = slab(8.0, 2.0, 4, prestretch=1.2)
    rest = at_voltage(body, 0.0)
    drawn = rest.top[:, 0] - body.network.points[body.electrodes[0], 0]
    assert drawn[0] > 0.05
    assert drawn[-1] == pytest.approx(-drawn[0])
    middle = len(drawn) // 2
    assert abs(drawn[middle]) < 1e-9
    assert at_voltage(body, 0.5).top[middle, 1] < rest.top[middle, 1]


def test_what_is_not_stable_without_a_voltage_is_refused():
    body = slab(2.0, 1.0, 2)
    force = np.where(body.network.fixed, 0.0, [0.0, -5.0])  # many times the springs' own strength
    pressed = replace(body.network, force=force)
    with pytest.raises(SolverError, match=r"no stable equilibrium at 0 V; lower"):
        at_voltage(replace(body, network=pressed), 1.0)


def test_beyond_pull_in_one_line_names_both_voltages(plates):
    with pytest.raises(
        PulledIn, match=r"no stable equilibrium at 7 V.* last voltage held is 6\.34"
    ) as e:
        at_voltage(plates, 7.0)
    assert "\n" not in str(e.value)
    assert isinstance(e.value, SolverError)
    assert isinstance(e.value.last, ActuatorEquilibrium)
    assert e.value.last.voltage < uniform.pull_in().voltage < e.value.beyond


@table(
    ("given", "match"),
    [
        ({"voltage": np.nan}, "voltage: nan"),
        ({"voltage": np.inf}, "voltage: inf"),
        ({"voltage": "high"}, "voltage"),
        ({"bracket": 0.1}, "at most"),
        ({"bracket": -1.0}, "bracket"),
        ({"start": 3}, "start: 3; give an ActuatorEquilibrium"),
    ],
)
def test_at_voltage_refuses(film, given, match):
    with pytest.raises(ProblemError, match=match):
        at_voltage(film, **{"voltage": 1.0} | given)


def test_a_start_of_another_network_is_refused(film, plates):
    with pytest.raises(ProblemError, match="another network"):
        at_voltage(film, 1.0, start=at_voltage(plates, 1.0))
