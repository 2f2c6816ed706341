"""Solutions with their own error: finer meshes of the same body, and errors that are as stated."""

from __future__ import annotations

from dataclasses import replace
from itertools import chain

import numpy as np
import pytest

from msvalidate.problem import (
    BodyForce,
    Box,
    Isotropic,
    Mesh,
    PointForce,
    Polygon,
    Problem,
    ProblemError,
    Region,
    SolverError,
    Support,
    Traction,
    Zone,
)
from reference_fem.converged import converge
from reference_fem.first_mesh import MOST_MIXED, first_mesh
from reference_fem.mesh.outlines import outline_discretisation
from tests.reference_fem.bodies_at_random import problems

L_SHAPE = Polygon(((0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 1.0), (1.0, 2.0), (0.0, 2.0)))
LAW = Isotropic(1e5, 0.3)


def volume(body):
    return Mesh(body.points, body.cells, body.element.shape).volume


def test_outlines_are_filled():
    for spacing in (2.0, 0.5, 0.1):
        body = outline_discretisation(L_SHAPE, spacing, np.array([[0.3, 0.0], [0.7, 0.2]]))
        assert volume(body) == pytest.approx(L_SHAPE.volume)
        for place in ((0.3, 0.0), (0.7, 0.2), (1.0, 1.0)):
            assert np.linalg.norm(body.points - place, axis=1).min() < 1e-12
    thin = Polygon(((0.0, 0.0), (9.0, 0.0), (9.0, 1e-3), (0.0, 2e-3)))
    assert volume(outline_discretisation(thin, 0.5)) == pytest.approx(thin.volume)


def test_a_plate_has_room_for_a_second_mesh():
    plate = Box((20.0, 20.0, 0.5))
    held = (Support(plate.side("left"), (0.0, 0.0, 0.0)),)
    x = first_mesh(Problem(plate, Isotropic(1e5, 0.3, "solid"), held)).points
    assert len(np.unique(x[:, 2])) == 5  # of two cells
    assert 8 * len(x) <= MOST_MIXED


def cubic(points):
    x, y = points.T
    return np.column_stack([x**3 * y, x * y**2 - y**3])


def test_a_smooth_field_is_known_as_well_as_stated():
    """Prescribed all round: u is what its body force asks for (plane stress, E = 1, nu = 0)."""
    box = Box((1.0, 0.7))

    def force(points):  # -div σ with σ = sym grad u
        x, y = points.T
        # With u = x³y and v = xy² - y³: u_xx = 6xy, v_yy = 2x - 6y, u_xy = 3x², v_xy = 2y.
        return -np.column_stack([6 * x * y + y, 2 * x - 6 * y + 1.5 * x**2])

    sides = tuple(
        Support(box.side(name), (lambda p: cubic(p)[:, 0], lambda p: cubic(p)[:, 1]))
        for name in ("left", "right", "bottom", "top")
    )
    problem = Problem(box, Isotropic(1.0, 0.0), sides, (BodyForce(force),))
    points = np.random.default_rng(2).uniform((0, 0), box.size, (50, 2))
    found = converge(problem, points, 1e-5)
    true = np.abs(found.displacement.value - cubic(points)).max() / found.displacement.value.max()
    assert found.resolved
    assert 0 < true <= found.error <= 30 * true


def test_errors_are_as_stated_on_bodies_at_random():
    """A look: `docs` have what hundreds of bodies showed."""
    covered = []
    for kind, problem, points in chain(
        *(problems(n, 1, ("box", "bent", "outline")) for n in (5, 101))
    ):
        found = converge(problem, points, 1e-12, most_nodes=1000)
        body = found.finest.body
        finer = converge(problem, points, 1e-14, most_nodes=20 * len(body.points), first=body)
        away = np.linalg.norm(found.displacement.value - finer.displacement.value, axis=1).max()
        size = np.linalg.norm(finer.displacement.value, axis=1).max()
        assert away / size <= found.error, kind
        for name in ("energy", "mean_stress"):
            mine, exact = getattr(found, name), getattr(finer, name).value
            off = np.abs(mine.value - exact).max()
            assert off <= mine.uncertainty + 1e-11 * np.abs(exact).max(), (kind, name)
        stress, known = found.stress(points)
        covered.append(np.abs(stress - finer.stress(points)[0]).max(axis=1) <= known)
    assert np.concatenate(covered).mean() >= 0.95


def test_balance_of_what_is_stated():
    problem = Problem(
        L_SHAPE, LAW, (Support(Region((None, 0.0)), (0.0, 0.0)),), (BodyForce((3.0, -2.0)),)
    )
    found = converge(problem, np.array([[0.5, 0.5], [0.9, 1.9]]), 1e-2)
    (reaction,) = found.reactions
    np.testing.assert_allclose(reaction.value, [-9.0, 6.0], rtol=1e-9)
    assert found.energy.value[0] > 0
    work = (np.array([3.0, -2.0]) * found.mean_stress.value[:2]).sum()
    assert np.isfinite(work)


