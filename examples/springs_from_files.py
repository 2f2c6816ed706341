"""Springs of a case from the tables that its run leaves: at rest to first order, then moving.

msvalidate case run examples/plate.toml
python examples/springs_from_files.py reports/cases/plate rest.csv [--move]
msvalidate case judge examples/plate.toml rest.csv
"""

import sys
from pathlib import Path

import numpy as np
from scipy import sparse

FACES = {8: "0321 4567 0154 1265 2376 0473", 4: "0211 0133 1233 0322"}  # triangles: last twice


def measure(x, nodes):
    """Lengths of springs, volumes of cells (m,), and the matrix (m, n d) of their slopes."""
    p, d = x[nodes] - x[nodes[:, :1]], x.shape[1]
    if nodes.shape[1] == 2:
        slope = np.stack([-p[:, 1], p[:, 1]], 1) / np.linalg.norm(p[:, 1], axis=1)[:, None, None]
    elif d == 2:  # the shoelace formula
        across = (np.roll(p, -1, 1) - np.roll(p, 1, 1)) / 2
        slope = np.stack([across[..., 1], -across[..., 0]], -1)
    else:  # of faces a, b, c, d, bilinear: (a + b + c + d) . (c - a) x (d - b) / 24
        slope, faces = (
            np.zeros(p.shape),
            np.array([[*map(int, f)] for f in FACES[len(p[0])].split()]),
        )
        a, b, c, e = np.moveaxis(p[:, faces], 2, 0)
        f, g, h = (
            np.cross(*pair)
            for pair in ((c - a, e - b), (e - b, a + b + c + e), (a + b + c + e, c - a))
        )
        for corner, part in zip(faces.T, (f - g, f - h, f + g, f + h), strict=True):
            np.add.at(slope, (slice(None), corner), part / 24)
    size = (p * slope).sum((1, 2)) / (1 if nodes.shape[1] == 2 else d)  # as both grow with x
    column, first = nodes[..., None] * d + np.arange(d), np.arange(len(p) + 1) * slope[0].size
    return size, sparse.csr_array((slope.ravel(), column.ravel(), first), (len(p), x.size))


def solve(folder, move):
    """Displacement (n, d) in m: at rest to first order, or where leapfrog ends."""
    files = [folder / f"{name}.csv" for name in ("points", "springs", "cells")]
    points, springs, *cells = (
        np.genfromtxt(f, delimiter=",", names=True) for f in files if f.exists()
    )
    axes = [a for a in "xyz" if a in points.dtype.names]
    x, held, start, load = (
        np.stack([points[w + a] for a in axes], 1) for w in ("", "held_", "move_", "force_")
    )
    free, mass = held.ravel() == 0, np.repeat(points["mass"], len(axes))
    # A cell's energy κ V0 (V/V0 - 1)²/2 is that of a spring of constant κ/V0 whose length is V.
    kinds = [(["i", "j"], springs, springs["stiffness"], springs["rest_length"])]
    for c in cells:
        if "initial_pressure" in c.dtype.names:
            raise SystemExit("cells.csv: cells under pressure; take route = 'volume energy'")
        kinds.append(
            ([f"p{k}" for k in range(len(c.dtype) - 4)], c, c["kappa"] / c["volume"], c["volume"])
        )
    parts = [
        (np.stack([t[n] for n in names], 1).astype(int), k, size) for names, t, k, size in kinds
    ]
    slopes = [(measure(x, nodes)[1], k) for nodes, k, _ in parts]
    K = sparse.csr_array(sum((slope.T * k) @ slope for slope, k in slopes))
    u, inner = start.ravel().copy(), K[free][:, free]
    scale = sparse.diags_array(1 / inner.diagonal())
    u[free], _ = sparse.linalg.cg(inner, (load.ravel() - K @ u)[free], rtol=1e-13, M=scale)
    if move:  # at .9 of the limit (Gershgorin's circles), damped as suits what the load moves
        dt, at_rest = 1.8 / np.sqrt((abs(K).sum(1) / mass).max()), u
        loss = dt * np.sqrt(u @ (K @ u) / (u @ (mass * u)))
        u, v = start.ravel().copy(), np.zeros(x.size)
        for _ in range(int(20 / loss)):
            now = ((*measure(x + u.reshape(x.shape), nodes), k, rest) for nodes, k, rest in parts)
            pull = load.ravel() + sum(slope.T @ (k * (rest - size)) for size, slope, k, rest in now)
            v = ((1 - loss) * v + dt * free * pull / mass) / (1 + loss)
            u += dt * v
        off = np.abs(u - at_rest).max() / np.abs(u).max()
        print(f"{int(20 / loss)} steps of {dt:.4g} s; {off:.2g} of the largest from first order")
    return u.reshape(x.shape)


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    u = solve(Path(sys.argv[1]), "--move" in sys.argv)
    rows = np.column_stack([np.arange(len(u)), u])
    header = "id,ux,uy,uz"[: 2 + 3 * u.shape[1]]
    np.savetxt(sys.argv[2], rows, "%.17g", ",", header=header, comments="")
    print(f"{len(u)} points, largest displacement {np.abs(u).max():.6g} m; {sys.argv[2]} written")
