"""Any network as the compiled sweep takes it: tables of places, and the way there and back."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from functools import cached_property
from itertools import pairwise

import numpy as np

from msvalidate.problem import LONGEST, Array, Index, ProblemError
from msvalidate.springs.kernels import sweep
from msvalidate.springs.kernels.rows import aligned
from msvalidate.springs.kernels.sweep import Form, Limit, Pushing, Springs
from msvalidate.springs.network import Network
from msvalidate.springs.network.breakage import Breakage
from msvalidate.springs.network.ground import Ground
from msvalidate.springs.network.laws.volumes import Volumes
from msvalidate.springs.network.layout import BLOCK, TOGETHER, Layout

CACHE = 2**22
"""Bytes that waves of steps may hold between them: what one core may count on of the last cache."""
INDICES = 2**32
"""Numbers that a table may hold: where they are is told in 32 bits."""
MOST_WAVES = 10
"""Steps behind each other: more win nothing, as memory is passed over once in so many already."""
TWICE = 0.1
"""Largest fraction of the places that threads may move in common.

Threads then meet only once in many steps.
"""


class Sweep:
    """A network, or the part of its places that a layout has, and the tables in which it moves.

    One thread at a time may use it.

    Raises `ProblemError` if there are too many points for the tables.
    """

    def __init__(
        self,
        network: Network,
        layout: Layout | None = None,
        waves: int = MOST_WAVES,
        breakage: Breakage | None = None,
    ) -> None:
        self._breakage = breakage
        network = network if breakage is None else breakage.whole(network)
        self.layout = network.layout if layout is None else layout
        n, d = self.layout.points, network.dim
        self._most_waves = waves
        self._axes, self._half = tuple(range(d)), 2 * d - 2
        if 2 * self._half * (n + 1) > INDICES:
            most = INDICES // (2 * self._half) - 1
            raise ProblemError(f"network: {n} points; take at most {most} in {d} dimensions")
        self._order = order = self.layout.order if len(self.layout.order) else np.arange(n)
        self._rest, self._still = network.points[order], _zeros(n, 2 * self._half)
        with np.errstate(over="ignore", divide="ignore"):  # the motion that it gives is refused
            self._still[:, :d] = np.where(network.fixed[order], 0.0, 1 / network.mass[order, None])
        self._still[:, self._half : self._half + d] = network.force[order]
        self._mass = network.mass[order]
        self._straight = network.law.straight
        self._limit: Limit = ()
        if breakage is not None:
            s = breakage.critical_stretch
            self._slots = self.layout.slots(network.springs)
            self._limit = s / (1 + s), np.zeros(len(self.layout.other))
        owner, other = (
            (2 * self._half * places).astype(np.uint32)
            for places in (self.layout.owner, self.layout.other)
        )
        laws = self._in_turn(self.layout.stiffness, self.layout.tension)
        form: Form = (0,) if self._straight else ()
        self._springs: Springs = self.layout.first, owner, other, laws, form
        self._cells = self._cells_of(network.volumes)
        self.place, self.flow = _zeros(n + 1, 2 * self._half), _zeros(n + 1, 2 * self._half)
        # Where springs that fill up end: they need a length, and no point gets there.
        self.place[n, :d] = 2 * LONGEST
        self._keep, self._push = _zeros(n), _zeros(n)

    def _in_turn(self, *laws: Array) -> Array:
        """Values of springs in the order in which `sweep` computes four of them, law by law."""
        values = aligned(len(laws) * len(laws[0]))
        fours = values.reshape(-1, len(laws), TOGETHER)
        for at, law in enumerate(laws):
            fours[:, at] = law.reshape(-1, TOGETHER)[:, self._turn]
        return values

    @property
    def _turn(self) -> list[int]:
        return [0, 2, 1, 3] if self._half == 2 else [0, 1, 2, 3]

    def _cells_of(self, cells: Volumes | None) -> tuple[Index, Array, Array, Index] | tuple[()]:
        layout = self.layout
        if cells is None or not len(layout.cells):
            return ()
        kappa, rest = cells.stiffness[layout.cell_order], cells.rest_volume[layout.cell_order]
        return 2 * self._half * layout.cells, kappa, rest, layout.first_cell

    @property
    def bytes_a_step(self) -> int:
        """Bytes that pass between memory and processor in a step, where no cache holds them."""
        lists = sum(table.nbytes for table in (*self._springs[:4], *self._cells))
        # Where places are and how they flow comes and goes; the rest comes.
        return int(lists + 4 * self.flow.nbytes + self._still.nbytes + 3 * self._mass.nbytes)

    @cached_property
    def _forces(self) -> Array:
        """Room for the forces of a block's springs."""
        first, n = self.layout.first, self.layout.points
        ends = first[np.minimum(np.arange(-(-n // BLOCK) + 1) * BLOCK, n)]
        return aligned(int(np.diff(ends).max()) * self._half)

    @property
    def _tables(self) -> tuple[Array, Array, Array]:
        return self.place.ravel(), self.flow.ravel(), self._forces

    def _cells_in(self, place: Array, flow: Array) -> Pushing:
        if not self._cells:
            return ()
        corners = tuple(range(self._cells[0].shape[1]))
        return corners, place, place[self._half :], *self._cells, flow

    def enter(self, u: Array, v: Array, keep: Array, push: Array) -> None:
        """Take over displacement, velocity, keep and push of the network's points."""
        tables = self.place, self.flow, self._keep, self._push
        moving = u, v, keep, push
        sweep.enter(self._order, self._rest, self._still, moving, tables, self._half)

    def leave(self, u: Array, v: Array, begin: int = 0, end: int | None = None) -> None:
        """Hand displacement and velocity back, of the places from `begin` to `end`."""
        end = self.layout.points if end is None else end
        tables = self.place, self.flow
        sweep.leave(self._order, tables, (u, v), self._half, begin, end)

    def run(
        self, dt: float, steps: int, kinetic: float = 0.0, to_peak: bool = False
    ) -> tuple[int, float, bool]:
        """Steps done, kinetic energy (J) of the last, whether it ended there as that fell."""
        step = _zeros(4)
        step[2 if self._half == 2 else 0 :] = dt
        place, flow, forces = self._tables
        done, energy, fell = sweep.run(
            self._axes,
            (place, flow, forces),
            self._springs,
            self._limit,
            self._cells_in(place, flow),
            (self._still.ravel(), self._keep, self._push, self._mass),
            step,
            (steps, *self._waves(steps, to_peak)),
            kinetic,
            to_peak,
        )
        return int(done), float(energy), bool(fell)

    def _waves(self, steps: int, to_peak: bool) -> tuple[int, int]:
        """Number of steps that follow each other, and their distance in blocks."""
        piece = max(1, -(-self.layout.span // BLOCK))
        held = piece * BLOCK * self.bytes_a_step / self.layout.points
        waves = 1 if to_peak else max(1, min(self._most_waves, steps, int(CACHE / held) - 1))
        return waves, piece

    def advance(
        self,
        u: Array,
        v: Array,
        keep: Array,
        push: Array,
        dt: float,
        steps: int,
        kinetic: float = 0.0,
        to_peak: bool = False,
        ground: Ground | None = None,
    ) -> tuple[int, float, bool]:
        """As `Motion.advance`, but that v must be 0 where points are held."""
        self.enter(u, v, keep, push)
        if ground is None:
            ended = self.run(dt, steps, kinetic, to_peak)
        else:
            ended = self._run_on(ground, dt, steps, kinetic, to_peak)
        self.leave(u, v)
        if self._breakage is not None:
            self._take_out(self._breakage)
        return ended

    def _take_out(self, breakage: Breakage) -> None:
        """Tell which springs broke in the steps so far, and begin to count anew."""
        lost = self._limit[1]  # type: ignore[misc]  # there is one
        held = lost.reshape(-1, TOGETHER)[:, self._turn].ravel()[self._slots]
        if held.any():
            breakage.lose(held > 0, float(held.sum()))
            lost[:] = 0.0

    def _run_on(
        self, ground: Ground, dt: float, steps: int, kinetic: float, to_peak: bool
    ) -> tuple[int, float, bool]:
        """As `run`, step by step, with the forces of ground springs among the loads of each."""
        at = np.argsort(self._order, kind="stable")[ground.points]
        half, axes = self._half, len(self._axes)
        load, done, fell = self._still[at, half : half + axes], 0, False
        while done < steps and not fell:
            self.flow[at, :axes] = load + ground.push(self.place[at, half : half + axes])
            _, kinetic, fell = self.run(dt, 1, kinetic, to_peak)
            done += 1
        return done, kinetic, fell

    @cached_property
    def _compliance(self) -> Array:
        k = self.layout.stiffness * (2.0 if self._straight else 1.0)  # φ = pull²/4a where straight
        return self._in_turn(np.divide(1.0, k, out=np.zeros_like(k), where=k > 0))

    def force(self, u: Array, out: Array) -> float:
        """Write the force (n, d) in N at displacements (n, d) in m; return the energy (J)."""
        self.enter(u, out, self._keep, self._push)
        place, flow, forces = self._tables
        cells = self._cells_in(place, flow)
        stored = sweep.force(
            self._axes, (place, flow, forces), self._springs, self._compliance, cells
        )
        at = self.layout.order if len(self.layout.order) else slice(None)
        out[at] = self.flow[:-1, : u.shape[1]]
        return float(stored)


class Threads:
    """A network whose places are shared by threads, each with some of its neighbours' beside.

    What is not a thread's own goes wrong from the outside inwards, by the longest spring a step;
    before its own places are reached, it is copied anew. Each place meets the same operations in
    the same order as in one thread.
    """

    def __init__(self, network: Network, threads: int, waves: int = MOST_WAVES) -> None:
        layout, n = network.layout, len(network.points)
        each = -(-n // threads // BLOCK) * BLOCK
        self._own = list(pairwise([*range(0, n, each), n]))
        reach = max(layout.span, 1)
        self.between = max(1, min(MOST_WAVES, int(TWICE * each / 2 / reach)))
        beside = -(-self.between * reach // BLOCK) * BLOCK
        self._ends = [(max(0, begin - beside), min(n, end + beside)) for begin, end in self._own]
        self._parts = [Sweep(network, layout.part(*ends), waves) for ends in self._ends]
        self._mass = network.mass

    def advance(
        self, u: Array, v: Array, keep: Array, push: Array, dt: float, steps: int
    ) -> tuple[int, float, bool]:
        """As `Motion.advance`, to no peak, of one step or more; v is 0 where points are held."""
        with ThreadPoolExecutor(len(self._parts)) as pool:
            list(pool.map(lambda part: part.enter(u, v, keep, push), self._parts))
            for done in range(0, steps, self.between):
                now = min(self.between, steps - done)
                list(pool.map(lambda part: part.run(dt, now), self._parts))  # noqa: B023
                self._exchange()
        for part, (first, _), own in zip(self._parts, self._ends, self._own, strict=True):
            part.leave(u, v, own[0] - first, own[1] - first)
        with np.errstate(over="ignore", invalid="ignore"):  # as compiled code, that says nothing
            return steps, 0.5 * float(self._mass @ (v**2).sum(axis=1)), False

    def _exchange(self) -> None:
        """Copy places beside a part from the part whose own they are."""
        whole = list(zip(self._parts, self._ends, self._own, strict=True))
        for part, (first, last), _ in whole:
            for other, (start, _), (begin, end) in whole:
                low, high = max(first, begin), min(last, end)
                if other is not part and low < high:
                    for mine, given in ((part.place, other.place), (part.flow, other.flow)):
                        mine[low - first : high - first] = given[low - start : high - start]


def _zeros(*shape: int) -> Array:
    zeros = aligned(*shape)
    zeros[:] = 0.0
    return zeros
