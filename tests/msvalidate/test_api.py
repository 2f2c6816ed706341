"""High-level API: ten lines from a body to an animation, and first guesses."""

import textwrap

import numpy as np
import pytest
from matplotlib.layout_engine import ConstrainedLayoutEngine

import msvalidate as ms
import reference_fem
from msvalidate import studies
from msvalidate.bench.output import animation
from msvalidate.problem import Contact, Obstacle
from msvalidate.springs.bodies.calibrate import calibrate

BEAM = ms.Box(4, 1)
SOLID = ms.Isotropic(E=1e5, nu=0.3)
PROBLEM = ms.body(BEAM, SOLID, fixed="left", traction={"right": (0, -10)})
SIDE = BEAM.side("left")


@pytest.fixture(scope="module")
def network():
    return ms.build(PROBLEM, "square", cells=8)


@pytest.fixture(scope="module")
def elements():
    return ms.reference(PROBLEM, rtol=1e-3)


def test_ten_lines_from_a_body_to_an_animation(network, elements, tmp_path, monkeypatch):
    monkeypatch.setattr(animation, "MAX_SHOWN", 3)
    assert "volume energy" in str(network)
    springs = ms.solve(network)
    comparison = ms.compare(springs, elements)
    rows = {row.quantity: row for row in comparison.rows}
    # Timoshenko's cantilever: F L³/(3 E I) + F L/(κ G A), 2 % of it by the clamp's corners
    deflection = 10 * 4**3 / (3 * 1e5 / 12) + 10 * 4 / (5 / 6 * 1e5 / 2.6)
    assert rows["displacement"].wanted == pytest.approx(deflection, rel=0.03)
    assert rows["displacement"].word == "agrees"
    assert springs.energy == pytest.approx(0.5 * (springs.displacement * network.force).sum())
    assert elements.energy == pytest.approx(springs.energy, rel=0.05)
    assert elements.error < 1e-3
    text = str(comparison)
    assert "strain energy (J)" in text
    assert "<table" in comparison._repr_html_()
    assert comparison.table().loc[0, "springs"] == rows["displacement"].found
    legend = {text.get_text() for text in ms.plot(springs, elements).legends[0].get_texts()}
    assert {"springs", "elements", "undeformed"} <= legend
    large = ms.solve(network, geometry="nonlinear")
    assert 0 < np.abs(large.displacement - springs.displacement).max() < 1e-3
    layouts = []
    monkeypatch.setattr(ConstrainedLayoutEngine, "execute", lambda *_: layouts.append(1))
    saved = ms.animate(ms.relax(network, "algorithm1")).save(tmp_path / "relaxation.gif")
    assert len(layouts) == 1, "all frames have the axes of the first"
    assert saved.read_bytes()[:4] == b"GIF8"


def test_stress_of_a_bar_in_tension_is_uniform():
    bar = ms.body(
        ms.Box(0.37, 0.2),
        ms.Isotropic(E=210e9, nu=0.3, thickness=0.2),
        fixed={"left": (0, None), "bottom": (None, 0)},
        traction={"right": (1e6, 0)},
    )
    springs = ms.solve(ms.build(bar, spacing=0.01))
    assert springs.stress == pytest.approx(np.tile([1e6, 0, 0], (len(springs.stress), 1)), abs=1)
    assert ms.reference(bar).stress[0] == pytest.approx([1e6, 0, 0], abs=1)


@pytest.mark.parametrize(("geometry", "strain"), [("linear", 1e-9), ("nonlinear", 0.3)])
def test_energy_of_a_bar_at_any_strain(geometry, strain):
    pulled = {"left": (0, None), "bottom": (None, 0), "right": (strain, None)}
    bar = ms.body(ms.Box(1, 1), ms.Isotropic(E=1e5, nu=1 / 3), fixed=pulled)
    springs = ms.solve(ms.build(bar, cells=2), geometry)
    forces = springs.reaction[:, 0] * (springs.displacement[:, 0] != 0)
    work = [0.0]
    steps = np.linspace(0, strain, 33)[1:]
    for part in steps if geometry == "nonlinear" else ():
        each = ms.body(ms.Box(1, 1), bar.material, fixed=pulled | {"right": (float(part), None)})
        at = ms.solve(ms.build(each, cells=2), geometry)
        work.append(float(at.reaction[at.network.points[:, 0] == 1, 0].sum()))
    area = (
        np.trapezoid(work, [0.0, *steps]) if geometry == "nonlinear" else forces.sum() * strain / 2
    )
    assert springs.energy == pytest.approx(area, rel=1e-3)


