"""What a solution is made of."""

import numpy as np
import pytest

from msvalidate.problem import Isotropic, ProblemError
from reference_fem.body import Solution
from reference_fem.mesh import make_discretisation


def test_stress_follows_from_a_material_and_not_from_its_name():
    body = make_discretisation([[0, 0], [0.37, 0], [0.37, 0.2], [0, 0.2]], [[0, 1, 2, 3]], "Q1")
    moved = np.zeros(body.points.shape)
    assert Solution(body, moved.copy(), Isotropic(1e5, 0.3)).material.nu == 0.3
    with pytest.raises(ProblemError, match="material"):
        Solution(body, moved, "steel")
