"""Bent bar: how stiff is a bar of cubic cells in pure bending?

Question   Moment over curvature of a square bar of cubic 18, N x N cells in its cross-section.
Candidate  Linear equilibrium of the spring network, edges and faces shared (1/4 and 1/2).
Reference  The cross-section alone: far from the ends every layer of cells bends alike, so its
           points' moves in the section are all that is unknown. And a closed form.
Expected   A quadratic displacement stretches a spring by its strain in the middle. Springs with
           their middle in a layer of points add up T = N³/12 + N/6, the trapezium rule of ∫y², the
           others M = N³/12 - N/12, the midpoint rule. With strains -α y and -β y across, up and
           sideways, the energy is that of

               k1 (T + M α² + T β²) + k2 (M (1 - α)² + T (1 - β)² + M (α + β)²),

           least over α and β: an upper bound, exact for N = 1 and 2, where the section can move in
           no other way. For large N it is EI_eff/EI = 1 + (19/20)/N² at k2 = k1 (nu = 1/4), where
           the plane has 1 + ((2 - nu)/(1 + nu))/N². The bound is not sharp: along the bar's four
           edges forces of order (spacing)² are left, which release a part log(N)/N⁴.
"""

from __future__ import annotations

from functools import partial

import numpy as np
import pandas as pd

from msvalidate import kit
from msvalidate.springs.bodies.lattice_network import lattice_network
from msvalidate.springs.constants.homogenise import interior_tensor
from msvalidate.springs.constants.stiffness import moduli, pattern_tensor
from msvalidate.springs.lattice import fill, patterns

HEIGHTS, FINE_SECTION = (1, 2, 3, 4), 12
"""Cells through the height of the bar, and of a cross-section from which the limit is read."""
LENGTH = 8
"""Heights. The consistent forces of a linear traction are not quite the network's own pure bending;
what they add decays as exp(-3.8·distance/height), to 3e-7 of itself at the middle."""
MOMENT = 1.0
"""N·m; the answer is linear."""
LEADING = 19 / 20
"""N² (EI_eff/EI - 1) of large N: from T and M with α = β = 1/4."""
PATTERN = patterns.cubic18()
MODULUS = moduli(pattern_tensor(PATTERN, (1.0, 1.0))).E
"""Of the solid, in units of the spring constant over the spacing."""
judged = partial(kit.Rule, unit="1", table="bent_bar", value="EI_bar")
RULES = (
    judged(
        "bent bar of 1 and 2 cells: EI_eff/EI in closed form", 1e-9,
        rows={"cells_high": (1, 2)}, reference="EI_bound",
        because="exact: the section has no other way to move; left are rounding and end effects "
        "that these sections hardly carry",
    ),
    judged(
        "bent bar: EI_eff/EI against its cross-section", 1e-7,
        rows={"cells_high": HEIGHTS}, reference="EI_section",
        because="the same network far from its ends: end effects of a tenth, 3e-7 of them at the "
        "middle",
    ),
    judged(
        "bent bar: N² (EI_eff/EI - 1), 12 cells, against 19/20",
        float(np.log(FINE_SECTION) / FINE_SECTION**2), rows={"cells_high": FINE_SECTION},
        value=lambda rows: rows["cells_high"] ** 2 * (rows["EI_section"] - 1), reference=LEADING,
        because="what edges release is of order log(N)/N⁴, and N² times that is left",
    ),
)  # fmt: skip


def run(
    candidate: kit.DisplacementSolver = kit.solve_springs, setting: kit.Setting = kit.FULL
) -> kit.Evidence:
    """Compare the candidate's bar with its cross-section and the closed form."""
    bars = setting.sweep(partial(bending_stiffness, candidate), HEIGHTS, "bent bars")
    measured: list[float | str] = [*bars, *("none" for _ in (8, FINE_SECTION))]
    table = pd.DataFrame(
        {
            "lattice": PATTERN.name,
            "cells_high": n,
            "EI_bar": bar,
            "EI_section": section_stiffness(n),
            "EI_bound": bending_bound(n),
        }
        for n, bar in zip((*HEIGHTS, 8, FINE_SECTION), measured, strict=True)
    )
    stiffer = ", ".join(
        f"{100 * (bar - 1):.1f} % (N = {n})" for n, bar in zip(HEIGHTS, bars, strict=True)
    )
    finding = (
        f"A square bar of cubic 18 is stiffer in bending than its solid, by {stiffer}: for many "
        f"cells by {LEADING:.2f}/N²."
    )
    return kit.Evidence(
        tables={"bent_bar": table},
        tolerances=RULES,
        columns=kit.columns(__file__),
        findings=(finding,),
    )


