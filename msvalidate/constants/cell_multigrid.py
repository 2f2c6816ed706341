"""Motions that relieve a large periodic cell: conjugate gradients with multigrid cycles.

All strains are solved for at once, so that the stiffness is read once a step. Coarse spaces are of
translations alone: these are all that a periodic cell has without stiffness. Rotations, which are
not periodic, make coarse spaces twice as large for an eighth fewer steps.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.sparse import csr_array

from msvalidate.linear_algebra.conjugate_gradients import (
    Iterated,
    answer_to_random_load,
    conjugate_gradients,
)
from msvalidate.linear_algebra.multigrid import MeetsNothingError, aggregate
from msvalidate.problem import Array

PART = 1e-4
"""Part of an elongation's error that is left of what is relieved. Asked three times, that is
rounding; of a motion that is known it is a tenth of what may be missed."""
HIGHEST = 2.0
"""Of the stiffness of springs over its diagonal blocks: a spring between two points costs at most
twice what it would with either of them held."""
MEETS_NONE = "some motion meets no stiffness but rounding"


class NotConverged(Exception):  # noqa: N818  an outcome, for the caller to act on
    """Conjugate gradients did not answer."""


class MechanismFound(Exception):  # noqa: N818
    """A motion was found that stretches no spring."""


def _is_mechanism(B: csr_array, k: Array, own: Array, motion: Array | None, least: float) -> bool:
    """Whether a motion (f,) stretches no spring: energy over that of its parts, `own` (f,)."""
    size = 0.0 if motion is None else float(np.abs(motion).max(initial=0.0))
    if motion is None or not (size and np.isfinite(size)):
        return False
    way = motion.reshape(len(own), -1)[:, 0] / size
    return bool(k @ (B @ way) ** 2 <= least * (own @ way**2))


def multigrid_relaxation(
    K: csr_array, B: csr_array, k: Array, dim: int, least: float
) -> Callable[[Array], Array]:
    """A way to relieve elongations (m, v) by motions (f, v).

    Parameters
    ----------
    K
        Stiffness (n·d, n·d) of all points in N/m, none held.
    B, k
        Elongations (m, n·d) of springs by motions, and stiffnesses (m,) in N/m.
    dim
        Axes d.
    least
        Energy of a motion, over what its components cost one by one, below which it has none.

    Raises
    ------
    MechanismFound
        If a motion without stiffness was found: certain.
    NotConverged
        If conjugate gradients do not answer.
    """
    unit = float(k.max(initial=0.0))
    if not unit:
        raise MechanismFound
    A, part = (K / unit).tobsr((dim, dim)), k / unit
    A.sort_indices()
    own = A.diagonal()

    def refuse_mechanism(motion: Array | None) -> None:
        if _is_mechanism(B, part, own, motion, least):
            raise MechanismFound

    def refuse_unsettled(found: Iterated, *, settled: bool) -> None:
        if not settled:
            refuse_mechanism(found.direction if found.negative else found.solution)
            often = f"conjugate gradients did not answer in {found.steps} steps"
            raise NotConverged(MEETS_NONE if found.negative else often)

    try:
        shift = np.tile(np.eye(dim), (A.shape[0] // dim, 1))
        cycle = aggregate(A, shift, floating=dim, highest=HIGHEST)
    except MeetsNothingError as why:
        refuse_mechanism(why.motion)
        raise NotConverged(MEETS_NONE) from why
    found, told = answer_to_random_load(A, cycle, np.ones(len(own), dtype=bool), dim)
    refuse_unsettled(found, settled=told)
    refuse_mechanism(found.solution)

    def relieve(stretch: Array) -> Array:
        force = (B.T @ (part[:, None] * stretch)).reshape(-1, dim, stretch.shape[1])
        force = (force - force.mean(axis=0)).reshape(len(own), -1)  # what rounding leaves of it
        size = np.abs(force).max(axis=0, initial=0.0)
        found = conjugate_gradients(A, force / np.where(size > 0, size, 1.0), cycle, PART)
        refuse_unsettled(found, settled=not found.negative and found.reduction <= PART)
        return np.asarray(-size * found.solution)

    return relieve
