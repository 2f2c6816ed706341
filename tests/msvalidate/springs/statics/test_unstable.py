"""What must not be returned as an equilibrium: instabilities, free motions, mechanisms."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from msvalidate.problem import Box, ProblemError, Region, SolverError, Support, Traction
from msvalidate.springs.network import internal_force, spring_network, tangent
from msvalidate.springs.statics.equilibrium import equilibrium
from tests.table import table

GEOMETRIES = ["linear", "nonlinear"]


def free_tangent(network, position):
    """Dense tangent on the free components."""
    free = ~network.fixed.ravel()
    return tangent(network, position).toarray()[np.ix_(free, free)]


def bent(lattice_body, load):
    traction = Traction(Region((4.0, None)), (load, -load))
    return lattice_body((4.0, 1.0), (16, 4), loads=(traction,))


# Stability ------------------------------------------------------------------------------------


def compressed_string(shortening):
    """Two springs in line, tight over 2 m (0.9 m at rest each), their end pushed inwards."""
    held = np.array([[True, True], [False, False], [True, True]])
    return spring_network(
        [[0, 0], [1, 0], [2, 0]],
        [[0, 1], [1, 2]],
        1.0,
        rest_length=[0.9, 0.9],
        fixed=held,
        displacement=[[0, 0], [0, 0], [-shortening, 0]],
    )


@pytest.mark.parametrize("name", ["pulled", "bent", "string"])
def test_what_nonlinear_returns_is_stable(independent, lattice_body, name):
    network = {
        "pulled": lambda: independent("s3")[0],
        "bent": lambda: bent(lattice_body, 2e-3),
        "string": lambda: compressed_string(0.1),
    }[name]()
    position = equilibrium(network, "nonlinear").position
    np.testing.assert_allclose(
        np.where(network.fixed, 0, internal_force(network, position) + network.force), 0, atol=1e-10
    )
    assert np.linalg.eigvalsh(free_tangent(network, position))[0] > 0


def test_a_column_beyond_its_euler_load_is_not_returned_straight(lattice_body):
    # Clamped-free, L = 10, height 1: π²EI/4L², with E = 1 and I = 1/12; the lattice's bending
    # stiffness with 4 cells through the height is 1 + ((2 - nu)/(1 + nu))/4² times EI.
    euler = np.pi**2 / 12 / 400 * (1 + 1.25 / 16)

    def column(load):
        squeeze = Traction(Region((10.0, None)), (-load, 0.0))
        return lattice_body((10.0, 1.0), (40, 4), loads=(squeeze,))

    straight = equilibrium(column(0.95 * euler), "nonlinear")
    assert np.abs(straight.displacement).max() < 0.03
    with pytest.raises(SolverError, match="no stable equilibrium found beyond") as caught:
        equilibrium(column(1.5 * euler), "nonlinear")
    reached = float(re.search(r"beyond ([\d.]+) of the load", str(caught.value))[1])
    # Shear and shortening, which the formula leaves out, are of the order P/EA = 0.2 %.
    assert 1.5 * reached == pytest.approx(1.0, abs=0.01)
    assert "reduce the load or stiffen the network" in str(caught.value)


def test_a_straight_string_in_compression_is_not_called_stable():
    # In line the forces are linear, so one step from the tight string lands on the slack one.
    with pytest.raises(SolverError, match="no stable equilibrium"):
        equilibrium(compressed_string(0.4), "nonlinear")


def test_a_linear_response_against_the_load_is_refused():
    # Compressed at its reference points, the string "answers" a push by moving towards it.
    string = replace(compressed_string(0.0), rest_length=np.array([1.1, 1.1]))
    pushed = replace(string, force=np.array([[0, 0], [0, 0.01], [0, 0]]))
    with pytest.raises(SolverError, match="stable"):
        equilibrium(pushed)


def test_two_held_points_pushed_into_one_are_refused():
    network = spring_network(
        [[0, 0], [1, 0]],
        [[0, 1]],
        1.0,
        fixed=np.ones((2, 2), dtype=bool),
        displacement=[[0, 0], [-1, 0]],
    )
    with pytest.raises((ProblemError, SolverError)):
        equilibrium(network, "nonlinear")


# What cannot be in equilibrium ----------------------------------------------------------------


@table("geometry", GEOMETRIES)
def test_an_unsupported_network_is_refused_by_its_motions(geometry):
    free = spring_network([[0, 0], [1, 0], [0, 1]], [[0, 1], [1, 2], [2, 0]], 1.0)
    message = "translation along x; translation along y; rotation about (0.333333, 0.333333)"
    with pytest.raises(ProblemError, match=re.escape(f"leave the body free: {message}. Hold one")):
        equilibrium(free, geometry)
    hinged = replace(free, fixed=np.array([[True, True], [False, False], [False, False]]))
    with pytest.raises(ProblemError, match=re.escape("free: rotation about (0, 0). Hold one")):
        equilibrium(hinged, geometry)


@pytest.mark.parametrize("geometry", GEOMETRIES)
@pytest.mark.parametrize("n", [1, 2, 5, 10])
def test_a_lattice_without_diagonals_is_a_mechanism_in_shear(lattice_body, geometry, n):
    box = Box((1.0, 1.0))
    sliding = (
        Support(box.side("bottom"), (None, 0.0)),
        Support(Region((0.0, 0.0)), (0.0, None)),
    )
    shear = Traction(box.side("top"), (0.01, 0.0))
    network = lattice_body((1.0, 1.0), n, supports=sliding, loads=(shear,), constants=(1.0, 0.0))
    with pytest.raises(SolverError, match=r"network is a mechanism.*add springs or supports"):
        equilibrium(network, geometry)


@table("geometry", GEOMETRIES)
def test_a_point_without_springs_is_named(geometry):
    network = spring_network(
        [[0, 0], [1, 0], [0, 1], [3, 3]],
        [[0, 1], [1, 2], [2, 0]],
        1.0,
        fixed=[[True, True], [False, True], [False, False], [False, False]],
    )
    message = r"a mechanism: nothing resists point 3 at \(3, 3\) moving along .*add springs"
    with pytest.raises(SolverError, match=message):
        equilibrium(network, geometry)
    # Held, it is in nobody's way.
    pinned = replace(network, fixed=network.fixed | [[False], [False], [False], [True]])
    assert equilibrium(pinned, geometry).residual < 1e-15  # N: the rest length √2 is rounded


def test_an_unknown_geometry_is_refused(lattice_body):
    with pytest.raises(ProblemError, match="geometry: 'exact'; choose linear or nonlinear"):
        equilibrium(bent(lattice_body, 1e-3), "exact")


@pytest.mark.parametrize(
    ("load", "remedy"),
    [
        (0.0, "beyond 0 of the prestress .*; bring rest lengths closer to the springs' lengths"),
        (1e-3, "beyond 0 of the load .*; reduce load or prestress, or take the start from a relax"),
    ],
)
def test_a_strut_that_prestress_buckles_is_told_what_to_change(load, remedy):
    # Both springs push: the middle has no stiffness across, and less than none.
    held = [[True, True], [False, False], [True, True]]
    force = [[0, 0], [load, 0], [0, 0]]
    strut = spring_network(
        [[0, 0], [0.37, 0], [0.74, 0]],
        [[0, 1], [1, 2]],
        1.0,
        rest_length=0.5,
        fixed=held,
        force=force,
    )
    with pytest.raises(SolverError, match=remedy):
        equilibrium(strut, "nonlinear")
