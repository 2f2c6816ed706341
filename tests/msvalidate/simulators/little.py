"""A little simulator of our own for tests: linear tetrahedra of any law P(F), one step from rest.

Nothing of the code under test is used: forces go by the cells' own edges.
"""

from __future__ import annotations

import numpy as np

from msvalidate.simulators.exchange.protocol import Answer


def lame(E, nu):
    return E / 2 / (1 + nu), E * nu / (1 + nu) / (1 - 2 * nu)


def linear(C):
    """P(F) of a stiffness (6, 6), in order xx, yy, zz, yz, xz, xy with engineering strains."""

    def stress(F):
        e = (F + F.transpose(0, 2, 1)) / 2 - np.eye(3, dtype=F.dtype)
        rows = [e[:, 0, 0], e[:, 1, 1], e[:, 2, 2], 2 * e[:, 1, 2], 2 * e[:, 0, 2], 2 * e[:, 0, 1]]
        s = np.stack(rows, axis=1) @ C.astype(F.dtype).T
        return s[:, [0, 5, 4, 5, 1, 3, 4, 3, 2]].reshape(-1, 3, 3)

    return stress


def isotropic(mu, lam):
    C = np.diag([2 * mu] * 3 + [mu] * 3).astype(float)
    C[:3, :3] += lam
    return C


class Tetrahedra:
    """Forces of a law on the nodes of a mesh, in a precision of its own."""

    def __init__(self, mesh, law, kind="float64"):
        self.cells, self.kind, self.law = mesh.cells, np.dtype(kind), law
        self.points = mesh.points.astype(kind)
        edges = self.edges(self.points)
        self.volumes = np.linalg.det(edges) / self.kind.type(6)
        self.inverse = np.linalg.inv(edges)

    def edges(self, x):
        first, *rest = np.moveaxis(x[self.cells], 1, 0)
        return np.stack([each - first for each in rest], axis=-1)

    def force(self, x):
        """(n, 3) N; what the body puts on its nodes."""
        P = self.law(self.edges(x) @ self.inverse).astype(self.kind)
        H = -self.volumes[:, None, None] * (P @ self.inverse.transpose(0, 2, 1))
        f = np.zeros(x.shape, self.kind)
        for k in range(3):
            np.add.at(f, self.cells[:, k + 1], H[:, :, k])
        np.add.at(f, self.cells[:, 0], -H.sum(axis=2))
        return f


class Springs:
    """Equal springs on the edges of a mesh, as forces."""

    def __init__(self, mesh, stiffness, kind="float64", pairs=None):
        if pairs is None:
            ends = [mesh.cells[:, [a, b]] for a in range(4) for b in range(a)]
            pairs = np.unique(np.sort(np.concatenate(ends), axis=1), axis=0)
        self.ends, self.k = pairs, stiffness
        a, b = mesh.points[self.ends].transpose(1, 0, 2)
        self.length = np.linalg.norm(b - a, axis=1).astype(kind)

    def force(self, x):
        d = x[self.ends[:, 1]] - x[self.ends[:, 0]]
        r = np.linalg.norm(d, axis=1)
        pull = (self.k * (r - self.length) / r)[:, None] * d
        f = np.zeros_like(x)
        np.add.at(f, self.ends[:, 0], pull)
        np.add.at(f, self.ends[:, 1], -pull)
        return f


def lumped(mesh, density):
    first, *rest = np.moveaxis(mesh.points[mesh.cells], 1, 0)
    volumes = np.linalg.det(np.stack([x - first for x in rest], axis=-1)) / 6
    masses = np.zeros(len(mesh.points))
    for k in range(4):
        np.add.at(masses, mesh.cells[:, k], density * volumes / 4)
    return masses


class Little:
    """A simulator: explicit or implicit Euler, lumped masses, faults on request.

    Parameters
    ----------
    make
        (mesh, kind) -> an object with `force(x)`.
    implicit, kind
        How steps are taken, and in which precision.
    masses
        (n,) kg in place of each node's share.
    outside
        (x, v) -> force (n, 3) beside the body's own.
    keep
        Part of each velocity that is left after a step: damping.
    viscous
        s: the body's damping is that many times its stiffness.
    remember
        Whether each run begins where the last one ended, by this part of its displacement.
    """

    def __init__(self, make, implicit=False, kind="float64", masses=None, outside=None, keep=1.0,
                 viscous=0.0, remember=0.0, iterations=8):  # fmt: skip
        self.make, self.implicit, self.kind = make, implicit, kind
        self.masses, self.outside, self.keep = masses, outside, keep
        self.viscous, self.remember, self.iterations = viscous, remember, iterations
        self.left, self.asked, self.stiff = 0.0, 0, None

    def __call__(self, request):
        self.asked += 1
        kind = np.dtype(self.kind)
        body = self.make(request.mesh, self.kind)
        masses = lumped(request.mesh, request.material.density)
        masses = (masses if self.masses is None else self.masses).astype(kind)[:, None]
        x = request.start.astype(kind) + kind.type(self.remember) * self.left
        dt, g = kind.type(request.dt), request.gravity.astype(kind)

        def force(y):
            f = body.force(y)
            return f + self.outside(y).astype(kind) if self.outside else f

        self.rest = request.mesh.points
        v = dt * (force(x) / masses + g)
        if self.implicit:
            v = self.solve(force, x, masses, dt, g)
        end = x + dt * v
        if self.implicit:
            v = (end - x) / dt  # as programs do that solve for positions
        v = kind.type(self.keep) * v
        self.left = end - request.mesh.points.astype(kind)
        about = {
            "simulator": "little", "precision": self.kind, "mass": "lumped",
            "forces_at": "end" if self.implicit else "start", "dt": request.dt,
        }  # fmt: skip
        return Answer(position=end.astype(float), velocity=v.astype(float), about=about)

    def solve(self, force, x, masses, dt, g):
        """Velocity of implicit Euler, by Newton with the stiffness at rest."""
        m = np.broadcast_to(masses, x.shape).astype(float).ravel()
        dt = float(dt)

        def total(z):
            return force(z.reshape(x.shape).astype(self.kind)).astype(float).ravel()

        if self.stiff is None:
            self.stiff = stiffness(total, self.rest.ravel(), self.kind)
            self.inverse = {}
        if dt not in self.inverse:
            left = np.diag(m / dt) + (dt + self.viscous) * self.stiff
            self.inverse[dt] = np.linalg.inv(left)
        y, weight, v = x.astype(float).ravel(), m * np.tile(g, len(x)), np.zeros(x.size)
        for _ in range(self.iterations):
            viscous = self.viscous * (self.stiff @ v)
            left = m * v / dt - total(y + dt * v) + viscous - weight
            v = v - self.inverse[dt] @ left
        return v.reshape(x.shape).astype(self.kind)


def stiffness(total, rest, kind):
    """-∂f/∂x (3 n, 3 n) by differences about the rest position."""
    size = 2.0**-20 if kind == "float64" else 2.0**-12
    K = np.empty((rest.size, rest.size))
    for j in range(rest.size):
        step = np.zeros(rest.size)
        step[j] = size
        K[:, j] = (total(rest - step) - total(rest + step)) / (2 * size)
    return K
