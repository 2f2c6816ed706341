"""Solid, springs and bodies of a lattice, with the mass that steps and bodies show together."""

from __future__ import annotations

import math
from functools import partial

import numpy as np

from msvalidate.problem import Array, Isotropic
from msvalidate.problem.records import dataclass, replace
from msvalidate.simulators.lattice.bodies import LatticeBody, compare_body, fit_to_rest
from msvalidate.simulators.lattice.measure import LatticeSprings, MeasuredLattice, fit_springs
from msvalidate.simulators.lattice.regular import regular_block
from msvalidate.simulators.probe.reading import BAND, SHOWN
from msvalidate.springs.constants.stiffness import (
    Moduli,
    axes_moduli,
    isotropic_moduli,
    isotropic_part,
    isotropic_tensor,
)


@dataclass(frozen=True, eq=False)
class LatticeReport:
    """Solid, springs and bodies of a lattice.

    Parameters
    ----------
    C, mean, misfit
        Homogenised tensor (Pa), moduli of the nearest isotropic solid, and the part of the tensor
        that this solid leaves.
    springs, right
        Springs that have the tensor, and those of the requested material.
    steps
        As steps show it; None of programs without motion.
    total
        Mass relative to the requested one; NaN if it is not known.
    bodies
        Cantilevers at rest.
    """

    C: Array
    mean: Moduli
    misfit: float
    springs: LatticeSprings
    right: LatticeSprings
    steps: MeasuredLattice | None
    total: float
    bodies: tuple[LatticeBody, ...]


def make_report(
    shape: str,
    law: Isotropic,
    spacing: float,
    steps: MeasuredLattice | None,
    bodies: list[LatticeBody],
) -> LatticeReport | None:
    """Solid, springs and bodies; the mass by what bodies under forces and steps show."""
    dim, total, block = law.dim, math.nan, regular_block(shape, (2,) * law.dim, spacing)
    target = isotropic_tensor(dim, *axes_moduli(law, dim, "lattice")) / law.thickness
    right = fit_springs(block, target, target, law.thickness)
    if steps is not None and steps.is_mechanism:
        return None
    if steps is not None:
        C, springs, masses = steps.C, steps.springs, steps.masses
    elif bodies:
        springs, masses = fit_to_rest(bodies[0], right), None
        C = block.tensor(springs.constants, 0.5, law.thickness)
    else:
        return None
    compare = partial(compare_body, springs=springs, masses=masses, band=BAND)
    compared = tuple(compare(body, C) for body in bodies)
    first = next((each for each in compared if not max(each.rest, each.left) > BAND), None)
    meant = abs(isotropic_moduli(C).E * law.thickness / axes_moduli(law, dim, "")[0] - 1) <= SHOWN
    if masses is not None and first is not None and first.factor > 0:
        total = 1.0 if meant or abs(first.factor - 1) <= BAND else 1 / first.factor
        C = C * total
        springs = replace(springs, constants=springs.constants * total)
        compared = tuple(compare(body, C, springs=springs, total=total) for body in bodies)
    mean = isotropic_moduli(C)
    left = C - isotropic_part(C)
    scale = np.sqrt(np.r_[np.ones(dim), np.full(len(C) - dim, 2.0)])
    misfit = np.linalg.norm(left * np.outer(scale, scale))
    misfit /= np.linalg.norm(C * np.outer(scale, scale))
    return LatticeReport(C, mean, float(misfit), springs, right, steps, total, compared)
