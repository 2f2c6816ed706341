"""Which solver is taken, that all give one answer, and that both notice what does not stand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from msvalidate.linear_algebra import choice
from msvalidate.linear_algebra.factor import factorise
from msvalidate.problem import (
    Box,
    Isotropic,
    Problem,
    ProblemError,
    Region,
    SolverError,
    Support,
    Traction,
)
from msvalidate.springs.bodies.lattice_network import lattice_network
from msvalidate.springs.lattice import fill, patterns
from msvalidate.springs.network import configuration_at, inverse, multigrid, spring_network, tangent
from msvalidate.springs.network.inverse import SOLVERS, Solver, elimination_order
from msvalidate.springs.statics.equilibrium import equilibrium

CUBE = (1.0, 1.0, 1.0)


def block(sides, cells, load=(0.0, 0.0, -1e-3), supports=None):
    box, d = Box(sides), len(sides)
    plane = {"state": "plane_stress", "thickness": 0.2}
    material = Isotropic(1.0, 1 / 3, **plane) if d == 2 else Isotropic(1.0, 1 / 4, "solid")
    given = Problem(
        box,
        material,
        supports or (Support(box.side("left"), (0.0,) * d),),
        (Traction(box.side("right"), load[-d:]),),
    )
    pattern = patterns.square() if d == 2 else patterns.cubic18()
    return lattice_network(given, fill(pattern, box, cells))


def stiff_inside(network, times):
    """Springs near the middle stiffer by so many times."""
    middle = network.points[network.springs].mean(axis=1) - network.points.mean(axis=0)
    near = (np.abs(middle) < np.ptp(network.points, axis=0) / 4).all(axis=1)
    return network.scaled(np.where(near, times, 1.0))


BODIES = {
    "cube": lambda: block(CUBE, (5, 5, 5)),
    "plate": lambda: block((1.0, 1.0), (14, 14)),
    "far": lambda: replace(block(CUBE, (4, 4, 4)), points=block(CUBE, (4, 4, 4)).points + 5e5),
    "bar": lambda: block((100.0, 1.0, 1.0), (100, 1, 1)),
    "stiff inside": lambda: stiff_inside(block(CUBE, (6, 6, 6)), 1e6),
    "soft inside": lambda: stiff_inside(block(CUBE, (6, 6, 6)), 1e-6),
    "prescribed": lambda: block(CUBE, (5, 5, 5), supports=(Support(Region((0.0, None, None)), (0.0,
        0.0, 0.0)), Support(Region((1.0, None, None)), (1e-3, 0.0, None))), load=(0.0, 0.0, 0.0)),
}  # fmt: skip


@pytest.mark.parametrize("geometry", ["linear", "nonlinear"])
@pytest.mark.parametrize("name", BODIES)
def test_solvers_agree_to_what_they_state(name, geometry):
    network = BODIES[name]()
    if name == "bar":
        network = replace(network, force=1e-3 * network.force)
    one, two = (equilibrium(network, geometry, solver=way) for way in SOLVERS[1:])
    assert (one.solver.name, two.solver.name) == SOLVERS[1:]
    largest = np.abs(one.displacement).max()
    apart = np.abs(one.displacement - two.displacement).max() / largest
    assert max(one.error, two.error) < 1e-12
    assert apart <= one.error + two.error
    held = network.fixed
    met = np.abs(one.reaction).max()
    np.testing.assert_allclose(two.reaction[held], one.reaction[held], rtol=0, atol=1e-9 * met)


def test_a_factor_of_small_and_slender_bodies_multigrid_of_others():
    assert Solver(BODIES["cube"]()).choice.name == "direct"
    assert Solver(block((100.0, 1.0, 1.0), (400, 4, 4))).choice.name == "direct"
    assert Solver(block(CUBE, (16, 16, 16))).choice.name == "multigrid"
    assert Solver(BODIES["cube"](), "multigrid").choice == ("multigrid", "asked for")
    with pytest.raises(ProblemError, match=r"solver: 'lu'.*direct.*multigrid"):
        equilibrium(BODIES["plate"](), solver="lu")


def test_components_are_in_the_order_of_their_points():
    network = BODIES["prescribed"]()
    order = elimination_order(network)
    free = np.flatnonzero(~network.fixed.ravel())
    assert np.array_equal(np.sort(order), np.arange(len(free)))
    points = free[order] // 3
    assert np.count_nonzero(np.diff(points)) == len(np.unique(points)) - 1


@pytest.fixture
def by_multigrid(monkeypatch):
    """Every body counts as too large for a factor, even in need."""
    monkeypatch.setattr(choice, "MOST_PRODUCTS", 0)
    monkeypatch.setattr(choice, "MOST_IN_NEED", 0)


def hinged_cubes(cells):
    """A held cube and one that hangs on it by an edge: it may turn about that."""
    network = block(CUBE, (cells,) * 3)
    n, across = len(network.points), network.points + np.array([1.0, 0.0, 1.0])
    same = {tuple(p): i for i, p in enumerate(np.round(network.points, 9).tolist())}
    number = np.array([same.get(tuple(p), -1) for p in np.round(across, 9).tolist()])
    new = number < 0
    number[new] = n + np.arange(np.count_nonzero(new))
    points = np.concatenate([network.points, across[new]])
    held = np.zeros(points.shape, dtype=bool)
    held[:n] = network.fixed
    return spring_network(
        points,
        np.concatenate([network.springs, number[network.springs]]),
        np.tile(network.stiffness, 2),
        fixed=held,
        force=np.where(points[:, :1] > 1.9, [0.0, 0.0, -1e-4], 0.0),
    )


@pytest.mark.parametrize("geometry", ["linear", "nonlinear"])
@pytest.mark.parametrize("cells", [3, 8])
@pytest.mark.usefixtures("by_multigrid")
def test_multigrid_names_a_mechanism(cells, geometry):
    with pytest.raises(SolverError, match=r"mechanism: nothing resists point .* moving along"):
        equilibrium(hinged_cubes(cells), geometry)


@pytest.mark.usefixtures("by_multigrid")
def test_multigrid_names_a_loose_part_beside_one_that_is_much_stiffer():
    """The hinge is between soft cubes, beside which the stiffest spring meets 1e6 times as much."""
    network = hinged_cubes(4)
    k = network.stiffness.copy()
    k[:10] *= 1e6
    with pytest.raises(SolverError, match="mechanism"):
        equilibrium(replace(network, stiffness=k))


@pytest.mark.usefixtures("by_multigrid")
@pytest.mark.parametrize(("strain", "stable"), [(1e-5, True), (1e-4, True), (3e-3, False)])
def test_multigrid_tells_what_prestress_makes_unstable(strain, stable):
    """A slender column of squeezed springs, which buckles at some 5e-4: as its pivots have it."""
    network = block((20.0, 1.0, 1.0), (40, 2, 2), load=(0.0, 0.0, -1e-9))
    squeezed = replace(network, rest_length=(1 + strain) * network.rest_length)
    x = squeezed.points
    free = np.flatnonzero(~squeezed.fixed.ravel())
    pivots = factorise(tangent(squeezed, x)[free][:, free], elimination_order(squeezed))
    assert (pivots.negative == 0) is stable
    assert (Solver(squeezed).regular(configuration_at(squeezed, x)).negative == 0) is stable
    if not stable:
        with pytest.raises(SolverError, match="unstable"):
            equilibrium(squeezed)


def test_what_multigrid_cannot_do_is_left_to_a_factor(monkeypatch):
    """No cycle is allowed: the same answer, and the reason told; where none fits, its size is."""
    monkeypatch.setattr(choice, "MOST_PRODUCTS", 0)
    network = BODIES["cube"]()
    expected = equilibrium(network, solver="direct").displacement
    real = multigrid.conjugate_gradients
    monkeypatch.setattr(
        multigrid, "conjugate_gradients", lambda *args, **rest: real(*args, **{**rest, "most": 2})
    )
    with monkeypatch.context() as patch:  # a factor tells: no long search by multigrid before it
        patch.setattr(inverse, "softest_motion", None)
        found = equilibrium(network)
    assert found.solver.name == "direct"
    assert found.solver.reason.startswith("multigrid gave up: ")
    np.testing.assert_array_equal(found.displacement, expected)
    with pytest.raises(SolverError, match=r"^multigrid: .*; take solver 'direct'$"):
        equilibrium(network, solver="multigrid")
    monkeypatch.setattr(choice, "MOST_IN_NEED", 0)
    with pytest.raises(SolverError, match=r"a factor would take .* GB: take solver 'direct' where"):
        equilibrium(network)


@pytest.mark.parametrize("where", ["springs.statics.tangents", "springs.network.stability"])
def test_where_multigrid_cannot_tell_stability_under_load_a_factor_does(where, monkeypatch):
    """The loaded tangent's softest motion may be rounding where that at the start is not."""
    monkeypatch.setattr(choice, "MOST_PRODUCTS", 0)
    monkeypatch.setattr(f"msvalidate.{where}.is_certain", lambda _: False)
    monkeypatch.setattr("msvalidate.springs.network.stability.is_certain", lambda _: False)
    network = BODIES["cube"]()
    assert equilibrium(network, "nonlinear").solver.name == "direct"
    with pytest.raises(SolverError, match=r"^multigrid: whether .*; take solver 'direct'$"):
        equilibrium(network, "nonlinear", solver="multigrid")


def test_an_answer_does_not_hang_on_the_size_where_multigrid_begins(monkeypatch):
    """A shallow arch that snaps through: a factor goes on past its limit point, multigrid stops."""
    points = np.array([[0.0, 0.0], [1.0, 0.1], [2.0, 0.0]])
    held = np.array([[True, True], [False, False], [True, True]])
    force = np.array([[0.0, 0.0], [0.0, -2e-3], [0.0, 0.0]])
    arch = spring_network(points, [[0, 1], [1, 2]], 1.0, fixed=held, force=force)
    expected = equilibrium(arch, "nonlinear")
    assert expected.passed_limit is not None
    monkeypatch.setattr(choice, "MOST_PRODUCTS", 0)
    found = equilibrium(arch, "nonlinear")
    assert found.passed_limit == expected.passed_limit
    np.testing.assert_allclose(found.displacement, expected.displacement, rtol=1e-12)
