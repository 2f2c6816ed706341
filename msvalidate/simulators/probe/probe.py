"""Measurement of a simulator's elastic law to first order from single steps.

All nodes are put at c + (I ± G)(X - c), at rest, without weight, for each of six strains G. One
step gives forces f = M Δv/dt, or the program tells them. In a body of cells whose stress is P, the
force on node i is -Σ V P ∇Nᵢ, and Σ Xᵢ ⊗ ∇Nᵢ is the identity in each linear cell, so

    mean of P over the volume = -(1/V) Σ fᵢ ⊗ (Xᵢ - c),

whatever the law: the theorem of virial stress [Clausius1870]. Half the difference between +G and -G
is odd in the strain: stress at rest and second-order terms drop out, and what is left is C : G with
a relative error of the strain's square. Forces of implicit programs act at the end of the step, so
there the strain is the volume's mean of ∂u/∂X at its end: it is not uniform then, but to first
order mean P = C : mean strain holds in a body of one solid all the same, for any dt. Two strains,
eps and eps/2, leave an error of the fourth power: the extrapolation of Richardson [Roache1994].

It reads the law, not the answer: locking, convergence and supports are not in it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from msvalidate.linear_algebra.norms import max_abs
from msvalidate.problem import VOIGT, Array, Isotropic
from msvalidate.problem.records import dataclass, replace
from msvalidate.simulators.exchange.protocol import (
    Answer,
    Simulator,
    SimulatorError,
    solves_to,
)
from msvalidate.simulators.probe.bench import ENGINEERING, Bench, Push, first_step, voigt
from msvalidate.simulators.probe.block import Block, probe_mesh
from msvalidate.simulators.probe.flags import raise_flags, rounding_parts
from msvalidate.simulators.probe.masses import Masses, measure_masses
from msvalidate.simulators.probe.reading import SOLVED, STRAINS, Reading

STRAIN = {"float64": 2.0**-10, "float32": 2.0**-7}
"""Larger of the two strains by default. In double precision they leave 1e-12 of rounding and of the
fourth order; in single 2e-5 of rounding, and 1e-8 of the fourth order: a single strain of 2⁻⁸ would
leave 6e-5 of the second order, fifty times that in the shear modulus of a solid of ratio .49."""
LONGER = 4.0
"""Steps of implicit programs in single precision, in default steps: their velocities are
differences of rounded positions, whose rounding counts by 1/dt²."""
CURVES = 4.0
"""Factor of the error that extrapolation from two strains leaves.

It multiplies the square of the second-order term, plus the fourth power of the strain: terms of
higher order in a law are of the size of powers of the lowest, or of the strain's own.
"""


@dataclass(frozen=True, eq=False)
class StrainFit:
    """C (Pa) by pairs of opposite strained states, and these pairs."""

    C: Array
    shrunk: float
    pairs: tuple[tuple[Push, Push], ...]


def probe(
    simulator: Simulator,
    material: Isotropic,
    *,
    settings: Mapping[str, Any] | None = None,
    masses: Masses | None = None,
) -> Reading:
    """First-order stiffness of the law that a simulator runs, with the flags it stands on.

    The step is the largest power of two (s) below the time in which a pressure wave of the asked
    material crosses the smallest cell, 1.7 cm; `LONGER` times that where an implicit program works
    in single precision. An explicit one has Δv/dt = f/m at any dt.

    Parameters
    ----------
    material
        What the simulator is asked for, of state "solid".
    settings
        Of the simulator, by its own names.
    masses
        Measured before, of the same block; default: measured here.

    Raises
    ------
    CannotRepresent, SimulatorError
        As the simulator, or where its answers do not say what they must, or no mass fits.
    ProblemError
        For arguments out of their range.
    """
    block = Block(probe_mesh(), material)
    bench, first = first_step(simulator, block, settings)
    if (bench.precision, bench.forces_at) == ("float32", "end"):
        bench = replace(bench, dt=LONGER * bench.dt)
    if first.force is None and masses is None:
        masses = measure_masses(bench)
    inertia = _inertia(block, masses, first)
    consistent = first.force is None and first.about["mass"] != "lumped"
    bench = replace(bench, inertia=inertia, consistent=consistent, solves_to=solves_to(first.about))
    return _read(bench, STRAIN[bench.precision], masses, first)


def _inertia(block: Block, masses: Masses | None, first: Answer) -> Callable[[Array], Array]:
    """Momentum (n, 3) in kg m/s of velocities, by measured masses."""
    if masses is None:
        return lambda v: v
    if first.about["mass"] == "lumped":
        m = masses.best[:, None]
        return lambda v: m * v
    matrix = block.consistent if first.about["mass"] == "consistent" else block.one_point
    return lambda v: np.asarray(matrix @ v)


def _read(bench: Bench, strain: float, masses: Masses | None, first: Answer) -> Reading:
    rest = bench.push(np.zeros((3, 3)))
    fit = fit_strains(bench, strain)
    largest = max_abs(fit.C)
    if largest == 0:
        raise SimulatorError("probe: no strain makes a force; give the body a stiffness")
    noise, of_strain = rounding_parts(bench, strain, largest, fit.shrunk)
    curvature = _curvature(fit, rest) / (strain * largest)
    half = fit_strains(bench, strain / 2)
    step = max_abs(half.C - fit.C) / largest
    C = (4 * half.C - fit.C) / 3
    # 4/3 of the step is the second-order term, and the next one is of the size of its square.
    cut = CURVES * ((4 * step / 3) ** 2 + strain**4)
    flags = raise_flags(bench, fit.pairs, rest, C, strain, curvature, masses)
    flagged = {flag.name: flag.value for flag in flags}
    causes = {
        # 4/3 of a half strain's, which is twice, and 1/3 of the whole one's.
        "rounding of stresses": 3 * noise * largest,
        STRAINS: 3 * of_strain * largest,
        SOLVED: bench.solves_to * largest,
        "finite strain": cut * largest,
        "stress not symmetric": flagged["symmetry of P"] * largest,
        "C not symmetric": flagged["symmetry of C"] * largest,
        "resultant": flagged["net force"] * largest,
        # Those of a known pattern have no error of their own.
        "masses": 0.0 if masses is None or masses.known is not None else masses.error * largest,
    }
    error = float(np.linalg.norm(list(causes.values())))
    about = dict(first.about)
    return Reading(C, error, causes, flags, masses, strain, bench.precision, about)


def fit_strains(bench: Bench, strain: float) -> StrainFit:
    """Fit C = S E⁻¹ to mean stresses S and strains E, a column a state."""
    d = bench.block.mesh.dim
    pairs, S, E = [], [], []
    for a, b in VOIGT[d]:
        G = np.zeros((d, d))
        G[a, b] += strain / 2
        G[b, a] += strain / 2
        there, back = bench.push(G), bench.push(-G)
        pairs.append((there, back))
        S.append(voigt(there.odd(back).stress))
        E.append(voigt(there.odd(back).gradient) * ENGINEERING[d])
    E_columns = np.transpose(E)
    shrunk = float(np.linalg.svd(E_columns, compute_uv=False)[-1]) / strain
    if not shrunk:
        raise SimulatorError(
            "probe: the strains at the end of the step are not independent; take a shorter dt"
        )
    return StrainFit(np.transpose(S) @ np.linalg.inv(E_columns), shrunk, tuple(pairs))


def _curvature(fit: StrainFit, rest: Push) -> float:
    """Largest second-order part of the stress, Pa."""
    return max(
        max_abs(there.stress + back.stress - 2 * rest.stress) / 2 for there, back in fit.pairs
    )
