"""Sentences about dielectric elastomer actuators: section 7, and what 8 makes of them."""

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
    Reading,
    column,
    finest,
    numbers,
    rows,
    unjudged,
    value,
)

FIGURE_8, NODES, HALVES = (
    "actuator/figure8_statements",
    "electrostatics/nodes",
    "electrostatics/halves",
)
PHYSICS, REPORTS = ("in_springs", "in_fem"), ("in_report", "in_report_coarse")
EVEN = "uniform"
"""Segments of one length, as springs of a lattice are."""
OFF = 0.05
"""What an engineer neglects."""


def charge_off_plane(results: Results) -> float:
    """Charge of the report's body over that of the plane, off 1, at the worst depth."""
    return float(np.abs(column(results, "electrostatics/depths", "as_report_over_plane") - 1).max())


def deep_charge_off_plane(results: Results) -> float:
    """The same at depths of 24 gaps and more."""
    table = rows(results, "electrostatics/depths")
    deep = table[numbers(table, "depth_over_gap") >= 24]
    return float(np.abs(numbers(deep, "as_report_over_plane") - 1).max())


def order_of_charges(results: Results) -> float:
    """Least order with which charges on even segments come to the closed form."""
    return float(column(results, "electrostatics/strip_orders", "order", grading=EVEN).min())


def edge_off_coulomb(results: Results) -> float:
    """Force on the edge's own node by Coulomb's law, off that of the energy, finest."""
    found, right = (
        float(numbers(finest(results, NODES, "segments", charges_on="springs", forces_by=by),
                      "edge_along")[0])
        for by in ("point sums", "derivatives")
    )  # fmt: skip
    return abs(found / right - 1)


def halves_off(results: Results) -> float:
    """Force on the edge's own node by halves, off that of the energy, finest."""
    table = finest(results, HALVES, "segments", grading=EVEN, from_edge=0)
    return float(abs(numbers(table, "along_halves")[0] / numbers(table, "along")[0] - 1))


def inner_halves_off(results: Results) -> float:
    """Farthest force by halves on the third and fourth node, over the force on a tip, finest."""
    table = finest(results, HALVES, "segments", grading=EVEN)
    table = table[table["from_edge"].isin([2, 3])]
    return float(np.abs(numbers(table, "along_halves") - numbers(table, "along")).max())


def total_halves_off(results: Results) -> float:
    """Force by halves on half of the strip, off that of the energy, finest."""
    table = finest(results, HALVES, "segments", grading=EVEN, from_edge="half")
    return float(abs(numbers(table, "along_halves")[0] / numbers(table, "along")[0] - 1))


def compressed_alike(results: Results) -> float:
    """Part of the most stretched film that sinks as its middle does, springs or elements."""
    table = finest(results, "actuator/prestretched", "prestretch", film="stretched")
    return float(min(numbers(table, "alike").min(), numbers(table, "alike_fem").min()))


def in_figure_8(results: Results, statement: str, sources: tuple[str, ...]) -> list[float]:
    """What a statement about Figure 8 measures in each of some models."""
    return [value(results, FIGURE_8, source, statement=statement) for source in sources]


def marginal_effect(results: Results) -> float:
    """Deflection 2 m inside the edge over that of the middle, least of springs and elements."""
    return min(in_figure_8(results, "strong marginal effect", PHYSICS))


def growth_of_effect(results: Results) -> float:
    """That at 1.5 V over that at 0.5 V, least of springs and elements."""
    return min(in_figure_8(results, "the effect grows with voltage", PHYSICS))


def middle_sinks(results: Results) -> float:
    """Deflection of the middle over the largest, at 0.5 V, least of springs and elements."""
    return min(in_figure_8(results, "at low voltage the middle is the main effect", PHYSICS))


def waves_of_the_top(results: Results) -> float:
    """Dips under the electrode more than at 0.5 V, most of all models."""
    words = "the top becomes wavy at a higher voltage"
    return max(in_figure_8(results, words, PHYSICS + REPORTS))


def springs_from_edge(results: Results, sources: tuple[str, ...]) -> float:
    """Springs between the edge and what sinks fastest, least of some models."""
    return min(in_figure_8(results, "the unstable part is not at the margin", sources))


