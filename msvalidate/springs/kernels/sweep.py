"""Compiled steps of any network: forces and motion in one pass over memory, in place.

Places come in blocks (`springs.network.layout`). The springs of a block are computed four side by
side into a buffer that stays in the first cache; then each place takes up the forces of its own
springs, hands their opposites to the other ends, which come later, and moves: all forces on it are
known, and no later place asks where it was. Several steps may run as waves behind each other, so
that memory is passed over once for all of them; each place meets the same operations in the same
order.

A place has one row of four numbers in each table in the plane, and two in space: `place` its rest
and displacement, `flow` force and velocity, `still` mobility (1/m, 0 where held) and load. Plain
form: `springs.network.internal_force`, and `springs.dynamics.integrate.motion`.
"""

from __future__ import annotations

from typing import Any

from msvalidate.problem import Array, Index
from msvalidate.springs.kernels.cells import push as push_cells
from msvalidate.springs.kernels.compiling import compiled
from msvalidate.springs.kernels.lanes import (
    any_positive,
    load,
    load_half,
    root_and_quotient,
    spread,
    start,
    store,
    total,
)
from msvalidate.springs.kernels.turning import (
    components,
    crossed,
    first_halves,
    halves_added,
    pairs,
    rows,
)
from msvalidate.springs.kernels.values import Axes, Corners, Done, Lane, Pointer, Small, Vector
from msvalidate.springs.network.layout import BLOCK, TOGETHER

Form = tuple[()] | tuple[int]
"""Form of the law: empty for a pull of a - b/√s.

It has one number for a pull of a·s - b.
"""
Limit = tuple[()] | tuple[float, Array]
"""Empty, or of springs that break: s/(1 + s), s the critical stretch, which the pull over k is not
to exceed, and where the energy goes that they had then, in the order of the laws."""
Springs = tuple[Index, Small, Small, Array, Form]
"""First spring of each place, where its owner and its other end are in the tables, and laws."""
Ends = tuple[()] | tuple[float, Any]
Lists = tuple[Pointer[int], Pointer[int], Pointer[int], Pointer[float], Form, Pointer[float] | None]
"""Pointers to the lists, the form of the laws, and compliances.

Compliances are present if the energy is requested.
"""
Pushing = tuple[Corners, Array, Array, Index, Array, Array, Index, Array] | tuple[()]
"""Cells: k, places at rest, displacements, where corners are in these, κ, volumes at rest, first
cells of the blocks, and the flow that takes the forces; empty where there are none."""


@compiled(inner=True)
def _apart(axes: Axes, place: Pointer[float], i: int, j: int) -> Lane:
    """Vector from place i to place j; in the plane its two parts, side by side."""
    apart = load(place, j) - load(place, i)
    if len(axes) == 3:
        apart = apart + (load(place, j + 4) - load(place, i + 4))
    return apart


@compiled(inner=True)
def _vectors(
    axes: Axes, place: Pointer[float], owner: Pointer[int], other: Pointer[int], e: int
) -> Vector:
    """Components of the vectors of four springs from e on."""
    i, j = owner[e >> 1], owner[(e >> 1) + 1]
    a = _apart(axes, place, i, other[e])
    b = _apart(axes, place, i, other[e + 1])
    c = _apart(axes, place, j, other[e + 2])
    d = _apart(axes, place, j, other[e + 3])
    if len(axes) == 3:
        return components(a, b, c, d)
    x, y = halves_added(a, c, b, d)  # the order of the laws, from which `pairs` come in turn
    return x, y, y


@compiled(inner=True)
def _break(laws: Any, energy: Any, looked: Pointer[float], e: int, at: int) -> None:
    """Take out of four springs from e on those that are beyond; what is looked at lies at `at`."""
    for i in range(TOGETHER):
        if looked[at + i] > 0:
            energy[e + i] = looked[at + TOGETHER + i] / laws[2 * e + i]
            laws[2 * e + i] = laws[2 * e + TOGETHER + i] = 0.0