def bending_stiffness(candidate: kit.DisplacementSolver, cells: int) -> float:
    """EI_eff/EI of a bar 1 m high and wide under end moments, from the curvature at its middle."""
    length = float(LENGTH)
    bar = kit.Box((length, 1.0, 1.0))
    grid = fill(PATTERN, bar, (LENGTH * cells, cells, cells))
    tensor = interior_tensor(grid, (1.0, 1.0), "shared")

    def pull(points: kit.Array) -> kit.Array:
        return 12 * MOMENT * np.outer(points[:, 1] - 0.5, (1.0, 0.0, 0.0))

    def push(points: kit.Array) -> kit.Array:
        return -pull(points)

    problem = kit.Problem(
        bar,
        kit.Anisotropic(tensor),
        (
            kit.Support(kit.Region((0.0, 0.0, 0.0)), (0.0, 0.0, 0.0)),
            kit.Support(kit.Region((length, 0.0, 0.0)), (None, 0.0, 0.0)),
            kit.Support(kit.Region((0.0, 1.0, 0.0)), (None, None, 0.0)),
        ),
        (kit.Traction(bar.side("right"), pull), kit.Traction(bar.side("left"), push)),
        name="pure bending of a bar",
    )
    network = lattice_network(problem, grid, (1.0, 1.0))
    move = candidate(problem, network, "linear")
    line = (grid.points[:, 1:] == 0).all(axis=1)
    deflection = move[line, 1][np.argsort(grid.points[line, 0], kind="stable")]
    middle = LENGTH * cells // 2
    left, centre, right = deflection[middle - 1 : middle + 2]
    curvature = (left - 2 * centre + right) * cells**2
    return float(MOMENT / abs(curvature) / (moduli(tensor).E / 12))


def section_stiffness(cells: int) -> float:
    """EI_eff/EI of an endless bar: the least energy of its cross-section at curvature 1.

    Spacing and constants are 1. The section's points move by (v, w) beside u_x = x y and
    u_y = -x²/2; an elongation is then what bending gives a spring at its middle height, and the
    part of the points' moves along it.
    """
    points = (cells + 1) ** 2
    height = np.repeat(np.arange(cells + 1) - cells / 2, cells + 1)
    rows, bent = [], []
    for start, end, share, (nx, ny, nz) in _section_springs(cells):
        a, b, weight = start.ravel(), end.ravel(), np.sqrt(share.ravel())
        row = np.zeros((a.size, 2 * points))
        for first, part in ((0, ny), (points, nz)):
            row[np.arange(a.size), b + first] += weight * part
            row[np.arange(a.size), a + first] -= weight * part
        rows.append(row)
        # n·ε·n L of the bending strain ε_xx = y is nx² L y, and L nx = 1 where it leads on.
        bent.append(weight * nx * (height[a] + height[b]) / 2)
    A, e = np.concatenate(rows), np.concatenate(bent)
    left = e - A @ np.linalg.lstsq(A.T @ A, A.T @ e, rcond=1e-12)[0]
    return float(left @ left / (MODULUS * cells**4 / 12))


def _section_springs(
    cells: int,
) -> list[tuple[kit.Index, kit.Index, kit.Array, tuple[float, float, float]]]:
    """Springs that join points of one section, or of it and the next.

    Start, end, share and direction (x, y, z), one entry a direction. Of the two diagonals that lead
    on along the bar one climbs and one descends: by symmetry they are stretched alike, so one
    stands for both.
    """
    n = cells + 1
    number = np.arange(n * n).reshape(n, n)  # by height, then width
    inside = np.where(np.isin(np.arange(n), (0, cells)), 0.5, 1.0)
    wide, high = np.tile(inside, (n, 1)), np.tile(inside[:, None], (1, n))
    up, across = (number[:-1], number[1:], wide[1:]), (number[:, :-1], number[:, 1:], high[:, 1:])
    whole = np.ones((cells, cells))
    half = float(np.sqrt(0.5))
    return [
        (number, number, wide * high, (1.0, 0.0, 0.0)),
        (*up, (0.0, 1.0, 0.0)),
        (*across, (0.0, 0.0, 1.0)),
        (*up[:2], 2 * up[2], (half, half, 0.0)),
        (*across[:2], 2 * across[2], (half, 0.0, half)),
        (number[:-1, :-1], number[1:, 1:], whole, (0.0, half, half)),
        (number[:-1, 1:], number[1:, :-1], whole, (0.0, half, -half)),
    ]


def bending_bound(cells: int) -> float:
    """EI_eff/EI of the best quadratic displacement, k2 = k1: see the head of this file."""
    T, M = cells**3 / 12 + cells / 6, cells**3 / 12 - cells / 12
    # Zero slope in α and β. In one cell no spring tells α, which is then 0.
    system = np.array([[3 * M, M], [M, 2 * T + M]])
    a, b = np.linalg.lstsq(system, np.array([M, T]), rcond=None)[0]
    energy = T + M * a**2 + T * b**2 + M * (1 - a) ** 2 + T * (1 - b) ** 2 + M * (a + b) ** 2
    return float(energy / (MODULUS * cells**3 / 12))
