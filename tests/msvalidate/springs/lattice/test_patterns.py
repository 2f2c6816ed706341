"""Patterns: what repeats, and what every lattice is known by."""

from __future__ import annotations

import numpy as np
import pytest

from msvalidate.problem import Box, Isotropic, Problem, Support, Traction
from msvalidate.springs.bodies.lattice_network import lattice_network
from msvalidate.springs.constants.homogenise import homogenise
from msvalidate.springs.lattice import Pattern, fill, patterns, repeat_cell
from msvalidate.springs.lattice.pattern import SpringFormulas, pattern_by_shells
from msvalidate.springs.statics.equilibrium import equilibrium
from tests.table import refused, table

LATTICES = patterns.all_patterns()
every = pytest.mark.parametrize("name", LATTICES)
# Neighbours a point in shells, from any textbook on crystals.
NEIGHBOURS = {
    "square": [4, 4],
    "square4": [4],
    "triangular": [6],
    "honeycomb": [3, 6],
    "cubic6": [6],
    "cubic18": [6, 12],
    "cubic26": [6, 12, 8],
    "bcc": [8, 6],
    "fcc": [12, 6],
}


def brute_force(pattern, reach=3):
    """Vectors between all points and images, sorted; slow and plain."""
    size = np.array(pattern.size)
    steps = np.indices((2 * reach + 1,) * pattern.dim).reshape(pattern.dim, -1).T - reach
    return [
        pattern.points[j] + step * size - pattern.points[i]
        for i in range(len(pattern.points))
        for j in range(len(pattern.points))
        for step in steps
    ]


def neighbours(pattern):
    """Number (n, kinds) of springs of each kind at each point."""
    found = np.zeros((len(pattern.points), pattern.kinds), dtype=int)
    np.add.at(found, (pattern.springs, pattern.kind[:, None]), 1)
    return found


@pytest.mark.parametrize("name", NEIGHBOURS)
def test_every_point_has_the_neighbours_of_its_lattice(name):
    found = neighbours(LATTICES[name]())
    np.testing.assert_array_equal(found, np.tile(NEIGHBOURS[name], (len(found), 1)))


@every
def test_springs_are_all_pairs_at_their_distances_each_once(name):
    pattern = LATTICES[name]()
    length = np.linalg.norm(pattern.vectors, axis=1)
    for kind in range(pattern.kinds):
        ours = length[pattern.kind == kind]
        np.testing.assert_allclose(ours, ours[0], rtol=1e-14)
        apart = np.linalg.norm(brute_force(pattern), axis=1)
        assert 2 * len(ours) == (np.abs(apart - ours[0]) < 1e-9).sum()
    both = np.concatenate(
        [
            np.column_stack([pattern.springs, pattern.image]),
            np.column_stack([pattern.springs[:, ::-1], -pattern.image]),
        ]
    )
    assert len(np.unique(both, axis=0)) == len(both)


@every
@pytest.mark.parametrize("times", [1, 2, 3])
def test_a_repeated_cell_is_the_same_lattice(name, times):
    pattern = LATTICES[name]()
    larger = repeat_cell(pattern, times)
    cells = times**pattern.dim
    assert len(larger.points) == cells * len(pattern.points)
    np.testing.assert_allclose(larger.size, times * np.array(pattern.size))

    # The same vectors as often, and each joins points that are where it says.
    def counted(vectors):
        rounded = np.round(vectors, 9) + 0.0
        return np.unique(rounded, axis=0, return_counts=True)

    once, many = counted(pattern.vectors), counted(larger.vectors)
    np.testing.assert_allclose(many[0], once[0], atol=1e-9)
    np.testing.assert_array_equal(many[1], cells * once[1])
    assert (larger.points < larger.size).all()
    assert larger.volume.sum() == pytest.approx(np.prod(larger.size))
    assert (
        np.bincount(larger.springs.ravel()).tolist()
        == np.tile(np.bincount(pattern.springs.ravel()), cells).tolist()
    )


def kagome() -> Pattern:
    """Kagome lattice, spacing its nearest distance: 4 nearest k1, 4 next k2; isotropic."""

    def tensor(k):
        both = np.sqrt(3) / 8 * (k[0] + 3 * k[1])
        return patterns.cubic_tensor(2, 3 * both, both)

    half, row = 0.5, np.sqrt(3) / 2
    points = [(0, 0), (1, 0), (half, row), (1, 2 * row), (0, 2 * row), (1.5, 3 * row)]
    rules = {"equal": (1.0, 1.0)}
    return pattern_by_shells("kagome", (2.0, 4 * row), points, (1.0, 2 * row), rules, tensor)


def test_a_new_function_is_a_new_lattice(monkeypatch):
    monkeypatch.setattr(patterns, "kagome", kagome, raising=False)
    assert patterns.all_patterns()["kagome"] is kagome
    monkeypatch.setitem(LATTICES, "kagome", kagome)
    test_springs_are_all_pairs_at_their_distances_each_once("kagome")
    test_a_repeated_cell_is_the_same_lattice("kagome", 2)
    made = kagome()
    np.testing.assert_array_equal(neighbours(made), np.full((6, 2), 4))
    for k in ((1.0, 1.0), (0.3, 2.0)):
        exact = made.tensor(k)
        np.testing.assert_allclose(homogenise(made, k).tensor, exact, atol=1e-13 * exact.max())
    # A box of it stands under a pull as any other lattice's does.
    box = Box((0.74, 0.74 * np.sqrt(3)))
    problem = Problem(
        box,
        Isotropic(E=1.0, nu=1 / 3),
        (Support(box.side("left"), (0.0, None)), Support(box.side("bottom"), (None, 0.0))),
        (Traction(box.side("right"), (1e-3, 0.0)),),
    )
    network = lattice_network(problem, fill(made, box, (4, 4)), (1.0, 1.0))
    assert equilibrium(network).error <= 1e-9


