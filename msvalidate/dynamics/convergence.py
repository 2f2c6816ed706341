"""The convergence test of a relaxation: when a network is at rest."""

from __future__ import annotations

import math

import numpy as np

from msvalidate.dynamics.state import State
from msvalidate.linear_algebra.norms import max_abs
from msvalidate.network import Configuration, Network
from msvalidate.network.laws.linear import LINEAR
from msvalidate.network.laws.quadratic import QUADRATIC
from msvalidate.network.laws.volumes import stiffness_magnitudes
from msvalidate.network.residual import force_roundoff, force_scale
from msvalidate.problem import Array


class ConvergenceTest:
    """Residual force and kinetic energy against what a tolerance allows.

    The residual may be `tolerance` times the forces that meet at a point, the kinetic energy
    `tolerance`² times the energy stored; neither is asked to fall below rounding.

    A lattice may be at rest as it is stepped, and as the network is but for what the two are apart.

    Parameters
    ----------
    state
        The network on its way.
    tolerance
        Relative, as above.
    """

    def __init__(self, state: State, tolerance: float) -> None:
        network = state.network
        self.state, self.tolerance = state, tolerance
        self._at_lengths = 4 * force_roundoff(network, 0.0)
        self._per_metre = 4 * force_roundoff(network, 1.0) - self._at_lengths
        # A lattice is stepped as if springs that lead the same way were the same: in the network
        # each component of their vectors, and their lengths, may differ by 4 roundings of the
        # largest coordinate.
        self._apart = np.zeros_like(self._at_lengths)
        if state.motion.path == "lattice":
            self._apart = 4 * (1 + math.sqrt(network.dim)) * force_roundoff(network)
        k = np.abs(network.axial_stiffness)
        self._softest = float(k[k > 0].min(initial=np.inf))
        self._stiffest, self._loaded = (
            _largest_point_stiffness(network),
            float(np.abs(network.force).max()),
        )
        self._met = math.inf, state.displacement

    def met(self, residual: float, kinetic: float) -> bool:
        """Whether the state is at rest, of this residual force (N) and kinetic energy (J).

        Bounds of the forces that meet at a point are asked first: to sum them takes as long as
        many steps.
        """
        state = self.state
        rounding = self.rounding
        still = max(self.tolerance**2 * state.stored, rounding / self._softest * rounding)
        if kinetic > still:  # the usual case, and the cheapest question
            return False
        rounding += max_abs(self._apart)
        # Forces that meet at a point add up to √(2·energy·Σk) at most, by Cauchy and Schwarz.
        bound = math.sqrt(2 * state.stored * self._stiffest) if self._stiffest else math.inf
        if residual > max(self.tolerance * (bound + 2 * self._loaded), rounding):
            return False
        if residual > max(self.tolerance * self._most_met(), rounding):
            return False
        held = state.network.held
        if (state.displacement[held] != state.network.displacement[held]).any():
            return False
        return self._balanced()

    def _balanced(self) -> bool:
        """Whether no force is left at any point, by the sums of forces that meet there."""
        state = self.state
        small = np.maximum(self.tolerance * self._force_met(), self._floor)
        excess = np.abs(state.balance()) - small
        if not (excess <= self._apart).all():
            return False
        if (excess > 0).any():  # as the network is
            excess = np.abs(state.motion.balance(state.displacement)) - small
        return bool((excess <= 0).all())

    @property
    def rounding(self) -> float:
        """Largest force (N) on a point that is rounding."""
        return float(self._floor.max())

    @property
    def _floor(self) -> Array:
        """Force (n, d) in N that is rounding: of positions, and of what they moved."""
        return np.asarray(self._at_lengths + max_abs(self.state.displacement) * self._per_metre)

    def allowed(self) -> float:
        """Residual force (N) that is small enough at the points where most forces meet, now."""
        return max(self.tolerance * self._force_met(), self.rounding)

    def target(self) -> float:
        """As `allowed`, from the last sum of forces there is: enough to show the way by."""
        met = self._met[0]
        return max(self.tolerance * met, self.rounding) if math.isfinite(met) else self.allowed()

    def _force_met(self) -> float:
        """Largest sum of force magnitudes (N) that meet at a free point now."""
        state = self.state
        self._met = (
            force_scale(Configuration(state.network, state.displacement)),
            state.displacement.copy(),
        )
        return self._met[0]

    def _most_met(self) -> float:
        """What that sum (N) cannot exceed: a spring's force changes by k times its ends' moves.

        Where cells stand beside springs they stiffen as they are deformed; rest is then seen a few
        looks later, never too early.
        """
        met, there = self._met
        if not self._stiffest or not math.isfinite(met):
            return math.inf
        return met + 2 * self._stiffest * max_abs(self.state.displacement - there)


def _largest_point_stiffness(network: Network) -> float:
    """Largest stiffness (N/m) that meets at a point; 0 where it may grow.

    Or where cells may give energy back: energies of both signs bound no force.
    """
    k = np.repeat(network.stiffness, 2)
    met = 1.0 * np.bincount(network.springs.ravel(), k, len(network.points))
    cells = network.volumes
    if network.law is not LINEAR or (
        cells and (cells.law is not QUADRATIC or cells.stiffness.min() < 0)
    ):
        return 0.0
    return float((met + network.of_cells(stiffness_magnitudes)).max())
