"""Bad input gets one clear line that names the thing, the value and the remedy, and nothing else.

First a list of what users have got wrong or might; then random numbers, among them NaN, infinities,
zeros, subnormal and huge ones: either a valid result of finite numbers, or one of the two errors.
"""

from __future__ import annotations

import math
import warnings

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import reference_fem
from msvalidate.bodies.calibrate import calibrate_material
from msvalidate.bodies.lattice_network import lattice_network
from msvalidate.constants.directions import directional_ratio, rotate_tensor
from msvalidate.constants.homogenise import interior_tensor
from msvalidate.constants.routes import ROUTES, default_constants
from msvalidate.constants.stiffness import moduli, spring_tensor, square_constants, square_tensor
from msvalidate.dynamics.divergence import StabilityWarning
from msvalidate.dynamics.implicit import ConvergenceError
from msvalidate.dynamics.integrate import State, damping_rate, euler_cromer, motion
from msvalidate.dynamics.integrators import EULER_CROMER, INTEGRATORS
from msvalidate.dynamics.spectrum import natural_frequencies
from msvalidate.dynamics.step_limits import stability_limit
from msvalidate.judging.candidate import solve_springs
from msvalidate.judging.compare import farthest_value, observed_order
from msvalidate.judging.evidence import judge
from msvalidate.judging.singularity import clamped_free_exponent
from msvalidate.judging.sweep import Setting
from msvalidate.lattice import (
    boundary_weights,
    diagonal_square,
    square,
    trapezium,
    triangular,
    zigzag_block,
)
from msvalidate.network import Network, faults, internal_force, spring_network
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
from msvalidate.relaxation.relax import algorithm1, relax
from msvalidate.statics.equilibrium import equilibrium
from msvalidate.statics.tangents import is_stable
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
BAR = trapezium(0.2, (5, 3))
TENSOR = square_tensor(2.0, 1.0)
SWUNG = State(np.where(NETWORK.held, NETWORK.points, 1.3 * NETWORK.points), 0 * NETWORK.points)
STILL = State(NETWORK.start, np.zeros_like(NETWORK.points))
TRIANGLE = ([[0, 0], [1, 0], [0, 1]], [[0, 1], [1, 2], [0, 2]])
QUAD = ([[0, 0], [1, 0], [1, 1], [0, 1]], [[0, 1, 2, 3]])


def plate(supports=(CLAMP,), loads=(PULL,), **options):
    return Problem(BOX, SHEET, supports, loads, **options)


def net(stiffness=1.0, **options):
    held = np.array([[1, 1], [0, 1], [0, 0]], dtype=bool)
    return spring_network(*TRIANGLE, stiffness, **({"held": held} | options))


def meshed(outline=ZIGZAG, spacing=1 / 3, element="P1", **options):
    return reference_fem.polygon_discretisation(outline, spacing, element, **options)


def fem(points=QUAD[0], cells=QUAD[1], element="Q1", material=SHEET, fixed=(), forces=()):
    return reference_fem.solve(points, cells, element, material, fixed, forces)


