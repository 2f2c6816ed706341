"""The study `pull_in`: the infinite slab's waves, routes, controls."""

from dataclasses import replace
from functools import partial

import numpy as np
import pandas as pd
import pytest
from msvalidate.studies.pull_in import (
    branches,
    film,
    homogeneous,
    infinite,
    instability,
    pressed,
    pull_in_controls,
    sweep,
)
from msvalidate.studies.pull_in.slab import HEIGHT, PERMITTIVITY, PULL_IN
from msvalidate.studies.pull_in.way import SPRINGS, PullInSolver, bonded, sliding

from msvalidate.bench.judging.evidence import judge
from msvalidate.bench.judging.sweep import Setting
from msvalidate.dielectric.actuator import at_voltage, uniform
from msvalidate.dielectric.charges import Moments, facing_strips, tangent
from msvalidate.springs.network import tangent as springs_tangent
from msvalidate.studies import pull_in

QUICK = Setting(quick=True)


# --- waves of the infinite slab -------------------------------------------------------------------


@pytest.mark.parametrize("turn", [0.3, 1.0, 2.2])
@pytest.mark.parametrize("part", [0.95, 0.75])
def test_softening_is_that_of_a_long_pair_of_strips(part, turn):
    """Row of the tangent of the method of moments, in the middle of electrodes 16 gaps long."""
    layers, columns = 5, 120
    spacing = HEIGHT / layers
    strips = facing_strips(columns * spacing, part * HEIGHT, columns, grading="uniform")
    volts = uniform.voltage(part, height=HEIGHT)
    K = tangent(Moments(strips, permittivity=PERMITTIVITY).charges((0.5 * volts, -0.5 * volts)))
    n = len(strips.points) // 2
    middle = columns // 2
    block = K.reshape(2 * n, 2, 2 * n, 2)[middle, :, :n]
    phase = np.exp(1j * turn * (np.arange(n) - middle))
    found = np.einsum("iaj,a->ij", block.transpose(0, 1, 2), phase)
    q = np.array([turn / spacing])
    expected = infinite.softening(infinite.Columns(np.array([part]), spacing, q))[0]
    scale = np.abs(expected).max()
    np.testing.assert_allclose(found, expected, atol=2e-2 * scale)


def test_softening_of_long_waves_is_that_of_a_conductor():
    part, layers = np.array([0.8]), 200
    q = np.array([2 * np.pi / 7.0])
    columns = infinite.Columns(part, HEIGHT / layers, q)
    K = infinite.softening(columns)[0] / columns.spacing
    gap = part[0] * HEIGHT
    field = columns.charge[0] / PERMITTIVITY
    expected = PERMITTIVITY * field**2 * q[0] / np.tanh(q[0] * gap)
    assert K[1, 1].real == pytest.approx(expected, rel=1e-3)
    assert abs(K[0, 0]) < 1e-3 * expected


@pytest.mark.parametrize("part", [0.95, 0.7])
def test_stiffness_of_waves_is_the_networks(part):
    layers, turn = 4, 0.9
    actuator = bonded(layers)
    network = actuator.network
    K = springs_tangent(network, network.points * [1.0, part]).toarray()
    n = len(network.points)
    x, y = network.points.T
    spacing = HEIGHT / layers
    at = int(np.argmin(np.abs(x - x.max() / 2) + np.abs(y - HEIGHT)))
    phase = np.exp(1j * turn * (x - x[at]) / spacing)
    columns = infinite.Columns(np.array([part]), spacing, np.array([turn / spacing]))
    _, top, link = infinite.blocks(columns)
    rows = K.reshape(n, 2, n, 2)[at]
    for level, block in ((HEIGHT, top[0]), (HEIGHT - spacing, link[0])):
        there = np.abs(y - level) < 1e-9
        found = np.einsum("iaj,a->ij", rows[:, there], phase[there])
        np.testing.assert_allclose(found, block, atol=1e-12)


def test_waves_without_end_go_at_the_uniform_pull_in():
    parts = infinite.thresholds(5, np.array([4000.0]))
    assert parts[0] == pytest.approx(PULL_IN.thickness, abs=1e-3)


@pytest.mark.parametrize("wave", [4.0, 11.0, 30.0])
def test_elimination_finds_where_the_lowest_eigenvalue_is_zero(wave):
    parts = infinite.thresholds(5, np.array([wave]))
    q = np.array([2 * np.pi / wave])
    for shift, sign in ((1e-6, 1), (-1e-6, -1)):
        if parts[0] > PULL_IN.thickness + 1e-5:
            assert np.sign(infinite.softest_wave(parts[0] + shift, 5, q))[0] == sign


