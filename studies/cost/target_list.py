"""The targets, each with how it is read from the tables."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any, Literal, NamedTuple

from msvalidate import kit

from .readings import (
    Measured,
    beside_steps,
    elements,
    growth_at_rest,
    largest,
    network_over,
    newton_growth,
    newton_over_elements,
    ours_over,
    seconds_at_rest,
    share,
    speed_up,
)


class Target(NamedTuple):
    """What is wanted, and what finds it in the tables."""

    words: str
    direction: Literal["at least", "at most"]
    wanted: float
    measure: Callable[[kit.Tables], Measured]


def at_least(words: str, wanted: float, measure: Callable[..., Measured], *given: Any) -> Target:
    """A target for what `measure` reads, given its arguments."""
    return Target(words, "at least", wanted, partial(measure, *given))


def at_most(words: str, wanted: float, measure: Callable[..., Measured], *given: Any) -> Target:
    """The same, where less is better."""
    return Target(words, "at most", wanted, partial(measure, *given))


PLANE, BLOCK, SOLID = (2, 100_000), (3, 30_000), (3, 47_000)
"""Axes and unknowns of bodies of elements."""
TARGETS = (
    *(
        at_least(
            f"LAMMPS over general path, lattice, {nodes:,} points",
            times, ours_over, "general", "LAMMPS", nodes,
        )
        for nodes, times in ((10_000, 3.5), (100_000, 3.5), (1_000_000, 4.0))
    ),
    *(
        at_least(
            f"NumPy bincount over general path, lattice, {nodes:,} points",
            7.0, ours_over, "general", "NumPy bincount", nodes,
        )
        for nodes in (10_000, 100_000)
    ),
    *(
        at_least(
            f"LAMMPS over uniform-lattice path, {nodes:,} points",
            7.0, ours_over, "uniform lattice", "LAMMPS", nodes,
        )
        for nodes in (10_000, 100_000, 1_000_000)
    ),
    at_least(
        "share of memory bandwidth, a step a pass, lattice, 1,000,000 points",
        0.65, share, 1_000_000,
    ),
    at_least(
        "one thread over two, general path, lattice, 100,000 points", 1.6, speed_up, 100_000,
    ),
    at_most(
        "random triangles over lattice, a spring, 100,000 points",
        1.6, network_over, "random triangles", 100_000,
    ),
    at_most(
        "springs with volume energy over springs, lattice, 100,000 points",
        2.0, network_over, "lattice with volume energy", 100_000,
    ),
    at_most(
        "assembly over NGSolve, plane, 1e5 unknowns",
        1.6, elements, *PLANE, "assembly", "ours", "NGSolve",
    ),
    at_most(
        "assembly over NGSolve, solid, 3e4 unknowns",
        2.2, elements, *BLOCK, "assembly", "ours", "NGSolve",
    ),
    at_least(
        "spsolve over solution, plane, 1e5 unknowns",
        4.0, elements, *PLANE, "solution", "spsolve", "ours",
    ),
    at_least(
        "spsolve over solution, solid, 4.7e4 unknowns",
        6.0, elements, *SOLID, "solution", "spsolve", "ours",
    ),
    at_least(
        "spsolve over solution without extras, plane, 1e5 unknowns",
        1.0, elements, *PLANE, "solution", "spsolve", "ours, SuperLU",
    ),
    at_least(
        "spsolve over solution without extras, solid, 4.7e4 unknowns",
        1.0, elements, *SOLID, "solution", "spsolve", "ours, multigrid",
    ),
    at_most(
        "solution over NGSolve sparse Cholesky, plane, 1e5 unknowns",
        0.7, elements, *PLANE, "solution", "ours", "NGSolve",
    ),
    at_most(
        "solution over NGSolve sparse Cholesky, solid, 4.7e4 unknowns",
        0.4, elements, *SOLID, "solution", "ours", "NGSolve",
    ),
    at_most("1e5 points in space at rest (s)", 20.0, seconds_at_rest, "cube", 100_000),
    *(
        at_most(
            f"exponent of seconds to rest, {shape}s, 10,000 to {most:,} points",
            1.2, growth_at_rest, shape, most,
        )
        for shape, most in (("cube", 100_000), ("plate", 300_000))
    ),
    at_most(
        "Newton with multigrid, 1 % strain, over elements, 1,000,000 points",
        4.0, newton_over_elements, 1_000_000,
    ),
    at_most("exponent of its seconds, 10,000 to 1,000,000 points", 1.15, newton_growth),
    *(
        at_most(
            f"best explicit relaxation over its steps x kernel, {nodes:,} points",
            1.3, beside_steps, nodes,
        )
        for nodes in (10_000, 100_000)
    ),
    at_most(
        "path from plain form after 2000 steps, over the displacement",
        1e-12, largest, "agreement", "apart_here",
    ),
    at_most(
        "two threads from one after 2000 steps, over the displacement",
        1e-13, largest, "agreement", "threads_apart_here",
    ),
    at_most(
        "elements by every choice from spsolve, over the displacement",
        1e-9, largest, "fem_agreement", "difference_here",
    ),
)  # fmt: skip
"""In the order in which they are told."""
