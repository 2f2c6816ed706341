"""The solver against the frozen cases, and its own numbers against those that were committed."""

import numpy as np
import pytest
from my_solver import solve

try:
    from msvalidate_check import assert_elastic, elastic_case
except ImportError:  # a wheel without the set of cases
    elastic_case = None


@pytest.mark.skipif(elastic_case is None, reason="this msvalidate-check has no cases")
@pytest.mark.parametrize("mesh", ["tri3", "tri3_2", "tet4"])
def test_block_pull(mesh):
    case = elastic_case("block_pull", nu=0.3, mesh=mesh)
    body = case.points, case.cells, case.E, case.nu, case.state, case.thickness
    u = solve(*body, case.force, case.held, case.value)
    assert_elastic(case, case.points, u, band=0.05)


def test_cantilever(msvalidate_baseline):
    sizes, tips = [2, 4, 8], []
    for n in sizes:
        points, cells = strip(5 * n, n)
        held = np.repeat(points[:, :1] == 0, 2, axis=1)
        end = points[:, 0] == 5
        force = np.zeros_like(points)
        force[end, 1] = -1.0 / end.sum()
        u = solve(points, cells, 1e5, 0.3, "plane_stress", 0.1, force, held, 0.0)
        tips.append(u[end, 1].mean())
    msvalidate_baseline.check("cantilever", {"cells_across": sizes, "tip_m": tips})


def strip(columns, rows):
    """A strip 5 m long and 1 m high: points (n, 2) in m, triangles (m, 3)."""
    x, y = np.meshgrid(np.linspace(0, 5, columns + 1), np.linspace(0, 1, rows + 1), indexing="ij")
    at = np.arange(x.size).reshape(x.shape)
    a, b, c, d = (at[:-1, :-1], at[1:, :-1], at[1:, 1:], at[:-1, 1:])
    halves = [np.stack(three, axis=-1).reshape(-1, 3) for three in ((a, b, c), (a, c, d))]
    return np.stack([x.ravel(), y.ravel()], axis=1), np.vstack(halves)
