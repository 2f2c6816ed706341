"""Networks of springs and cells: their data, energies, forces and tangents."""

from msvalidate.springs.network.configuration import (
    Configuration,
    configuration_at,
    energy,
    frequency_bound,
    internal_force,
    mode_energy,
    tangent,
)
from msvalidate.springs.network.network import Body, Network, spring_network

__all__ = [
    "Body",
    "Configuration",
    "Network",
    "configuration_at",
    "energy",
    "frequency_bound",
    "internal_force",
    "mode_energy",
    "spring_network",
    "tangent",
]
