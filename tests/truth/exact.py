"""Equilibria of spring networks in some 120 digits: what the solvers' answers are held to.

Written from the energies alone and solved by a factor of its own: nothing is shared with the
package. All inputs are exact binary numbers. A spring whose rest length is the rounded distance of
its points is at rest.

    spring  E = ½ k (l - L0)²            plane cell  U = ½ (κ/V0) (V - V0)²
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass

import numpy as np
from flint import arb, ctx
from scipy.sparse import coo_array
from scipy.sparse.csgraph import reverse_cuthill_mckee

from msvalidate.springs.network import Network

ctx.prec = 420
ZERO, HALF = arb(0), arb(1) / 2
AT_REST = 4 * np.finfo(float).eps
"""Relative difference of a rest length from the distance that is the distance's own rounding."""
Rows = dict[int, dict[int, arb]]


class SingularError(Exception):
    """A pivot may be zero, or Newton's method does not arrive."""


@dataclass(frozen=True)
class Exact:
    """A displacement to many digits, (n·d) point-major, and the negative pivots of its tangent."""

    displacement: list[arb]
    negative: int

    def error_of(self, displacement: np.ndarray) -> float:
        """Largest error of a displacement (n, d) over the largest displacement."""
        off = max(
            abs(float((arb(float(u)) - t).mid()))
            for u, t in zip(displacement.ravel(), self.displacement, strict=True)
        )
        largest = max(abs(float(t.mid())) for t in self.displacement)
        return off / largest if largest else (np.inf if off else 0.0)


def linear(network: Network) -> Exact:
    """What the tangent at the reference points answers to loads and prescribed displacements."""
    order, free = _order(network), ~network.fixed.ravel()
    balance, rows = _balance_and_tangent(network, [ZERO] * free.size)
    u = [arb(float(value)) for value in network.displacement.ravel()]
    load = [
        balance[p] - sum((K * u[q] for q, K in rows[p].items() if not free[q]), ZERO) for p in order
    ]
    factor = _factor(rows, order)
    for p, value in zip(order, _solved(factor, load), strict=True):
        u[p] = value
    return Exact(u, _negative(factor))


def nonlinear(network: Network, start: np.ndarray, most: int = 12) -> Exact:
    """The equilibrium that Newton's method finds from a displacement (n, d) close by."""
    order = _order(network)
    given = np.where(network.fixed, network.displacement, start).ravel()
    u = [arb(float(value)) for value in given]
    for _ in range(most):
        balance, rows = _balance_and_tangent(network, u)
        factor = _factor(rows, order)
        move = _solved(factor, [balance[p] for p in order])
        for p, value in zip(order, move, strict=True):
            u[p] = (u[p] + value).mid()
        size = max(abs(float(v.mid())) for v in u)
        if max(abs(float(v.mid())) for v in move) <= 1e-30 * size:
            return Exact(u, _negative(factor))
    raise SingularError


def _balance_and_tangent(network: Network, u: list[arb]) -> tuple[list[arb], Rows]:
    """Out-of-balance force on all components, and the tangent's rows, at a displacement."""
    d = network.dim
    x = [arb(float(c)) for c in network.points.ravel()]
    now = [a + b for a, b in zip(x, u, strict=True)]
    balance = [arb(float(f)) for f in network.force.ravel()]
    rows: Rows = defaultdict(lambda: defaultdict(lambda: ZERO))
    for (i, j), stiffness, rest_length in zip(
        network.springs.tolist(), network.stiffness, network.rest_length, strict=True
    ):
        apart = [x[j * d + a] - x[i * d + a] for a in range(d)]
        v = [now[j * d + a] - now[i * d + a] for a in range(d)]
        distance, length = (sum((c * c for c in w), ZERO).sqrt() for w in (apart, v))
        rest, k = arb(float(rest_length)), arb(float(stiffness))
        if abs(float((rest - distance).mid())) <= AT_REST * float(distance.mid()):
            rest = distance
        unit = [c / length for c in v]
        across = k * (1 - rest / length)
        for a in range(d):
            pull = k * (length - rest) * unit[a]
            balance[i * d + a] += pull
            balance[j * d + a] -= pull
            for b in range(d):
                entry = (k - across) * unit[a] * unit[b] + (across if a == b else ZERO)
                for p, q, sign in ((i, i, 1), (j, j, 1), (i, j, -1), (j, i, -1)):
                    rows[p * d + a][q * d + b] += sign * entry
    if network.volumes is not None:
        for cell, kappa in zip(
            network.volumes.cells.tolist(), network.volumes.stiffness, strict=True
        ):
            _add_cell(cell, arb(float(kappa)), x, now, balance, rows)
    return balance, rows


