"""Springs that a block is made of: each is labelled by what it is made with.

A label is made of the names of lattice, rules and weights that ran, so another rule has another.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from msvalidate import kit
from msvalidate.springs.bodies.calibrate import calibrate
from msvalidate.springs.bodies.lattice_network import lattice_network
from msvalidate.springs.constants.calibration import Calibration
from msvalidate.springs.constants.homogenise import homogenise
from msvalidate.springs.constants.stiffness import isotropic_moduli
from msvalidate.springs.lattice import patterns, square, voronoi, voronoi_box

NU = 0.4
BLOCK = kit.Box((1.0, 1.0))
MATERIAL = kit.Isotropic(E=1.0, nu=NU, state="plane_strain")
ALONG = MATERIAL.E / (1 - NU**2)
"""Modulus in the plane (Pa): what a pull along an axis of a free block sees."""
CENTRAL = kit.Isotropic(E=ALONG, nu=1 / 3)
"""What isotropic central springs of this modulus are: in the plane they have one ratio."""
SAMPLE = 400
"""Points of the periodic cell that gives the modulus of random springs."""
BOUNDARY = {
    "shared": "half boundary springs",
    "equal": "whole boundary springs",
}
"""Rule for the weights of a boundary's springs -> its words; another says its own name."""
LATTICES = {"cubic 18": "cubic with 18 neighbours", ", cut": ", cut to the outline"}
"""Part of a lattice's name -> its words."""
POINTS = {"uniform": "random points", "blue_noise": "spread points"}
STIFFNESS = {"1": "equal springs", "A/L": "springs as facet over length"}


def problem(material: kit.Material = MATERIAL) -> kit.Problem:
    """The part: clamped on the left, 1 mPa of shear down on the right."""
    return kit.Problem(
        BLOCK,
        material,
        (kit.Support(BLOCK.side("left"), (0.0, 0.0)),),
        (kit.Traction(BLOCK.side("right"), (0.0, -1e-3)),),
    )


@dataclass(frozen=True, eq=False)
class Squares:
    """Springs on the block's squares."""

    constants: tuple[float, ...] | Calibration
    weights: str = "shared"

    def network(self, across: int, _draw: int = 0) -> kit.Network:
        """The block of so many cells."""
        lattice = square(BLOCK, across)
        return lattice_network(problem(), lattice, self.constants, weights=self.weights)

    @property
    def solid(self) -> kit.Array:
        """Tensor (3, 3) in N/m of an endless lattice."""
        if isinstance(self.constants, Calibration):
            return self.constants.tensor
        return homogenise(patterns.square(), self.constants).tensor

    def __str__(self) -> str:
        k = self.constants
        (k1, k2), volume = (k.constants, k.volume) if isinstance(k, Calibration) else (k, 0.0)
        return squares_label(square(BLOCK, 1).name, k1, k2, self.weights, volume)


@dataclass(frozen=True)
class Random:
    """A Voronoi network whose endless like has the part's modulus."""

    points: str
    stiffness: str

    def network(self, across: int, draw: int) -> kit.Network:
        """The block of so many mean spacings."""
        given = {"points": self.points, "stiffness": self.stiffness}
        lattice = voronoi_box(BLOCK, 1 / across, **given, seed=draw)
        return lattice_network(problem(), lattice, (ALONG / isotropic_moduli(self._unit).E,))

    @property
    def solid(self) -> kit.Array:
        """Tensor (3, 3) in N/m of an endless network."""
        return self._unit * (ALONG / isotropic_moduli(self._unit).E)

    @cached_property
    def _unit(self) -> kit.Array:
        """The same of springs whose constant is 1."""
        sample = voronoi(SAMPLE, dim=2, points=self.points, stiffness=self.stiffness)
        return homogenise(sample, (1.0,)).tensor

    def __str__(self) -> str:
        return random_label(self.points, self.stiffness)


def lattice_label(name: str) -> str:
    """A lattice's name in words."""
    for short, words in LATTICES.items():
        name = name.replace(short, words)
    return name


def squares_label(lattice: str, k1: float, k2: float, weights: str, volume: float = 0.0) -> str:
    """Springs on squares: their lattice, diagonals over sides, and what stands at the boundary."""
    energy = ["volume energy"] if volume else []
    boundary = BOUNDARY.get(weights, f"weights {weights!r}")
    return ", ".join([lattice_label(lattice), f"k2/k1 = {k2 / k1:.3g}", *energy, boundary])


def random_label(points: str, stiffness: str) -> str:
    """Springs between points that are drawn."""
    return f"{POINTS.get(points, points)}, {STIFFNESS.get(stiffness, f'springs as {stiffness}')}"


REPORT = Squares((0.6 * ALONG, 1.2 * ALONG), "equal")
"""The source report's, k2 = 2 k1 and whole on the boundary; its modulus along x is the part's."""
ISOTROPIC = Squares(calibrate(ALONG, 1 / 3, patterns.square()).constants)
"""Isotropic, of the part's modulus, and so of a ratio of 1/3."""
VOLUME = Squares(calibrate(MATERIAL.E, NU, square(BLOCK, 1), MATERIAL.state))
"""The part's modulus and ratio."""
EVEN, BLUE = Random("uniform", "1"), Random("blue_noise", "A/L")
SPRINGS = (REPORT, ISOTROPIC, VOLUME, EVEN, BLUE)
