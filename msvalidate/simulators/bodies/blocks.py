"""The second route: bodies of the frozen set at rest, and the material that they answer as.

The affine probe (`probe`) reads a law. What a user gets is an answer: it holds the mesh, the
masses, the supports and how far the simulation went, too. So bodies whose elasticity is known are
brought to rest under their loads and under the opposite loads; the odd half of the two has no
second-order part. Modulus and ratio are those of the linear elements on the same mesh that are
nearest to it (what a program of linear tetrahedra should be), and of elasticity.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from msvalidate.linear_algebra.norms import max_length
from msvalidate.problem import Array, Isotropic, Mesh, ProblemError
from msvalidate.problem.records import dataclass
from msvalidate.simulators.bodies.tetrahedra import linear_elements
from msvalidate.simulators.exchange.protocol import Request, Simulator, SimulatorError, ask
from msvalidate_check import ElasticCase, elastic_case
from msvalidate_check.case_set import case_facts
from msvalidate_check.material import fit_material

RATIOS = (0.0, 0.45)
"""For which elasticity of these bodies is known."""
ELEMENTS = (-0.95, 0.4999)
"""Ratios between which linear elements are asked."""


Elements = Callable[[Request, float, float, Array | None], Array]
"""Displacement (n, 3) m of a request's body by elements of E (Pa), nu, and masses (n,) kg."""


@dataclass(frozen=True)
class Effective:
    """The material that a displacement is nearest to.

    Parameters
    ----------
    E, nu
        Pa and 1. The ratio is NaN where it does not show, and the modulus then that of the ratio
        asked for.
    left
        Largest difference that is left, over the largest displacement.
    """

    E: float
    nu: float
    left: float


@dataclass(frozen=True, eq=False)
class AtRest:
    """Response of a simulator in equilibrium for one body on one mesh.

    Parameters
    ----------
    case
        Of the frozen set.
    request
        With the loads as they are.
    move
        (n, 3) m: half the difference of the answers to the loads and to their opposites.
    even
        Largest half sum of the two over the largest displacement: the second-order part.
    about
        What the simulator says of the first.
    elements
        What its program should be on this mesh.
    """

    case: ElasticCase
    request: Request
    move: Array
    even: float
    about: Mapping[str, Any]
    elements: Elements = linear_elements

    def of_elements(self, E: float, nu: float, mass: Array | None = None) -> Array:
        """(n, 3) m of its elements of a material (Pa, 1), with other masses (n,) kg."""
        return self.elements(self.request, E, nu, mass)


def request_of(
    case: ElasticCase,
    material: Isotropic,
    settings: Mapping[str, Any] | None = None,
    times: float = 1.0,
    away: float = 0.0,
) -> Request:
    """A frozen case as a request to come to rest, of another material, its loads multiplied.

    `away` (m) from its place along each axis.

    Forces go with the modulus, and gravity with the modulus over the density, so that every
    material of a ratio is strained alike.
    """
    weight = case.driven == "weight"
    none = np.zeros(case.points.shape)
    stiffer, heavier = material.E / case.E, material.density / case.density
    gravity = case.force.sum(axis=0) / case.mass.sum() if weight else np.zeros(3)
    shape = {"tet4": "tetra", "hex8": "hexahedron"}[case.mesh.partition("_")[0]]
    return Request(
        "rest",
        Mesh(case.points + away, case.cells, shape),
        material,
        mass=heavier * case.mass,
        gravity=times * stiffer / heavier * gravity,
        force=none if weight else times * stiffer * case.force,
        held=case.held.astype(bool),
        value=times * case.value,
        settings=settings or {},
        name=f"{case.name}, {case.mesh}",
    )


def at_rest_both_ways(
    simulator: Simulator,
    name: str,
    mesh: str,
    material: Isotropic,
    settings: Mapping[str, Any] | None = None,
    times: float = 1.0,
    away: float = 0.0,
    elements: Elements = linear_elements,
) -> AtRest:
    """A body of the set brought to rest under its loads and under their opposites.

    With `times` under so many times the loads, and what it moves is divided by that.

    Raises
    ------
    CannotRepresent, SimulatorError
        As the simulator says.
    """
    case = frozen_case(name, mesh, material.nu)
    there = request_of(case, material, settings)
    answer, other = (
        ask(simulator, request_of(case, material, settings, sign * times, away)) for sign in (1, -1)
    )
    one, two = np.asarray(answer.displacement), np.asarray(other.displacement)
    move, sum_of_both = (one - two) / 2 / times, (one + two) / 2 / times
    if not max_length(move):
        raise SimulatorError(f"answer: {case.name} does not move under its loads")
    even = max_length(sum_of_both) / max_length(move)
    return AtRest(case, there, move, even, answer.about, elements)


def frozen_case(name: str, mesh: str, nu: float) -> ElasticCase:
    """A frozen case on a mesh, at the ratio of the set that is nearest."""
    ratios = case_facts(name)["ratios"]
    return elastic_case(name, min(ratios, key=lambda each: abs(each - nu)), mesh=mesh)


def elasticity_at(case: ElasticCase, times: float, nu: float) -> Array:
    """(p, 3) m of elasticity at the named nodes of a case, for another material.

    `times` is its modulus over that which the loads are made for.

    Raises
    ------
    ProblemError
        If the set does not reach to this ratio.
    """
    low, high = case.ratios
    if not low <= nu <= high:
        raise ProblemError(f"ratio {nu:g}: the set knows {case.name} from {low:g} to {high:g}")
    return case.at_ratio(nu) / times


def effective_on_mesh(found: AtRest) -> Effective:
    """Modulus and ratio of the elements on the same mesh that are nearest to an answer."""
    E, nu = found.request.material.E, found.request.material.nu
    fit = fit_material(found.move, lambda ratio: found.of_elements(E, ratio), nu, ELEMENTS)
    left = max_length(found.move - fit.scale * fit.own) / max_length(found.move)
    modulus = E / fit.scale if fit.scale > 0 else np.nan
    return Effective(modulus, fit.nu if fit.shows else np.nan, left)
