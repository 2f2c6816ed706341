"""How accurate a candidate's numbers are: stated, or read off the grid that they were rounded to.

An accuracy is relative: the largest error of a component of a position (rest point plus
displacement), over the largest coordinate of the positions. Of the coordinate and not of the body's
size, since numbers lose digits with their distance from the origin. In double precision it is
1.1e-16, in single precision 6e-8; a file with k decimals is within 10^-k/2 m.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterable, Iterator

import numpy as np

from msvalidate.judging.candidate import Answer, DisplacementSolver, check_displacement
from msvalidate.network import Network
from msvalidate.problem import Array, Problem, ProblemError
from msvalidate.problem.checks import finite_number, format_value
from msvalidate.problem.records import dataclass, field

DOUBLE = float(np.finfo(float).eps)
"""Spacing of double precision at 1 (1)."""
ROUNDING = 4 * DOUBLE
"""What a sum of two numbers that lie on a grid may miss it by, over the largest of them."""
FORMATS = (np.float16, np.float32)
"""Binary formats that numbers are asked about."""
DECIMALS, DIGITS = range(1, 13), range(3, 13)
"""Decimal places, and significant digits, that numbers are asked about."""
LEVELS = 64
"""Steps of a grid that displacements have to span to show it: an exact answer, such as uniform
strain of a lattice of 5 cells, lies on a few even steps of its own, and is not rounded."""
LEAST = 8
"""Numbers away from 0 that have to show a grid."""


@dataclass(frozen=True)
class Accurate:
    """A candidate for displacements whose accuracy is known, or can be measured.

    Parameters
    ----------
    predict
        The candidate.
    accuracy
        Relative, of its positions (see above); None has it measured.
    tighter
        The same candidate at a tighter tolerance of its own. What the two differ by is then an
        accuracy of `predict`, measured at every body.

    Raises
    ------
    ProblemError
        If the accuracy is no number from 0 to below 1, or a candidate is no function.
    """

    predict: DisplacementSolver
    accuracy: float | None = None
    tighter: DisplacementSolver | None = None

    def __post_init__(self) -> None:
        for name, solver in (("candidate", self.predict), ("tighter", self.tighter)):
            if not (callable(solver) or (name == "tighter" and solver is None)):
                raise ProblemError(f"{name}: {format_value(solver)}; give a function")
        if self.accuracy is not None:
            check_accuracy(self.accuracy)

    def __call__(self, problem: Problem, network: Network, answer: Answer = "linear") -> Array:
        """The candidate's displacement (n, d) in m."""
        return self.predict(problem, network, answer)


@dataclass(frozen=True)
class Perturbed:
    """A candidate whose positions are moved by up to an accuracy.

    Parameters
    ----------
    predict
        The candidate: the truth.
    accuracy
        Relative, as above; 0 leaves its answers as they are.
    seed
        Of the errors, drawn evenly from ± accuracy; the same for the same network, loads, answer
        and seed. None rounds each component to the nearest multiple of twice the accuracy instead,
        as a file with fixed decimals does.
    """

    predict: DisplacementSolver
    accuracy: float
    seed: int | None = None

    def __call__(self, problem: Problem, network: Network, answer: Answer = "linear") -> Array:
        """The displacement (n, d) in m, perturbed."""
        move = np.asarray(self.predict(problem, network, answer), float)
        if not self.accuracy:
            return move
        place = network.points + move
        reach = self.accuracy * float(np.abs(place).max())
        if self.seed is None:
            step = 2 * reach
            return np.asarray(np.round(place / step) * step - network.points)
        chance = np.random.default_rng([self.seed, _fingerprint(network, answer)])
        return move + reach * chance.uniform(-1, 1, move.shape)


