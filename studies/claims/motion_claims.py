"""Sentences about motion to rest: damping, and steps in time, of sections 2, 4, 5 and 8."""

from __future__ import annotations

import numpy as np

from msvalidate.output.results import Results

from .record import (
    AT_LEAST,
    AT_MOST,
    FAILS,
    HOLDS,
    ONLY_IF,
    Check,
    Claim,
    column,
    finest,
    numbers,
    rows,
    unjudged,
    value,
)

PASSING = "stability/passing"
SEEN = (20, 55)
"""Steps at which the report sees its overshoots."""
OTHERS = ("euler_cromer", "leapfrog", "velocity_verlet")


def energy_drift(results: Results) -> float:
    """Part of its energy that an undamped motion gains or loses, Euler-Cromer."""
    return abs(value(results, "stability/drift", "drift", scheme="euler_cromer"))


def returned_wave(results: Results) -> float:
    """Velocity of a wave that comes back from fixed nodes, over that before."""
    table = finest(results, "damping/wave", "cells", sides="held")
    return float(numbers(table, "returned").max())


def loop_off_rest(results: Results) -> float:
    """Farthest point of Algorithm 1's rest from the equilibrium by Newton's method."""
    return float(column(results, "poisson/algorithm1", "difference").max())


def first_steps(results: Results) -> float:
    """Most steps that the loop makes, its test read as printed, from rest."""
    return float(column(results, "damping/stop_rule", "printed_steps").max())


def error_over_asked(results: Results) -> float:
    """Largest error where the loop stops, tested after each step, over the one asked for."""
    return float(column(results, "damping/stop_rule", "error_over_asked").max())


def more_overshoots(results: Results) -> float:
    """Overshoots of a particle at a fifth of critical damping, less those at twice."""
    under, over = (
        value(results, "damping/overshoots", "overshoots", c_over_critical=c, curve="particle")
        for c in (0.2, 2.0)
    )
    return under - over


def price_of_critical(results: Results) -> float:
    """Steps at critical damping over the fewest, worst body."""
    table = rows(results, "damping/optimum")
    return float((numbers(table, "steps_at_critical") / numbers(table, "fewest_steps")).max())


def best_off_critical(results: Results) -> float:
    """Factor between the best damping and the critical one, worst body."""
    best = column(results, "damping/optimum", "best")
    return float(np.maximum(best, 1 / best).max())


def overshoot_ratio_off(results: Results) -> float:
    """Ratio of the two overshoots' times, off that of the report's reading."""
    where = {"c_over_critical": 0.2, "curve": "particle"}
    found = value(results, "damping/overshoots", "second_over_first", **where)
    return abs(found - SEEN[1] / SEEN[0])


def cells_folded(results: Results, low: float, high: float) -> float:
    """Most cells inside out at once, of stable runs with damping over critical within these."""
    table = rows(results, PASSING)
    damping = numbers(table, "c_over_critical")
    return float(
        numbers(table[(low <= damping) & (damping <= high)], "cells_inverted", "grows").max()
    )


def folded_underdamped(results: Results) -> float:
    """Most cells inside out below critical damping."""
    return cells_folded(results, 0.0, 0.99)


def folded_overdamped(results: Results) -> float:
    """Most cells inside out at twice critical damping or more."""
    return cells_folded(results, 2.0, np.inf)


def price_of_too_much(results: Results) -> float:
    """Steps at three times critical damping over those at a third, body where that is least."""
    third, thrice = (
        column(results, "damping/advice", "steps", c_over_critical=c) for c in (1 / 3, 3.0)
    )
    return float((thrice / third).min())


def price_of_too_little(results: Results) -> float:
    """Steps at a tenth of critical damping over those at it, body where that is least."""
    return float(column(results, "damping/advice", "price", c_over_critical=0.1).min())


def euler_off_formula(results: Results) -> float:
    """Growth a step of explicit Euler, farthest from that of the formula, over the latter."""
    table = rows(results, "stability/growth", scheme="explicit_euler")
    return float(
        np.abs(numbers(table, "growth_measured") / numbers(table, "growth_predicted") - 1).max()
    )


def printed_cromer(results: Results) -> float:
    """Difference of printed Euler-Cromer from explicit Euler, step for step."""
    where = {"scheme": "euler_cromer_as_printed"}
    return float(column(results, "stability/misprints", "difference", **where).max())


def printed_verlet(results: Results) -> float:
    """Difference of printed velocity Verlet from the motion that it should follow."""
    where = {"scheme": "verlet_as_printed", "compared_with": "motion itself"}
    return value(results, "stability/misprints", "difference", **where)


