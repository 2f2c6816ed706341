"""Bodies of the frozen set that a simulator brings to rest, and what each owes to which cause."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from msvalidate.case.judge.mistakes import mistakes_on_mesh
from msvalidate.linear_algebra.norms import max_length
from msvalidate.problem import Array, Isotropic, SolverError
from msvalidate.problem.records import dataclass, replace
from msvalidate.simulators.bodies import blocks
from msvalidate.simulators.bodies.blocks import (
    AtRest,
    Effective,
    Elements,
    at_rest_both_ways,
    elasticity_at,
)
from msvalidate.simulators.exchange.asked import Note, note_of
from msvalidate.simulators.exchange.protocol import (
    Answer,
    CannotRepresent,
    Request,
    Simulator,
    stated_residual_motion,
)
from msvalidate.simulators.probe.block import Block
from msvalidate.simulators.probe.reading import BAND, Reading
from msvalidate_check.beside import Driven, Field, Mistake, best_scale
from msvalidate_check.causes import Cause
from msvalidate_check.diagnosis import explain


@dataclass(frozen=True)
class Factors:
    """Factors of the displacement by cause; 1 for a cause without effect.

    The causes come apart by construction. Each displacement differs from the one before it by one
    cause alone: elasticity as asked; elasticity of what the law is to first order; linear elements
    of that law on the program's own mesh; the same with the masses that were measured; the program
    as far as it can be brought to rest; the program as it was run. A factor is the quotient of two
    sizes that follow one another, so all of them multiply to the whole.

    Parameters
    ----------
    total
        Size of the answer over that of elasticity as asked.
    law, resolution, mass, solver
        Of each cause.
    left
        What the causes do not explain: the program brought to rest over the elements that should be
        alike.
    apart
        Largest difference of these two over the largest displacement, of whatever shape.
    """

    total: float
    law: float
    resolution: float
    mass: float
    solver: float
    left: float
    apart: float

    @property
    def is_explained(self) -> bool:
        """Return True if the misfit in size and shape is small."""
        return self.apart <= BAND


def factors(
    found: AtRest,
    law: tuple[float, float],
    mass: Array | None = None,
    settled: AtRest | None = None,
) -> Factors:
    """Take the causes of an answer apart.

    Parameters
    ----------
    found
        The answer as the program was run.
    law
        Modulus (Pa) and ratio of its law to first order, as probed, or as its documents say.
    mass
        (n,) kg as measured; None where they are those asked.
    settled
        The answer with steps and iterations at which nothing changes any more; None where it is
        the same.

    Raises
    ------
    ProblemError
        If the set does not reach to the ratio asked for.
    """
    case, asked = found.case, found.request.material
    named = case.named
    wanted = elasticity_at(case, 1.0, asked.nu)
    on_mesh = found.of_elements(*law)
    own_law = _elasticity_of(found, law, on_mesh)
    weighed = on_mesh if mass is None else found.of_elements(*law, mass)
    rest = found if settled is None else settled

    moves = (wanted, own_law, *(u[named] for u in (on_mesh, weighed, rest.move, found.move)))
    sizes = [best_scale(move, wanted) for move in moves]
    steps = [after / before if before else np.inf for before, after in pairwise(sizes)]
    apart = max_length(rest.move - weighed) / max_length(weighed)
    return Factors(sizes[-1], steps[0], steps[1], steps[2], steps[4], steps[3], apart)


def _elasticity_of(found: AtRest, law: tuple[float, float], on_mesh: Array) -> Array:
    """(p, 3) m of elasticity of a law.

    Below the ratios of the set what it is to the nearest of them, elements are on the same mesh;
    above them it is that of the nearest, as elements lock there. What that is off by goes from
    "law" to "resolution", and nothing of it into what is left.
    """
    case, asked = found.case, found.request.material
    E, nu = law
    near = float(np.clip(nu, *case.ratios))
    known = elasticity_at(case, E / asked.E, near)
    if near <= nu:
        return known
    return np.asarray(known + (on_mesh - found.of_elements(E, near))[case.named])


MESHES = ("tet4", "tet4_2")
BODIES: Mapping[str, tuple[str, ...]] = {
    "pulled": ("block_pull_space", "clamped_pull_space", "block_gravity_space"),
    "sheared": ("block_shear_space", "clamped_shear_space"),
    "bent": ("cantilever_gravity_space",),
}
"""Cases of the frozen set for each kind of body.

The first case that a program can represent counts.

Clamped ones are for programs that hold nodes whole. The bent one shows "resolution": linear
elements are far off there on any mesh one pays for.
"""
SHORT = 3.0
"""Factor on the stated residual motion, for further changes of a body.

Most statements are estimates.
"""
EVEN = 0.1
"""Largest fraction of the displacement that is even in the loads.

