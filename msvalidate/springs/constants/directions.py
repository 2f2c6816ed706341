"""A material seen along other axes: its tensor turned, and its moduli in any direction."""

from __future__ import annotations

import numpy as np

from msvalidate.problem import VOIGT, Array, ProblemError
from msvalidate.problem.checks import finite, finite_angle, finite_number
from msvalidate.springs.constants.stiffness import AXES_OF, check_voigt, voigt_directions
from msvalidate.springs.lattice.turned import rotation_matrix


def rotate_tensor(tensor: Array, turn: float | Array) -> Array:
    """Rotate a stiffness tensor by a counter-clockwise angle or a matrix (d, d).

    The angle is in rad.

    Source: the law of transformation of tensors, [Nye1957], chapter VIII.

    Raises
    ------
    ProblemError
        If it is no Voigt tensor, an angle is given in space, or a matrix is no rotation.
    """
    C = check_voigt(tensor)
    Q = rotation_matrix(turn, AXES_OF[len(C)])
    # Stress of the turned body from its own stress: the Bond matrix for Voigt stress vectors.
    first, second = np.array(VOIGT[len(Q)]).T
    B = Q[np.ix_(first, first)] * Q[np.ix_(second, second)]
    swapped = Q[np.ix_(first, second)] * Q[np.ix_(second, first)]
    bond = np.where(first == second, B, B + swapped)
    with np.errstate(over="ignore", invalid="ignore"):
        return np.array(finite("turned tensor", bond @ C @ bond.T))


def directional_modulus(tensor: Array, directions: Array) -> Array:
    """Young's modulus (q,), in Pa or N/m, along unit vectors (q, d).

    1/E = v S v, v the Voigt vector of n⊗n and S the compliance.

    Source: [Nye1957], chapter VIII: E = 1/S of the rotated compliance.

    Raises
    ------
    ProblemError
        If it is no Voigt tensor, is singular, or the directions are not unit vectors.
    """
    C = check_voigt(tensor)
    n = finite("directions", directions)
    d = AXES_OF[len(C)]
    if n.ndim != 2 or n.shape[1] != d or np.abs((n**2).sum(axis=1) - 1).max(initial=0) > 1e-9:
        raise ProblemError(f"directions: shape {n.shape}; give unit vectors (q, {d})")
    v = voigt_directions(n)
    return np.asarray(1 / np.einsum("qi,ij,qj->q", v, _compliance(C), v))


def directional_ratio(tensor: Array, angle: float) -> float:
    """Poisson's ratio of a 2D body in tension at `angle` (rad) to x.

    nu = -w S v/(v S v), v and w the Voigt vectors of n⊗n along and across, and S the compliance.

    Source: [Nye1957], chapter VIII: -S12/S11 of the rotated compliance.

    Raises
    ------
    ProblemError
        If it is no plane tensor, is singular, or the angle is not one finite number.
    """
    turn = finite_angle("angle", angle)
    c, s = np.cos(turn), np.sin(turn)
    ratio = contraction_ratios(check_voigt(tensor, 2), np.array([c, s]), np.array([[-s, c]]))
    return finite_number("directional ratio", ratio[0])


def contraction_ratios(tensor: Array, along: Array, across: Array) -> Array:
    """Poisson's ratios (q,) of the contraction along unit vectors (q, d), in tension along one.

    Source: as for `directional_ratio`.

    Raises
    ------
    ProblemError
        If it is no Voigt tensor, or is singular.
    """
    strain = _compliance(check_voigt(tensor)) @ (v := voigt_directions(along[None])[0])
    with np.errstate(all="ignore"):
        return np.asarray(-(voigt_directions(across) @ strain) / (v @ strain))


def _compliance(C: Array) -> Array:
    if np.linalg.matrix_rank(C) < len(C):
        raise ProblemError("directional moduli: the tensor is singular; some strain costs nothing")
    with np.errstate(all="ignore"):
        return np.asarray(np.linalg.inv(C))
