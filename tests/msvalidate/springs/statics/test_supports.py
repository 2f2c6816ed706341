"""Prescribed displacements are imposed on a relaxation without folding the body."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize

from msvalidate.problem import Box, SolverError, Support
from msvalidate.springs.dynamics.relax import relax
from msvalidate.springs.dynamics.relaxations import RELAXATIONS
from tests.msvalidate.energies import spring_energy

SIDE = 0.37
"""m"""
CONSTANTS = (2.0, 1.0)
"""k1, k2 in N/m, by which the unit square stores 0.013444 J at 10 % and 12 x 12 cells."""


def squeezed(lattice_body, cells, part):
    """Square of square-8 lattice between clamped sides, one pushed in by a part of the width."""
    box = Box((SIDE, SIDE))
    sides = (Support(box.side("left"), (0, 0)), Support(box.side("right"), (-part * SIDE, 0)))
    return lattice_body((SIDE, SIDE), cells, supports=sides, constants=CONSTANTS)


def least_energy(network, part):
    """Energy (J) of the rest near uniform compression, by L-BFGS on the springs' energy alone."""
    free = ~network.fixed
    uniform = network.points * [1 - part, 1.0]

    def value(x):
        position = uniform.copy()
        position[free] = x
        stored, slope = spring_energy(network, position)
        return stored, slope[free]

    options = {"maxiter": 5000, "ftol": 1e-15, "gtol": 1e-9}
    return minimize(value, uniform[free], jac=True, method="L-BFGS-B", options=options).fun


def inside_out(position, cells):
    """Cells with a corner whose sides turn the wrong way, numbered along x and then y."""
    grid = position.reshape(cells + 1, cells + 1, 2)
    ring = [grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1]]
    turns = []
    for k in range(4):
        ahead, back = ring[(k + 1) % 4] - ring[k], ring[k - 1] - ring[k]
        turns.append(ahead[..., 0] * back[..., 1] - ahead[..., 1] * back[..., 0])
    return int((np.array(turns) <= 0).any(axis=0).sum())


@pytest.mark.parametrize("method", RELAXATIONS.values(), ids=RELAXATIONS.keys())
def test_a_squeezed_body_is_not_turned_inside_out(method, lattice_body):
    """At 10 % of 12 cells the side moves past its neighbours, to half the energy if all at once."""
    network = squeezed(lattice_body, 12, 0.1)
    rest = relax(network, method).equilibrium
    found, _ = spring_energy(network, rest.position)
    assert found == pytest.approx(0.013444 * SIDE**2, rel=1e-4)
    assert found == pytest.approx(least_energy(network, 0.1), rel=1e-8)
    assert inside_out(rest.position, 12) == 0
    assert rest.folded == 0


@pytest.mark.parametrize(("cells", "part"), [(6, 0.15), (24, 0.05), (24, 0.15)])
def test_finer_cells_and_further_pushes_find_the_same_body(lattice_body, cells, part):
    network = squeezed(lattice_body, cells, part)
    expected = least_energy(network, part)
    for name in ("conjugate_gradients", "kinetic_damping"):
        rest = relax(network, RELAXATIONS[name]).equilibrium
        assert spring_energy(network, rest.position)[0] == pytest.approx(expected, rel=1e-7)


def test_a_folded_rest_is_refused_with_its_cells(lattice_body):
    """From the side moved alone the first row folds, and rests so."""
    network = squeezed(lattice_body, 12, 0.1)
    options = {"method": RELAXATIONS["conjugate_gradients"], "start": network.displacement}
    with pytest.raises(SolverError, match=r"12 cells are inside out, of 144: at \(0\.35458") as no:
        relax(network, **options)
    assert "\n" not in str(no.value)
    assert "along a path, or reduce it" in str(no.value)
    rest = relax(network, **options, allow_folded=True).equilibrium
    assert rest.folded == inside_out(rest.position, 12) == 12
    assert spring_energy(network, rest.position)[0] == pytest.approx(0.006257 * SIDE**2, rel=1e-3)
