"""Cantilever of a lattice, compared with elasticity and with a network of its springs."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import partial
from typing import Any

import numpy as np
from scipy.optimize import least_squares

from msvalidate.case.judge.mistakes import factorise_network
from msvalidate.linear_algebra.norms import max_length
from msvalidate.problem import (
    Anisotropic,
    Array,
    Box,
    Isotropic,
    Material,
    Problem,
    SolverError,
    Support,
    Traction,
    Weight,
)
from msvalidate.problem.records import dataclass, replace
from msvalidate.problem.records import field as default
from msvalidate.simulators.exchange.protocol import (
    Answer,
    Request,
    Simulator,
    SimulatorError,
    ask,
    stated_residual_motion,
)
from msvalidate.simulators.lattice.measure import LatticeSprings, MeasuredLattice, fit_springs
from msvalidate.simulators.lattice.regular import SPACING, Regular, RegularBlock, regular_block
from msvalidate.simulators.probe.masses import Masses, patterns
from msvalidate.simulators.probe.probe import STRAIN
from msvalidate.simulators.probe.reading import BAND, SHOWN
from msvalidate.springs.constants.stiffness import (
    Moduli,
    axes_moduli,
    isotropic_moduli,
    isotropic_part,
    isotropic_tensor,
)
from msvalidate.springs.network import spring_network
from msvalidate_check.beside import Driven, Field, Mistake, best_scale
from msvalidate_check.causes import Cause
from msvalidate_check.diagnosis import explain
from reference_fem.body import solve_problem
from reference_fem.elasticity import solve_on
from reference_fem.mesh.boxes import box_discretisation
from reference_fem.mesh.from_mesh import mesh_discretisation

COUNTS = {2: (8, 4), 3: (4, 2, 2)}
"""Cells of the cantilever along each axis."""
FINER = {2: ("Q2", 2), 3: ("H2", 1)}
"""Element of the reference, and the number of its cells per side of a cell."""
END, WEIGHT = "end load", "weight"
"""Loads of the cantilever."""


@dataclass(frozen=True, eq=False)
class LatticeBody:
    """A cantilever in equilibrium.

    Parameters
    ----------
    load
        `END` or `WEIGHT`.
    part, request, about
        Mesh and springs, the request, and the simulator's own record of the answer.
    move
        Displacement (n, d) in m: the odd part of those under the load and under its opposite.
    rest
        Part of the displacement that may still change, as stated; NaN if it is not known.
    prestrain
        Strain along the body that is the same under both loads, due to rest lengths.
    errors
        Largest difference relative to the largest displacement, from elasticity of the material and
        of the homogenised solid, by quadratic and by linear elements, and from our network of its
        springs: "elasticity", "solid", "elements" and "network". An unknown one has no entry.
    factor, residual
        Displacement relative to that of our network, or of elements, and what this factor leaves.
    mesh_error
        Difference of linear elements on the same mesh from the homogenised solid, likewise.
    causes
        Explanations of what our network leaves.
    """

    load: str
    part: Regular
    request: Request
    move: Array
    rest: float
    about: Mapping[str, Any]
    prestrain: float
    errors: Mapping[str, float] = default(default_factory=dict)
    factor: float = np.nan
    residual: float = np.nan
    mesh_error: float = 0.0
    causes: tuple[Cause, ...] = ()


def bring_to_rest(
    simulator: Simulator,
    shape: str,
    material: Isotropic,
    settings: Mapping[str, Any],
    precision: str,
    spacing: float = SPACING,
) -> list[LatticeBody]:
    """Solve for the cantilever under each load and its opposite.

    Raises
    ------
    CannotRepresent, SimulatorError
        As the simulator, or if the body does not move.
    """
    part = regular_block(shape, COUNTS[material.dim], spacing)
    bodies = []
    for load in (END, WEIGHT):
        force, gravity = _loads(part, material, load, STRAIN.get(precision, STRAIN["float64"]))
        x = part.mesh.points
        held = np.repeat(x[:, :1] == 0, x.shape[1], axis=1)
        mass = RegularBlock(part.mesh, material).lumped
        request = Request(
            "rest", part.mesh, material, mass=mass, gravity=gravity, force=force, held=held,
            value=np.zeros(x.shape), settings=settings, name=f"cantilever, {load}",
        )  # fmt: skip
        answer = ask(simulator, request)
        back = ask(simulator, replace(request, force=-force, gravity=-gravity))
        there, other = np.asarray(answer.displacement), np.asarray(back.displacement)
        move, length = (there - other) / 2, part.box.size[0]
        even = float((there + other)[x[:, 0] == length, 0].mean()) / 2 / length
        if not max_length(move):
            raise SimulatorError(f"answer: {request.name}: the body does not move")
        rest = stated_residual_motion(request, Answer(displacement=move, about=answer.about))
        bodies.append(LatticeBody(load, part, request, move, rest, answer.about, even))
    return bodies


def _loads(part: Regular, law: Isotropic, load: str, strain: float) -> tuple[Array, Array]:
    """Forces (n, d) in N and gravity (d,) in m/s² that strain the root by about `strain`."""
    x, (length, height) = part.mesh.points, part.box.size[:2]
    force, gravity = np.zeros(x.shape), np.zeros(x.shape[1])
    if load == WEIGHT:
        gravity[-1] = -strain * law.E * height / (3 * law.density * length**2)
        return force, gravity
    share = RegularBlock(part.mesh, law).lumped * (x[:, 0] == length)
    traction = strain * law.E * height / (6 * length)
    total = traction * part.box.volume / length * law.thickness
    force[:, -1] = -total * share / share.sum()
    return force, gravity


def compare_body(
    body: LatticeBody,
    C: Array | None,
    springs: LatticeSprings | None,
    masses: Masses | None,
    band: float,
    total: float = 1.0,
) -> LatticeBody:
    """Compare a body with elasticity, with its homogenised solid and with our network.

    Parameters
    ----------
    C, springs, masses
        Homogenised tensor (Pa), springs and masses as measured; None if they are not known.
    band
        Largest difference relative to the largest displacement that is none.
    total
        Mass relative to the requested one.
    """
    material = body.request.material
    request = replace(body.request, mass=total * body.request.mass)
    elastic = _elasticity(body, material)
    errors, own, mesh_error = {"elasticity": _difference(body.move, elastic)}, elastic, 0.0
    if C is not None:
        solid = Anisotropic(C, material.density, material.thickness)
        elastic = _elasticity(body, solid)
        elements = mesh_discretisation(request.mesh)
        own = solve_on(
            elements, solid, request.held, request.value, request.load, allow_locked=True
        )
        errors |= {
            "solid": _difference(body.move, elastic),
            "elements": _difference(body.move, own),
        }
        mesh_error = _difference(own, elastic)
    if springs is not None and springs.misfit <= band:
        mass = request.mass
        if masses is not None:
            pattern = patterns(RegularBlock(request.mesh, material)).get(masses.pattern, mass)
            mass = pattern * (mass.sum() / pattern.sum())
        network = network_displacement(body, springs.constants, springs.weight, mass)
        errors["network"] = _difference(body.move, network)
        if errors["network"] <= band or errors.get("elements", 1.0) > band:
            own = network
    factor = best_scale(body.move, own)
    residual = _difference(body.move / factor, own) if factor else np.inf
    body = replace(body, errors=errors, mesh_error=mesh_error, factor=factor, residual=residual)
    if factor < 0 or residual > band:
        driven: Driven = "loads" if body.load == END else "weight"
        x = request.mesh.points
        span = tuple(zip(x.min(axis=0), x.max(axis=0), strict=True))
        mistakes = []
        if springs is not None:
            equal = partial(network_displacement, body, springs.constants, springs.weight)
            even = np.full(len(x), request.mass.mean())
            mistakes.append(Mistake("equal masses", lambda: [(1.0, equal(even))]))
        field = Field(x, body.move, own, band / 10, driven, span, mistakes=mistakes)
        causes = explain(field)
        return replace(body, causes=causes)
    return body


def _difference(move: Array, other: Array) -> float:
    return max_length(move - other) / max_length(other)


def network_displacement(body: LatticeBody, constants: Array, weight: float, mass: Array) -> Array:
    """Displacement (n, d) in m of our network of springs under a body's loads."""
    request, part = body.request, body.part
    network = spring_network(
        part.mesh.points, part.springs, part.stiffness(constants, weight), mass=mass,
        fixed=request.held, force=request.force + np.outer(mass, request.gravity),
    )  # fmt: skip
    factor = factorise_network(network)
    if factor is None:
        raise SolverError("cantilever: the springs measured are not stable")
    return factor(network)