def test_a_comparison_out_of_range_never_agrees():
    soft = ms.body(ms.Box(10, 1), ms.Isotropic(E=1e6, nu=0.3), fixed="left", gravity=(0, -300))
    comparison = ms.compare(ms.solve(ms.build(soft, cells=4)), ms.reference(soft))
    assert all(row.word != "agrees" for row in comparison.rows)
    assert any(each.kind in ("nonlinear", "unstable") for each in comparison.limitations)


def test_a_3d_body_has_a_solid_material_and_its_pictures():
    cube = ms.body(ms.Box(0.2, 0.2, 0.2), ms.Isotropic(1e5, 0.25), fixed="left", gravity=(0, 0, -9))
    assert cube.material.dim == 3
    network = ms.build(cube, cells=2)
    solved = ms.solve(network)
    moved = [0.5 * solved.displacement, solved.displacement]
    assert len(ms.animate(network, moved).gif) > 1000
    assert ms.plot(cube, network, solved).axes


STATE = ms.State(np.array(ms.square(BEAM, 2).points), np.zeros((27, 2)))
"""State of zero velocity."""


def two_across():
    return ms.build(PROBLEM, cells=2)


GUESSES = {
    "Box(4, 1)": lambda: ms.Box(4, 1) == ms.Box((4, 1)),
    "square(beam, 8)": lambda: len(ms.square(BEAM, 8).cells) == 8 * 32,
    "Support(name)": lambda: (
        ms.Problem(BEAM, SOLID, [ms.Support("left")]).supports[0].region == SIDE
    ),
    "Support(side)": lambda: ms.Support(SIDE).displacement == (0, 0),
    "Support(side, 0)": lambda: ms.Support(SIDE, 0).displacement == (0, 0),
    "one support": lambda: len(ms.Problem(BEAM, SOLID, ms.Support(SIDE)).supports) == 1,
    "list of supports": lambda: len(ms.Problem(BEAM, SOLID, [ms.Support(SIDE)]).supports) == 1,
    "equilibrium(problem)": lambda: ms.equilibrium(PROBLEM).energy > 0,
    "plot(lattice)": lambda: ms.plot(ms.square(BEAM, 2)),
    "eq.plot()": lambda: ms.equilibrium(two_across()).plot(),
    "solve_problem(problem)": reference_fem.solve_problem(PROBLEM).displacement.any,
    "motion by name": lambda: ms.motion(two_across(), STATE, "leapfrog", 1e-5, 1),
    "relax by name": ms.relax(two_across(), "fire").displacement.any,
    "lattice_network at any ratio": lambda: ms.lattice_network(PROBLEM, ms.square(BEAM, 2)).volumes,
}
"""First guess -> expression that is true if it works."""


@pytest.mark.parametrize("guess", GUESSES)
def test_a_first_guess_works(guess):
    assert GUESSES[guess]()


@pytest.mark.parametrize(
    ("guess", "error", "remedy"),
    [
        (ms.square, TypeError, "'box' and 'cells'"),
        (lambda: ms.square(4, 8), ms.ProblemError, "give a plane box, such as Box"),
        (lambda: ms.fem, AttributeError, "did you mean 'reference'"),
        (lambda: ms.equilibrium(two_across(), nonlinear=True), ms.ProblemError, "'nonlinear' for"),
        (lambda: ms.run("poison"), ms.ProblemError, "did you mean 'poisson'"),
        (lambda: ms.run("claims"), ms.ProblemError, "python -m msvalidate.study claims"),
        (ms.plot, ms.ProblemError, "nothing to plot"),
        (lambda: ms.plot(3), ms.ProblemError, r"plot\(network, equilibrium\)"),
        (lambda: ms.animate(two_across()), ms.ProblemError, r"animate\(network, states\)"),
        (lambda: ms.compare(ms.solve(PROBLEM), 3), ms.ProblemError, r"reference\(problem\)"),
        (lambda: ms.Problem(BEAM, SOLID, "left"), ms.ProblemError, "give a list of Support"),
        (
            lambda: ms.body(BEAM, SOLID, traction=("right", (0, 1))),
            ms.ProblemError,
            "a mapping, su",
        ),
        (lambda: ms.body(BEAM, SOLID, gravity=-9.81), ms.ProblemError, "weight"),
        (lambda: ms.body(BEAM, SOLID, fixed=3), ms.ProblemError, "give sides"),
        (lambda: ms.body(BEAM, SOLID, force={(4, 1): 3}), ms.ProblemError, "numbers each"),
        (lambda: ms.body((4, 1), SOLID, fixed="left"), ms.ProblemError, "give a Box"),
        (
            lambda: ms.solve(ms.body(BEAM, SOLID, gravity=(0, -9.81))),
            ms.ProblemError,
            "free: trans",
        ),
        (lambda: ms.animate(two_across(), [STATE], 0.0), ms.ProblemError, "magnification: 0.0"),
    ],
)
def test_another_guess_is_refused_with_the_right_call(guess, error, remedy):
    with pytest.raises(error, match=remedy):
        guess()


