"""Solutions with their own error: finer meshes of the same body, and errors that are as stated."""

from __future__ import annotations

import time
from dataclasses import replace
from itertools import chain
from types import SimpleNamespace

import numpy as np
import pytest

from msvalidate.problem import (
    VOIGT,
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
from reference_fem import converged
from reference_fem.converged import LargeChange, Reference, converge, is_nearly_incompressible
from reference_fem.first_mesh import MOST_MIXED, first_mesh
from reference_fem.materials import materials_of
from reference_fem.mesh.outlines import outline_discretisation
from reference_fem.richardson import TWO_MESHES
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


CUBE = Box((1.0, 1.0, 1.0))
PULLED = Problem(
    CUBE, Isotropic(1e5, 0.3, "solid"), Support("left"), Traction("right", (0.0, 0.0, 1.0))
)
TIP = np.array([[1.0, 1.0, 1.0]])


def test_memory_limits_meshes_in_space(monkeypatch):
    steps, began = [], time.perf_counter()
    monkeypatch.setattr(converged, "report_step", lambda _, *values: steps.append(values))
    found = converge(PULLED, TIP, 1e-9, memory=0.1)
    sizes = [len(solution.body.points) for solution in found.solutions]
    assert sizes == [343, 2197]
    assert 0 < min(found.seconds) <= sum(found.seconds) < time.perf_counter() - began
    expected = f", about {8 * found.seconds[0]:.0f} s"
    assert steps == [(1, 3, "343", ""), (2, 3, "2,197", expected)]
    assert found.more.unknowns == 3 * 8 * 2197
    assert 0.1e9 < found.more.bytes < 0.5e9
    assert found.more.seconds == pytest.approx(8 * found.seconds[-1])
    assert converge(PULLED, TIP, 0.1, memory=0.05).more is None  # known as asked
    monkeypatch.setattr("reference_fem.effort.free_memory", lambda: 0.12e9)
    with pytest.raises(SolverError, match=r"unknowns, takes 0\.2 GB, and 0\.1 are free.*= 0\.1"):
        converge(PULLED, TIP, 1e-9, memory=1.0)


@pytest.mark.parametrize("dim", [2, 3])
def test_an_even_strain_has_closed_forms(dim):
    """All sides follow u = A x; two meshes with equal values are enough."""
    A = 1e-3 * np.array([[3.0, 1.0, -2.0], [2.0, -4.0, 5.0], [1.0, 3.0, 2.0]])[:dim, :dim]
    box = Box((2.0, 1.0) if dim == 2 else (1.0, 1.0, 1.0))
    law = LAW if dim == 2 else Isotropic(1e5, 0.3, "solid")
    law = replace(law, thickness=1.0 if dim == 3 else 0.2)
    moves = tuple(lambda p, row=row: p @ row for row in A)
    sides = ("left", "right", "bottom", "top", "back", "front")[: 2 * dim]
    x = np.array([box.size, 0.3 * np.array(box.size)])
    found = converge(Problem(box, law, tuple(Support(box.side(s), moves) for s in sides)), x)
    assert (len(found.solutions), found.accuracy) == (2, 1e-3)
    strain, (i, j) = (A + A.T) / 2, np.transpose(VOIGT[dim])
    ratio = law.nu / (1 - (dim - 1) * law.nu)  # of plane stress, and of a solid
    stress = law.E / (1 + law.nu) * (strain + ratio * np.trace(strain) * np.eye(dim))
    np.testing.assert_allclose(found.mean_stress.value, stress[i, j], rtol=1e-8)
    energy = np.prod(box.size) * law.thickness * (stress * strain).sum() / 2
    assert found.energy.value[0] == pytest.approx(energy, rel=1e-8)
    np.testing.assert_allclose(sum(each.value for each in found.reactions), 0, atol=1e-9 * law.E)
    large = replace(found, large=LargeChange(np.full(x.shape, 7.0), 0.25), following=object())
    np.testing.assert_allclose(large.displacement.value, x @ A.T + 7, rtol=1e-9)
    size = np.linalg.norm(x @ A.T + 7, axis=1).max()
    assert large.error == pytest.approx(0.25 / size, rel=1e-6)
    assert large.more is large.following
    assert replace(large, accuracy=large.error).more is None


def scripted(values):
    """A reference with prescribed values on meshes of 5, 10 and 20 points."""
    solutions = [
        SimpleNamespace(stress=lambda _, v=v: v, body=SimpleNamespace(points=range(5 * 2**n)))
        for n, v in enumerate(np.array(values))
    ]
    return Reference(None, np.zeros((1, 2)), tuple(solutions), 0.1, ())


def test_values_of_each_mesh(monkeypatch):
    found = scripted([[[1.0, 9.0]], [[4.0, 3.0]], [[2.0, 8.0]]])
    value, off = found.stress(np.zeros((1, 2)))
    assert (value.tolist(), off.tolist()) == ([[2, 8]], [5 * TWO_MESHES])
    assert np.isinf(replace(found, solutions=found.solutions[:1]).stress(np.zeros((1, 2)))[1]).all()
    for nodes, count in ((4, 1), (5, 1), (10, 2), (19, 2), (20, 3)):
        assert found.solutions_up_to(nodes) == found.solutions[:count]
    assert found.finest is found.solutions[-1]
    # A third of the change before the last, of whatever sign, where the last one is small.
    monkeypatch.setattr(Reference, "_most", 4.0)
    monkeypatch.setattr(Reference, "_mean_stress", lambda _, value, __: value)
    for values in ([5.0, 0.9, 0.0, 0.01], [0.9, 0.0, 0.01]):
        monkeypatch.setattr(Reference, "_internal", [(np.array([v]), None) for v in values])
        assert scripted([]).mean_stress.uncertainty == pytest.approx(0.3)
    monkeypatch.setattr(Reference, "_internal", [(np.array([v]), None) for v in (1.0, 1.1)])
    assert scripted([]).mean_stress.uncertainty == pytest.approx(TWO_MESHES * 0.1)


@pytest.mark.parametrize(
    ("laws", "expected"),
    [
        ([(0.45, "plane_strain")], True),
        ([(0.449, "solid")], False),
        ([(0.49, "plane_stress")], False),
        ([(0.49, "solid"), (0.0, "solid")], False),
        ([(0.3, "solid"), (0.5, "solid")], True),
        ([(0.5, "solid"), (-0.1, "solid")], False),
        ([(0.01, "solid"), (0.46, "solid")], True),
    ],
)
def test_mixed_elements_are_for_nearly_incompressible_solids(laws, expected):
    materials = [Isotropic(1e5, *law) for law in laws]
    assert is_nearly_incompressible(SimpleNamespace(materials=materials)) == expected


@pytest.mark.parametrize(
    ("options", "meshes"),
    [
        ({"accuracy": 0.5}, 2),
        ({"accuracy": 0.5, "solver": "superlu"}, 2),
        ({"accuracy": 0.5, "most_nodes": 2744}, 2),
        ({"most_nodes": 2743}, 1),
        ({"most_nodes": 1}, 1),
        ({"mixed": True}, 1),
        ({"solver": "superlu"}, 1),
    ],
)
def test_numbers_of_meshes(monkeypatch, options, meshes):
    """The first mesh has 343 nodes, a second at most 2744."""
    monkeypatch.setattr(converged, "MOST_MIXED", 2743)
    nodes = 2743 if options == {"solver": "superlu"} else 2744
    monkeypatch.setattr(converged, "MOST_NODES", {2: 9, 3: nodes})
    found = converge(PULLED, TIP, **{"accuracy": 1e-9} | options)
    assert len(found.solutions) == meshes


@pytest.mark.parametrize(
    "options", [{"accuracy": -1.0}, {"memory": 0.0}, {"most_nodes": 0}, {"problem": "cube"}]
)
def test_other_options_are_refused(options):
    with pytest.raises((ProblemError, TypeError), match=next(iter(options)).replace("_", " ")):
        converge(**{"problem": PULLED, "points": TIP} | options)


@pytest.mark.parametrize(
    ("changes", "factor"),
    [
        ({}, False),
        ({"coarser": None}, True),
        ({"finer": None}, True),
        ({"solver": "amg"}, True),
        ({"dim": 2}, True),
        ({"fast": True}, False),
        ({"nodes": 9}, False),
        ({"nodes": 20_000, "fast": True}, True),
    ],
)
def test_solvers_of_finer_meshes(monkeypatch, changes, factor):
    case = {"coarser": 1, "finer": 2 * np.eye(2), "solver": "auto", "dim": 3, "nodes": 20_001}
    case = SimpleNamespace(**case | {"fast": False} | changes)
    body = SimpleNamespace(dim=case.dim, points=range(case.nodes))
    monkeypatch.setattr(converged, "make_solver", lambda *arguments: arguments)
    monkeypatch.setattr(converged, "favours_factor", lambda _: case.fast)
    monkeypatch.setattr(converged, "Nested", lambda *arguments: arguments[-1].tolist())
    found = [SimpleNamespace(displacement=np.full(2, n)) for n in (5.0, 6.0, 7.0)]
    law = materials_of(PULLED, first_mesh(PULLED))
    result = converged._make_ready(case.solver, found, case.coarser, case.finer, body, law, 2)
    assert result == ((body, law, 2, case.solver) if factor else [14.0, 14.0])
