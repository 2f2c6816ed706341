"""What several tests of elements share: cells with middle nodes, Hooke's law, moments,
a manufactured solution."""

from __future__ import annotations

import numpy as np

from msvalidate.problem import SIDES, BodyForce, Problem, Support, Traction
from reference_fem import box_discretisation, solve_problem
from reference_fem.mesh.elements import ELEMENTS

# C16 and C26 couple stretch and shear: a swapped index cannot hide behind a zero.
SKEW = np.array([[3.0, 0.9, 0.5], [0.9, 2.0, -0.3], [0.5, -0.3, 1.1]])


def compliance(E, nu):
    """Hooke's law as engineers write it: strains (6,) from stresses (6,)."""
    S = np.diag([1.0, 1, 1, *[2 * (1 + nu)] * 3])
    S[:3, :3] -= nu * (1 - np.eye(3))
    return S / E


def with_middles(corners, cells, element):
    """Points and cells in VTK order: edge midpoints after the corners, the mean of them last."""
    corners, cells = np.array(corners, dtype=float), np.array(cells)
    kind = ELEMENTS[element]
    if kind.simplex:
        cells = np.vstack([cells[:, [0, 1, 2]], cells[:, [0, 2, 3]]])
    if kind.degree == 1:
        return corners, cells
    edges = np.sort(np.stack([cells, np.roll(cells, -1, axis=1)], axis=2), axis=2)
    ends, which = np.unique(edges.reshape(-1, 2), axis=0, return_inverse=True)
    middles = [corners, corners[ends].mean(axis=1)]
    columns = [cells, len(corners) + which.reshape(cells.shape)]
    if any(len(amid) == 4 for amid in kind.middles):
        middles.append(corners[cells].mean(axis=1))
        columns.append(len(corners) + len(ends) + np.arange(len(cells))[:, None])
    return np.vstack(middles), np.hstack(columns)


def moment(points, force):
    """Of forces (n, d) at points (n, d), about the origin: a number in the plane, (3,) in space."""
    if points.shape[1] == 2:
        return float((points[:, 0] * force[:, 1] - points[:, 1] * force[:, 0]).sum())
    return np.cross(points, force).sum(axis=0)


WAVES = np.array([[2.1, -1.3, 0.8], [1.1, 1.9, -0.7], [-0.9, 0.6, 1.7]])
"""One wave vector (1/m) for each displacement component; of fewer axes their first parts."""
PHASES = np.array([0.4, -0.7, 0.2])
PAIRS = {2: [(0, 0), (1, 1), (0, 1)], 3: [(0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)]}


def exact(x):
    """Displacement (n, d) of the manufactured solution."""
    d = x.shape[1]
    return np.sin(x @ WAVES[:d, :d].T + PHASES[:d])


def gradient(x):
    """∂u_k/∂x_l, (n, d, d)."""
    d = x.shape[1]
    return np.cos(x @ WAVES[:d, :d].T + PHASES[:d])[:, :, None] * WAVES[:d, :d]


def indexed(C, d):
    """C_ijkl of a tensor in Voigt's order, by another route than the code."""
    # σ = Σ σ_I unit[I], and engineering strains are ε : unit[I].
    unit = np.zeros((len(C), d, d))
    for number, (i, j) in enumerate(PAIRS[d]):
        unit[number, i, j] = unit[number, j, i] = 1
    return np.einsum("IJ,Iij,Jkl->ijkl", C, unit, unit)


def manufactured(box, material, C, loaded, fault=0.0):
    """Problem whose answer is `exact`, loaded on some sides and held on the others."""
    d, C = box.dim, indexed(C, box.dim)
    waves = WAVES[:d, :d]
    # -div σ: each component differentiates to minus two wave numbers times itself.
    body_force = np.einsum("ijkl,kj,kl->ki", C, waves, waves)
    fields = tuple((lambda x, axis=axis: exact(x)[:, axis]) for axis in range(d))
    loads, supports = [BodyForce(lambda x: (1 + fault) * exact(x) @ body_force)], []
    for side, (axis, _) in list(SIDES.items())[: 2 * d]:
        if side in loaded:
            pull = lambda x, axis=axis: np.einsum("jkl,nkl->nj", C[axis], gradient(x))  # noqa: E731
            loads.append(Traction(box.side(side), pull))
        else:
            supports.append(Support(box.side(side), fields))
    return Problem(box, material, tuple(supports), tuple(loads))


def errors(body, displacement):
    """Root mean square error of the displacement and of its gradient, by fine quadrature."""
    d, fine = body.dim, body.quadrature(5 if body.element.degree == 1 else 7)
    x = np.asarray(fine.global_coordinates()).reshape(d, -1).T
    fields = [fine.interpolate(displacement[body.node, axis]) for axis in range(d)]
    u = np.stack([np.asarray(f).ravel() for f in fields], axis=1)
    g = np.stack([f.grad.reshape(d, -1).T for f in fields], axis=1)
    weights = fine.dx.ravel()
    return tuple(
        np.sqrt((weights @ ((found - wanted) ** 2).reshape(len(x), -1)).sum())
        for found, wanted in ((u, exact(x)), (g, gradient(x)))
    )


def convergence(problem, element, cells):
    """Orders and levels (displacement, gradient); levels in units of the interpolant's error."""
    found, interpolated = [], []
    for n in (cells, 2 * cells):
        body = box_discretisation(problem.domain, n, element)
        found.append(errors(body, solve_problem(problem, body).displacement))
        interpolated.append(errors(body, exact(body.points)))
    return np.log2(np.divide(*found)), np.divide(found[-1], interpolated[-1])
