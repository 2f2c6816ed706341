"""Layouts: what they promise the sweep, and parts of them against layouts of their own."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from msvalidate.springs.network.layout import BLOCK, TOGETHER, make_layout

examples = settings(max_examples=40, deadline=None)


@st.composite
def bodies(draw, *, near=False):
    """Points, axes, springs, k, L0 and cells: any pairs, or `near` ones, whose numbers are kept."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    n, m = draw(st.integers(2, 400)), draw(st.integers(1, 900))
    # An eighth of all points is far less than the layers of a cube that numbers may stay within.
    most = max(1, n // 8) if near else n - 1
    first = rng.integers(0, n - 1, m)
    second = np.minimum(first + rng.integers(1, most + 1, m), n - 1)
    turned = rng.random(m) < 0.5
    springs = np.where(turned[:, None], np.stack([second, first], 1), np.stack([first, second], 1))
    corners = draw(st.sampled_from([3, 4, 8]))
    cells = np.zeros((0, 1), dtype=np.intp)
    if n > corners:
        base = rng.integers(0, n - corners, draw(st.integers(0, 200)))
        cells = base[:, None] + rng.permuted(np.tile(np.arange(corners), (len(base), 1)), axis=1)
    return n, 3 if near else 2, springs, rng.uniform(1, 2, m), rng.uniform(1, 2, m), cells


def held_by(layout):
    """Springs of stiffness as rows (owner, other end, k, k·L0), sorted."""
    rows = np.stack([layout.owner.repeat(2), layout.other, layout.stiffness, layout.tension], 1)
    rows = rows[layout.stiffness > 0]
    return rows[np.lexsort(rows.T[::-1])]


@examples
@given(body=bodies())
def test_every_spring_is_there_once_with_its_earlier_point(body):
    n, _, springs, k, tension, cells = body
    layout = make_layout(*body)
    assert layout.points == n
    np.testing.assert_array_equal(np.sort(layout.place), np.arange(n))
    ends = np.sort(layout.place[springs], axis=1)
    expected = np.column_stack([ends, k, tension])
    np.testing.assert_array_equal(held_by(layout), expected[np.lexsort(expected.T[::-1])])
    filled = layout.stiffness == 0
    assert (layout.other[filled] == n).all()
    assert not layout.tension[filled].any()
    assert (layout.owner.repeat(2) < layout.other).all()
    # Two to a point, four to a block: what the sweep computes together.
    np.testing.assert_array_equal(layout.owner, np.arange(n).repeat(np.diff(layout.first) // 2))
    assert not (layout.first % 2).any()
    assert not (layout.first[::BLOCK] % TOGETHER).any()
    assert layout.first[-1] % TOGETHER == 0
    np.testing.assert_array_equal(layout.cells, layout.place[cells[layout.cell_order]])
    reach = np.ptp(layout.cells, axis=1).max(initial=0) if len(cells) else 0
    assert layout.span == max(np.diff(ends, axis=1).max(), reach)


@examples
@given(body=bodies())
def test_cells_stand_with_the_block_of_their_first_place(body):
    layout = make_layout(*body)
    block = np.searchsorted(layout.first_cell, np.arange(len(layout.cells)), side="right") - 1
    np.testing.assert_array_equal(block, layout.cells.min(axis=1) // BLOCK)
    assert layout.first_cell[-1] == len(layout.cells)
    assert len(layout.first_cell) == -(-layout.points // BLOCK) + 1


@examples
@given(body=bodies(near=True), cut=st.tuples(st.integers(0, 6), st.integers(1, 7)))
def test_a_part_is_the_layout_of_what_joins_its_places(body, cut):
    """Against one made of these points, springs and cells alone, as they are numbered."""
    n, dim, springs, k, tension, cells = body
    whole = make_layout(*body)
    begin, end = BLOCK * cut[0], min(n, BLOCK * (cut[0] + cut[1]))
    inside = ((whole.place[springs] >= begin) & (whole.place[springs] < end)).all(axis=1)
    if begin >= end or not inside.any():
        return
    part = whole.part(begin, end)
    kept = ((whole.place[cells] >= begin) & (whole.place[cells] < end)).all(axis=1)
    few = whole.place[springs[inside]] - begin, k[inside], tension[inside]
    alone = make_layout(end - begin, dim, *few, whole.place[cells[kept]] - begin)
    np.testing.assert_array_equal(part.order, np.argsort(whole.place)[begin:end])
    assert part.points == end - begin
    if not len(alone.order):  # else it found an order of its own, and has the same in that
        np.testing.assert_array_equal(held_by(part), held_by(alone))
        np.testing.assert_array_equal(part.cells, alone.cells)
        np.testing.assert_array_equal(part.first_cell, alone.first_cell)
    # The numbers of its cells are those of the whole.
    np.testing.assert_array_equal(part.cells, whole.place[cells[part.cell_order]] - begin)
    np.testing.assert_array_equal(np.sort(part.cell_order), np.flatnonzero(kept))
    # What the sweep asks of any layout.
    assert part.first[0] == 0
    assert not (part.first % 2).any()
    assert not (part.first[::BLOCK] % TOGETHER).any()
    filled = part.stiffness == 0
    assert (part.other[filled] == part.points).all()
    assert part.other.max(initial=0) <= part.points


def test_numbers_at_random_are_replaced_and_near_ones_kept():
    side = 30
    number = np.arange(side**2).reshape(side, side)
    springs = np.concatenate(
        [
            np.column_stack([number[:, 1:].ravel(), number[:, :-1].ravel()]),
            np.column_stack([number[1:].ravel(), number[:-1].ravel()]),
        ]
    )
    ones, none = np.ones(len(springs)), np.zeros((0, 1), dtype=np.intp)
    kept = make_layout(side**2, 2, springs, ones, ones, none)
    assert not len(kept.order)
    assert kept.span == side
    renamed = np.random.default_rng(0).permutation(side**2)
    mended = make_layout(side**2, 2, renamed[springs], ones, ones, none)
    # Levels of Cuthill and McKee's ordering are diagonals, of at most `side` points.
    assert mended.span <= 2 * side
    assert np.abs(np.subtract(*mended.place[renamed[springs]].T)).mean() == pytest.approx(
        side, rel=0.5
    )
