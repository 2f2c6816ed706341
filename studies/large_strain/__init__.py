"""Spring laws at large strain

The report has springs serve beyond 5 % strain where elements fail, and leaves rubber's law open.
One question a file:

- `twins`: springs under tension beside cells under pressure, against finite elements node for node;
- `stretch`: laws of springs in homogeneous strain, against neo-Hookean and St. Venant-Kirchhoff;
- `bending`: a block whose ends turn, springs and linear elements against elements in full;
- `rubber`: which law of springs is vulcanised rubber, by Treloar's three tests;
- `buckling`: a column beyond its critical load, against the elastica.

Candidate: displacements predicted for a problem and its network, by default the network's own
equilibrium. Reference: closed forms, scikit-fem finite elements, and measured rubber.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from msvalidate import kit
from msvalidate.springs.network import Network

from . import bending, buckling, rubber, stretch, twins

FAULTS = {
    **twins.FAULTS,
    **stretch.FAULTS,
    **bending.FAULTS,
    **rubber.FAULTS,
    **buckling.FAULTS,
}
"""Negative controls: arguments of `run` under which a tolerance must fail."""


def run(
    candidate: kit.DisplacementSolver = kit.solve_springs,
    setting: kit.Setting = kit.FULL,
    questions: tuple[str, ...] | None = None,
    laws: dict[str, rubber.Basis] = rubber.LAWS,
    build: Callable[[int, int], tuple[Network, kit.Array]] = buckling.column,
) -> kit.Evidence:
    """All questions, or those named, for one candidate, laws of rubber and way to build columns."""
    candidate = kit.check_displacements(candidate)
    asked: dict[str, Callable[[], kit.Evidence]] = {
        "twins": partial(twins.run, candidate, setting),
        "stretch": partial(stretch.run, candidate, setting),
        "bending": partial(bending.run, candidate, setting),
        "rubber": partial(rubber.run, laws),
        "buckling": partial(buckling.run, setting, build),
    }
    return kit.gather_evidence(asked, questions)
