"""Limits: how large may the step be?

Question   Which step is the largest stable one of each scheme, against the damping ratio
           ζ = c/(2ω) of the highest frequency, for one oscillator and for networks?
Candidate  Each scheme's own step, run for hundreds to thousands of steps on trial after trial.
Reference  Its limit in closed form; of a network with the ends of its spectrum.
Expected   Equal, to the last gap between trial steps. Where no step is stable, see `growth`.
"""

from __future__ import annotations

from functools import partial
from itertools import product

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from msvalidate import kit
from msvalidate.springs.dynamics.integrators import INTEGRATORS
from msvalidate.springs.dynamics.scheme import Integrator
from msvalidate.springs.dynamics.step_limits import stability_limit

from . import common
from .bounded import Search, measured_limit
from .common import Schemes
from .networks import OSCILLATOR, Body, Linear, linear

SEARCH = Search()
ATLAS = tuple(float(zeta) for zeta in np.round([0, 0.05, *np.arange(0.1, 3.05, 0.1)], 2))
QUICK_ATLAS = (0.0, 0.05, 0.3, 0.6, 1.0, 1.5, 2.0, 3.0)
"""Damping ratios of the oscillator."""
CURVE = tuple(float(zeta) for zeta in np.round(np.arange(0, 3.01, 0.025), 3))
JUMP = 0.8
"""Damping ratios at which the closed forms are drawn, and the difference (rad) between two of them
that is a jump: velocity Verlet has one."""
RATIOS = (0.0, 0.05, 0.3, 1.0, 2.0)
"""Damping ratios of the networks, at their highest frequency."""
SIDES = (6, 12, 40)
QUICK_SIDES = (6,)
LATTICES = ("square", "triangular")
LOOKS = {
    "oscillator": ("o", kit.figures.COLOURS[0], 4.0),
    "square": ("s", kit.figures.COLOURS[1], 7.0),
    "triangular": ("^", kit.figures.COLOURS[2], 10.0),
}
"""Body -> marker, its colour and its size: networks agree, so that their markers enclose others."""


RULES = (
    kit.Rule(
        "largest stable step, measured over closed form", 0.01, "1",
        f"the search ends within {SEARCH.resolution:.2%}; slow growth near the limit may go "
        "unnoticed for another gap",
        table="limits", value="limit_error",
    ),
)  # fmt: skip


def run(candidate: Schemes = INTEGRATORS, setting: kit.Setting = kit.FULL) -> kit.Evidence:
    """Measure the limits of every scheme on every body."""
    common.chosen(candidate)  # of which the findings speak
    limited = {name: scheme for name, scheme in candidate.items() if np.isfinite(scheme.limit(0.0))}
    sides = QUICK_SIDES if setting.quick else SIDES
    bodies = [OSCILLATOR, *(Body(lattice, n) for n, lattice in product(sides, LATTICES))]
    cases = [
        (body, moving, scheme)
        for body, moving in zip(bodies, map(linear, bodies), strict=True)
        for scheme in limited.items()
    ]
    found = setting.sweep(partial(measure, setting.quick, setting.seed), cases, "stability limits")
    table = pd.DataFrame([row for rows in found for row in rows])
    return kit.Evidence(
        tables={"limits": table, "limit_curves": curves(limited)},
        tolerances=RULES,
        figures={"atlas": draw},
        columns=kit.columns(__file__),
        findings=tuple(findings(table, limited)),
    )


def measure(
    quick: bool, seed: int, case: tuple[Body, Linear, tuple[str, Integrator]]
) -> list[dict[str, object]]:
    """Rows of one scheme on one body, a damping each; none where no step is stable."""
    body, moving, (name, scheme) = case
    highest = moving.omega[1]
    atlas = QUICK_ATLAS if quick else ATLAS
    ratios = np.array(atlas if body == OSCILLATOR else RATIOS)
    damping = 2 * ratios * highest
    predicted = np.array([stability_limit(scheme, *moving.omega, c) for c in damping.tolist()])
    stable = predicted > 0
    found = measured_limit(scheme, moving, damping[stable], SEARCH, seed)
    return [
        {
            "scheme": name,
            "body": body.lattice,
            "points_a_side": body.points,
            "damping_ratio": ratio,
            "limit_measured": measured * highest,
            "limit_predicted": closed * highest,
            "limit_error": measured / closed - 1,
        }
        for ratio, measured, closed in zip(ratios[stable], found, predicted[stable], strict=True)
    ]


