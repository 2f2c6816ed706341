"""Load paths: loads and prescribed displacements up to their full size."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from msvalidate.linear_algebra.norms import max_abs
from msvalidate.problem import Array, ProblemError
from msvalidate.problem.checks import finite, finite_coordinates, format_value
from msvalidate.problem.records import dataclass, replace
from msvalidate.springs.network import Configuration, Network

Applied = tuple[Array, Array]
"""Forces (n, d) in N and prescribed displacements (n, d) in m.

Displacements are 0 where components are free.
"""
Path = Sequence[float] | Callable[[float], Applied]
"""Load path: increasing fractions that end at 1, or a function.

The function has the argument t from 0 to 1.
"""

PARTS = 32
"""Number of steps for a path that is a function: 7 degrees for 4 rad."""
SAME_END = 1e-9
"""Relative difference allowed between the end of a path and the network.

It is relative to the largest force or displacement; sines of large angles keep twelve digits.
"""


@dataclass(frozen=True, eq=False)
class LoadPath:
    """Loads and prescribed displacements for t in [0, 1] from a start.

    Parameters
    ----------
    network
        Whose supports and loads are met at t = 1.
    start
        (n, d) displacement (m) at t = 0.
    stops
        Places of t, rising to 1, each of which an equilibrium is found at.
    load_function
        The function, if the path is one; else loads and displacements rise in proportion.
    loaded
        Whether the start carries the network's own loads already.
    present
        (m,) lengths (m) of the springs at the start, where rest lengths begin as these, so that
        prestress is raised too; None where they are the network's own all along.
    released
        (n, d) force (N) out of balance at the start, as prestress leaves it: held against at t = 0,
        and let go in proportion.
    """

    network: Network
    start: Array
    stops: tuple[float, ...]
    load_function: Callable[[float], Applied] | None
    loaded: bool
    present: Array | None = None
    released: Array | float = 0.0

    def network_at(self, t: float) -> Network:
        """The network with the rest lengths that it has at t."""
        if self.present is None or t == 1:
            return self.network
        own = self.network.rest_length
        return replace(self.network, rest_length=self.present + t * (own - self.present))

    def force(self, t: float) -> Array:
        """Force (n, d) in N at t, with what holds the start in balance."""
        left = (1 - t) * self.released
        return self.load(t) - left if t < 1 else self.network.force

    def load(self, t: float) -> Array:
        """Force (n, d) in N of the path alone."""
        if t == 1:
            return self.network.force
        if self.load_function is not None:
            return _evaluate_path(self.network, self.load_function, t)[0]
        return self.network.force if self.loaded else t * self.network.force

    def prescribed(self, t: float) -> Array:
        """Prescribed displacement (n, d) in m at t; of no meaning where nothing is held."""
        if t == 1:
            return self.network.displacement
        if self.load_function is not None:
            return _evaluate_path(self.network, self.load_function, t)[1]
        first = self.start if self.loaded else 0.0
        return np.asarray(first + t * (self.network.displacement - first))


def load_path(
    network: Network,
    path: Path | None = None,
    start: Array | None = None,
    *,
    tightened: bool = False,
) -> LoadPath:
    """The path of a network from a start to its own loads and displacements.

    Raises `ProblemError` if the path does not rise to 1, ends elsewhere, or an array does not fit.

    `network`: its force and displacement are where the path ends. `path`: by default in proportion,
    with no stop before the end. `start`: (n, d) displacement (m) from which it begins; by default
    0. Where the start is out of balance, what is missing is applied and taken away along the path.
    """
    stops, given = _check_stops(path), path if callable(path) else None
    u = np.zeros(network.points.shape) if start is None else start
    if given is not None:
        _refuse_other_end(network, given)
    present = Configuration(network, u).length if tightened else None
    begun = LoadPath(network, u, stops, given, start is not None, present)
    left = Configuration(begun.network_at(0.0), u).force() + begun.load(0.0)
    rounding = 4 * network.rounding(network.size + max_abs(u))
    left = np.where(network.fixed | (np.abs(left) <= rounding), 0.0, left)
    return replace(begun, released=left)


def _check_stops(path: Path | None) -> tuple[float, ...]:
    """Places of t that are to be stopped at."""
    if path is None:
        return (1.0,)
    if callable(path):
        return tuple(part / PARTS for part in range(1, PARTS + 1))
    parts = finite("path", path)
    if parts.ndim != 1 or not len(parts):
        raise ProblemError(
            f"path: {format_value(path)}; give a row of fractions that rise to 1, or a function of "
            f"t"
        )
    rising = np.diff(parts, prepend=0.0) > 0
    if not rising.all():
        at = int(np.flatnonzero(~rising)[0])
        raise ProblemError(
            f"path: {parts[at]:g} at index {at}; fractions must rise from above 0 to 1"
        )
    if parts[-1] != 1:
        raise ProblemError(f"path: ends at {parts[-1]:g}; its last fraction must be 1")
    return tuple(parts.tolist())


def _evaluate_path(network: Network, applied: Callable[[float], Applied], t: float) -> Applied:
    """Evaluate a path function at t and check the result."""
    try:
        force, displacement = applied(t)
    except (TypeError, ValueError) as error:
        raise ProblemError(
            f"path: at t = {t:g} no pair of force and displacement ({error}); return two arrays "
            f"{network.points.shape}"
        ) from error
    shape, need = network.points.shape, f"return {network.points.shape}"
    force = finite(f"path: force at t = {t:g}", force, *shape, need=need)
    name = f"path: displacement at t = {t:g}"
    displacement = finite_coordinates(name, displacement, *shape, need=need)
    if displacement[~network.fixed].any():
        point = int(np.flatnonzero((~network.fixed & (displacement != 0)).any(axis=1))[0])
        raise ProblemError(
            f"path: displacement at t = {t:g} of point {point}, which is not held; return 0 there"
        )
    return force, displacement


def _refuse_other_end(network: Network, applied: Callable[[float], Applied]) -> None:
    """Raise `ProblemError` unless a path ends at the network's own loads and displacements."""
    own = (network.force, network.displacement)
    ends = zip(("force", "displacement"), _evaluate_path(network, applied, 1.0), own, strict=True)
    for name, end, wanted in ends:
        apart = np.abs(end - wanted)
        if apart.max() > SAME_END * max_abs(wanted):
            point = int(np.unravel_index(apart.argmax(), apart.shape)[0])
            raise ProblemError(
                f"path: at t = 1 the {name} of point {point} is "
                f"{format_value(end[point].tolist())}, the "
                f"network's own {format_value(wanted[point].tolist())}; end the path there"
            )
