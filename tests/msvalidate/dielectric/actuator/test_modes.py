"""Lowest modes: against dense matrices, towards pull-in and beyond, without tips."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from msvalidate.dielectric.actuator import (
    at_voltage,
    fix_near_tips,
    lowest_modes,
    slab,
    sweep,
    uniform,
)
from msvalidate.dielectric.actuator.balance import stiffness
from msvalidate.dielectric.actuator.models import charge_actuator
from msvalidate.problem import ProblemError, SolverError
from tests.table import table


def test_the_lowest_mode_softens_towards_pull_in(plates):
    near = sweep(plates, [3.0, 6.0, 7.0], bracket=1e-5).equilibria
    values = [lowest_modes(held)[0][0] for held in near]
    assert (np.diff(values) < 0).all()
    assert 0 < values[-1] < 0.05 * values[0]


def test_an_unstable_place_has_a_negative_mode():
    """At the same voltage beyond pull-in's thickness: the other, unstable branch."""
    body = slab(60.0, 10.0, 10, sides="sliding", model="parallel_plates")
    ratio = 0.6
    start = at_voltage(body, 0.0)
    squeezed = replace(
        start,
        voltage=uniform.voltage(ratio),
        displacement=body.network.points * [0, ratio - 1],
    )
    (value,), (mode,) = lowest_modes(squeezed)
    assert value < 0
    K = stiffness(
        body, squeezed.position, charge_actuator(body, squeezed.position, squeezed.voltage)
    )
    assert value == pytest.approx(np.linalg.eigvalsh(K.toarray())[0], rel=1e-9)
    assert np.abs(mode[body.electrodes[0], 1]).max() > 0
    with pytest.raises(SolverError, match="no stable equilibrium near the start"):
        at_voltage(body, squeezed.voltage, start=squeezed)


def test_holding_tips_stiffens_the_lowest_mode(film):
    held = at_voltage(film, 1.5)
    (with_tips,), (mode,) = lowest_modes(held)
    kept = at_voltage(fix_near_tips(film, 1.0), 1.5)
    (without,), (inside,) = lowest_modes(kept)
    assert without >= with_tips
    edges = film.electrodes[0][[0, -1]]
    assert not inside[edges].any()
    assert mode[edges].any()
    assert not kept.displacement[edges].any()


@table("count", [0, 10**6, 1.5])
def test_lowest_modes_refuses(film, count):
    with pytest.raises(ProblemError, match="count"):
        lowest_modes(at_voltage(film, 0.5), count)
