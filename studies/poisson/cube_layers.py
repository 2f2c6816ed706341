"""Cubes of equal springs in closed form: layers of springs in a uniform strain, and their work."""

from __future__ import annotations

import numpy as np

from msvalidate import kit

from .cube_block import SIDE, STRAIN


def layers_ratio(constants: tuple[float, ...], cells: int) -> float:
    """Ratio of N + 1 layers of equal springs for N cells, all in one uniform strain.

    Axial springs lie in two families of layers, face diagonals in one, cube diagonals in none.

    Source: closed form derived here.
    """
    k1, k2, k3 = (*constants, 0.0)[:3]
    m = (cells + 1) / cells
    C11, C12 = k1 * m**2 + 2 * k2 * m + 4 / 3 * k3, k2 * m + 4 / 3 * k3
    return C12 / (C11 + C12)


def layers_work(
    constants: tuple[float, ...], cells: int, points: kit.Array, displacement: kit.Array
) -> float:
    """Work of equal springs, ends sliding, on a uniform strain along y: from the faces alone.

    Along a row of axial springs the elongations add up to that of the row, D, and so do those of
    the two families of diagonals in a layer, which count the rows at its ends once and the others
    twice. With E the pull, bars for plain means over a face's points and a subscript for an axis
    along which the mean is that of the trapezium rule,

        m k1 D̄y + k2 (E + D̄y_x + D̄y_z + D̄z_y) + 4/3 k3/m (E + D̄y_xz + D̄z_xy) = 0.

    Returned over (k2 + 4/3 k3/m) E.
    """
    k1, k2, k3 = (*constants, 0.0)[:3]
    n, m = cells + 1, (cells + 1) / cells
    order = np.lexsort(points.T)  # by z, then y, then x
    u = displacement[order].reshape(n, n, n, 3)
    Dy, Dz = (u[:, -1] - u[:, 0])[..., 1], (u[-1] - u[0])[..., 2]  # (z, x) and (y, x)
    plain, rule = np.full(n, 1 / n), np.full(n, 1 / cells)
    rule[[0, -1]] /= 2
    E = STRAIN * SIDE
    faces = k2 * (E + plain @ Dy @ rule + rule @ Dy @ plain + rule @ Dz @ plain)
    cubes = 4 / 3 * k3 / m * (E + rule @ Dy @ rule + rule @ Dz @ rule)
    return float((m * k1 * plain @ Dy @ plain + faces + cubes) / ((k2 + 4 / 3 * k3 / m) * E))
