"""Solver of one system for many loads, the fastest for the body."""

from __future__ import annotations

import math
from functools import cached_property, partial
from time import perf_counter

import numpy as np
from scipy.sparse import bsr_array, csr_matrix, issparse

from msvalidate.linear_algebra import choice as limits
from msvalidate.linear_algebra.choice import QUESTIONS, Choice
from msvalidate.linear_algebra.conjugate_gradients import conjugate_gradients
from msvalidate.linear_algebra.factor import (
    Factor,
    has_cholmod,
)
from msvalidate.linear_algebra.multigrid import Cycle, aggregate, restrain_in_place
from msvalidate.linear_algebra.order import Dissection
from msvalidate.problem import (
    Array,
    Index,
    Mask,
    ProblemError,
    SolverError,
    refuse_free_motions,
    rigid_motions,
)
from msvalidate.problem.checks import format_value, require_one_of, require_type, shaped
from msvalidate.problem.records import dataclass
from reference_fem.effort import fits_in_memory
from reference_fem.mesh.discretisation import Discretisation
from reference_fem.mesh.gradients import gradients_at_points
from reference_fem.systems.cells import ElasticForces
from reference_fem.systems.direct import choose_solver, elimination_order, factor_entries, factor_of
from reference_fem.systems.refined import (
    FIRST,
    SHRINKS,
    Refined,
    Vectors,
    refine_solution,
    share_left,
)

SOLVERS = ("auto", "superlu", "cholmod", "multigrid")
"""Names of solvers. "auto" chooses one of the others."""
RESIDUAL = 1e-9
"""Largest accepted residual relative to the terms that cancel in it; a direct solve of a regular
system leaves 1e-13."""
ACCEPTED = 1e-6
"""Largest accepted error of a displacement, relative to the largest: the discretisation's own is
seldom less, and an error that is known to be larger is of use to nobody as a reference."""
ROUGH_ENOUGH = 3e-11
"""Correction by multigrid that is the last, where one by a factor may go on to rounding."""
ROUGHLY = (0.1, 1e-4)
"""Error to which multigrid makes corrections, which are rounding themselves as a rule; the second
where a known motion does not come back by the first."""
ITERATED = 5e-12
"""Error and residual at which the first steps of multigrid stop."""
PATIENCE, MOST_STEPS = 120, 1000
"""Steps of multigrid where a factor fits, and where none does. Cells of good shape take 20, cells
ten times as long as wide 100, and nu = .499 takes 200."""


@dataclass(frozen=True)
class SystemSolution:
    """Solution statistics of a system: solver, reason, residual and error.

    Parameters
    ----------
    choice
        "superlu", "cholmod" or "multigrid"; "nothing" where every component is held.
    reason
        Why this one, in words.
    residual
        Largest force left on a free component, relative to the terms that cancel in it.
    steps
        Steps of conjugate gradients; 0 of a factor.
    seconds
        Wall time (s) of this solution; the first of a `Solver` makes its factor or hierarchy.
    error
        Largest error of a displacement as the solution of these linear equations, relative to the
        largest displacement: how far the elements are from the body is another matter (`refine`).
    corrections
        By which the first answer was refined.
    """

    choice: str
    reason: str
    residual: float
    steps: int
    seconds: float
    error: float = math.nan
    corrections: int = 0


