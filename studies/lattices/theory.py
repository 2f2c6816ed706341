"""What is known of the lattices on paper: anisotropy and highest frequency, by name.

A lattice that is not here is compared with its own closed tensor alone, if it has one. Zener's
ratio 2·C44/(C11 - C12) is of the springs' sum over the neighbours of one point. The highest
frequency is that of a wave at the edge of Brillouin's zone: each spring whose ends move against
each other adds 2·k·(n·e)² for each of its two directions, n its own and e that of the motion.
"""

from __future__ import annotations

from collections.abc import Callable

from msvalidate.springs.lattice import Constants

ZENER: dict[str, Callable[[Constants], float]] = {
    "square": lambda k: 2 * k[1] / k[0],
    "square 4": lambda _: 0.0,
    "triangular": lambda _: 1.0,
    "honeycomb": lambda _: 1.0,
    "cubic 6": lambda _: 0.0,
    "cubic 18": lambda k: 2 * k[1] / (k[0] + k[1]),
    "cubic 26": lambda k: 2 * (k[1] + 4 / 3 * k[2]) / (k[0] + k[1]),
    "BCC": lambda k: 2 * k[0] / (3 * k[1]),
    "FCC": lambda k: 2 * k[0] / (k[0] + 4 * k[1]),
}
"""Name -> Zener's ratio under constants; 1 where they are isotropic: square k1 = 2 k2, cubic 18
k1 = k2, cubic 26 k1 = k2 + 8 k3/3, BCC k2 = 2/3 k1, FCC k2 = k1/4."""
FREQUENCY: dict[str, tuple[float, ...]] = {
    "square": (4, 4),
    "square 4": (4,),
    "triangular": (6,),
    "cubic 6": (4,),
    "cubic 18": (4, 8),
    "cubic 26": (4, 8, 16 / 3),
    "BCC": (16 / 3, 4),
    "FCC": (8, 4),
}
"""Name -> m·omega_max² as a sum over the constants: of waves (π, 0) and (π, 0, 0) in square and
cubic lattices, along (1, 1, 0) in BCC and (1, 1, 1) in FCC, by the edge of the cube."""


def zener(name: str, constants: Constants) -> float | str:
    """Zener's ratio on paper, or "none".

    Source: [Zener1948].
    """
    return float(ZENER[name](constants)) if name in ZENER else "none"


def frequency(name: str, constants: Constants) -> float | str:
    """m·omega_max² (N/m) on paper, or "none".

    Source: [BornHuang1954].
    """
    if name not in FREQUENCY:
        return "none"
    return float(sum(c * k for c, k in zip(FREQUENCY[name], constants, strict=True)))
