"""Masses as a simulator's own motion tells them.

Forces between nodes have no resultant, whatever their law: Σ mᵢ Δvᵢ = 0 in each of the three
directions, in every step from rest. The rows of Δv of many displaced states have thus one vector in
common that they all vanish on: the masses, up to a factor. That factor cannot be seen: a body of
twice the mass and twice the stiffness moves alike, so only E/ρ is ever observed, and the masses are
scaled to the asked total. Where the mass matrix M is not diagonal, its row sums are found.
"""

from __future__ import annotations

import numpy as np

from msvalidate.problem import Array, Index
from msvalidate.problem.records import dataclass
from msvalidate.simulators.exchange.protocol import SimulatorError
from msvalidate.simulators.probe.bench import Bench
from msvalidate.simulators.probe.block import Block
from msvalidate_check.causes import Phrase, phrase

MOVE = 1 / 16
"""Largest random displacement, in heights of the smallest cell: far above rounding, and no cell is
turned inside out. The resultant vanishes at any size."""
SURPLUS = 1.25
"""States beyond the fewest that determine the masses, as a part of these."""
LOOSEST = 0.05
"""Relative error beyond which masses are refused: a node of half another's mass is not told apart
from rounding."""
SAME = 1e-3
"""Masses within this part of a known pattern are of it, or within their own error if that is more:
a fifth of what a reading of the stiffness may be off."""
FEW = 0.1
"""Largest part of the nodes that may be exceptions to a pattern, rather than it none."""
NAMED = 4
"""Exceptions that are named one by one."""
SURE = 4.0
"""Standard deviations within which each of some hundred masses is expected."""
SEED = 7


@dataclass(frozen=True, eq=False)
class Masses:
    """Masses of nodes, measured.

    Parameters
    ----------
    values
        (n,) kg, scaled to the asked total: only their ratios were observed.
    ratio
        (n,) over what is asked, each cell's mass shared among its nodes.
    error
        Largest relative error of one, from how well the rows of Δv agree on one vector: the least
        singular value.
    pattern
        Of `patterns`, whose masses they are; "" if of none.
    exceptions
        Nodes that are not of the pattern.
    times
        (k,) of the first exceptions, what they have of the pattern's mass.
    known
        (n,) kg of the pattern where there are no exceptions; else None. They have no rounding.
    """

    values: Array
    ratio: Array
    error: float
    pattern: str
    exceptions: Index
    known: Array | None = None
    times: tuple[float, ...] = ()

    @property
    def best(self) -> Array:
        """(n,) kg: of the pattern that they agree with, or else as measured."""
        return self.values if self.known is None else self.known

    def on(self, block: Block, total: float) -> Array:
        """Masses (n,) in kg of the pattern on another block.

        They are the shares of its cells if there is no pattern.
        """
        pattern = patterns(block).get(self.pattern, block.lumped)
        return np.asarray(pattern * (total / pattern.sum()))

    @property
    def off(self) -> float:
        """Largest part by which one is not what is asked."""
        return float(np.abs(self.ratio - 1).max())

    @property
    def spread(self) -> Phrase:
        """Range of the masses of nodes relative to the requested ones."""
        return phrase("spread", least=self.ratio.min(), most=self.ratio.max())

    @property
    def words(self) -> Phrase:
        """Whose masses they are."""
        if not self.pattern:
            return phrase("no pattern")
        if not len(self.exceptions):
            return phrase("pattern", name=self.pattern)
        each = [
            f"node {i} {x:.3g} times" for i, x in zip(self.exceptions, self.times, strict=False)
        ]
        count = len(self.exceptions) - len(each)
        more = phrase("more nodes", count=count) if count else Phrase("")
        return phrase("pattern but", name=self.pattern, nodes=", ".join(each), more=more)

    @property
    def line(self) -> Phrase:
        """Summary of the masses in one line."""
        spread = phrase("spread besides", spread=self.spread) if self.off > SAME else Phrase("")
        return phrase("mass line", pattern=self.words, spread=spread, error=self.error)