It is of second order for turns of 0.02 and strains of 0.01, with a factor of three.
"""
AWAY = 4.0
"""m, to where floats are spaced eight times as widely and more."""
MORE, SHRINKS = 8.0, 2.0
"""Factor of larger loads, and uncertainty of the rounding error.

Rounding is then an eighth of its part; it is known to a factor of two.
"""
LOADED = ("pulled", "sheared")
"""Bodies that strain so little that eight times the loads leave their second order small."""


@dataclass(frozen=True, eq=False)
class BodyRow:
    """Result for one body on one mesh.

    Parameters
    ----------
    body, case, mesh
        What was asked.
    error
        Largest difference from elasticity as asked, over the largest displacement.
    on_mesh
        The material that it is the elements of, on its own mesh.
    rest
        Part of the displacement that may still change, as stated; NaN if nobody says.
    factors
        Causes, multiplied; None where the law is not known.
    shapes
        Rivals that would explain what is left: known mistakes, a scale, points swapped, axes,
        signs. Without a law they explain the difference from elements as asked.
    even
        Half the sum of what it moves by loads and by their opposites, over the displacement.
    finer
        Whether it is nearer to elasticity of the law than half of what linear elements on its mesh
        are: elements of another kind.
    loaded_more
        What is left under `MORE` times the loads, over the largest displacement then; NaN where
        that was not asked.
    far_away
        The same, moved by `AWAY`, where positions in floats are coarser.
    driven
        Cause of the motion, as of the frozen case: "loads", "weight" or "supports".
    move
        (n, 3) m of the nodes, for figures.
    """

    body: str
    case: str
    mesh: str
    error: float
    on_mesh: Effective
    rest: float
    factors: Factors | None
    shapes: tuple[Cause, ...] = ()
    even: float = 0.0
    finer: bool = False
    loaded_more: float = math.nan
    far_away: float = math.nan
    driven: str = ""
    move: Array | None = None

    @property
    def is_explained(self) -> bool:
        """Return True if causes or better elements explain the displacement.

        Its part that is even in the loads must be small as well.
        """
        causes = self.factors is not None and (self.factors.is_explained or self.finer)
        return causes and self.even <= EVEN

    @property
    def may_settle(self) -> bool:
        """Return True if the stated residual motion may explain the misfit."""
        left = math.inf if self.factors is None else self.factors.apart
        return bool(left <= SHORT * self.rest) and self.rest > BAND and self.even <= EVEN

    @property
    def is_rounded(self) -> bool:
        """Return True if the misfit is rounding of positions.

        Rounding has a fixed size, whatever the loads.

        An error of law, masses or mesh stays the same part of what moves, and one of any other kind
        does not grow where positions are coarser.
        """
        if self.factors is None or not math.isfinite(self.far_away):
            return False
        shrinks = self.loaded_more <= min(BAND, self.factors.apart * SHRINKS / MORE)
        return shrinks and self.far_away >= SHRINKS * self.loaded_more and self.even <= EVEN


def bring_to_rest(
    simulator: Simulator,
    material: Isotropic,
    settings: Mapping[str, Any],
    meshes: tuple[str, ...],
    notes: list[Note],
    elements: Elements,
) -> list[tuple[str, AtRest]]:
    """Each body at rest, by the first of its cases that the program can represent."""
    found: list[tuple[str, AtRest]] = []
    for body, cases in BODIES.items():
        for case in cases:
            try:
                each = [
                    at_rest_both_ways(simulator, case, mesh, material, settings, elements=elements)
                    for mesh in meshes
                ]
            except (CannotRepresent, SolverError) as error:
                notes.append(note_of(case, error))
                continue
            found += [(body, one) for one in each]
            break
    return found


def bring_further(
    simulator: Simulator,
    settings: Mapping[str, Any],
    converged: Mapping[str, Any] | None,
    found: list[tuple[str, AtRest]],
) -> Mapping[tuple[str, str], AtRest]:
    """The same bodies with settings that change nothing any more."""
    if not converged:
        return {}
    return {
        (each.case.name, each.case.mesh): at_rest_both_ways(
            simulator,
            each.case.name,
            each.case.mesh,
            each.request.material,
            {**settings, **converged},
        )
        for _, each in found
    }


def masses_on(request: Request, reading: Reading | None, total: float) -> Array | None:
    """(n,) kg on a request's mesh by the pattern that the probe measured; None if as asked."""
    masses = reading.masses if reading else None
    if masses is None or not masses.pattern or len(masses.exceptions):
        return None if total == 1 else request.mass * total
    return masses.on(Block(request.mesh, request.material), total * request.mass.sum())


