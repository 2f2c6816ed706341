"""NGSolve on the same bodies: its own assembly, sparse Cholesky and preconditioners, one thread."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from msvalidate.problem import Array, Isotropic

ENDS = {2: ("left", "right"), 3: ("back", "front")}
"""What NGSolve calls the sides at x = 0 and x = 1."""
CHOLESKY, LOCAL = "NGSolve sparse Cholesky", "NGSolve CG, local"
MULTIGRID = "NGSolve CG, multigrid"
SOLVERS = {CHOLESKY: None, LOCAL: "local", MULTIGRID: "multigrid"}
"""Name -> preconditioner of its conjugate gradients; none of a factor."""
MOST_STEPS = 20_000
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

    The body is one metre across. Each solution makes mesh and matrix anew; conjugate gradients stop
    at `left` of the first residual. Multigrid has the points of a coarse mesh that is halved, which
    NGSolve does of tetrahedra. None without NGSolve.
    """
    try:
        import ngsolve as ng  # noqa: PLC0415
        from ngsolve.krylovspace import CGSolver  # noqa: PLC0415
    except (ImportError, OSError):
        return None
    ng.SetNumThreads(1)

    def solved(name: str) -> tuple[float, int]:
        kind = SOLVERS[name]
        halvings = doublings(cells) if kind == "multigrid" else 0
        mesh = meshed(cells, halvings, hexes=kind != "multigrid")
        space = ng.VectorH1(mesh, order=1, dirichlet=ENDS[3][0])
        form = stiffness(ng, space, material)
        before = ng.Preconditioner(form, kind) if kind else None
        form.Assemble()
        for _ in range(halvings):
            mesh.ngmesh.Refine()
            space.Update()
            form.Assemble()
        load = ng.LinearForm(space)
        load += -shear * space.TestFunction()[2] * ng.ds(definedon=mesh.Boundaries(ENDS[3][1]))
        load.Assemble()
        found, steps = ng.GridFunction(space), 0
        if before is None:
            inverse = form.mat.Inverse(space.FreeDofs(), inverse="sparsecholesky")
            found.vec.data = inverse * load.vec
        else:
            inverse = CGSolver(form.mat, before.mat, tol=left, maxiter=MOST_STEPS)
            found.vec.data = inverse * load.vec
            steps = int(inverse.iterations)
        return float(ng.InnerProduct(load.vec, found.vec)), steps

    return solved


def doublings(cells: tuple[int, ...]) -> int:
    """How often a coarse mesh of two cells across or more is halved to so many cells."""
    count = 0
    while min(cells) > 2 and not any(one % 2 for one in cells):
        cells, count = tuple(one // 2 for one in cells), count + 1
    return count


def meshed(cells: tuple[int, ...], halvings: int, *, hexes: bool) -> Any:
    """A body one metre across, of cubes or of six tetrahedra in each, before it is halved."""
    from ngsolve.meshes import MakeStructured3DMesh  # noqa: PLC0415

    nx, ny, nz = (one // 2**halvings for one in cells)
    sides = tuple(one / min(cells) for one in cells)

    def placed(*unit: float) -> tuple[float, ...]:
        return tuple(side * at for side, at in zip(sides, unit, strict=True))

    return MakeStructured3DMesh(hexes=hexes, nx=nx, ny=ny, nz=nz, mapping=placed)


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
