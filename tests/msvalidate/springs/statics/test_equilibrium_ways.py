"""Nonlinear equilibria at rest inside out, and those that are reached the second way."""

import numpy as np
import pytest

from msvalidate.problem import SolverError
from msvalidate.springs.network import spring_network
from msvalidate.springs.statics import equilibrium as module
from msvalidate.springs.statics.equilibrium import equilibrium

STIFFNESS, TIGHT = 5.0, 0.8


def rope():
    """Two springs in line, 0.2 tight, pulled across at their middle; nothing else holds it."""
    return spring_network(
        0.37 * np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]]),
        [[0, 1], [1, 2]],
        STIFFNESS,
        rest_length=TIGHT * 0.37,
        fixed=np.array([[True, True], [False, False], [True, True]]),
        force=[[0.0, 0.0], [0.0, 0.3], [0.0, 0.0]],
    )


def pull(y):
    """Force (N) that holds the rope's middle y (m) to the side: 2 k (1 - L0/L) y."""
    return 2 * STIFFNESS * (1 - TIGHT * 0.37 / np.hypot(0.37, y)) * y


def test_a_rest_inside_out_is_refused_unless_it_is_asked_for():
    # A triangle on a held side of 0.37 m: its apex rests as well mirrored to the other side.
    corners = 0.37 * np.array([[0.0, 0.0], [1.0, 0.0], [0.4, 0.7]])
    held = np.array([[True, True], [True, True], [False, False]])
    network = spring_network(corners, [[0, 1], [1, 2], [0, 2]], STIFFNESS, fixed=held)
    over = np.array([[0.0, 0.0], [0.0, 0.0], [0.0, -2 * corners[2, 1]]])
    with pytest.raises(SolverError, match="nonlinear equilibrium: "):
        equilibrium(network, "nonlinear", start=over)
    found = equilibrium(network, "nonlinear", start=over, allow_folded=True)
    assert found.folded == 1
    np.testing.assert_allclose(found.displacement, over, atol=1e-12)
    assert not found.displacement.flags.writeable
    assert equilibrium(network, "nonlinear").folded == 0


@pytest.mark.parametrize("first", ["refused", "stuck half way"])
def test_where_the_first_way_ends_rest_lengths_are_raised_too(monkeypatch, first):
    follow, ways = module.follow_path, []

    def ends(way, solver):
        ways.append(way)
        if len(ways) > 1:
            return follow(way, solver)
        if first == "refused":
            raise SolverError("no way")
        found = follow(way, solver)
        found.reached = 0.5
        return found

    monkeypatch.setattr(module, "follow_path", ends)
    assert pull(equilibrium(rope(), "nonlinear").position[1, 1]) == pytest.approx(0.3, rel=1e-12)
    assert len(ways) == 2
