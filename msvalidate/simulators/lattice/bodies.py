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
from msvalidate.simulators.bodies.bodies import explain_body
from msvalidate.simulators.exchange.export import on_mesh, request_on
from msvalidate.simulators.exchange.protocol import (
    Answer,
    Request,
    Simulator,
    SimulatorError,
    ask,
    stated_residual_motion,
)
from msvalidate.simulators.lattice.measure import (
    LatticeSprings,
    MeasuredLattice,
    fit_springs,
    is_mechanism,
)
from msvalidate.simulators.lattice.regular import SPACING, Regular, RegularBlock, regular_block
from msvalidate.simulators.probe.masses import Masses
from msvalidate.simulators.probe.probe import STRAIN
from msvalidate.simulators.probe.reading import BAND, SHOWN, anisotropy
from msvalidate.springs.constants.stiffness import (
    Moduli,
    axes_moduli,
    isotropic_moduli,
    isotropic_tensor,
)
from msvalidate.springs.network import Network, spring_network
from msvalidate_check.beside import Driven, Mistake, best_scale
from msvalidate_check.causes import Cause
from reference_fem.body import solve_problem
from reference_fem.mesh.boxes import box_discretisation
from reference_fem.mesh.from_mesh import mesh_discretisation

COUNTS = {2: (8, 4), 3: (4, 2, 2)}
"""Cells of the cantilever along each axis."""
FINER = {2: ("Q2", 2), 3: ("H2", 1)}
"""Element of the reference, and the number of its cells per side of a cell."""
END, WEIGHT = "end load", "weight"
"""Loads of the cantilever."""
UNLIKE = 2.0
"""Factor on the discretisation error of elements, up to which unknown springs differ from them."""


@dataclass(frozen=True, eq=False)
class LatticeBody:
    """A cantilever in equilibrium.

    Parameters
    ----------
    load
        `END` or `WEIGHT`.
    part, problem, request
        Mesh and springs, the problem, and the request.
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
    problem: Problem
    request: Request
    move: Array
    rest: float
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
    box, x = part.box, part.mesh.points
    length, height = box.size[:2]
    strained = STRAIN.get(precision, STRAIN["float64"]) * material.E * height / length
    down = -strained * np.eye(material.dim)[-1]
    loads: dict[str, Traction | Weight] = {
        END: Traction(box.side("right"), tuple((down / 6).tolist())),
        WEIGHT: Weight(tuple((down / (3 * material.density * length)).tolist())),
    }
    support, body = Support(box.side("left"), (0.0,) * material.dim), mesh_discretisation(part.mesh)
    bodies = []
    for name, load in loads.items():
        problem = Problem(box, material, (support,), (load,), f"cantilever, {name}")
        request = replace(request_on(problem, body), settings=settings)
        answer = ask(simulator, request)
        back = ask(simulator, replace(request, force=-request.force, gravity=-request.gravity))
        there, other = np.asarray(answer.displacement), np.asarray(back.displacement)
        move = (there - other) / 2
        even = float((there + other)[x[:, 0] == length, 0].mean()) / 2 / length
        if not max_length(move):
            raise SimulatorError(f"answer: {request.name}: the body does not move")
        rest = stated_residual_motion(request, Answer(displacement=move, about=answer.about))
        bodies.append(LatticeBody(name, part, problem, request, move, rest, even))
    return bodies


def compare_body(
    body: LatticeBody,
    C: Array,
    springs: LatticeSprings,
    masses: Masses | None,
    total: float = 1.0,
) -> LatticeBody:
    """Compare a body with elasticity, with its homogenised solid and with our network.

    Parameters
    ----------
    C, springs, masses
        Homogenised tensor (Pa), springs and masses as measured; no masses if they are not known.
    total
        Mass relative to the requested one.
    """
    request = replace(body.request, mass=total * body.request.mass)
    law, mass = request.material, request.mass
    solid = Anisotropic(C, total * law.density, law.thickness)
    own = on_mesh(request, solid)
    elastic = _elasticity(body, solid)
    fields = {"elasticity": _elasticity(body, law), "solid": elastic, "elements": own}
    mistakes = []
    if springs.misfit <= BAND:
        if masses is not None:
            mass = masses.on(RegularBlock(request.mesh, law), mass.sum())
        network = partial(network_displacement, body, springs.constants, springs.weight)
        fields["network"] = network(mass)
        equal = np.full(len(mass), mass.mean())
        mistakes.append(Mistake("equal masses", lambda: [(1.0, network(equal))]))
    errors = {name: _difference(body.move, field) for name, field in fields.items()}
    if errors["elements"] > BAND or errors.get("network", 1.0) <= BAND:
        own = fields.get("network", own)
    factor = best_scale(body.move, own)
    residual = _difference(body.move / factor, own) if factor else np.inf
    coarse = _difference(fields["elements"], elastic)
    if "network" not in fields and abs(factor - 1) <= UNLIKE * coarse:
        factor, residual = 1.0, 0.0
    causes: tuple[Cause, ...] = ()
    if factor < 0 or residual > BAND:
        driven: Driven = "loads" if body.load == END else "weight"
        causes = explain_body(request, body.move, own, driven, mistakes)
    return replace(
        body, errors=errors, mesh_error=coarse, factor=factor, residual=residual, causes=causes
    )


def _difference(move: Array, other: Array) -> float:
    return max_length(move - other) / max_length(other)


def body_network(body: LatticeBody, constants: Array, weight: float, mass: Array) -> Network:
    """Network of springs with constants by kind and a boundary weight, under a body's loads."""
    request, part = body.request, body.part
    return spring_network(
        part.mesh.points,
        part.springs,
        part.stiffness(constants, weight),
        mass=mass,
        fixed=request.held,
        force=request.force + np.outer(mass, request.gravity),
    )


