"""The study `displacement`: its public table, the arithmetic of the budget, orders, targets."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from msvalidate.studies.displacement import (
    budget,
    displacement_controls,
    load_cases,
    measuring,
    orders,
    target,
)
from msvalidate.studies.displacement.large import Large
from msvalidate.studies.displacement.load_cases import CASES
from msvalidate.studies.displacement.measuring import WEIGHTS, Block, Measurement
from msvalidate.studies.displacement.models import ISOTROPIC, MODELS, homogenised

from msvalidate.bench.judging.candidate import solve_springs
from msvalidate.bench.judging.evidence import all_passed, judge
from msvalidate.bench.judging.singularity import clamped_free_exponent
from msvalidate.bench.judging.sweep import Setting
from msvalidate.problem import ProblemError

QUICK = Setting(quick=True)
BLOCK = Block("shear", ISOTROPIC, 5)
SHIFTS = {
    ("shared", "linear"): 1.0,
    ("shared", "nonlinear"): 1.1,
    ("shared", "relaxed"): 1.13,
    ("equal", "linear"): 1.5,
    ("equal", "nonlinear"): 1.7,
    ("equal", "relaxed"): 1.71,
}
FEM, TARGET, DOUBT = 0.8, 0.5, 0.01
OWN, FULL, LARGE_DOUBT = 0.07, 0.11, 0.003


def uniform(size, like):
    """The same displacement (3, 4)·size everywhere: as long as 5·size."""
    return np.tile([3.0 * size, 4.0 * size], (len(like), 1))


@pytest.fixture(scope="module")
def rows():
    """Rows of a block whose displacements are known everywhere."""
    shape = load_cases.body("square", "shear", 5)
    points, probes = shape.grid().points, list(shape.probes)
    solid = [
        SimpleNamespace(
            at_points={5: uniform(size, points)},
            at_probes=uniform(size, probes),
            uncertainty=uniform(uncertainty, probes),
        )
        for size, uncertainty in ((FEM, DOUBT), (TARGET, 2 * DOUBT))
    ]
    moves = {key: uniform(size, points) for key, size in SHIFTS.items()}
    change = Large(*(uniform(each / 5, probes) for each in (OWN, FULL, LARGE_DOUBT)))
    key = ("shear", ISOTROPIC, 5)
    found = budget.rows(BLOCK, Measurement(points, moves), {key: tuple(solid)}, {key: change})
    return pd.DataFrame(found)


@pytest.mark.parametrize("weights", WEIGHTS)
@pytest.mark.parametrize(("component", "along"), [("ux", 0.6), ("uy", 0.8)])
def test_budget_by_hand(rows, weights, component, along):
    """Every part is a component over the length of the target's vector at the probe."""
    row = rows.set_index(["weights", "probe", "component"]).loc[weights, "upper", component]
    linear, nonlinear, relaxed = (SHIFTS[weights, answer] for answer in measuring.ANSWERS)
    steps = {
        "at_rest": relaxed - nonlinear,
        "linear_reference": FULL * TARGET,
        "law": (OWN - FULL) * TARGET,
        "large_spacing": nonlinear - linear - OWN * TARGET,
        "boundary": linear - SHIFTS["shared", "linear"],
        "discretisation": SHIFTS["shared", "linear"] - FEM,
        "model_form": FEM - TARGET,
        "total": relaxed - TARGET,
        "reference": 2 * DOUBT,
        "reference_large": LARGE_DOUBT * TARGET,
    }
    for part, step in steps.items():
        assert row[part] == pytest.approx(along * step / TARGET, abs=1e-14), part
    assert row["rel_l2"] == pytest.approx((linear - FEM) / FEM, rel=1e-12)
    assert row["rel_max"] == pytest.approx((linear - FEM) / FEM, rel=1e-12)
    assert row["u_springs"] == pytest.approx(5 * along * relaxed)
    assert row["u_fem"] == pytest.approx(5 * along * FEM)
    assert row["u_target"] == pytest.approx(5 * along * TARGET)
    assert row["verdict"] == "differs"


