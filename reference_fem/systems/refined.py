"""Iterative refinement: residuals summed cell by cell, the factor again, and what error is left.

A factor of a slender body's matrix is off by the rounding of the entries times the condition, which
grows as the fourth power of length over thickness: at 10,000 to 1 nothing is left. The residual of
an answer, though, can be had from strains of differences (`Gradients`) far more exactly, and the
same factor turns it into a correction ([Wilkinson1963], chapter 3; [Higham2002], chapter 12). Where
even that does not contract, corrections are combined so that the energy of the error is least, as
in conjugate gradients with every direction kept [Notay2000].
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

import numpy as np

from msvalidate.problem import Array, Mask
from msvalidate.problem.records import dataclass

QUICK = 1e-10
"""A first correction this small, relative to the answer, leaves nothing but rounding: no more than
its square, were it not for directions that the inverse knows less well, and those were 1e5 times as
bad."""
NEAR = 1e-14
"""Corrections below this, relative to the answer, change no more than its rounding."""
SLOW = 0.1
"""Share of the correction before, from which on refinement is taken not to contract."""
SETTLED = 1e-9
"""Corrections below this that no longer shrink are what rounding leaves in the residual."""
MOST = 30
MOST_DIRECTIONS = 60
PATIENCE = 12
"""Directions that may bring no smaller correction."""
SLOWEST = 4.0
"""Times the last correction, that may be left: where most of an error is taken out at once, a part
of it may still fall by no more than a fifth."""
AGAIN = 3
"""Times that all directions are gone along once more: they are conjugate but for rounding, which a
first step of the size of the answer leaves a part of, where the inverse is blind to it."""
SQUARE = 1e5
SAMPLES, MANY = 3, 20_000
"""Samples of what rounding leaves in residuals, and unknowns from which on there is one: in so many
the largest part is none of chance."""
SAMPLE = 16.0
"""Factor on the largest sample: one in 25 normal variables is that much smaller than its like, and
the rounding of constants, as large as any, is in no sample."""
REWRITTEN = 2.0**-24
"""Part of an unknown by which its two numbers are changed against each other for a sample."""
CAUTION = 2.0
"""Times a correction that was made roughly, for what is left after it."""
LEAST = 128 * float(np.finfo(float).eps)
"""What is rounded before there are equations: constants, points and weights of integration, and the
products of 27 functions there."""

Inverse = Callable[[Array], Array]
"""Corrections (f, r) of residuals (f, r) on the free unknowns."""


class System(Protocol):
    """Linear equations whose residual is summed cell by cell.

    Their unknowns are an array of any shape, which loads and forces have too.
    """

    @property
    def positive(self) -> bool:
        """Whether every motion takes energy."""

    def strain(self, u: Array, rest: Array | None = None) -> Any:
        """What costs energy, of unknowns and the digits that these lack."""

    def stress(self, strain: Any) -> Any:
        """What goes with it in the energy, measured."""

    def forces(self, stress: Any) -> Array:
        """Forces that the unknowns feel."""

    def noise(self, u: Array, rest: Array, force: Array, number: int) -> Array:
        """Forces as rounding makes them in `force`, which is that of u: sample of a number."""


@dataclass(frozen=True, eq=False)
class Refined:
    """A solution, its remainder beyond double precision, and an error estimate.

    Parameters
    ----------
    value, rest
        The answer is their sum.
    error
        Largest error of an unknown that counts, relative to the largest of these.
    corrections
        How many there were.
    """

    value: Array
    rest: Array
    error: float
    corrections: int


def refine_solution(
    system: System,
    inverse: Inverse,
    start: Array,
    load: Array,
    free: Mask,
    *,
    sample: bool = True,
    counted: Mask | None = None,
) -> Refined:
    """The solution that a start leads to, under loads.

    Parameters
    ----------
    system
        The equations.
    inverse
        Nearly their inverse, on free unknowns.
    start
        The first answer, with what is held at its values.
    load, free
        Loads, and which unknowns are sought, both of the shape of the unknowns.
    sample
        Whether `inverse` is so cheap that what rounding leaves in residuals can be sampled.
    counted
        Unknowns whose error is judged; all by default.
    """
    judged = np.ones(start.shape, dtype=bool) if counted is None else counted
    work = _Work(system, inverse, load, free, judged, start.copy(), np.zeros(start.shape))
    if not free.any() or not np.isfinite(start).all():
        return Refined(start, work.rest, 0.0, 0)
    force = work.force()
    residual, noises = (load - force)[free], work.noises(force) if sample else []
    first = inverse(np.stack([residual, *noises], axis=1)).T
    size = work.corrected(first[0])
    if size <= QUICK:
        left = CAUTION * size
        if sample:
            left = SQUARE * size**2 + SAMPLE * max(map(work.relative, first[1:]))
        return work.ended(left, 1)
    return _refine_slowly(work, size, sample)


def _refine_slowly(work: _Work, size: float, sample: bool) -> Refined:
    """Refinement whose first correction is no rounding."""
    count, last = 1, 1.0
    while np.isfinite(size) and count < MOST:
        if size * min(1.0, size / last) <= NEAR:
            break
        if size > SLOW * last and count > 1:
            if size <= SETTLED:
                break
            if work.system.positive:
                more, size = _minimise_along_directions(work)
                return work.ended(SLOWEST * size + work.sampled(sample), count + more)
            if size > last:
                break
        last = size
        size = work.corrected(work.inverse(work.residual(work.stress())[:, None])[:, 0])
        count += 1
    return work.ended(SLOWEST * size + work.sampled(sample), count)


def _minimise_along_directions(work: _Work) -> tuple[int, float]:
    """Steps along directions, and the largest correction of the last ones.

    Source: flexible conjugate gradients, [Notay2000].
    """
    sizes: list[float] = []
    while len(sizes) < MOST_DIRECTIONS:
        stress = work.stress()
        way = work.spread(work.inverse(work.residual(stress)[:, None])[:, 0])
        if not work.kept(way):
            break
        sizes.append(work.along(work.directions[-1], stress))
        best = int(np.argmin(sizes))
        if sizes[-1] <= NEAR or len(sizes) - best > PATIENCE:
            break
        if len(sizes) > 2 and max(sizes[-3:]) <= SETTLED and sizes[-1] > SLOW * sizes[-2]:
            break
    last, steps = np.inf, len(sizes)
    for _ in range(AGAIN if work.directions else 0):
        size = max(work.along(way, work.stress()) for way in work.directions)
        steps += len(work.directions)
        if size <= NEAR or size > SLOW * last:
            return steps, size
        last = size
    return steps, last


@dataclass(eq=False)
class _Work:
    """An intermediate solution `value` + `rest`, and the search directions so far."""

    system: System
    inverse: Inverse
    load: Array
    free: Mask
    counted: Mask
    value: Array
    rest: Array

    def __post_init__(self) -> None:
        self.directions: list[tuple[Array, Any]] = []

    def stress(self) -> Any:
        return self.system.stress(self.system.strain(self.value, self.rest))

    def force(self) -> Array:
        """Forces that the unknowns feel now."""
        return self.system.forces(self.stress())

    def residual(self, stress: Any) -> Array:
        """Forces left on the free unknowns (f,)."""
        return np.asarray((self.load - self.system.forces(stress))[self.free])

    def spread(self, part: Array) -> Array:
        """Unknowns, zero where held, of the free ones (f,)."""
        every = np.zeros(self.value.shape)
        every[self.free] = part
        return every

    def relative(self, part: Array) -> float:
        """Largest of a correction, relative to the answer."""
        largest = float(np.abs(self.value[self.counted]).max())
        size = float(np.abs(part[self.counted[self.free]]).max(initial=0.0))
        return size / largest if largest else (np.inf if size else 0.0)

    def corrected(self, part: Array) -> float:
        """Add a correction (f,); its size, relative."""
        self.add(self.spread(part))
        return self.relative(part)

    def add(self, change: Array) -> None:
        """Add to the answer, and keep the digits that it cannot hold."""
        self.value, self.rest = add_with_remainder(self.value, self.rest, change)

    def kept(self, way: Array) -> bool:
        """Make a direction conjugate to all before and keep it; False if it has no energy."""
        strain = self.system.strain(way)
        for _ in range(2):  # once leaves what rounding makes of it
            shares = [_dot(strain, stress) for _, stress in self.directions]
            for share, (before, _) in zip(shares, self.directions, strict=True):
                way = way - share * before
            strain = self.system.strain(way)
        stress = self.system.stress(strain)
        energy = _dot(strain, stress)
        if not (np.isfinite(energy) and energy > 0):
            return False
        size = np.sqrt(energy)
        self.directions.append((way / size, stress / size))
        return True

    def along(self, direction: tuple[Array, Array], stress: Array) -> float:
        """Go along a direction to the least energy; the size of that correction, relative."""
        way = direction[0]
        share = float(_dot(way, self.load)) - _dot(self.system.strain(way), stress)
        self.add(share * way)
        return self.relative(share * way[self.free])

    def noises(self, force: Array) -> list[Array]:
        """Samples (f,) of what rounding leaves in residuals; `force` is that of the unknowns."""
        count = SAMPLES if np.count_nonzero(self.free) <= MANY else 1
        each = (self.system.noise(self.value, self.rest, force, k) for k in range(count))
        return [noise[self.free] for noise in each]

    def sampled(self, sample: bool) -> float:
        """What rounding leaves in residuals, as a part of the answer."""
        return SAMPLE * max(map(self.answered, self.noises(self.force()))) if sample else 0.0

    def answered(self, noise: Array) -> float:
        """What forces (f,) make of unknowns, relative to the answer, by directions and inverse."""
        force = self.spread(noise)
        found = np.zeros(force.shape)
        for way, pull in self.directions:
            share = _dot(way, force)
            found += share * way
            force = force - self.spread(share * self.system.forces(pull)[self.free])
        rest = self.spread(self.inverse(force[self.free][:, None])[:, 0])
        if self.directions:  # the inverse does not know their stiffness
            strain = self.system.strain(rest)
            for way, pull in self.directions:
                rest = rest - _dot(strain, pull) * way
        return self.relative((found + rest)[self.free])

    def ended(self, left: float, corrections: int) -> Refined:
        error = left + LEAST if np.isfinite(left) else np.inf
        if not np.abs(self.value[self.counted]).max():
            error = 0.0 if left == 0 else np.inf
        return Refined(self.value, self.rest, float(error), corrections)


def change_by_rewriting(
    system: System, value: Array, rest: Array, force: Array, number: int
) -> Array:
    """What another way to write the same unknowns, as two numbers each, changes in their forces.

    It is rounding and nothing else: a sample of it, a number's its own.
    """
    change = REWRITTEN * np.random.default_rng(number).uniform(-1, 1, value.shape) * value
    other, less = add_with_remainder(value, np.zeros_like(rest), change)
    return system.forces(system.stress(system.strain(other, rest - change + less))) - force


def add_with_remainder(value: Array, rest: Array, change: Array) -> tuple[Array, Array]:
    """A sum of value and rest with a change, as its doubles and the digits that these cannot hold.

    The rounding of a sum is a double itself, and six operations find it ([Knuth1997],
    section 4.2.2).
    """
    change = change + rest
    total = value + change
    part = total - value
    return total, (value - (total - part)) + (change - part)


def _dot(a: Array, b: Array) -> float:
    """Sum of products, in one order."""
    return float(np.einsum("i,i", a.ravel(), b.ravel()))
