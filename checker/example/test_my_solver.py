"""The solver against the frozen cases, and its own numbers against those that were committed."""

import numpy as np
import pytest
from my_solver import solve

from msvalidate_check import assert_elastic, elastic_case


@pytest.mark.parametrize(
    ("body", "mesh", "band"),
    [
        ("block_pull", "tri3", 0.001),  # uniform stress: exact in linear elements
        ("block_shear", "tet4", 0.001),
        ("clamped_pull", "tri3_3", 0.02),
    ],
)
def test_known_cases(body, mesh, band):
    case = elastic_case(body, nu=0.3, mesh=mesh)
    u = solve(
        case.points, case.cells, case.E, case.nu, case.state, case.thickness,
        case.force, case.held, case.value,
    )  # fmt: skip
    assert_elastic(case, case.points, u, band=band)


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