def _add_cell(
    cell: list[int], kappa: arb, x: list[arb], now: list[arb], balance: list[arb], rows: Rows
) -> None:
    """Add a plane cell of area V = ½ Σ (x_i y_j - x_j y_i) over its edges (i, j)."""
    edges = list(zip(cell, cell[1:] + cell[:1], strict=True))
    V0, V = (
        HALF * sum((z[2 * i] * z[2 * j + 1] - z[2 * j] * z[2 * i + 1] for i, j in edges), ZERO)
        for z in (x, now)
    )
    g: dict[int, arb] = defaultdict(lambda: ZERO)
    pressure = kappa * (V / V0 - 1)
    for i, j in edges:
        for p, q, sign in ((2 * i, 2 * j + 1, HALF), (2 * j, 2 * i + 1, -HALF)):
            g[p] += sign * now[q]
            g[q] += sign * now[p]
            rows[p][q] += sign * pressure
            rows[q][p] += sign * pressure
    for p, slope in g.items():
        balance[p] -= pressure * slope
        for q, other in g.items():
            rows[p][q] += kappa / V0 * slope * other


def _order(network: Network) -> list[int]:
    """Free components, their points in Cuthill and McKee's order."""
    (n, d), (i, j) = network.points.shape, network.springs.T
    ends = [(i, j)]
    if network.volumes is not None:
        c = network.volumes.cells
        ends += [(c[:, a], c[:, b]) for a in range(c.shape[1]) for b in range(a)]
    a, b = (np.concatenate(side) for side in zip(*ends, strict=True))
    graph = coo_array((np.ones(2 * len(a)), (np.r_[a, b], np.r_[b, a])), shape=(n, n)).tocsr()
    points = reverse_cuthill_mckee(graph, symmetric_mode=True)
    return [
        p * d + axis for p in points.tolist() for axis in range(d) if not network.fixed[p, axis]
    ]


def _factor(rows: Rows, order: list[int]) -> list[tuple[int, list[arb], arb]]:
    """LDLᵀ by rows within the envelope: first column, L's row from there on, and the pivot.

    Midpoints go on, intervals do not: those of a long elimination grow without need.
    """
    place = {p: row for row, p in enumerate(order)}
    factor: list[tuple[int, list[arb], arb]] = []
    for p in order:
        entries = {place[q]: K for q, K in rows[p].items() if q in place and place[q] <= place[p]}
        r = place[p]
        first = min(entries, default=r)
        line = [entries.get(c, ZERO) for c in range(first, r)]  # becomes L·D, then L
        for c in range(first, r):
            start, other, _ = factor[c]
            low = max(first, start)
            total = line[c - first]
            for m in range(low, c):
                total -= line[m - first] * other[m - start]
            line[c - first] = total.mid()
        pivot = entries.get(r, ZERO)
        for c in range(first, r):
            scaled = (line[c - first] / factor[c][2]).mid()
            pivot -= scaled * line[c - first]
            line[c - first] = scaled
        if pivot.mid() == 0:
            raise SingularError
        factor.append((first, line, pivot.mid()))
    return factor


def _solved(factor: list[tuple[int, list[arb], arb]], load: list[arb]) -> list[arb]:
    z = list(load)
    for r, (first, line, _) in enumerate(factor):
        z[r] = (z[r] - sum((entry * z[c] for c, entry in enumerate(line, first)), ZERO)).mid()
    z = [value / pivot for value, (_, _, pivot) in zip(z, factor, strict=True)]
    for r in range(len(z) - 1, -1, -1):
        first, line, _ = factor[r]
        for c, entry in enumerate(line, first):
            z[c] = (z[c] - entry * z[r]).mid()
    return z


def _negative(factor: list[tuple[int, list[arb], arb]]) -> int:
    """Negative eigenvalues, by Sylvester's law of inertia."""
    return sum(1 for _, _, pivot in factor if pivot < 0)
