"""What a reader of the report should know first, in sentences with the ledger's numbers."""

from __future__ import annotations

from collections.abc import Mapping

TOLD = (
    (
        "k2/(2 k1 + k2) is the ratio of one cell alone; blocks of shared springs are off it by up "
        "to {plain[17]:.2f}, and k2 = 2 k1 off incompressible by up to {plain[18]:.2f} (17, 18)."
    ),
    (
        "Random points with Voronoi neighbours have mean ratios from {plain[20]:.2f} on, where the "
        "report has 0 (20)."
    ),
    (
        "Steps to rest grow as nodes^{plain[11]:.2f} in the plane, where the report has a "
        "constant; elements take n^{plain[2]:.1f} for n nodes an edge, not n^9 (2, 11)."
    ),
    (
        "Three times critical damping takes {plain[27]:.1f} times the steps of a third of it; "
        "twice folds {under[27]:.0f} cells, where too little folds up to {plain[26]:.0f} (26, 27)."
    ),
    (
        "The loop as printed makes {plain[15]:.0f} steps; tested after each step it ends with up "
        "to {under[15]:.0f} times the error asked for (15)."
    ),
    (
        "As printed, Euler-Cromer is off explicit Euler by {plain[29]:.0g}, and velocity Verlet "
        "off the motion by {plain[31]:.0%} of its size (29, 31)."
    ),
    (
        "Coulomb's law between springs errs by {plain[43]:.0%} on the outermost node; on the third "
        "and fourth, by {under[43]:.1%} of the force on a tip (43)."
    ),
    (
        "With an energy of volumes, a bent block of isotropic rubber comes within {plain[58]:.1%} "
        "of mixed elements (57, 58)."
    ),
)
"""Of some sentences: `plain` are numbers of sentences as they stand, `under` of conditions."""


def tell(plain: Mapping[int, float], under: Mapping[int, float]) -> tuple[str, ...]:
    """Findings whose sentences have numbers."""
    found = []
    for words in TOLD:
        try:
            found.append(words.format(plain=plain, under=under))
        except KeyError:  # a ledger of some sentences only
            continue
    return tuple(found)
