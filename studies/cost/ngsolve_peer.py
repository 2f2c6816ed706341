"""NGSolve on the same bodies: its own assembly, sparse Cholesky and preconditioners, one thread."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from msvalidate import kit

ENDS = {2: ("left", "right"), 3: ("back", "front")}
"""What NGSolve calls the sides at x = 0 and x = 1."""


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


def block(cells: tuple[int, ...], material: kit.Isotropic, traction: float) -> Block | None:
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
        values: kit.Array = np.abs(found.vec.FV().NumPy())
        return float(values.max())

    return Block(assemble, solve, int(space.ndof), farthest)


def stiffness(ng: Any, space: Any, material: kit.Isotropic) -> Any:
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
