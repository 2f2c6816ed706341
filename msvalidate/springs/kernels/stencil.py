"""Compiled steps of a uniform lattice: no lists of springs, for every place has the same ones.

Places lie in rows of columns, a row padded to whole `lanes`; each component is an array of its own.
One sweep moves everything by one step, in place. Row by row it computes the springs to the rows
that follow, adds their forces to this row and takes them from those, which are still to come; then
the row's forces are complete, no later row asks where it was, and it moves. So each spring is
computed once and memory is passed over once a step. Rows that a step has left may take the next one
while they are in the cache: several steps run as waves behind each other, as many rows apart as
springs reach, with the same operations for every place. The same steps by lists of springs are in
`sweep`, the plain form of the forces in `msvalidate.springs.network.internal_force`.

A spring joins two columns that are neighbours or the same. It is counted with the lower of them,
so that its forces go to this column or `one_on`.
"""

from __future__ import annotations

from msvalidate.problem import Array, Index
from msvalidate.springs.kernels.compiling import compiled
from msvalidate.springs.kernels.grid import Grid
from msvalidate.springs.kernels.lanes import (
    WIDTH,
    load,
    one_on,
    root_and_quotient,
    spread,
    start,
    store,
    total,
)
from msvalidate.springs.kernels.lanes import where_positive as where
from msvalidate.springs.kernels.rows import aligned, in_rows, out_of_rows
from msvalidate.springs.kernels.values import Axes, Done, Padded, Pointer, Spring

CACHE = 2**18
"""Bytes that waves of steps may hold between them: half of a usual second cache, for one thread."""
Laws = tuple[Index, Array, Array, Array, Index]
"""Rows ahead of each group of springs, laws, vectors at rest, weights, and special blocks."""
Columns = tuple[Pointer[float], int, Pointer[int]]
"""Weights of springs in the columns, where those of a kind begin, and which blocks are special."""
Tables = tuple[int, Pointer[int], Pointer[float], Pointer[float], Pointer[float], Pointer[int]]
"""Number of groups of springs, and where each of the `Laws` begins."""


