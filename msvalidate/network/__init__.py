"""Networks of springs and cells: their data, energies, forces and tangents."""

from msvalidate.network.network import (
    Network,
    energy,
    internal_force,
    mode_energy,
    refuse_zero_length,
    spring_network,
    spring_vectors,
    tangent,
    tangent_blocks,
)

__all__ = [
    "Network",
    "energy",
    "internal_force",
    "mode_energy",
    "refuse_zero_length",
    "spring_network",
    "spring_vectors",
    "tangent",
    "tangent_blocks",
]
