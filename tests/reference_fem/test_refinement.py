"""Refinement: is the true error below the uncertainty, on sequences whose limit is known?"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import reference_fem
from msvalidate.problem import (
    BodyForce,
    Box,
    Isotropic,
    Problem,
    ProblemError,
    Region,
    SolverError,
    Support,
    Traction,
)
from reference_fem.mesh.elements import ELEMENTS, of_dimension
from reference_fem.refinement import SAFETY, TRUSTED_ORDER, refine, richardson
from tests.table import table

# A division by a change of zero must not warn.
pytestmark = pytest.mark.filterwarnings("error")

HIGHEST = 4.5
"""Twice the degree of a quadratic element, with room for scatter: the default of `refine`."""


def three(sequence, cells=8):
    """Estimate from cells, 2 cells and 4 cells per side."""
    values = [np.atleast_1d(np.asarray(sequence(n), dtype=float)) for n in (cells, 2 * cells)]
    return richardson(*values, np.atleast_1d(sequence(4 * cells)), 4 * cells, HIGHEST)


def power(limit, factor, order):
    return lambda n: limit + factor * float(n) ** -order


# --- three meshes ---------------------------------------------------------------------------------


@settings(deadline=None)  # a busy machine is no failure
@given(
    limit=st.floats(-10, 10),
    factor=st.sampled_from([-3.0, -0.1, 0.1, 3.0]),
    order=st.floats(0.55, 4.4),
)
def test_order_of_a_pure_power_is_recovered(limit, factor, order):
    estimate = three(power(limit, factor, order))
    assert estimate.status == ("asymptotic",)
    # Changes of 1e-7 and more on values of 10 are known to 2e-8 of themselves.
    assert estimate.order == pytest.approx([order], abs=1e-6)
    error = abs(estimate.value - limit)
    # Richardson's error where the order is below the trusted one, never less than a third of the
    # change before the last.
    believed = SAFETY * error * max(1.0, (2**order - 1) / (2**TRUSTED_ORDER - 1))
    before = error * (4**order - 2**order)
    assert estimate.uncertainty == pytest.approx(np.maximum(believed, before / 3), rel=1e-5)
    assert estimate.cells == 32


@settings(deadline=None)
@given(
    limit=st.floats(-10, 10),
    factor=st.sampled_from([-1.0, 1.0]),
    order=st.floats(0.6, 4.0),
    bend=st.floats(-1.0, 0.5),
)
def test_true_error_is_below_the_uncertainty(limit, factor, order, bend):
    # A second term, one order higher, up to an eighth of the first on the coarsest mesh: as much as
    # the safety factor of 1.25 can cover where it makes the order look better than it is.
    estimate = three(lambda n: limit + factor * (n**-order + bend * n ** -(order + 1)), cells=4)
    assert (np.abs(estimate.value - limit) <= estimate.uncertainty).all()


@pytest.mark.parametrize("order", [0.7, 1.0, 2.0, 4.0])
@pytest.mark.parametrize("cells", [4, 5])
def test_oscillation_is_not_asymptotic_and_is_covered(order, cells):
    # Signs alternate from mesh to mesh, so that no order can be read off them.
    estimate = three(lambda n: 1 + (-1) ** round(np.log2(n / cells)) * n**-order, cells)
    assert estimate.status == ("not asymptotic",)
    assert np.isnan(estimate.order).all()
    assert estimate.uncertainty > np.abs(estimate.value - 1)


@pytest.mark.parametrize("order", [4.6, 6.0, 10.0])
def test_order_too_good_to_be_true_is_not_believed(order):
    estimate = three(power(1.0, 1.0, order), cells=2)
    assert estimate.status == ("not asymptotic",)
    first = 2.0**-order * (1 - 2.0**-order)
    assert estimate.uncertainty == pytest.approx([first], rel=1e-6)
    assert estimate.uncertainty > 10 * np.abs(estimate.value - 1)


def test_orders_of_one_and_two_together_are_covered_on_coarse_meshes():
    # 1/n + 1/n² on 2, 4 and 8 cells shows an order of 1.3; what is left at 8 is 1/8 + 1/64. By one
    # order alone it would be 0.104, with the safety 0.130.
    estimate = three(lambda n: 1 / n + 1 / n**2, 2)
    assert 1 < estimate.order[0] < 2
    assert estimate.uncertainty == pytest.approx([SAFETY * (1 / 8 + 1 / 64)], rel=1e-12)


@pytest.mark.parametrize("nu", [0.49, 0.4999])
def test_a_nearly_incompressible_body_on_coarse_meshes_is_covered(nu):
    box = Box((0.37, 0.37))
    problem = Problem(
        box,
        Isotropic(1e6, nu, "plane_strain", thickness=0.2),
        (Support(box.side("left"), (0.0, 0.0)),),
        (Traction(box.side("right"), (0.3, 1.0)),),
    )

    def tip(cells, element="P2", mixed=False):
        mesh = reference_fem.box_discretisation(box, cells, element)
        return reference_fem.solve_problem(problem, mesh, mixed=mixed).at([box.size])[0]

    # Mixed elements do not lock: the limit of 6, 12 and 24 cells as of a geometric series.
    coarse, medium, fine = (tip(n, "Q2", mixed=True) for n in (6, 12, 24))
    limit = fine + (fine - medium) ** 2 / (2 * medium - coarse - fine)
    found = three(tip, 2)
    assert (np.abs(found.value - limit) <= found.uncertainty).all()


def test_highest_order_is_the_callers():
    values = [np.array([1 + n**-3.0]) for n in (4, 8, 16)]
    assert richardson(*values, 16, 3.1).status == ("asymptotic",)
    assert richardson(*values, 16, 2.9).status == ("not asymptotic",)


@pytest.mark.parametrize("limit", [1.0, -1e6, 1e-6])
def test_rounding_is_called_exact(limit):
    estimate = three(lambda n: limit * (1 + 1e-14 * np.sin(37 * n)))
    assert estimate.status == ("exact",)
    assert np.isnan(estimate.order).all()
    assert (estimate.uncertainty >= np.abs(estimate.value - limit) / 2).all()
    assert (estimate.uncertainty <= 1e-13 * abs(limit)).all()


def test_constant_is_exact_zero_included():
    for value in (0.0, 3.5):
        estimate = three(lambda n, value=value: value)  # noqa: ARG005  no mesh changes it
        assert estimate.status == ("exact",)
        np.testing.assert_array_equal(estimate.uncertainty, 0)


def test_small_change_above_rounding_is_not_exact():
    estimate = three(lambda n: 1 + 1e-9 * n**-1.0)
    assert estimate.status == ("asymptotic",)


# --- refinement -----------------------------------------------------------------------------------


class Counted:
    """A sequence that remembers for which meshes it was asked."""

    def __init__(self, sequence):
        self.sequence, self.asked = sequence, []

    def __call__(self, cells):
        self.asked.append(cells)
        return np.atleast_1d(self.sequence(cells))


def test_every_value_must_meet_the_tolerance():
    estimate = refine(lambda n: np.array([n**-4.0, n**-1.0]), 2, 0.01)
    assert (estimate.uncertainty <= 0.01).all()
    assert estimate.cells == 128


@pytest.mark.parametrize(
    "sequence",
    [power(1.0, 1.0, 0.6), lambda n: (-1.0) ** round(np.log2(n)), float],
    ids=["too slow", "oscillates", "diverges"],
)
def test_not_converged_by_the_finest_is_a_solver_error(sequence):
    quantity = Counted(sequence)
    with pytest.raises(SolverError, match=r"not converged: uncertainty .* at 64 cells, wanted"):
        refine(quantity, 4, 1e-3, finest=100)
    assert quantity.asked == [4, 8, 16, 32, 64]


@table(
    ("arguments", "fragment"),
    [
        ({"tolerance": 0.0}, "tolerance: 0.0; it must be above zero"),
        ({"tolerance": -1.0}, "tolerance"),
        ({"tolerance": float("nan")}, "tolerance: nan"),
        ({"coarsest": 0}, "coarsest: 0; give a whole number, 1 or more"),
        ({"finest": 7}, "from 2 cells to 7; leave room for three"),
    ],
)
def test_bad_arguments_are_named(arguments, fragment):
    with pytest.raises(ProblemError, match=fragment):
        refine(
            **({"quantity": lambda n: np.ones(1) / n, "coarsest": 2, "tolerance": 1} | arguments)
        )


@pytest.mark.parametrize("value", [np.nan, np.inf])
@pytest.mark.parametrize("mesh", [2, 8, 16])
def test_value_that_is_not_finite_is_never_a_result(value, mesh):
    with pytest.raises(SolverError, match=f"not a finite number on the mesh of {mesh} cells"):
        refine(lambda n: np.array([value if n == mesh else n**-1.0]), 2, 1e-2)


# --- real bodies ----------------------------------------------------------------------------------

BOX = Box((1.0, 1.0))


WAVE, AMPLITUDE = np.array([2.1, -1.3]), np.array([1.0, 0.6])


def smooth(x):
    """Displacement: a plane wave, one that no grid is aligned with."""
    return np.sin(x @ WAVE + 0.4)[:, None] * AMPLITUDE


def smooth_body():
    """The problem whose answer is `smooth`, by Navier's equation in plane stress."""
    E, nu = 1.0, 0.3
    lam, mu = E * nu / (1 - nu**2), E / (2 * (1 + nu))
    force = mu * WAVE @ WAVE * AMPLITUDE + (lam + mu) * WAVE * (WAVE @ AMPLITUDE)
    fields = (lambda x: smooth(x)[:, 0], lambda x: smooth(x)[:, 1])
    supports = tuple(Support(BOX.side(side), fields) for side in ("left", "right", "bottom", "top"))
    load = BodyForce(lambda x: np.sin(x @ WAVE + 0.4)[:, None] * force)
    return Problem(BOX, Isotropic(E, nu), supports, (load,))


