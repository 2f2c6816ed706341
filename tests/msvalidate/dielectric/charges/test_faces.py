"""Outlines of bodies with electrodes, and what is refused of them."""

from __future__ import annotations

import numpy as np
import pytest

from msvalidate.dielectric.charges.faces import Faces, faces_of, slab_faces
from msvalidate.problem import ProblemError
from tests.table import stored_rows, table

SQUARE = np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]])
COVERED = [1, -1, 0, -1]


@pytest.mark.parametrize("covered", [1.0, 0.4])
@pytest.mark.parametrize("grading", ["uniform", "cosine"])
def test_slab_is_covered_as_asked(covered, grading):
    faces = slab_faces(6.0, 1.0, 40, covered=covered, grading=grading)
    length = [faces.length[faces.electrode == k].sum() for k in (0, 1, -1)]
    assert length == pytest.approx([6.0 * covered, 6.0, 2.0 + 6.0 * (1 - covered)])
    top = faces.electrode == 0
    assert faces.middle[top, 1] == pytest.approx(np.ones(top.sum()))
    assert faces.middle[faces.electrode == 1, 1] == pytest.approx(np.zeros(40))
    (x, y), (dx, dy) = faces.points.T, faces.along.T
    flux = x * dy - y * dx
    assert 0.5 * flux.sum() == pytest.approx(6.0)  # the area, by Gauss's theorem


def test_graded_segments_are_alike_where_parts_meet():
    faces = slab_faces(6.0, 1.0, 40, covered=0.4)
    before, after = faces.length, np.roll(faces.length, -1)
    meet = faces.electrode != np.roll(faces.electrode, -1)
    # Numbers of segments are rounded: by a tenth or so of the few on the short side of a slab.
    assert (np.abs(np.log(before / after)[meet]) < 0.35).all()


def test_chains_of_a_network_become_faces():
    points = np.array([[0.0, 0], [1, 0], [2, 0], [0, 1], [1, 1], [2, 1], [1, 0.5]])
    faces = faces_of(points, [0, 1, 2, 5, 4, 3], ([3, 4], [2, 1, 0]))
    assert faces.points == pytest.approx(points[[0, 1, 2, 5, 4, 3]])
    assert faces.electrode.tolist() == [1, 1, -1, -1, 0, -1]


@table(
    ("outline", "electrodes", "said"),
    [
        *stored_rows("chains"),
        ([0, 1, 2, 5, 4, 3], None, "electrodes: None; give a tuple of chains"),
    ],
)
def test_bad_chains_are_refused(outline, electrodes, said):
    points = np.array([[0.0, 0], [1, 0], [2, 0], [0, 1], [1, 1], [2, 1], [1, 0.5]])
    with pytest.raises(ProblemError, match=said):
        faces_of(points, outline, electrodes and tuple(electrodes))


@table(
    ("points", "electrode", "said"),
    [
        (SQUARE[::-1], COVERED, "runs clockwise"),
        (SQUARE[[0, 2, 1, 3]], COVERED, "crosses or touches itself"),
        (np.vstack([SQUARE, SQUARE[:1]]), [1, -1, 0, -1, -1], "segment 4 of the faces: length 0"),
        (SQUARE, [1, 0, -1, -1], "electrodes 1 and 0 touch between segments 0 and 1"),
        (SQUARE, [0, -1, 0, -1], "give at least 0 and 1"),
        (SQUARE, [0, -1, 2, -1], "leave out none"),
        (SQUARE, [-2, -1, 0, 1], "leave out none"),
        (SQUARE, [0, -1, 1], r"electrode: shape \(3,\); give \(4,\)"),
        (SQUARE[:2], [0, 1], r"shape \(2, 2\); give \(n, 2\), n above 2"),
        (SQUARE * np.nan, COVERED, "every value must be finite"),
    ],
)
def test_bad_outlines_are_refused(points, electrode, said):
    with pytest.raises(ProblemError, match=said):
        Faces(points, electrode)


def test_faces_move_with_as_many_points():
    with pytest.raises(ProblemError, match=r"points of faces: shape \(3, 2\); give \(4, 2\)"):
        Faces(SQUARE, COVERED).moved(SQUARE[:3])


@table("covered", [0.0, -0.1, 1.1, np.nan])
def test_bad_cover_is_refused(covered):
    with pytest.raises(ProblemError, match="covered"):
        slab_faces(6.0, 1.0, 40, covered=covered)
