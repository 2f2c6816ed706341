"""Classic benchmarks of elasticity

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

from functools import partial

from msvalidate import kit

from . import (
    benchmarks_controls,
    bending,
    cantilever,
    cases,
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

FAULTS = benchmarks_controls.FAULTS
"""Negative controls: arguments of `run` under which a tolerance must fail, asked of the question
that should notice."""
ASKED = (
    patch, from_file, cantilever, bending, three_point, cook, ellipse, hole, strips, ring,
    thick_plate, plate_springs, frozen_cases, published,
)  # fmt: skip
QUESTIONS = {module.__name__.rpartition(".")[2]: module.run for module in ASKED}


def run(
    candidate: kit.DisplacementSolver = kit.solve_springs,
    setting: kit.Setting = kit.FULL,
    questions: tuple[str, ...] | None = None,
) -> kit.Evidence:
    """All questions, or those named, for one candidate."""
    candidate = kit.check_displacements(candidate)
    found = kit.gather_evidence(
        {name: partial(ask, candidate, setting) for name, ask in QUESTIONS.items()}, questions
    )
    if not any(cases.has_layout(table) for table in found.tables.values()):
        return found
    return kit.merge(overview.overview(found.tables), found)