@pytest.mark.parametrize("element", of_dimension(2))
def test_error_of_a_smooth_body_is_covered(element):
    # At nodes of the coarsest mesh, which every finer one keeps: each error is a smooth function of
    # the spacing there.
    line = np.array([0.25, 0.5, 0.75])
    places = np.stack(np.meshgrid(line, line), axis=-1).reshape(-1, 2)
    exact = smooth(places).ravel()

    def sampled(cells):
        body = reference_fem.box_discretisation(BOX, cells, element)
        return reference_fem.solve_problem(smooth_body(), body).at(places).ravel()

    estimate = refine(sampled, 16, {1: 1e-2, 2: 1e-5}[ELEMENTS[element].degree])
    assert estimate.status == ("asymptotic",) * len(exact)
    # Nodes converge by twice the degree; the two that happen to lie near a zero of the error's
    # first term come within 0.2 on these meshes, all others within 0.03.
    assert estimate.order == pytest.approx(
        np.full(len(exact), 2.0 * ELEMENTS[element].degree), abs=0.2
    )
    assert (np.abs(estimate.value - exact) <= estimate.uncertainty).all()
    # Not by luck: the price of caution is a factor of about 4 at order 2, 16 times 5 at order 4.
    price = {1: 10, 2: 100}[ELEMENTS[element].degree]
    assert (np.abs(estimate.value - exact) >= estimate.uncertainty / price).all()