def pattern(**change):
    parts = {
        "name": "row",
        "size": (1.0, 1.0),
        "points": np.zeros((1, 2)),
        "springs": np.array([[0, 0]]),
        "image": np.array([[1, 0]]),
        "kind": np.array([0]),
        "rules": {"one": (1.0,)},
    }
    return Pattern(**(parts | change))


@table(("change", "message"), [
    ({"size": (1.0, 0.0)}, "pattern row: cell edge"),
    ({"size": (1.0, float("nan"))}, "pattern row: cell edge: nan"),
    ({"points": np.array([[np.nan, 0.0]])}, "pattern row: points: nan"),
    ({"springs": np.array([[0, 1]])}, "springs: points 0 to 1; there are 1"),
    ({"image": np.array([[0, 0]])}, "pattern row: a spring has no length"),
    ({"image": np.array([[1, 0, 0]])}, "pattern row: image: shape (1, 3); give (1, 2)"),
    ({"kind": np.array([1]), "rules": {}}, "pattern row: kinds [1]; count from 0"),
    ({"kind": np.array([0, 0])}, "pattern row: kind: shape (2,); give (1,)"),
    ({"springs": np.zeros((0, 2), int)}, "pattern row: springs: shape (0, 2)"),
    ({"rules": {"one": (1.0, 2.0)}}, "row: spring one (1.0, 2.0); give 1, one a kind"),
    ({"rules": {"one": (-1.0,)}}, "row: spring one (-1.0,); none may be negative"),
    ({"rules": {"one": (float("inf"),)}}, "row: spring constants: inf"),
    ({"formulas": SpringFormulas((("x", ""),) * 2)}, "row: formulas of 2 kinds; give 1, or none"),
    ({"factor": np.ones(2)}, "pattern row: factor: shape (2,); give (1,)"),
    ({"factor": np.array([-1.0])}, "pattern row: a factor below 0"),
    ({"factor": np.array([np.nan])}, "pattern row: factor: nan"),
    ({"volume": np.array([2.0])}, "pattern row: volumes sum to 2, the cell has 1"),
    ({"volume": np.array([-1.0])}, "pattern row: a factor below 0 or a volume not above"),
    ({"points": np.array([[1.0, 0.0]])}, "pattern row: points reach outside the cell"),
    ({"points": np.zeros(2)}, "pattern row: points: shape (2,); give (n, 2)"),
    ({"points": np.zeros((0, 2))}, "pattern row: points: shape (0, 2); give (n, 2)"),
    ({"image": np.array([[0.5, 0]])}, "pattern row: image: "),
    ({"image": "north"}, "pattern row: image: expected numbers"),
    ({"springs": None}, "pattern row: springs: expected numbers"),
    ({"size": (1.0,)}, "pattern row: size (1.0,); give a tuple of 2 or 3 lengths"),
    ({"size": None}, "pattern row: size None; give a tuple of 2 or 3 lengths"),
    ({"rules": {}}, "pattern row: rules {}; give constants by their names"),
    ({"rules": None}, "pattern row: rules None; give constants by their names"),
    ({"tensor": "soft"}, "pattern row: tensor 'soft'; give a function or None"),
    ({"name": None}, "pattern: name None; give a word"),
    ({"springs": np.zeros((2, 2), int), "image": np.array([[1, 0], [-1, 0]]), "kind": np.zeros(2,
        int)}, "pattern row: a spring is listed twice"),
])  # fmt: skip
def test_patterns_that_do_not_fit_together_are_refused(change, message):
    with refused(message):
        pattern(**change)


def test_a_shell_without_points_is_refused():
    with refused("pattern gap: no two points are 1.2 spacings apart"):
        pattern_by_shells("gap", (1.0, 1.0), [(0, 0)], (1.2,), {"one": (1.0,)})


@table(
    ("change", "message"),
    [
        ({"distances": ()}, "pattern row: points (1, 2), distances (); give (n, 2) and lengths"),
        ({"distances": None}, "pattern row: distances: expected numbers"),
        ({"distances": (float("nan"),)}, "pattern row: distances: nan"),
        ({"distances": (-1.0,)}, "distances (-1.0,); give (n, 2) and lengths above 0"),
        ({"distances": (1e5,)}, "pairs of points, and the most is"),
        ({"points": None}, "pattern row: points: expected numbers"),
        ({"points": [(0, 0, 0)]}, "pattern row: points (1, 3)"),
        ({"size": (1.0, 0.0)}, "pattern row: cell edge: 0.0"),
        ({"size": ()}, "pattern row: size (); give a tuple"),
        ({"rules": None}, "pattern row: rules None; give constants"),
    ],
)
def test_shells_that_cannot_be_are_refused(change, message):
    parts = {"size": (1.0, 1.0), "points": [(0, 0)], "distances": (1.0,), "rules": {"a": (1.0,)}}
    with refused(message):
        pattern_by_shells("row", **(parts | change))


@pytest.mark.parametrize("times", [0, -1, 1.5, None])
def test_a_cell_is_repeated_a_whole_number_of_times(times):
    with refused("times: "):
        repeat_cell(pattern(), times)


def test_arrays_of_a_pattern_cannot_be_changed():
    for name in ("points", "springs", "image", "kind", "factor", "volume"):
        with pytest.raises(ValueError, match="read-only"):
            getattr(pattern(), name)[0] = 1