@dataclass(frozen=True, eq=False)
class Solver:
    """A supported body, ready for many loads: its factor or hierarchy is made once, when needed.

    Parameters
    ----------
    body
        The mesh.
    stiffness
        Of all components (d·n, d·n) in N/m, component-major, as `stiffness` gives it: symmetric,
        and with energy in every motion of a cell but the rigid ones.
    held
        Components (n, d) that are held.
    choice
        "superlu", a factor by SciPy; "cholmod", one by cvxopt, which is faster and optional;
        "multigrid"; or "auto": a factor of small, plane or slender bodies, multigrid of others. All
        of them agree to 1e-9, and in bodies whose condition allows no factor more than 1e-8, such
        as beams of 100:1, to that.
    tensor
        C (d, d, d, d) in Pa that the stiffness was made with, thickness included, as
        `elasticity.thickness_tensor` gives it. With it residuals are summed cell by cell, which
        slender bodies need; without it, by the entries of the stiffness, whose rounding is then a
        part of the error.
    number
        (c,) which of several such tensors (m, d, d, d, d) is a cell's; None of one for all.

    Raises
    ------
    ProblemError
        If an argument is of another shape, a rigid motion is free, or the choice is not there or
        not for this body.
    """

    body: Discretisation
    stiffness: csr_matrix
    held: Mask
    choice: str = "auto"
    tensor: Array | None = None
    number: Index | None = None

    def __post_init__(self) -> None:
        refuse_no_mask(self.body, self.held)
        size = self.held.size
        K = self.stiffness
        if not (issparse(K) and K.format == "csr" and K.dtype == float and K.shape == (size, size)):
            raise ProblemError(
                f"stiffness: {format_value(K)}; give a matrix {size} x {size} of floats in CSR "
                f"format"
            )
        require_one_of("solver", self.choice, SOLVERS)
        refuse_free_motions("finite element body", self.body.points, self.held)
        if self.choice == "cholmod" and not has_cholmod():
            raise ProblemError(
                "solver: cholmod needs cvxopt, which is not installed; pip install "
                "'msvalidate[fast]', or take auto"
            )
        if self.choice == "multigrid" and not self.body.in_one_piece:
            raise ProblemError(
                "solver: multigrid cannot see a mechanism, and this body's cells do not all hang "
                "together by whole sides; take auto or superlu"
            )

    def solve(self, displacement: Array, force: Array) -> tuple[Array, SystemSolution]:
        """Displacement (n, d) in m under values (n, d) of what is held (m) and forces (n, d) in N.

        Raises
        ------
        ProblemError
            If an argument is of another shape.
        SolverError
            If part of the body can move without strain, memory does not suffice, the solution
            fails its residual check, or its error may be above `systems.solver.ACCEPTED`.
        """
        refuse_shapes(self.body, displacement=displacement, force=force)
        began = perf_counter()
        with np.errstate(over="ignore", invalid="ignore"):  # the residual refuses what has none
            K, free, load = self.stiffness, self._free, force.T.ravel()
            u = np.where(self.held, displacement, 0.0).T.ravel()
            choice, reason, steps, left = "nothing", "every component is held", 0, 0.0
            if len(free):
                u[free], steps, choice, reason = self._found((load - K @ u)[free])
                residual = np.abs((K @ u - load)[free]).max()
                scale = (abs(K) @ np.abs(u) + np.abs(load))[free].max()
                if not residual <= RESIDUAL * scale:
                    raise SolverError(
                        f"finite elements: residual {residual:.3g} N against forces of "
                        f"{scale:.3g} N; {self._remedy(displacement=displacement, force=force)}"
                    )
                left = float(residual / scale) if scale else 0.0
            found = self._refine(choice, u, load)
        seconds = perf_counter() - began
        if not found.error <= ACCEPTED:
            raise SolverError(describe_lost_digits(found.error))
        how = SystemSolution(choice, reason, left, steps, seconds, found.error, found.corrections)
        return found.value.reshape(self.body.dim, -1).T.copy(), how

    def _refine(self, choice: str, u: Array, load: Array) -> Refined:
        """The answer (d·n,), refined by the way that it was found."""
        if not len(self._free):
            return Refined(u, 0.0, 0)
        rough = choice == "multigrid"
        with fits_in_memory(len(self._free), "unknowns"):
            inverse, share = self._roughly if rough else self._directly
            enough = ROUGH_ENOUGH if rough else FIRST
            return refine_solution(self._force, inverse, u, load, share, enough=enough)

    @property
    def inverse(self) -> Vectors:
        """Displacements (d·n,) in m of forces (d·n,) in N by the factor, not refined."""
        return self._directly[0]

    @cached_property
    def _directly(self) -> tuple[Vectors, float]:
        """Displacements (d·n,) of forces by the factor, and what that leaves of an error."""
        return self._tried(self._factor.solve)

    @cached_property
    def _roughly(self) -> tuple[Vectors, float]:
        """As `_directly`, by no more steps of multigrid than leave half an error at most."""
        for error in ROUGHLY:
            found = self._tried(partial(self._iterated, error))
            if found[1] < SHRINKS:
                break
        return found

    def _iterated(self, error: float, force: Array) -> Array:
        return self._by_cycles(force, error, MOST_STEPS)[0]

    def _tried(self, solve: Vectors) -> tuple[Vectors, float]:
        free, body = self._free, self.body

        def inverse(force: Array) -> Array:
            found = np.zeros(len(force))
            found[free] = solve(force[free])
            return found

        moves = ~self.held.T.ravel()
        return inverse, share_left(self._force, inverse, body.points, moves, body.dim)

    @cached_property
    def _force(self) -> Vectors:
        if self.tensor is None:
            return lambda u: np.asarray(self.stiffness @ u)
        return ElasticForces(gradients_at_points(self.body), self.tensor, self.number)

    def correct(self, force: Array) -> Array:
        """Nearly the displacements (n, d) in m of forces (n, d) in N; zero where held.

        By the factor, where there is one, or by one cycle of multigrid: linear and symmetric.
        """
        if self._planned[0].name == "multigrid" and "_factor" not in vars(self):
            moved = self._cycle(np.where(self.held, 0.0, force).ravel()).reshape(force.shape)
            return np.asarray(np.where(self.held, 0.0, moved))
        return self.inverse(force.T.ravel()).reshape(self.body.dim, -1).T

    def _remedy(self, **given: Array) -> str:
        """Remedy for a solution that fails its check."""
        for name, values in {"stiffness": self.stiffness.data, **given}.items():
            if not np.isfinite(values).all():
                return f"the {name} holds values that are not finite"
        return "the system is singular or badly scaled"

    def _found(self, load: Array) -> tuple[Array, int, str, str]:
        """Free displacements (f,) under forces (f,); steps, the solver and the reason."""
        choice, reason = self._planned[0]
        if choice == "multigrid":
            if "_factor" in vars(self):  # multigrid gave up before
                reason = "its factor was made for another load"
            else:
                most = MOST_STEPS if self.choice == "multigrid" else PATIENCE
                try:
                    return *self._by_cycles(load, ITERATED, most), choice, reason
                except SolverError as error:  # thin cells, or nu near 1/2: no matter to a factor
                    if self.choice == "multigrid":
                        raise
                    if not self._fits:
                        return *self._by_cycles(load, ITERATED, MOST_STEPS), choice, reason
                    reason = f"multigrid gave up: {error}"
        return self._factor.solve(load), 0, self._factor.name, reason

    @cached_property
    def _planned(self) -> tuple[Choice, Dissection | None]:
        """The solver to begin with, and what a factor takes where that was counted."""
        if self.choice != "auto":
            return Choice("multigrid" if self.choice == "multigrid" else "direct", QUESTIONS), None
        if not self.body.in_one_piece:
            why = "parts that hang by edges may be mechanisms, which a factor shows"
            return Choice("direct", why), None
        return choose_solver(self.body)

    @cached_property
    def _free(self) -> Index:
        return np.flatnonzero(~self.held.T.ravel())

    @property
    def _fits(self) -> bool:
        """Return True if a factor fits into memory where multigrid fails."""
        return factor_entries(self.body) <= limits.MOST_IN_NEED

    @cached_property
    def _factor(self) -> Factor:
        """Factor of the free part, in nested dissection.

        A part that moves without strain is refused.
        """
        large = len(self._free) >= limits.WORTH_CHOLMOD and has_cholmod()
        best = "cholmod" if large else "superlu"
        name = best if self.choice in ("auto", "multigrid") else self.choice
        counted = self._planned[1]
        with fits_in_memory(len(self._free), "unknowns"):
            whole = counted if counted is not None and len(counted.order) else None
            order = elimination_order(self.body, self.held, whole)
            A = self.stiffness[self._free][:, self._free]
            return factor_of(self.body, A, order, self._free, name)

    @cached_property
    def _blocks(self) -> bsr_array:
        """The stiffness by node: what is held keeps its rows, so that every node has a block."""
        d = self.body.dim
        by_node = np.arange(self.held.size).reshape(d, -1).T.ravel()
        with fits_in_memory(len(self._free), "unknowns"):
            A = bsr_array(self.stiffness[by_node][:, by_node], blocksize=(d, d))
            restrain_in_place(A, ~self.held)
        return A

    @cached_property
    def _cycle(self) -> Cycle:
        A, free = self._blocks, ~self.held
        centred = self.body.points - self.body.points.mean(axis=0)
        rigid = rigid_motions(centred / np.abs(centred).max()).reshape(free.size, -1)
        with fits_in_memory(len(self._free), "unknowns"):
            return aggregate(A, rigid * free.reshape(-1, 1))

    def _by_cycles(self, load: Array, error: float, most: int) -> tuple[Array, int]:
        """Free displacements (f,) under forces (f,) by multigrid, and the steps taken."""
        largest = float(np.abs(load).max(initial=0.0))
        stiff = float(np.abs(self.stiffness.data).max(initial=0.0))
        if not largest:
            return np.zeros(load.shape), 0
        if not np.isfinite([largest, stiff]).all() or stiff < np.finfo(float).tiny:
            return np.full(load.shape, np.nan), 0  # which no residual allows
        right = np.zeros(self.held.shape)
        right.T[~self.held.T] = load / largest
        cycle = self._cycle
        with fits_in_memory(len(load), "unknowns"):
            found = conjugate_gradients(
                self._blocks, right.ravel() * cycle.unit, cycle, error, most=most
            )
        if found.negative or not found.reduction <= error:
            raise SolverError(
                f"finite elements: error {found.reduction:.1g} of the displacement after "
                f"{found.steps} steps of conjugate gradients; take cells of better shape, fewer "
                "of them, or a smaller nu"
            )
        moved = found.solution.reshape(self.held.shape).T[~self.held.T]
        return np.asarray(moved * (largest / cycle.unit)), found.steps


def describe_lost_digits(error: float) -> str:
    """A message for an answer that has lost its digits to rounding."""
    known = f"known to {error:.1g} of the largest only" if error < 1 else "all rounding"
    return (
        f"finite elements: displacements are {known}, wanted {ACCEPTED:g}: the body is too "
        "slender, or its cells too thin, for this many of them; take fewer and longer cells, a "
        "part of the body, or the formula of a beam"
    )


def refuse_shapes(body: Discretisation, **named: Array | Mask) -> None:
    """Raise a `ProblemError` for what is no array of one number for each component of a node."""
    require_type("body", body, Discretisation)
    for name, array in named.items():
        if not isinstance(array, np.ndarray) or array.dtype.kind not in "bif":
            raise ProblemError(f"{name}: {format_value(array)}; give an array of real numbers")
        shaped(name, array, *body.points.shape)


def refuse_no_mask(body: Discretisation, held: Mask) -> None:
    """Raise `ProblemError` unless `held` says of each component of a body's nodes if it is held."""
    refuse_shapes(body, held=held)
    if held.dtype != bool:
        raise ProblemError(f"held: of {held.dtype}; give True where a component is held")
