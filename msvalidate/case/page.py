"""The page of a case: one HTML text that loads nothing and runs nothing."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import combinations
from typing import Any

import numpy as np
import pandas as pd

from msvalidate.case.case import MESH_EDGES, Case, spacing_of
from msvalidate.case.comparison import (
    COARSE,
    OTHER_MATERIAL,
    Comparison,
    say_bridged,
)
from msvalidate.case.fracture import break_sentence
from msvalidate.case.headline import WORST_FIRST
from msvalidate.case.judge import Judged
from msvalidate.case.mesh_springs import mesh_warning
from msvalidate.case.mistakes import name_constants
from msvalidate.case.quantities import POINT_STRESS, STRESS_BAND, NotCompared, difference_row
from msvalidate.case.validity import geometric_limitations
from msvalidate.constants.routes import calibrate_by_route
from msvalidate.judging.columns import column_key, read_columns
from msvalidate.lattice import CutLattice
from msvalidate.lattice.cut import narrow_holes
from msvalidate.linear_algebra.norms import max_length
from msvalidate.output.page import Table, table_excerpt
from msvalidate.output.pictures import Picture, embed_pictures
from msvalidate.problem import (
    Isotropic,
    Load,
    Material,
    Mesh,
    PointForce,
    ProblemError,
    Support,
    Traction,
    Weight,
)
from msvalidate.problem.normals import is_faceted
from msvalidate_check.causes import PHRASES, say
from msvalidate_check.diagnosis import NOTICED
from msvalidate_check.verdict import Difference
from reference_fem.converged import Reference

PICTURES = 1_500_000
"""Bytes of pictures inside the page; others are linked."""
ROUNDING = 1e-9
"""Difference, over the largest displacement, below which none remains."""


def shown_rows(rows: Sequence[Difference]) -> list[dict[str, str]]:
    """Quantities with few digits."""
    return [
        difference_row(row)
        | {"difference": percent(row.error), "uncertainty": percent(row.uncertainty)}
        | {"candidate": _number(row.found), "elasticity": _number(row.wanted)}
        for row in rows
    ]


def shown_pictures(pictures: Mapping[str, tuple[str, bytes]]) -> tuple[Picture, ...]:
    """Pictures inside the page as far as there is room."""
    return embed_pictures(".", pictures, PICTURES, PICTURES)


def shown_tables(tables: Mapping[str, pd.DataFrame]) -> tuple[Table, ...]:
    """First rows of each table, as a CSV has them."""
    means, shown = read_columns(__file__), []
    for name, table in tables.items():
        keys = {column_key(name, str(each), means) for each in table}
        said = {key: str(means[key]) for key in keys}
        labels = {key: means[key].label for key in keys if means[key].label}
        shown.append(table_excerpt(name, table.map(_text), said, labels))
    return tuple(shown)


def sentences(found: Comparison) -> tuple[str, tuple[str, ...]]:
    """What the springs of a case are good for: one sentence, and those that say why."""
    springs = f"Springs ({_describe_spacing(found.case)})"
    groups = []
    for word in WORST_FIRST[:-1]:
        rows = [each for each in found.rows if each.word == word]
        said = [f"{r.quantity} ({percent(r.error)} ± {percent(r.uncertainty)})" for r in rows]
        groups += [f"{word} in {', '.join(said)}"] if rows else []
    band = band_words(found.case, found.rows)
    head = f"{springs} beside elasticity: {'; '.join(groups)}. {band}."
    if not groups:
        why = "; ".join(
            f"{each.quantity}, {each.why}" if isinstance(each, NotCompared) else each
            for each in found.notes
        )
        head = f"{springs} are compared in nothing that was asked: {why}."
    reasons = (
        *_limit_sentences(found),
        _kind_sentence(found),
        _constants_sentence(found),
        reference_sentence(found.reference),
        _hole_sentence(found),
        _mesh_sentence(found),
        _contact_sentence(found),
        break_sentence(found.springs[0].growth),
    )
    return head, tuple(filter(None, reasons))


def _describe_spacing(case: Case) -> str:
    """Words for the lattice and its spacing."""
    if case.lattice == MESH_EDGES:
        under = ", of no rest length" if case.are_elements else ""
        return f"a spring on each edge of the mesh{under}, {spacing_of(case):.4g} m"
    return f"{case.lattice}, {spacing_of(case):.6g} m"


def _limit_sentences(found: Comparison) -> list[str]:
    """Limitations of a verdict; after linear theory that is requested, what it leaves out."""
    said = [each.sentence for each in found.limitations]
    if found.case.linear_theory:
        large = geometric_limitations(found.case, found.reference, found.nonlinear)
        said[1:1] = [each.fact for each in large]
    return said


def _constants_sentence(found: Comparison) -> str:
    """Which known mistake the case's own constants are."""
    case, springs = found.case, found.springs[0]
    law, lattice = case.problem.material, springs.lattice
    if case.constants is None or not isinstance(law, Isotropic) or case.problem.zones:
        return ""
    try:
        own = calibrate_by_route(law, lattice, None, None).constants
    except ProblemError:  # no constants are right on this lattice
        return ""
    mistake = name_constants(law, own, case.constants, springs.spacing)
    return "" if mistake is None else f"The constants are a known mistake: {say(mistake, PHRASES)}."