BEAM = Box((4.0, 1.0))
TIP = -267.1394
"""Deflection (m) of the middle of a cantilever's end: two gradings, 64 cells, agree to 3e-6."""


@pytest.mark.parametrize("grading", [1.0, 2.0, 3.0])
def test_error_of_a_body_with_singular_corners_is_covered(grading):
    problem = Problem(
        BEAM,
        Isotropic(1.0, 1 / 3),
        (Support(BEAM.side("left"), (0.0, 0.0)),),
        (Traction(BEAM.side("right"), (0.0, -1.0)),),
    )

    def tip(cells):
        body = reference_fem.box_discretisation(BEAM, (4 * cells, cells), "Q2", grading)
        return reference_fem.solve_problem(problem, body).at(np.array([[4.0, 0.5]]))[0, 1:]

    estimate = refine(tip, 2, 0.05)
    assert estimate.status == ("asymptotic",)
    assert np.abs(estimate.value - TIP) <= estimate.uncertainty
    if grading == 1.0:
        # Twice the exponent at a corner clamped on one side [Williams1952].
        assert 1.3 < estimate.order[0] < 1.6


@pytest.mark.parametrize("element", of_dimension(2))
@pytest.mark.parametrize("grading", [1.0, 2.0])
def test_largest_error_of_a_clamped_body_is_covered(element, grading):
    # What `refine` promises of all values together; one value's own order may come out too high.
    problem = Problem(
        BOX,
        Isotropic(1.0, 0.3),
        (Support(BOX.side("left"), (0.0, 0.0)), Support(Region((1.0, None)), (1e-3, 0.0))),
    )
    line = np.linspace(0.03, 0.97, 12)
    places = np.array([[x, y] for x in line for y in (0.0, 0.1, 0.21, 0.37, 0.5)])

    def sampled(cells, element=element, grading=grading):
        body = reference_fem.box_discretisation(BOX, cells, element, grading)
        return reference_fem.solve_problem(problem, body).at(places).ravel()

    estimate = refine(sampled, 4, 1e-4)
    limit = sampled(64, "Q2", 3.0)  # its own error is 1e-9, of errors of 1e-6
    error = np.abs(estimate.value - limit)
    assert error.max() > 1e-8
    assert error.max() <= estimate.uncertainty.max()


def test_a_plateau_is_not_the_limit():
    """Two meshes that happen to agree say nothing: the change before them still counts."""
    estimate = three(lambda n: {8: 1.0, 16: 2.0, 32: 2.0}[n])
    assert estimate.status == ("not asymptotic",)
    assert estimate.uncertainty[0] >= 1.0


def test_slow_convergence_is_not_trusted():
    estimate = three(power(0.0, 1.0, 0.2))
    assert abs(estimate.value[0]) <= estimate.uncertainty[0]


@table(
    ("quantity", "message"),
    [
        (lambda _: np.array([]), r"shape \(0,\); give one value or a row of them"),
        (lambda n: np.ones((2, 2)) / n, r"shape \(2, 2\)"),
        (lambda n: np.ones(1 + (n > 4)) / n, "another number of values on another mesh"),
    ],
)
def test_quantities_that_cannot_be_compared_are_refused(quantity, message):
    with pytest.raises(ProblemError, match=message):
        refine(quantity, 2, 1e-3)


def test_a_plain_number_will_do():
    assert refine(lambda n: 1.0 / n**2, 2, 1e-2).value.shape == (1,)
