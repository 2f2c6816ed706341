"""A charged slab in air: charges, far boundary, forces at edges, response, moved meshes."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from msvalidate.dielectric.charges.exact import facing_strips_capacitance
from msvalidate.problem import Isotropic, ProblemError, SolverError, format_point
from reference_fem import (
    Electrode,
    Slab,
    facing_slab,
    move_air,
    respond,
    slab_mesh,
    solve_charges,
)
from reference_fem.electric import FAR
from reference_fem.mesh.elements import ELEMENTS, of_dimension
from tests.table import table

pytestmark = pytest.mark.filterwarnings("error")

ROUNDING = 1e-12
SOFT = Isotropic(1.0, 0.3, "plane_strain")

QUADRILATERALS = [name for name in of_dimension(2) if not ELEMENTS[name].simplex]


def lopsided():
    """Nothing in it is symmetric."""
    electrodes = (
        Electrode("top", 1.0, 2.5, 1.0),
        Electrode("bottom", 0.0, 3.5, -0.5),
        Electrode("top", 3.2, 4.0, 0.3),
    )
    return Slab(5.0, 1.0, electrodes, permittivity=3.0, air=1.0)


# --- the mesh -------------------------------------------------------------------------------------


@pytest.mark.parametrize("element", QUADRILATERALS)
def test_mesh_holds_the_slab_its_electrodes_and_its_tips(element):
    slab = lopsided()
    mesh = slab_mesh(slab, 8, element=element)
    x = mesh.body.points
    assert mesh.solid.points.min(axis=0) == pytest.approx([0, 0], abs=0)
    assert mesh.solid.points.max(axis=0) == pytest.approx([5, 1], abs=0)
    area = mesh.solid.basis.dx.sum()
    assert area == pytest.approx(5.0, rel=ROUNDING)
    assert set(mesh.permittivity) == {3.0, 1.0}
    for electrode, nodes in zip(slab.electrodes, mesh.conductors, strict=True):
        along = np.sort(x[nodes, 0])
        assert along[[0, -1]] == pytest.approx([electrode.start, electrode.end], abs=1e-12)
        assert (x[nodes, 1] == slab.level(electrode.side)).all()
    assert x[mesh.tips, 0] == pytest.approx([1, 2.5, 0, 3.5, 3.2, 4])
    assert (x[mesh.nodes[mesh.base], 1] == 0).all()
    assert np.abs(x[mesh.far]).max(axis=1).min() > 50
    assert np.unique(x[mesh.nodes[:, None], 1]).size == 8 * ELEMENTS[element].degree + 1


# --- charges --------------------------------------------------------------------------------------


def between_bounds(slab, layers, reach, element="Q2"):
    """Capacitance with the natural and with the floating far boundary (F/m)."""
    mesh = slab_mesh(slab, layers, element=element, reach=reach)
    return [solve_charges(mesh, (1.0, 0.0), far).totals[0] for far in FAR]


def test_far_boundaries_bracket_endless_air_and_fall_with_the_square():
    exact = facing_strips_capacitance(2.0)
    reach = np.array([10.0, 20.0])
    slab = facing_slab(2.0, 1.0)
    natural, floating = np.transpose([between_bounds(slab, 24, far) for far in reach])
    assert (natural < exact).all()
    assert (floating > exact).all()
    # Both errors go with the square of the box's size, which is the slab's and twice the reach.
    gap = floating - natural
    assert -np.diff(np.log(gap)) / np.diff(np.log(2 * reach + 1.5)) == pytest.approx(2.0, abs=0.05)
    # The mean is nearer by far.
    assert (np.abs(0.5 * (natural + floating) - exact) <= 0.05 * gap).all()


@pytest.mark.parametrize(("element", "order"), [("Q1", 2.0), ("Q2", 3.0)])  # or twice the grading
def test_capacitance_of_facing_strips_is_reached_at_its_order(element, order):
    means = [np.mean(between_bounds(facing_slab(2.0, 1.0), n, None, element)) for n in (8, 16, 32)]
    first, last = np.diff(means)
    assert np.log2(first / last) == pytest.approx(order, abs=0.3)
    assert means[2] + last / (2**order - 1) == pytest.approx(
        facing_strips_capacitance(2.0), rel=1e-3
    )


def test_charges_of_several_electrodes_are_neutral_and_store_the_energy():
    found = solve_charges(slab_mesh(lopsided(), 8))
    assert abs(found.totals.sum()) <= 1e-9 * np.abs(found.totals).max()
    assert found.energy == pytest.approx(0.5 * found.totals @ found.voltages, rel=1e-9)
    raised = solve_charges(found.mesh, np.array(found.voltages) + 2.0)
    assert raised.totals == pytest.approx(found.totals, rel=1e-7)
    doubled = solve_charges(found.mesh, 2 * found.voltages)
    assert doubled.forces == pytest.approx(4 * found.forces, abs=1e-9 * np.abs(found.forces).max())


# --- forces at edges ------------------------------------------------------------------------------


def tip_force(ratio):
    """In-plane pull on half of one of two facing strips at 1 V, gap 1: a quarter of dC/dw.

    A plane electrode is pulled along itself at its two tips alone, so widening both strips by dw
    works 4·F·dw/2 = dW = dC/2.
    """
    step = 1e-4
    change = facing_strips_capacitance(ratio + step) - facing_strips_capacitance(ratio - step)
    return change / (2 * step) / 4


def pull_on_corner(mesh, force):
    """Pull along x on the quarter of the slab that holds the right tip of the top electrode."""
    x, y = mesh.body.points[mesh.nodes].T
    return force[(x > 0.5 * mesh.slab.length) & (y > 0.5 * mesh.slab.height), 0].sum()


def test_carried_forces_hold_the_whole_pull_of_a_tip():
    mesh = slab_mesh(facing_slab(6.0, 1.0), 16)
    pull = pull_on_corner(mesh, solve_charges(mesh).forces)
    assert pull == pytest.approx(tip_force(6.0), rel=2e-3)


def test_net_force_on_a_closed_body_is_nothing():
    # In one medium a slab with its electrodes is closed: what pulls on it is the far boundary, as
    # little as the field there. Forces that are lost at tips would show.
    electrodes = lopsided().electrodes
    found = solve_charges(slab_mesh(Slab(5.0, 1.0, electrodes), 16))
    size = np.abs(found.forces).sum()
    assert np.abs(found.forces.sum(axis=0)).max() <= 1e-5 * size


@pytest.mark.parametrize("strained", [0.0, 0.05])
def test_carried_forces_are_derivatives_of_the_energy(strained):
    # In what the slab is displaced by, from where it was meshed and from where it has been moved.
    mesh = slab_mesh(lopsided(), 8, grading=1.5)
    x, y = mesh.body.points[mesh.nodes].T
    shape = np.column_stack([np.sin(2 * x + y), np.cos(x) * y])
    before = strained * np.column_stack([y * np.cos(2 * x), np.sin(x - y)])
    step = 1e-4
    up, down = (solve_charges(move_air(mesh, before + s * step * shape)).energy for s in (1, -1))
    found = solve_charges(move_air(mesh, before))
    work = (mesh.carried(found.solution.forces) * shape).sum()
    assert abs(work) > 0.1
    assert (up - down) / (2 * step) == pytest.approx(work, rel=1e-6)


# --- moved meshes ---------------------------------------------------------------------------------


def test_squeezed_slab_has_the_capacitance_of_a_flatter_one():
    slab = facing_slab(3.0, 1.0, permittivity=2.0)
    mesh = slab_mesh(slab, 16, grading=1.5)
    u = np.zeros((len(mesh.nodes), 2))
    u[:, 1] = -0.2 * mesh.body.points[mesh.nodes, 1]
    moved = move_air(mesh, u)
    assert np.abs(moved.body.points[mesh.far] - mesh.body.points[mesh.far]).max() == 0
    assert np.ptp(moved.solid.points[:, 1]) == pytest.approx(0.8)
    flat = solve_charges(slab_mesh(facing_slab(3.0, 0.8, permittivity=2.0), 16))
    assert solve_charges(moved).totals[0] == pytest.approx(flat.totals[0], rel=3e-3)


@table("part", ["slab", "air"])
def test_a_cell_turned_inside_out_is_refused(part):
    mesh = slab_mesh(facing_slab(3.0, 1.0), 4, element="Q1")
    u = np.zeros((len(mesh.nodes), 2))
    top = mesh.body.points[mesh.nodes, 1] == 1.0
    if part == "slab":
        u[top, 1] = -2.0
    else:
        u[:, 1] = 100.0  # through the far boundary
    with pytest.raises(SolverError, match=f"turns the cell of the {part} around") as caught:
        move_air(mesh, u)
    assert "\n" not in str(caught.value)


def test_a_folded_cell_is_named_by_its_place():
    # All its corners are right angles still.
    mesh = slab_mesh(facing_slab(3.0, 1.0), 4)
    u, cells = np.zeros((len(mesh.nodes), 2)), mesh.solid.cells
    middle = mesh.solid.points[cells[:, 8]]
    wanted = int(np.linalg.norm(middle - (1.5, 0.3), axis=1).argmin())
    u[cells[wanted, 8]] = 0.4 * np.ptp(mesh.solid.points[cells[wanted]], axis=0)
    where = mesh.solid.points[cells[wanted, :4]].mean(axis=0)
    with pytest.raises(SolverError, match="turns the cell of the slab around") as caught:
        move_air(mesh, u)
    assert format_point(where) in str(caught.value)


# --- elastic response -----------------------------------------------------------------------------


def test_wide_slab_is_squeezed_as_an_oedometer():
    # Far from its ends: u = -h·½εE²/C22, C22 = E(1 - nu)/((1 + nu)(1 - 2nu)).
    # The field above the electrode takes a ten-thousandth off, ends reach in as exp(-0.9 x/h).
    slab = facing_slab(20.0, 1.0, 0.1, permittivity=3.0)
    mesh = slab_mesh(slab, 8)
    moved = respond(mesh, solve_charges(mesh).forces, SOFT).at([[10, 1.0], [10, 0.5], [10, 0.0]])
    modulus = 0.7 / (1.3 * 0.4)
    assert moved[0, 1] == pytest.approx(-0.5 * 3.0 * 0.1**2 / modulus, rel=5e-4)
    assert moved[1, 1] == pytest.approx(0.5 * moved[0, 1], rel=5e-4)
    assert np.abs(moved[:, 0]).max() <= 1e-3 * abs(moved[0, 1])
    assert (moved[2] == 0).all()


def test_depth_is_the_materials_thickness():
    mesh = slab_mesh(facing_slab(2.0, 1.0), 4)
    forces = solve_charges(mesh).forces
    thin, thick = (
        respond(mesh, forces, Isotropic(2.0, 0.2, "plane_stress", thickness=t)).displacement
        for t in (0.1, 3.0)
    )
    assert np.abs(thin - thick).max() <= 1e-11 * np.abs(thin).max()


# --- bad input ------------------------------------------------------------------------------------

BOTTOM = Electrode("bottom", 0.0, 1.0, 0.0)


@table(("ask", "words"), [
    (lambda: facing_slab(1.0, 0.0), "slab height, the gap between electrodes: 0.0 m"),
    (lambda: facing_slab(np.nan, 1.0), "nan"),
    (lambda: facing_slab(1.0, 1.0, covered=1.5), "covered part: 1.5; give at most 1"),
    (lambda: facing_slab(1.0, 1.0, covered=0.0), "covered part: 0.0"),
    (lambda: facing_slab(1.0, 1.0, np.inf), "voltage: inf"),
    (lambda: facing_slab(1.0, 1.0, permittivity=-3.0), "permittivity of the slab: -3.0 F/m"),
    (lambda: facing_slab(1.0, 1.0, air=0.0), "permittivity of the air: 0.0 F/m"),
    (lambda: Electrode("left", 0.0, 1.0, 0.0), "electrode on 'left': not on the slab's surf"),
    (lambda: Electrode("top", 1.0, 1.0, 0.0), "it must end after it starts"),
    (lambda: Slab(1.0, 1.0, (BOTTOM, Electrode("top", 0.5, 1.5, 1.0))),
        "electrode 1: from 0.5 to 1.5 m is not on the slab's surface"),
    (lambda: Slab(1.0, 1.0, (BOTTOM, Electrode("top", 0.5, 0.5 + 1e-13, 1.0))),
        "electrode 1: 1e-13 m long, too short to tell its ends apart"),
    (lambda: Slab(1.0, 1.0, (BOTTOM,)), "give a tuple of two or more"),
    (lambda: Slab(2.0, 1.0, (BOTTOM, Electrode("bottom", 1.0, 2.0, 1.0))),
        "electrodes 0 and 1 touch at x = 1 m on the bottom; leave a gap"),
    (lambda: slab_mesh(facing_slab(1.0, 1.0), 7), "layers: 7; give an even number"),
    (lambda: slab_mesh(facing_slab(1.0, 1.0), 8, element="P2"), "element: 'P2'"),
    (lambda: slab_mesh(facing_slab(1.0, 1.0), 8, grading=0.5), "mesh grading: 0.5"),
    (lambda: slab_mesh(facing_slab(1.0, 1.0), 8, grading=30.0), "take less grading"),
    (lambda: slab_mesh(facing_slab(1.0, 1.0), 8, reach=-0.5), "-0.5 m .* is inside the slab"),
    (lambda: slab_mesh(facing_slab(1.0, 1.0), 8, reach=0.5), "too near; give several"),
    (lambda: slab_mesh(facing_slab(1.0, 1.0), 6000, grading=1.0), "take fewer"),
    (lambda: slab_mesh(facing_slab(1e9, 1.0), 8), "take fewer"),
])  # fmt: skip
def test_bad_input_gets_a_clear_line(ask, words):
    with pytest.raises(ProblemError, match=words) as caught:
        ask()
    assert "\n" not in str(caught.value)


def test_what_does_not_fit_a_mesh_is_refused():
    mesh = slab_mesh(facing_slab(1.0, 1.0), 4, element="Q1")
    with pytest.raises(ProblemError, match=r"voltages: shape \(3,\); give \(2,\)"):
        solve_charges(mesh, (1.0, 2.0, 3.0))
    with pytest.raises(ProblemError, match="far boundary: 'open'; choose natural or floating"):
        solve_charges(mesh, far="open")
    with pytest.raises(ProblemError, match=r"forces on all nodes: shape \(3, 2\); give \("):
        mesh.carried(np.zeros((3, 2)))
    with pytest.raises(ProblemError, match="force: shape"):
        respond(mesh, np.zeros((3, 2)), SOFT)
    with pytest.raises(ProblemError, match="displacement of the slab: shape"):
        move_air(mesh, np.zeros((3, 2)))
    with pytest.raises(ProblemError, match="displacement of the slab: nan"):
        move_air(mesh, np.full((len(mesh.nodes), 2), np.nan))


number = st.one_of(st.floats(-10, 10), st.floats(), st.integers(-3, 3))


@settings(deadline=None, max_examples=60)
@given(number, number, number, number, number, st.sampled_from(QUADRILATERALS))
def test_any_slab_is_refused_or_has_finite_charges(length, height, voltage, covered, ratio, kind):
    found, said = None, ""
    try:
        slab = facing_slab(length, height, voltage, covered=covered, permittivity=ratio)
        found = solve_charges(slab_mesh(slab, 2, element=kind))
    except (ProblemError, SolverError) as error:
        said = str(error)
    assert "\n" not in said
    if found is not None:
        assert np.isfinite(found.totals).all()
        assert abs(found.totals.sum()) <= 1e-6 * np.abs(found.totals).max()