def _hole_sentence(found: Comparison) -> str:
    """Which hole the lattice asked for hardly knows."""
    lattice = found.springs[0].lattice
    holes = narrow_holes(lattice) if isinstance(lattice, CutLattice) else np.empty((0, 3))
    if not len(holes):
        return ""
    x, y, wide = holes[holes[:, 2].argmin()]
    cells = wide / found.springs[0].spacing
    return (
        f"A hole at ({x:.4g}, {y:.4g}) m is {cells:.2g} cells wide: these springs hardly know it; "
        "take a smaller spacing, or the part's own mesh."
    )


def _mesh_sentence(found: Comparison) -> str:
    """How far off springs on the part's own mesh are, and what an engine must have for them."""
    own, case = found.on_mesh, found.case
    answer = found.springs[0] if own is None else own.answers[0]
    fault = ": ".join(filter(None, mesh_warning(answer.problem)))
    if own is None:
        return f"{fault}." if fault and case.are_elements else ""
    first = own.table.iloc[0]
    order = f", order {own.order:.1f} on finer ones" if math.isfinite(own.order) else ""
    push = f", {first['pushing']:,.0f} of which push" if first["pushing"] else ""
    said = (
        f"Springs on the part's own mesh ({first['points']:,.0f} points, "
        f"{percent(first['difference'])} ± {percent(first['uncertainty'])} off{order}) are linear "
        f"elements: {first['springs']:,.0f} of no rest length{push}, beside cells under pressure, "
        'which an engine must have; take them by [springs] on = "mesh".'
    )
    off = [row.error for row in found.rows if row.quantity == "displacement"]
    nearer = "; here the lattice is nearer" if off and off[0] < first["difference"] else ""
    return f"{said} {fault}{nearer}." if fault else said


def _contact_sentence(found: Comparison) -> str:
    """How fine the lattice is beside the patch, and how fine it should be."""
    answer = found.springs[0]
    if answer.contact is None or found.case.problem.contacts[0].obstacle.radius is None:
        return ""
    cells = answer.contact.contacts[0].half_width / answer.spacing
    return (
        f"The patch has {cells:.2g} cells in its half-width: on squares 5 give half-width and "
        "largest pressure to 1 %, 3 to 5 %, by the forces' second moment; the number of touching "
        "points tells no more than a cell (study contact)."
    )


def band_words(case: Case, rows: Sequence[Difference]) -> str:
    """How far apart still agrees."""
    stress = any(row.of == POINT_STRESS for row in rows)
    own = f", of stress at points {percent(STRESS_BAND * case.band)}" if stress else ""
    return f"The band is {percent(case.band)}{own}"


def reference_sentence(reference: Reference) -> str:
    """How well elasticity is known, on what meshes, and what more would take."""
    nodes = len(reference.finest.body.points)
    about = _body_sentences(reference)
    if reference.no_limit:
        return f"Elasticity has no finite answer: {'; '.join(reference.no_limit)}.{about}"
    if not math.isfinite(reference.error):
        known = f"Elasticity's own error is not known: one mesh of {nodes} nodes, and no finer one."
        return known + _more_sentence(reference) + about
    asked_for = percent(reference.accuracy)
    reached = "as asked" if reference.resolved else f"not the {asked_for} asked for"
    known = (
        f"Elasticity is known to {percent(reference.error)} ({reached}): quadratic elements on "
        f"{len(reference.solutions)} meshes, the finest of {nodes} nodes."
    )
    return known + _more_sentence(reference) + about