def from_edge_in_physics(results: Results) -> float:
    """Springs between the edge and what sinks fastest, in springs and elements."""
    return springs_from_edge(results, PHYSICS)


def from_edge_in_report(results: Results) -> float:
    """The same by the report's way."""
    return springs_from_edge(results, REPORTS)


def charge_moves_in(results: Results, sources: tuple[str, ...]) -> float:
    """Charge on the middle half at the last voltage, less that at 0.5 V, least of some models."""
    words = "charges concentrate on the central part after the indentation"
    return min(in_figure_8(results, words, sources))


def charge_moves_in_physics(results: Results) -> float:
    """Change of the charge on the middle half, in springs and elements."""
    return charge_moves_in(results, PHYSICS)


def charge_moves_in_coarse_report(results: Results) -> float:
    """The same by the report's way on 5 layers."""
    return charge_moves_in(results, REPORTS[1:])


def nodes_over_springs(results: Results) -> float:
    """Error of charge on nodes over that of charge on springs, finest."""
    nodes, springs = (
        abs(float(numbers(finest(results, NODES, "segments", charges_on=place), "charge_error")[0]))
        for place in ("nodes", "springs")
    )
    return nodes / springs


def springs_over_nodes(results: Results) -> float:
    """Error of charge on springs over that of charge on nodes, finest."""
    return 1 / nodes_over_springs(results)


def springs_off_elements(results: Results) -> float:
    """Difference of springs from elements away from the edges, extrapolated, finest."""
    table = finest(results, "actuator/profile", "layers")
    return float(np.abs(numbers(table, "extrapolated")).max())


def figure_8(measure: str, read: Reading, bound: float, because: str) -> Check:
    """A check by what was seen of Figure 8."""
    return Check("actuator", "figure8_statements", measure, "1", read, AT_LEAST, bound, because)


