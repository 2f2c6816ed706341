"""The study `poisson`: its public tables, its controls, its reference's corner exponent."""

from functools import partial

import numpy as np
import pytest

import reference_fem
from msvalidate.evidence import judge
from msvalidate.stiffness import square_tensor
from msvalidate.sweep import Setting
from studies import poisson
from studies.poisson import algorithm1, block, controls, elastic_block, finite_size

QUICK = Setting(quick=True)
FINITE_SIZE = [
    "lattice",
    "weights",
    "k1",
    "k2",
    "cells",
    "loading",
    "definition",
    "nu_springs",
    "nu_cell_formula",
    "nu_bulk_formula",
    "nu_fem",
]
DIRECTION = ["lattice", "k1", "k2", "angle_deg", "nu_tensor", "nu_fem"]


@pytest.fixture(scope="module")
def evidence():
    return poisson.run(setting=QUICK)


def test_public_columns(evidence):
    assert list(evidence.tables["finite_size"]) == FINITE_SIZE
    assert list(evidence.tables["direction"]) == DIRECTION


def test_rows_of_the_finite_size_table(evidence):
    table = evidence.tables["finite_size"]
    # weights x sizes x loadings x definitions, less the clamped single cell, which cannot deform.
    assert len(table) == 3 * 6 * 3 * 2 - 3 * 2
    assert not table.duplicated(["weights", "k2", "cells", "loading", "definition"]).any()
    assert not ((table["loading"] == "clamped") & (table["cells"] == 1)).any()


def test_full_form_has_every_ratio_and_angle():
    assert finite_size.RATIOS == (0.25, 0.5, 1.0, 2.0)
    full = poisson.direction.run().tables["direction"]
    assert sorted(set(full["angle_deg"])) == list(range(0, 91, 5))
    assert len(full) == 19 * 4


def test_reference_in_the_candidates_place_has_no_error():
    found = finite_size.run(candidate=block.finite_elements, setting=QUICK)
    table = found.tables["finite_size"]
    uniform = table["loading"] != "clamped"
    difference = np.abs(table["nu_springs"] - table["nu_fem"])
    assert difference[uniform].max() < 1e-9, "uniform strain is exact on every mesh"
    assert difference[~uniform].max() < elastic_block.REFERENCE_ERROR, "a coarser mesh of its own"


@pytest.mark.parametrize("name", controls.FAULTS)
def test_stated_resolution_is_the_real_one(name):
    noticed = controls.smallest(name)["smallest_noticed"]

    def largest(size):
        faulty = partial(controls.spoilt, controls.FAULTS[name], size)
        return max(controls.identities(faulty).values())

    assert largest(1.1 * noticed) > finite_size.IDENTITY
    assert largest(0.9 * noticed) < finite_size.IDENTITY


@pytest.mark.parametrize("fault", poisson.FAULTS)
def test_faults_are_caught_by_physics(fault):
    """By an identity or the finite elements, not by a remembered number."""
    verdict = judge(finite_size.run(**poisson.FAULTS[fault], setting=QUICK))
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


def test_corner_exponent():
    """Where a clamped edge meets a free one at 90 degrees the stress is singular, nu > 0 or not."""
    assert elastic_block.corner_exponent(1 / 3) == pytest.approx(0.7447, abs=1e-4)
    # Uniaxial stress alone is compatible with nu = 0: the corner is regular.
    assert elastic_block.corner_exponent(0.0) == pytest.approx(1.0, abs=1e-6)


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
