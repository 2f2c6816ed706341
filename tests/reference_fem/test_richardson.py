"""Stated errors, of sequences whose limit and order are known to the digit, and of real bodies."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import reference_fem
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
from reference_fem.mesh.elements import of_dimension
from reference_fem.richardson import (
    SAFETY_OF_EACH,
    TRUSTED_ORDER,
    close_in,
    extrapolate,
    extrapolate_each,
    refine,
)
from tests.table import table

# A division by a change of zero must not warn.
pytestmark = pytest.mark.filterwarnings("error")

# --- fields: one order for all components ---------------------------------------------------------

LIMIT = np.array([-7.0, 0.5, 3.0])


def sequence(*parts, meshes=3):
    """`LIMIT` + C h^p on meshes each twice as fine, (C, p) of each component; last errors."""
    errors = [[C * 2.0 ** (-p * n) for C, p in parts] for n in range(meshes)]
    return [LIMIT[: len(parts)] + each for each in errors], np.array(errors[-1])


@pytest.mark.parametrize("order", [0.501, 0.6, 1.0, 1.4, 2.0])
@pytest.mark.parametrize("meshes", [3, 5])
@pytest.mark.parametrize("size", [0.3, -0.3])
def test_twice_the_true_error_is_stated_where_an_order_is_seen(order, meshes, size):
    values, errors = sequence((size, order), (0.02, order), meshes=meshes)
    found = close_in(values)
    assert found.order == pytest.approx(order)
    assert found.uncertainty == pytest.approx(2 * np.abs(errors).max())
    np.testing.assert_array_equal(found.value, values[-1])
    np.testing.assert_allclose(found.extrapolated, LIMIT[:2], rtol=1e-12)


def test_higher_orders_count_as_the_highest_that_is_believed():
    values, errors = sequence((0.3, 3.0))
    found = close_in(values)  # of 7 parts that changed, an order of 2 leaves 7/3
    assert found.order == pytest.approx(3)
    assert found.uncertainty == pytest.approx(2 * 7 / 3 * errors[0])
    values, errors = sequence((0.3, 1.0))
    assert close_in(values, 0.25).uncertainty == pytest.approx(2 * errors[0] / (2**0.25 - 1))


@pytest.mark.parametrize("order", [0.499, 0.2, -0.5])
@pytest.mark.parametrize(("most", "factor"), [(2.0, 3.0), (0.25, 2 / (2**0.25 - 1))])
def test_the_larger_of_two_changes_counts_where_no_order_is_seen(order, most, factor):
    changes = [0.0, 1.0, 2.0**-order]
    values = list(np.array([5.0, 1.0]) - np.outer(np.cumsum(changes), [-0.2, 1.0]))
    found = close_in(values, most)
    assert np.isnan(found.order)
    assert found.uncertainty == pytest.approx(factor * max(changes))
    np.testing.assert_array_equal(found.extrapolated, values[-1])


def test_few_meshes():
    values, _ = sequence((-0.3, 1.0), (0.4, 1.0), meshes=2)
    assert close_in(values).uncertainty == pytest.approx(2 * 0.2)
    assert close_in(values, 0.25).uncertainty == pytest.approx(2 * 0.2 / (2**0.25 - 1))
    assert np.isinf(close_in(values[:1]).uncertainty)
    for meshes in (2, 3):
        none = close_in([np.zeros(2)] * meshes)
        assert none.uncertainty == 0
    for array in (none.value, none.added):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0


@pytest.mark.parametrize("meshes", [2, 3])
@pytest.mark.parametrize(("change", "stated"), [(0.0, 1.0), (-0.9, 1.0), (-1.1, None)])
def test_rounding(meshes, change, stated):
    rounding = 1e-10 * 8.0
    values = [np.array([-8.0, 1.0])] * (meshes - 1) + [np.array([-8.0, 1.0 + change * rounding])]
    found = close_in(values)
    wanted = stated or {2: 2 * 1.1, 3: 3 * 1.1}[meshes]
    assert found.uncertainty == pytest.approx(wanted * rounding, rel=1e-5)
    assert np.isnan(found.order)


def test_components_that_close_in_more_slowly_have_their_own_order():
    # The first rules the order; the second is slower, the third faster and counts as the first.
    values, errors = sequence((100.0, 2.0), (-1.0, 0.7), (0.5, 4.0), meshes=4)
    found = close_in(values)
    assert found.order == pytest.approx(2, abs=1e-3)
    np.testing.assert_allclose(found.extrapolated[:2], LIMIT[:2], rtol=0, atol=2e-3)
    assert found.added[2] == pytest.approx(15 / 3 * -errors[2], rel=1e-2)
    # Nor has one that goes to and fro, or hardly falls, an order of its own.
    for last in (-0.5, 0.9):
        rows = [np.array([100 * 4.0**-n, part]) for n, part in enumerate((0, 1, 1 + last))]
        assert close_in(rows).added[1] == pytest.approx(last / 3, rel=3e-3)


@pytest.mark.parametrize("many", [1, 400])
def test_the_order_is_the_lower_of_all_and_of_the_largest(many):
    # Changes 8 and 2 of one, 3 and 1.5 of many: alone the largest rules, many rule the norm.
    rows = np.cumsum([np.zeros(many + 1), [8] + [3] * many, [2] + [1.5] * many], axis=0)
    norms = np.sqrt([64 + 9 * many, 4 + 2.25 * many])
    found = close_in(list(rows))
    assert found.order == pytest.approx(np.log2(min(norms[0] / norms[1], 8 / 2)))
    # The other way round: the largest falls more slowly than all together.
    rows = np.cumsum([np.zeros(many + 1), [8] + [3] * many, [5] + [0.1] * many], axis=0)
    assert close_in(list(rows)).order == pytest.approx(np.log2(8 / 5))


# --- values, each of an order of its own ----------------------------------------------------------


def three(sequence, cells=8, highest=4.5):
    """Estimate from cells, 2 cells and 4 cells per side."""
    rows = [np.atleast_1d(np.asarray(sequence(n), float)) for n in (cells, 2 * cells, 4 * cells)]
    return extrapolate_each(rows, 4 * cells, highest)


def power(limit, factor, order):
    return lambda n: limit + factor * float(n) ** -order


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
    left = error * max(1.0, (2**order - 1) / (2**TRUSTED_ORDER - 1))
    before = error * (4**order - 2**order)
    believed = np.maximum(SAFETY_OF_EACH * left, before / 3)
    assert estimate.uncertainty == pytest.approx(believed, rel=1e-5)
    assert np.abs(estimate.added) == pytest.approx(left, rel=1e-5)
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


@table(
    ("sequence", "cells", "limit", "least"),
    [
        # Signs alternate from mesh to mesh, so that no order can be read off them.
        *((lambda n, p=p, c=c: 1 + (-1) ** round(np.log2(n / c)) * n**-p, c, 1, 1)
          for p in (0.7, 1.0, 2.0, 4.0) for c in (4, 5)),
        # Orders too good to be true: the change before the last still counts.
        *((power(1.0, 1.0, order), 2, 1.0, 10) for order in (4.6, 6.0, 10.0)),
        (lambda n: {8: 1.0, 16: 2.0, 32: 2.0}[n], 8, 1.0, 1),  # nor do two that agree say anything
        (power(0.0, 1.0, 0.2), 8, 0.0, 1),  # too slow
    ],
)  # fmt: skip
def test_what_shows_no_plausible_order_is_covered(sequence, cells, limit, least):
    estimate = three(sequence, cells)
    assert estimate.status == ("not asymptotic",)
    assert np.isnan(estimate.order).all()
    assert (estimate.added == 0).all()
    assert estimate.uncertainty >= least * np.abs(estimate.value - limit)
    if least > 1:
        assert estimate.uncertainty == pytest.approx(sequence(2) - sequence(4), rel=1e-6)


def test_orders_of_one_and_two_together_are_covered_on_coarse_meshes():
    # 1/n + 1/n² on 2, 4 and 8 cells shows an order of 1.3; what is left at 8 is 1/8 + 1/64. By one
    # order alone it would be 0.104, with the safety 0.130.
    estimate = three(lambda n: 1 / n + 1 / n**2, 2)
    assert 1 < estimate.order[0] < 2
    assert estimate.uncertainty == pytest.approx([SAFETY_OF_EACH * (1 / 8 + 1 / 64)], rel=1e-12)


@table(
    ("sequence", "highest", "status", "most"),
    [
        (power(1.0, 1.0, 3.0), 3.1, "asymptotic", 1.0),
        (power(1.0, 1.0, 3.0), 2.9, "not asymptotic", 1.0),
        (lambda n: 1 + 1e-9 / n, 4.5, "asymptotic", 1.0),  # small, and above rounding
        *((lambda n, x=x: x * (1 + 1e-14 * np.sin(37 * n)), 4.5, "exact", 1e-13 * abs(x))
          for x in (1.0, -1e6, 1e-6)),
        *((lambda _, x=x: x, 4.5, "exact", 0.0) for x in (0.0, 3.5)),
    ],
)  # fmt: skip
def test_status(sequence, highest, status, most):
    estimate = three(sequence, highest=highest)
    assert estimate.status == (status,)
    assert np.isnan(estimate.order[0]) == (status != "asymptotic")
    limit = sequence(10**9) if status != "exact" else sequence(8)
    assert abs(estimate.value[0] - limit) / 2 <= estimate.uncertainty[0] <= most


# --- known orders ---------------------------------------------------------------------------------


def test_extrapolation_finds_the_limit_of_two_powers():
    value, uncertainty = extrapolate(lambda n: [1 + 3 * n**-1.5 - n**-2.0, 2.0], 3, (1.5, 2.0))
    assert value == pytest.approx([1.0, 2.0], abs=1e-12)
    assert uncertainty == pytest.approx([0.0, 0.0], abs=1e-12)
    # From one cell on, orders below one and near each other.
    value, _ = extrapolate(lambda n: 1 + n**-0.9, 1, (1.0, 0.9))
    assert value == pytest.approx(1, abs=1e-12)


@table("power", [1.75, 2.5, 3.0, 4.0])
def test_extrapolation_owns_to_what_it_leaves_out(power):
    value, known = extrapolate(lambda n: 1 + n**-1.5 + n**-2.0 + n**-power, 2, (2.0, 1.5))
    true = abs(value[0] - 1)
    assert known[0] == pytest.approx(true * (2**power - 1) / (2**1.5 - 1), rel=1e-9)
    assert 0 < true <= known[0]


@table("orders", [(2.0, 2.0), (2.0, 1.96), (0.0, 2.0), (-0.5, 2.0), (1.0,), (1.0, np.nan)])
def test_orders_that_tell_nothing(orders):
    with pytest.raises(ProblemError, match="orders"):
        extrapolate(lambda n: 1 / n, 2, orders)


# --- refinement -----------------------------------------------------------------------------------


def test_every_value_must_meet_the_tolerance():
    estimate = refine(lambda n: np.array([n**-4.0, n**-1.0]), 2, 0.01)
    assert (estimate.uncertainty <= 0.01).all()
    assert estimate.cells == 128
    assert refine(lambda n: 1.0 / n**2, 2, 1e-2).value.shape == (1,)  # a plain number will do


@table(
    "sequence",
    [power(1.0, 1.0, 0.6), lambda n: (-1.0) ** round(np.log2(n)), float],
    ids=["too slow", "oscillates", "diverges"],
)
def test_not_converged_by_the_finest_is_a_solver_error(sequence):
    asked = []

    def quantity(cells):
        asked.append(cells)
        return sequence(cells)

    with pytest.raises(SolverError, match=r"not converged: uncertainty .* at 64 cells, wanted"):
        refine(quantity, 4, 1e-3, finest=100)
    assert asked == [4, 8, 16, 32, 64]


@table(
    ("changed", "message"),
    [
        ({"tolerance": 0.0}, "tolerance: 0.0; it must be above zero"),
        ({"tolerance": -1.0}, "tolerance"),
        ({"tolerance": float("nan")}, "tolerance: nan"),
        ({"coarsest": 0}, "coarsest: 0; give a whole number, 1 or more"),
        ({"finest": 7}, "from 2 cells to 7; leave room for three"),
        ({"quantity": lambda _: np.array([])}, r"shape \(0,\); give one value or a row of them"),
        ({"quantity": lambda n: np.ones((2, 2)) / n}, r"shape \(2, 2\)"),
        ({"quantity": lambda n: np.ones(1 + (n > 4)) / n}, "another number of values on another"),
        *(
            ({"quantity": lambda n, x=x, m=m: x if n == m else 1 / n},
             f"not a finite number on the mesh of {m} cells")
            for x in (np.nan, np.inf) for m in (2, 8, 16)
        ),
    ],
)  # fmt: skip
def test_bad_arguments_and_values_are_named(changed, message):
    good = {"quantity": lambda n: np.ones(1) / n, "coarsest": 2, "tolerance": 1e-2}
    kind = SolverError if "finite" in message else ProblemError
    with pytest.raises(kind, match=message):
        refine(**(good | changed))


# --- real bodies ----------------------------------------------------------------------------------

BOX = Box((1.0, 1.0))


WAVE, AMPLITUDE = np.array([2.1, -1.3]), np.array([1.0, 0.6])


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