@compiled(fused=True, inner=True)
def _pull(
    axes: Axes,
    place: Pointer[float],
    springs: tuple[Pointer[int], Pointer[int], Pointer[float], Form, Pointer[float] | None],
    limit: Ends,
    e: int,
    end: int,
    forces: Pointer[float],
) -> float:
    """Put the forces of springs on their owners one after the other; return twice their energy."""
    owner, other, laws, form, compliance = springs
    at, stored = 0, spread(0.0)
    while e < end:
        x, y, z = _vectors(axes, place, owner, other, e)
        square = x * x + y * y
        if len(axes) == 3:
            square = square + z * z
        if len(form):
            force = pull = load(laws, 2 * e) * square - load(laws, 2 * e + 4)
        else:
            length, share = root_and_quotient(load(laws, 2 * e + 4), square)
            pull = load(laws, 2 * e) - share
            if len(limit):
                beyond = pull - limit[0] * load(laws, 2 * e)  # type: ignore[misc]  # some
                if any_positive(beyond):
                    store(forces, at, beyond)
                    store(forces, at + TOGETHER, 0.5 * pull * pull * square)
                    _break(laws, limit[1], forces, e, at)  # type: ignore[misc]  # some
                    continue
            force = pull * length
        if compliance is not None:
            stored = stored + load(compliance, e) * (force * force)
        if len(axes) == 3:
            a, b, c, d = rows(pull * x, pull * y, pull * z, spread(0.0))
            store(forces, at + 8, c)
            store(forces, at + 12, d)
        else:
            a, b = pairs(pull * x, pull * y)
        store(forces, at, a)
        store(forces, at + 4, b)
        e += TOGETHER
        at += TOGETHER * (2 * len(axes) - 2)
    return total(stored)


@compiled(inner=True)
def _force_of(axes: Axes, forces: Pointer[float], spring: int) -> Lane:
    return load(forces, 4 * spring) if len(axes) == 3 else load_half(forces, 2 * spring)


@compiled(inner=True)
def _gathered(
    axes: Axes,
    flow: Pointer[float],
    other: Pointer[int],
    forces: Pointer[float],
    mine: tuple[int, int, int],
    i: int,
) -> Lane:
    """Force on place i, from earlier ones and its own springs, whose other ends get the opposite.

    `mine` is the first of its springs, the one behind the last, and the block's first.
    """
    force = load(flow, i)
    e, end, begin = mine
    while e < end:
        first = _force_of(axes, forces, e - begin)
        second = _force_of(axes, forces, e - begin + 1)
        j, k = other[e], other[e + 1]
        store(flow, j, load(flow, j) - first)
        store(flow, k, load(flow, k) - second)
        force = force + (first + second)
        e += 2
    return force


@compiled(fused=True, inner=True)
def _moved(
    axes: Axes,
    place: Pointer[float],
    flow: Pointer[float],
    point: tuple[Pointer[float], float, float, float],
    i: int,
    force: Lane,
    dt: float,
) -> Lane:
    """Move place i under a force; m·v² of it in lanes, in the plane twice."""
    still, keep, push, mass = point
    own = load(still, i)
    if len(axes) == 3:
        v = keep * load(flow, i + 4) + (push * own) * force
        store(flow, i, load(still, i + 4))
        store(flow, i + 4, v)
        store(place, i + 4, load(place, i + 4) + dt * v)
    else:
        parts = first_halves(push * own, spread(keep)) * force  # the velocity beside the force
        v = parts + crossed(parts, parts)
        store(flow, i, crossed(own, v))
        store(place, i, load(place, i) + dt * v)
    return mass * (v * v)


@compiled(fused=True, inner=True)
def _block(
    axes: Axes,
    tables: tuple[Pointer[float], Pointer[float], Pointer[float]],
    springs: Lists,
    limit: Ends,
    cells: Pushing,
    points: tuple[int, Pointer[float], Pointer[float], Pointer[float], Pointer[float]],
    dt: float,
    b: int,
) -> float:
    """Move the places of block b by one step; twice their kinetic energy."""
    place, flow, forces = tables
    n, still, keep, push, mass = points
    first, other, wide = springs[0], springs[2], 4 * (len(axes) - 1)
    i, last = b * BLOCK, min(n, (b + 1) * BLOCK)
    begin = first[i]
    _pull(axes, place, springs[1:], limit, begin, first[last], forces)
    _push(axes, cells, b)
    twice = spread(0.0)
    while i < last:
        mine = first[i], first[i + 1], begin
        force = _gathered(axes, flow, other, forces, mine, i * wide)
        point = still, keep[i], push[i], mass[i]
        twice = twice + _moved(axes, place, flow, point, i * wide, force, dt)
        i += 1
    return total(twice) / (4 - len(axes))


@compiled(inner=True)
def _push(axes: Axes, cells: Pushing, b: int) -> float:
    """Add the forces of a block's cells to the flow; return their energy."""
    stored = 0.0
    if len(cells):
        corners, rest, displacement, lists, kappa, volume, first, flow = cells  # type: ignore[misc]  # some
        stored = push_cells(
            axes, corners, rest, displacement, lists, kappa, volume, first[b], first[b + 1], flow
        )
    return stored


