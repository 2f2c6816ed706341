"""One cell of a volume energy by hand, at a size that is not 1."""

import numpy as np
import pytest

from msvalidate.problem import ProblemError
from msvalidate.springs.network.laws import volumes
from msvalidate.springs.network.laws.volumes import Volumes

SIDE, KAPPA = 0.37, 5.0
CORNERS = SIDE * np.array([[0.0, 0], [1, 0], [0, 1]])


def triangle(corners=CORNERS, kappa=KAPPA):
    return Volumes(corners, np.array([[0, 1, 2]]), np.array([kappa]))


def test_corners_in_one_place_are_no_cell():
    with pytest.raises(ProblemError, match="cell 0 has volume 0"):
        triangle(np.full((3, 2), SIDE))


@pytest.mark.parametrize("reach", [0.0, 0.05, 40.0])
def test_rounding_is_of_the_force_that_moves_by_the_reach_would_make(reach):
    # An area changes with a corner by half of the side across.
    across = SIDE / 2 * np.array([np.sqrt(2), 1, 1])
    area = SIDE**2 / 2
    growth = across.sum() * (reach + np.sqrt(area)) / area
    for kappa in (KAPPA, -KAPPA):
        met = volumes.roundoff_magnitudes(triangle(kappa=kappa), reach)
        np.testing.assert_allclose(met, KAPPA * growth * across, rtol=1e-14)


def test_forces_and_stiffness_met_are_sizes_of_either_sign():
    across = SIDE / 2 * np.array([np.sqrt(2), 1, 1])
    area = SIDE**2 / 2
    for kappa in (KAPPA, -KAPPA):
        cell = triangle(kappa=kappa)
        np.testing.assert_allclose(
            volumes.stiffness_magnitudes(cell), KAPPA * across**2 / area, rtol=1e-14
        )
        # Stretched to 1.1 and 1.2 of its sides: the area is 1.32 of what it was.
        met = volumes.force_magnitudes(cell, CORNERS * [0.1, 0.2])
        sides = SIDE / 2 * np.array([np.hypot(1.1, 1.2), 1.2, 1.1])
        np.testing.assert_allclose(met, KAPPA * 0.32 * sides, rtol=1e-12)