def fit_to_rest(body: LatticeBody, start: LatticeSprings) -> LatticeSprings:
    """Springs whose network moves as a body under its end load, for programs without motion."""
    kinds = min(len(start.constants), 2)

    def springs(p: Array) -> tuple[Array, float]:
        constants = start.constants.copy()
        constants[:kinds] *= np.exp(p[:kinds])
        return constants, float(np.exp2(p[kinds]) / 2)

    def misfit(p: Array) -> Array:
        u = network_displacement(body, *springs(p), body.request.mass)
        return np.asarray((u - body.move).ravel() / max_length(body.move))

    first = network_displacement(body, *springs(np.zeros(kinds + 1)), body.request.mass)
    times = best_scale(first, body.move)
    if not times > 0:
        raise SimulatorError(f"answer: {body.request.name}: it moves against its load")
    fit = least_squares(misfit, np.r_[np.full(kinds, np.log(times)), 0.0], xtol=1e-12)
    residual = float(np.linalg.norm(fit.fun.reshape(body.move.shape), axis=1).max())
    return LatticeSprings(*springs(fit.x), residual)


def _elasticity(body: LatticeBody, law: Material) -> Array:
    """Displacement (n, d) in m of elasticity under a body's loads, by quadratic elements."""
    request, size = body.request, body.part.box.size
    box, none = Box(size), (0.0,) * len(size)
    total = tuple((request.force.sum(axis=0) * size[0] / (box.volume * law.thickness)).tolist())
    load: Weight | Traction = Weight(tuple(request.gravity.tolist()))
    if body.load == END:
        load = Traction(box.side("right"), total)
    problem = Problem(box, law, (Support(box.side("left"), none),), (load,), "cantilever")
    element, parts = FINER[len(size)]
    cells = tuple(parts * n for n in COUNTS[len(size)])
    solution = solve_problem(problem, box_discretisation(box, cells, element))
    return np.asarray(solution.at(request.mesh.points))


