"""What charges do to a network: forces, stiffness, and equilibria as each model says."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from msvalidate.dielectric.actuator import PulledIn, at_voltage, lowest_modes, relax_actuator, slab
from msvalidate.dielectric.actuator.balance import residual_force, stiffness
from msvalidate.dielectric.actuator.models import charge_actuator
from msvalidate.springs.network import energy


def disturbed(body, size=0.03):
    """A place near the start, with a wavy electrode."""
    network = body.network
    spacing = network.rest_length.min()
    away = size * spacing * np.random.default_rng(7).normal(size=network.points.shape)
    return network.points + np.where(network.fixed, 0.0, away)


def potential_energy(body, x, volts):
    """Springs' energy less that of the electrodes."""
    return energy(body.network, x) - body.depth * charge_actuator(body, x, volts).charges.energy


def test_forces_are_the_slope_of_the_energy(body):
    x, volts, step = disturbed(body), 0.4, 1e-5
    force = residual_force(body, x - body.network.points, charge_actuator(body, x, volts))
    for point, axis in np.argwhere(~body.network.fixed)[::3]:
        beside = np.zeros(x.shape)
        beside[point, axis] = step
        up, down = (potential_energy(body, x + s * beside, volts) for s in (1, -1))
        # 1e-10 by the third derivative, 1e-16/1e-5 by rounding.
        assert force[point, axis] == pytest.approx(-(up - down) / (2 * step), abs=1e-8)


def slopes(body, step):
    """Central differences of forces in free components, and the stiffness they are to be."""
    x, volts = disturbed(body), 0.4
    free = ~body.network.fixed
    K = stiffness(body, x, charge_actuator(body, x, volts)).toarray()
    found = np.empty_like(K)
    for column, (point, axis) in enumerate(np.argwhere(free)):
        beside = np.zeros(x.shape)
        beside[point, axis] = step
        up, down = (
            residual_force(body, place - body.network.points, charge_actuator(body, place, volts))[
                free
            ]
            for place in (x + beside, x - beside)
        )
        found[:, column] = -(up - down) / (2 * step)
    return found, K


def test_stiffness_is_the_slope_of_the_forces(body):
    found, K = slopes(body, step=1e-5)
    assert abs(K - K.T).max() <= 1e-12 * abs(K).max()
    assert abs(K - found).max() <= 1e-7 * abs(K).max()


def test_stiffness_of_the_report_s_model_is_the_symmetric_part():
    found, K = slopes(slab(4.0, 1.0, 3, covered=0.5, model="as_report", depth=2.0), step=1e-5)
    largest = abs(K).max()
    assert abs(found - found.T).max() > 1e-3 * largest
    assert abs(K - 0.5 * (found + found.T)).max() <= 1e-7 * largest


def test_air_of_the_same_permittivity_is_the_plane():
    plane = slab(4.0, 1.0, 4, covered=0.5, permittivity=1.3)
    air = replace(plane, model="in_air", permittivity_ratio=1.0)
    one, other = at_voltage(plane, 0.3), at_voltage(air, 0.3)
    assert other.displacement == pytest.approx(one.displacement, abs=1e-10)
    assert other.charges.totals == pytest.approx(one.charges.totals, rel=1e-9)
    assert lowest_modes(other)[0] == pytest.approx(lowest_modes(one)[0], rel=1e-4)


def test_the_report_s_model_ends_at_its_own_equilibrium():
    """Its forces are no slopes of an energy, so both ways must find where they balance."""
    body = slab(4.0, 1.0, 2, covered=0.5, model="as_report")
    one, moved = at_voltage(body, 0.3), relax_actuator(body, 0.3)
    assert one.displacement == pytest.approx(moved.displacement, abs=1e-7)
    plane = at_voltage(replace(body, model="plane"), 0.3)
    assert abs(one.top[:, 1] - plane.top[:, 1]).max() > 1e-4
    more = at_voltage(body, 0.35, start=one)
    assert lowest_modes(more)[0][0] < lowest_modes(one)[0][0]
    with pytest.raises(PulledIn):
        at_voltage(body, 0.7, start=more, bracket=1e-3)
