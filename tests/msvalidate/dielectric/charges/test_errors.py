"""The error that charges state, against the same equations solved in 60 digits."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from msvalidate.dielectric.charges import Moments, ReportModel, SlabInAir, facing_strips
from msvalidate.dielectric.charges.checks import ROUNDED, check_error
from msvalidate.dielectric.charges.faces import slab_faces
from msvalidate.problem import SolverError
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
@pytest.mark.parametrize("size", [0.37, 1e-9])
def test_stated_error_holds_the_true_one(size, gap):
    electrodes = facing_strips(size, gap * size, 6)
    found = Moments(electrodes, permittivity=3.0).charges(VOLTAGES)
    expected = 3.0 * digits60(electrodes, VOLTAGES)
    true = np.abs(found.charge - expected).sum() / np.abs(expected).sum()
    totals = np.bincount(electrodes.electrode, expected)
    assert true <= found.error
    # The bound adds up what happens to be opposite in part: two or three digits, and it is no more.
    assert found.error <= max(1e3 * true, 1e-11)
    assert np.abs(found.totals - totals).max() <= found.error * np.abs(expected).sum()
    assert found.energy == pytest.approx(0.5 * totals @ VOLTAGES, rel=2 * found.error)


@pytest.mark.parametrize("kernel", ["report", "plane"])
def test_turned_electrodes_have_equal_charges_within_their_error(kernel):
    rng = np.random.default_rng(4)
    for gap, angle in zip(10 ** rng.uniform(-3, 0, 4), rng.uniform(0, 6, 4), strict=True):
        strips, (c, s) = facing_strips(0.37, gap * 0.37, 6), (np.cos(angle), np.sin(angle))
        turned = replace(strips, points=strips.points @ [[c, s], [-s, c]])
        models = [ReportModel(each, depth=0.2, kernel=kernel) for each in (strips, turned)]
        one, other = (model.charges(VOLTAGES) for model in models)
        room = (one.error + other.error) * np.abs(one.charge).sum()
        assert 0 < np.abs(one.charge - other.charge).sum() <= room


def test_every_model_states_an_error():
    strips = facing_strips(0.37, 0.1, 6)
    found = (
        ReportModel(strips, permittivity=8.9e-12, depth=0.2).charges(VOLTAGES),
        ReportModel(strips, permittivity=8.9e-12, kernel="plane").charges(VOLTAGES),
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
