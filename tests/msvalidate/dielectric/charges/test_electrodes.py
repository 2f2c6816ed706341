"""Electrodes: what they know of themselves, and bad ones told in one line."""

from __future__ import annotations

import math

import numpy as np
import pytest

from msvalidate.dielectric.charges import (
    Electrodes,
    Moments,
    ReportModel,
    SlabInAir,
    capacitance,
    checks,
    electrodes_of_chains,
    facing_strips,
    facing_strips_capacitance,
    strip_points,
)
from msvalidate.dielectric.charges.faces import slab_faces
from msvalidate.dielectric.charges.patches import patch_charges, plate
from msvalidate.problem import ProblemError

FLAT = [[0.0, 0.0], [1.0, 0.0]]
ABOVE = [[0.0, 1.0], [1.0, 1.0]]
PAIR = electrodes_of_chains(FLAT, ABOVE)
BENT = [[0, 0], [1, 0], [1, 1], [0, 1]]

BAD = [
    ("none", electrodes_of_chains, "none; give a chain"),
    ("a single point", lambda: electrodes_of_chains([[0.0, 0.0]]),
        "shape (1, 2); give (n, 2), n above 1"),
    ("in space", lambda: electrodes_of_chains(np.zeros((3, 3))), "shape (3, 3); give (n, 2)"),
    ("NaN", lambda: electrodes_of_chains(FLAT, [[0, math.nan], [1, 1]]), "nan at index (0, 1)"),
    ("infinite", lambda: PAIR.moved(np.full((4, 2), math.inf)), "inf at index (0, 0)"),
    ("text", lambda: electrodes_of_chains("abc"), "expected numbers"),
    ("a point twice", lambda: electrodes_of_chains([[0, 0], [0, 0], [1, 0]]),
        "segment 0: length 0 m; leave it"),
    ("tiny", lambda: electrodes_of_chains([[0, 0], [1, 0], [1, 1e-12]]),
        "segment 1: length 1e-12 m"),
    ("crossing", lambda: electrodes_of_chains(FLAT, [[0.5, -1], [0.5, 1]]),
        "electrodes 0 and 1 cross or touch at segments 0 and 1 near (0.5, 0) m; leave a gap"),
    ("touching", lambda: electrodes_of_chains(FLAT, [[0.5, 0], [0.5, 1]]),
        "electrodes 0 and 1 cross or touch"),
    ("touching at ends", lambda: electrodes_of_chains(FLAT, [[1, 0], [2, 1]]),
        "electrodes 0 and 1 cross or"),
    ("zero gap", lambda: facing_strips(1.0, 0.0, 4), "gap: 0.0 m; it must be above zero"),
    ("on each other", lambda: electrodes_of_chains(FLAT, [[0.2, 0], [0.8, 0]]),
        "electrodes 0 and 1 cross or"),
    ("next to nothing apart", lambda: electrodes_of_chains(FLAT, [[0, 1e-10], [1, 1e-10]]),
        "electrodes 0 and 1 cross or touch at segments 0 and 1 near (0.5, 0) m"),
    ("crossing itself", lambda: electrodes_of_chains([[0, 0], [1, 0], [1, 1], [0.5, -1]]),
        "electrode 0 crosses or touches itself at segments 0 and 2"),
    ("folded back", lambda: electrodes_of_chains([[0, 0], [1, 0], [0.5, 0]]),
        "electrode 0 crosses or touches itself at segments 0 and 1"),
    ("the same segment twice", lambda: Electrodes(FLAT, [[0, 1], [1, 0]], [0, 0]),
        "electrode 0 crosses or touches itself at segments 0 and 1"),
    ("closed without sharing a point", lambda: electrodes_of_chains([*BENT, [0, 0]]),
        "electrode 0 crosses or touches itself at segments 0 and 3"),
    ("points of segments", lambda: Electrodes(FLAT, [[0, 2]], [0]), "0 to 2; there are 2"),
    ("negative points", lambda: Electrodes(FLAT, [[-1, 0]], [0]), "-1 to 0; there are 2"),
    ("halves", lambda: Electrodes(FLAT, [[0, 0.5]], [0]), "segments: [[0, 0.5]]; give whole"),
    ("no segments", lambda: Electrodes(FLAT, np.zeros((0, 2)), []), "shape (0, 2); give (m, 2)"),
    ("triangles", lambda: Electrodes(FLAT, [[0, 1, 0]], [0]), "shape (1, 3); give (m, 2)"),
    ("too few names", lambda: Electrodes(FLAT, [[0, 1]], [0, 1]), "shape (2,); give (1,)"),
    ("names left out", lambda: Electrodes(FLAT, [[0, 1]], [10**9]), "numbers are left out"),
    ("grading", lambda: strip_points(1.0, 0.0, 4, grading="log"),
        "grading: 'log'; choose uniform or"),
    ("fewer points moved", lambda: PAIR.moved(ABOVE), "shape (2, 2); give (4, 2), as there were"),
    ("more points moved", lambda: PAIR.moved(np.eye(5, 2)), "shape (5, 2); give (4, 2), as there"),
    ("height of a strip", lambda: strip_points(1.0, math.nan, 4),
        "height: nan; every value must be"),
    ("centre of a strip", lambda: strip_points(1.0, 0.0, 4, centre="a"),
        "centre: expected numbers"),
    ("too many", lambda: strip_points(1.0, 0.0, 10**9),
        "segments: 1e+09 segments, and the most is"),
    ("segments of a strip", lambda: strip_points(1.0, 0.0, 0), "segments: 0; give a whole number"),
    ("one electrode", lambda: Moments(electrodes_of_chains(FLAT)),
        "one alone holds no charge in the plane"),
    ("not electrodes", lambda: Moments(FLAT), "electrodes: [[0.0, 0.0], [1.0, 0.0]]; give an"),
    ("permittivity", lambda: Moments(PAIR, permittivity=0.0), "permittivity: 0.0 F/m; it must"),
    ("weighting", lambda: Moments(PAIR, weighting="nodal"), "weighting: 'nodal'; choose"),
    ("too few voltages", lambda: Moments(PAIR).charges((1.0,)), "shape (1,); give (2,), one an"),
    ("voltages", lambda: Moments(PAIR).charges((1.0, math.nan)), "voltages: nan at index 1"),
    ("places", lambda: Moments(PAIR).charges((1, 0)).field([0.0, 1.0]), "shape (2,); give (n, 2)"),
    ("one to charge", lambda: capacitance(electrodes_of_chains(FLAT)),
        "electrodes: 1; a capacitance is of two"),
    ("too narrow", lambda: facing_strips_capacitance(0.01), "width over gap: 0.01; give 0.1 to 50"),
    ("too wide", lambda: facing_strips_capacitance(51.0), "width over gap: 51; give 0.1 to 50"),
]  # fmt: skip


