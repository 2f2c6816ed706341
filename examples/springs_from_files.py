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


def measure(p, under):
    """Lengths (m,) of springs, their squares' halves or volumes of cells, and slopes (m, k, d)."""
    if p.shape[1] == 2:
        slope = np.stack([p[:, 0] - p[:, 1], p[:, 1] - p[:, 0]], 1)
        square = (slope[:, 1] ** 2).sum(1)
        return (square / 2, slope) if under else (square**0.5, slope / square[:, None, None] ** 0.5)
    d = p.shape[2]
    if d == 2:  # the shoelace formula
        across = (np.roll(p, -1, 1) - np.roll(p, 1, 1)) / 2
        slope = np.stack([across[..., 1], -across[..., 0]], -1)
    else:  # of faces a, b, c, d, bilinear: (a + b + c + d) . (c - a) x (d - b) / 24
        slope, faces = (
            np.zeros(p.shape),
            np.array([[*map(int, f)] for f in FACES[p.shape[1]].split()]),
        )
        a, b, c, e = np.moveaxis(p[:, faces], 2, 0)
        f, g, h = (
            np.cross(*pair)
            for pair in ((c - a, e - b), (e - b, a + b + c + e), (a + b + c + e, c - a))
        )
        for corner, part in zip(faces.T, (f - g, f - h, f + g, f + h), strict=True):
            np.add.at(slope, (slice(None), corner), part / 24)
    return (p * slope).sum((1, 2)) / d, slope  # as it grows with x to the power d


class Parts:
    """Springs, or cells: their points, and what they store by their size."""

    def __init__(self, x, nodes, k, size, pressure=None):
        """Springs (m, 2) of constant k and length at rest, or cells (c, k) of κ and volume."""
        self.x, self.nodes, self.k, self.size, self.pressure = x, nodes, k, size, pressure
        # Of springs of no rest length, k L²/2, and of cells under pressure, at rest too.
        self.under = pressure is not None or (nodes.shape[1] == 2 and not size.any())

    def local(self, u):
        """Places (m, k, d) from the first point of each."""
        return (self.x + u)[self.nodes] - (self.x + u)[self.nodes[:, :1]]

    def slopes(self, size):
        """First and second derivative (m,) of what is stored by the size."""
        if self.nodes.shape[1] == 2:
            return (self.k, 0 * self.k) if self.under else (self.k * (size - self.size), self.k)
        if not self.under:  # κ V0 (V/V0 - 1)²/2
            return self.k * (size / self.size - 1), self.k / self.size
        J, log = size / self.size, np.log(size / self.size)  # V0 (-p ln J + λ ln²J / 2)
        k, p = self.k, self.pressure
        return (k * log - p) / J, (k - k * log + p) / J**2 / self.size

    def force(self, u):
        """Forces (n, d)."""
        size, slope = measure(self.local(u), self.under)
        out = np.zeros(self.x.shape)
        np.add.at(out, self.nodes, -self.slopes(size)[0][:, None, None] * slope)
        return out

    def stiffness(self):
        """Matrix (n d, n d) at rest."""
        p = self.local(0)
        size, g = measure(p, self.under)
        pull, hard = self.slopes(size)
        (m, k, d), step = p.shape, np.ptp(p, axis=(0, 1)).max()
        block = hard[:, None, None, None, None] * g[:, :, :, None, None] * g[:, None, None]
        for corner in range(k * self.under):  # sizes are of degree 3 at most: differences are exact
            for axis in range(d):
                move = np.zeros((k, d))
                move[corner, axis] = step
                change = measure(p + move, True)[1] - measure(p - move, True)[1]
                block[:, :, :, corner, axis] += pull[:, None, None] * change / (2 * step)
        dof = (self.nodes[..., None] * d + np.arange(d)).reshape(m, k * d)
        rows, columns = np.repeat(dof, k * d, axis=1), np.tile(dof, k * d)
        at = (rows.ravel(), columns.ravel())
        return sparse.csr_array(sparse.coo_array((block.ravel(), at), shape=[self.x.size] * 2))


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
    ends = np.stack([springs["i"], springs["j"]], 1).astype(int)
    parts = [Parts(x, ends, springs["stiffness"], springs["rest_length"])]
    for c in cells:
        nodes = np.stack([c[n] for n in c.dtype.names if n[0] == "p" and n[1:].isdigit()], 1)
        pressure = c["initial_pressure"] if "initial_pressure" in c.dtype.names else None
        parts.append(Parts(x, nodes.astype(int), c["kappa"], c["volume"], pressure))
    K = sparse.csr_array(sum(part.stiffness() for part in parts))
    u, inner = start.ravel().copy(), K[free][:, free]
    scale = sparse.diags_array(1 / inner.diagonal())
    u[free], _ = sparse.linalg.cg(inner, (load.ravel() - K @ u)[free], rtol=1e-13, M=scale)
    if move:  # at .9 of the limit (Gershgorin's circles), damped as suits what the load moves
        dt, at_rest = 1.8 / np.sqrt((abs(K).sum(1) / mass).max()), u
        loss = dt * np.sqrt(u @ (K @ u) / (u @ (mass * u)))
        u, v = start.ravel().copy(), np.zeros(x.size)
        for _ in range(int(20 / loss)):
            pull = load + sum(part.force(u.reshape(x.shape)) for part in parts)
            v = ((1 - loss) * v + dt * free * pull.ravel() / mass) / (1 + loss)
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
