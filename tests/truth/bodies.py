"""Random spring networks that solvers get wrong if they can: slender, stiff beside soft, far away,
barely strained or strained by a third, prestressed."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import Delaunay

from msvalidate.springs.dynamics.relaxations import RELAXATIONS
from msvalidate.springs.network import Network, spring_network
from msvalidate.springs.network.laws.volumes import Volumes
from tests.truth import exact

FEW_DECADES = 3.0
"""Of stiffnesses for a relaxation: its steps grow as the root of their ratio."""


@dataclass(frozen=True)
class Body:
    """A network, how it is to be solved, and what makes it hard.

    `method` is "linear", "nonlinear" or the name of a relaxation; `slender` the body's length over
    its height, `decades` those of its stiffnesses, `away` its distance from the origin over its
    size, `strain` the largest that the linear answer has.
    """

    seed: int
    network: Network
    method: str
    slender: float
    decades: float
    away: float
    strain: float
    prestressed: bool

    @property
    def ordinary(self) -> bool:
        """Whether an engineer would call it so: nearly all of these must be answered."""
        return (
            self.slender <= 1e3
            and self.decades <= 6
            and self.away <= 1e3
            and not self.prestressed
            and (self.method == "linear" or self.strain <= 0.05)
        )

    def __str__(self) -> str:
        return (
            f"seed {self.seed}, {self.method}: {len(self.network.points)} points in "
            f"{self.network.dim}D, {self.slender:.3g}:1, {self.decades:.3g} decades of stiffness, "
            f"{self.away:.3g} sizes away, strain {self.strain:.2g}"
            + (", prestressed" if self.prestressed else "")
        )


def body(seed: int) -> Body | None:
    """The body of a seed; None where its tangent is singular or nothing of it is free."""
    rng = np.random.default_rng(seed)
    method = _method(rng)
    points, springs, cells = _shape(rng, small=method not in {"linear", "nonlinear"})
    slender = _slender(points)
    decades = float(rng.choice([0, rng.uniform(0, 6), rng.uniform(6, 12)]))
    if method in RELAXATIONS:
        decades = min(decades, FEW_DECADES)
    away = float(rng.choice([0, 10 ** rng.uniform(0, 3), 10 ** rng.uniform(3, 7)]))
    unit = float(rng.choice([1.0, 0.37, 10 ** rng.uniform(-6, 6)]))
    clamped = np.isclose(points[:, 0], points[:, 0].min())
    end = np.isclose(points[:, 0], points[:, 0].max())
    middle = points[springs, 0].mean(axis=1) / np.ptp(points[:, 0])
    points = _placed(rng, points * unit, away)
    stiffness = 10 ** rng.uniform(-6, 6) * _stiffness(rng, springs, middle, decades)
    prestressed = bool(rng.random() < 0.15)
    distance = np.linalg.norm(points[springs[:, 1]] - points[springs[:, 0]], axis=1)
    rest = distance * rng.uniform(0.7, 1.05, len(springs)) if prestressed else distance
    held, displacement, force = _loads(rng, points, clamped, end)
    network = spring_network(
        points, springs, stiffness, rest_length=rest, fixed=held, displacement=displacement,
        force=force * stiffness.min(), volumes=_volumes(rng, points, cells, stiffness.min()),
    )  # fmt: skip
    strain = 10 ** rng.uniform(-9, -0.5)
    if held.all():
        return None
    try:
        scaled = _scaled(network, strain, prestressed)
    except exact.SingularError:
        return None
    return Body(seed, scaled, method, slender, decades, away, strain, prestressed)


def _method(rng: np.random.Generator) -> str:
    part = rng.random()
    if part < 0.45:
        return "linear"
    return "nonlinear" if part < 0.85 else str(rng.choice(sorted(RELAXATIONS)))


def _shape(
    rng: np.random.Generator, *, small: bool
) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
    """Points, springs and quadrilateral cells of a strip, a triangulation, or a solid."""
    kind = rng.choice(["strip", "strip", "strip", "chain", "triangles", "solid"])
    if kind == "solid":
        sides = rng.integers(1, 3 if small else 4, 3) + 1
        points = _grid(sides) * np.array([10 ** rng.uniform(0, 2), 1.0, rng.uniform(0.5, 2)])
        return points, _near(_grid(sides)), None
    if kind == "triangles":
        sides = rng.integers(3, 6 if small else 9, 2)
        grid = _grid(sides)
        inside = (grid[:, 0] > 0) & (grid[:, 0] < sides[0] - 1)
        points = grid + inside[:, None] * rng.uniform(-0.3, 0.3, grid.shape)
        corners = Delaunay(points).simplices
        pairs = np.sort(np.vstack([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [0, 2]]]))
        return points * [10 ** rng.uniform(0, 2), 1.0], np.unique(pairs, axis=0), None
    if kind == "chain" and not small:  # slender by many cells
        sides = np.array([int(10 ** rng.uniform(1, 2.7)), int(rng.integers(1, 3))]) + 1
        aspect = 10 ** rng.uniform(0, 1.3)
    else:  # slender by long cells
        sides = np.array([rng.integers(1, 5 if small else 13), rng.integers(1, 4)]) + 1
        aspect = 10 ** rng.uniform(0, 1 if small else 3.3)
    number = np.arange(sides.prod()).reshape(sides)
    cells = np.stack([number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]], -1)
    return _grid(sides) * [aspect, 1.0], _near(_grid(sides)), cells.reshape(-1, 4)


def _grid(sides: np.ndarray) -> np.ndarray:
    axes = np.meshgrid(*map(np.arange, sides), indexing="ij")
    return np.stack(axes, axis=-1).reshape(-1, len(sides)).astype(float)


def _near(grid: np.ndarray) -> np.ndarray:
    """Pairs of points of a grid that are a step apart in every axis at the most."""
    apart = np.abs(grid[:, None] - grid[None]).max(axis=2)
    return np.argwhere(np.triu(apart == 1))


def _slender(points: np.ndarray) -> float:
    size = np.ptp(points, axis=0)
    return float(size.max() / size.min())


def _placed(rng: np.random.Generator, points: np.ndarray, away: float) -> np.ndarray:
    """Turned, in half of all cases, and moved away from the origin."""
    d = points.shape[1]
    if rng.random() < 0.5:
        turn, _ = np.linalg.qr(rng.normal(size=(d, d)))
        points = points @ turn
    direction = rng.normal(size=d)
    size = float(np.ptp(points, axis=0).max())
    return points + away * size * direction / np.linalg.norm(direction)


def _stiffness(
    rng: np.random.Generator, springs: np.ndarray, middle: np.ndarray, decades: float
) -> np.ndarray:
    """One half stiff, or each spring its own, over so many decades."""
    if rng.random() < 0.5:
        return np.where(middle > rng.uniform(0.2, 0.8), 10**decades, 1.0)
    return 10 ** rng.uniform(0, max(decades, 0.3), len(springs))


def _loads(
    rng: np.random.Generator, points: np.ndarray, clamped: np.ndarray, end: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Held components, their displacements, and forces, in units to be scaled."""
    n, d = points.shape
    held, move, force = np.zeros((n, d), dtype=bool), np.zeros((n, d)), np.zeros((n, d))
    held[clamped] = True
    way = rng.choice(["end force", "end moved", "all", "both"])
    size = float(np.ptp(points, axis=0).max())
    if way in {"end moved", "both"}:
        held[end] = True
        move[end] = 1e-3 * size * rng.normal(size=d)
    if way == "end force":
        force[end] = size * rng.normal(size=d)
    if way in {"all", "both"}:
        force = 1e-3 * size * rng.normal(size=(n, d))
    force[held] = 0.0
    return held, move, force