@pytest.mark.parametrize(("make", "words"), [case[1:] for case in BAD], ids=[c[0] for c in BAD])
def test_bad_input_is_told_in_one_line(make, words):
    with pytest.raises(ProblemError) as told:
        make()
    assert words in str(told.value)
    assert "\n" not in str(told.value)
    assert len(str(told.value)) < 300


@pytest.mark.parametrize(
    "make",
    [
        Moments,
        ReportModel,
        lambda _: SlabInAir(slab_faces(2.0, 1.0, 4)),
        lambda _: patch_charges(plate((1.0, 1.0), 2), (1.0,)),
    ],
)
def test_a_matrix_beyond_memory_is_refused(make, monkeypatch):
    monkeypatch.setattr(checks, "MOST_DENSE", 3)
    with pytest.raises(
        ProblemError,
        match=r"(segments|patches): \d+ of them, whose matrix takes .* GB; take at most 3",
    ):
        make(facing_strips(1.0, 1.0, 2))


def test_electrodes_know_their_segments():
    pair = facing_strips(2.0, 0.5, 4, grading="uniform")
    assert pair.count == 2
    assert pair.extent == 2.0
    np.testing.assert_allclose(pair.length, 0.5)
    np.testing.assert_allclose(pair.middle[4], (-0.75, 0.0))
    np.testing.assert_array_equal(pair.electrode, [0] * 4 + [1] * 4)
    assert not pair.points.flags.writeable
    up = np.array([0.0, 1.0])
    np.testing.assert_allclose(pair.moved(pair.points + up).middle, pair.middle + up)


def test_cosine_grading_spreads_an_isolated_charge_evenly():
    """Between x and the edge of a strip lies acos(x/a)/π of its charge."""
    x = strip_points(2.0, 0.0, 12)[:, 0]
    np.testing.assert_allclose(np.arccos(x) / np.pi, np.arange(12, -1, -1) / 12, atol=1e-12)


def test_closed_and_branched_electrodes_share_points():
    for points, segments in (
        (BENT, [[0, 1], [1, 2], [2, 3], [3, 0]]),
        ([*BENT, [2, 0]], [[0, 1], [1, 2], [1, 4]]),
    ):
        electrodes = Electrodes(points, segments, [0] * len(segments))
        assert electrodes.count == 1
        assert electrodes.length.min() > 0


@pytest.mark.parametrize("angle", [1e-2, 1e-5])
def test_a_sharp_tip_of_fine_segments_is_not_contact(angle):
    """Neighbours' neighbours beside a tip are closer than they are long, and do not touch."""
    side = np.column_stack([np.linspace(1, 0, 50) ** 2, np.zeros(50)])
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    back = side[::-1] @ turn
    electrodes = electrodes_of_chains(np.concatenate([side, back[1:]]))
    far = np.linalg.norm(electrodes.points[48] - electrodes.points[50])
    assert far < electrodes.length.min()


def test_the_finest_grading_is_not_contact():
    fine = facing_strips(10.0, 1e-3, 5000)
    assert fine.length.min() < 1e-6
    assert np.array_equal(fine.moved(fine.points).points, fine.points)