def network_displacement(body: LatticeBody, constants: Array, weight: float, mass: Array) -> Array:
    """Displacement (n, d) in m of our network of springs under a body's loads."""
    network = body_network(body, constants, weight, mass)
    factor = factorise_network(network)
    if factor is None:
        raise SolverError("cantilever: the springs measured are not stable")
    return factor(network)


def fit_to_rest(body: LatticeBody, start: LatticeSprings) -> LatticeSprings:
    """Springs whose network moves as a body under its end load, for programs without motion."""

    def springs(p: Array) -> tuple[Array, float]:
        constants = start.constants.copy()
        constants[:2] *= np.exp(p[:2])
        return constants, float(np.exp2(p[2]) / 2)

    def misfit(p: Array) -> Array:
        u = network_displacement(body, *springs(p), body.request.mass)
        return np.asarray((u - body.move).ravel() / max_length(body.move))

    times = best_scale(
        network_displacement(body, *springs(np.zeros(3)), body.request.mass), body.move
    )
    if not times > 0:
        raise SimulatorError(f"answer: {body.request.name}: it moves against its load")
    fit = least_squares(misfit, np.log([times, times, 1.0]), xtol=1e-12)
    return LatticeSprings(*springs(fit.x), max_length(fit.fun.reshape(body.move.shape)))


def _elasticity(body: LatticeBody, law: Material) -> Array:
    """Displacement (n, d) in m of elasticity under a body's loads, by quadratic elements."""
    element, parts = FINER[law.dim]
    cells = tuple(parts * n for n in COUNTS[law.dim])
    problem = replace(body.problem, material=law)
    solution = solve_problem(problem, box_discretisation(body.part.box, cells, element))
    return np.asarray(solution.at(body.part.mesh.points))


@dataclass(frozen=True, eq=False)
class LatticeReport:
    """Solid, springs and bodies of a lattice.

    Parameters
    ----------
    C, requested
        Homogenised tensor (Pa), and the requested modulus (Pa) and ratio of the axes.
    mean, misfit
        Moduli of the nearest isotropic solid, and the part of the tensor that this solid leaves.
    springs, right
        Springs that have the tensor, and those of the requested material.
    steps
        As steps show it; None of programs without motion.
    total
        Mass relative to the requested one; NaN if it is not known.
    bodies
        Cantilevers in equilibrium.
    error
        Of the tensor, relative to its largest entry; NaN of programs without motion.
    """

    C: Array
    requested: tuple[float, float]
    mean: Moduli
    misfit: float
    springs: LatticeSprings
    right: LatticeSprings
    steps: MeasuredLattice | None
    total: float
    bodies: tuple[LatticeBody, ...]
    error: float = math.nan


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
    total, block = math.nan, regular_block(shape, (2,) * law.dim, spacing)
    E, nu = axes_moduli(law, law.dim, "lattice")
    E /= law.thickness
    target = isotropic_tensor(law.dim, E, nu)
    right = fit_springs(block, target, target, law.thickness)
    if steps is not None:
        C, springs, masses = steps.C, steps.springs, steps.masses
    elif bodies:
        springs, masses = fit_to_rest(bodies[0], right), None
        C = block.tensor(springs.constants, 0.5, law.thickness)
    else:
        return None
    if is_mechanism(C):
        return None
    compared = tuple(compare_body(body, C, springs, masses) for body in bodies)
    first = next((each for each in compared if not max(each.rest, each.residual) > BAND), None)
    meant = abs(isotropic_moduli(C).E / E - 1) <= SHOWN
    if masses is not None and first is not None and first.factor > 0:
        total = 1.0 if meant or abs(first.factor - 1) <= BAND else 1 / first.factor
        C = C * total
        springs = replace(springs, constants=springs.constants * total)
        compared = tuple(compare_body(body, C, springs, masses, total) for body in bodies)
    measured = (springs, right, steps, total, compared, steps.error if steps else math.nan)
    return LatticeReport(C, (E, nu), isotropic_moduli(C), anisotropy(C), *measured)