BAD = [
    # values and names
    ("ragged", lambda: finite("mass", [[1, 2], [3]]), ProblemError, "rows of different length"),
    ("complex", lambda: finite("mass", 1j), ProblemError, "mass: expected numbers, got 1j"),
    ("boolean", lambda: Isotropic(True, 0.3), ProblemError, "E: expected numbers, got True"),
    ("objects", lambda: finite("mass", [1, None]), ProblemError, "expected numbers, got [1, None]"),
    ("long list", lambda: finite("mass", ["a"] * 10**6), ProblemError, "mass: expected numbers"),
    ("many lines", lambda: finite("mass", "1\n2\n3"), ProblemError, r"got '1\n2\n3'"),
    (
        "thousands of digits",
        lambda: whole_number("steps", 10**5000, 1),
        ProblemError,
        "steps: <int>;",
    ),
    (
        "huge count",
        lambda: whole_number("steps", 10**12, 1),
        ProblemError,
        "the most is 1000000000",
    ),
    ("count as a float", lambda: square(BOX, (4.0, 2.0)), ProblemError, "cells: 4.0; give a whole"),
    # boxes and outlines
    ("box of None", lambda: Box(None), ProblemError, "box size: None; give a tuple of 2 or 3"),
    ("box of an array", lambda: Box(np.eye(2)), ProblemError, "give a tuple of 2 or 3 lengths"),
    ("box of text", lambda: Box((1.0, "b")), ProblemError, "box size along y: expected numbers"),
    ("box too large", lambda: Box((1.0, 1e160)), ProblemError, "y: 1e+160 m; take a unit in which"),
    ("box too small", lambda: Box((1e-300, 1.0)), ProblemError, "x: 1e-300 m; take a unit in"),
    ("box too thin", lambda: Box((1.0, 1e-10)), ProblemError, "thinner than 1e-09 m, where two"),
    ("side of a list", lambda: BOX.side(["left"]), ProblemError, "side ['left']: a 2D box has"),
    (
        "outline too large",
        lambda: Polygon(((0.0, 0.0), (1e160, 0.0), (0.0, 1e160))),
        ProblemError,
        "polygon vertex 1: 1e+160 at index 0; take a unit in which nothing is beyond 1e+100 m",
    ),
    (
        "outline far away",
        lambda: Polygon(((1e12, 0.0), (1e12 + 1, 0.0), (1e12, 1.0))),
        ProblemError,
        "1e+12 m from the origin, where coordinates no longer tell its places apart",
    ),
    (
        "outline of too many",
        lambda: Polygon(((0.0, 0.0),) * 20_000),
        ProblemError,
        "polygon: 2e+04 vertices, and the most is 1e+04",
    ),
    ("clockwise", lambda: Polygon(((0.0, 0.0), (0.0, 1.0), (1.0, 0.0))), ProblemError, "counter-"),
    # regions
    ("region of an array", lambda: Region(np.zeros(2)), ProblemError, "give a tuple of 2 or 3"),
    ("region far away", lambda: Region((1e200, None)), ProblemError, "x: 1e+200; take a unit in"),
    (
        "segment of no length",
        lambda: Segment((0.0, 0.0), (1e-300, 0.0)),
        ProblemError,
        "segment ((0, 0) to (1e-300, 0)): its length: 1e-300 m; take a unit",
    ),
    (
        "segment across the teeth",
        lambda: Problem(
            ZIGZAG, SHEET, (Support(Segment((0.0, 1.0), (ZIGZAG.span[0][1], 1.0)), (0.0, 0.0)),)
        ),
        ProblemError,
        "it is not on one side of the body all the way; give a part of a side, such as a Segment",
    ),
    (
        "region across the teeth",
        lambda: Problem(ZIGZAG, SHEET, (Support(Region((None, 1.0)), (0.0, 0.0)),)),
        ProblemError,
        "support on (y = 1): from (0, 1) to ",
    ),
    (
        "top of a trapezium",
        lambda: Problem(
            BAR,
            SHEET,
            (Support(Region((None, 0.0)), (0.0, 0.0)),),
            (Traction(Region((None, BAR.span[1][1])), (0.0, 1.0)),),
        ),
        ProblemError,
        "from (0, 0.519615) to (1.6, 0.519615) m it is not on one side of the body",
    ),
    # materials
    (
        "modulus of None",
        lambda: Isotropic(None, 0.3),
        ProblemError,
        "E: expected numbers, got None",
    ),
    ("infinite modulus", lambda: Isotropic(INF, 0.3), ProblemError, "E: inf; every value must be"),
    ("tiny modulus", lambda: Isotropic(5e-324, 0.3), ProblemError, "E: 4.94066e-324 Pa; take"),
    ("ratio of a list", lambda: Isotropic(1.0, [0.3]), ProblemError, "nu: [0.3] is a list; give o"),
    ("no thickness", lambda: Isotropic(1.0, 0.3, thickness=0.0), ProblemError, "thickness: 0.0 m"),
    ("state in a list", lambda: Isotropic(1.0, 0.3, ["solid"]), ProblemError, "state: ['solid'];"),
    ("tensor of zeros", lambda: Anisotropic(np.zeros((3, 3))), ProblemError, "eigenvalue 0 Pa;"),
    ("tensor of a mass", lambda: Anisotropic(np.eye(3), -1.0), ProblemError, "density: -1.0 kg/m³"),
    # problems
    ("support far away", lambda: Support(BOX.side("left"), (1e200, 0.0)), ProblemError, "1e+200"),
    ("support of a list", lambda: Support(BOX.side("left"), [0.0]), ProblemError, "give a tuple"),
    ("force at a list", lambda: PointForce([0.0, 0.0], (1.0, 0.0)), ProblemError, "give a tuple"),
    ("body force", lambda: BodyForce("down"), ProblemError, "body force: expected numbers, got 'd"),
    ("body force of one axis", lambda: BodyForce((1.0,)), ProblemError, "give 2 or 3 components"),
    (
        "body force of three axes",
        lambda: plate(loads=(BodyForce((0.0, 0.0, 1.0)),)),
        ProblemError,
        "body force: (0.0, 0.0, 1.0); give 2 components",
    ),
    (
        "weight beyond numbers",
        lambda: BodyForce.gravity(1e308, (0.0, -1e10)),
        ProblemError,
        "gravity: density 1e+308 kg/m³ by (0.0, -10000000000.0) m/s² is no ordinary number; choose",
    ),
    (
        "weight below numbers",
        lambda: BodyForce.gravity(1e-300, (0.0, -1e-10)),
        ProblemError,
        "gravity: density 1e-300 kg/m³ by (0.0, -1e-10) m/s² is no ordinary number; choose units",
    ),
    ("no domain", lambda: Problem(None, SHEET, (CLAMP,)), ProblemError, "give a Box or a Polygon"),
    ("no material", lambda: Problem(BOX, None, (CLAMP,)), ProblemError, "material: None; give an"),
    ("no supports", lambda: plate(supports=()), ProblemError, "leave the body free: translation"),
    ("name of two lines", lambda: plate(name="a\nb"), ProblemError, r"name: 'a\nb'; give 1 to"),
    ("name that hides", lambda: plate(name="a\u202eb"), ProblemError, r"name: 'a\u202eb'; give 1"),
    ("name too long", lambda: plate(name="a" * 10**6), ProblemError, "printable letters on one"),
    (
        "contradiction",
        lambda: prescribed_displacements(
            plate(supports=(CLAMP, Support(BOX.side("bottom"), (None, 0.5)))), LATTICE.points
        ),
        ProblemError,
        "y displacement 0 and 0.5 m at (0, 0); prescribe it once",
    ),
    (
        "points of one axis",
        lambda: prescribed_displacements(PROBLEM, np.zeros(3)),
        ProblemError,
        "an array (n, 2)",
    ),
    (
        "points of None",
        lambda: prescribed_displacements(PROBLEM, None),
        ProblemError,
        "shape (); give an array (n, 2)",
    ),
    (
        "field of text",
        lambda: vectors_at("body force", lambda p: p.astype(str), LATTICE.points),
        ProblemError,
        "body force: expected numbers",
    ),
    # lattices
    ("square of 2.5e11", lambda: square(Box((1.0, 1.0)), 500_000), ProblemError, "2.5e+11 points"),
    (
        "diagonal square of 5e11",
        lambda: diagonal_square(Box((1.0, 1.0)), 500_000),
        ProblemError,
        "45° of 500000 x 500000 squares: 5e+11 points, and the most is 2e+07; take fewer",
    ),
    ("triangles of 1e-7", lambda: triangular(ZIGZAG, 1e-7 / 3), ProblemError, "most is 2e+07"),
    ("triangles of None", lambda: triangular(None, 0.1), ProblemError, "a None; give a Polygon"),
    ("strips of one number", lambda: zigzag_block(1.0, 6), ProblemError, "cells 6; give two whole"),
    ("strips without end", lambda: zigzag_block(1.0, (10**8, 2)), ProblemError, "2e+08 vertices"),
    ("rows without end", lambda: trapezium(1.0, (10**8, 10**8)), ProblemError, "points, and the"),
    ("trapezium of one number", lambda: trapezium(1.0, 3), ProblemError, "give two whole numbers"),
    ("cells of three", lambda: square(BOX, [2, 2, 2]), ProblemError, "give one or two whole"),
    ("square of None", lambda: square(None, 2), ProblemError, "a None; give a plane box"),
    ("weights of None", lambda: boundary_weights(LATTICE, None), ProblemError, "None; choose shar"),
    # networks
    ("network of None", lambda: lattice_network(None, LATTICE), ProblemError, "give a Problem"),
    ("network on None", lambda: lattice_network(PROBLEM, None), ProblemError, "give a Lattice"),
    (
        "rule of an array",
        lambda: lattice_network(PROBLEM, LATTICE, mass=np.ones(3)),
        ProblemError,
        "mass: [1. 1. 1.]; choose shared or equal",
    ),
    ("held as numbers", lambda: net(held=np.full((3, 2), 2)), ProblemError, "give booleans (3, 2)"),
    ("held in rows", lambda: net(held=[[True], [True, False]]), ProblemError, "held: rows of diff"),
    ("held of None", lambda: Network(*[None] * 8), ProblemError, "points: expected numbers"),
    (
        "factor of text",
        lambda: net().scaled("a"),
        ProblemError,
        "factor of the stiffness: expected",
    ),
    (
        "points in one place",
        lambda: spring_network([[0, 0], [1e-200, 0]], [[0, 1]], 1.0),
        ProblemError,
        "its two points coincide",
    ),
    ("points far away", lambda: spring_network([[0, 1e200]], [[0, 1]], 1.0), ProblemError, "unit"),
    (
        "shear springs",
        lambda: spring_network(*TRIANGLE, 1.0, shear=object()),
        ProblemError,
        "shear springs are gone; take a volume energy",
    ),
    (
        "position of a list",
        lambda: internal_force(NETWORK, [0.0]),
        ProblemError,
        "position: [0.0];",
    ),
    (
        "position of NaN",
        lambda: internal_force(NETWORK, NETWORK.points * NAN),
        ProblemError,
        "position: nan at index (0, 0); every value must be finite",
    ),
    # faults
    (
        "fault of text",
        lambda: faults.stiffen_diagonals(NETWORK, "a"),
        ProblemError,
        "size of the fault: exp",
    ),
    (
        "fault of three sizes",
        lambda: faults.stiffen_all(NETWORK, np.ones(3)),
        ProblemError,
        "size of the fault: [1. 1. 1.] is an array (3,); give one number",
    ),
    ("fault in None", lambda: faults.stiffen_all(None, 0.1), ProblemError, "give a Network"),
    (
        "fault too large",
        lambda: faults.stiffen_all(NETWORK, -2.0),
        ProblemError,
        "must be 0 or mor",
    ),
    (
        "fault in other loads",
        lambda: faults.lump_tractions(PROBLEM, net(), 0.1),
        ProblemError,
        "no point of the network lies there; give the problem's own",
    ),
    # stiffness
    (
        "constants of None",
        lambda: square_constants(None),
        ProblemError,
        "the material must be isot",
    ),
    ("no isotropy", lambda: square_constants(SHEET, isotropic="no"), ProblemError, "give a bool"),
    ("tensor of NaN", lambda: square_tensor(NAN, 1.0), ProblemError, "spring constant k1: nan"),
    ("tensor of None", lambda: interior_tensor(None, (1.0,), "equal"), ProblemError, "a Lattice"),
    ("moduli of a row", lambda: moduli([1.0]), ProblemError, "shape (1,); give a plane one"),
    ("moduli of zeros", lambda: moduli(np.zeros((3, 3))), ProblemError, "C11 = 0, C12 = 0"),
    ("ratio of NaN", lambda: directional_ratio(TENSOR, NAN), ProblemError, "angle: nan"),
    (
        "turn without end",
        lambda: rotate_tensor(TENSOR, 1e300),
        ProblemError,
        "angle: 1e+300 rad; give a number of",
    ),
    (
        "springs of no length",
        lambda: spring_tensor(np.zeros((1, 2)), [1.0], 1.0),
        ProblemError,
        "0 h",
    ),
    ("constants on None", lambda: default_constants(SHEET, None), ProblemError, "give a Lattice"),
    # corners
    (
        "wedge of a line",
        lambda: clamped_free_exponent(TENSOR, 1e-9),
        SolverError,
        "wedge angle: 1e-",
    ),
    ("wedge of NaN", lambda: clamped_free_exponent(TENSOR, NAN), ProblemError, "wedge angle: nan"),
    ("wedge of a row", lambda: clamped_free_exponent([1.0], 1.0), ProblemError, "give a plane one"),
    # equilibria
    (
        "springs of None",
        lambda: solve_springs(PROBLEM, None),
        ProblemError,
        "network: None; give a N",
    ),
    (
        "answer of a list",
        lambda: solve_springs(PROBLEM, NETWORK, ["linear"]),
        ProblemError,
        "choose lin",
    ),
    ("stability of None", lambda: is_stable(None), ProblemError, "give a Configuration"),
    ("no stiffness", lambda: equilibrium(net(0.0)), SolverError, "a mechanism: nothing resists"),
    ("tiny stiffness", lambda: net(1e-310), ProblemError, "stiffness: 1e-310 at index 0 N/m; "),
    ("stiffness of NaN", lambda: net(NAN), ProblemError, "stiffness: nan; every value must be fin"),
    (
        "negative stiffness",
        lambda: net(-1.0),
        ProblemError,
        "stiffness: -1 at index 0 N/m; it must",
    ),
    ("no mass", lambda: net(mass=0.0), ProblemError, "mass: 0 at index 0 kg; it must be above 0"),
    # motion
    ("motion of None", lambda: euler_cromer(None, STILL, 1.0, 1), ProblemError, "give a Network"),
    ("motion from None", lambda: euler_cromer(NETWORK, None, 1.0, 1), ProblemError, "give a State"),
    (
        "steps too long",
        lambda: euler_cromer(NETWORK, STILL, 1e9, 200, warn=False),
        SolverError,
        "beyond all bounds with steps of 1e+09 s; take steps below stability_limit, 0.01464 s",
    ),
    (
        "plain steps too long",
        lambda: euler_cromer(NETWORK, STILL, 1e9, 200, compiled=False, warn=False),
        SolverError,
        "beyond all bounds with steps of 1e+09 s; take steps below stability_limit, 0.01464 s",
    ),
    (
        "steps too long for Newton's method",
        lambda: motion(FALLING, SWUNG, INTEGRATORS["average_acceleration"], 1e9, 1),
        ConvergenceError,
        "implicit step: a move of",
    ),
    (
        "steps of a list",
        lambda: euler_cromer(NETWORK, STILL, [1e-3], 1),
        ProblemError,
        "time step dt: [0.001] is a list; give one number",
    ),
    (
        "steps of an array",
        lambda: euler_cromer(NETWORK, STILL, np.ones(1), 1),
        ProblemError,
        "time step dt: [1.] is an array (1,); give one number",
    ),
    (
        "name of an integrator",
        lambda: motion(NETWORK, STILL, "Leap frog", 1.0, 1),
        ProblemError,
        "integrator: 'Leap frog' is a name; give INTEGRATORS['leapfrog']",
    ),
    (
        "name of no integrator",
        lambda: stability_limit("rk45", 1.0, 1.0),
        ProblemError,
        "integrator: 'rk45' is a name; give an entry of INTEGRATORS: explicit_euler, euler_cromer,",
    ),
    ("integrator of None", lambda: motion(NETWORK, STILL, None, 1.0, 1), ProblemError, "give an I"),
    (
        "name of a method",
        lambda: relax(NETWORK, "fire"),
        ProblemError,
        "method: 'fire' is a name; give RELAXATIONS['fire']",
    ),
    ("steps without end", lambda: euler_cromer(NETWORK, STILL, 1.0, 10**12), ProblemError, "steps"),
    (
        "damping of None",
        lambda: damping_rate(NETWORK, None),
        ProblemError,
        "damping: expected numb",
    ),
    (
        "limit of no rates",
        lambda: stability_limit(EULER_CROMER, 1.0, 1.0, []),
        ProblemError,
        "a negative rate feeds the motion",
    ),
    (
        "limit of nothing",
        lambda: stability_limit(EULER_CROMER, 5e-324, 5e-324),
        SolverError,
        "stability limit: inf s",
    ),
    (
        "relaxation of None",
        lambda: algorithm1(None),
        ProblemError,
        "network: None; give a Netw",
    ),
    (
        "relaxation by 1e-60 s",
        lambda: algorithm1(NETWORK, dt=1e-60),
        ProblemError,
        "damping and dt",
    ),
    (
        "frequencies beyond numbers",
        lambda: natural_frequencies(net(1e300, mass=1e-300), 1),
        SolverError,
        "choose units that give ordinary frequencies",
    ),
    ("frequencies of None", lambda: natural_frequencies(None), ProblemError, "give a Network"),
    ("no frequency", lambda: natural_frequencies(NETWORK, True), ProblemError, "count: True freq"),
    # comparisons and settings
    ("evidence of a number", lambda: judge(3), ProblemError, "evidence: 3; give an Evidence"),
    ("nothing to compare", lambda: farthest_value([], []), ProblemError, "comparison of no values"),
    (
        "unlike rows",
        lambda: farthest_value([1, 2], [1, 2, 3]),
        ProblemError,
        "with references (3,); give one",
    ),
    ("order of text", lambda: observed_order([1, 2], ["a", "b"]), ProblemError, "errors: expected"),
    (
        "order of zero",
        lambda: observed_order([1, 0], [1, 1]),
        ProblemError,
        "give each once, above",
    ),
    (
        "negative seed",
        lambda: Setting(seed=-1),
        ProblemError,
        "seed: -1; give a whole number, 0 or",
    ),
    (
        "no executor",
        lambda: Setting(executor=4),
        ProblemError,
        "executor: 4; give a concurrent.fut",
    ),
    (
        "nothing to sweep",
        lambda: Setting().sweep(None, [], "a"),
        ProblemError,
        "sweep: None over []",
    ),
    # meshes
    (
        "mesh of 1e10",
        lambda: reference_fem.box_discretisation(BOX, 100_000, "Q1"),
        ProblemError,
        "mesh of 100000 x 100000 cells: 1e+10 points, and the most is 4e+06; take fewer, larger",
    ),
    ("triangles of 1e-6", lambda: meshed(spacing=1e-6 / 3), ProblemError, "and the most is 4e+06"),
    (
        "depth and no place",
        lambda: meshed(depth=40),
        ProblemError,
        "depth: 40 and no places to ref",
    ),
    (
        "mesh of None",
        lambda: reference_fem.box_discretisation(None, 2),
        ProblemError,
        "in a None; g",
    ),
    (
        "mesh lines of a number",
        lambda: reference_fem.box_discretisation(BOX, 2, through=0.5),
        ProblemError,
        "mesh lines through 0.5: give coordinates for each axis",
    ),
    (
        "solid in plane elements",
        lambda: reference_fem.box_discretisation(Box((1.0, 1.0, 1.0)), 2, "Q1"),
        ProblemError,
        "mesh: Q1 in a box 1 x 1 x 1 m; in 3D, give one of H1, H2, T1, T2",
    ),
    (
        "plane in tetrahedra",
        lambda: reference_fem.box_discretisation(BOX, 2, "T1"),
        ProblemError,
        "mesh: T1 in a box 2 x 1 m; in 2D, give one of Q1, Q2",
    ),
    (
        "solid of two counts",
        lambda: reference_fem.box_discretisation(Box((1.0, 1.0, 1.0)), (2, 2), "H1"),
        ProblemError,
        "mesh cells: (2, 2); give one or three whole numbers, 1 or more",
    ),
    ("tetrahedron in the plane", lambda: fem(element="T1"), ProblemError, "T1 needs (n, 3)"),
    (
        "tetrahedron inside out",
        lambda: fem([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 2, 1, 3]], "T1"),
        ProblemError,
        "cell 0 is inverted, flat or folded; list its corners in VTK order, the first 3 counter-",
    ),
    (
        "points beyond all",
        lambda: fem([[0, 0], [1e200, 0]]),
        ProblemError,
        "points: 1e+200 at index",
    ),
    ("cells in rows", lambda: fem(cells=[[0, 1], [2]]), ProblemError, "cells: rows of different"),
    ("rows of None", lambda: fem(fixed=None), ProblemError, "fixed: None; give rows (node, comp"),
    ("body left free", fem, ProblemError, "the supports leave the body free"),
    (
        "material of None",
        lambda: elasticity.stiffness(MESH, None),
        ProblemError,
        "give an Isotropic",
    ),
    (
        "finite elements of None",
        lambda: reference_fem.solve_problem(None, MESH),
        ProblemError,
        "a Pro",
    ),
    (
        "finite elements on None",
        lambda: reference_fem.solve_problem(PROBLEM, None),
        ProblemError,
        "on",
    ),
    ("solution of a row", lambda: fem_body.Solution(MESH, np.zeros(3)), ProblemError, "shape (3,)"),
    (
        "sample outside",
        lambda: fem_body.Solution(MESH, np.zeros(MESH.points.shape)).at([[3.0, 0.0]]),
        ProblemError,
        "points to sample: (3, 0); they must lie in the body",
    ),
    (
        "refined None",
        lambda: reference_fem.refine(None, 1, 1.0),
        ProblemError,
        "give a function of",
    ),
    (
        "refined text",
        lambda: reference_fem.refine(lambda _: "a", 1, 1.0),
        ProblemError,
        "refined quantity: expected numbers, got 'a'",
    ),
    (
        "refined NaN",
        lambda: reference_fem.refine(lambda _: NAN, 1, 1.0),
        SolverError,
        "not a finite",
    ),
]


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