def advance(
    grid: Grid,
    u: Array,
    v: Array,
    keep: Array,
    push: Array,
    dt: float,
    steps: int,
    kinetic: float,
    to_peak: bool,
) -> tuple[int, float, bool]:
    """Advance u (m) and v (m/s), both (n, d) in the network's numbering, in place.

    As `Motion.advance`, but that v must be 0 where points are held.
    """
    d, reach, pitch = u.shape[1], int(grid.ahead[-1]), grid.pitch
    places = grid.order, grid.shape[-1], pitch
    moving = in_rows((u, v, push, keep), *places)
    row = 8 * pitch * (len(moving) + len(grid.still))
    waves = 1 if to_peak else max(1, min(steps, CACHE // (row * reach)))
    force = aligned(waves * (reach + 1) * d * pitch)
    force[:] = 0.0
    done, energy, fell = _advance(
        tuple(range(d)),
        moving,
        grid.still,
        pitch,
        (grid.ahead, grid.law, grid.vector, grid.weight, grid.special),
        force,
        waves,
        dt,
        steps,
        kinetic,
        to_peak,
    )
    out_of_rows(moving, (u, v), *places)
    return int(done), float(energy), bool(fell)


def bytes_a_step(grid: Grid) -> int:
    """Bytes that pass between memory and processor in a step, where no cache holds them."""
    d, size = len(grid.shape), grid.still.shape[1]
    # Displacement and velocity come and go; keep and push come, and what stands still.
    return int(8 * size * (2 * 2 * d + 2) + grid.still.nbytes + grid.law.nbytes)


@compiled(inner=True)
def _at(axes: Axes, values: Pointer[float], apart: int, index: int) -> Padded:
    """Components of a vector, of which in the plane the third is not used."""
    x, y = load(values, index), load(values, index + apart)
    return x, y, load(values, index + 2 * apart) if len(axes) == 3 else x


@compiled(inner=True)
def _put(axes: Axes, values: Pointer[float], apart: int, index: int, vector: Padded) -> None:
    store(values, index, vector[0])
    store(values, index + apart, vector[1])
    if len(axes) == 3:
        store(values, index + 2 * apart, vector[2])


@compiled(inner=True)
def _plus(a: Padded, b: Padded) -> Padded:
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@compiled(inner=True)
def _one_on(before: Padded, now: Padded) -> Padded:
    return one_on(before[0], now[0]), one_on(before[1], now[1]), one_on(before[2], now[2])


@compiled(inner=True)
def _law(axes: Axes, law: Pointer[float], vector: Pointer[float], first: int, kind: int) -> Spring:
    """A spring's k and k·L0, and its vector at rest."""
    at, k = len(axes) * kind, 2 * (first + kind)
    z = vector[at + 2] if len(axes) == 3 else 0.0
    return law[k], law[k + 1], vector[at], vector[at + 1], z


@compiled(inner=True)
def _pull(
    axes: Axes, law: Spring, a: Padded, b: Padded, special: bool, weight: tuple[Pointer[float], int]
) -> Padded:
    """Force on `a` of the springs from there to `b`, which are displacements of their ends.

    In `special` columns each counts by its weight, and beyond the lattice is nothing, whatever the
    padding there says.
    """
    k, tension, X, Y, Z = law
    x, y = X + (b[0] - a[0]), Y + (b[1] - a[1])
    z, square = x, x * x + y * y
    if len(axes) == 3:
        z = Z + (b[2] - a[2])
        square = square + z * z
    pull = k - root_and_quotient(spread(tension), square)[1]
    if special:
        share = load(weight[0], weight[1])
        pull = where(share, share * pull, spread(0.0))
    return pull * x, pull * y, pull * z


@compiled()
def _between(
    axes: Axes,
    u: Pointer[float],
    size: int,
    f: Pointer[float],
    pitch: int,
    rows: tuple[int, int, int, int],
    laws: tuple[Spring, Spring, Spring],
    columns: Columns,
) -> None:
    """Add the forces of the springs between two rows, which lean back, stand or lean forward."""
    here, there, own, other = rows
    back, up, on = laws
    weight, first, special = columns
    zero = spread(0.0)
    nothing = (zero, zero, zero)
    last_mine = last_its = nothing
    for block in range(pitch // WIDTH):
        c = block * WIDTH
        edge = special[block] != 0
        a, b = _at(axes, u, size, here + c), _at(axes, u, size, there + c)
        mine, mine_on, its, its_on = nothing, nothing, nothing, nothing
        if up[0] != 0:
            mine = its = _pull(axes, up, a, b, edge, (weight, first + pitch + c))
        if on[0] != 0:
            end = _at(axes, u, size, there + c + 1)
            its_on = _pull(axes, on, a, end, edge, (weight, first + 2 * pitch + c))
            mine = _plus(mine, its_on)
        if back[0] != 0:
            end = _at(axes, u, size, here + c + 1)
            mine_on = _pull(axes, back, end, b, edge, (weight, first + c))
            its = _plus(its, mine_on)
        mine = _plus(mine, _one_on(last_mine, mine_on))
        its = _plus(its, _one_on(last_its, its_on))
        last_mine, last_its = mine_on, its_on
        _put(axes, f, pitch, own + c, _plus(_at(axes, f, pitch, own + c), mine))
        x, y, z = _at(axes, f, pitch, other + c)
        _put(axes, f, pitch, other + c, (x - its[0], y - its[1], z - its[2]))


@compiled()
def _move(
    axes: Axes,
    u: Pointer[float],
    size: int,
    still: Pointer[float],
    f: Pointer[float],
    pitch: int,
    rows: tuple[int, int],
    law: Spring,
    columns: Columns,
    dt: float,
    watched: bool,
) -> float:
    """Add the forces of a row's own springs and move it; return Σ m v², where `watched`."""
    here, own = rows
    weight, first, special = columns
    d, zero = len(axes), spread(0.0)
    last, twice = (zero, zero, zero), zero
    for block in range(pitch // WIDTH):
        c = block * WIDTH
        at = here + c
        a, force = _at(axes, u, size, at), _at(axes, f, pitch, own + c)
        _put(axes, f, pitch, own + c, (zero, zero, zero))  # for the row that comes here next
        force = _plus(force, _at(axes, still, size, at))
        if law[0] != 0:
            on = _at(axes, u, size, at + 1)
            on = _pull(axes, law, a, on, special[block] != 0, (weight, first + c))
            less = _one_on(last, on)
            last = on
            force = _plus(force, (on[0] - less[0], on[1] - less[1], on[2] - less[2]))
        v, mobility = _at(axes, u, size, at + d * size), _at(axes, still, size, at + d * size)
        push, keep = load(u, at + 2 * d * size), load(u, at + (2 * d + 1) * size)
        x = keep * v[0] + (push * mobility[0]) * force[0]
        y = keep * v[1] + (push * mobility[1]) * force[1]
        z = keep * v[2] + (push * mobility[2]) * force[2]
        _put(axes, u, size, at + d * size, (x, y, z))
        _put(axes, u, size, at, (a[0] + dt * x, a[1] + dt * y, a[2] + dt * z))
        if watched:
            square = x * x + y * y
            if d == 3:
                square = square + z * z
            twice = twice + load(still, at + 2 * d * size) * square
    return total(twice)


@compiled(inner=True)
def _row(
    axes: Axes,
    u: Pointer[float],
    size: int,
    still: Pointer[float],
    f: Pointer[float],
    pitch: int,
    tables: Tables,
    ring: int,
    row: int,
    dt: float,
    watched: bool,
) -> float:
    """All that a step does at a row."""
    groups, ahead, law, vector, weight, special = tables
    slots, long, first = ahead[groups - 1] + 1, len(axes) * pitch, 3 * groups * row
    here, own = row * pitch, ring + row % slots * long
    for group in range(1, groups):
        kind = 3 * group
        back = _law(axes, law, vector, first, kind)
        up, on = _law(axes, law, vector, first, kind + 1), _law(axes, law, vector, first, kind + 2)
        if back[0] != 0 or up[0] != 0 or on[0] != 0:  # none is there where the lattice ends
            there = row + ahead[group]
            rows = here, there * pitch, own, ring + there % slots * long
            columns = weight, kind * pitch, special
            _between(axes, u, size, f, pitch, rows, (back, up, on), columns)
    own_law = _law(axes, law, vector, first, 2)
    columns = weight, 2 * pitch, special
    return _move(axes, u, size, still, f, pitch, (here, own), own_law, columns, dt, watched)


@compiled()
def _advance(
    axes: Axes,
    moving: Array,
    still: Array,
    pitch: int,
    laws: Laws,
    force: Array,
    waves: int,
    dt: float,
    steps: int,
    kinetic: float,
    to_peak: bool,
) -> Done:
    """Steps done, kinetic energy of the last, and whether it ended there because that fell."""
    ahead, law, vector, weight, special = laws
    reach, rows, size = ahead[-1], len(law), moving.shape[1]
    ring = (reach + 1) * len(axes) * pitch
    u, fixed, f = start(moving), start(still), start(force)
    begun = start(ahead), start(law), start(vector), start(weight), start(special)
    tables = (len(ahead), *begun)
    done = 0
    while done < steps:
        together = min(waves, steps - done)
        done += together
        twice = 0.0
        for front in range(rows + (together - 1) * reach):
            for wave in range(together):
                row, at = front - wave * reach, wave * ring
                if 0 <= row < rows:
                    watched = to_peak or (done == steps and wave == together - 1)
                    twice += _row(axes, u, size, fixed, f, pitch, tables, at, row, dt, watched)
        if to_peak and 0.5 * twice < kinetic:
            return done, 0.5 * twice, True
        kinetic = 0.5 * twice
    return done, kinetic, False
