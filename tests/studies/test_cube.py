"""The cube of the study `poisson`: its closed forms by hand, its elastic body, faults."""

from functools import partial

import numpy as np
import pytest
from msvalidate.studies.poisson import cube, cube_block, cube_layers, poisson_controls

import reference_fem
from msvalidate.bench.judging.candidate import solve_springs
from msvalidate.bench.judging.evidence import judge
from msvalidate.bench.judging.singularity import clamped_edge_exponent
from msvalidate.bench.judging.sweep import Setting
from msvalidate.bench.output import figures
from msvalidate.springs.network import faults
from msvalidate.studies import poisson
from reference_fem.richardson import extrapolate

QUICK = Setting(quick=True)


def ratio_of_layers(constants, cells):
    """By counting: springs of every direction in a cube of equal springs, strained uniformly.

    The strains (1, -nu, -nu) cost least: the energy of all springs, each alone, by its direction.
    """
    n = cells + 1
    count = {  # direction -> how many springs there are, which constant
        **dict.fromkeys(((1, 0, 0), (0, 1, 0), (0, 0, 1)), (n * n * cells, 0)),
        **{
            d: (n * cells * cells, 1)
            for a, b in ((0, 1), (0, 2), (1, 2))
            for s in (1, -1)
            for d in [tuple(1 if i == a else s if i == b else 0 for i in range(3))]
        },
        **{(1, s, t): (cells**3, 2) for s in (1, -1) for t in (1, -1)},
    }
    k = (*constants, 0.0)[:3]

    def energy(nu):
        total = 0.0
        for direction, (many, kind) in count.items():
            squares = np.square(direction)
            stretch = squares @ (1, -nu, -nu) / np.sqrt(squares.sum())
            total += many * k[kind] * stretch**2
        return total

    # A parabola in nu: its lowest point from three values.
    low, middle, high = energy(0.0), energy(0.5), energy(1.0)
    return 0.25 * (3 * low - 4 * middle + high) / (low - 2 * middle + high)


@pytest.mark.parametrize("constants", [(1.0, 1.0), (1.0, 2.0), (1.0, 1.0, 1.0)])
@pytest.mark.parametrize("cells", [1, 2, 7])
def test_layers_by_counting_springs(constants, cells):
    assert cube_layers.layers_ratio(constants, cells) == pytest.approx(
        ratio_of_layers(constants, cells), rel=1e-12
    )


@pytest.mark.parametrize("k2", [0.25, 1.0, 3.0])
def test_one_cell_of_cubic_18(k2):
    """k2/(2 k1 + 3 k2): the cell formula in space, for an isolated cell and summed cell by cell."""
    assert cube.one_cell(solve_springs, k2)["nu_springs"] == pytest.approx(
        k2 / (2 + 3 * k2), abs=1e-12
    )
    problem, network = cube_block.spring_cube("cubic 18", "per_cell", "traction", 3, (1.0, k2))
    nu = cube_block.ratio(network.points, solve_springs(problem, network))
    assert nu == pytest.approx(k2 / (2 + 3 * k2), abs=1e-12)


def test_equal_springs_tend_to_the_bulk_in_first_order():
    """With the slope of the layers: mean strain over a volume is what the faces move apart."""
    away = []
    for cells in (6, 12):
        problem, network = cube_block.spring_cube("cubic 18", "equal", "slide", cells)
        away.append(
            cells * (0.25 - cube_block.ratio(network.points, solve_springs(problem, network)))
        )
    assert away == pytest.approx([1 / 16, 1 / 16], rel=0.05)
    assert abs(away[1] - 1 / 16) < abs(away[0] - 1 / 16)


def test_work_of_layers_by_summing_over_springs():
    """What the faces alone tell is the virtual work of every spring on the strain along y."""
    _, network = cube_block.spring_cube("cubic 26", "equal", "slide", 3)
    move = np.random.default_rng(1).normal(size=network.points.shape) * 1e-3
    left, right = network.points[:, 0] == 0, network.points[:, 0] == 1
    move[left, 0], move[right, 0] = 0.0, cube_block.STRAIN
    a, b = network.springs.T
    along = network.points[b] - network.points[a]
    along /= np.linalg.norm(along, axis=1)[:, None]
    stretch = (along * (move[b] - move[a])).sum(axis=1)
    virtual = along[:, 1] * (network.points[b] - network.points[a])[:, 1]
    work = (network.stiffness * stretch * virtual).sum()
    m, E = 4 / 3, cube_block.STRAIN
    scale = 3 * 4 / 3 * (1 + 4 / 3 / m) * E  # spacing · N (N + 1) · (k2 + 4/3 k3/m) E
    seen = cube_layers.layers_work((1.0, 1.0, 1.0), 3, network.points, move)
    assert seen == pytest.approx(work / scale, rel=1e-9)