def test_a_study_runs_and_returns_its_tables(tmp_path, monkeypatch):
    source = """
        import pandas as pd
        from msvalidate import kit
        def run(candidate=None, setting=kit.FULL):
            table = pd.DataFrame({"cells": [1 if setting.quick else 9]})
            return kit.Evidence({"summary": table}, columns={"cells": "number"})
    """
    (tmp_path / "tiny_study.py").write_text(textwrap.dedent(source), encoding="utf-8")
    monkeypatch.setenv(studies.VARIABLE, str(tmp_path))
    assert [ms.run("tiny_study", quick=q).tables["summary"].iat[0, 0] for q in (True, False)] == [
        1,
        9,
    ]


def test_a_comparison_of_two_problems_is_refused(network):
    other = ms.body(BEAM, SOLID, fixed="left", traction={"right": (0, -20)})
    with pytest.raises(ms.ProblemError, match="two problems"):
        ms.compare(ms.solve(network), ms.reference(other, rtol=1e-2))
    again = ms.body(ms.Box(4, 1), SOLID, fixed="left", traction={"right": (0, -10)})
    assert ms.compare(ms.solve(network), ms.reference(again, rtol=1e-2)).rows


def test_a_network_without_a_body_has_no_stress():
    alone = ms.spring_network(
        [[0, 0], [1, 0], [0, 1]], [[0, 1], [1, 2], [2, 0]], 1.0, fixed=np.ones((3, 2), bool)
    )
    with pytest.raises(ms.ProblemError, match=r"build\(problem, lattice\)"):
        _ = ms.solve(alone).stress


def test_a_network_that_is_cut_shows_the_outline_of_its_body():
    arms = ms.Polygon(((0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)))
    clamped = {ms.Segment((0, 2), (0, 0)): (0, 0)}
    corner = ms.body(arms, SOLID, fixed=clamped, traction={ms.Segment((2, 0), (2, 1)): (0, -10)})
    network = ms.build(corner, spacing=0.3)
    assert "cut" in str(network)
    (axis,) = ms.plot(network, ms.solve(network)).axes
    (outline,) = [each for each in axis.collections if each.get_label() == "body"]
    drawn = np.concatenate(outline.get_segments())
    assert [drawn.min(), drawn.max()] == [0, 2]


def test_results_of_one_kind_have_their_own_labels(network):
    solved = ms.solve(network)
    legend = ms.plot(solved, solved).legends[0].get_texts()
    assert {"springs 1", "springs 2"} <= {text.get_text() for text in legend}
    legend = ms.plot(network, ms.relax(network, "fire")).legends[0].get_texts()
    assert [text.get_text() for text in legend].count("springs") == 1


def test_a_compared_case_is_a_table_in_a_notebook():
    comparison = ms.compare_case(ms.Case(PROBLEM, cells=4, quantities=("displacement",)))
    assert comparison.table()["quantity"].tolist() == ["displacement"]
    assert "<table" in comparison._repr_html_()


def test_a_large_linear_result_names_its_theory(network):
    assert "Linear theory" not in str(ms.solve(network))
    heavy = ms.body(BEAM, SOLID, fixed="left", traction={"right": (0, -1000)})
    assert "Linear theory" in str(ms.solve(ms.build(heavy, cells=4)))


def test_stress_of_a_body_of_two_materials_jumps_at_the_interface():
    stiff = ms.Zone(ms.Region(((0.5, 1.0), None)), ms.Isotropic(1e6, 1 / 3))
    pulled = {"left": (0, None), "bottom": (None, 0), "top": (None, 0), "right": (1e-3, None)}
    parts = ms.Problem(
        ms.Box(1, 1),
        ms.Isotropic(1e5, 1 / 3),
        [ms.Support(side, value) for side, value in pulled.items()],
        zones=stiff,
    )
    springs = ms.solve(ms.build(parts, cells=4))
    assert np.ptp(springs.stress[:, 0]) < 1e-9 * springs.stress[:, 0].max()


@pytest.mark.parametrize("k2", [0.25, 0.5, 2.0])
def test_a_square_lattice_has_its_ratio_along_the_axes(k2):
    solid = ms.homogenise(ms.patterns.square(), (1.0, k2))
    assert solid.nu == pytest.approx(k2 / (1 + k2))
    assert solid.zener == pytest.approx(2 * k2)


