"""What is taken as an actuator, and what is refused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from msvalidate.dielectric.actuator import Actuator, fix_near_tips, slab
from msvalidate.dielectric.actuator.uniform import relaxed_thickness
from msvalidate.problem import ProblemError
from msvalidate.springs.network import internal_force, spring_network
from tests.table import table


@pytest.fixture(scope="module")
def small():
    return slab(6.0, 2.0, 2)


def refused(match, **changes):
    with pytest.raises(ProblemError, match=match) as caught:
        replace(slab(6.0, 2.0, 2), **changes)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("stretch", [0.9, 1.5])
def test_stretched_film_between_sliding_sides_rests_as_it_is(stretch):
    body = slab(4.0, 2.0, 4, prestretch=stretch, sides="sliding")
    points = body.network.points
    assert points.max(axis=0) == pytest.approx([4 * stretch, 2 * relaxed_thickness(stretch)])
    force = internal_force(body.network, points)[~body.network.fixed]
    assert force == pytest.approx(0, abs=1e-14)
    assert np.abs(internal_force(body.network, points)).max() > 0.01  # the walls bear the stretch


@table(("given", "match"), [
    ({"covered": 0.3}, r"covered: 0\.3 ends between points of 6 cells; take 2/6"),
    ({"covered": 0.05}, "covered: .* take 2/6"),
    ({"covered": 1.5}, "at most 1"),
    ({"covered": 0.0}, "above zero"),
    ({"length": 6.3}, "whole multiple"),
    ({"sides": "glued"}, "choose free or sliding"),
    ({"permittivity": -1.0}, "permittivity: -1"),
    ({"permittivity": np.nan}, "permittivity: nan"),
    ({"model": "wires"}, "model: 'wires'; choose"),
    ({"prestretch": 0.0}, "prestretch"),
    ({"model": "in_air", "permittivity_ratio": 1e18}, r"permittivity ratio: 1e\+18; above 1e\+06"),
    ({"depth": -1.0}, "depth"),
    ({"cells": 0}, "cells"),
])  # fmt: skip
def test_slab_refuses(given, match):
    with pytest.raises(ProblemError, match=match) as caught:
        slab(**{"length": 6.0, "height": 2.0, "cells": 2} | given)
    assert "\n" not in str(caught.value)


def test_electrodes_must_be_two_chains(small):
    top, bottom = small.electrodes
    refused("give two chains", electrodes=(top,))
    refused("give two chains", electrodes=None)
    refused("2 or more points", electrodes=(top[:1], bottom))
    refused("there are 21", electrodes=(np.array([19, 20, 21]), bottom))
    refused("whole numbers", electrodes=(top + 0.5, bottom))


def test_electrodes_follow_springs(small):
    top, bottom = small.electrodes
    refused(
        f"from point {top[0]} to {top[2]} it is not on the surface",
        electrodes=(top[[0, 2]], bottom),
    )


def test_electrodes_stay_on_the_surface(small):
    _, bottom = small.electrodes
    inside = np.arange(7, 14)
    assert (small.network.points[inside, 1] == 1).all()
    refused("from point 7 to 8 it is not on the surface", electrodes=(inside, bottom))
    diagonal = np.array([14, 8])
    refused("it is not on the surface", electrodes=(diagonal, bottom))
    sides = np.array([7, 14])  # up the left side: surface too
    assert Actuator(small.network, (sides, bottom)).electrodes[0].tolist() == [7, 14]


def test_electrodes_keep_apart(small):
    top, bottom = small.electrodes
    refused("electrodes 0 and 1: both cover the surface", electrodes=(bottom, bottom))
    refused("touch between segments", electrodes=(np.array([0, 7, 14]), bottom))  # meets the corner
    refused("both cover", electrodes=(top[[0, 1, 0]], bottom))


def test_a_free_body_and_a_solid_are_refused(small):
    refused("network: ", network=replace(small.network, fixed=np.zeros((21, 2), dtype=bool)))
    n = 4
    solid = spring_network(
        np.vstack([np.zeros(3), np.eye(3)]),
        [(0, 1), (0, 2), (0, 3)],
        1.0,
        fixed=np.ones((n, 3), bool),
    )
    refused("one in space", network=solid)


def test_parallel_plates_need_a_flat_held_bottom(small):
    held = np.array(small.network.fixed)
    held[3] = False
    refused(
        "flat and held",
        network=replace(small.network, fixed=held),
        model="parallel_plates",
    )


def test_arrays_are_read_only(small):
    with pytest.raises(ValueError, match="read-only"):
        small.electrodes[0][0] = 3


def test_without_tips_holds_points_near_the_edges():
    body = slab(6.0, 2.0, 4, covered=1 / 3)
    held = fix_near_tips(body, 0.5).network.fixed & ~body.network.fixed
    there = body.network.points[held.all(axis=1)]
    edges = np.array([[2.0, 2.0], [4.0, 2.0]])
    away = np.linalg.norm(there[:, None] - edges, axis=2).min(axis=1)
    assert len(there) == 8  # each edge, its neighbours left and right, and the one below
    assert away.max() == 0.5


@table(("within", "match"), [(-1.0, "0 or more"), (100.0, "every point")])
def test_without_tips_refuses(small, within, match):
    with pytest.raises(ProblemError, match=match):
        fix_near_tips(small, within)
    with pytest.raises(ProblemError, match="actuator: None; give an Actuator"):
        fix_near_tips(None, 1.0)


def test_electrodes_lie_where_all_points_are(small):
    with pytest.raises(ProblemError, match=r"position: shape \(3, 2\); give \(21, 2\)"):
        small.lying(np.zeros((3, 2)))
