"""Elongations of a periodic cell's springs at rest, and the ways to find them.

Of all motions of the points those at rest leave the least energy, so an energy is off by the square
of what the elongations are: a way to relax them need not be exact, only known to be near. It is
asked again until it finds nothing more, and tried on a motion that is known.

Small cells are solved by dense matrices, which count motions without stiffness, large ones by a
factor of their stiffness, or conjugate gradients with multigrid cycles, whose work is in proportion
to the points: a factor's grows with the power 2 of them in space, 1.3 in the plane. Coarse spaces
are of translations alone: these are all that a periodic cell has without stiffness. Rotations,
which are not periodic, make coarse spaces twice as large for an eighth fewer steps.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.linalg import LinAlgError, cho_factor, cho_solve, qr, solve_triangular
from scipy.linalg.lapack import dpocon
from scipy.sparse import csr_array, diags_array

from msvalidate.linear_algebra.conjugate_gradients import (
    Iterated,
    answer_to_random_load,
    conjugate_gradients,
)
from msvalidate.linear_algebra.factor import factorise, softest_mode
from msvalidate.linear_algebra.multigrid import MeetsNothingError, aggregate
from msvalidate.linear_algebra.norms import EPS
from msvalidate.problem import Array, Index, SolverError
from msvalidate.springs.network.mechanism import NO_STIFFNESS as NO_ENERGY
from msvalidate.springs.network.refine import LARGEST_ERROR

DENSE = 300
"""Motions of a cell up to which those without stiffness are counted: dense matrices."""
MULTIGRID = {1: 200_000, 2: 200_000, 3: 6_000}
"""Motions, by axes, above which conjugate gradients take less time than a factor."""
AFFORDED = {1: 600_000, 2: 600_000, 3: 15_000}
"""Maximum number of motions for a factor if conjugate gradients fail, by axes.

It takes half a minute.
"""
NO_STIFFNESS = 1e-10
"""Stiffness of a motion, relative to the stiffest, below which it has none."""
WELL_POSED = 1e-6
"""Reciprocal condition, as LAPACK estimates it, above which no motion is without stiffness: it
is `DENSE` times off at the most, and the estimate some tens."""
NEAR = 1e4
"""Largest ratio of stiffnesses for which `NO_STIFFNESS` holds.

Rounding is 1e-12 of the softest.
"""
SOFTEST = 1e-6
"""Root of a motion's stiffness over the softest spring's, below which it has none."""
CORRECTIONS = 8
ENOUGH = 1e-15
"""Relative energy of a correction that ends the iteration."""
LEAST_PART = 1e-24
"""Energy over the largest strain's, below which a strain has none."""
ROUNDING = 1e-13
"""Relative rounding of sums over springs."""
BLIND = 1e-3
"""Relative error allowed for the elongations of a known motion."""
PART = 1e-4
"""Relative error of the elongations that conjugate gradients leave.

Three solves reduce it to rounding; for a known motion it is a tenth of `BLIND`.
"""
HIGHEST = 2.0
"""Upper bound of the spring stiffness, relative to its diagonal blocks.

A spring between two free points costs at most twice the energy that it costs with one of them
fixed.
"""
MEETS_NONE = "some motion meets no stiffness but rounding"

Relieve = Callable[[Array], Array]
"""Motions (f, v) that relieve elongations (m, v) to nearly the least energy."""


class RelaxedCell(NamedTuple):
    """Elongations of a cell's springs under unit strains, its points in equilibrium.

    Parameters
    ----------
    elongation
        (m, v) in m.
    floppy
        Number of motions without stiffness, translations apart; None where they were not counted.
    error
        Of two strains' common energy, over the root of their own ones'.
    solver
        The way taken, "direct" or "multigrid".
    """

    elongation: Array
    floppy: int | None
    error: float
    solver: str


def relax_cell(
    count: int, springs: Index, normal: Array, stiffness: Array, stretch: Array, solver: str
) -> RelaxedCell:
    """The least energy of a cell's springs.

    Parameters
    ----------
    count
        Points n.
    springs, normal, stiffness
        (m, 2), directions (m, d), and (m,) in N/m.
    stretch
        Elongations (m, v) in m with the points held.
    solver
        One of `inverse.SOLVERS`.

    Raises
    ------
    SolverError
        If a large cell has a motion without stiffness, or what is found is not known to
        `refine.LARGEST_ERROR`.
    """
    dim, k = normal.shape[1], stiffness
    B = elongations(count, springs, normal)
    large = solver == "multigrid" or (solver == "auto" and (count - 1) * dim > MULTIGRID[dim])
    if large and count > 1:  # a single point has no motion to look for
        try:
            relieve = _solve_by_multigrid(B, k, dim)
            elongation, error = _relax_elongations(relieve, B, k, stretch)
            return RelaxedCell(elongation, None, error, "multigrid")
        except _NotConverged as why:
            if solver == "multigrid" or (count - 1) * dim > AFFORDED[dim]:
                raise SolverError(
                    f"periodic network: {why}; the points may move without stretching a spring, "
                    "or stiffnesses be too far apart: solver='direct' tells, if it has the memory"
                ) from why
    B = B[:, dim:]  # the first point held
    relieve, floppy = _solve_dense(B, k) if B.shape[1] <= DENSE else _solve_by_factor(B, k)
    elongation, error = _relax_elongations(relieve, B, k, stretch)
    return RelaxedCell(elongation, floppy, error, "direct")


