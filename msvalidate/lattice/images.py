"""As many images of points as their Voronoi cells need to be complete.

A periodic cell is repeated, a box is reflected across its sides. Only images within a margin are
made; a cell is complete if the empty sphere around each of its vertices, through its points, stays
within that.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.spatial import QhullError

from msvalidate.lattice.triangulation import FACES, triangulation
from msvalidate.problem import Array, Box, Index, ProblemError, SolverError

FIRST_MARGIN, STEP = 2.25, 1.3
"""Margin tried first, in spacings, and the next in parts of it at most. Even sets need about 2;
cells at the end of too small a margin are long and ask for more than they need."""
UNEVEN, UNEVEN_MARGIN = 0.5, {2: 3.0, 3: 2.75}
"""Variance over mean of points in boxes, 1 where they are strewn at random, from which a set is
uneven, and the margin, by axes, tried first then: holes are larger. To try again costs more."""
BOXES = 8
"""Points in a box, about."""
MOST_IMAGES, IMAGES_OF_FEW, IMAGES_OF_EACH = 2_000_000, 15_000, 15
"""Points with their images: at all; and for few points and for each more, of which an even set in
a body not long or flat needs a fifth. Far more lie in a few rows, and take minutes to triangulate.
"""


def triangulate_with_images(
    x: Array, edges: Array, unit: float, *, mirrored: bool
) -> tuple[Array, Index, Index, Index, Index, Array]:
    """Points with as many images as cells need, their source and image number, and simplices.

    Of these, as `_cells`, the corners, those beyond their faces and the circumcentres. What is
    measured is in parts of 1/unit (m).

    Raises
    ------
    ProblemError
        If too many images are needed: the body is long or flat for its points.
    SolverError
        If points lie so close that their cells can't be told apart.
    """
    n, dim = x.shape
    box = Box(tuple((edges / unit).tolist()))
    # No point of the body is further than this from all images of one point.
    furthest = (2 if mirrored else 1) * float(np.linalg.norm(edges)) * (1 + 1e-9)
    spacing = (math.prod(edges.tolist()) / n) ** (1 / dim)
    margin = _first_margin(x, edges) * spacing
    margin = min(max(margin, 0.5 * float(edges.max()) / n), furthest)
    # In a long or flat body, points are as far apart as on its axis or in its plane: what they
    # will need is refused at once.
    longest = np.sort(edges)[::-1].tolist()
    apart = max((math.prod(longest[:k]) / n) ** (1 / k) for k in range(1, dim + 1))
    _refuse_too_many_images(n, box, min(FIRST_MARGIN * apart, furthest) / unit)
    again = True
    while True:
        _refuse_too_many_images(n, box, margin / unit)
        everywhere, source, image = _images(x, edges, margin, mirrored=mirrored)
        try:
            found = _cells(everywhere, source, n, regular=mirrored)
        except SolverError:
            # Two points and their reflections are on one circle: with other images around them
            # the simplex between them may not be flat.
            if not again or margin >= furthest:
                raise
            found, again = None, False
        if found is not None:
            cells, beyond, centres, radius = found
            away = np.maximum(-centres, centres - edges).max(axis=1)
            needed = float((away + radius).max())
            if needed <= margin:
                return everywhere, source, image, cells, beyond, centres
        if margin >= furthest:
            raise SolverError(f"cells of {n} points in {box}: not told apart, some are too close")
        # Cells only shrink as images are added, and their spheres' reach with them.
        step = STEP if found is None else min(STEP, 1.05 * needed / margin)
        margin = min(step * margin, furthest)


def _first_margin(x: Array, edges: Array) -> float:
    """Margin in spacings that points (n, d) will need, by how evenly boxes are filled."""
    dim = x.shape[1]
    across = np.maximum((edges / (math.prod(edges.tolist()) * BOXES / len(x)) ** (1 / dim)), 1)
    shape = tuple(across.astype(np.intp).tolist())
    place = np.minimum((x / edges * shape).astype(np.intp), np.array(shape) - 1)
    filled = np.bincount(np.ravel_multi_index(tuple(place.T), shape), minlength=math.prod(shape))
    return UNEVEN_MARGIN[dim] if filled.var() > UNEVEN * filled.mean() else FIRST_MARGIN


def _images(
    points: Array, size: Array, margin: float, *, mirrored: bool
) -> tuple[Array, Index, Index]:
    """Points and images within a margin, the points first; of each its source and image number.

    Image k of a mirrored axis is shifted by k·size if k is even, and else reflected: at -x for
    k = -1 and 2·size - x for k = 1.
    """
    source = np.arange(len(points))
    image = np.zeros(points.shape, dtype=np.intp)
    for axis, edge in enumerate(size.tolist()):
        start = points[:, axis]
        reach = math.ceil(margin / edge) + 1
        parts = []
        for k in sorted(range(-reach, reach + 1), key=abs):
            reflected = mirrored and k % 2 == 1
            place = (k + 1) * edge - start if reflected else start + k * edge
            near = (place >= -margin) & (place <= edge + margin)
            if reflected:  # points on a side are their own image
                near &= (start != 0) & (start != edge)
            elif k == 0:
                near[:] = True
            which = np.flatnonzero(near)
            moved, number = points[which], image[which]
            moved[:, axis], number[:, axis] = place[which], k
            parts.append((moved, source[which], number))
        points, source, image = (np.concatenate(part) for part in zip(*parts, strict=True))
    return points, source, image


def _cells(
    x: Array, source: Index, count: int, *, regular: bool
) -> tuple[Index, Index, Array, Array] | None:
    """Simplices at the first `count` points, those beyond their faces, circumcentres and radii.

    None if the cell of one of these points has no end.
    """
    try:
        cells, beyond = triangulation(x, count, source, regular=regular)
    except QhullError:  # so few images that they lie in a plane
        return None
    near = (cells < count).any(axis=1)
    cells, beyond = cells[near], beyond[near]
    ending = (beyond < 0) & (cells[:, FACES[x.shape[1]]] < count).any(axis=2)
    if ending.any() or not np.bincount(cells.ravel(), minlength=count)[:count].all():
        return None
    number = np.append(np.where(near, np.cumsum(near) - 1, -1), -1)
    start = x[cells[:, 0]]
    sides = x[cells[:, 1:]] - start[:, None]
    to_centre = np.linalg.solve(sides, 0.5 * (sides**2).sum(axis=2, keepdims=True))[:, :, 0]
    radius = np.linalg.norm(to_centre, axis=1)
    return cells, number[beyond], start + to_centre, np.asarray(radius)


def _refuse_too_many_images(count: int, box: Box, margin: float) -> None:
    wanted = count * math.prod(1 + 2 * margin / edge for edge in box.size)
    most = min(MOST_IMAGES, IMAGES_OF_FEW + IMAGES_OF_EACH * count)
    if wanted > most:
        remedy = "fewer points" if most == MOST_IMAGES else "more points, or more even ones"
        raise ProblemError(
            f"cells of {count} points in the {box}, {max(box.size) / min(box.size):.3g} times as "
            f"long as thick: they need {wanted:.3g} images, and the most is {most:.3g}; take "
            f"{remedy}, or a body less long and thin"
        )