def test_what_is_not_reached_is_said():
    problem = Problem(
        L_SHAPE, LAW, (Support(Region((None, 0.0)), (0.0, 0.0)),), (BodyForce((3.0, -2.0)),)
    )
    found = converge(problem, np.array([[0.9, 1.9]]), 1e-9, most_nodes=500)
    assert not found.resolved
    assert 1e-4 < found.error < 1
    one = converge(problem, np.array([[0.9, 1.9]]), 1e-9, most_nodes=10)
    assert np.isinf(one.error)
    with pytest.raises(ProblemError, match="must lie in the body"):
        converge(problem, np.array([[9.0, 9.0]]))


def test_forces_of_mixed_elements_balance():
    box = Box((2.0, 1.0))
    law = Isotropic(1e5, 0.499, "plane_strain", thickness=0.3)
    problem = Problem(
        box,
        law,
        (Support(box.side("left"), (0.0, 0.0)),),
        (Traction(box.side("right"), (3.0, -2.0)),),
    )
    found = converge(problem, np.array([[2.0, 0.5]]), 1e-2)
    assert found.finest.pressure is not None
    np.testing.assert_allclose(found.reactions[0].value, [-0.9, 0.6], rtol=1e-8)
    work = 0.5 * 0.3 * np.array([3.0, -2.0]) @ side_mean(found, box)
    assert found.energy.value[0] == pytest.approx(work, rel=2e-3)


def side_mean(found, box):
    """Mean displacement (2,) in m of the right side, by Gauss's rule."""
    s, weight = np.polynomial.legendre.leggauss(40)
    places = np.column_stack([np.full(40, box.size[0]), (s + 1) / 2])
    return weight @ found.finest.at(places) / 2


def test_what_has_no_limit_is_said():
    box, law = Box((2.0, 1.0)), Isotropic(1e5, 0.3, "plane_stress")
    clamp, corner = Support(box.side("left"), (0.0, 0.0)), np.array([[2.0, 1.0], [1.0, 0.5]])
    forced = converge(
        Problem(box, law, (clamp,), (PointForce((2.0, 1.0), (0.0, -1.0)),)), corner, most_nodes=2000
    )
    assert np.isinf([forced.error, forced.energy.uncertainty]).all()
    assert "a force at the point" in forced.no_limit[0]
    pins = (
        Support(Region((0.0, 0.0)), (0.0, 0.0)),
        Support(Region((2.0, 0.0)), (None, 0.0)),
    )
    pressed = (Traction(box.side("top"), (0.0, -1.0)),)
    carried = converge(Problem(box, law, pins, pressed), corner, most_nodes=2000)
    assert np.isinf(carried.error)
    assert len(carried.no_limit) == 2
    pulled = (Traction(box.side("right"), (1.0, 0.0)), Traction(box.side("left"), (-1.0, 0.0)))
    free = converge(Problem(box, law, pins, pulled), corner)  # pins that carry nothing
    assert not free.no_limit
    assert free.error < 1e-9


def test_materials_that_cross_are_known_to_hide_their_error():
    box, soft = Box((2.0, 2.0)), Isotropic(1e5, 0.3, "plane_strain")
    stiff = Isotropic(1e9, 0.3, "plane_strain")
    quarters = [Region(((0.0, 1.0), (0.0, 1.0))), Region(((1.0, 2.0), (1.0, 2.0)))]
    problem = Problem(
        box, soft, (Support(box.side("bottom"), (0.0, 0.0)),),
        (Traction(box.side("top"), (100.0, 0.0)),),
        zones=tuple(Zone(region, stiff) for region in quarters),
    )  # fmt: skip
    found = converge(problem, np.array([[2.0, 2.0]]), most_nodes=5000)
    # Meshes that crowd at the crossing, under loads alone, are a bound from below: 0.278134 J.
    assert found.energy.value[0] + found.energy.uncertainty > 0.278134
    assert found.error > 0.05
    beside = replace(problem, zones=problem.zones[:1])
    assert converge(beside, np.array([[2.0, 2.0]]), most_nodes=5000).error < 0.05


def test_memory_limits_meshes_in_space(monkeypatch):
    cube = Box((1.0, 1.0, 1.0))
    problem = Problem(
        cube, Isotropic(1e5, 0.3, "solid"), (Support(cube.side("left"), (0.0, 0.0, 0.0)),),
        (Traction(cube.side("right"), (0.0, 0.0, 1.0)),),
    )  # fmt: skip
    at = np.array([[1.0, 1.0, 1.0]])
    found = converge(problem, at, 1e-9, memory=0.1)
    sizes = [len(solution.body.points) for solution in found.solutions]
    assert sizes == [343, 2197]
    assert found.more.unknowns == 3 * 8 * 2197
    assert 0.1e9 < found.more.bytes < 0.5e9
    assert found.more.seconds == pytest.approx(8 * found.seconds[-1])
    assert converge(problem, at, 0.1, memory=0.05).more is None  # known as asked
    monkeypatch.setattr("reference_fem.effort.free_memory", lambda: 0.12e9)
    with pytest.raises(SolverError, match=r"unknowns, takes 0\.2 GB, and 0\.1 are free.*= 0\.1"):
        converge(problem, at, 1e-9, memory=1.0)
