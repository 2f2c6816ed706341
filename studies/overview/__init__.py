"""What are springs good for, and where must they not be used?

- `part`: one part by every spring model and by elements: error against springs and against time.
"""

from __future__ import annotations

from msvalidate.judging.candidate import DisplacementSolver, check_displacements, solve_springs
from msvalidate.judging.evidence import Evidence
from msvalidate.judging.sweep import FULL, Setting

from . import part

FAULTS: dict[str, dict[str, object]] = {}


def run(candidate: DisplacementSolver = solve_springs, setting: Setting = FULL) -> Evidence:
    """All questions."""
    return part.run(check_displacements(candidate), setting)
