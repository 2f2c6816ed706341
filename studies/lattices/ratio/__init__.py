"""Any Poisson's ratio: which ways lead there, what they cost, and whether they lock near 1/2.

- `stretch`: blocks under a pull, with the volume energy: E and nu recovered;
- `routes`: how far each way goes, and how stiff its waves are;
- `bodies`: what a finite block loses by each way;
- `fitted`: constants by least squares where no closed form is known;
- `faults`: the smallest fault of a volume that is noticed;
- `rubber`: a bent block near nu = 1/2 against mixed finite elements, and which models lock;
- `pressure`: whether pressures of cells alternate from cell to cell;
- `resting`: condition and steps to rest as nu goes to 1/2.
"""

from __future__ import annotations

from msvalidate import kit

from . import bodies, faults, fitted, pressure, resting, routes, rubber, stretch


def any_ratio(candidate: kit.DisplacementSolver, setting: kit.Setting) -> kit.Evidence:
    """Is any ratio reached, by which route, and at what price?"""
    return kit.merge(
        stretch.run(candidate, setting),
        routes.run(setting),
        bodies.run(candidate, setting),
        fitted.run(setting),
        faults.run(),
    )


def near_half(candidate: kit.DisplacementSolver, setting: kit.Setting) -> kit.Evidence:
    """Do springs with the volume energy lock, alternate or crawl as nu goes to 1/2?"""
    return kit.merge(
        rubber.run(candidate, setting), pressure.run(candidate, setting), resting.run(setting)
    )
