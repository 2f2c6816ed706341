"""Actuator: a 2D network with two electrodes and the dielectric between them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cached_property

import numpy as np
import shapely

from msvalidate.dielectric.charges import Electrodes, electrodes_of_chains, faces_of
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
from msvalidate.springs.network import Network

SAME_PLACE = 1e-9
"""Distance over the body's size below which two places are one: rounding of coordinates is 1e-16,
and what is elsewhere is a good part of a segment away."""
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
        Two chains of points, each the numbers of points in order along the outer surface: 0 is
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
        If springs enclose no body in one part, an electrode leaves its outer surface, electrodes
        cross, touch or leave no gap, supports leave a rigid motion free, or a value is out of
        range.
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
        refuse_free_motions("network", self.network.points, self.network.fixed)
        given = self.electrodes
        if not isinstance(given, tuple | list) or len(given) != 2:
            raise ProblemError(
                f"electrodes: {format_value(given)}; give two chains of points, the top one first"
            )
        need = "give the numbers of 2 or more points"
        count = len(self.network.points)
        kept = tuple(
            indices(f"electrode {i}", line, count, "k>1", need=need) for i, line in enumerate(given)
        )
        for line in kept:
            line.setflags(write=False)
        object.__setattr__(self, "electrodes", kept)
        faces_of(self.network.points, self.outline, kept)
        object.__setattr__(
            self, "charged", electrodes_of_chains(*(self.network.start[line] for line in kept))
        )
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


def outline(network: Network) -> Index:
    """Points (k,) around a plane network, counter-clockwise, the last not the first again.

    Raises
    ------
    ProblemError
        If the body is in parts, or springs cross at the surface where there is no point.
    """
    lines = shapely.linestrings(network.points[network.springs])
    faces = shapely.get_parts(shapely.polygonize([shapely.unary_union(lines)]))
    body = shapely.coverage_union_all(faces)
    if body.geom_type != "Polygon":
        raise ProblemError("network: its springs enclose no body in one part; join them by points")
    corners = shapely.get_coordinates(shapely.orient_polygons(body).exterior)[:-1]
    tree = shapely.STRtree(shapely.points(network.points))
    _, found = tree.query_nearest(shapely.points(corners), all_matches=False)
    away: Array = np.linalg.norm(network.points[found] - corners, axis=1)
    if away.max() > SAME_PLACE * np.ptp(network.points, axis=0).max():
        x, y = corners[away.argmax()]
        raise ProblemError(
            f"network: springs cross at ({x:g}, {y:g}) m on the surface; put a point there"
        )
    return np.asarray(found, dtype=np.intp)


def _accept(_: Actuator) -> None:
    """Any actuator will do."""


def _refuse_no_plate(actuator: Actuator) -> None:
    top, bottom = actuator.electrodes
    network = actuator.network
    height = network.start[bottom, 1]
    if (
        not network.fixed[bottom, 1].all()
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