@pytest.mark.parametrize("unit", [1e-300, 1e-200, 1e200, 1e300])
def test_the_exponent_of_a_corner_has_no_unit(unit):
    here, there = (clamped_free_exponent(u * TENSOR, np.pi / 2) for u in (1.0, unit))
    assert there == pytest.approx(here, rel=1e-12)


@pytest.mark.parametrize("geometry", ["factor", "finite elements"])
def test_too_little_memory_is_told(geometry, monkeypatch):
    def no_memory(*_args, **_options):
        raise MemoryError

    module = (
        "msvalidate.linear_algebra.factor"
        if geometry == "factor"
        else "reference_fem.systems.factor"
    )
    monkeypatch.setattr(f"{module}.splu", no_memory)
    with pytest.raises(SolverError, match="more memory than there is; take solver"):
        equilibrium(NETWORK) if geometry == "factor" else reference_fem.solve_problem(PROBLEM, MESH)


def test_rings_that_refine_everywhere_are_refused_before_memory_is_taken(monkeypatch):
    # Else it takes seconds.
    monkeypatch.setattr("reference_fem.mesh.triangles.NODES_PER_TRIANGLE", 2e3)
    with pytest.raises(ProblemError, match="mesh refined to depth 4 of 12 with 1000000 rings: "):
        meshed(towards=[(0.0, 0.0)], depth=12, rings=10**6)


