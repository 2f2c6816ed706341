"""Points far from the origin, on its negative side as on its positive one."""

import numpy as np
import pytest

from msvalidate.network import spring_network
from msvalidate.problem import ProblemError


@pytest.mark.parametrize("side", [-1e6, 1e6])
def test_points_that_only_rounding_keeps_apart_are_in_one_place(side):
    # 1e-14 of the coordinates is 1e-8 m.
    near, apart = (np.array([[side, side], [side + d, side]]) for d in (5e-9, 5e-8))
    with pytest.raises(ProblemError, match="its two points coincide"):
        spring_network(near, [[0, 1]], 1.0)
    assert spring_network(apart, [[0, 1]], 1.0).rest_length == pytest.approx(5e-8, rel=1e-2)
