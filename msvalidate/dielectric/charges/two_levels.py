"""Nearly the inverse of the equations of very many segments, for GMRES to start from.

Within patches of neighbouring segments charges are solved for exactly, those of each electrode
adding up to nothing there: what is left of their potentials falls off like a dipole's. Among each
other, patches have one unknown an electrode: its charge, spread as it would be in the patch alone.
The two are added up: an additive Schwarz method.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import lu_factor, lu_solve
from scipy.sparse import csr_array

from msvalidate.dielectric.charges.moments import Complex
from msvalidate.dielectric.kernels import charges as integrals
from msvalidate.problem import Array, Index
from msvalidate.problem.records import dataclass

PATCH = 64
"""Most segments of a patch."""
SAMPLES = 8
"""Places on which the charge of a patch stands as other patches see it."""
ROWS = 1000
"""Places whose distances from all others are in memory at once."""


@dataclass(frozen=True, eq=False)
class Patch:
    """Neighbouring segments, of one electrode or several.

    Parameters
    ----------
    segments
        (n,) their numbers.
    inside
        (n, n) charges at potentials, those of an electrode adding up to nothing.
    spread
        (n, k) how a unit charge of each electrode lies here alone.
    own
        (k, k) potentials that these have of each other.
    places, held
        For each electrode, where groups of its segments lie, as complex numbers, and the part of
        its unit charge on each.
    """

    segments: Index
    inside: Array
    spread: Array
    own: Array
    places: tuple[Complex, ...]
    held: tuple[Array, ...]


class TwoLevels:
    """Charges and constant (m + 1,), nearly, of potentials and a sum of charges (m + 1,).

    Parameters
    ----------
    start, along
        (m,) of the segments, complex.
    electrode
        (m,) which each belongs to.
    unit
        Logarithm of the length at whose distance potentials are zero.
    """

    def __init__(self, start: Complex, along: Complex, electrode: Index, unit: float) -> None:
        m = len(start)
        patches = [
            _patch(segments, start[segments], along[segments], electrode[segments], unit)
            for segments in _bisect_segments(start + 0.5 * along)
        ]
        self._at = np.full((len(patches), PATCH), m)  # m: room that is not used
        self._inside = np.zeros((len(patches), PATCH, PATCH))
        for patch, at, inside in zip(patches, self._at, self._inside, strict=True):
            n = len(patch.segments)
            at[:n], inside[:n, :n] = patch.segments, patch.inside
        self._spread = _block_diagonal(patches, m)
        self._totals = lu_factor(_pairs_among(patches, unit))

    def __call__(self, x: Array) -> Array:
        """Both levels, added up."""
        charge = np.zeros(len(x))
        potential = np.append(x[:-1], 0.0)[self._at]
        charge[self._at] = (self._inside @ potential[:, :, None])[:, :, 0]
        totals = lu_solve(self._totals, np.append(self._spread.T @ x[:-1], x[-1]))
        charge[:-1] += self._spread @ totals[:-1]
        charge[-1] = totals[-1]
        return charge


def _bisect_segments(middle: Complex) -> list[Index]:
    """Numbers of the segments of each patch: halves of halves, across the longer side."""
    waiting, done = [np.arange(len(middle))], []
    while waiting:
        here = waiting.pop()
        place = middle[here]
        wide = np.ptp(place.real) >= np.ptp(place.imag)
        here = here[np.argsort(place.real if wide else place.imag, kind="stable")]
        if len(here) <= PATCH:
            done.append(here)
        else:
            waiting += np.array_split(here, 2)
    return done


def _patch(segments: Index, start: Complex, along: Complex, electrode: Index, unit: float) -> Patch:
    inverse = np.linalg.inv(unit - integrals.means(start, along))
    members = [np.flatnonzero(electrode == name) for name in np.unique(electrode)]
    among = np.zeros((len(segments), len(members)))
    for column, of_one in zip(among.T, members, strict=True):
        column[of_one] = 1
    even = inverse @ among
    own = np.linalg.inv(among.T @ even)
    spread = even @ own
    groups = [np.array_split(of_one, min(SAMPLES, len(of_one))) for of_one in members]
    middle = start + 0.5 * along
    return Patch(
        segments,
        inverse - spread @ even.T,
        spread,
        np.asarray(own, dtype=float),
        tuple(np.array([middle[group].mean() for group in each]) for each in groups),
        tuple(
            np.array([column[group].sum() for group in each])
            for column, each in zip(spread.T, groups, strict=True)
        ),
    )


def _block_diagonal(patches: list[Patch], m: int) -> csr_array:
    """(m, k) how the unit charges of all patches lie."""
    count = np.cumsum([0, *(len(patch.own) for patch in patches)])
    rows = [np.repeat(patch.segments, len(patch.own)) for patch in patches]
    columns = [
        np.tile(np.arange(k, k + len(patch.own)), len(patch.segments))
        for k, patch in zip(count, patches, strict=False)
    ]
    values = [patch.spread.ravel() for patch in patches]
    index = (np.concatenate(rows), np.concatenate(columns))
    return csr_array((np.concatenate(values), index), shape=(m, count[-1]))


def _pairs_among(patches: list[Patch], unit: float) -> Array:
    """The bordered equations (k + 1, k + 1) of patches' charges."""
    places = [one for patch in patches for one in patch.places]
    held = [one for patch in patches for one in patch.held]
    k, at = len(places), np.concatenate(places)
    index = (np.arange(len(at)), np.repeat(np.arange(k), [len(one) for one in places]))
    sampled = csr_array((np.concatenate(held), index), shape=(len(at), k))
    matrix = np.ones((k + 1, k + 1))
    matrix[k, k] = 0.0
    matrix[:k, :k] = 0.0
    for i in range(0, len(at), ROWS):
        distance = np.abs(at[i : i + ROWS, None] - at)
        distance[distance == 0] = 1.0  # of a place from itself: its patch has better
        matrix[:k, :k] += sampled[i : i + ROWS].T @ ((unit - np.log(distance)) @ sampled)
    first = 0
    for patch in patches:
        own = slice(first, first + len(patch.own))
        matrix[own, own] = patch.own
        first = own.stop
    return matrix
