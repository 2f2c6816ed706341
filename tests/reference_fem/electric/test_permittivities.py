"""Permittivities far apart: layers in closed form, a core that becomes a conductor, a refusal."""

from __future__ import annotations

import numpy as np
import pytest

from msvalidate.problem import Box, SolverError
from reference_fem.electric.electrostatics import Dielectric
from reference_fem.mesh.boxes import box_discretisation
from tests.table import table

SIDE = 0.37
ROUNDING = 1e-12
"""Of charges and energies where permittivities are alike: sums of a thousand terms, each rounded by
1e-16 of the largest."""


def layers(ratio, element="Q1"):
    """A layer that touches neither electrode, one sixth to one half of the height."""
    body = box_discretisation(Box((SIDE, SIDE)), (4, 6), element)
    middle = body.points[body.cells].mean(axis=1)[:, 1]
    inside = (middle > SIDE / 6) & (middle < SIDE / 2)
    y = body.points[:, 1]
    held = np.isin(y, (0.0, y.max()))
    return Dielectric(body, np.where(inside, 3.0 * ratio, 3.0), held), np.where(y == 0, 0.2, 1.2)


@pytest.mark.parametrize("element", ["Q1", "Q2"])
@pytest.mark.parametrize("ratio", [1e-8, 1e-6, 1e-3, 1.0, 1e3, 1e6, 1e8])
def test_layers_are_capacitors_in_series(ratio, element):
    medium, values = layers(ratio, element)
    found = medium.solve(values)
    capacitance = 3.0 / (2 / 3 + 1 / 3 / ratio)  # of a square: width over height is 1
    top = found.charge[values == 1.2][medium.held[values == 1.2]].sum()
    bottom = found.charge[values == 0.2].sum()
    for value in (top, -bottom, 2 * found.energy):
        assert value == pytest.approx(capacitance, rel=found.error + ROUNDING)
    # Potentials have 1e-16 of themselves, of which the field in the layer takes its difference.
    apart = max(ratio, 1 / ratio)
    assert found.error <= max(2e-12, 1e-14 * apart)
    field = found.field([[SIDE / 2, SIDE / 4], [SIDE / 2, 0.9 * SIDE]])[:, 1]
    wanted = -capacitance / 3 / SIDE * np.array([1 / ratio, 1])
    assert field == pytest.approx(wanted, rel=1e-12 + 1e-14 * apart)


@table("ratio", [1e-30, 1e-18, 1e-12, 1e12, 1e18, 1e22, 1e30])
def test_what_rounding_hides_is_refused(ratio):
    medium, values = layers(ratio)
    with pytest.raises(SolverError, match=r"permittivities from 3.* to 3.*take a conductor"):
        medium.solve(values)
