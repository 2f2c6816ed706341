"""What the questions of the study share: columns, names of schemes, how figures show them."""

from __future__ import annotations

from collections.abc import Mapping

from msvalidate import kit
from msvalidate.springs.dynamics.integrators import INTEGRATORS
from msvalidate.springs.dynamics.scheme import Integrator

Schemes = Mapping[str, Integrator]
"""Name -> scheme: the candidate of every question."""
REPORTED = ("explicit_euler", "euler_cromer", "leapfrog", "velocity_verlet")
"""The report's four, in their true forms."""
TRUE = tuple(name for name, scheme in INTEGRATORS.items() if not scheme.variant)
"""Schemes in their true forms."""


def colour(scheme: str) -> str:
    """Colour of a scheme in every figure, by its place in the table; black of others."""
    place = _place(scheme)
    return "black" if place is None else kit.figures.COLOURS[place % len(kit.figures.COLOURS)]


def marker(scheme: str) -> str:
    """Marker of a scheme in every figure, the next one where colours begin again."""
    place = _place(scheme)
    if place is None:
        return "."
    return kit.figures.MARKERS[
        (place + place // len(kit.figures.COLOURS)) % len(kit.figures.MARKERS)
    ]


def title(scheme: str) -> str:
    """A scheme's name in words."""
    return INTEGRATORS[scheme].title if scheme in INTEGRATORS else scheme


def _place(scheme: str) -> int | None:
    return list(INTEGRATORS).index(scheme) if scheme in INTEGRATORS else None


def chosen(candidate: Schemes, names: tuple[str, ...] = REPORTED) -> dict[str, Integrator]:
    """Those of the candidate's schemes that a question is about.

    Raises
    ------
    ProblemError
        If one is missing.
    """
    missing = [name for name in names if name not in candidate]
    if missing:
        raise kit.ProblemError(
            f"candidate: no scheme {', '.join(missing)}; the study asks about it"
        )
    return {name: candidate[name] for name in names}