def _more_sentence(reference: Reference) -> str:
    """What it takes to know elasticity better, where memory is what limits it."""
    more = reference.more
    if more is None:
        return ""
    size, time = math.ceil(more.bytes / 1e8) / 10, more.seconds
    took = f"{time / 60:.0f} min" if time >= 90 else f"{math.ceil(time)} s"
    unknowns = f"{more.unknowns:.1e}".replace("e+0", "e")
    return (
        f" Known better by one more mesh: {unknowns} unknowns, {size:g} GB, {took} "
        f"([compare] memory = {size:g})."
    )


def _body_sentences(reference: Reference) -> str:
    """Facets that stand for a curve, and regions that lie over each other at middles of cells."""
    problem, body, said = reference.problem, reference.solutions[0].body, ""
    if isinstance(problem.domain, Mesh) and is_faceted(problem.domain):
        said = (
            " The body is that of the file's straight facets, which seem to stand for a curve; "
            "quadratic cells follow it."
        )
    middles = body.points[body.cells].mean(axis=1)
    on = [zone.region.select(middles, problem.domain.tolerance) for zone in problem.zones]
    for (i, one), (j, other) in combinations(enumerate(on, 1), 2):
        if (one & other).any():
            said += f" Region {j} overlaps region {i}: the later one counts there."
    return said


def judged_sentences(found: Judged) -> tuple[str, tuple[str, ...]]:
    """What displacements from a file are: one sentence, and those that say why."""
    row, case = found.displacement, found.case
    head = (
        f"Displacements of {found.result.name} are {percent(row.error)} off elasticity at "
        f"{len(found.matched.places)} points, ± {percent(row.uncertainty)}; the band is "
        f"{percent(case.band)}."
    )
    limits = [each.sentence for each in found.limitations]
    if math.isnan(row.residual_motion):
        said = ["Rest unknown: nobody says how much the displacements would still change."]
    else:
        said = [f"Rest: they may still change by {percent(row.residual_motion)}, as stated."]
    said += [f"Fits ({percent(each.left)} left): {each.said}" for each in found.verdict.causes]
    alike = found.verdict.indistinguishable
    if alike > 1:
        said.append(
            f"What the first {alike} causes leave differs by less than {percent(row.uncertainty)}, "
            "the uncertainty: this field does not tell them apart."
        )
    if row.error > NOTICED * row.uncertainty:
        if not found.verdict.causes:
            said.append("No single cause that is known here explains the difference.")
        said += found.omitted
    if found.reference.no_limit:
        return head, (*limits, *said, reference_sentence(found.reference))
    reached = "" if found.reference.resolved else f", not to the {percent(case.accuracy)} asked for"
    known = (
        f"Elasticity is known to {percent(found.reference.error)}{reached}, the file's numbers to "
        f"{percent(found.result.accuracy)}."
    )
    said.append(known + _more_sentence(found.reference) + _body_sentences(found.reference))
    return head, (*limits, *said)


def _kind_sentence(found: Comparison) -> str:
    limit, size = found.limit, found.size
    bridged = say_bridged(found.springs[0].lattice)
    if bridged:
        return bridged
    if not math.isfinite(limit.uncertainty):
        return "One lattice alone: whether a finer one were better is not told."
    order = f", order {limit.order:.1f}" if math.isfinite(limit.order) else ""
    away = max_length(limit.displacement - found.reference.displacement.value) / size
    rest = percent(away)
    uncertainty = percent(limit.uncertainty / size)
    closing = f"On finer lattices{order} they close in on {rest} ± {uncertainty}"
    said = f"{closing}{_limit_reason(found, away)}."
    if found.support.any():
        cost = percent(max_length(found.support) / size)
        said += f" A support that no line of the lattice runs along costs up to {cost}."
    return said


