"""NGSolve on the same bodies: its own assembly, sparse Cholesky and preconditioners, one thread."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from msvalidate.problem import Array, Isotropic

ENDS = {2: ("left", "right"), 3: ("back", "front")}
"""What NGSolve calls the sides at x = 0 and x = 1."""
CHOLESKY, H1AMG, LOCAL = "NGSolve sparse Cholesky", "NGSolve CG, h1amg", "NGSolve CG, local"
SOLVERS = {CHOLESKY: None, H1AMG: "h1amg", LOCAL: "local"}
"""Name -> preconditioner of its conjugate gradients; none of a factor."""
MOST_STEPS = 5_000
Sheared = Callable[[str], tuple[float, int]]
"""Solves by a name of `SOLVERS`: the work of the load (J), and steps of conjugate gradients."""


@dataclass
class Block:
    """A clamped block in NGSolve: its space and its form, and how it is assembled and solved.

    Parameters
    ----------
    assemble
        Makes the matrix anew, with the pattern of its entries.
    solve
        Factorises it and solves for a unit traction on the right.
    unknowns
        Degrees of freedom, held ones too.
    farthest
        Largest displacement (m) in the last solution, of any component.
    """

    assemble: Callable[[], object]
    solve: Callable[[], object]
    unknowns: int
    farthest: Callable[[], float]


def version() -> str | None:
    """Its version, if it is there."""
    try:
        import ngsolve  # noqa: PLC0415  not everyone has it
    except (ImportError, OSError):
        return None
    return str(ngsolve.__version__)


def block(cells: tuple[int, ...], material: Isotropic, traction: float) -> Block | None:
    """Unit square or cube of cells of first order, clamped on the left; None without NGSolve.

    The same quadrature and the same numbers of unknowns as ours.
    """
    try:
        import ngsolve as ng  # noqa: PLC0415
        from ngsolve.meshes import MakeStructured2DMesh, MakeStructured3DMesh  # noqa: PLC0415
    except (ImportError, OSError):
        return None
    ng.SetNumThreads(1)
    sizes = dict(zip(("nx", "ny", "nz"), cells, strict=False))
    mesh = (
        MakeStructured2DMesh(quads=True, **sizes)
        if len(cells) == 2
        else MakeStructured3DMesh(hexes=True, **sizes)
    )
    held, pulled = ENDS[len(cells)]
    space = ng.VectorH1(mesh, order=1, dirichlet=held)
    load = ng.LinearForm(space)
    load += traction * space.TestFunction()[0] * ng.ds(definedon=mesh.Boundaries(pulled))
    load.Assemble()
    found = ng.GridFunction(space)
    made: list[Any] = []

    def assemble() -> None:
        made[:] = [stiffness(ng, space, material)]
        made[0].Assemble()

    def solve() -> None:
        inverse = made[0].mat.Inverse(space.FreeDofs(), inverse="sparsecholesky")
        found.vec.data = inverse * load.vec

    def farthest() -> float:
        values: Array = np.abs(found.vec.FV().NumPy())
        return float(values.max())

    return Block(assemble, solve, int(space.ndof), farthest)


def sheared(
    cells: tuple[int, int, int], material: Isotropic, shear: float, left: float
) -> Sheared | None:
    """Cubic cells of first order, clamped at one end, pulled along -z at the other by `shear` Pa.

    The body is one metre across.

    Each solution assembles anew; conjugate gradients stop at `left` of the first residual. None
    without NGSolve.
    """
    try:
        import ngsolve as ng  # noqa: PLC0415
        from ngsolve.krylovspace import CGSolver  # noqa: PLC0415
        from ngsolve.meshes import MakeStructured3DMesh  # noqa: PLC0415
    except (ImportError, OSError):
        return None
    ng.SetNumThreads(1)
    nx, ny, nz = cells
    sides = tuple(one / min(cells) for one in cells)

    def placed(*unit: float) -> tuple[float, ...]:
        return tuple(side * at for side, at in zip(sides, unit, strict=True))

    mesh = MakeStructured3DMesh(hexes=True, nx=nx, ny=ny, nz=nz, mapping=placed)
    held, pulled = ENDS[3]
    space = ng.VectorH1(mesh, order=1, dirichlet=held)

    def solved(name: str) -> tuple[float, int]:
        load = ng.LinearForm(space)
        load += -shear * space.TestFunction()[2] * ng.ds(definedon=mesh.Boundaries(pulled))
        load.Assemble()
        form, found, kind = stiffness(ng, space, material), ng.GridFunction(space), SOLVERS[name]
        before = ng.Preconditioner(form, kind) if kind else None
        form.Assemble()
        steps = 0
        if before is None:
            inverse = form.mat.Inverse(space.FreeDofs(), inverse="sparsecholesky")
            found.vec.data = inverse * load.vec
        else:
            inverse = CGSolver(form.mat, before.mat, tol=left, maxiter=MOST_STEPS)
            found.vec.data = inverse * load.vec
            steps = int(inverse.iterations)
        return float(ng.InnerProduct(load.vec, found.vec)), steps

    return solved


def stiffness(ng: Any, space: Any, material: Isotropic) -> Any:
    """The form of linear elasticity: 2μ ε:ε + λ div div, plane stress in the plane."""
    E, nu = material.E, material.nu
    mu, lam = E / (2 * (1 + nu)), E * nu / ((1 + nu) * (1 - 2 * nu))
    if material.dim == 2:
        lam = 2 * lam * mu / (lam + 2 * mu)
    u, v = space.TnT()
    left, right = (0.5 * (ng.Grad(w) + ng.Grad(w).trans) for w in (u, v))
    form = ng.BilinearForm(space, symmetric=True)
    form += (2 * mu * ng.InnerProduct(left, right) + lam * ng.div(u) * ng.div(v)) * ng.dx
    return form
