"""Breaking springs: which springs may break, and which break in a motion."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from msvalidate.problem import Array, Mask, ProblemError
from msvalidate.problem.checks import numbers, positive_number, require_type
from msvalidate.problem.records import replace
from msvalidate.springs.network.checks import refuse_first_bad
from msvalidate.springs.network.configuration import Configuration
from msvalidate.springs.network.network import Network


def critical_stretches(network: Network, critical_stretch: ArrayLike) -> Array:
    """Elongation over rest length (m,) at which each spring breaks, checked.

    `critical_stretch` is one number or (m,) numbers, infinite for springs that never break. The
    result is read-only.

    Raises `ProblemError` if it has another shape, a value is not above 0, a spring with stiffness
    exceeds it at rest, the law is not linear, or the network has volume energies.
    """
    require_type("network", network, Network)
    if network.law.name != "linear" or network.volumes is not None:
        raise ProblemError(
            f"breaking: springs of the {network.law.name} law"
            f"{' and cells' * (network.volumes is not None)}; take Hooke's alone: in the plane "
            "square-8 or triangular at ratio 1/3 (plane stress), in space cubic 18 at 1/4"
        )
    m = len(network.springs)
    given = numbers("critical stretch", critical_stretch)
    if given.shape not in {(), (m,)}:
        raise ProblemError(f"critical stretch: shape {given.shape}; give one number or ({m},)")
    stretch = np.broadcast_to(given, m)
    need = "is none; give an elongation over rest length above 0"
    refuse_first_bad("critical stretch", stretch, ~(stretch > 0), need)
    at_rest = network.distance / network.rest_length - 1
    beyond = (at_rest > stretch) & (network.stiffness > 0)
    refuse_first_bad(
        "stretch of a spring at rest", at_rest, beyond, "is beyond the critical one; raise that"
    )
    return stretch


class Breakage:
    """The springs of a network that break in motion: in tension, and for good.

    Before each step it looks at every spring; what is beyond the critical stretch there is gone
    from then on, with the energy that it has. A motion changes it, and one that is given it later
    goes on with what is whole.

    Parameters
    ----------
    network
        Of Hooke's springs without cells.
    critical_stretch
        Elongation over rest length, one for all springs.

    Attributes
    ----------
    network
        Its own, of what is whole: broken springs have no stiffness.
    broken
        (m,) springs that broke.
    released
        Energy (J) that they held.

    Raises
    ------
    ProblemError
        If springs are of another law, the network has cells with a volume energy, the critical
        stretch is not above 0, or a spring exceeds it at the reference positions.
    """

    def __init__(self, network: Network, critical_stretch: float) -> None:
        self.critical_stretch = positive_number("critical stretch", critical_stretch)
        critical_stretches(network, critical_stretch)
        self._applied = self.network = network
        self.broken: Mask = np.zeros(len(network.springs), dtype=bool)
        self.released = 0.0

    def look(self, displacement: Array) -> bool:
        """Break what is beyond the critical stretch at a displacement (n, d); whether any is."""
        network = self.network
        length = Configuration(network, displacement).length
        part = 1 - network.rest_length / length
        s = self.critical_stretch
        beyond = (part > s / (1 + s)) & (network.stiffness > 0)
        if beyond.any():
            e = (length - network.rest_length)[beyond]
            self.lose(beyond, 0.5 * float(network.stiffness[beyond] @ e**2))
        return bool(beyond.any())

    def whole(self, network: Network) -> Network:
        """Return a network of the same springs without the broken ones.

        Its loads and supports may be others. Raises `ProblemError` if its points, springs,
        stiffnesses or rest lengths are others.
        """
        if network is self._applied:
            return self.network
        for name in ("points", "springs", "stiffness", "rest_length"):
            if not np.array_equal(getattr(network, name), getattr(self._applied, name)):
                raise ProblemError(f"breakage: of other {name}; make one of the network that moves")
        return replace(network, stiffness=self.network.stiffness.copy())

    def lose(self, springs: Mask, energy: float) -> None:
        """Take springs (m,) out, which held an energy (J)."""
        self.broken = self.broken | springs
        self.released += energy
        self.network = replace(
            self.network, stiffness=np.where(springs, 0.0, self.network.stiffness)
        )