@dataclass(frozen=True)
class Recorded:
    """A candidate whose answers are looked at for the accuracy that they show."""

    predict: DisplacementSolver
    grids: list[float] = field(default_factory=list)
    gaps: list[float] = field(default_factory=list)

    def __call__(self, problem: Problem, network: Network, answer: Answer = "linear") -> Array:
        """The candidate's displacement (n, d) in m."""
        move = self.predict(problem, network, answer)
        checked = check_displacement(move, network)
        grid = measure_grid(network.points, checked)
        if grid is not None:
            self.grids.append(grid)
        tighter = getattr(self.predict, "tighter", None)
        if tighter is not None:
            better = check_displacement(tighter(problem, network, answer), network)
            reach = float(np.abs(network.points + better).max())
            self.gaps.append(float(np.abs(checked - better).max()) / reach)
        return move

    @property
    def accuracy(self) -> float:
        """As measured (1): the finest grid of all answers, or what two tolerances differ by.

        One format writes all numbers, so an answer on a finer grid shows that the coarser one of
        another was that answer's own. 0 where no answer shows anything.
        """
        return max(min(self.grids, default=0.0), max(self.gaps, default=0.0))


def check_accuracy(accuracy: float) -> float:
    """An accuracy (1), from 0 to below 1; raise `ProblemError` if it is none."""
    value = finite_number("accuracy", accuracy)
    if not 0 <= value < 1:
        raise ProblemError(
            f"accuracy: {value:g}; give the error of a position over the largest coordinate, from "
            "0 to below 1, such as 6e-8 for single precision"
        )
    return value


def measure_grid(points: Array, displacement: Array) -> float | None:
    """Accuracy (1) that the rounding of positions, or of displacements, leaves.

    Parameters
    ----------
    points
        (n, d) rest points (m).
    displacement
        (n, d) (m): rounded itself, or the difference of rounded positions and `points`.

    Returns
    -------
    float or None
        Half a step of the coarsest grid that all of them lie on, over the largest coordinate; 0 if
        they lie on none, None if they are too few, or on too even a grid, to show any. For
        significant decimal digits the step is that of most numbers, else of the largest.
    """
    place = points + displacement
    largest = float(np.abs(place).max())
    moved = displacement[displacement != 0]
    if len(moved) < LEAST or not largest:
        return None
    span, found = float(np.ptp(displacement)), 0.0
    for values in (place.ravel(), moved):
        for family in (_binary, _decimal, _significant):
            step = _coarsest(family(values), values)
            if step and span < LEVELS * step:
                return None
            found = max(found, step / 2 / largest)
    return found


def _coarsest(family: Iterable[tuple[Array, Array]], values: Array) -> float:
    """Step of the coarsest format that values lie on, of formats from coarse to fine; 0 for none.

    Of decimal digits it is that of three quarters of the values or less: the largest may be a few
    even ones, such as prescribed places, and steps differ by ten.
    """
    size = float(np.abs(values).max())
    for rounded, steps in family:
        step = float(np.quantile(steps, 0.75))
        if step <= 8 * ROUNDING * size:
            return 0.0  # of double precision's own size: everything lies on it
        if np.abs(rounded - values).max() <= ROUNDING * size:
            return step
    return 0.0


def _binary(values: Array) -> Iterator[tuple[Array, Array]]:
    for kind in FORMATS:
        with np.errstate(over="ignore", under="ignore"):
            rounded = values.astype(kind)
            if np.isfinite(rounded).all():
                yield rounded.astype(float), np.spacing(np.abs(rounded).max(keepdims=True))


def _decimal(values: Array) -> Iterator[tuple[Array, Array]]:
    for places in DECIMALS:
        yield np.round(values, places), np.array([10.0**-places])


def _significant(values: Array) -> Iterator[tuple[Array, Array]]:
    power = np.floor(np.log10(np.abs(np.where(values == 0, 1.0, values))))
    for digits in DIGITS:
        steps = 10.0 ** (power + 1 - digits)
        yield np.round(values / steps) * steps, steps


def _fingerprint(network: Network, answer: str) -> int:
    """A number for a network, its supports and loads, and the answer asked for."""
    found = zlib.crc32(answer.encode())
    for array in (network.points, network.stiffness, network.displacement, network.force):
        found = zlib.crc32(np.ascontiguousarray(array).tobytes(), found)
    return found
