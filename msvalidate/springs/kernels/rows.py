"""Values of points as `stencil` wants them: each component an array of its own, in padded rows."""

from __future__ import annotations

import math

import numpy as np

from msvalidate.problem import Array, Index
from msvalidate.springs.kernels.lanes import WIDTH

PAGE, SKEW = 512, 72
"""Components end so many numbers behind a page: places just a page apart evict each other."""


def aligned(*shape: int) -> Array:
    """An array, of any content, that begins where a line of the cache does.

    Elsewhere every second of the values that `lanes` load would have a part in two lines.
    """
    size = math.prod(shape)
    raw = np.empty(size + 8)
    first = -raw.ctypes.data // 8 % 8
    return raw[first : first + size].reshape(shape)


def in_rows(values: tuple[Array, ...], order: Index, columns: int, pitch: int) -> Array:
    """Components (c, size) of values (n, d) or (n,) in rows of `columns`, each padded to `pitch`.

    Place i has the values of point `order[i]`, or i where `order` is empty. Padding is 0, and there
    is some behind the last row too.
    """
    tables = [value if value.ndim == 2 else value[:, None] for value in values]
    whole = len(values[0]) // columns * pitch + WIDTH
    fields = aligned(sum(table.shape[1] for table in tables), -(-whole // PAGE) * PAGE + SKEW)
    rows, behind = _rows(fields, len(values[0]), columns, pitch)
    rows[:, :, columns:] = 0.0
    behind[:] = 0.0
    first = 0
    for table in tables:
        d = table.shape[1]
        places = table[order] if len(order) else table
        rows[first : first + d, :, :columns] = places.reshape(-1, columns, d).transpose(2, 0, 1)
        first += d
    return fields


def out_of_rows(
    fields: Array, values: tuple[Array, ...], order: Index, columns: int, pitch: int
) -> None:
    """Put the first components of `fields` back into values (n, d)."""
    rows, _ = _rows(fields, len(values[0]), columns, pitch)
    at: Index | slice = order if len(order) else slice(None)
    first = 0
    for value in values:
        d = value.shape[1]
        value[at] = rows[first : first + d, :, :columns].transpose(1, 2, 0).reshape(-1, d)
        first += d


def _rows(fields: Array, places: int, columns: int, pitch: int) -> tuple[Array, Array]:
    """Views of `fields`: their rows (c, rows, pitch), and what is behind the last."""
    end = places // columns * pitch
    return fields[:, :end].reshape(len(fields), -1, pitch), fields[:, end:]
