"""What the candidate is asked: every load case on every model, size and boundary rule."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

from msvalidate import kit
from msvalidate.springs.bodies.lattice_network import lattice_network

from . import load_cases
from .load_cases import CASES
from .models import MODELS, Model, homogenised

WEIGHTS = ("shared", "equal")
"""Boundary rules of the rows: `per_cell` is another lattice inside, not another boundary."""
SIZES = {"square": (5, 10, 20, 40, 80), "triangular": (5, 10, 20, 40, 80)}
QUICK_SIZES = {"square": (5, 10, 20), "triangular": (5, 10)}
"""Spacings on a side of 1 m; 5 are the report's 6 x 6 particles."""
ANSWERS: tuple[kit.Answer, ...] = ("linear", "nonlinear", "relaxed")


@dataclass(frozen=True)
class Block:
    """One network to measure: a case on a model at a fineness."""

    case: str
    model: Model
    fineness: int


@dataclass(frozen=True, eq=False)
class Measurement:
    """Displacements (n, 2) in m of a block by (weights, answer), and its points (n, 2) in m."""

    points: kit.Array
    moves: dict[tuple[str, kit.Answer], kit.Array]


def blocks(setting: kit.Setting) -> list[Block]:
    """All networks of the study."""
    return [Block(c, m, n) for c in CASES for m in MODELS for n in sizes(setting, m.lattice)]


def sizes(setting: kit.Setting, lattice: str) -> tuple[int, ...]:
    """Finenesses of a lattice's bodies, coarsest first."""
    return (QUICK_SIZES if setting.quick else SIZES)[lattice]


def measure_all(
    candidate: kit.DisplacementSolver, setting: kit.Setting
) -> dict[Block, Measurement]:
    """Every block of the study, measured."""
    todo = blocks(setting)
    found = setting.sweep(partial(measure, candidate), todo, "spring networks")
    return dict(zip(todo, found, strict=True))


def measure(candidate: kit.DisplacementSolver, block: Block) -> Measurement:
    """The candidate's answers for a block, under every boundary rule."""
    shape = load_cases.body(block.model.lattice, block.case, block.fineness)
    problem = load_cases.problem(block.case, shape, homogenised(block.model))
    grid = shape.grid()
    moves: dict[tuple[str, kit.Answer], kit.Array] = {}
    for weights in WEIGHTS:
        network = lattice_network(problem, grid, block.model.constants, weights=weights)
        for answer in ANSWERS:
            moves[weights, answer] = candidate(problem, network, answer)
    return Measurement(grid.points, moves)
