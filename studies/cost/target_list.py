"""The targets, each with how it is read from the tables."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any, Literal, NamedTuple

from msvalidate.judging.evidence import Tables

from .readings import (
    Measured,
    beside_steps,
    elements,
    from_peer,
    growth_at_rest,
    largest,
    network_over,
    newton_growth,
    newton_over_elements,
    ours_over,
    over_peer,
    seconds_at_rest,
    share,
    speed_up,
    started,
)


class Target(NamedTuple):
    """What is wanted, and what finds it in the tables."""

    words: str
    direction: Literal["at least", "at most"]
    wanted: float
    measure: Callable[[Tables], Measured]


def _kernel_targets() -> list[Target]:
    targets: list[Target] = []

    def add(words: str, wanted: float, measure: Callable[..., Measured], *given: Any) -> None:
        targets.append(Target(words, "at least", wanted, partial(measure, *given)))

    for nodes, times in ((10_000, 3.5), (100_000, 3.5), (1_000_000, 4.0)):
        add(
            f"LAMMPS over general path, lattice, {nodes:,} points",
            times,
            ours_over,
            "general",
            "LAMMPS",
            nodes,
        )
    for nodes in (10_000, 100_000):
        add(
            f"NumPy bincount over general path, lattice, {nodes:,} points",
            7.0,
            ours_over,
            "general",
            "NumPy bincount",
            nodes,
        )
    for nodes in (10_000, 100_000, 1_000_000):
        add(
            f"LAMMPS over uniform-lattice path, {nodes:,} points",
            7.0,
            ours_over,
            "uniform lattice",
            "LAMMPS",
            nodes,
        )
    add(
        "share of memory bandwidth, a step a pass, lattice, 1,000,000 points",
        0.65,
        share,
        1_000_000,
    )
    add("one thread over two, general path, lattice, 100,000 points", 1.6, speed_up, 100_000)
    return targets


def _network_targets() -> list[Target]:
    return [
        Target(words, "at most", wanted, partial(network_over, name, nodes))
        for words, wanted, name, nodes in (
            (
                "random triangles over lattice, a spring, 100,000 points",
                1.6,
                "random triangles",
                100_000,
            ),
            (
                "springs with volume energy over springs, lattice, 100,000 points",
                2.0,
                "lattice with volume energy",
                100_000,
            ),
        )
    ]


def _element_targets() -> list[Target]:
    plane, solid, most = (2, 100_000), (3, 47_000), (3, 30_000)
    rows: list[tuple[str, Literal["at least", "at most"], float, tuple[Any, ...]]] = [
        (
            "assembly over NGSolve, plane, 1e5 unknowns",
            "at most",
            1.6,
            (*plane, "assembly", "ours", "NGSolve"),
        ),
        (
            "assembly over NGSolve, solid, 3e4 unknowns",
            "at most",
            2.2,
            (*most, "assembly", "ours", "NGSolve"),
        ),
        (
            "spsolve over solution, plane, 1e5 unknowns",
            "at least",
            4.0,
            (*plane, "solution", "spsolve", "ours"),
        ),
        (
            "spsolve over solution, solid, 4.7e4 unknowns",
            "at least",
            6.0,
            (*solid, "solution", "spsolve", "ours"),
        ),
        (
            "spsolve over solution without extras, plane, 1e5 unknowns",
            "at least",
            1.0,
            (*plane, "solution", "spsolve", "ours, SuperLU"),
        ),
        (
            "spsolve over solution without extras, solid, 4.7e4 unknowns",
            "at least",
            1.0,
            (*solid, "solution", "spsolve", "ours, multigrid"),
        ),
        (
            "solution over NGSolve sparse Cholesky, plane, 1e5 unknowns",
            "at most",
            0.7,
            (*plane, "solution", "ours", "NGSolve"),
        ),
        (
            "solution over NGSolve sparse Cholesky, solid, 4.7e4 unknowns",
            "at most",
            0.4,
            (*solid, "solution", "ours", "NGSolve"),
        ),
    ]
    return [
        Target(words, way, wanted, partial(elements, *given)) for words, way, wanted, given in rows
    ]


def _solver_targets() -> list[Target]:
    rows: list[tuple[str, float, Callable[[Tables], Measured]]] = [
        ("1e5 points in space at rest (s)", 20.0, partial(seconds_at_rest, "cube", 100_000)),
        (
            "peak memory of 1e5 points in space at rest (GiB)",
            2.0,
            partial(started, "1e5 points in space, GiB"),
        ),
        (
            "exponent of seconds to rest, cubes, 10,000 to 100,000 points",
            1.2,
            partial(growth_at_rest, "cube", 100_000),
        ),
        (
            "exponent of seconds to rest, plates, 10,000 to 300,000 points",
            1.2,
            partial(growth_at_rest, "plate", 300_000),
        ),
        *(
            (
                f"equilibrium over {peer}, cube, {points:,} points",
                1.0,
                partial(over_peer, peer, points),
            )
            for peer, points in (
                ("SciPy spsolve", 2_200),
                ("NGSolve sparse Cholesky", 10_000),
                ("NGSolve CG, multigrid", 36_000),
                ("SciPy cg with Jacobi", 36_000),
            )
        ),
        (
            "work of the load by NGSolve from ours, over it, cube, 10,000 points",
            0.05,
            partial(from_peer, "NGSolve sparse Cholesky", 10_000),
        ),
    ]
    return [Target(words, "at most", wanted, measure) for words, wanted, measure in rows]


def _other_targets() -> list[Target]:
    rows: list[tuple[str, float, Callable[[Tables], Measured]]] = [
        ("peak memory of 3e5 unknowns, solid (GiB)", 4.0, partial(started, "3e5 unknowns, GiB")),
        (
            "Newton with multigrid, 1 % strain, over elements, 1,000,000 points",
            4.0,
            partial(newton_over_elements, 1_000_000),
        ),
        ("exponent of its seconds, 10,000 to 1,000,000 points", 1.15, newton_growth),
        (
            "best explicit relaxation over its steps x kernel, 10,000 points",
            1.3,
            partial(beside_steps, 10_000),
        ),
        (
            "best explicit relaxation over its steps x kernel, 100,000 points",
            1.3,
            partial(beside_steps, 100_000),
        ),
        (
            "path from plain form after 2000 steps, over the displacement",
            1e-12,
            partial(largest, "agreement", "apart_here"),
        ),
        (
            "two threads from one after 2000 steps, over the displacement",
            1e-13,
            partial(largest, "agreement", "threads_apart_here"),
        ),
        (
            "elements by every choice from spsolve, over the displacement",
            1e-9,
            partial(largest, "fem_agreement", "difference_here"),
        ),
        ("--help beyond bare Python (s)", 0.15, partial(started, "--help")),
        ("list beyond bare Python (s)", 0.15, partial(started, "list")),
        ("compilation of a cold first run (s)", 5.0, partial(started, "compilation, first run")),
    ]
    return [Target(words, "at most", wanted, measure) for words, wanted, measure in rows]


TARGETS = (
    *_kernel_targets(),
    *_network_targets(),
    *_element_targets(),
    *_solver_targets(),
    *_other_targets(),
)
"""In the order in which they are told."""
