"""The same steps in NumPy and in SciPy: what a user would write first, and the oracle of paths."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.sparse import csr_array

from msvalidate import kit
from msvalidate.springs.network import internal_force

Force = Callable[[kit.Array], kit.Array]
"""Force (n, d) in N of all springs at displacements (n, d) in m."""


def advance(
    net: kit.Network,
    force: Force,
    u: kit.Array,
    v: kit.Array,
    keep: kit.Array,
    push: kit.Array,
    dt: float,
    steps: int,
) -> None:
    """Steps v = keep·v + push·F/m, u += dt·v in place, what is held stays: as `kernels`."""
    kick = np.where(net.fixed, 0.0, (push / net.mass)[:, None])
    for _ in range(steps):
        v *= keep[:, None]
        v += kick * (force(u) + net.force)
        u += dt * v


def whole(net: kit.Network) -> Force:
    """The package's plain form, of springs and cells."""
    return lambda u: internal_force(net, net.points + u)


def by_bincount(net: kit.Network) -> Force:
    """Springs alone, sums over points by `bincount`, a component at a time."""
    i, j = (np.ascontiguousarray(end) for end in net.springs.T)
    vector = np.ascontiguousarray(net.vector.T)
    both, count = np.concatenate([i, j]), len(net.points)

    def force(u: kit.Array) -> kit.Array:
        now = [x + (c[j] - c[i]) for x, c in zip(vector, u.T.copy(), strict=True)]
        length = np.sqrt(sum(x * x for x in now))
        pull = net.stiffness - net.stiffness * net.rest_length / length
        out = np.empty_like(u)
        for axis, x in enumerate(now):
            part = pull * x
            out[:, axis] = np.bincount(both, np.concatenate([part, -part]), count)
        return out

    return force


def by_sparse(net: kit.Network) -> Force:
    """Springs alone, differences and sums by the matrix of which springs meet which points."""
    m, n = len(net.springs), len(net.points)
    rows = np.repeat(np.arange(m), 2)
    ends = np.tile([-1.0, 1.0], m)
    apart = csr_array((ends, (rows, net.springs.ravel())), shape=(m, n))
    gather = csr_array(apart.T)

    def force(u: kit.Array) -> kit.Array:
        now = net.vector + apart @ u
        length = np.sqrt((now * now).sum(axis=1))
        pull = net.stiffness - net.stiffness * net.rest_length / length
        return np.asarray(gather @ (-pull[:, None] * now))

    return force