def runs_as_said(results: Results) -> float:
    """Part of the runs, at every step tried, in which Euler leaves or one of the others stays."""
    table = rows(results, "stability/figure3")
    euler, stays = table["scheme"] == "explicit_euler", table["leaves_at_step"] == "stays"
    return float((euler != stays)[euler | table["scheme"].isin(OTHERS)].mean())


def curves_apart(results: Results) -> float:
    """Farthest curve of the other three schemes from the motion, of those that stay."""
    table = rows(results, "stability/figure3", leaves_at_step="stays")
    return float(numbers(table[table["scheme"].isin(OTHERS)], "distance").max())


def decay_off_exponential(results: Results) -> float:
    """Rate of decay, farthest from that of the exponential, over the latter."""
    table = rows(results, "damping/decay")
    found, theory = (numbers(table, c) for c in ("rate_over_c", "rate_over_c_predicted"))
    return float(np.abs(found / theory - 1).max())


def growth_of_overdamped(results: Results) -> float:
    """Factor of the velocity in a step at the largest damping tried, body where it is least."""
    return float(numbers(finest(results, "damping/direction", "h_c"), "factor").min())


REST = (
    Claim(
        7, "2, first paragraph", "Without damping the motion never ends.",
        HOLDS, "springs and masses keep their energy, and so does a symplectic scheme in the mean",
        Check(
            "stability", "drift", "part of the energy gained or lost, Euler-Cromer", "1",
            energy_drift, AT_MOST, 1e-6, "a motion that ends loses all; a millionth in a thousand "
            "periods and more is none",
        ),
    ),
    unjudged(
        8, "2, first paragraph", "With damping each node has one stable position.",
        "work on several positions of rest will judge it: no table counts where motions end",
    ),
    Claim(
        9, "2, second paragraph", "At fixed nodes the wave stops and turns back.",
        HOLDS, "a fixed end returns the whole wave with its velocity reversed",
        Check(
            "damping", "wave", "velocity of the returned wave over that before", "1",
            returned_wave, AT_MOST, -0.95, "-1 in theory; a twentieth for what spreads on the way",
        ),
    ),
    Claim(
        14, "4, Algorithm 1", "The loop of force, velocity and position ends at the deformation.",
        ONLY_IF, "by its velocities it stops far too early or never starts; where forces balance, "
        "Newton's method finds the same",
        Check(
            "damping", "stop_rule", "error where its own rule stops it over the one asked for",
            "1", error_over_asked, AT_MOST, 1, "what is asked for",
        ),
        "it stops by the force left over, not by velocities",
        Check(
            "poisson", "algorithm1", "farthest point from rest by Newton's method", "1",
            loop_off_rest, AT_MOST, 1e-6, "a millionth of the displacement is seen by nobody",
        ),
    ),
    Claim(
        15, "4, Algorithm 1", "The loop runs while the largest velocity exceeds epsilon.",
        FAILS, "at rest before the first step it is zero, and at turning points it is small",
        Check(
            "damping", "stop_rule", "steps of the loop as printed, from rest", "1",
            first_steps, AT_LEAST, 1, "a loop that makes no step simulates nothing",
        ),
        "it is first tested after a step",
        Check(
            "damping", "stop_rule", "error where it then stops over the one asked for", "1",
            error_over_asked, AT_MOST, 1, "what is asked for",
        ),
    ),
    Claim(
        23, "5.3, equation", "Viscosity -v c over- or underdamps the system.",
        HOLDS, "a mode overshoots below twice its frequency and not above",
        Check(
            "damping", "overshoots", "overshoots at 0.2 of critical damping less those at 2", "1",
            more_overshoots, AT_LEAST, 1, "one is enough to tell them apart",
        ),
    ),
    Claim(
        24, "5.3, first paragraph", "The best damping is the critical one; others take longer.",
        ONLY_IF, "to a given error the best is somewhat below, where the overshoot stays in it",
        Check(
            "damping", "optimum", "steps at critical damping over the fewest, worst body", "1",
            price_of_critical, AT_MOST, 1.1, "a tenth more steps is as good as best",
        ),
        "nearly critical is meant",
        Check(
            "damping", "optimum", "factor between best and critical damping, worst body", "1",
            best_off_critical, AT_MOST, 2, "within a factor of two, as one finds by trial",
        ),
    ),
    Claim(
        25, "5.3, Figure 2", "Underdamped, it overshoots at about the 20th and 55th step.",
        HOLDS, "overshoots to one side come at odd multiples of half a period, 1 : 3",
        Check(
            "damping", "overshoots", "ratio of the overshoots' times, off 55/20 = 2.75", "1",
            overshoot_ratio_off, AT_MOST, 0.47, "both are told in fives: half of 5 steps in 20 "
            "and in 55 is 0.17 of their ratio",
        ),
    ),
    Claim(
        26, "5.3, first paragraph", "Overshoots may carry one particle past another.",
        HOLDS, "an overshoot is up to twice the displacement at rest",
        Check(
            "stability", "passing", "most cells inside out below critical damping", "1",
            folded_underdamped, AT_LEAST, 1, "one is enough: it may",
        ),
    ),
    Claim(
        27, "5.3, first paragraph", "If the critical value is unknown, rather overdamp.",
        ONLY_IF, "rates are 1/3 and 1/5.8 of the mode's: too much costs more, but never overshoots",
        Check(
            "damping", "advice", "steps at 3 times critical damping over those at a third", "1",
            price_of_too_much, AT_MOST, 1, "better if it takes no more steps",
        ),
        "keeping particles from passing matters more than steps",
        Check(
            "stability", "passing", "most cells inside out at twice critical damping", "1",
            folded_overdamped, AT_MOST, 0, "none may pass",
        ),
    ),
    Claim(
        54, "8, second paragraph", "Damping makes the velocity fall exponentially.",
        HOLDS, "c/2 below critical damping, the slower root above it, c where nothing pulls back",
        Check(
            "damping", "decay", "farthest rate from that of the exponential, over it", "1",
            decay_off_exponential, AT_MOST, 0.02, "first-order steps: half of h c, which is up to "
            "0.03 where rates go with c",
        ),
    ),
    Claim(
        55, "8, second paragraph", "Too large a coefficient turns motion round and destabilises.",
        HOLDS, "a step multiplies a free velocity by 1 - h c: turned beyond 1, growing beyond 2",
        Check(
            "damping", "direction", "size of the velocity's factor a step at h c = 2.1", "1",
            growth_of_overdamped, AT_LEAST, 1, "it grows from 1",
        ),
    ),
    Claim(
        56, "8, second paragraph", "Too small a coefficient costs many steps.",
        HOLDS, "a tenth of the damping decays at a tenth of the rate",
        Check(
            "damping", "advice", "steps at a tenth of critical damping over those at it", "1",
            price_of_too_little, AT_LEAST, 2, "twice the steps is many more",
        ),
    ),
)  # fmt: skip
SCHEMES = (
    Claim(
        28, "5.4 (1)", "Explicit Euler, as its formula is printed.",
        HOLDS, "grows by (1 + h²ω²)^(1/2) a step, which is that formula's",
        Check(
            "stability", "growth", "growth a step off that of the formula, over it", "1",
            euler_off_formula, AT_MOST, 1e-6, "an identity",
        ),
    ),
    Claim(
        29, "5.4 (2)", "Euler-Cromer, as its formula is printed.",
        FAILS, "positions are moved by the old velocity: explicit Euler by another name",
        Check(
            "stability", "misprints", "difference from explicit Euler, step for step", "1",
            printed_cromer, AT_LEAST, 1e-6, "another scheme moves otherwise",
        ),
    ),
    unjudged(
        30, "5.4 (3)", "Leapfrog, as its formula is printed.",
        "misprint: its index stands on the line; the scheme that is meant is judged in study "
        "stability",
    ),
    Claim(
        31, "5.4 (4)", "Velocity Verlet, as its formula is printed.",
        FAILS, "the second half kick starts anew: half of the force is lost",
        Check(
            "stability", "misprints", "difference from the motion, over its size", "1",
            printed_verlet, AT_MOST, 0.01, "fine steps bring a right scheme far below a hundredth",
        ),
    ),
    Claim(
        32, "5.4, Figure 3", "Explicit Euler is least stable; the others give one smooth curve.",
        HOLDS, "Euler grows at any step without damping; the others stay up to h ω = 2",
        Check(
            "stability", "figure3", "part of all runs in which Euler leaves and others stay", "1",
            runs_as_said, AT_LEAST, 0.5, "most likely: in more runs than not",
        ),
        "the step is below their stability limit",
        Check(
            "stability", "figure3", "farthest of their curves from the motion, below the limit",
            "1", curves_apart, AT_MOST, 0.1, "a tenth of the way is where printed curves part",
        ),
    ),
)  # fmt: skip
CLAIMS = (*REST, *SCHEMES)
