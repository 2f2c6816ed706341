"""Sentences about what elements and springs cost, and about their background: sections 1 and 2."""

from __future__ import annotations

from msvalidate.output.results import Results

from .record import (
    AT_LEAST,
    AT_MOST,
    FAILS,
    HOLDS,
    ONLY_IF,
    Check,
    Claim,
    numbers,
    rows,
    unjudged,
    value,
)

FACTORS = "convergence/growth_of_factors"
STEPS = {"body": "plate", "method": "algorithm1", "threshold": 1e-6}
"""Algorithm 1 in the plane, to an error of a millionth."""


def factor_growth(results: Results) -> float:
    """Exponent of a sparse factor's products in the number of nodes, in space."""
    return value(results, FACTORS, "exponent", way="nested dissection", quantity="products")


def sparse_growth(results: Results) -> float:
    """The same in the nodes of an edge, of which there are a cube's root."""
    return 3 * factor_growth(results)


def full_growth(results: Results) -> float:
    """Exponent of a full matrix's products in the nodes of an edge."""
    return 3 * value(results, FACTORS, "exponent", way="full matrix", quantity="products")


def work_growth(results: Results) -> float:
    """Exponent of Algorithm 1's work to rest in the number of nodes."""
    return value(results, "convergence/growth", "exponent", quantity="cost in nodes", **STEPS)


def steps_growth(results: Results) -> float:
    """Exponent of Algorithm 1's steps to rest in the number of nodes."""
    return value(results, "convergence/growth", "exponent", quantity="steps in nodes", **STEPS)


def operations_growth(results: Results) -> float:
    """Operations a node and step, largest lattice over smallest."""
    table = rows(results, "cost/limits", network="lattice", axes=2, way="general")
    operations = numbers(table.sort_values("nodes", kind="stable"), "operations_a_node")
    return float(operations[-1] / operations[0])


CLAIMS = (
    Claim(
        1, "1, first paragraph", "Elements solve a large Ax = b, which takes much computing.",
        HOLDS, "the last separator of a solid is a full matrix of nodes^(2/3): products nodes^2",
        Check(
            "convergence", "growth_of_factors",
            "exponent of a sparse factor's products in the nodes, in space", "1",
            factor_growth, AT_LEAST, 1.1, "work that grows as the nodes do would be that of "
            "reading the matrix; a tenth is what logarithms add",
        ),
    ),
    Claim(
        2, "1, first paragraph", "With n nodes an edge, solving takes O(n^9).",
        ONLY_IF, "elements' matrices are sparse: n^6 by nested dissection; a full one takes n^9",
        Check(
            "convergence", "growth_of_factors", "exponent in n, sparse factor", "1",
            sparse_growth, AT_LEAST, 8.5, "read as what solving takes, to half a power",
        ),
        "the matrix is taken as full",
        Check(
            "convergence", "growth_of_factors", "exponent in n, full matrix", "1",
            full_growth, AT_LEAST, 8.5, "read as what solving takes, to half a power",
        ),
    ),
    unjudged(
        3, "1, first paragraph", "Elements hardly converge where local deformation is large.",
        "work on large strain will judge it: no table follows elements to where they fail",
    ),
    unjudged(
        4, "1, second paragraph", "A smooth kernel gives a liquid of particles a smooth surface.",
        "background: particles without springs are not looked at",
    ),
    Claim(
        5, "1, third paragraph", "Springs act locally and so are computationally cheap.",
        ONLY_IF, "a step costs the same for each node, but steps to rest grow with the body",
        Check(
            "convergence", "growth", "exponent of work to rest in the nodes, in the plane", "1",
            work_growth, AT_MOST, 1.1, "cheap if it grows as the nodes do; a tenth for small sizes",
        ),
        "a step is counted, not the way to rest",
        Check(
            "cost", "limits", "operations a node and step, largest lattice over smallest", "1",
            operations_growth, AT_MOST, 1.1, "none but what the edges save: few parts in a hundred",
        ),
    ),
    unjudged(
        6, "1, third paragraph", "Springs can be simulated in real time.",
        "it depends on the machine: study cost tells how many points, and the baseline holds "
        "no times",
    ),
    unjudged(
        10, "2, second paragraph", "The network of balls is like a neural network.",
        "background: a likeness that makes no number",
    ),
    Claim(
        11, "2, third paragraph", "Time to settle is constant, so the whole costs O(nodes).",
        FAILS, "steps go as the square root of the condition: nodes^(1/2) in the plane",
        Check(
            "convergence", "growth", "exponent of steps to rest in the nodes, in the plane", "1",
            steps_growth, AT_MOST, 0.1, "constant if it does not grow; a tenth for small sizes",
        ),
    ),
    unjudged(
        65, "1, third paragraph", "Others simulate heart valves and surgery with springs.",
        "background: work of others that is cited",
    ),
)  # fmt: skip