# Any numbers at all ---------------------------------------------------------------------------

number = st.one_of(
    st.sampled_from(
        [NAN, INF, -INF, 0.0, -0.0, 5e-324, 1e-310, 1e-300, 1e-160, 1e-90, 1e-12, 0.25, 0.5, 1.0]
    ),
    st.sampled_from([2.0, 3.0, -1.0, 1e6, 1e12, 1e90, 1e99, 1e101, 1e160, 1e300, -1e300, 1.8e308]),
    st.floats(0.1, 10.0),
    st.floats(),
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
@given(st.lists(ordinary, min_size=2, max_size=3))
def test_any_box(size):
    box = judged(lambda: Box(tuple(size)))
    if box:
        assert all_finite(box.volume, box.tolerance, box.span)
        assert box.volume > 0


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
        constants = judged(lambda: square_constants(material, isotropic=False))
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
@example([1.0, 1.0, 1.797693129862316e308, 1.0, 1.0, -1e300], 1.0)
def test_any_tensor(entries, angle):
    C = np.zeros((3, 3))
    C[np.triu_indices(3)] = entries
    with np.errstate(over="ignore", invalid="ignore"):
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
@given(width=ordinary, height=ordinary, cells=st.one_of(st.integers(-3, 8), st.integers()))
def test_any_square_lattice(width, height, cells):
    box = judged(lambda: Box((width, height))) or Box((1.0, 1.0))
    for body in (box, Box((box.size[0], box.size[0]))):
        lattice = judged(
            lambda body=body: square(body, cells if abs(cells) < 9 else abs(cells) + 10**5)
        )
        if lattice:
            assert all_finite(lattice.points, lattice.point_volume)
            assert (lattice.point_volume > 0).all()


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
        lambda: spring_network(x, TRIANGLE[1], stiffness, held=[[True, True]] * 2 + [[False] * 2])
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
    for compiled in (True, False):
        end = judged(
            lambda compiled=compiled: euler_cromer(
                NETWORK, State(start, np.full_like(start, speed)), dt, 5, damping, compiled=compiled
            )
        )
        assert end is None or all_finite(end.position, end.velocity)


@few
@given(number, number)
@example(5e-324, 1e-12)  # their quotient is beyond all numbers
def test_any_stability_limit(omega, damping):
    for scheme in INTEGRATORS.values():
        limit = judged(lambda scheme=scheme: stability_limit(scheme, omega, omega, damping))
        assert limit is None or 0 <= limit < INF or limit == scheme.limit(0.0)


@few
@given(number, number, number)
def test_any_constants(k1, k2, angle):
    C = judged(lambda: square_tensor(k1, k2))
    if C is not None:
        turned = judged(lambda: rotate_tensor(C, angle))
        assert turned is None or all_finite(turned)
        found = judged(lambda: moduli(C))
        assert found is None or all_finite(found.E, found.nu, found.zener)
        ratio = judged(lambda: directional_ratio(C, angle))
        assert ratio is None or all_finite(ratio)


@few
@given(
    width=ordinary,
    cells=st.tuples(st.integers(-1, 6), st.integers(-1, 6)),
    grading=number,
    through=st.lists(number, max_size=2),
)
def test_any_mesh_of_a_box(width, cells, grading, through):
    box = judged(lambda: Box((width, 1.0)))
    if box:
        for lines in ((), tuple(through)):
            mesh = judged(
                lambda lines=lines: reference_fem.box_discretisation(
                    box, cells, "Q1", grading, through=(lines, ())
                )
            )
            assert mesh is None or all_finite(mesh.points)


@few
@given(place=st.tuples(number, number), depth=st.integers(-1, 60), rings=st.integers(0, 3))
def test_any_place_to_refine_towards(place, depth, rings):
    mesh = judged(lambda: meshed(towards=[(0.0, 1.0), place], depth=depth, rings=rings))
    assert mesh is None or all_finite(mesh.points)
    mesh = judged(lambda: meshed(towards=[(0.0, 1.0)], depth=depth, rings=rings))
    assert mesh is None or all_finite(mesh.points)


@few
@given(st.lists(number, min_size=1, max_size=4), st.lists(number, min_size=1, max_size=4))
def test_any_rows_compared(values, references):
    judged(lambda: farthest_value(values, references))
    order = judged(lambda: observed_order(values, references))
    assert order is None or isinstance(order, float)


@few
@given(st.lists(st.tuples(st.integers(-1, 4), number, number), max_size=6))
def test_any_rows_of_a_mesh(rows):
    clamp = [(0, 0, 0.0), (0, 1, 0.0), (1, 1, 0.0)]
    for fixed, forces in ((clamp, rows), ([*clamp, *rows], ())):
        u = judged(lambda fixed=fixed, forces=forces: fem(fixed=fixed, forces=forces))
        assert u is None or all_finite(u)
