"""Bad input gets one clear line that names the thing, the value and the remedy, and nothing else.

First a list of what users have got wrong or might; then random numbers, among them NaN, infinities
and zeros: either a valid result of finite numbers, or one of the two errors.
"""

from __future__ import annotations

import math
import warnings

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import reference_fem
from msvalidate.bench.judging.candidate import solve_springs
from msvalidate.bench.judging.compare import farthest_value, observed_order
from msvalidate.bench.judging.evidence import judge
from msvalidate.bench.judging.singularity import clamped_free_exponent
from msvalidate.bench.judging.sweep import Setting
from msvalidate.dielectric.charges.faces import slab_faces
from msvalidate.problem import (
    Anisotropic,
    BodyForce,
    Box,
    Isotropic,
    PointForce,
    Polygon,
    Problem,
    ProblemError,
    Region,
    Segment,
    SolverError,
    Support,
    Traction,
    prescribed_displacements,
    vectors_at,
)
from msvalidate.problem.checks import finite, format_value, whole_number
from msvalidate.springs.bodies.calibrate import calibrate_material
from msvalidate.springs.bodies.lattice_network import lattice_network
from msvalidate.springs.constants.directions import directional_ratio
from msvalidate.springs.constants.homogenise import (
    deforms_affinely,
    homogenise_network,
    interior_tensor,
)
from msvalidate.springs.constants.isotropic import isotropic_constants
from msvalidate.springs.constants.routes import ROUTES, default_constants
from msvalidate.springs.constants.stiffness import (
    moduli,
    pattern_tensor,
    spring_tensor,
    square_tensor,
)
from msvalidate.springs.dynamics.divergence import StabilityWarning
from msvalidate.springs.dynamics.implicit import ConvergenceError
from msvalidate.springs.dynamics.integrate import State, damping_rate, euler_cromer, motion
from msvalidate.springs.dynamics.integrators import EULER_CROMER, INTEGRATORS
from msvalidate.springs.dynamics.relax import algorithm1, relax
from msvalidate.springs.dynamics.spectrum import natural_frequencies
from msvalidate.springs.dynamics.step_limits import stability_limit
from msvalidate.springs.lattice import (
    diagonal_square,
    patterns,
    square,
    trapezium,
    triangular,
    zigzag_block,
)
from msvalidate.springs.network import Network, faults, internal_force, spring_network
from msvalidate.springs.statics.equilibrium import equilibrium
from msvalidate.springs.statics.tangents import is_stable
from reference_fem import body as fem_body
from reference_fem import elasticity

NAN, INF = math.nan, math.inf
LINE = 300
"""Letters that a message may take."""
BOX = Box((2.0, 1.0))
SHEET = Isotropic(1e6, 1 / 3)
CLAMP = Support(BOX.side("left"), (0.0, 0.0))
PULL = Traction(BOX.side("right"), (1.0, 0.0))
PROBLEM = Problem(BOX, SHEET, (CLAMP,), (PULL,))
LATTICE = square(BOX, (4, 2))
NETWORK = lattice_network(PROBLEM, LATTICE)
FALLING = lattice_network(Problem(BOX, SHEET, (CLAMP,), (BodyForce((3.0, -1e4)),)), LATTICE)
MESH = reference_fem.box_discretisation(BOX, (4, 2), "Q1")
ZIGZAG = zigzag_block(1.0, (4, 3))
TENSOR = square_tensor(2.0, 1.0)
SWUNG = State(np.where(NETWORK.fixed, NETWORK.points, 1.3 * NETWORK.points), 0 * NETWORK.points)
STILL = State(NETWORK.start, np.zeros_like(NETWORK.points))
TRIANGLE = ([[0, 0], [1, 0], [0, 1]], [[0, 1], [1, 2], [0, 2]])
QUAD = ([[0, 0], [1, 0], [1, 1], [0, 1]], [[0, 1, 2, 3]])


def plate(supports=(CLAMP,), loads=(PULL,), **options):
    return Problem(BOX, SHEET, supports, loads, **options)


def net(stiffness=1.0, **options):
    held = np.array([[1, 1], [0, 1], [0, 0]], dtype=bool)
    return spring_network(*TRIANGLE, stiffness, **({"fixed": held} | options))


def meshed(outline=ZIGZAG, spacing=1 / 3, element="P1", **options):
    return reference_fem.polygon_discretisation(outline, spacing, element, **options)


