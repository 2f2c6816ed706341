"""Known faults of random solids: what a candidate's solid may get wrong, for negative controls."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from msvalidate.springs.constants.homogenise import Homogenised, homogenise
from msvalidate.springs.constants.stiffness import pattern_tensor
from msvalidate.springs.lattice import Constants, Pattern


def unrelaxed(pattern: Pattern, constants: Constants, spacing: float = 1.0) -> Homogenised:
    """The solid with its points held to the uniform strain, taken for the one at rest."""
    affine = pattern_tensor(pattern, constants, spacing)
    return Homogenised(affine, affine.copy(), floppy=0, error=0.0, solver="direct")


def partly_unrelaxed(pattern: Pattern, constants: Constants, spacing: float = 1.0) -> Homogenised:
    """The solid with 5 % of what relaxation takes left in: no identity of a network tells."""
    right = homogenise(pattern, constants, spacing)
    return replace(right, tensor=0.95 * right.tensor + 0.05 * right.affine)


def wrong_facet(pattern: Pattern, constants: Constants, spacing: float = 1.0) -> Homogenised:
    """The solid with one spring's facet, so its stiffness, too large by 1 %."""
    factor = np.array(pattern.factor)
    factor[len(factor) // 2] *= 1.01
    return homogenise(replace(pattern, factor=factor), constants, spacing)


def missing_neighbour(pattern: Pattern, constants: Constants, spacing: float = 1.0) -> Homogenised:
    """The solid without one spring at nearly every point: springs that pair the points off."""
    alone = np.ones(len(pattern.points), dtype=bool)
    factor = np.array(pattern.factor)
    for spring, (i, j) in enumerate(pattern.springs):
        if i != j and alone[i] and alone[j]:
            factor[spring], alone[i], alone[j] = 0.0, False, False
    return homogenise(replace(pattern, factor=factor), constants, spacing)


FAULTS = {
    name: {"solid": solid, "questions": ("random_solids",)}
    for name, solid in {
        "random solids with their points held": unrelaxed,
        "random solids 5 % unrelaxed": partly_unrelaxed,
        "one facet 1 % too large": wrong_facet,
        "one neighbour of every point missing": missing_neighbour,
    }.items()
}
"""Negative controls: arguments of the study's `run` under which a tolerance must fail."""