@compiled(inner=True)
def _starts(
    springs: Springs,
) -> tuple[Pointer[int], Pointer[int], Pointer[int], Pointer[float], Form]:
    first, owner, other, laws, form = springs
    return start(first), start(owner), start(other), start(laws), form


@compiled(inner=True)
def _ends(limit: Limit) -> Ends:
    if len(limit):
        return limit[0], start(limit[1])  # type: ignore[misc]  # some
    return ()


@compiled(fused=True)
def run(
    axes: Axes,
    tables: tuple[Array, Array, Array],
    springs: Springs,
    limit: Limit,
    cells: Pushing,
    points: tuple[Array, Array, Array, Array],
    step: Array,
    schedule: tuple[int, int, int],
    kinetic: float,
    to_peak: bool,
) -> Done:
    """Steps done, kinetic energy of the last, and whether it ended there because that fell.

    `schedule` is the number of steps, of waves, and of blocks in a piece, which no spring is longer
    than: a piece may take a step when it and the next one have taken the last.
    """
    steps, waves, piece = schedule
    place, flow, forces = tables
    still, keep, push, mass = points
    blocks = -(-len(mass) // BLOCK)
    pieces = -(-blocks // piece)
    moved = start(place), start(flow), start(forces)
    values = len(mass), start(still), start(keep), start(push), start(mass)
    ends = _ends(limit)
    lists, dt = (*_starts(springs), None), load(start(step), 0)
    done = 0
    while done < steps:
        side = min(waves, steps - done)
        twice = 0.0
        for front in range(pieces + side - 1):
            for wave in range(max(0, front - pieces + 1), min(side, front + 1)):
                begin = (front - wave) * piece
                for b in range(begin, min(begin + piece, blocks)):
                    moving = _block(axes, moved, lists, ends, cells, values, dt, b)
                    if wave == side - 1:
                        twice += moving
        done += side
        if to_peak and 0.5 * twice < kinetic:
            return done, 0.5 * twice, True
        kinetic = 0.5 * twice
    return done, kinetic, False


@compiled(fused=True)
def force(
    axes: Axes,
    tables: tuple[Array, Array, Array],
    springs: Springs,
    compliance: Array,
    cells: Pushing,
) -> float:
    """Put the forces of springs and cells into the flow; return their energy."""
    place, flow, forces = start(tables[0]), start(tables[1]), start(tables[2])
    lists = (*_starts(springs), start(compliance))
    first, n, wide = springs[0], len(springs[0]) - 1, 4 * (len(axes) - 1)
    tables[1][:] = 0.0
    stored = 0.0
    for b in range(-(-n // BLOCK)):
        begin, last = first[b * BLOCK], min(n, (b + 1) * BLOCK)
        stored += 0.5 * _pull(axes, place, lists[1:], (), begin, first[last], forces)
        stored += _push(axes, cells, b)
        for i in range(b * BLOCK, last):
            mine = first[i], first[i + 1], begin
            store(flow, i * wide, _gathered(axes, flow, lists[2], forces, mine, i * wide))
    return stored


@compiled()
def enter(
    order: Index,
    rest: Array,
    still: Array,
    moving: tuple[Array, Array, Array, Array],
    tables: tuple[Array, Array, Array, Array],
    half: int,
) -> None:
    """Put displacement, velocity, keep and push of points where their places are.

    `order` is the point of each place; `tables` are where these four `moving` go.
    """
    u, v, keep, push = moving
    place, flow, kept, pushed = tables
    for i in range(len(kept)):
        point = order[i]
        for a in range(u.shape[1]):
            place[i, a] = rest[i, a]
            place[i, half + a] = u[point, a]
            flow[i, a] = still[i, half + a]
            flow[i, half + a] = v[point, a] if still[i, a] else 0.0
        kept[i], pushed[i] = keep[point], push[point]


@compiled()
def leave(
    order: Index,
    tables: tuple[Array, Array],
    moved: tuple[Array, Array],
    half: int,
    begin: int,
    end: int,
) -> None:
    """Take displacement and velocity of points from the places from `begin` to `end`."""
    u, v = moved
    place, flow = tables
    for i in range(begin, end):
        point = order[i]
        for a in range(u.shape[1]):
            u[point, a] = place[i, half + a]
            v[point, a] = flow[i, half + a]
