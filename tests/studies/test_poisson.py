"""The study `poisson`: its controls, its reference."""

from functools import partial
from itertools import combinations

import numpy as np
import pytest
from msvalidate.studies.poisson import (
    algorithm1,
    block,
    elastic_block,
    finite_size,
    poisson_controls,
    rotated,
)

import reference_fem
from msvalidate.bench.judging.candidate import solve_springs
from msvalidate.bench.judging.evidence import judge
from msvalidate.bench.judging.sweep import Setting
from msvalidate.springs.constants.stiffness import square_tensor
from msvalidate.springs.network import faults
from msvalidate.studies import poisson

QUICK = Setting(quick=True)


def test_reference_in_the_candidates_place_has_no_error():
    found = finite_size.run(candidate=block.finite_elements, setting=QUICK)
    table = found.tables["finite_size"]
    uniform = table["loading"] != "clamped"
    difference = np.abs(table["nu_springs"] - table["nu_fem"])
    assert difference[uniform].max() < 1e-9, "uniform strain is exact on every mesh"
    assert difference[~uniform].max() < elastic_block.REFERENCE_ERROR, "a coarser mesh of its own"


@pytest.mark.parametrize("name", poisson_controls.FAULTS)
def test_stated_resolution_is_the_real_one(name):
    noticed = poisson_controls.smallest(name)["smallest_noticed"]

    def largest(size):
        faulty = partial(poisson_controls.apply_fault, poisson_controls.FAULTS[name][0], size)
        return max(poisson_controls.identities(faulty).values())

    assert largest(1.1 * noticed) > finite_size.IDENTITY
    assert largest(0.9 * noticed) < finite_size.IDENTITY


@pytest.mark.parametrize(
    "fault",
    [
        pytest.param(name, marks=[] if name.startswith("diagonals") else [pytest.mark.slow])
        for name in poisson.FAULTS
    ],
)
def test_faults_are_caught_by_physics(fault):
    """By an identity or the finite elements, not by a remembered number."""
    verdict = judge(finite_size.run(poisson.FAULTS[fault]["candidate"], setting=QUICK))
    failed = set(verdict[verdict["verdict"] == "fail"]["quantity"])
    assert failed & {
        "shared springs: k2/(k1+k2)",
        "uniform strain: springs against FEM",
        "modulus of shared springs against FEM, relative",
    }


def test_a_relaxation_that_stops_early_is_caught():
    early = partial(algorithm1.algorithm1, tolerance=1e-4)
    verdict = judge(algorithm1.run(relaxation=early, setting=QUICK))
    assert (verdict["verdict"] == "fail").any()


def test_definitions_of_the_ratio():
    """Affine strain has one ratio by any definition; a bulge is seen at the middle only."""
    x = block.lattice.square(block.BOX, 5).points
    affine = np.column_stack([0.01 * x[:, 0], -0.003 * x[:, 1]])
    bulge = affine.copy()
    half = np.abs(x[:, 0] - 0.5) < 0.11
    bulge[half & (x[:, 1] == 1), 1] += 0.001
    for definition in block.DEFINITIONS:
        assert block.ratio(x, affine, definition) == pytest.approx(0.3, abs=1e-12)
    assert block.ratio(x, bulge, "middle") == pytest.approx(0.2, abs=1e-12)
    assert block.ratio(x, bulge, "edges") == pytest.approx(0.3 - 0.1 * 2 / 6, abs=1e-12)


@pytest.mark.parametrize("body", [0.2, 2 / 3])
def test_the_clamped_quarter_is_the_whole_block(body):
    """The same mesh, folded: equal to rounding."""
    points = block.edge_points(block.lattice.square(block.BOX, 5).points)
    tensor = square_tensor(1 - body, body)
    quarter = elastic_block.Sampler.of("clamped", points, 12).displacement(tensor)
    mesh = reference_fem.box_discretisation(block.BOX, 12, "Q2", block.GRADING)
    whole = reference_fem.solve_problem(block.loaded_block("clamped", tensor), mesh).at(points)
    middle = [block.STRAIN / 2, 0.0]  # displacement of the block's middle
    assert np.abs(whole - middle - quarter).max() < 1e-12 * block.STRAIN