def fem(points=QUAD[0], cells=QUAD[1], element="Q1", material=SHEET, fixed=(), forces=()):
    return reference_fem.solve(points, cells, element, material, fixed, forces)


BAD = [
    # values and names
    ("ragged", lambda: finite("mass", [[1, 2], [3]]), ProblemError, "rows of different length"),
    ("complex", lambda: finite("mass", 1j), ProblemError, "mass: expected numbers, got 1j"),
    ("boolean", lambda: Isotropic(True, 0.3), ProblemError, "E: expected numbers, got True"),
    ("huge count", lambda: whole_number("steps", 10**12, 1), ProblemError,
        "the most is 1000000000"),
    # boxes and outlines
    ("box of text", lambda: Box((1.0, "b")), ProblemError, "box size along y: expected numbers"),
    ("box too large", lambda: Box((1.0, 1e160)), ProblemError, "y: 1e+160 m; take a unit in which"),
    ("box too thin", lambda: Box((1.0, 1e-10)), ProblemError, "thinner than 1e-09 m, where two"),
    ("outline far away", lambda: Polygon(((1e12, 0.0), (1e12 + 1, 0.0), (1e12, 1.0))), ProblemError,
        "1e+12 m from the origin, where coordinates no longer tell its places apart"),
    ("outline of too many", lambda: Polygon(((0.0, 0.0),) * 20_000), ProblemError,
        "polygon: 2e+04 vertices, and the most is 1e+04"),
    # regions
    # materials
    ("ratio of a list", lambda: Isotropic(1.0, [0.3]), ProblemError, "nu: [0.3] is a list; give o"),
    ("no thickness", lambda: Isotropic(1.0, 0.3, thickness=0.0), ProblemError, "thickness: 0.0 m"),
    ("state in a list", lambda: Isotropic(1.0, 0.3, ["solid"]), ProblemError, "state: ['solid'];"),
    ("tensor of a mass", lambda: Anisotropic(np.eye(3), -1.0), ProblemError, "density: -1.0 kg/m³"),
    # problems
    ("support of a list", lambda: Support(BOX.side("left"), [0.0]), ProblemError, "1 components"),
    ("force at a list", lambda: PointForce([0.0, 0.0], (1.0, 0.0)), ProblemError, "give a tuple"),
    ("body force", lambda: BodyForce("down"), ProblemError, "body force: expected numbers, got 'd"),
    ("body force of one axis", lambda: BodyForce((1.0,)), ProblemError, "give 2 or 3 components"),
    ("body force of three axes", lambda: plate(loads=(BodyForce((0.0, 0.0, 1.0)),)), ProblemError,
        "body force: (0.0, 0.0, 1.0); give 2 components"),
    ("no material", lambda: Problem(BOX, None, (CLAMP,)), ProblemError, "material: None; give an"),
    ("name of two lines", lambda: plate(name="a\nb"), ProblemError, r"name: 'a\nb'; give 1 to"),
    ("points of one axis", lambda: prescribed_displacements(PROBLEM, np.zeros(3)), ProblemError,
        "an array (n, 2)"),
    ("field of text", lambda: vectors_at("body force", lambda p: p.astype(str), LATTICE.points),
        ProblemError, "body force: expected numbers"),
    # lattices
    ("square of 2.5e11", lambda: square(Box((1.0, 1.0)), 500_000), ProblemError, "2.5e+11 points"),
    ("diagonal square of 5e11", lambda: diagonal_square(Box((1.0, 1.0)), 500_000), ProblemError,
        "square lattice of 500000 x 500000 cells: 5e+11 points, and the most is 2e+07; take fewer"),
    ("triangles of 1e-7", lambda: triangular(ZIGZAG, 1e-7 / 3), ProblemError, "most is 2e+07"),
    ("strips of one number", lambda: zigzag_block(1.0, 6), ProblemError, "cells 6; give two whole"),
    ("strips without end", lambda: zigzag_block(1.0, (10**8, 2)), ProblemError, "2e+08 vertices"),
    ("rows without end", lambda: trapezium(1.0, (10**8, 10**8)), ProblemError, "points, and the"),
    ("trapezium of one number", lambda: trapezium(1.0, 3), ProblemError, "give two whole numbers"),
    # networks
    ("network of None", lambda: lattice_network(None, LATTICE), ProblemError, "give a Problem"),
    ("network on None", lambda: lattice_network(PROBLEM, None), ProblemError, "give a Lattice"),
    ("fixed in rows", lambda: net(fixed=[[True], [True, False]]), ProblemError, "fixed: rows of d"),
    ("held of None", lambda: Network(*[None] * 8), ProblemError, "points: expected numbers"),
    ("factor of text", lambda: net().scaled("a"), ProblemError,
        "factor of the stiffness: expected"),
    ("points far away", lambda: spring_network([[0, 1e200]], [[0, 1]], 1.0), ProblemError, "unit"),
    ("position of a list", lambda: internal_force(NETWORK, [0.0]), ProblemError,
        "position: [0.0];"),
    ("position of NaN", lambda: internal_force(NETWORK, NETWORK.points * NAN), ProblemError,
        "position: nan at index (0, 0); every value must be finite"),
    # faults
    ("fault of text", lambda: faults.stiffen_diagonals(NETWORK, "a"), ProblemError,
        "size of the fault: exp"),
    ("fault in None", lambda: faults.stiffen_all(None, 0.1), ProblemError, "give a Network"),
    ("fault too large", lambda: faults.stiffen_all(NETWORK, -2.0), ProblemError,
        "must be 0 or mor"),
    ("fault in other loads", lambda: faults.lump_tractions(PROBLEM, net(), 0.1), ProblemError,
        "no point of the network lies there; give the problem's own"),
    # stiffness
    ("tensor of NaN", lambda: square_tensor(NAN, 1.0), ProblemError, "spring constant k1: nan"),
    ("tensor of None", lambda: interior_tensor(None, (1.0,), "equal"), ProblemError, "a Lattice"),
    ("moduli of a row", lambda: moduli([1.0]), ProblemError, "shape (1,); give a plane one"),
    ("moduli of zeros", lambda: moduli(np.zeros((3, 3))), ProblemError, "C11 = 0, C12 = 0"),
    ("ratio of NaN", lambda: directional_ratio(TENSOR, NAN), ProblemError, "angle: nan"),
    ("tensor of no pattern", lambda: pattern_tensor("square", (1.0,)), ProblemError, "a Pattern"),
    ("affinity of no pattern", lambda: deforms_affinely("square"), ProblemError, "give a Pattern"),
    ("no such solver", lambda: homogenise_network(1, [[0, 0]], [[1.0, 0]], [1.0], 1.0, solver="x"),
        ProblemError, "solver"),
    ("no segments", lambda: slab_faces(2.0, 1.0, 0), ProblemError, "segments: 0"),
    ("springs of no length", lambda: spring_tensor(np.zeros((1, 2)), [1.0], 1.0), ProblemError,
        "0 h"),
    ("constants on None", lambda: default_constants(SHEET, None), ProblemError, "give a Lattice"),
    # corners
    ("wedge of a row", lambda: clamped_free_exponent([1.0], 1.0), ProblemError, "give a plane one"),
    # equilibria
    ("springs of None", lambda: solve_springs(PROBLEM, None), ProblemError,
        "network: None; give a N"),
    ("answer of a list", lambda: solve_springs(PROBLEM, NETWORK, ["linear"]), ProblemError,
        "choose lin"),
    ("stability of None", lambda: is_stable(None), ProblemError, "give a Configuration"),
    # motion
    ("motion of None", lambda: euler_cromer(None, STILL, 1.0, 1), ProblemError, "give a Network"),
    ("motion from None", lambda: euler_cromer(NETWORK, None, 1.0, 1), ProblemError, "give a State"),
    ("steps too long", lambda: euler_cromer(NETWORK, STILL, 1e9, 200, warn=False), SolverError,
        "beyond all bounds with steps of 1e+09 s; take steps below stability_limit, 0.01464 s"),
    ("steps too long for Newton's method", lambda: motion(FALLING, SWUNG,
        INTEGRATORS["average_acceleration"], 1e9, 1), ConvergenceError, "implicit step: a move of"),
    ("steps of a list", lambda: euler_cromer(NETWORK, STILL, [1e-3], 1), ProblemError,
        "time step dt: [0.001] is a list; give one number"),
    ("name of an integrator", lambda: motion(NETWORK, STILL, "Leap frog", 1.0, 1), ProblemError,
        "integrator: 'Leap frog'; did you mean 'leapfrog'?"),
    (
        "name of no integrator",
        lambda: stability_limit("rk45", 1.0, 1.0),
        ProblemError,
        "integrator: 'rk45'; choose explicit_euler, euler_cromer,",
    ),
    ("integrator of None", lambda: motion(NETWORK, STILL, None, 1.0, 1), ProblemError, "give an I"),
    ("name of a method", lambda: relax(NETWORK, "fir"), ProblemError,
        "method: 'fir'; did you mean 'fire'?"),
    ("steps without end", lambda: euler_cromer(NETWORK, STILL, 1.0, 10**12), ProblemError, "steps"),
    ("damping of None", lambda: damping_rate(NETWORK, None), ProblemError,
        "damping: expected numb"),
    ("limit of no rates", lambda: stability_limit(EULER_CROMER, 1.0, 1.0, []), ProblemError,
        "a negative rate feeds the motion"),
    ("relaxation of None", lambda: algorithm1(None), ProblemError, "network: None; give a Netw"),
    ("frequencies of None", lambda: natural_frequencies(None), ProblemError, "give a Network"),
    ("no frequency", lambda: natural_frequencies(NETWORK, True), ProblemError, "count: True freq"),
    # comparisons and settings
    ("evidence of a number", lambda: judge(3), ProblemError, "evidence: 3; give an Evidence"),
    ("nothing to compare", lambda: farthest_value([], []), ProblemError, "comparison of no values"),
    ("unlike rows", lambda: farthest_value([1, 2], [1, 2, 3]), ProblemError,
        "with references (3,); give one"),
    ("order of zero", lambda: observed_order([1, 0], [1, 1]), ProblemError,
        "give each once, above"),
    ("negative seed", lambda: Setting(seed=-1), ProblemError,
        "seed: -1; give a whole number, 0 or"),
    ("no executor", lambda: Setting(executor=4), ProblemError,
        "executor: 4; give a concurrent.fut"),
    ("nothing to sweep", lambda: Setting().sweep(None, [], "a"), ProblemError,
        "sweep: None over []"),
    # meshes
    ("mesh of None", lambda: reference_fem.box_discretisation(None, 2), ProblemError,
        "in a None; g"),
    ("rows of None", lambda: fem(fixed=None), ProblemError, "fixed: None; give rows (node, comp"),
    ("material of None", lambda: elasticity.stiffness(MESH, None), ProblemError,
        "give an Isotropic"),
    ("finite elements of None", lambda: reference_fem.solve_problem(None, MESH), ProblemError,
        "a Pro"),
    ("finite elements on None", lambda: reference_fem.solve_problem(PROBLEM, 3), ProblemError,
        "on"),
    ("solution of a row", lambda: fem_body.Solution(MESH, np.zeros(3)), ProblemError, "shape (3,)"),
    ("refined None", lambda: reference_fem.refine(None, 1, 1.0), ProblemError,
        "give a function of"),
    ("refined text", lambda: reference_fem.refine(lambda _: "a", 1, 1.0), ProblemError,
        "refined quantity: expected numbers, got 'a'"),
]  # fmt: skip


