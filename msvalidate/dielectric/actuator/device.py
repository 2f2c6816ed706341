"""What an actuator is: a plane network, two electrodes along its surface, and what lies between."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cached_property

import numpy as np

from msvalidate.dielectric.actuator.surface import SAME_PLACE, is_off_surface, outline
from msvalidate.dielectric.charges import Electrodes, electrodes_of_chains
from msvalidate.network import Network
from msvalidate.problem import Array, Index, ProblemError, refuse_free_motions
from msvalidate.problem.checks import (
    format_value,
    indices,
    positive_number,
    require_one_of,
    require_type,
    shaped,
)
from msvalidate.problem.records import dataclass, field

LARGEST_RATIO = 1e6
"""Permittivity ratio in air up to which equilibria are sought: forces are differences of terms so
many times as large, which rounding by some 1e-15 leaves known to 1e-9, and a residual is asked to
be below 1e-8 of the loads. Beyond, an equilibrium that is not found says nothing of pull-in."""


@dataclass(frozen=True, eq=False)
class Actuator:
    """A plane network with two electrodes that follow its surface.

    Parameters
    ----------
    network
        (n, 2) points; its stiffnesses (N/m) include the depth.
    electrodes
        Two chains of points, each the numbers of points in order along springs of the surface: 0 is
        the top electrode, at half the voltage, 1 the bottom one, at minus half.
    permittivity
        Of the dielectric between them (F/m).
    model
        Of charges: one of `MODELS`.
    depth
        Of the body out of the plane (m): forces and energies are per depth times this.
    permittivity_ratio
        Permittivity over that of what surrounds the body, up to `LARGEST_RATIO`; "in_air"
        alone asks for it, other models leave it aside.

    Attributes
    ----------
    charged
        The electrodes at the network's start; their points are those of `loaded`.

    Raises
    ------
    ProblemError
        If an electrode leaves the surface, electrodes cross, touch or leave no gap, supports leave
        a rigid motion free, or a value is out of range.
    """

    network: Network
    electrodes: tuple[Index, ...]
    permittivity: float = 1.0
    model: str = "plane"
    depth: float = 1.0
    permittivity_ratio: float = 1.0
    charged: Electrodes = field(init=False, repr=False)

    def __post_init__(self) -> None:
        require_type("network", self.network, Network)
        if self.network.dim != 2:
            raise ProblemError("network: one in space; an actuator's is in the plane")
        positive_number("permittivity", self.permittivity, "F/m")
        positive_number("depth", self.depth, "m")
        positive_number("permittivity ratio", self.permittivity_ratio)
        require_one_of("model", self.model, MODELS)
        refuse_free_motions("network", self.network.points, self.network.held)
        given = self.electrodes
        if not isinstance(given, tuple | list) or len(given) != 2:
            raise ProblemError(
                f"electrodes: {format_value(given)}; give two chains of points, the top one first"
            )
        kept = tuple(_chain(f"electrode {i}", line, self.network) for i, line in enumerate(given))
        object.__setattr__(self, "electrodes", kept)
        object.__setattr__(
            self, "charged", electrodes_of_chains(*(self.network.start[line] for line in kept))
        )
        for i, line in enumerate(kept):
            _refuse_inside(f"electrode {i}", line, self.network)
        MODELS[self.model](self)

    @cached_property
    def outline(self) -> Index:
        """(k,) points of the network around the body, counter-clockwise."""
        return outline(self.network)

    @property
    def loaded(self) -> Index:
        """(k,) points of the network that the electrodes' points are: top, then bottom."""
        return np.concatenate(self.electrodes)

    def lying(self, position: Array) -> Electrodes:
        """The electrodes when the network is at `position` (n, 2) in m.

        Raises
        ------
        ProblemError
            If they cross or touch there, or positions are not one for each point.
        """
        shaped("position", np.asarray(position), *self.network.points.shape)
        return self.charged.moved(position[self.loaded])

    def potentials(self, voltage: float) -> Array:
        """Potentials (2,) in V of the electrodes at a voltage (V) from bottom to top."""
        return np.array([0.5, -0.5]) * voltage


def _chain(name: str, given: object, network: Network) -> Index:
    """A chain of points of the network, read-only."""
    need = "give the numbers of 2 or more points"
    line = indices(name, given, len(network.points), "k>1", need=need)  # type: ignore[arg-type]
    pairs = _sorted_pairs(line)
    known = set(map(tuple, np.sort(network.springs, axis=1).tolist()))
    for i, j in pairs.tolist():
        if (i, j) not in known:
            raise ProblemError(
                f"{name}: no spring joins points {i} and {j}; follow springs of the surface, point "
                "by point"
            )
    line.setflags(write=False)
    return line


def _sorted_pairs(line: Index) -> Index:
    return np.sort(np.column_stack([line[:-1], line[1:]]), axis=1)


def _refuse_inside(name: str, line: Index, network: Network) -> None:
    """Raise unless every segment of a chain has the body on one side only."""
    pairs = _sorted_pairs(line)
    inside = is_off_surface(network, pairs)
    if len(inside):
        i, j = pairs[inside[0]]
        raise ProblemError(
            f"{name}: the spring of points {i} and {j} is not on the surface; lay electrodes along "
            "the boundary"
        )


def _accept(_: Actuator) -> None:
    """Any actuator will do."""


def _refuse_no_plate(actuator: Actuator) -> None:
    top, bottom = actuator.electrodes
    network = actuator.network
    height = network.start[bottom, 1]
    if (
        not network.held[bottom, 1].all()
        or np.ptp(height) > SAME_PLACE * np.abs(network.start[top, 1] - height[0]).max()
    ):
        raise ProblemError(
            "electrode 1: bends or can move up; between parallel plates the bottom one is flat "
            'and held: take model="plane", or hold it'
        )


def _refuse_high_ratio(actuator: Actuator) -> None:
    if actuator.permittivity_ratio > LARGEST_RATIO:
        raise ProblemError(
            f"permittivity ratio: {actuator.permittivity_ratio:g}; above {LARGEST_RATIO:g} forces "
            "in air have too few digits: at such ratios the field outside counts for nothing, "
            f"take {LARGEST_RATIO:g}"
        )


MODELS: Mapping[str, Callable[[Actuator], None]] = {
    "plane": _accept,
    "parallel_plates": _refuse_no_plate,
    "as_report": _accept,
    "in_air": _refuse_high_ratio,
}
"""Name of a model of charges -> what raises `ProblemError` for an actuator that it is not for."""
