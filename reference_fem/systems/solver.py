"""One system, many loads: the solver that size, dimension and shape of a body make the fastest."""

from __future__ import annotations

import math
from functools import cached_property, partial
from time import perf_counter

import numpy as np
from scipy.sparse import csr_matrix, issparse

from msvalidate.problem import Array, Index, Mask, ProblemError, SolverError, refuse_free_motions
from msvalidate.problem.checks import format_value, require_one_of, require_type, shaped
from msvalidate.problem.records import dataclass
from reference_fem.effort import factor_envelope, fits_in_memory
from reference_fem.mesh.discretisation import Discretisation
from reference_fem.mesh.gradients import gradients_at_points
from reference_fem.systems.cells import ElasticForces
from reference_fem.systems.dissection import elimination_order
from reference_fem.systems.factor import Apply, Factor, factorise, has_cholmod
from reference_fem.systems.multigrid import MOST_STEPS, Hierarchy
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
WORTH_CHOLMOD = 20_000
"""Unknowns from which on CHOLMOD is taken where it is there. Below, either factor takes a second at
most, and answers are the same bits with it and without."""
MOST_PRODUCTS = {"superlu": 2e4, "cholmod": 2e4}
"""Products of a factor's envelope for each entry of the stiffness, in space, that take as long as
multigrid does with well-shaped cells; as measured on cubes, bars and plates of all elements. Cubes
of 15 hexahedra a side have so many. CHOLMOD's would be ten times as many on a still machine, but in
`cost` multigrid took a third of its time on a cube of 24, and a quarter of its memory on one of 45.
In the plane a factor is faster to a million unknowns and more."""
A_STEP = {"superlu": 500.0, "cholmod": 5000.0}
"""Products for each entry of the stiffness that take no less time than a step of multigrid."""
LEAST_STEPS = 60
"""Steps that multigrid is always given: well-shaped cells take 40."""
MOST_ENTRIES = 2e8
"""Entries of a factor's envelope up to which one is made where multigrid fails: it takes 5 bytes
for each in hexahedra, 15 in tetrahedra, 3 GB at most. A cube of 26 x 26 x 26 has 2e8."""


@dataclass(frozen=True)
class SystemSolution:
    """How a system was solved.

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
        "multigrid"; or "auto": a factor in the plane and of slender or small bodies in space,
        multigrid of others. All of them agree to 1e-9, and in bodies whose condition allows no
        factor more than 1e-8, such as beams of 100:1, to that.
    tensor
        C (d, d, d, d) in Pa that the stiffness was made with, thickness included, as `measured`
        gives it. With it residuals are summed cell by cell, which slender bodies need; without it,
        by the entries of the stiffness, whose rounding is then a part of the error.
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
            fails its residual check, or its error may be above `ACCEPTED`.
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
        return self._tried(self._factor)

    @cached_property
    def _roughly(self) -> tuple[Vectors, float]:
        """As `_directly`, by no more steps of multigrid than leave half an error at most."""
        for error in ROUGHLY:
            found = self._tried(partial(self._iterated, error))
            if found[1] < SHRINKS:
                break
        return found

    def _iterated(self, error: float, force: Array) -> Array:
        return self._hierarchy.solve(force, error=error)[0]

    def _tried(self, solve: Apply) -> tuple[Vectors, float]:
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
        if self._chosen[0] == "multigrid" and "_factor" not in vars(self):
            return self._hierarchy.correct(force)
        return self.inverse(force.T.ravel()).reshape(self.body.dim, -1).T

    def _remedy(self, **given: Array) -> str:
        """What to say of a solution that fails its check."""
        for name, values in {"stiffness": self.stiffness.data, **given}.items():
            if not np.isfinite(values).all():
                return f"the {name} holds values that are not finite"
        return "the system is singular or badly scaled"

    def _found(self, load: Array) -> tuple[Array, int, str, str]:
        """Free displacements (f,) under forces (f,); steps, the solver and the reason."""
        choice, reason = self._chosen
        if choice == "multigrid":
            if "_factor" in vars(self):  # multigrid gave up before
                reason = "its factor was made for another load"
            else:
                try:
                    return *self._hierarchy.solve(load, self._patience), choice, reason
                except SolverError as error:  # thin cells, or nu near 1/2: no matter to a factor
                    if self.choice == "multigrid" or not self._fits:
                        raise
                    reason = f"multigrid gave up: {error}"
        return self._factor(load), 0, self._factor.name, reason

    @cached_property
    def _chosen(self) -> tuple[str, str]:
        """The solver to begin with, and why."""
        if self.choice != "auto":
            return self.choice, "asked for"
        if self.body.dim == 2:
            return self._direct, "in the plane a factor is faster"
        if not self.body.in_one_piece:
            return self._direct, "parts that hang by edges may be mechanisms, which a factor shows"
        if self._effort[1] <= MOST_PRODUCTS[self._direct] * self.stiffness.nnz:
            return self._direct, "small or slender: a factor is faster"
        return "multigrid", "a large solid, whose factor fills up"

    @cached_property
    def _direct(self) -> str:
        """The factor to take where one is taken."""
        if self.choice in ("superlu", "cholmod"):
            return self.choice
        return "cholmod" if len(self._free) >= WORTH_CHOLMOD and has_cholmod() else "superlu"

    @cached_property
    def _free(self) -> Index:
        return np.flatnonzero(~self.held.T.ravel())

    @cached_property
    def _effort(self) -> tuple[float, float]:
        return factor_envelope(self.body.links, self.held)

    @property
    def _fits(self) -> bool:
        """Whether a factor is small enough to be made where multigrid fails."""
        return self._effort[0] <= MOST_ENTRIES

    @property
    def _patience(self) -> int:
        """Steps after which multigrid has taken as long as a factor would have."""
        if self.choice == "multigrid" or not self._fits:
            return MOST_STEPS
        steps = int(self._effort[1] / (A_STEP[self._direct] * self.stiffness.nnz))
        return min(max(LEAST_STEPS, steps), MOST_STEPS)

    @cached_property
    def _factor(self) -> Factor:
        with fits_in_memory(len(self._free), "unknowns"):
            order = elimination_order(self.body, self.held)
        return factorise(self.body, self._free, order, self.stiffness, self._direct)

    @cached_property
    def _hierarchy(self) -> Hierarchy:
        return Hierarchy(self.body, self.held, self.stiffness)


def favours_factor(body: Discretisation, held: Mask) -> bool:
    """Whether "auto" begins with a factor of a body in space with such components (n, d) held."""
    products = MOST_PRODUCTS["superlu"] * body.dim**2 * len(body.pattern.columns)
    return not body.in_one_piece or factor_envelope(body.links, held)[1] <= products


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