def refused(make, kind, piece):
    """What is wrong with the refusal; "" if nothing is."""
    try:
        make()
    except (ProblemError, SolverError) as error:
        line = str(error)
        if type(error) is not kind or piece not in line:
            return f"{type(error).__name__}: {line}"
        one = line.strip() == line and len(line.splitlines()) == 1
        return "" if one and len(line) < LINE else f"not one short line: {line}"
    except Exception as error:  # noqa: BLE001  what users should never see
        return repr(error)
    return "not refused"


def test_bad_input_gets_one_clear_line():
    missed = {name: refused(*given) for name, *given in BAD}
    assert {name: why for name, why in missed.items() if why} == {}


def test_the_list_is_long_enough_and_names_each_once():
    assert len({entry[0] for entry in BAD}) == len(BAD) >= 60


@pytest.mark.parametrize(
    ("value", "line"),
    [
        ("left", "'left'"),
        ("left\u200b\n", r"'left\u200b\n'"),
        (np.eye(2), "[[1. 0.] [0. 1.]]"),
        (BOX, "box 2 x 1 m"),
        ((1, 2.5, None), "(1, 2.5, None)"),
    ],
    ids=["text", "invisible", "array", "box", "tuple"],
)
def test_what_was_given_is_shown_on_one_line(value, line):
    assert format_value(value) == line


