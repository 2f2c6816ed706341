"""The springs that a solved case has in hand: those of `advice`, read off its own network."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from msvalidate.case.advise.advice import (
    UNDER_PRESSURE,
    Advice,
    SpringKind,
    advice_lines,
    advice_of,
    lame_name,
    springs_words,
)
from msvalidate.case.advise.identify import with_cells
from msvalidate.case.file.case import MESH_EDGES, Case
from msvalidate.case.springs.lattice_springs import SpringAnswer
from msvalidate.problem import Isotropic, ProblemError, SolverError
from msvalidate.problem.records import replace
from msvalidate.springs.constants.calibration import Calibration
from msvalidate.springs.constants.homogenise import homogenise
from msvalidate.springs.constants.routes import calibration_of
from msvalidate.springs.constants.zones import calibrate_zones
from msvalidate.springs.dynamics.damping import quickest_damping
from msvalidate.springs.dynamics.spectrum import highest_frequency
from msvalidate.springs.lattice.edges import EdgeLattice

EDGE_FORMULAS = {
    "area": "sum of E·V/L² over its cells, V their volume",
    "cotangent": "sum of -μ∫∇φi·∇φj over its cells, φ of their corners",
}
"""Rule of `springs.lattice.EDGE_RULES` -> stiffness of a mesh's edge; V has the thickness in it."""
FREQUENCY = 1e-4
"""Relative error of the highest frequency's square: a step has a tenth of its limit in hand."""


def advise_body(case: Case, answer: SpringAnswer) -> tuple[Advice, ...]:
    """Springs of a case at rest, an entry a material: constants, masses, steps and damping.

    Steps and damping are those of the whole network; no damping where nothing moves it. No entry of
    a material that is given by its tensor. Raises `SolverError` if no highest frequency is found.
    """
    network, problem, lattice = answer.network, case.problem, answer.lattice
    law = problem.material
    if not isinstance(law, Isotropic):
        return ()
    omega, whose = highest_frequency(network, tolerance=FREQUENCY), "this body"
    damping, why = None, ""
    try:
        damping = quickest_damping(network)
    except (ProblemError, SolverError) as error:
        why = f"no damping: {error}"
    if isinstance(lattice, EdgeLattice):
        k, own = network.stiffness, case.constants is None
        middle = int(np.argsort(k, kind="stable")[len(k) // 2])
        edges = SpringKind(
            name=f"k, from {k.min():.6g} to {k.max():.6g} N/m, median",
            along="the mesh's edges, and diagonals of other cells than simplices",
            constant=float(k[middle]),
            length=float(network.rest_length[middle]),
            formula=EDGE_FORMULAS[lattice.rule] if own else "",
        )
        made = answer.calibration
        route = made.route if made else f"the rule {lattice.rule!r}"
        body = (law, MESH_EDGES, answer.spacing, route, (edges,), float(np.median(network.mass)))
        edge: dict[str, Any] = {"damping": damping, "undamped": why, "weights": lattice.boundary}
        source = "[vanGelder1998]" + ", cells [SimoPister1984]" * (made is not None)
        if made is not None and not problem.zones:
            lame = UNDER_PRESSURE[network.dim].format(λ=lame_name(law))
            cells = {"volume": made.volume, "volume_formula": lame, "pressure": made.pressure}
            edge |= {**cells, "E": made.E, "nu": made.nu, "zener": made.zener}
        return (Advice(*body, omega, whose, source, **edge),)
    found: tuple[Calibration, ...]
    if problem.zones:
        found = calibrate_zones(problem, lattice, route=case.route)
    else:
        found = (answer.calibration or _given(case, answer, law),)
    return tuple(
        replace(
            advice_of(law, str(case.lattice), each, omega, whose, damping, lattice.boundary),
            undamped=why,
        )
        for law, each in zip(problem.materials, found, strict=True)
        if isinstance(law, Isotropic)
    )


def _given(case: Case, answer: SpringAnswer, law: Isotropic) -> Calibration:
    """Constants of a case's own as what they make of the endless lattice."""
    lattice: Any = answer.lattice  # a pattern's: constants of mesh edges go another way
    given, route = (lattice.pattern, lattice.spacing, case.constants or ()), "constants of the case"
    solid = homogenise(lattice.pattern, given[2], lattice.spacing)
    try:
        tensor = with_cells(route, solid, case.volume).tensor
        return calibration_of(law, *given, case.volume, route, tensor)
    except ProblemError:  # cells beside points that move on, or some strain without energy
        spacing, k = given[1:]
        none, name = math.nan, lattice.pattern.name
        made = (none, none, none, route, solid.tensor * none, name, spacing, law.thickness)
        return Calibration(k, case.volume, *made)


def body_lines(each: tuple[Advice, ...]) -> tuple[str, ...]:
    """Springs in five lines, and one more for each further material."""
    if not each:
        return ()
    first, *others = each
    regions = (f"region {n}: {springs_words(one)}" for n, one in enumerate(others, 1))
    return (*advice_lines(first), *regions)