def elongations(n: int, pairs: Index, normal: Array, turn: Array | None = None) -> csr_array:
    """Sparse matrix (m, n·d) from motions of points to spring elongations.

    `pairs` (m, 2) are the points of the springs, `normal` (m, d) unit vectors along them. Motions
    are periodic, or waves that turn by factors (m,) on the way to the second point. A spring to its
    own image has no elongation unless the wave turns.
    """
    m, d = normal.shape
    column = pairs[:, :, None] * d + np.arange(d)
    value = np.stack([-normal, normal if turn is None else turn[:, None] * normal], axis=1)
    row = np.broadcast_to(np.arange(m)[:, None, None], column.shape)
    return csr_array((value.ravel(), (row.ravel(), column.ravel())), shape=(m, n * d))


def stiffness_of(B: csr_array, k: Array) -> csr_array:
    """Stiffness (f, f) of motions, by roots: symmetric to the last digit."""
    rows = csr_array(diags_array(np.sqrt(k)) @ B)
    return csr_array(rows.T @ rows)


def stiffness_ratio(k: Array) -> float:
    """Largest stiffness over the least that is one."""
    there = k[k > 0]
    return float(there.max() / there.min()) if len(there) else 1.0


def energy_threshold(k: Array) -> float:
    """Relative stiffness of a motion below which its energy counts as zero.

    By the springs' own elongations, which rounding of a stiffness's entries does not hide.
    """
    return NO_ENERGY if stiffness_ratio(k) > NEAR else NO_STIFFNESS


def _relax_elongations(
    relieve: Relieve, B: csr_array, k: Array, stretch: Array
) -> tuple[Array, float]:
    """Elongations (m, v) with the least energy, from those of the points held, and an error.

    What a correction takes from an energy bounds what the next one would.
    """
    total = stretch + B @ relieve(stretch)
    left = np.inf
    for _ in range(CORRECTIONS):
        move = B @ relieve(total)
        total, before = total + move, left
        energy = np.einsum("m,mv,mv->v", k, total, total)
        taken = np.einsum("m,mv,mv->v", k, move, move)
        floor = LEAST_PART * energy.max(initial=0.0)
        left = float((taken / np.maximum(energy, max(floor, np.finfo(float).tiny))).max())
        if left <= ENOUGH or left > before / 2:
            break
    error = left + ROUNDING + _rounding_error(k, total, stretch)
    if not error <= LARGEST_ERROR:
        raise SolverError(
            f"periodic network: its tensor is known to {error:.1g} only, more than "
            f"{LARGEST_ERROR:g}: {_remedy(k)}"
        )
    _refuse_blind_solver(relieve, B, k)
    return total, error


def _rounding_error(k: Array, total: Array, stretch: Array) -> float:
    """Error of two strains' common energy, over the root of their own ones', by rounding.

    An elongation (m, v) at rest is rounded as the one that it was (`stretch`). Where a strain is
    stiff and another soft, stiff springs make much of what the latter's have of that.
    """
    energy = np.einsum("mv,mv->v", k[:, None] * total, total)
    there = energy > LEAST_PART * energy.max(initial=0.0)
    left = np.einsum("mv,mw->vw", k[:, None] * np.abs(total), np.abs(stretch))[there][:, there]
    root = np.sqrt(energy[there])
    return 2 * EPS * float((left / root / root[:, None]).max(initial=0.0))


def _refuse_blind_solver(relieve: Relieve, B: csr_array, k: Array) -> None:
    """Raise `SolverError` unless the elongations of a random motion are found, asked as often."""
    known = B @ np.random.default_rng(0).normal(size=(B.shape[1], 1))
    known[k == 0] = 0.0
    most = BLIND * np.linalg.norm(known)
    for _ in range(CORRECTIONS):
        known = np.where(k[:, None] > 0, known + B @ relieve(known), 0.0)
        if np.linalg.norm(known) <= most:
            return
    if known.size:
        raise SolverError(
            f"periodic network: of a motion that is known more than {BLIND:g} is not found, so "
            f"the tensor is not to be believed: {_remedy(k)}"
        )


def _remedy(k: Array) -> str:
    return (
        f"stiffnesses are {stiffness_ratio(k):.1g} times apart; bring them closer together, or "
        f"take a cell "
        f"of {DENSE} components at the most, which is solved by least squares at any ratio"
    )


