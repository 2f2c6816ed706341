"""The page of a case: one HTML text that loads nothing and runs nothing."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import combinations
from typing import Any

import numpy as np
import pandas as pd

from msvalidate.bench.judging.columns import column_key, read_columns
from msvalidate.bench.output.excerpt import Table, table_excerpt
from msvalidate.bench.output.pictures import Picture, embed_pictures
from msvalidate.bench.output.screen import FirstScreen, Summary, agreement_badge
from msvalidate.case.compare.comparison import (
    COARSE,
    OTHER_MATERIAL,
    Comparison,
)
from msvalidate.case.compare.quantities import POINT_STRESS, STRESS_BAND
from msvalidate.case.compare.validity import geometric_limitations
from msvalidate.case.file.case import Case, spacing_of
from msvalidate.case.file.fracture import break_sentence
from msvalidate.case.file.places import mesh_names
from msvalidate.case.file.units import quantity_text, user_unit
from msvalidate.case.judge.judgement import Judged
from msvalidate.case.report.headline import DISPLACEMENT, LARGEST, part_text, springs_sentence
from msvalidate.case.springs.mesh_springs import mesh_warning
from msvalidate.linear_algebra.norms import max_length
from msvalidate.problem import (
    Mesh,
)
from msvalidate.problem.normals import is_faceted
from msvalidate.springs.lattice import CutLattice
from msvalidate.springs.lattice.cut import NARROW, narrow_holes
from msvalidate_check.diagnosis import NOTICED
from msvalidate_check.text import number_text, percent
from msvalidate_check.verdict import Difference
from reference_fem.converged import Reference
from reference_fem.first_mesh import MOST_MIXED

BASES = {
    "N": "; of reactions over the largest one",
    "Pa": "; of stress at points as root mean squares (rms) over these points",
}
"""Unit -> what the difference of such a quantity is relative to."""
PICTURES = 1_500_000
"""Bytes of pictures inside the page; others are linked."""
PARTS = ("reasons", "springs", "pictures", "tables")
"""Sections of the page; a judged field has no springs."""


def first_screen(
    found: Comparison | Judged,
    verdict: Mapping[str, Any],
    pictures: Sequence[Picture],
    remarks: Sequence[str],
) -> FirstScreen:
    """First screen of a case, or of a judged field, from its `verdict.json`."""
    case, badge = found.case, (verdict["verdict"], f"field {verdict['verdict']}")
    if isinstance(found, Judged):
        kind, name = "judged field", f"{found.result.name} for {case.name}"
        question = "Does this field agree"
        candidate, rows, cover = "field", found.verdict.differences, "difference"
    else:
        kind, name = "case: springs compared with elasticity", case.name
        candidate, rows, cover = "springs", found.rows, "field"
        spacing = quantity_text(found.springs[0].spacing, "m", case.unit)
        question = f"Do springs with a spacing of {spacing} agree"
        words = "springs agree with elasticity in {} of {} quantities"
        badge = agreement_badge(badge[0], [row.word for row in rows], words)
    return FirstScreen(
        f"msvalidate {kind}",
        name,
        badge,
        verdict["headline"],
        verdict["recommendation"],
        quantity_summary(case, rows, candidate),
        next((each for each in pictures if each.source and each.file == f"./{cover}.svg"), None),
        remarks,
        f"{question} with elasticity in this body within {percent(case.band)}?",
    )


def quantity_summary(case: Case, rows: Sequence[Difference], candidate: str) -> Summary:
    """Quantities in the units of the case; differences below their uncertainty are bounds."""
    texts = []
    for row in rows:
        unit, size = user_unit(row.unit, case.unit)
        values = (_number(value / size) for value in (row.found, row.wanted))
        error = part_text(row.error, row.uncertainty)
        name = LARGEST if row.quantity == DISPLACEMENT else row.quantity
        name = f"rms {name}" if row.of == POINT_STRESS else name
        name += f" ({unit})" if unit else ""
        texts.append((name, *values, error, percent(row.uncertainty), row.word))
    heads = ("quantity", candidate, "elasticity", "difference", "uncertainty", "verdict")
    bases = "".join(text for unit, text in BASES.items() if any(row.unit == unit for row in rows))
    caption = f"Differences count all components, over the size in elasticity{bases}. "
    caption += f"{band_words(case, rows)}."
    return Summary(caption, heads, texts, (False, True, True, True, True, False))


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
    """Verdict on the springs of a case, and its reasons."""
    reasons = (
        *_limit_sentences(found),
        "" if any(each.decides for each in found.limitations) else _kind_sentence(found),
        reference_sentence(found.reference),
        _hole_sentence(found),
        _mesh_sentence(found),
        _contact_sentence(found),
        break_sentence(found.springs[0].growth),
    )
    return springs_sentence(found), tuple(filter(None, reasons))


def _limit_sentences(found: Comparison) -> list[str]:
    """Limitations of a verdict; after linear theory that is requested, what it leaves out."""
    said = [each.sentence for each in found.limitations]
    if found.case.linear_theory:
        large = geometric_limitations(found.case, found.reference, found.nonlinear)
        said[1:1] = [each.fact for each in large]
    return said


def _gap_sentence(comparison: Comparison) -> str:
    """Gap that springs join, and the spacing that resolves it."""
    gaps, unit = comparison.gaps[0], comparison.case.unit
    x, y = (quantity_text(each, "m", unit).split()[0] for each in gaps[0, :2])
    width, spacing = (quantity_text(gaps[0, 2] / many, "m", unit) for many in (1, NARROW))
    return (
        f"Springs bridge a gap or hole of the body, {width} wide at ({x}, {y}), that their cells "
        f"do not resolve: take a spacing of {spacing} or less."
    )


def _hole_sentence(found: Comparison) -> str:
    """Name the narrowest hole that the lattice barely resolves; empty without one."""
    lattice = found.springs[0].lattice
    holes = narrow_holes(lattice) if isinstance(lattice, CutLattice) else np.empty((0, 3))
    if not len(holes):
        return ""
    x, y, wide = holes[holes[:, 2].argmin()]
    cells = wide / found.springs[0].spacing
    unit, size = user_unit("m", found.case.unit)
    return (
        f"A hole at ({x / size:.4g}, {y / size:.4g}) {unit} is {cells:.2g} cells wide: "
        "these springs hardly know it; take a smaller spacing, or the part's own mesh."
    )


def _mesh_sentence(found: Comparison) -> str:
    """Report the error of springs on the part's own mesh.

    The sentence also states what an engine must support for them.
    """
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
    if math.isfinite(found.alone):
        said += f" Springs alone on these edges differ by {percent(found.alone)}."
    return f"{said} {fault}{nearer}." if fault else said


def _contact_sentence(found: Comparison) -> str:
    """Report the resolution of the contact patch, and the recommended one."""
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
    """State the largest difference that counts as agreement."""
    stress = any(row.of == POINT_STRESS for row in rows)
    own = f", of stress at points {percent(STRESS_BAND * case.band)}" if stress else ""
    return f"The band is {percent(case.band)}{own}"


def reference_sentence(reference: Reference) -> str:
    """Report the error of the elasticity solution and its meshes.

    The sentence also states the cost of a smaller error.
    """
    nodes = len(reference.finest.body.points)
    about = _body_sentences(reference)
    if reference.no_limit:
        return f"Elasticity has no finite answer: {'; '.join(reference.no_limit)}.{about}"
    if not math.isfinite(reference.error):
        known = (
            f"Elasticity's own error is not known: one mesh of {nodes:,} nodes, and no finer one."
        )
        if reference.finest.pressure is not None and reference.finest.body.dim == 3:
            known += f" Give a first mesh of at most {MOST_MIXED // 8:,} nodes, by a larger cell."
        return known + _more_sentence(reference) + about
    asked_for = percent(reference.accuracy)
    reached = "as asked" if reference.resolved else f"not the {asked_for} asked for"
    known = (
        f"Elasticity is known to {percent(reference.error)} ({reached}): quadratic elements on "
        f"{len(reference.solutions)} meshes, the finest of {nodes:,} nodes."
    )
    return known + _more_sentence(reference) + about


def _more_sentence(reference: Reference) -> str:
    """State the cost of one more mesh, if memory limits it."""
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
    """Summarise the judgement of displacements from a file.

    One sentence states the result, the others its reasons.
    """
    row, case = found.displacement, found.case
    head = (
        f"Displacements of {found.result.name} are {percent(row.error)} off elasticity at "
        f"{len(found.matched.places):,} points, ± {percent(row.uncertainty)}; the band is "
        f"{percent(case.band)}."
    )
    limits = [each.sentence for each in found.limitations]
    if math.isnan(row.residual_motion):
        said = ["Rest unknown: nobody says how much the displacements would still change."]
    else:
        said = [f"Rest: they may still change by {percent(row.residual_motion)}, as stated."]
    for each in found.verdict.causes:
        how = "Fits" if found.verdict.fits(each) else "Comes near, but does not fit"
        said.append(f"{how} ({percent(each.left)} left): {each.said}")
    alike = found.verdict.indistinguishable
    if alike > 1:
        said.append(
            f"The field does not distinguish {alike} of these causes: what they leave differs by "
            f"less than {percent(row.uncertainty)}, the uncertainty."
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
    if len(found.gaps[0]):
        return _gap_sentence(found)
    if not math.isfinite(found.reference.error):
        return "The limit of finer lattices is not compared: elasticity's error is not known."
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
    if not found.kind:
        return ": no difference remains on any of these lattices"
    if found.kind == COARSE:
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


def _number(value: float) -> str:
    return number_text(value) if math.isfinite(value) else ""


def _text(value: object) -> str:
    if isinstance(value, float):
        return repr(value) if math.isfinite(value) else ""
    return str(value)


def facts(found: Comparison | Judged) -> dict[str, str]:
    """Facts of a request that its file may leave to defaults."""
    case, problem = found.case, found.case.problem
    about = {"result": found.result.name} if isinstance(found, Judged) else {}
    names = "; ".join(f"{part}: {name}" for part, name in mesh_names(problem).items())
    about |= {"names in the mesh": names} if names else {}
    return about | {
        "body": str(problem.domain),
        "material (SI units)": str(problem.material),
        "lattice": f"{case.lattice}, {quantity_text(spacing_of(case), 'm', case.unit)}",
        "theory": case.geometry,
        "band": percent(case.band),
        "accuracy of elasticity": percent(case.accuracy),
    }
