"""The classic benchmarks of elasticity: how near do springs and elements come to them?

Every table of a benchmark has the layout of `cases`: the value, the accepted one and its source,
the differences, an uncertainty, and the order with which the mesh takes them away. One question a
file:

- `patch`: MacNeal and Harder's patch tests;
- `from_file`: the patch from a mesh file in mm;
- `cantilever`: Timoshenko and Goodier's beam, whose exact field is known;
- `bending`: pure bending at any Poisson's ratio, against a closed form;
- `three_point`: a beam under a load in the middle of its span;
- `cook`: Cook's membrane, by elements, a cut lattice and springs on edges of meshes;
- `ellipse`: the membrane with an elliptic hole, NAFEMS LE1;
- `hole`: the plate with a circular hole, Kirsch's;
- `strips`: the same of a finite width, Heywood's;
- `ring`: Lamé's pressed ring, up to nu = 0.499;
- `thick_plate`: the plate of NAFEMS LE10 by elements, and whether it has a limit;
- `plate_springs`: the same plate by springs;
- `frozen_cases`: boxes of the set that others may copy, judged as anybody's fields are;
- `published`: spring meshes whose stiffnesses were printed, found again row by row.

Table `benchmarks` holds the finest mesh of all of them (`overview`). Candidate: displacements
predicted for a problem and its network. Reference: accepted values, closed forms, scikit-fem finite
elements.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from msvalidate.judging.candidate import DisplacementSolver, check_displacements, solve_springs
from msvalidate.judging.evidence import Evidence, gather_evidence, merge
from msvalidate.judging.sweep import FULL, Setting

from . import (
    bending,
    cantilever,
    cases,
    controls,
    cook,
    ellipse,
    from_file,
    frozen_cases,
    hole,
    overview,
    patch,
    plate_springs,
    published,
    ring,
    strips,
    thick_plate,
    three_point,
)

FAULTS = controls.FAULTS
"""Negative controls: arguments of `run` under which a tolerance must fail, asked of the question
that should notice."""
QUESTIONS: dict[str, Callable[[DisplacementSolver, Setting], Evidence]] = {
    "patch": patch.run,
    "from_file": from_file.run,
    "cantilever": cantilever.run,
    "bending": bending.run,
    "three_point": three_point.run,
    "cook": cook.run,
    "ellipse": ellipse.run,
    "hole": hole.run,
    "strips": strips.run,
    "ring": ring.run,
    "thick_plate": thick_plate.run,
    "plate_springs": plate_springs.run,
    "frozen_cases": frozen_cases.run,
    "published": published.run,
}


def run(
    candidate: DisplacementSolver = solve_springs,
    setting: Setting = FULL,
    questions: tuple[str, ...] | None = None,
) -> Evidence:
    """All questions, or those named, for one candidate."""
    asked = setting
    candidate = check_displacements(candidate)
    found = gather_evidence(
        {name: partial(ask, candidate, asked) for name, ask in QUESTIONS.items()}, questions
    )
    if not any(cases.has_layout(table) for table in found.tables.values()):
        return found
    return merge(overview.overview(found.tables), found)