def _solve_dense(B: csr_array, k: Array) -> tuple[Relieve, int | None]:
    """Relieving function by dense matrices, and the number of motions without stiffness.

    Cholesky's factor serves if every motion has stiffness. Otherwise least squares by Householder's
    method with columns exchanged do: their rows are springs, the stiff ones first, so that each is
    rounded by itself. The function takes elongations (m, v) to motions (f, v).

    Source: [GolubVanLoan2013], section 4.2, and [CoxHigham1998].
    """
    if not B.shape[1]:
        return lambda stretch: np.zeros((0, stretch.shape[1])), 0
    K = stiffness_of(B, k).toarray()
    with contextlib.suppress(LinAlgError):
        factor = cho_factor(K)
        if dpocon(factor[0], np.abs(K).sum(axis=0).max())[0] > WELL_POSED:
            return lambda stretch: -cho_solve(factor, B.T @ (k[:, None] * stretch)), 0
    order = np.argsort(-k, kind="stable")
    root = np.sqrt(k[order])[:, None]
    Q, R, exchanged = qr(root * B.toarray()[order], mode="economic", pivoting=True)
    least = SOFTEST * float(np.sqrt(k[k > 0].min(initial=np.inf)))
    rank = int((np.abs(np.diag(R)) > least).sum())

    def relieve(stretch: Array) -> Array:
        u = np.zeros((B.shape[1], stretch.shape[1]))
        right = Q[:, :rank].T @ (root * stretch[order])
        u[exchanged[:rank]] = -solve_triangular(R[:rank, :rank], right)
        return u

    return relieve, B.shape[1] - rank


def _solve_by_factor(B: csr_array, k: Array) -> tuple[Relieve, int | None]:
    """Relieving function by a sparse factor of the stiffness.

    Motions without stiffness are not counted. Raises `SolverError` if there is one, or if memory
    does not suffice.
    """
    K = stiffness_of(B, k)
    try:
        factor = factorise(K)
    except SolverError as error:  # no memory
        raise SolverError(
            f"periodic network: a factor of {K.shape[0]} unknowns takes more memory than there is; "
            "take solver='multigrid'"
        ) from error
    except RuntimeError as error:
        raise SolverError(FLOPPY) from error
    mode = softest_mode(K, factor, K.diagonal())
    if float(k @ (B @ mode) ** 2) <= energy_threshold(k) * (mode**2 @ K.diagonal()):
        raise SolverError(FLOPPY)

    def relieve(stretch: Array) -> Array:
        right = -(B.T @ (k[:, None] * stretch))
        return np.column_stack([factor.solve(column) for column in right.T])

    return relieve, None


def _solve_by_multigrid(B: csr_array, k: Array, dim: int) -> Relieve:
    """Relieving function by conjugate gradients with multigrid, for all strains at once.

    The stiffness is thus read once a step.

    Raises
    ------
    SolverError
        If a motion without stiffness was found: certain.
    _NotConverged
        If conjugate gradients do not answer.
    """
    unit, least = float(k.max(initial=0.0)), energy_threshold(k)
    if not unit:
        raise SolverError(FLOPPY)
    A, part = (stiffness_of(B, k) / unit).tobsr((dim, dim)), k / unit
    A.sort_indices()
    own = A.diagonal()

    def refuse_mechanism(motion: Array | None) -> None:
        size = 0.0 if motion is None else float(np.abs(motion).max(initial=0.0))
        if motion is None or not (size and np.isfinite(size)):
            return
        way = motion.reshape(len(own), -1)[:, 0] / size
        if part @ (B @ way) ** 2 <= least * (own @ way**2):
            raise SolverError(FLOPPY)

    def refuse_unsettled(iterated: Iterated, *, converged: bool) -> None:
        if not converged:
            refuse_mechanism(iterated.direction if iterated.negative else iterated.solution)
            often = f"conjugate gradients did not answer in {iterated.steps} steps"
            raise _NotConverged(MEETS_NONE if iterated.negative else often)

    try:
        shift = np.tile(np.eye(dim), (A.shape[0] // dim, 1))
        cycle = aggregate(A, shift, floating=dim, highest=HIGHEST)
    except MeetsNothingError as why:
        refuse_mechanism(why.motion)
        raise _NotConverged(MEETS_NONE) from why
    found, told = answer_to_random_load(A, cycle, np.ones(len(own), dtype=bool), dim)
    refuse_unsettled(found, converged=told)
    refuse_mechanism(found.solution)

    def relieve(stretch: Array) -> Array:
        force = (B.T @ (part[:, None] * stretch)).reshape(-1, dim, stretch.shape[1])
        force = (force - force.mean(axis=0)).reshape(len(own), -1)  # what rounding leaves of it
        size = np.abs(force).max(axis=0, initial=0.0)
        found = conjugate_gradients(A, force / np.where(size > 0, size, 1.0), cycle, PART)
        refuse_unsettled(found, converged=not found.negative and found.reduction <= PART)
        return np.asarray(-size * found.solution)

    return relieve


class _NotConverged(Exception):  # noqa: N818  an outcome, for the caller to act on
    """Conjugate gradients did not answer."""


FLOPPY = (
    "periodic network: some of its points can move without stretching a spring; take more springs "
    f"a point, or a cell of {DENSE} components at the most, where such motions are counted"
)
