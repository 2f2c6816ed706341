"""The reference of the study `lattices`: clamped elastic bodies by finite elements."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

import reference_fem
from msvalidate import kit
from msvalidate.bench.judging.singularity import clamped_free_exponent
from reference_fem.body import nodal_forces

from . import cases, loading
from .cases import Case, Solid

ELEMENT = {2: "Q2", 3: "H1"}
MESHES = {2: (8, 16, 32), 3: (6, 12, 24)}
QUICK_MESHES = {2: (4, 8, 16), 3: (3, 6, 12)}
"""Cells along each edge of the meshes, graded to the corners."""
GRADING = {2: 2.0, 3: 1.5}
SAME = 1e-9
"""Relative difference below which two bodies are one."""
TRUST = 0.5
"""Part of an extrapolation that may be wrong: orders of 1.3 or 2 instead of 1.6 change it by half
and a third of itself."""


class Reference(NamedTuple):
    """Work of the load on an elastic body, over that on a free bar, and its relative error."""

    work: float
    uncertainty: float


def bodies(solid: Solid, setting: kit.Setting) -> dict[Case, dict[str, Reference]]:
    """Every elastic body, in both tests; those of one tensor but for a factor are solved once."""
    meshes = QUICK_MESHES if setting.quick else MESHES
    number: dict[Case, int] = {}
    distinct: list[tuple[kit.Array, kit.Box, tuple[int, ...]]] = []
    for case in cases.stiff(solid):
        tensor = cases.tensor_of(solid, case)
        tensor = tensor / loading.modulus(tensor)
        box = cases.box_of(cases.fill_box(case, 2))
        same = [
            n
            for n, (other, its_box, _) in enumerate(distinct)
            if its_box == box and np.abs(other - tensor).max() <= SAME * np.abs(tensor).max()
        ]
        number[case] = same[0] if same else len(distinct)
        if not same:
            distinct.append((tensor, box, meshes[case.pattern.dim]))
    found = setting.sweep(solve_reference, distinct, "finite elements")
    return {case: found[n] for case, n in number.items()}


def solve_reference(body: tuple[kit.Array, kit.Box, tuple[int, ...]]) -> dict[str, Reference]:
    """Both tests of an elastic body of modulus 1, on three meshes, each twice as fine."""
    tensor, box, meshes = body
    works: dict[str, list[float]] = {test: [] for test in loading.TESTS}
    for cells in meshes:
        mesh = reference_fem.box_discretisation(box, cells, ELEMENT[box.dim], GRADING[box.dim])
        for test, found in works.items():
            problem = loading.clamped(box, kit.Anisotropic(tensor), test, 1.0)
            move = reference_fem.solve_problem(problem, mesh).displacement
            found.append(float((nodal_forces(problem, mesh) * move).sum() / box.volume))
    return {test: extrapolate(*found) for test, found in works.items()}


def extrapolate(coarse: float, medium: float, fine: float) -> Reference:
    """The limit that three meshes point to (Aitken), known to half of what that adds to the last.

    Changes that do not shrink are no sequence: then the last, known to three of them.
    """
    first, last = medium - coarse, fine - medium
    if not 0 < last * first < first**2:
        return Reference(fine, 3 * max(abs(first), abs(last)) / abs(fine))
    beyond = last**2 / (first - last)
    return Reference(fine + beyond, TRUST * abs(beyond) / abs(fine + beyond))


def corner_order(tensor: kit.Array, dim: int) -> float:
    """Twice the least exponent of the displacement where the clamped side meets a free one."""
    if dim == 2:
        return 2 * clamped_free_exponent(tensor, np.pi / 2)
    found = []
    for across in (1, 2):  # along an edge the body cannot stretch: the plane across it decides
        pairs = ((0, 0), (across, across), (0, across))
        plane = [kit.VOIGT[3].index(pair if pair in kit.VOIGT[3] else pair[::-1]) for pair in pairs]
        found.append(2 * clamped_free_exponent(tensor[np.ix_(plane, plane)], np.pi / 2))
    return min(found)
