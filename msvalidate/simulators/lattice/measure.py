"""Homogenised tensor, boundary excess and masses of a lattice, measured by single steps.

Blocks of n cells a side in uniform strain have the mean tensor C(n), a polynomial of 1/n: its value
at 0 is the homogenised tensor, and the rest is due to the boundary. Inner nodes that a uniform
strain leaves out of balance are relaxed first, by the simulator's own solver.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from scipy.optimize import nnls

from msvalidate.linear_algebra.norms import max_abs
from msvalidate.problem import Array, Isotropic, Mask, Mesh
from msvalidate.problem.records import dataclass, replace
from msvalidate.simulators.exchange.asked import Note, note_of
from msvalidate.simulators.exchange.protocol import (
    CannotRepresent,
    Simulator,
    SimulatorError,
    ask,
)
from msvalidate.simulators.lattice.regular import SPACING, Regular, RegularBlock, regular_block
from msvalidate.simulators.probe.bench import Bench, first_step
from msvalidate.simulators.probe.masses import Masses, measure_masses
from msvalidate.simulators.probe.probe import STRAIN, fit_strains
from msvalidate.simulators.probe.reading import BAND

SIZES = {2: (2, 4, 8), 3: (2, 3, 4, 6)}
"""Cells per side, by the number of axes.

There are as many sizes as C(n) has coefficients if springs reach over two cells."""
LARGER = {2: (4, 8, 12), 3: (3, 4, 5, 6)}
"""Cells per side if inner nodes are relaxed.

The boundary layers of opposite sides then stay apart."""
WEIGHED = {2: 4, 3: 2}
"""Cells a side of the block whose masses are measured."""
INNER = 0.01
"""Largest force on inner nodes in a uniform strain, relative to the largest."""
SHORT = 2.0**-5
"""Step of implicit programs, relative to the time in which a wave crosses a cell.

