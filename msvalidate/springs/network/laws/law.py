"""Records of functions that define a law of springs or of cells."""

from __future__ import annotations

from collections.abc import Callable

from msvalidate.problem import Array
from msvalidate.problem.records import dataclass

Coefficients = tuple[Array, ...]


@dataclass(frozen=True, eq=False)
class SpringLaw:
    """Law of springs as functions of the squared length s (m²).

    All arrays are (m,).

    Every function takes the springs' coefficients first. A spring stores φ(s), pulls with
    f = dφ/dL, and its force over its length, f/L = 2 dφ/ds, is its *pull* (N/m). Forces are sums of
    changes: between s0 and s, whose difference `grown` is known to all its digits, what changes
    must be too.

    Attributes
    ----------
    name
        As users write it.
    coefficients
        From stiffness (N/m) and rest length (m).
    pull
        (coefficients, s): f/L in N/m.
    axial
        (coefficients, s): df/dL in N/m. A tangent block is pull·(I - n nᵀ) + axial·n nᵀ.
    change
        (coefficients, s0, s, grown): pull(s) - pull(s0).
    work
        (coefficients, s0, s, grown): φ(s) - φ(s0) - ½ pull(s0)·grown in J.
    stored
        (coefficients, s): φ(s) in J where there is a length at which it is 0; else 0.
    rests
        Whether there is a length at which it does not pull, its rest length. Only where there is
        none may stiffness be negative: what is stable is then a sum.
    loops
        Coefficients -> two numbers a spring, a and b, for compiled loops; None where they lack it.
    straight
        Whether the pull is a·s - b there; else a - b/√s.
    """

    name: str
    coefficients: Callable[[Array, Array], Coefficients]
    pull: Callable[[Coefficients, Array], Array]
    axial: Callable[[Coefficients, Array], Array]
    change: Callable[[Coefficients, Array, Array, Array], Array]
    work: Callable[[Coefficients, Array, Array, Array], Array]
    stored: Callable[[Coefficients, Array], Array]
    rests: bool = True
    loops: Callable[[Coefficients], tuple[Array, Array]] | None = None
    straight: bool = False


@dataclass(frozen=True, eq=False)
class CellLaw:
    """Energy U(J) per rest volume of a cell as a function of J - 1.

    All arrays are (c,).

    Every function takes stiffness and pressure at rest of the cells first.

    Attributes
    ----------
    name
        As users write it.
    at_rest
        (stiffness, pressure): U'(1).
    change
        (stiffness, pressure, j): U'(J) - U'(1), with all digits of j.
    curvature
        (stiffness, pressure, j): U''(J).
    work
        (stiffness, pressure, j): U(J) - U(1) - U'(1)·j.
    barrier
        Whether a cell cannot be pressed to no volume: J > 0.
    compiled
        Whether compiled loops have it.
    """

    name: str
    at_rest: Callable[[Array, Array], Array]
    change: Callable[[Array, Array, Array], Array]
    curvature: Callable[[Array, Array, Array], Array]
    work: Callable[[Array, Array, Array], Array]
    barrier: bool = False
    compiled: bool = False
