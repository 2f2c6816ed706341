"""The surface of a network, found from its springs."""

from __future__ import annotations

import numpy as np
import pytest

from msvalidate.dielectric.actuator.device import outline
from msvalidate.problem import Box, ProblemError
from msvalidate.springs.lattice import square
from msvalidate.springs.network import spring_network


def filled(columns, rows):
    lattice = square(Box((float(columns), float(rows))), (columns, rows))
    return spring_network(lattice.points, lattice.springs, 1.0)


def area(points):
    x, y = points.T
    return 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))


@pytest.mark.parametrize(("columns", "rows"), [(1, 1), (4, 1), (5, 3)])
def test_outline_of_a_box(columns, rows):
    network = filled(columns, rows)
    around = outline(network)
    assert len(around) == len(set(around.tolist())) == 2 * (columns + rows)
    assert area(network.points[around]) == pytest.approx(columns * rows)  # counter-clockwise


def test_numbering_does_not_matter():
    network = filled(4, 2)
    order = np.random.default_rng(0).permutation(len(network.points))
    place = np.argsort(order)
    mixed = spring_network(network.points[order], place[network.springs], 1.0)
    assert {*order[outline(mixed)].tolist()} == {*outline(network).tolist()}


def test_networks_without_one_outline_are_refused():
    apart = np.array([[0.0, 0], [1, 0], [0, 1], [5, 0], [6, 0], [5, 1]])
    pairs = [[0, 1], [1, 2], [0, 2], [3, 4], [4, 5], [3, 5]]
    with pytest.raises(ProblemError, match="no body in one part"):
        outline(spring_network(apart, pairs, 1.0))
    star = np.array([[0.0, 0], [2, 0], [1, 2], [0, 1.5], [2, 1.5], [1, -0.5]])
    crossing = [[0, 1], [1, 2], [0, 2], [3, 4], [4, 5], [3, 5]]
    with pytest.raises(ProblemError, match=r"springs cross at \(.* on the surface"):
        outline(spring_network(star, crossing, 1.0))
