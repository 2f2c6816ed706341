"""Known faults of random solids: what a candidate's solid may get wrong, for negative controls."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from msvalidate.constants.homogenise import Homogenised, homogenise
from msvalidate.constants.stiffness import pattern_tensor
from msvalidate.lattice import Constants, Pattern
from msvalidate.problem import Mask


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
    """The solid without one spring at nearly every point."""
    factor = np.where(_pairing(pattern), 0.0, pattern.factor)
    return homogenise(replace(pattern, factor=factor), constants, spacing)


def _pairing(pattern: Pattern) -> Mask:
    """Springs (m,) that pair the points off, as many as are met one after another."""
    left = np.ones(len(pattern.points), dtype=bool)
    paired = np.zeros(len(pattern.springs), dtype=bool)
    for spring, (i, j) in enumerate(pattern.springs):
        if i != j and left[i] and left[j]:
            paired[spring], left[i], left[j] = True, False, False
    return paired


FAULTS = {
    "random solids with their points held": {"solid": unrelaxed, "questions": ("random_solids",)},
    "random solids 5 % unrelaxed": {"solid": partly_unrelaxed, "questions": ("random_solids",)},
    "one facet 1 % too large": {"solid": wrong_facet, "questions": ("random_solids",)},
    "one neighbour of every point missing": {
        "solid": missing_neighbour,
        "questions": ("random_solids",),
    },
}
"""Negative controls: arguments of the study's `run` under which a tolerance must fail."""