def _volumes(
    rng: np.random.Generator, points: np.ndarray, cells: np.ndarray | None, softest: float
) -> Volumes | None:
    if cells is None or rng.random() < 0.7:
        return None
    corners = points[cells]
    a, b = corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]
    turned = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0] < 0
    cells = np.where(turned[:, None], cells[:, ::-1], cells)
    return Volumes(points, cells, np.full(len(cells), softest * 10 ** rng.uniform(-1, 2)))


def _scaled(network: Network, strain: float, prestressed: bool) -> Network:
    """Loads such that the linear answer strains the most strained spring by `strain`."""
    if prestressed:
        size = float(np.ptp(network.points, axis=0).max())
        push = max(float(np.abs(network.force).max()), 1e-300)
        shift = max(float(np.abs(network.displacement).max()), 1e-300)
        return replace(
            network,
            force=network.force * (strain * network.stiffness.min() * size / push),
            displacement=network.displacement * (strain * size / len(network.points) / shift),
        )
    answer = exact.linear(network)
    move = np.array([float(u.mid()) for u in answer.displacement]).reshape(network.points.shape)
    i, j = network.springs.T
    vector = network.vector
    along = ((move[j] - move[i]) * vector).sum(axis=1) / (vector**2).sum(axis=1)
    factor = strain / float(np.abs(along).max())
    return replace(
        network, force=network.force * factor, displacement=network.displacement * factor
    )