CHARGES = (
    unjudged(
        38, "7, second paragraph", "Dielectric elastomers strain much and store much energy.",
        "background: quoted from an encyclopedia",
    ),
    unjudged(
        39, "7, third paragraph", "Under voltage the membrane gets thinner and longer.",
        "no table tells how far a membrane lengthens; the bonded slab of Figure 8 hardly can",
    ),
    Claim(
        40, "7, integral of the potential", "Potential is the integral of charge over 4 pi eps r.",
        ONLY_IF, "that is a body's in space: a plane one's is a logarithm, its limit for depth",
        Check(
            "electrostatics", "depths", "charge over that of the plane, off 1, worst depth", "1",
            charge_off_plane, AT_MOST, OFF, "what an engineer neglects, at any depth as none is "
            "named",
        ),
        "the body is 24 gaps deep or more, its charge even",
        Check(
            "electrostatics", "depths", "charge over that of the plane, off 1, 24 gaps and more",
            "1", deep_charge_off_plane, AT_MOST, OFF, "what an engineer neglects",
        ),
    ),
    Claim(
        41, "7, Method of Moments", "Contributions of all charged springs add up to the voltages.",
        HOLDS, "charges even on each segment converge with order 1 on even segments",
        Check(
            "electrostatics", "strip_orders", "least order of the capacitance", "1",
            order_of_charges, AT_LEAST, 0.9, "order 1, less a tenth for the coarsest sizes",
        ),
    ),
    unjudged(
        42, "7, Method of Moments", "Both electrodes together carry no charge.",
        "implied by opposite voltages and nowhere said; study electrostatics asks for it",
    ),
    Claim(
        43, "7, after the integral", "Coulomb's law easily gives the force on each charged spring.",
        ONLY_IF, "middles see no field of their own segment, which pulls at the edge alone",
        Check(
            "electrostatics", "nodes", "force on the outermost node, off that of the energy", "1",
            edge_off_coulomb, AT_MOST, OFF, "what an engineer neglects",
        ),
        "the two outermost nodes are left out",
        Check(
            "electrostatics", "halves", "error on the next two nodes over the force on a tip", "1",
            inner_halves_off, AT_MOST, OFF, "what an engineer neglects",
        ),
    ),
    Claim(
        44, "7, after the integral", "A spring's force goes to its two nodes in halves.",
        ONLY_IF, "fields vary along an edge's segment, so its own node takes more than half",
        Check(
            "electrostatics", "halves", "force on the outermost node, off that of the energy", "1",
            halves_off, AT_MOST, OFF, "what an engineer neglects",
        ),
        "the sum over many even springs is asked for",
        Check(
            "electrostatics", "halves", "force on half a strip, off that of the energy, finest",
            "1", total_halves_off, AT_MOST, OFF, "what an engineer neglects",
        ),
    ),
    Claim(
        60, "8, fourth paragraph", "Charge belongs on springs, for ends and inside alike.",
        ONLY_IF, "both err with order 1 on even springs, with opposite signs: none is better",
        Check(
            "electrostatics", "nodes", "error of charge on nodes over that on springs", "1",
            nodes_over_springs, AT_LEAST, 2, "an advantage if it halves the error",
        ),
        "one definition for all is asked, not accuracy",
        Check(
            "electrostatics", "nodes", "error of charge on springs over that on nodes", "1",
            springs_over_nodes, AT_MOST, 1, "no worse than the other definition",
        ),
    ),
)  # fmt: skip
FIGURE = (
    Claim(
        45, "7, before Figure 8", "A pre-stretched film is compressed nearly uniformly.",
        HOLDS, "margins reach a height inwards, and the film is 16 heights long",
        Check(
            "actuator", "prestretched", "part of the film that sinks as its middle, stretch 2",
            "1", compressed_alike, AT_LEAST, 0.8, "four fifths is nearly all: 16 heights less a "
            "height and a half at either end",
        ),
    ),
    Claim(
        46, "7, Figure 8 (2)", "A fully covered membrane has a strong marginal effect.",
        HOLDS, "charge and stress are singular at the edge, which nothing holds",
        figure_8("deflection 2 m inside the edge over the middle's", marginal_effect, 1.5,
                 "half as much again is strong"),
    ),
    Claim(
        47, "7, Figure 8 (2)", "That effect grows with voltage.",
        HOLDS, "the gap narrows most at the edge, and its field grows most",
        figure_8("marginal effect at 1.5 V over that at 0.5 V", growth_of_effect, 1.02,
                 "a fiftieth is more than springs and elements differ by"),
    ),
    Claim(
        48, "7, Figure 8 (3)", "Partly covered, low voltage mainly compresses the middle.",
        HOLDS, "pressure acts under the electrode alone",
        figure_8("deflection of the middle over the largest, 0.5 V", middle_sinks, 0.5,
                 "mainly is more than half of the most"),
    ),
    Claim(
        49, "7, Figure 8 (3)", "At higher voltage the top gets wavy and unstable.",
        FAILS, "the electrode's edge is lost at a voltage below that of waves",
        figure_8("dips under the electrode more than at 0.5 V, any model", waves_of_the_top, 0.5,
                 "a wave has one dip more"),
    ),
    Claim(
        50, "7, Figure 8 (3)", "What gets unstable is not at the electrode's margin.",
        ONLY_IF, "the edge's charge pulls hardest; the report's sums miss half of that",
        figure_8("springs from the edge to what sinks fastest", from_edge_in_physics, 0.5,
                 "one spring away is not at the margin"),
        "charges and forces are the report's own",
        figure_8("springs from the edge to what sinks fastest, report's way", from_edge_in_report,
                 0.5, "one spring away is not at the margin"),
    ),
    Claim(
        51, "7, Figure 8 (3)", "After the indentation charge gathers in the centre.",
        ONLY_IF, "the edge sinks fastest, so charge goes there",
        figure_8("charge on the middle half, last voltage less 0.5 V", charge_moves_in_physics, 0,
                 "gathering is a growth"),
        "charges are the report's and the film has 5 layers",
        figure_8("charge on the middle half, report's way, 5 layers",
                 charge_moves_in_coarse_report, 0, "gathering is a growth"),
    ),
    unjudged(
        52, "7, last paragraph", "The figure's scales and thicknesses differ for better view.",
        "background: a remark on the drawing",
    ),
    Claim(
        61, "8, fourth paragraph", "Actuators by springs should be compared with elements.",
        HOLDS, "the same law and charges on finer meshes tend to the same shape",
        Check(
            "actuator", "profile", "springs off elements away from edges, extrapolated", "1",
            springs_off_elements, AT_MOST, 0.01, "compared, and within a hundredth of the largest "
            "displacement",
        ),
    ),
)  # fmt: skip
CLAIMS = (*CHARGES, *FIGURE)