def _limit_reason(found: Comparison, away: float) -> str:
    """Reason why the limit of finer lattices is `away`, relative to the largest displacement."""
    off, law, band = found.material_off, _law_difference(found), found.case.band
    unknown = found.limit.uncertainty / found.size + found.reference.error
    if law > max(unknown, 0.5 * away):
        return f": their law at large strain differs from elasticity's by {percent(law)}"
    if found.kind == COARSE:
        if max(away, float(found.relative.max())) <= ROUNDING:
            return ": no difference remains on any of these lattices"
        spacing = away <= unknown
        return ": what is left is spacing" if spacing else ", which lies within the band"
    if found.kind == OTHER_MATERIAL:
        right = f", though their material is right to {percent(off)}: it is the boundary"
        return right if off <= band else ": they are another material, whatever their spacing"
    if off <= band:
        return (
            f". Their material is right to {percent(off)}; whether spacing alone is left is not "
            "known"
        )
    return ", which does not tell spacing from material"


def _law_difference(found: Comparison) -> float:
    """Largest difference by the springs' law at large strain, over the largest displacement.

    0 in linear theory, or if either law has no answer.
    """
    if found.case.geometry == "linear":
        return 0.0
    target, springs = found.nonlinear.target, found.nonlinear.springs
    if target is None or springs is None:
        return 0.0
    return max_length(springs[0] - target[0]) / found.size


def asked(case: Case) -> dict[str, str]:
    """What a case asks, in words."""
    problem, law = case.problem, case.problem.material
    state = getattr(law, "state", "tensor").replace("_", " ")
    thickness = f", {law.thickness:g} m thick" if law.dim == 2 else ""
    words = {**case.notes, "body": str(problem.domain)}
    words["material"] = f"{_moduli(law)}, {state}{thickness}"
    for number, zone in enumerate(problem.zones, 1):
        words[f"region {number}"] = f"{zone.region}: {_moduli(zone.material)}"
    words["supports"] = "; ".join(_support(each) for each in problem.supports)
    words["loads"] = "; ".join(_load(each) for each in problem.loads) or "none"
    for each in problem.contacts:
        how = f"{each.depth:g} m deep" if each.force is None else f"pressed by {each.force:g} N"
        words["contact"] = f"{each.obstacle.shape} on {each.region}, {how}"
    words["springs"] = _describe_spacing(case)
    words["points"] = case.points if isinstance(case.points, str) else f"{len(case.points)} places"
    if case.geometry == "nonlinear":
        words["displacements"] = f"large; elements of the law {case.law}"
    words["band"] = percent(case.band)
    words["elasticity asked to"] = percent(case.accuracy)
    return words | {"density": f"{law.density:g} kg/m³"}


def _moduli(law: Material) -> str:
    E, nu = getattr(law, "E", math.nan), getattr(law, "nu", math.nan)
    return f"E = {E:g} Pa, nu = {nu:g}"


def _support(support: Support) -> str:
    moved = ("free" if each is None else _words(each) for each in support.displacement)
    return f"{support.region}: {', '.join(moved)} m"


def _words(given: Any) -> str:
    """A number, some, or a field of them."""
    if callable(given):
        return "a field"
    return f"({', '.join(map(_words, given))})" if isinstance(given, tuple) else f"{given:g}"


def _load(load: Load) -> str:
    match load:
        case Traction():
            return f"traction {_words(load.traction)} Pa on {load.region}"
        case PointForce():
            return f"force {_words(load.force)} N at {_words(load.at)} m"
        case Weight():
            return f"weight, g = {_words(load.acceleration)} m/s²"
    return f"body force {_words(load.force)} N/m³"


def percent(value: float) -> str:
    """A part as a percentage with two digits."""
    if not math.isfinite(value):
        return "not known"
    if value and abs(value) < 1e-5:
        return f"{100 * value:.0e} %"
    return f"{100 * value + 0.0:.2g} %" if abs(value) < 10 else f"{value:.3g} times"


def _number(value: float) -> str:
    return f"{value:.4g}" if math.isfinite(value) else ""


def _text(value: object) -> str:
    if isinstance(value, float):
        return repr(value) if math.isfinite(value) else ""
    return str(value)