def test_what_was_given_is_shown_shortened():
    for value in ("a" * 10**6, list(range(10**6)), np.zeros(10**6), {i: i for i in range(10**5)}):
        assert len(format_value(value)) <= 100


def test_a_list_of_counts_is_as_good_as_a_tuple():
    assert len(diagonal_square(BOX, [4, 2]).points) == len(diagonal_square(BOX, (4, 2)).points)
    assert zigzag_block(1.0, [4, 3]) == ZIGZAG
    assert len(reference_fem.box_discretisation(BOX, [4, 2], "Q1").points) == len(MESH.points)


def test_too_little_memory_is_told(monkeypatch):
    def no_memory(*_args, **_options):
        raise MemoryError

    monkeypatch.setattr("msvalidate.linear_algebra.factor.splu", no_memory)
    with pytest.raises(SolverError, match="more memory than there is; take solver"):
        equilibrium(NETWORK)


def test_rings_that_refine_everywhere_are_refused_before_memory_is_taken(monkeypatch):
    # Else it takes seconds.
    monkeypatch.setattr("reference_fem.mesh.triangles.NODES_PER_TRIANGLE", 2e3)
    with pytest.raises(ProblemError, match="mesh refined to depth 4 of 12 with 1000000 rings: "):
        meshed(towards=[(0.0, 0.0)], depth=12, rings=10**6)