def curves(candidate: Schemes) -> pd.DataFrame:
    """Closed forms of one oscillator against the damping ratio."""
    return pd.DataFrame(
        [
            {"scheme": name, "damping_ratio": zeta, "limit_predicted": scheme.limit(zeta)}
            for (name, scheme), zeta in product(candidate.items(), CURVE)
        ]
    )


def findings(table: pd.DataFrame, candidate: Schemes) -> list[str]:
    """Which scheme bears the largest step, without damping and with much."""
    one = table[(table["body"] == "oscillator") & table["scheme"].isin(common.REPORTED)]
    said = []
    for ratio in (0.0, 0.3, 2.0):
        rows = one[one["damping_ratio"] == ratio].sort_values(
            "limit_measured", ascending=False, kind="stable"
        )
        values = [
            f"{common.title(name)} {limit:.3f}"
            for name, limit in zip(rows["scheme"], rows["limit_measured"], strict=True)
        ]
        none = [common.title(s) for s in common.REPORTED if s not in set(rows["scheme"])]
        said.append(
            f"Largest stable step times frequency at a damping ratio of {ratio:g}: "
            + ", ".join([*values, *(f"{name} none" for name in none)])
            + "."
        )
    return [*said, _worst_found(table), _jump(curves(candidate))]


def _worst_found(table: pd.DataFrame) -> str:
    return (
        f"{len(table)} limits of {table['scheme'].nunique()} schemes on "
        f"{len(table[['body', 'points_a_side']].drop_duplicates())} bodies are the closed forms to "
        f"{table['limit_error'].abs().max():.2%}."
    )


def _jump(closed: pd.DataFrame) -> str:
    """Where damping does velocity Verlet harm, and where it helps."""
    rows = closed[closed["scheme"] == "velocity_verlet"].reset_index(drop=True)
    limit, ratio = rows["limit_predicted"], rows["damping_ratio"]
    jump = int(limit.diff().abs().fillna(0).to_numpy().argmax())
    least = int(limit[:jump].to_numpy().argmin())
    return (
        f"Velocity Verlet's limit falls to {limit[least]:.2f} at a damping ratio of "
        f"{ratio[least]:.3g}, and leaps from {limit[jump - 1]:.2f} to {limit[jump]:.2f} between "
        f"{ratio[jump - 1]:.3g} and {ratio[jump]:.3g}, to fall again."
    )


def draw(tables: kit.Tables) -> Figure:
    """Stability atlas: the largest stable step against the damping ratio, a panel a scheme."""
    table, closed = tables["limits"], tables["limit_curves"]
    names = list(dict.fromkeys(table["scheme"]))
    figure, axes = kit.figures.new_figure(3, -(-(len(names) + 1) // 3), size=(2.4, 2.2))
    for axis, name in zip(axes, names, strict=False):
        rows = table[table["scheme"] == name]
        _curve(axis, closed, name, "black", "closed form, one oscillator")
        networks = rows[rows["body"] != "oscillator"]
        at = (networks["damping_ratio"], networks["limit_predicted"])
        axis.plot(*at, "k_", ms=12, mew=1, label="closed form, network")
        for body, points in rows.groupby("body"):
            shape, tint, size = LOOKS[str(body)]
            at = (points["damping_ratio"], points["limit_measured"])
            axis.plot(*at, shape, mfc="none", mec=tint, ms=size, label=f"measured, {body}")
        axis.set_title(common.title(name))
    together, *unused = axes[len(names) :]
    for name in [n for n in names if n in common.TRUE]:
        _curve(together, closed, name, common.colour(name), common.title(name))
    together.set_title("closed forms together")
    for axis in (*axes[: len(names)], together):
        axis.set(xlabel="damping ratio c/(2ω) (1)", ylim=(0, 4.2))
        if axis.get_subplotspec().is_first_col():  # type: ignore[union-attr]
            axis.set_ylabel("largest h·ω (rad)")
    for axis in unused:
        figure.delaxes(axis)
    figure.suptitle("The largest stable step of each scheme")
    kit.figures.add_shared_legend(figure, axes[: len(names) + 1], columns=3)
    return figure


def _curve(axis: Axes, closed: pd.DataFrame, name: str, colour: str, label: str) -> None:
    rows = closed[closed["scheme"] == name]
    limit = rows["limit_predicted"]
    # A jump is no slope: the line is broken there.
    whole = limit.where(limit.diff().abs().fillna(0) < JUMP)
    axis.plot(rows["damping_ratio"], whole, color=colour, lw=1, label=label)