# --- other routes ---------------------------------------------------------------------------------


@pytest.mark.parametrize("kappa", [0.5, 3.0, 10.0])
def test_film_by_elements(kappa):
    assert film.field(kappa) == pytest.approx(uniform.bonded_film_field(kappa), rel=2e-4)


def test_free_sheet_widens_alike():
    assert homogeneous.free_sheet(1.7) == pytest.approx(
        homogeneous.neo_hookean(np.sqrt(1.7), np.sqrt(1.7)), rel=1e-12
    )


@pytest.mark.parametrize("law", [pressed.springs, pressed.elements])
def test_pressed_column(law):
    assert law(uniform.pressure(0.6)) == pytest.approx(0.6, abs=1e-9)


# --- measuring a mode -----------------------------------------------------------------------------


@pytest.mark.parametrize("wave", [5.0, 8.0, 20.0])
def test_wavelength_of_a_known_mode(wave):
    held_at = at_voltage(bonded(4), 0.0)
    points = held_at.actuator.network.points
    bump = np.sin(np.pi * points[:, 0] / points[:, 0].max())
    mode = np.zeros(points.shape)
    mode[:, 1] = bump * np.cos(2 * np.pi * points[:, 0] / wave)
    assert branches.wavelength(held_at, mode) == pytest.approx(wave, rel=0.02)


def test_what_is_the_meshs_is_read_off_the_table():
    table = pd.DataFrame(
        {
            "branch": ["a", "a", "b", "b"],
            "critical_over_pull_in": [0.5, 0.3, 0.95, 0.94],
            "mode_wavelength_over_h": ["none", "none", 0.8, 0.4],
        }
    )
    said = instability.label_mesh_dependence(table)["mesh_dependent"]
    assert list(said) == ["voltage", "voltage", "wavelength", "wavelength"]
    calm = table.assign(critical_over_pull_in=0.5, mode_wavelength_over_h=0.8)
    assert set(instability.label_mesh_dependence(calm)["mesh_dependent"]) == {"nothing"}


# --- controls -------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", pull_in_controls.KINDS)
def test_stated_resolution_is_the_real_one(kind):
    noticed = (
        pull_in_controls.run().tables["resolution"].set_index("fault")["smallest_noticed"][kind]
    )
    for part, passes in ((1.1, False), (0.9, True)):
        found = pull_in_controls.pulled_in(
            PullInSolver(partial(pull_in_controls.KINDS[kind], part * noticed))
        )
        error = abs(found / PULL_IN.voltage - 1)
        assert (error <= sweep.RULES[1].limit) == passes


def test_no_fault_is_the_way_itself():
    right = pull_in_controls.pulled_in(SPRINGS)
    for faulty in pull_in_controls.KINDS.values():
        assert pull_in_controls.pulled_in(PullInSolver(partial(faulty, 0.0))) == right


def test_half_the_softening_is_between():
    found = at_voltage(sliding(3), 0.95 * PULL_IN.voltage)
    whole, half, none = (
        modes(found, 1)[0][0]
        for modes in (SPRINGS.modes, pull_in_controls.half_softened, pull_in_controls.springs_alone)
    )
    assert whole < half < none
    assert pull_in_controls.springs_alone(replace(found, voltage=5.0), 1)[0][0] == none


@pytest.mark.parametrize(
    ("fault", "noticing"),
    [
        ("a lattice without its diagonals", [2]),
        ("a linear sheet in the neo-Hookean one's place", [0, 2]),
        ("a bonded film of a ratio of 0.49", [1]),
    ],
)
def test_each_threshold_notices_its_law(fault, noticing):
    verdict = judge(pull_in.run(**pull_in.FAULTS[fault], setting=QUICK))["verdict"]
    assert [i for i, word in enumerate(verdict) if word == "fail"] == noticing


def test_linear_sheet_is_the_neo_hookean_one_to_second_order():
    for along, across in ((1e-3, 0.0), (1e-3, 2e-3), (-1e-3, 5e-4)):
        soft, straight = (
            law(1 + along, 1 + across)
            for law in (homogeneous.neo_hookean, pull_in_controls.linear_sheet)
        )
        assert straight == pytest.approx(soft, rel=1e-2)
