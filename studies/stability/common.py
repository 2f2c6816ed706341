"""What the questions of the study share: columns, names of schemes, how figures show them."""

from __future__ import annotations

from collections.abc import Mapping

from msvalidate.dynamics.integrators import Integrator
from msvalidate.output import figures
from msvalidate.problem import ProblemError

Schemes = Mapping[str, Integrator]
"""Name -> scheme: the candidate of every question."""
REPORTED = ("explicit_euler", "euler_cromer", "leapfrog", "velocity_verlet")
"""The report's four, in their true forms."""
COLUMNS = {
    "scheme": "time integration scheme; _as_printed and _lagged are variants kept for comparison",
    "body": "single oscillator, or lattice clamped on one side",
    "points_a_side": "points along the clamped side; 1 of the oscillator",
    "step_over_limit": "time step over a stability limit (1)",
    "damping_ratio": "damping over twice the frequency, c/(2ω); for the limit of a network over "
    "twice its highest (1)",
    "steps": "time steps of the run",
    "h_omega": "time step times frequency (rad)",
}
"""What columns of several tables mean."""
NAMES = {
    "explicit_euler": "explicit Euler",
    "euler_cromer": "Euler-Cromer",
    "leapfrog": "leapfrog",
    "velocity_verlet": "velocity Verlet",
    "euler_cromer_as_printed": "Euler-Cromer as printed",
    "verlet_as_printed": "Verlet as printed",
    "verlet_lagged": "Verlet with the old force",
}
COLOUR = {
    "explicit_euler": figures.COLOURS[1],
    "euler_cromer": figures.COLOURS[0],
    "leapfrog": figures.COLOURS[2],
    "velocity_verlet": figures.COLOURS[3],
    "euler_cromer_as_printed": figures.COLOURS[5],
    "verlet_as_printed": figures.COLOURS[4],
    "verlet_lagged": "#444444",
}
MARKER = dict(zip(COLOUR, ("s", "o", "^", "D", "v", "P", "X"), strict=True))


def colour(scheme: str) -> str:
    """Colour of a scheme in every figure; black of one that is not ours."""
    return COLOUR.get(scheme, "black")


def marker(scheme: str) -> str:
    """Marker of a scheme in every figure."""
    return MARKER.get(scheme, ".")


def title(scheme: str) -> str:
    """A scheme's name in words."""
    return NAMES.get(scheme, scheme)


def chosen(candidate: Schemes, names: tuple[str, ...] = REPORTED) -> dict[str, Integrator]:
    """Those of the candidate's schemes that a question is about.

    Raises
    ------
    ProblemError
        If one is missing.
    """
    missing = [name for name in names if name not in candidate]
    if missing:
        raise ProblemError(f"candidate: no scheme {', '.join(missing)}; the study asks about it")
    return {name: candidate[name] for name in names}
