"""The springs that a solved case has in hand: those of `advice`, read off its own network."""

from __future__ import annotations

import math
from contextlib import suppress
from typing import Any

import numpy as np

from msvalidate.case.advice import Advice, SpringKind, advice_lines, advice_of, springs_words
from msvalidate.case.case import MESH_EDGES, Case
from msvalidate.case.springs import SpringAnswer
from msvalidate.constants.calibration import Calibration
from msvalidate.constants.homogenise import homogenise
from msvalidate.constants.routes import calibration_of
from msvalidate.constants.zones import calibrate_zones
from msvalidate.dynamics.damping import Damping, quickest_damping
from msvalidate.dynamics.spectrum import highest_frequency
from msvalidate.problem import Isotropic, ProblemError, SolverError

FREQUENCY = 1e-4
"""Relative error of the highest frequency's square: a step has a tenth of its limit in hand."""
WHOSE = "this body"


def advise_body(case: Case, answer: SpringAnswer) -> tuple[Advice, ...]:
    """Springs of a case at rest, an entry a material: constants, masses, steps and damping.

    Steps and damping are those of the whole network; no damping where nothing moves it. No entry of
    a material that is given by its tensor.

    Raises
    ------
    SolverError
        If the highest frequency is not found.
    """
    network, problem = answer.network, case.problem
    law = problem.material
    if not isinstance(law, Isotropic):
        return ()
    omega = highest_frequency(network, tolerance=FREQUENCY)
    damping = None
    with suppress(ProblemError, SolverError):
        damping = quickest_damping(network)
    if case.lattice == MESH_EDGES:
        return (_edge_springs(case, answer, law, omega, damping),)
    found: tuple[Calibration, ...]
    if problem.zones:
        found = calibrate_zones(problem, answer.lattice, route=case.route)
    else:
        found = (answer.calibration or _given(case, answer, law),)
    rule = "cut" if hasattr(answer.lattice, "fraction") else "shared"
    return tuple(
        advice_of(law, str(case.lattice), each, omega, WHOSE, damping, rule)
        for law, each in zip(problem.materials, found, strict=True)
        if isinstance(law, Isotropic)
    )


def body_lines(each: tuple[Advice, ...]) -> tuple[str, ...]:
    """Springs in five lines, and one more for each further material."""
    if not each:
        return ()
    first, *others = each
    regions = (f"region {n}: {springs_words(one)}" for n, one in enumerate(others, 1))
    return (*advice_lines(first), *regions)


def _given(case: Case, answer: SpringAnswer, law: Isotropic) -> Calibration:
    """Constants of a case's own as what they make of the endless lattice."""
    lattice: Any = answer.lattice  # a pattern's: constants of mesh edges go another way
    constants = case.constants or ()
    tensor = homogenise(lattice.pattern, constants, lattice.spacing).tensor.copy()
    tensor[: case.problem.domain.dim, : case.problem.domain.dim] += case.volume
    given = (lattice.pattern, lattice.spacing, constants, case.volume)
    return calibration_of(law, *given, "constants of the case", tensor)


def _edge_springs(
    case: Case, answer: SpringAnswer, law: Isotropic, omega: float, damping: Damping | None
) -> Advice:
    """Springs along a mesh's edges: their constant, E·t or E, and the edge of median stiffness."""
    network = answer.network
    middle = int(np.argsort(network.stiffness)[len(network.stiffness) // 2])
    low, high = network.stiffness.min(), network.stiffness.max()
    kind = SpringKind(
        f"k, from {low:.6g} to {high:.6g} N/m, median",
        "the mesh's edges",
        float(network.stiffness[middle]),
        float(network.rest_length[middle]),
        "sum of E·V/L² over its cells, V their volume" if case.constants is None else "",
    )
    return Advice(
        material=law,
        lattice=MESH_EDGES,
        spacing=answer.spacing,
        route="the rule 'area'",
        kinds=(kind,),
        volume=0.0,
        volume_formula="",
        E=math.nan,
        nu=math.nan,
        zener=math.nan,
        mass=float(np.median(network.mass)),
        weights="edges",
        omega=omega,
        whose=WHOSE,
        damping=damping,
    )
