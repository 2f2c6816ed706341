"""Cells that lock are refused; what is answered near nu = 1/2 is right as far as `refine` says."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import reference_fem
from msvalidate.problem import Anisotropic, Box, Isotropic, Problem, SolverError, Support, Traction
from reference_fem.elasticity import elastic_tensor
from reference_fem.locking import bulk_over_shear
from reference_fem.mesh.elements import ELEMENTS, of_dimension
from reference_fem.richardson import extrapolate_each
from tests.table import table

SIZE = 0.37


def clamped(nu, state="plane_strain", pull=(0.3, 1.0)):
    """A square, clamped on its left and pulled askew on its right."""
    box = Box((SIZE, SIZE))
    return Problem(
        box,
        Isotropic(1e6, nu, state, thickness=0.2),
        (Support(box.side("left"), (0.0, 0.0)),),
        (Traction(box.side("right"), pull),),
    )


def tip(problem, cells, element, **how):
    mesh = reference_fem.box_discretisation(problem.domain, cells, element)
    return reference_fem.solve_problem(problem, mesh, **how).at([problem.domain.size])[0]


@cache
def limit(nu):
    """Tip of mixed elements, extrapolated to endless meshes, where nothing locks."""
    return extrapolated([tip(clamped(nu), n, "Q2", mixed=True) for n in (8, 16, 32)])


def extrapolated(values):
    """Aitken's limit of a geometric series."""
    first, last = values[1] - values[0], values[2] - values[1]
    return values[2] + last**2 / (first - last)


@table("element", [name for name in of_dimension(2) if ELEMENTS[name].locks])
@table("nu", [0.4999, 0.499999])
def test_locked_cells_are_refused_and_may_be_looked_at(element, nu):
    with pytest.raises(SolverError, match=r"lock.*nu = 0.476 or less"):
        tip(clamped(nu), 16, element)
    locked = tip(clamped(nu), 16, element, allow_locked=True)
    # The square of a bulk modulus 1e3 times its shear modulus hardly moves: half is missing.
    assert np.abs(locked / limit(nu) - 1).max() > 0.3
    free = tip(clamped(nu), 16, ELEMENTS[element].raised[0], mixed=True)
    assert np.abs(free / limit(nu) - 1).max() < 0.02


def test_solids_at_large_strain_lock_as_well():
    from reference_fem.large_strain import Solid, deform, neo_hookean  # noqa: PLC0415

    mesh = reference_fem.box_discretisation(Box((SIZE, SIZE)), 8, "Q1")
    held = np.repeat(mesh.points[:, :1] == 0, 2, axis=1)
    force = np.where(held, 0.0, 1e-3)
    solid = Solid(mesh, neo_hookean(Isotropic(1e6, 0.4999, "plane_strain")), held)
    with pytest.raises(SolverError, match="lock"):
        deform(solid, 0 * force, force)
    assert deform(solid, 0 * force, force, allow_locked=True).displacement.any()


@table("element", [name for name in of_dimension(3) if ELEMENTS[name].locks])
def test_cells_in_space_are_refused(element):
    box = Box((SIZE, SIZE, SIZE))
    problem = Problem(
        box,
        Isotropic(1e6, 0.4999, "solid"),
        (Support(box.side("left"), (0.0, 0.0, 0.0)),),
        (Traction(box.side("right"), (0.0, 1.0, 0.0)),),
    )
    with pytest.raises(SolverError, match="lock"):
        reference_fem.solve_problem(problem, reference_fem.box_discretisation(box, 3, element))


def test_plane_stress_and_fibres_do_not_lock():
    assert tip(clamped(0.5, "plane_stress"), 4, "Q1").any()
    for nu, state in ((0.3, "plane_strain"), (0.49, "solid"), (-0.4, "solid")):
        wanted = 2 * nu / (1 - 2 * nu)
        assert bulk_over_shear(elastic_tensor(Isotropic(7.0, nu, state))) == pytest.approx(wanted)
    stiff_one_way = Anisotropic(np.diag([1e4, 1.0, 0.4]))
    assert bulk_over_shear(stiff_one_way.C) < 1
    swelling = np.diag([0.8, 1.2, 0.4])
    swelling[:2, :2] += 1e4
    assert bulk_over_shear(swelling) == pytest.approx(1e4 / 0.5, rel=0.3)


@pytest.mark.parametrize("element", of_dimension(2))
def test_three_meshes_never_state_less_than_their_error(element):
    missed, answered = [], 0
    for nu in (0.0, 0.3, 0.45, 0.49, 0.4999, 0.499999):
        for coarsest in (2, 4):
            try:
                values = [tip(clamped(nu), coarsest * 2**i, element) for i in range(3)]
            except SolverError:
                assert nu >= 0.48
                assert ELEMENTS[element].locks
                continue
            found = extrapolate_each(values, 4 * coarsest)
            answered += 1
            error = np.abs(found.value - (limit(nu) if nu else zero_ratio()))
            if (error > found.uncertainty).any():
                missed.append((nu, coarsest, error, found))
    assert not missed
    assert answered >= 6


@cache
def zero_ratio():
    """The limit at nu = 0, for which mixed elements are not: Q2 on fine meshes, extrapolated."""
    return extrapolated([tip(clamped(0.0), n, "Q2") for n in (8, 16, 32)])