@pytest.mark.parametrize("power", [0.7, 1.0, 2.0])
@pytest.mark.parametrize("sign", [1, -1])
def test_order_of_a_power_law(power, sign):
    assert orders.order(sign * 3.0, sign * 3.0 / 4**power, 4) == pytest.approx(power)


@pytest.mark.parametrize(("before", "after"), [(1.0, -0.25), (0.0, 0.1), (1.0, 0.9), (1.0, 1e-3)])
def test_no_order(before, after):
    """A change of sign, no fall, or one too steep to be a power of the spacing."""
    assert orders.order(before, after, 2) == "not asymptotic"


def test_no_order_below_the_reference_s_own_error():
    assert orders.order(1.0, 0.25, 2, uncertainty=0.06) == pytest.approx(2)
    assert orders.order(1.0, 0.25, 2, uncertainty=0.07) == "not resolved"
    assert orders.order(1.0, -0.25, 2, uncertainty=0.07) == "not resolved"


@pytest.mark.parametrize(
    ("lattice", "case", "fineness", "message"),
    [
        ("hex", "shear", 5, "lattice 'hex'; choose from square, triangular"),
        ("square", "press", 5, "load case 'press'; choose from pressure"),
        ("square", "shear", 6, "fineness: 6; give a multiple of 5"),
        ("square", "shear", 0, "fineness: 0"),
        ("triangular", "shear", 5.5, "fineness: 5.5"),
    ],
)
def test_bodies_that_are_none(lattice, case, fineness, message):
    with pytest.raises(ProblemError, match=message.replace("; ", "[;:] ")):
        load_cases.body(lattice, case, fineness)


def test_a_probe_that_meets_no_point_is_refused():
    shape = load_cases.body("square", "shear", 5)
    with pytest.raises(ProblemError, match=r"probe 'upper': the nearest point is 0.03 m away"):
        shape.at_probes(np.add(shape.grid().points, (0.03, 0.0)))


def test_no_resolution_where_a_fault_does_nothing():
    """Rounding is no sign of a fault: the bent beam's traction is no uniform one."""
    found = displacement_controls.smallest(
        "traction", 1, displacement_controls.bending_error, displacement_controls.IDENTITY
    )
    assert found == "none"


@pytest.mark.parametrize(
    ("case", "model", "twice"),
    [
        ("shear", MODELS[0], 1.489),  # clamped-free right angle, nu = 1/3 (Williams 1952)
        ("two-sided pressure", MODELS[0], "no clamp"),
        ("shear", MODELS[2], "zigzag edge"),
        ("bending", MODELS[2], 1.315),  # the blunt corner of the trapezium, 120 degrees
    ],
)
def test_corner_exponents(case, model, twice):
    found = orders.twice_exponent(case, model)
    assert found == twice if isinstance(twice, str) else found == pytest.approx(twice, abs=1e-3)


def test_the_blunter_corner_decides():
    tensor = homogenised(MODELS[2]).C
    sharp, blunt = (2 * clamped_free_exponent(tensor, np.deg2rad(a)) for a in (60, 120))
    assert blunt < sharp
    assert orders.twice_exponent("bending", MODELS[2]) == blunt


def test_target_judges_by_an_independent_program():
    assert all_passed(judge(target.run(solve_springs, QUICK)))
    stiffer = displacement_controls.candidate_with("stiffness of every spring", 0.02)
    failed = judge(target.run(stiffer, QUICK)).query("verdict == 'fail'")["quantity"]
    assert "sheared square, k2 = 2 k1: an independent program, in its last digits" in set(failed)


@pytest.mark.parametrize("case", CASES)
def test_total_force_is_the_cases_own(case):
    """On every lattice the forces sum up to what the case says."""
    for model in MODELS:
        shape = load_cases.body(model.lattice, case, 5)
        problem = load_cases.problem(case, shape, homogenised(model))
        network = measuring.lattice_network(problem, shape.grid(), model.constants)
        want = np.sum(list(CASES[case].loads.values()), axis=0)
        np.testing.assert_allclose(network.force.sum(axis=0), want, atol=1e-9)