@pytest.mark.parametrize("loading", ["slide", "traction"])
def test_an_elastic_cube_has_the_tensors_ratio(loading):
    problem, network = cube_block.spring_cube("cubic 26", "shared", loading, 2)
    mesh = reference_fem.box_discretisation(cube_block.BOX, 3, "H1")
    move = reference_fem.solve_problem(problem, mesh).at(network.points)
    for lateral in cube_block.LATERAL:
        assert cube_block.ratio(network.points, move, lateral) == pytest.approx(0.35, abs=1e-9)
    assert cube_block.axial_strain(network.points, move) == pytest.approx(1e-3, rel=1e-9)


def test_an_eighth_stands_for_the_clamped_cube():
    """Folded out it is what the whole cube gives, on a mesh with the same elements."""
    problem, network = cube_block.spring_cube("cubic 18", "shared", "clamped", 4)
    mesh = reference_fem.box_discretisation(cube_block.BOX, 8, "H1")
    whole = reference_fem.solve_problem(problem, mesh).at(network.points)
    eighth = cube_block._clamped_eighth(problem.material.C)
    mesh = reference_fem.box_discretisation(cube_block.EIGHTH, 4, "H1")
    away = network.points - 0.5
    part = reference_fem.solve_problem(eighth, mesh).at(np.abs(away)) * np.where(away < 0, -1, 1)
    part[:, 0] += cube_block.STRAIN / 2  # the eighth counts from the cube's middle
    np.testing.assert_allclose(part, whole, atol=1e-9 * cube_block.STRAIN)


def test_clamped_reference_by_even_meshes_of_linear_elements():
    """Other elements, no grading, their limit by the exponent of the clamped edge."""
    problem, network = cube_block.spring_cube("cubic 18", "shared", "clamped", 2)
    eighth = cube_block._clamped_eighth(problem.material.C)
    away = network.points - 0.5

    def sampled(cells):
        mesh = reference_fem.box_discretisation(cube_block.EIGHTH, cells, "H1")
        move = reference_fem.solve_problem(eighth, mesh).at(np.abs(away))
        move *= np.where(away < 0, -1, 1)
        return [cube_block.ratio(network.points, move, at) for at in cube_block.LATERAL]

    limit, _ = extrapolate(sampled, 2, (2 * clamped_edge_exponent(problem.material.C), 2.0))
    fem = cube_block.clamped_reference("cubic 18", (2,))
    assert (np.abs(fem.value - limit) < fem.uncertainty).all()
    assert (fem.uncertainty < 1e-3).all()


def test_wrong_weights_in_space_are_equal_ones():
    """Springs that count 1/2 in faces and 1/4 on edges: both come to 1."""
    _, shared = cube_block.spring_cube("cubic 18", "shared", "slide", 3)
    _, equal = cube_block.spring_cube("cubic 18", "equal", "slide", 3)
    assert set(shared.stiffness) == {0.25, 0.5, 1.0}
    np.testing.assert_array_equal(faults.stiffen_boundary(shared, 1.0).stiffness, equal.stiffness)
    half = faults.stiffen_boundary(shared, 0.5).stiffness
    np.testing.assert_allclose(half, (shared.stiffness + equal.stiffness) / 2)


@pytest.mark.parametrize("fault", poisson.FAULTS)
def test_cubes_notice_faults(fault):
    verdict = judge(cube.run(poisson.FAULTS[fault]["candidate"], setting=QUICK))
    assert (verdict["verdict"] == "fail").any()


def test_a_fault_under_clamped_ends_alone_is_caught():
    """Against the elastic body: nothing else looks at the clamped cube."""

    def faulty(problem, network, answer):
        if problem.name.endswith("clamped"):
            network = faults.stiffen_boundary(network, 1.0)
        return solve_springs(problem, network, answer)

    verdict = judge(cube.run(faulty, QUICK)).set_index("quantity")["verdict"]
    failed = set(verdict.index[verdict == "fail"])
    assert failed == {"clamped cube, shared springs: difference to FEM times N"}


def test_a_small_fault_of_the_diagonals_is_caught():
    candidate = partial(poisson_controls.apply_fault, faults.stiffen_diagonals, 1e-7)
    row, stiff = cube.measure(candidate, ("cubic 18", "shared", "traction", 2))
    assert abs(row["nu_springs"] - 0.25) > 1e-9
    assert abs(stiff["modulus_ratio"] - 1) > 1e-9


def test_faces_of_a_grid_of_points():
    points = np.array([(x, y, z) for z in range(3) for y in range(3) for x in range(5)], float)
    faces = figures.box_faces(points * (0.5, 1.0, 2.0))
    assert len(faces) == 2 * (2 * 2 + 4 * 2 + 4 * 2)
    corners = points[faces]
    edges = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)
    np.testing.assert_array_equal(edges, 1.0)  # round each face, none crossed
    assert len(np.unique(np.sort(faces, axis=1), axis=0)) == len(faces)