def test_a_relaxation_stores_its_frames(network):
    result = ms.relax(network, "algorithm1")
    assert next(iter(result.frames)) == 0
    assert list(result.frames)[-1] == result.steps
    assert np.array_equal(result.frames[result.steps], result.displacement)
    assert 2 < len(result.frames) <= 101


def test_a_calibrated_network_equals_one_by_lattice_network(network):
    lattice = ms.square(BEAM, 8)
    long = ms.lattice_network(PROBLEM, lattice, calibrate(1e5, 0.3, lattice))
    assert np.array_equal(network.stiffness, long.stiffness)
    assert np.array_equal(network.force, long.force)
    assert np.array_equal(ms.lattice_network(PROBLEM, lattice).stiffness, long.stiffness)


def pressed():
    """Return the problem of a block that a disc is pressed into."""
    block = ms.Box(0.4, 0.2)
    disc = Contact(block.side("top"), Obstacle("disc", (0.2, 0.2), (0, -1), 0.1), force=50.0)
    return ms.Problem(block, SOLID, ms.Support("bottom"), contacts=(disc,))


def test_elements_beside_an_obstacle_store_energy_and_motions_refuse_it():
    network, elements = ms.build(pressed(), cells=12), ms.reference(pressed(), rtol=1e-2)
    springs = ms.solve(network)
    work = 0.5 * (springs.displacement * springs.contact.load).sum()
    assert springs.energy == pytest.approx(work)
    assert elements.energy == pytest.approx(springs.energy, rel=0.05)
    with pytest.raises(ms.ProblemError, match=r"obstacle; take solve\(network\)"):
        ms.relax(network, "fire")


@pytest.mark.parametrize("geometry", ["linear", "nonlinear"])
def test_stress_of_zero_length_springs_on_irregular_mesh_edges(geometry):
    points = np.array([(x, y) for y in (0, 0.1, 0.2) for x in (0, 0.2, 0.37)])
    points[4] += (0.03, 0.02)
    corners = [(i, i + 1, i + 4, i + 3) for i in (0, 1, 3, 4)]
    triangles = [cell for a, b, c, d in corners for cell in ((a, b, c), (a, c, d))]
    ends = [ms.Segment((0, 0.2), (0, 0)), ms.Segment((0, 0), (0.37, 0))]
    bar = ms.body(
        ms.Mesh(points=points, cells=triangles, shape="triangle"),
        ms.Isotropic(210e9, 0.45, thickness=0.2),
        fixed={ends[0]: (0, None), ends[1]: (None, 0)},
        traction={ms.Segment((0.37, 0), (0.37, 0.2)): (1e3, 0)},
    )
    solved = ms.solve(ms.build(bar, "mesh edges", route="neo-Hookean"), geometry)
    assert solved.stress == pytest.approx(np.tile([1e3, 0, 0], (9, 1)), abs=1e-2)


def test_energy_of_prestressed_springs_is_that_of_the_nonlinear_state():
    fixed = np.array([[1, 1], [0, 0], [1, 1], [1, 1]], dtype=bool)
    network = ms.spring_network(
        [[0, 0], [1, 0], [2, 0], [1, 1]],
        [[0, 1], [1, 2], [1, 3]],
        [100.0, 100.0, 50.0],
        rest_length=[0.9, 0.9, 0.99999],  # the third pulls the free point out of balance
        fixed=fixed,
        force=~fixed * 1e-3,
    )
    at_rest = 0.5 * (100 * 0.1**2 * 2 + 50 * 1e-5**2)
    linear, large = (ms.solve(network, geometry).energy for geometry in ("linear", "nonlinear"))
    assert linear - at_rest == pytest.approx(large - at_rest, rel=1e-3)


def test_a_comparison_of_a_body_that_nothing_moves_is_refused():
    still = ms.body(BEAM, SOLID, fixed="left")
    with pytest.raises(ms.ProblemError, match="nothing moves"):
        ms.compare(ms.solve(ms.build(still, cells=2)), ms.reference(still))


def test_arrays_are_tuples_in_a_problem():
    one, other = (
        ms.body(
            BEAM, SOLID, fixed="left", traction={"right": np.array([0, -10])}, gravity=np.ones(2)
        )
        for _ in range(2)
    )
    assert one.loads == other.loads


def test_a_nonlinear_comparison_names_what_it_leaves_out(network, elements):
    large = ms.compare(ms.solve(network, "nonlinear"), elements)
    assert "Forces, energy and stress" in str(large)
    assert (
        "<p>1 &lt; 2</p>"
        in ms.compare(large.springs, elements)
        .__class__(**vars(large) | {"remarks": ("1 < 2",)})
        ._repr_html_()
    )
