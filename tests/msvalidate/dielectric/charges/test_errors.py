"""The error that charges state, against the same equations solved in 60 digits, and limits."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

from msvalidate.dielectric.charges import (
    Faces,
    Moments,
    ReportModel,
    SlabInAir,
    capacitance,
    facing_strips,
    patch_charges,
    plate,
    slab_faces,
)
from msvalidate.dielectric.charges.checks import ROUNDED, check_error
from msvalidate.problem import ProblemError, SolverError
from tests.table import table

VOLTAGES = (0.7, -0.3)


def digits60(electrodes, voltages):
    """Charges (m,) in F/m·V of horizontal strips in a medium of permittivity 1, in 60 digits.

    The mean of ln|r| over two segments is the second difference of Re w²(ln w - 3/2)/2 in their
    ends, w = x + iy between these.
    """
    flint = pytest.importorskip("flint")
    flint.ctx.prec = 200
    arb, acb = flint.arb, flint.acb
    x, y = ([arb(float(value)) for value in line] for line in electrodes.points.T)
    segments = electrodes.segments.tolist()
    m = len(segments)

    def second(p, q):
        w = acb(x[p] - x[q], abs(y[p] - y[q]))
        if w.imag == 0:
            w = acb(abs(w.real))
        return arb(0) if w == 0 else (w * w * (w.log() - arb(3) / 2) / 2).real

    whole, right = flint.arb_mat(m + 1, m + 1), flint.arb_mat(m + 1, 1)
    for i, (a, b) in enumerate(segments):
        for j, (c, d) in enumerate(segments):
            area = (x[b] - x[a]) * (x[d] - x[c])
            mean = -(second(b, d) - second(b, c) - second(a, d) + second(a, c)) / area
            whole[i, j] = (arb(float(electrodes.extent)).log() - mean) / (2 * arb.pi())
        whole[i, m] = whole[m, i] = 1
        right[i, 0] = arb(float(voltages[electrodes.electrode[i]]))
    solved = whole.solve(right)
    return np.array([float(solved[i, 0].mid()) for i in range(m)])


@pytest.mark.parametrize("gap", [0.3, 1e-3, 1e-6, 1e-8])
@pytest.mark.parametrize(("size", "away"), [(0.37, 0.0), (1e-9, 0.0), (1e9, 0.0), (0.37, 1e7)])
def test_stated_error_holds_the_true_one(size, away, gap):
    electrodes = facing_strips(size, gap * size, 6)
    electrodes = electrodes.moved(electrodes.points + size * away * np.array([1.0, -0.7]))
    found = Moments(electrodes, permittivity=3.0).charges(VOLTAGES)
    expected = 3.0 * digits60(electrodes, VOLTAGES)
    true = np.abs(found.charge - expected).sum() / np.abs(expected).sum()
    totals = np.bincount(electrodes.electrode, expected)
    assert true <= found.error
    # The bound adds up what happens to be opposite in part: two or three digits, and it is no more.
    assert found.error <= max(1e3 * true, 1e-11)
    assert np.abs(found.totals - totals).max() <= found.error * np.abs(expected).sum()
    assert found.energy == pytest.approx(0.5 * totals @ VOLTAGES, rel=2 * found.error)


def test_a_common_voltage_costs_no_digits():
    electrodes = facing_strips(0.37, 0.1, 6)
    apart = Moments(electrodes).charges((0.5, -0.5))
    high = Moments(electrodes).charges((1e9 + 0.5, 1e9 - 0.5))
    np.testing.assert_allclose(high.charge, apart.charge, rtol=1e-15)
    assert high.floating == pytest.approx(1e9, rel=1e-15)
    assert not Moments(electrodes).charges((3.0, 3.0)).charge.any()


@pytest.mark.parametrize("ratio", [1e-80, 1e-15, 1e-12, 1e12, 1e15, 1e80])
@pytest.mark.parametrize("size", [1e-9, 0.37, 1e9])
def test_permittivity_ratios_tend_to_limits(ratio, size):
    """A slab of great permittivity loses no field; one of none lets all of it pass by."""
    faces = slab_faces(size, 0.2 * size, 12, covered=0.6)
    found = SlabInAir(faces, ratio=ratio, permittivity=1.0 if ratio > 1 else ratio)
    charges = found.charges(VOLTAGES)
    limit = SlabInAir(faces, ratio=1e6, permittivity=1.0) if ratio > 1 else None
    if limit is None:
        limit = SlabInAir(faces, ratio=1e-6, permittivity=1e-6)
    expected = limit.charges(VOLTAGES)
    # The limit's own distance from it is 1e-6 of some geometry of order 1.
    np.testing.assert_allclose(charges.totals, expected.totals, rtol=1e-5)
    assert charges.energy > 0
    # A condition of some hundreds, logarithms up to 21, a free charge that is a difference.
    assert charges.error < 1e-9


def test_a_slab_of_great_permittivity_is_a_capacitor_without_edges():
    faces = slab_faces(0.37, 0.2, 80)
    # With 80 segments charges at the corners are known to some 1e-3; nothing flows around.
    assert SlabInAir(faces, ratio=1e15).charges((0.5, -0.5)).totals[0] == pytest.approx(
        0.37 / 0.2, rel=2e-3
    )


def test_every_model_states_an_error():
    strips = facing_strips(0.37, 0.1, 6)
    found = (
        ReportModel(strips, permittivity=8.9e-12, depth=0.2).charges(VOLTAGES),
        ReportModel(strips, permittivity=8.9e-12, kernel="plane").charges(VOLTAGES),
        patch_charges(plate((0.37, 0.2), 6), (0.7,), permittivity=8.9e-12),
        SlabInAir(slab_faces(0.37, 0.2, 6), permittivity=8.9e-12).charges(VOLTAGES),
        Moments(strips, permittivity=8.9e-12, weighting="collocation").charges(VOLTAGES),
    )
    for each in found:  # conditions are of the order of the number of segments, far below 1e4
        assert 1e-16 < each.error < 1e-11


@table("condition", [1e14, np.inf, np.nan])
def test_charges_without_digits_are_refused(condition):
    # Gaps that are let in make conditions of 1e9 at most.
    with pytest.raises(SolverError, match=r"charges: known to .* of their size only"):
        check_error(ROUNDED * condition)


@table("value", [5e-324, 1e-310, 1e-101, 1e101, 1.7e308])
def test_numbers_that_have_no_squares_are_refused(value):
    strips, faces = facing_strips(0.37, 0.1, 6), slab_faces(0.37, 0.2, 6)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for make in (
            lambda: capacitance(strips, permittivity=value),
            lambda: SlabInAir(faces, permittivity=value),
            lambda: SlabInAir(faces, ratio=value),
            lambda: ReportModel(strips, permittivity=value),
            lambda: patch_charges(plate((0.37, 0.2), 2), (1.0,), permittivity=value),
            lambda: Moments(strips).charges((value, 0.0)),
        ):
            with pytest.raises(ProblemError, match="take units in which it is from 1e-100"):
                make()


def test_faces_far_away_are_as_good():
    near = slab_faces(0.37, 0.2, 12)
    far = Faces(near.points + np.array([3e6, -2e6]), near.electrode)
    # Coordinates of 3e6 m are known to 5e-10 m, segments of 6e-3 m to 1e-7 of themselves.
    one, other = (SlabInAir(faces).charges(VOLTAGES).totals for faces in (far, near))
    assert one == pytest.approx(other, rel=1e-6)