@dataclass(frozen=True, eq=False)
class LatticeReport:
    """Solid, springs and bodies of a lattice.

    Parameters
    ----------
    C, mean, misfit
        Homogenised tensor (Pa), moduli of the nearest isotropic solid, and the part of the tensor
        that this solid leaves.
    springs, right
        Springs that have the tensor, and those of the requested material.
    steps
        As steps show it; None of programs without motion.
    total
        Mass relative to the requested one; NaN if it is not known.
    bodies
        Cantilevers in equilibrium.
    """

    C: Array
    mean: Moduli
    misfit: float
    springs: LatticeSprings
    right: LatticeSprings
    steps: MeasuredLattice | None
    total: float
    bodies: tuple[LatticeBody, ...]


def make_report(
    shape: str,
    law: Isotropic,
    spacing: float,
    steps: MeasuredLattice | None,
    bodies: list[LatticeBody],
) -> LatticeReport | None:
    """Report the effective solid, springs, total mass and bodies of a measured lattice.

    Return None for a mechanism, or if neither steps nor bodies were measured. The mass follows from
    the stiffness of bodies under forces relative to that of steps.
    """
    dim, total, block = law.dim, math.nan, regular_block(shape, (2,) * law.dim, spacing)
    target = isotropic_tensor(dim, *axes_moduli(law, dim, "lattice")) / law.thickness
    right = fit_springs(block, target, target, law.thickness)
    if steps is not None and steps.is_mechanism:
        return None
    if steps is not None:
        C, springs, masses = steps.C, steps.springs, steps.masses
    elif bodies:
        springs, masses = fit_to_rest(bodies[0], right), None
        C = block.tensor(springs.constants, 0.5, law.thickness)
    else:
        return None
    compare = partial(compare_body, springs=springs, masses=masses, band=BAND)
    compared = tuple(compare(body, C) for body in bodies)
    first = next((each for each in compared if not max(each.rest, each.residual) > BAND), None)
    meant = abs(isotropic_moduli(C).E * law.thickness / axes_moduli(law, dim, "")[0] - 1) <= SHOWN
    if masses is not None and first is not None and first.factor > 0:
        total = 1.0 if meant or abs(first.factor - 1) <= BAND else 1 / first.factor
        C = C * total
        springs = replace(springs, constants=springs.constants * total)
        compared = tuple(compare(body, C, springs=springs, total=total) for body in bodies)
    mean = isotropic_moduli(C)
    residual = C - isotropic_part(C)
    scale = np.sqrt(np.r_[np.ones(dim), np.full(len(C) - dim, 2.0)])
    misfit = np.linalg.norm(residual * np.outer(scale, scale))
    misfit /= np.linalg.norm(C * np.outer(scale, scale))
    return LatticeReport(C, mean, float(misfit), springs, right, steps, total, compared)
