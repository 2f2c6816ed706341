"""Any Poisson's ratio: which ways lead there, what they cost, and whether they lock near 1/2.

- `stretch`: blocks under a pull, with the volume energy: E and nu recovered;
- `routes`: how far each way goes, and how stiff its waves are (figure: `ranges`);
- `bodies`: what a finite block pays for each way;
- `fitted`: constants by least squares where no closed form is known;
- `faults`: the smallest fault of a volume that is noticed;
- `rubber`: a bent block near nu = 1/2 against mixed finite elements;
- `locking`: which models lose their deflection near 1/2, by a count of conditions;
- `pressure`: whether pressures of cells alternate from cell to cell;
- `resting`: condition and steps to rest as nu goes to 1/2.
"""

from __future__ import annotations

from msvalidate.judging.candidate import DisplacementSolver
from msvalidate.judging.evidence import Evidence, merge
from msvalidate.judging.sweep import Setting

from . import (
    bodies,
    faults,
    fitted,
    pressure,
    resting,
    routes,
    rubber,
    stretch,
)


def any_ratio(candidate: DisplacementSolver, setting: Setting) -> Evidence:
    """Is any ratio reached, by which route, and at what price?"""
    return merge(
        stretch.run(candidate, setting),
        routes.run(setting),
        bodies.run(candidate, setting),
        fitted.run(setting),
        faults.run(setting),
    )


def near_half(candidate: DisplacementSolver, setting: Setting) -> Evidence:
    """Do springs with the volume energy lock, alternate or crawl as nu goes to 1/2?"""
    return merge(
        rubber.run(candidate, setting),
        pressure.run(candidate, setting),
        resting.run(setting),
    )
