"""The ways in which `reference_fem` solves: as it chooses, and by each that can be asked for."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from scipy.sparse import csr_matrix

from msvalidate import kit
from msvalidate.linear_algebra.factor import has_cholmod
from reference_fem import Solver

from .timing import ABSENT

NAMES = ("auto", "superlu", "cholmod", "multigrid")


class Found(NamedTuple):
    """Displacement (n, d) in m, how it was found, and the residual relative to its terms (1).

    The displacement is None where the way needs what is not installed.
    """

    displacement: kit.Array | None
    choice: str
    residual: float


Solve = Callable[[Any, csr_matrix, kit.Mask, kit.Array], Found]
"""Takes body, stiffness (N/m), held components (n, d) and forces (n, d) in N."""


def by(name: str, body: Any, K: csr_matrix, held: kit.Mask, force: kit.Array) -> Found:
    """One load, by a way of ours."""
    if name == "cholmod" and not has_cholmod():
        return Found(None, ABSENT, 0.0)
    u, how = Solver(body, K, held, name).solve(np.zeros(held.shape), force)
    return Found(u, how.choice, how.residual)


def many(body: Any, K: csr_matrix, held: kit.Mask, force: kit.Array, count: int) -> object:
    """So many loads on one body, made ready once."""
    ready = Solver(body, K, held)
    return [ready.solve(np.zeros(held.shape), (i + 1) * force) for i in range(count)]


WAYS: dict[str, Solve] = {name: partial(by, name) for name in NAMES}