def ratio_by_hand(n, k2):
    """Of a block at 45 degrees, n squares a side, n odd: from the points of Z x Z.

    (p, q) = (i - j, i + j) turns the point (i, j) by 45 degrees and makes everything √2 larger.
    Springs are told apart by their length; along the block's edges they count half.
    """
    reach = range(2 * n + 1)
    points = np.array([(p, q) for p in reach for q in reach if (p - q) % 2 == 0])
    stiffness = np.zeros((len(points), 2, len(points), 2))
    for a, b in combinations(range(len(points)), 2):
        along = points[b] - points[a]
        squared = along @ along
        if squared not in {2, 4}:
            continue
        straight = points[a][along == 0]  # the coordinate that does not change, if there is one
        k = (1.0 if squared == 2 else k2) * (0.5 if set(straight) & {0, 2 * n} else 1.0)
        spring = k * np.outer(along, along) / squared
        for at, other, sign in ((a, a, 1), (b, b, 1), (a, b, -1), (b, a, -1)):
            stiffness[at, :, other, :] += sign * spring
    x, y = points.T
    left, right, bottom, top = x == 0, x == 2 * n, y == 0, y == 2 * n
    force = np.zeros(points.shape)
    force[:, 0] = (right * 1.0 - left) * np.where(bottom | top, 0.5, 1.0)
    # Rigid motions cost no energy and change neither strain: any of the solutions will do.
    square = stiffness.reshape(force.size, force.size)
    u, v = np.linalg.lstsq(square, force.ravel(), rcond=1e-10)[0].reshape(-1, 2).T
    middle = np.abs(x - n) == 1
    lateral = v[middle & top].mean() - v[middle & bottom].mean()
    return -lateral / (u[right].mean() - u[left].mean())


def test_a_block_at_45_degrees_by_hand():
    row = rotated.measure(solve_springs, ("square", 2.0, 45, 5))
    assert row["nu_springs"] == pytest.approx(ratio_by_hand(5, 2.0), abs=1e-12)


def test_triangles_are_linear_elements():
    """A triangle of springs is the linear element at nu = 1/3, so both give the same block."""

    def elements(problem, network, _):
        side = network.rest_length.min()
        mesh = reference_fem.polygon_discretisation(problem.domain, side, "P1")
        return reference_fem.solve_problem(problem, mesh).at(network.points)

    for cells in (5, 10):  # half the strips odd, even
        case = ("triangular", 0.0, 90, cells)
        network, fem = (rotated.measure(c, case)["nu_springs"] for c in (solve_springs, elements))
        assert network == pytest.approx(fem, abs=1e-9)


def test_an_elastic_block_has_no_direction_of_its_lattice():
    """The tensor's ratio at any angle and size: what the springs lack is in the cut."""
    for degrees, cells in ((0, 5), (45, 5), (45, 10)):
        row = rotated.measure(block.finite_elements, ("square", 2.0, degrees, cells))
        assert row["nu_springs"] == pytest.approx(row["nu_tensor"], abs=1e-9)
    case = ("triangular", 0.0, 90, 5)
    solid, network = (rotated.measure(c, case) for c in (block.finite_elements, solve_springs))
    assert solid["nu_springs"] < network["nu_springs"] < 1 / 3, (
        "a zigzag edge is no lattice's fault"
    )


@pytest.mark.parametrize("fault", [*poisson.FAULTS][1:])
def test_rotated_blocks_notice_faults(fault):
    """All but the first: a ratio does not change when every spring is stiffer alike."""
    verdict = judge(rotated.run(poisson.FAULTS[fault]["candidate"], setting=QUICK))
    assert (verdict["verdict"] == "fail").any()


def test_a_fault_of_the_cut_blocks_alone_is_caught():
    """By the order: towards another ratio than the tensor's there is none."""

    def faulty(problem, network, answer):
        aligned = np.ptp(network.points[network.springs[0], 1]) == 0
        spoilt = network if aligned else faults.stiffen_diagonals(network, 0.02)
        return solve_springs(problem, spoilt, answer)

    verdict = judge(rotated.run(faulty, QUICK)).set_index("quantity")["verdict"]
    assert verdict["square at 0 degrees: the tensor's ratio"] == "pass"
    assert verdict["cut blocks: order in 1/N towards the tensor"] == "fail"
