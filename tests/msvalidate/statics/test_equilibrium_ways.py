"""Nonlinear equilibria at rest inside out, and those that are reached the second way."""

import numpy as np
import pytest

from msvalidate.network import spring_network
from msvalidate.problem import SolverError
from msvalidate.statics import equilibrium as module
from msvalidate.statics.equilibrium import equilibrium
from tests.table import table

STIFFNESS, TIGHT = 5.0, 0.8


def rope():
    """Two springs in line, 0.2 tight, pulled across at their middle; nothing else holds it."""
    return spring_network(
        0.37 * np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]]),
        [[0, 1], [1, 2]],
        STIFFNESS,
        rest_length=TIGHT * 0.37,
        held=np.array([[True, True], [False, False], [True, True]]),
        force=[[0.0, 0.0], [0.0, 0.3], [0.0, 0.0]],
    )


def pull(y):
    """Force (N) that holds the rope's middle y (m) to the side: 2 k (1 - L0/L) y."""
    return 2 * STIFFNESS * (1 - TIGHT * 0.37 / np.hypot(0.37, y)) * y


def test_a_rest_inside_out_is_refused_unless_it_is_asked_for():
    # A triangle on a held side of 0.37 m: its apex rests as well mirrored to the other side.
    corners = 0.37 * np.array([[0.0, 0.0], [1.0, 0.0], [0.4, 0.7]])
    held = np.array([[True, True], [True, True], [False, False]])
    network = spring_network(corners, [[0, 1], [1, 2], [0, 2]], STIFFNESS, held=held)
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


def test_a_way_that_leads_to_the_end_is_not_gone_twice(monkeypatch):
    follow, ways = module.follow_path, []
    monkeypatch.setattr(module, "follow_path", lambda *given: ways.append(given) or follow(*given))
    assert pull(equilibrium(rope(), "nonlinear").position[1, 1]) == pytest.approx(0.3, rel=1e-12)
    assert len(ways) == 1


def test_reactions_balance_loads_where_stiff_meets_soft():
    """A beam of 100 cells, its outer half softer by 1e8: what the last correction takes counts."""
    n = 100
    places = np.stack(np.meshgrid(np.arange(n + 1.0), [0.0, 1.0], indexing="ij"), axis=-1)
    low = 2 * np.arange(n)
    ways = ((0, 2), (1, 3), (0, 3), (1, 2), (2, 3))
    pairs = np.concatenate([np.column_stack([low + a, low + b]) for a, b in ways])
    stiffness = np.where(np.arange(len(pairs)) % n > n / 2, 1e-5, 1e3)
    held, force = np.zeros((2 * n + 2, 2), dtype=bool), np.zeros((2 * n + 2, 2))
    held[:2], force[-2:, 1] = True, -0.3
    beam = spring_network(0.37 * places.reshape(-1, 2), pairs, stiffness, held=held, force=force)
    reaction = equilibrium(beam).reaction
    # An eps of the largest reaction, 60 N, is 1e-14 N.
    np.testing.assert_allclose(reaction.sum(axis=0), [0.0, 0.6], rtol=0, atol=1e-12)


@table("geometry", ["linear", "nonlinear"])
@table("stiffness", [1e30, 1e200, 1e300, 1e307])
def test_a_displacement_that_positions_have_no_digits_for_is_right_or_refused(stiffness, geometry):
    # a square of 0.37 m with both diagonals moves by 0.00625/k and -0.00875/k under 0.01 N
    points = 0.37 * np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]])
    springs = [[0, 1], [0, 2], [1, 3], [2, 3], [0, 3], [1, 2]]
    force = np.zeros((4, 2))
    force[3, 1] = -0.01
    held = [[True, True], [False, True], [False, False], [False, False]]
    network = spring_network(points, springs, np.full(6, stiffness), held=held, force=force)
    move = equilibrium(network, geometry).displacement[3] * stiffness
    assert move == pytest.approx([0.00625, -0.00875], rel=1e-14)


def test_what_stiffnesses_far_apart_hide_is_no_matter_of_the_load():
    # A beam of 400 cells, its outer half stiffer by 1e16: soft cells carry a lever of stiff ones.
    n = 400
    places = np.stack(np.meshgrid(np.arange(n + 1.0), [0.0, 1.0], indexing="ij"), axis=-1)
    low = 2 * np.arange(n)
    ways = ((0, 2), (1, 3), (0, 3), (1, 2), (2, 3))
    pairs = np.concatenate([np.column_stack([low + a, low + b]) for a, b in ways])
    stiffness = np.where(pairs.min(axis=1) > n, 1e19, 1e3)
    held, force = np.zeros((2 * n + 2, 2), dtype=bool), np.zeros((2 * n + 2, 2))
    held[:2], force[-2:, 1] = True, -1e-9
    beam = spring_network(0.37 * places.reshape(-1, 2), pairs, stiffness, held=held, force=force)
    with pytest.raises(SolverError, match="closer together") as refused:
        equilibrium(beam, "nonlinear")
    assert "load or stiffen" not in str(refused.value)
