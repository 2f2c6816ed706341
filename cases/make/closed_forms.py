"""Exact answers of elasticity, where there are any: uniform states, and Lamé's ring.

Sources: Hooke's law; for the ring [TimoshenkoGoodier1970], section 28.
"""

from __future__ import annotations

import numpy as np

from cases.make.answer import Answer
from cases.make.bodies import BLOCK, PRESS, PULL, SHEAR
from cases.make.meshes import coarsest_nodes
from cases.make.statements import STRAIN, STRESS, THICKNESS, E, Statement

Array = np.ndarray
CELL = 0.25
"""Side (m) of the one cell."""
INNER, OUTER = 0.5, 1.0
"""Radii (m) of the ring."""
ROUNDING = 1e-14
"""Of what a closed form gives in double precision, over the largest value."""


def closed_form(statement: Statement, nu: float) -> Answer | None:
    """The exact answer to a statement at one ratio; None where there is none."""
    kind, _, load = statement.body.partition("_")
    if statement.body == "lame_ring":
        return _ring(statement, nu)
    if statement.is_uniform:
        sides = np.array((CELL,) * statement.dim if kind == "cell" else BLOCK[: statement.dim])
        return _uniform(statement, load, sides, nu)
    return None


def _answer(u: Array, by_ratio: Array, quantities: dict[str, Array], floors: list[float]) -> Answer:
    """Quantities with what rounding leaves of each, over the sizes (floors) of their kinds."""
    uncertainty = {
        name: ROUNDING * max(float(np.abs(value).max()), floor)
        for (name, value), floor in zip(quantities.items(), floors, strict=True)
    }
    uncertainty |= {"displacement": ROUNDING * float(np.abs(u).max())}
    uncertainty |= {"by_ratio": ROUNDING * float(np.abs(by_ratio).max())}
    return Answer(u, -u, by_ratio, quantities, uncertainty, np.nan, 0, exact=True)


def _uniform(statement: Statement, load: str, sides: Array, nu: float) -> Answer:
    """Uniform stress: strain by Hooke's law, and the motion that the supports leave."""
    d, x = statement.dim, coarsest_nodes(statement.grid)
    stress = np.zeros((d, d))
    if load == "pull":
        stress[0, 0] = PULL
    elif load == "pressure":
        stress = -PRESS * np.eye(d)
    else:
        stress[0, 1] = stress[1, 0] = SHEAR
    strain, by_ratio = _hooke(stress, nu, statement.state)
    # Corners are held so that an axis's own plane of supports does not turn: shear tilts y alone.
    for tensor in (strain, by_ratio):
        tensor[:] = np.triu(tensor, 1) * 2 + np.diag(np.diag(tensor))
    thickness = THICKNESS if d == 2 else 1.0
    volume = thickness * float(np.prod(sides))
    energy = volume * float((stress * (strain + strain.T) / 2).sum()) / 2
    quantities: dict[str, Array] = {}
    areas = volume / sides
    for i in range(d):
        force = np.zeros(d)
        if load != "shear":  # rollers on the low side of each axis
            force[i] = -stress[i, i] * areas[i]
        quantities[f"reaction {i + 1}"] = force + 0.0
    pairs = [(0, 0), (1, 1), (0, 1)] if d == 2 else [(0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)]
    quantities["strain energy"] = np.array([energy])
    quantities["mean stress"] = np.array([stress[pair] for pair in pairs])
    floors = [float(areas.max()) * PULL] * d + [0.0, PULL]
    return _answer(x @ strain.T, x @ by_ratio.T, quantities, floors)


def _hooke(stress: Array, nu: float, state: str) -> tuple[Array, Array]:
    """Strain (d, d) of a stress, and its slope by the ratio.

    ε = (1 + nu)/E σ - nu/E tr σ I; in plane strain with tr σ = (1 + nu)(σxx + σyy).
    """
    trace, one = np.trace(stress), np.eye(len(stress))
    if state == STRAIN:
        strain = ((1 + nu) * stress - nu * (1 + nu) * trace * one) / E
        return strain, (stress - (1 + 2 * nu) * trace * one) / E
    strain = ((1 + nu) * stress - nu * trace * one) / E
    return strain, (stress - trace * one) / E


def _ring(statement: Statement, nu: float) -> Answer:
    """Lamé's ring under pressure from inside, a quarter of it between rollers."""
    a, b, p = INNER, OUTER, PRESS
    x = coarsest_nodes(statement.grid)
    r = np.hypot(*x.T)[:, None]
    c = p * a**2 / (b**2 - a**2)
    inner, outer = _ring_parts(nu, statement.state)
    by_inner, by_outer = (
        np.array(_ring_parts(nu + 1e-6, statement.state)) - _ring_parts(nu - 1e-6, statement.state)
    ) / 2e-6
    # u_r = c/E' ((1 - nu') r + (1 + nu') b²/r), written as c (inner r + outer b²/r).
    u = c * (inner * x + outer * b**2 * x / r**2)
    by_ratio = c * (by_inner * x + by_outer * b**2 * x / r**2)
    u, by_ratio = _on_axes(u, x), _on_axes(by_ratio, x)
    force = p * a * THICKNESS
    edge = c * (inner * a + outer * b**2 / a)
    energy = p * edge * (np.pi / 2 * a) * THICKNESS / 2
    mean = _ring_mean(a, b, c, np.pi / 4 * (b**2 - a**2))
    quantities = {
        "reaction 1": np.array([0.0, -force]),
        "reaction 2": np.array([-force, 0.0]),
        "strain energy": np.array([energy]),
        "mean stress": mean,
    }
    return _answer(u, by_ratio, quantities, [force, force, 0.0, p])


def _ring_parts(nu: float, state: str) -> tuple[float, float]:
    """(1 - nu')/E' and (1 + nu')/E' of the plane's own constants."""
    if state == STRESS:
        return (1 - nu) / E, (1 + nu) / E
    return (1 + nu) * (1 - 2 * nu) / E, (1 + nu) / E


def _ring_mean(a: float, b: float, c: float, area: float) -> Array:
    """∫σ dA / A of σ_rr = c (1 - b²/r²), σ_θθ = c (1 + b²/r²) over the quarter.

    σxx = c (1 - b²/r² cos 2θ), σyy = c (1 + b²/r² cos 2θ), σxy = -c b²/r² sin 2θ; over a quarter
    cos 2θ has no mean, and ∫ sin 2θ dθ = 1.
    """
    return np.array([c, c, -c * b**2 * np.log(b / a) / area])


def _on_axes(u: Array, x: Array) -> Array:
    """Displacements that are 0 across an axis of symmetry exactly so."""
    return np.where(x == 0, 0.0, u)
