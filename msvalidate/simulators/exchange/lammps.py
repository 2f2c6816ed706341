"""A network of springs alone as files for LAMMPS: data, and an input that moves it to rest.

LAMMPS's harmonic bond stores K (r - r0)², so that K is half a spring's stiffness [LAMMPS]. Each
point is an atom, of the point's number plus one, with mass, force and held axes of its own; all in
SI units. Prescribed displacements are there from the start.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from msvalidate.case.springs.network_files import tension
from msvalidate.linear_algebra.norms import max_abs
from msvalidate.problem import AXES, Array, ProblemError
from msvalidate.springs.dynamics.damping import quickest_damping
from msvalidate.springs.network import Network
from msvalidate.springs.network.configuration import frequency_bound, tangent
from msvalidate.springs.network.laws.linear import LINEAR
from msvalidate.springs.statics.equilibrium import Equilibrium

PART_OF_LIMIT = 0.9
"""Time step relative to the largest stable one by Gershgorin's bound."""
MOVED = 2.0
"""Simulated time relative to that in which the motion comes to rest.

That time is of first order, for the motion that the load excites.
"""
AT_REST, ROUNDING = 1e-13, 2.0**-50
"""Force that is none: of the largest tension; of the largest stiffness times coordinate, which is
the rounding of positions."""
MOST_ROUNDING = 1e-3
"""Largest rounding of positions as a force, relative to the largest tension."""
INPUT = """\
# {said}
# Run it in this folder: lmp -in springs.in (or straight to rest: lmp -in springs.in -var steps 0)
# It leaves displacements in rest.dump; as a table for msvalidate case judge:
# awk 'NR==9 {{print "id,ux,uy,uz"}} NR>9 {{print $1-1","$2","$3","$4}}' rest.dump > rest.csv
units si
dimension {dim}
boundary s s {wall}
atom_style bond
atom_modify sort 0 0
neighbor {longest!r} bin
comm_modify cutoff {reach!r}
special_bonds lj/coul 1 1 1
bond_style harmonic
fix point all property/atom rmass d_fx d_fy d_fz i_hx i_hy i_hz d_x0 d_y0 d_z0 d_heavy ghost yes
read_data springs.data fix point NULL Points

# Loads, damping of every point by its mass, and what is held.
variable fx atom d_fx
variable fy atom d_fy
variable fz atom d_fz
variable work atom -(d_fx*x+d_fy*y+d_fz*z)
fix load all addforce v_fx v_fy v_fz energy v_work
fix damping all langevin 0 0 {damp!r} 1
{held}
# The springs move, by velocity Verlet at {part:g} of its limit.
variable steps index {steps}
timestep {dt!r}
fix motion all nve
thermo {often}
run ${{steps}}
unfix motion
unfix damping

# What is left goes to rest, with masses that make each point's own limit this step.
variable heavy atom d_heavy
set group all mass v_heavy
min_style fire
min_modify norm max integrator verlet tmax 1.0
minimize 0 {none!r} 100000 1000000
variable ux atom x-d_x0
variable uy atom y-d_y0
variable uz atom z-d_z0
write_dump all custom rest.dump id v_ux v_uy v_uz modify format float %.17g sort id
"""


def lammps_files(network: Network, found: Equilibrium, said: str) -> dict[str, bytes]:
    """Data file and input of a network of springs alone: name -> content.

    Parameters
    ----------
    network
        Without cells that resist a change of volume.
    found
        At rest to first order.
    said
        What the network is, in a line.

    Raises
    ------
    ProblemError
        If LAMMPS's positions, in double precision, have no digits of the displacement, or the
        springs are not Hooke's: its harmonic bonds are.
    """
    if network.law is not LINEAR:
        raise ProblemError(f"lammps: springs of the {network.law.name} law; take linear ones")
    u = found.displacement
    damping, dt = quickest_damping(network), PART_OF_LIMIT * 2 / frequency_bound(network)
    rows = abs(tangent(network, network.points)).sum(axis=1).reshape(u.shape).max(axis=1)
    heavy = rows * (dt / (2 * PART_OF_LIMIT)) ** 2  # their bounds of the frequency are one
    rounding = ROUNDING * float(network.stiffness.max()) * max_abs(network.start)
    largest = max_abs(tension(network, u))
    if rounding > MOST_ROUNDING * largest:
        raise ProblemError(
            f"lammps: the displacement is {max_abs(u):.2g} m in a body of {network.size:.2g} m, of "
            "which positions in double precision have no digits; multiply loads and displacements"
        )
    axes, steps = AXES[: network.dim], int(np.ceil(MOVED * damping.seconds / dt))
    held = [
        f"variable h{axis} atom i_h{axis}\ngroup held_{axis} variable h{axis}\n"
        f"fix held_{axis} held_{axis} setforce "
        + " ".join("0.0" if other == axis else "NULL" for other in "xyz")
        for axis in axes
    ]
    longest = float(network.rest_length.max())
    script = INPUT.format(
        said=said,
        dim=network.dim,
        wall="s" if network.dim == 3 else "p",
        longest=longest,
        reach=3 * longest,
        damp=1 / damping.rate,
        held="\n".join([*held, *(["fix flat all enforce2d"] if network.dim == 2 else [])]),
        part=PART_OF_LIMIT,
        steps=steps,
        often=max(1, steps // 10),
        dt=float(dt),
        none=max(AT_REST * largest, rounding),
    )
    return {"springs.in": script.encode(), "springs.data": _data(network, said, heavy)}


def _data(network: Network, said: str, heavy: Array) -> bytes:
    """The data file: atoms where the supports hold them at the start, bonds, and what is theirs."""
    start, points, force, held = (
        np.pad(each, ((0, 0), (0, 3 - network.dim)))
        for each in (network.start, network.points, network.force, network.fixed.astype(int))
    )
    room = 2 * float(network.rest_length.max())
    constants = np.column_stack([network.stiffness / 2, network.rest_length])
    kinds, kind = np.unique(constants, axis=0, return_inverse=True)
    bonds = np.column_stack([kind.ravel() + 1, network.springs + 1]).tolist()
    columns = (network.mass, force, held, points, heavy)
    own = zip(*(each.tolist() for each in columns), strict=True)
    walls = np.column_stack([start.min(axis=0) - room, start.max(axis=0) + room]).tolist()
    counts = {"atoms": len(start), "bonds": len(bonds), "atom types": 1, "bond types": len(kinds)}
    lines = [said, "", *(f"{count} {what}" for what, count in counts.items())]
    lines += [f"{a!r} {b!r} {x}lo {x}hi" for x, (a, b) in zip("xyz", walls, strict=True)]
    sections: dict[str, Iterable[Iterable[float]]] = {
        "Masses": [[1.0]],  # of the type; each atom has its own
        "Bond Coeffs": kinds.tolist(),
        "Atoms # bond": ([1, 1, *x] for x in start.tolist()),
        "Bonds": bonds,
        "Points": ([mass, *f, *h, *x, kg] for mass, f, h, x, kg in own),
    }
    for name, rows in sections.items():
        lines += ["", name, ""]
        lines += [" ".join(map(repr, [row, *each])) for row, each in enumerate(rows, 1)]
    return ("\n".join(lines) + "\n").encode()