At its end inner nodes carry a force of about the square of it: `INNER` must be far above that.
"""
FREE = 1e-3
"""Smallest eigenvalue of a tensor relative to its largest entry: less is no stiffness."""
DIVIDED = 0.25
"""Relative difference of a stiffness from half of it at twice the density."""


@dataclass(frozen=True, eq=False)
class LatticeSprings:
    """Springs with a given tensor, and the weight of those on the boundary.

    Parameters
    ----------
    constants
        N/m by kind: along axes, along diagonals of faces, along diagonals of cubes.
    weight
        Part of its constant that a spring in a side has; its square in an edge of a solid.
    misfit
        Largest entry of the tensors that these springs leave, relative to the largest.
    """

    constants: Array
    weight: float
    misfit: float


@dataclass(frozen=True, eq=False)
class MeasuredLattice:
    """A lattice as its steps show it.

    Parameters
    ----------
    C
        Homogenised tensor in Pa.
    small
        Tensor (Pa) of the smallest block.
    springs
        Springs that have both, as nearly as there are any.
    masses
        Masses of nodes; None of programs that answer by forces.
    prestrain
        Relative excess of rest lengths over the distances of the points.
    over_density
        True if the stiffness is divided by the density.
    relaxed, bound
        True if inner nodes were relaxed, and if they could not be, so that `C` is an upper
        bound.
    precision
        Of the simulator's positions.
    error
        Largest change of the tensor if one block size is left out, and the strain squared, relative
        to the largest entry.
    """

    C: Array
    small: Array
    springs: LatticeSprings
    masses: Masses | None
    prestrain: float = 0.0
    over_density: bool = False
    relaxed: bool = False
    bound: bool = False
    precision: str = "float64"
    error: float = math.nan


def measure_lattice(
    simulator: Simulator,
    shape: str,
    material: Isotropic,
    settings: Mapping[str, Any],
    notes: list[Note],
    spacing: float = SPACING,
) -> MeasuredLattice:
    """Measure a lattice by steps from uniformly strained blocks.

    Raises
    ------
    CannotRepresent, SimulatorError
        As the simulator, or if no masses fit its steps, or no strain causes a force.
    """
    dim = material.dim

    def block_of(count: int, density: float = 1.0) -> RegularBlock:
        mesh = regular_block(shape, (count,) * dim, spacing).mesh
        middle = mesh.points - mesh.points.max(axis=0) / 2
        heavy = replace(material, density=density * material.density)
        return RegularBlock(Mesh(middle, mesh.cells, shape), heavy)

    start, first = first_step(simulator, block_of(WEIGHED[dim]), settings)
    precision = start.precision
    if first.force is None and first.about["mass"] != "lumped":
        raise CannotRepresent("a mass matrix that is not diagonal; these cells need lumped masses")
    masses = None if first.force is not None else measure_masses(start)
    short = SHORT if (precision, start.forces_at) == ("float64", "end") else 1.0

    def bench_of(count: int, density: float = 1.0) -> Bench:
        block = block_of(count, density)
        bench = replace(start, block=block, dt=short * start.dt)
        if masses is None:
            return bench
        m = masses.on(block, block.lumped.sum())[:, None]
        return replace(bench, inertia=lambda v: m * v)

    sizes = SIZES[dim]
    benches = [bench_of(count) for count in sizes]
    strain, relaxed, bound = STRAIN[precision], False, False
    fits = [fit_strains(benches[-1], strain)]
    forces = np.array([there.odd(back).force for there, back in fits[0].pairs])
    inner = benches[-1].block.inner
    if max_abs(forces[:, inner]) > INNER * max_abs(forces):
        settled = [_settling(bench_of(count)) for count in LARGER[dim]]
        try:
            fits = [fit_strains(settled[-1], strain)]
            benches, relaxed, sizes = settled, True, LARGER[dim]
        except CannotRepresent as error:
            notes.append(note_of("relaxed inner nodes", error))
            bound = True
    fits = [*(fit_strains(bench, strain) for bench in benches[:-1]), *fits]
    if not max_abs(fits[0].C):
        raise SimulatorError("lattice: no strain makes a force; give the springs a stiffness")
    tensors = [(fit.C + fit.C.T) / 2 for fit in fits]
    C = extrapolate(sizes, tensors)
    rest = benches[0].push(np.zeros((dim, dim)))
    out = max_abs(rest.force.sum(axis=0)) > BAND * np.abs(rest.force).sum()
    prestrain = 0.0 if out else -float(np.trace(rest.stress) / C[:dim, :dim].sum())
    G = np.diag([strain, *(0.0,) * (dim - 1)])
    heavy = replace(bench_of(sizes[0], 2.0), settle=benches[0].settle)
    more, light = (bench.push(G).stress[0, 0] - rest.stress[0, 0] for bench in (heavy, benches[0]))
    smallest = regular_block(shape, (sizes[0],) * dim, spacing)
    springs = fit_springs(smallest, C, tensors[0], material.thickness)
    flags = abs(2 * more / light - 1) < DIVIDED, relaxed, bound
    others = [
        extrapolate(sizes[:i] + sizes[i + 1 :], tensors[:i] + tensors[i + 1 :])
        for i in range(len(sizes))
    ]
    off = max_abs(np.array(others) - C) / max_abs(C) + strain**2
    made = (C, tensors[0], springs, masses, prestrain + 0.0, *flags, precision, off)
    return MeasuredLattice(*made)


def is_mechanism(C: Array) -> bool:
    """Return true if some uniform strain costs no energy."""
    return bool(np.linalg.eigvalsh(C)[0] <= FREE * max_abs(C))


def extrapolate(sizes: tuple[int, ...], tensors: list[Array]) -> Array:
    """Value at 1/n = 0 of the polynomial of 1/n through tensors at sizes n."""
    n = np.array(sizes, dtype=float)
    between = n[:, None] - n + np.eye(len(n))
    weights = n ** (len(n) - 1) / between.prod(axis=1)
    return np.asarray(np.tensordot(weights, np.array(tensors), 1))


def fit_springs(block: Regular, C: Array, small: Array, thickness: float) -> LatticeSprings:
    """Springs between corners of cells with a tensor C, and with `small` in one block."""
    kinds = block.kind.max() + 1
    # Diagonals of faces and of cubes have the same tensor in cubes: those of faces are taken.
    each = [np.eye(kinds)[i] for i in range(2 if block.mesh.shape == "hexahedron" else kinds)]
    columns = [block.tensor(k, 0.5, thickness) for k in each]
    constants = nnls(np.array([T.ravel() for T in columns]).T, C.ravel())[0] @ np.array(each)
    fitted = block.tensor(constants, 0.5, thickness)
    whole = block.tensor(constants, 1.0, thickness) - fitted
    part = float((whole * (small - C)).sum() / (whole**2).sum())
    weight = float(np.clip((1 + part) / 2, 1 / 16, 4.0))
    left = max_abs(fitted - C), max_abs(block.tensor(constants, weight, thickness) - small)
    return LatticeSprings(constants, weight, max(left) / max_abs(C))


def _settling(bench: Bench) -> Bench:
    """The bench with inner nodes relaxed and all others fixed in a uniform strain."""
    block, inner = bench.block, bench.block.inner

    def settle(move: Array) -> Array:
        held: Mask = np.repeat(~inner[:, None], move.shape[1], axis=1)
        value = np.where(held, move, 0.0)
        own = {"settings": bench.settings, "name": "held boundary"}
        request = block.request("rest", held=held, value=value, **own)
        return np.asarray(ask(bench.simulator, request).displacement)

    return replace(bench, settle=settle)