def measure_masses(bench: Bench) -> Masses:
    """Masses from steps after small random displacements.

    Raises
    ------
    SimulatorError
        If the body does not move, two vectors fit equally (parts that pull at nobody), some come
        out negative, or they are not known to `LOOSEST`: forces have a resultant then.
    """
    n = len(bench.block.mesh.points)
    rng = np.random.default_rng(SEED)
    block, most = bench.block, MOVE * bench.block.height
    count = int(np.ceil(SURPLUS * n / block.mesh.dim))
    found = []
    for _ in range(count):
        answer = bench.step(rng.uniform(-most, most, (n, block.mesh.dim)))
        if answer.velocity is None:
            raise SimulatorError("masses: forces and no velocity; they say nothing of masses")
        found.append(answer.velocity.T)
    rows = np.concatenate(found)
    largest = np.abs(rows).max()
    if largest == 0:
        raise SimulatorError("masses: no node moved; the step does nothing, or the body no force")
    _, singular, vectors = np.linalg.svd(rows / largest, full_matrices=False)
    total = block.lumped.sum()
    vector = vectors[-1] * np.sign(vectors[-1].sum())
    if vector.min() <= 0:
        raise SimulatorError(
            "masses: no positive masses leave the forces without a resultant; forces from outside, "
            "or damping, act"
        )
    error = _relative_error(singular, vectors, len(rows))
    if error > LOOSEST:
        raise SimulatorError(
            f"masses: known to {error:.2g} only, {LOOSEST:g} is needed; forces have a resultant, "
            "or are too near to rounding: take a longer step or double precision"
        )
    return _recognise(block, vector * total / vector.sum(), error)


def _relative_error(singular: Array, vectors: Array, rows: int) -> float:
    """Largest relative error of the null vector's entries, for `SURE` standard deviations.

    Rounding of the rows by s turns the vector towards the j-th other one by s/σⱼ, which is first
    order perturbation [GolubVanLoan2013]; s is what the least singular value leaves, over
    the rows beyond those that determine the vector.
    """
    if singular[-2] == 0:
        return float("inf")
    rounding = singular[-1] / np.sqrt(rows - len(singular) + 1)
    spread = np.sqrt(((vectors[:-1] / singular[:-1, None]) ** 2).sum(axis=0))
    return float(SURE * rounding * (spread / np.abs(vectors[-1])).max())


def patterns(block: Block) -> dict[str, Array]:
    """Name -> masses (n,) that programs give their nodes; all up to a factor."""
    cells = block.mesh.cells
    n = len(block.mesh.points)
    counted = np.bincount(cells.ravel(), minlength=n).astype(float)
    last = np.zeros(n)
    for cell, volume in zip(cells, block.volumes, strict=True):
        last[cell] = volume
    return {
        "each node's own share": block.lumped,
        "equal masses on all nodes": np.ones(n),
        "a share for each cell at a node, whatever its size": counted,
        "the last cell's mass alone": last,
    }


def _recognise(block: Block, values: Array, error: float) -> Masses:
    """Masses, with the pattern that most nodes are of, and its exceptions."""
    allowed = max(SAME, error)
    fits = []
    for name, pattern in patterns(block).items():
        ratio = values / pattern
        ratio = ratio / np.median(ratio)
        fits.append((np.flatnonzero(np.abs(ratio - 1) > allowed), name, pattern, ratio))
    exceptions, name, pattern, ratio = min(fits, key=lambda fit: len(fit[0]))
    known, times = None, tuple(ratio[exceptions[:NAMED]].tolist())
    if not len(exceptions):
        known = pattern * (values.sum() / pattern.sum())
    elif len(exceptions) > FEW * len(values):
        name, exceptions, times = "", np.arange(len(values)), ()
    return Masses(values, values / block.lumped, error, name, exceptions, known, times)
