"""Errors of lattices cut to an outline: of second order, then first, where they do not fit.

Closed forms: Lamé's ring [Lame1852] under pressure from inside, plane stress,

    u = p a²/(E (b² - a²)) ((1 - nu) r + (1 + nu) b²/r),   sigma = p a²/(b² - a²) (1 -+ b²/r²).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from msvalidate.problem import Support
from msvalidate.springs.bodies.cut_network import cut_network
from msvalidate.springs.lattice import cut_lattice, patterns
from msvalidate.springs.statics.equilibrium import equilibrium
from msvalidate.springs.statics.stress import cell_stress, fitted_stress, interior_points

VOIGT = np.array([[9 / 8, 3 / 8, 0], [3 / 8, 9 / 8, 0], [0, 0, 3 / 8]])
"""Of a plane solid with E = 1 and a ratio of 1/3."""


def lame_displacement(x):
    r = np.linalg.norm(x, axis=1)[:, None]
    return x / r * (2 / 3 * r + 4 / 3 * 4 / r) / 3


def lame_stress(x):
    r = np.linalg.norm(x, axis=1)
    n = x / r[:, None]
    radial, hoop = (1 - 4 / r**2) / 3, (1 + 4 / r**2) / 3
    xx, yy, xy = n[:, 0] ** 2, n[:, 1] ** 2, n[:, 0] * n[:, 1]
    return np.stack(
        [radial * xx + hoop * yy, radial * yy + hoop * xx, (radial - hoop) * xy], axis=1
    )


def solved(problem, spacing, **rules):
    lattice = cut_lattice(patterns.square(), problem.domain, spacing, **rules)
    network = cut_network(problem, lattice)
    return lattice, network, equilibrium(network)


def lame_error(ring, spacing, **rules):
    """RMS error of the displacement inside, relative to its mean."""
    lattice, _, found = solved(ring, spacing, **rules)
    x, u = lattice.points[lattice.inside], found.displacement[lattice.inside]
    wanted = lame_displacement(x)
    return np.sqrt(((u - wanted) ** 2).sum(axis=1).mean() / (wanted**2).sum(axis=1).mean())


def test_displacements_of_a_ring_converge(pressed_ring):
    error = [lame_error(pressed_ring, 1 / n) for n in (8, 16, 32, 64)]
    assert error[0] < 5e-3
    assert error[3] < 2e-4
    # Second order as long as the lattice's own error leads; what the cut cells do is of first
    # order, some 0.006 h, and leads from a hundred cells on.
    assert np.log2(error[0] / error[2]) / 2 > 1.5
    assert error[0] > error[1] > error[2] > error[3]


@pytest.mark.parametrize("field", [True, False])
def test_a_ring_clamped_outside_converges(field, pressed_ring):
    # u = A r + B/r with u(2) = 0 and the pressure 1 at r = 1.
    A, B = np.linalg.solve([[2.0, 0.5], [3 / 2, -3 / 4]], [0.0, -1.0])

    def wanted(x):
        r2 = (x**2).sum(axis=1)[:, None]
        return A * x + B * x / r2

    clamp = tuple(lambda x, i=i: wanted(x)[:, i] for i in (0, 1)) if field else (0.0, 0.0)
    held = Support(pressed_ring.domain.side("outer"), clamp)
    problem = replace(pressed_ring, supports=(*pressed_ring.supports, held))
    error = []
    for n in (8, 16, 32):
        lattice, _, found = solved(problem, 1 / n)
        x, u = lattice.points[lattice.inside], found.displacement[lattice.inside]
        error.append(np.abs(u - wanted(x)).max() / (A + B))
    order = np.log2(error[0] / error[2]) / 2
    if field:
        assert error[2] < 0.01
    else:  # the clamp reaches up to a cell inwards
        assert error[2] > 0.02
        assert 0.8 < order < 1.3


def test_stress_at_the_outline_and_inside_converges(pressed_ring):
    angle = np.linspace(0, np.pi / 2, 13)
    rim = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    at_rim, in_cells = [], []
    for n in (8, 16, 32):
        lattice, network, found = solved(pressed_ring, 1 / n)
        good = interior_points(lattice)
        fitted = fitted_stress(lattice.points[good], found.displacement[good], rim, VOIGT)
        at_rim.append(np.abs(fitted - lame_stress(rim)).max() / (5 / 3))
        middle = lattice.points[lattice.cells].mean(axis=1)
        inner = np.abs(np.linalg.norm(middle, axis=1) - 1.5) < 0.25
        stress = cell_stress(network, lattice, found)
        in_cells.append(np.abs(stress - lame_stress(middle))[inner].max() / (5 / 3))
    assert at_rim[2] < 0.04
    assert at_rim[0] / at_rim[2] > 6
    assert in_cells[2] < 5e-4
    assert np.log2(in_cells[0] / in_cells[2]) / 2 > 1.7