# Any numbers at all ---------------------------------------------------------------------------

number = st.one_of(
    st.sampled_from([NAN, INF, -INF, 0.0, -0.0, 1e-12, 0.5, 1.0, 3.0, -1.0, 1e6, 1e12]),
    st.floats(0.1, 10.0),
    st.floats(-1e12, 1e12),
)
ordinary = st.one_of(st.floats(0.1, 10.0), number)
"""Half of them such as users mean, so that what comes after the first check is reached too."""
few = settings(max_examples=60, deadline=None, derandomize=True)


def judged(make):
    """What `make` returns; None where it is refused by one line of one of the two errors."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.simplefilter("ignore", StabilityWarning)  # said before a run that may be refused
        try:
            return make()
        except (ProblemError, SolverError) as error:
            line = str(error)
            assert 0 < len(line) < LINE
            assert len(line.splitlines()) == 1
            return None


def all_finite(*values):
    return all(np.isfinite(np.asarray(value, dtype=float)).all() for value in values)


@few
@given(st.lists(st.tuples(ordinary, ordinary), min_size=3, max_size=5))
def test_any_polygon(vertices):
    outline = judged(lambda: Polygon(tuple(vertices)))
    if outline:
        assert all_finite(outline.volume, outline.tolerance, outline.span)
        assert outline.volume > 0


@few
@given(
    E=ordinary,
    nu=number,
    thickness=ordinary,
    state=st.sampled_from(["plane_stress", "plane_strain"]),
)
def test_any_isotropic_material(E, nu, thickness, state):
    material = judged(lambda: Isotropic(E, nu, state, thickness=thickness))
    if material:
        assert all_finite(material.E, material.nu, material.thickness)
        constants = judged(lambda: isotropic_constants(material, patterns.square(), 1.0))
        assert constants is None or all_finite(constants)
        for route in ROUTES:
            found = judged(
                lambda route=route: calibrate_material(
                    material, square(Box((1.0, 1.0)), 2), route=route
                )
            )
            assert found is None or all_finite(found.constants, found.volume, found.E)


@few
@given(st.lists(ordinary, min_size=6, max_size=6), ordinary)
def test_any_tensor(entries, angle):
    C = np.zeros((3, 3))
    C[np.triu_indices(3)] = entries
    C += np.triu(C, 1).T
    if judged(lambda: Anisotropic(C)):
        assert all_finite(C)
        exponent = judged(lambda: clamped_free_exponent(C, angle))
        assert exponent is None or 0 < exponent < INF


@few
@given(ordinary, ordinary, ordinary, ordinary)
def test_any_support_and_load(x, y, u, p):
    part = judged(lambda: Segment((0.0, y), (x, 0.0)))
    support = judged(lambda: Support(Region((x, None)), (u, None)))
    pull = judged(lambda: Traction(BOX.side("right"), (p, u)))
    force = judged(lambda: PointForce((x, y), (p, u)))
    weight = judged(lambda: BodyForce.gravity(p, (u, 0.0)))
    assert weight is None or all_finite(weight.force)
    loads = tuple(load for load in (pull, force, weight) if load)
    line = part and judged(lambda: Support(part, (u, 0.0)))
    supports = tuple(s for s in (CLAMP, support, line) if s)
    for some in (loads, loads[:1]):
        judged(lambda some=some: Problem(BOX, SHEET, supports, some))


@few
@given(height=ordinary, part=st.sampled_from([1.0, 0.5, 1 / 3, 1e-8, 0.999]), spacing=number)
def test_any_triangular_lattice_and_mesh(height, part, spacing):
    outline = judged(lambda: zigzag_block(height, (2, 2)))
    if outline:
        for h in (height / 2 * part, spacing):
            if h > 0 and 300 < height / h < 10_000:  # a body like any other, but seconds to make
                continue
            lattice = judged(lambda h=h: triangular(outline, h))
            assert lattice is None or all_finite(lattice.points, lattice.point_volume)
            mesh = judged(lambda h=h: meshed(outline, h))
            assert mesh is None or all_finite(mesh.points)


@few
@given(
    st.lists(st.tuples(ordinary, ordinary), min_size=3, max_size=3),
    st.tuples(ordinary, ordinary, ordinary, number, number),
)
def test_any_network_and_its_equilibrium(points, values):
    stiffness, rest_length, mass, force, displacement = values
    x = np.array(points)
    moved, pulled = np.zeros((3, 2)), np.zeros((3, 2))
    moved[0, 0], pulled[2, 1] = displacement, force
    network = judged(
        lambda: net(stiffness, mass=mass, rest_length=rest_length, displacement=moved, force=pulled)
    )
    elsewhere = judged(
        lambda: spring_network(x, TRIANGLE[1], stiffness, fixed=[[True, True]] * 2 + [[False] * 2])
    )
    for body in (network, elsewhere):
        if body is None:
            continue
        assert all_finite(body.stiffness, body.vector)
        for geometry in ("linear", "nonlinear"):
            found = judged(lambda body=body, geometry=geometry: equilibrium(body, geometry))
            assert found is None or all_finite(found.position, found.reaction, found.residual)
        frequencies = judged(lambda body=body: natural_frequencies(body, 1))
        assert frequencies is None or all_finite(*frequencies)


@few
@given(E=ordinary, size=ordinary, traction=number, thickness=ordinary, density=ordinary)
def test_any_body_on_both_sides(E, size, traction, thickness, density):
    def question():
        box = Box((size, size))
        sheet = Isotropic(E, 1 / 3, density=density, thickness=thickness)
        held, pull = (
            Support(box.side("left"), (0.0, 0.0)),
            Traction(box.side("right"), (traction, 0.0)),
        )
        return Problem(box, sheet, (held,), (pull,))

    problem = judged(question)
    if problem is None:
        return
    network = judged(lambda: lattice_network(problem, square(problem.domain, 2)))
    if network:
        found = judged(lambda: equilibrium(network))
        assert found is None or all_finite(found.displacement, found.reaction)
    mesh = judged(lambda: reference_fem.box_discretisation(problem.domain, 2, "Q1"))
    if mesh:
        solution = judged(lambda: reference_fem.solve_problem(problem, mesh))
        assert solution is None or all_finite(solution.displacement)


@few
@given(
    stiffness=ordinary,
    mass=ordinary,
    force=number,
    options=st.fixed_dictionaries(
        {
            "dt": st.none() | number,
            "damping": st.none() | number,
            "tolerance": st.just(0.01) | number,
        }
    ),
)
def test_any_relaxation(stiffness, mass, force, options):
    pulled = np.zeros((3, 2))
    pulled[2, 1] = force
    network = judged(lambda: net(stiffness, mass=mass, force=pulled))
    if network:
        for most in (40, None if options["dt"] is None else 10):
            run = judged(lambda most=most: algorithm1(network, max_steps=most, **options))
            assert run is None or all_finite(run.equilibrium.position, run.history)


@few
@given(dt=number, damping=number, place=number, speed=number)
def test_any_motion(dt, damping, place, speed):
    start = np.array(NETWORK.start)
    start[-1, 0] = place
    for path in ("auto", "plain"):
        end = judged(
            lambda path=path: euler_cromer(
                NETWORK, State(start, np.full_like(start, speed)), dt, 5, damping, path=path
            )
        )
        assert end is None or all_finite(end.position, end.velocity)