def body_row(
    body: str,
    found: AtRest,
    law: tuple[float, float] | None,
    reading: Reading | None,
    total: float,
    settled: Mapping[tuple[str, str], AtRest],
) -> BodyRow:
    """A body, its difference from elasticity and the causes of it."""
    case, request = found.case, found.request
    wanted = blocks.elasticity_at(case, 1.0, request.material.nu)
    error = max_length(found.move[case.named] - wanted) / max_length(wanted)
    rest = stated_residual_motion(request, Answer(displacement=found.move, about=found.about))
    on_mesh = blocks.effective_on_mesh(found)
    row = BodyRow(
        body,
        case.name,
        case.mesh,
        error,
        on_mesh,
        rest,
        None,
        even=found.even,
        driven=case.driven,
        move=found.move,
    )
    if law is None:
        asked = request.material.E, request.material.nu
        return replace(row, shapes=_shapes(found, asked, request.mass))
    mass = masses_of(found, law, reading, total)
    row = replace(row, factors=factors(found, law, mass, settled.get((case.name, case.mesh))))
    if row.is_explained:
        return row
    expected = found.of_elements(*law, mass)
    row = replace(row, shapes=_shapes(found, law, mass))
    is_scaled = any(each.left <= BAND / 10 for each in row.shapes)
    return replace(row, finer=not is_scaled and _is_finer(found, law, expected))


def masses_of(
    found: AtRest, law: tuple[float, float], reading: Reading | None, total: float
) -> Array | None:
    """(n,) kg of a body, by the pattern that the probe measured; None if as asked.

    Where masses are not each node's share, how heavy a body is in all goes by how many nodes a mesh
    has: one under its weight then shows it by what it moves.
    """
    mass = masses_on(found.request, reading, total)
    other = reading is not None and reading.masses is not None and reading.masses.off > BAND
    if not other or found.case.driven != "weight":
        return mass
    given = found.request.mass if mass is None else mass
    expected = found.of_elements(*law, given)
    return np.asarray(given * best_scale(found.move, expected))


def _is_finer(found: AtRest, law: tuple[float, float], on_mesh: Array) -> bool:
    """Return True if a body is finer than linear elements.

    Its error relative to elasticity of the law is at most half of theirs.
    """
    named = found.case.named
    E, nu = law
    low, high = found.case.ratios
    if not low <= nu <= high:
        return False
    elastic = blocks.elasticity_at(found.case, E / found.request.material.E, nu)
    return max_length(found.move[named] - elastic) <= max_length(on_mesh[named] - elastic) / 2


def of_one_kind(rows: tuple[BodyRow, ...]) -> tuple[BodyRow, ...]:
    """The rows, none of other elements where one shows that they are linear ones, mesh and all."""
    linear = any(
        row.factors is not None
        and row.factors.is_explained
        and abs(row.factors.resolution - 1) > BAND
        for row in rows
    )
    return tuple(replace(row, finer=False) for row in rows) if linear else rows


def load_more(
    simulator: Simulator,
    row: BodyRow,
    found: AtRest,
    expected: Array,
    settings: Mapping[str, Any],
) -> BodyRow:
    """The row of a body, with what is left of it under more load where it is in single precision.

    Positions in single precision are steps of 6e-8 of a coordinate. A point stays where it is until
    a force moves it by half of that against its own cells; a whole body gives way to so small
    forces far more than a cell does. `expected` (n, 3) m are the elements that it should be.
    """
    single = found.about.get("precision") == "float32"
    if row.is_explained or not single or row.body not in LOADED:
        return row
    asked = (simulator, row.case, row.mesh, found.request.material, settings, MORE)
    try:
        near, far = at_rest_both_ways(*asked), at_rest_both_ways(*asked, away=AWAY)
    except (CannotRepresent, SolverError):
        return row
    each = [max_length(one.move - expected) / max_length(expected) for one in (near, far)]
    return replace(row, loaded_more=each[0], far_away=each[1])


def _shapes(found: AtRest, law: tuple[float, float], mass: Array | None) -> tuple[Cause, ...]:
    """Explain the difference of a field from its elements by known mistakes and other causes."""
    asked = found.request
    expected = found.of_elements(*law, mass)
    even = np.full(len(asked.mass), asked.mass.mean())
    equal = Mistake("equal masses", lambda: [(1.0, found.of_elements(*law, even))])
    mistakes = mistakes_on_mesh(
        asked.mesh, asked.material, expected, mass=asked.mass, gravity=asked.gravity,
        force=asked.force, fixed=asked.held, value=asked.value,
    )  # fmt: skip
    return explain_body(asked, found.move, expected, found.case.driven, (equal, *mistakes))


def explain_body(
    request: Request, move: Array, expected: Array, driven: Driven, mistakes: Sequence[Mistake]
) -> tuple[Cause, ...]:
    """Explain the difference of a body's displacement (n, d) in m from the expected one."""
    x = request.mesh.points
    span = tuple(zip(x.min(axis=0), x.max(axis=0), strict=True))
    return explain(Field(x, move, expected, BAND / 10, driven, span, mistakes=mistakes))
