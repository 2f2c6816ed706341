"""Inverse of a network's tangent by factorisation or by multigrid.

`linear_algebra.choice` says which. Both notice what has no stiffness, and what has negative
stiffness: by pivots, or by what a random load meets.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from scipy.sparse import bsr_array, csr_array

from msvalidate.linear_algebra import choice
from msvalidate.linear_algebra.choice import BYTES, QUESTIONS, Choice, choose
from msvalidate.linear_algebra.factor import Factor, factorise, inverse_iteration
from msvalidate.linear_algebra.multigrid import Cycle, restrain_in_place
from msvalidate.linear_algebra.order import Dissection, free_unknowns, nested_dissection, pairs_in
from msvalidate.problem import Array, Index, SolverError
from msvalidate.problem.checks import require_one_of
from msvalidate.problem.records import dataclass
from msvalidate.springs.network import Configuration, Network
from msvalidate.springs.network.mechanism import (
    NO_STIFFNESS,
    describe_motion,
    is_certain,
    relative_stiffness,
)
from msvalidate.springs.network.multigrid import (
    PART,
    Cycles,
    NotConvergedError,
    make_cycle,
    refuse_mechanism_motion,
    softest_motion,
)
from msvalidate.springs.network.refine import contraction_bound

SOLVERS = ("auto", "direct", "multigrid")
"""Names of solvers; "auto" takes one of the others."""
SOFT = 1e-7
"""Relative stiffness of the response to a random load that rules out soft modes.

The response consists mostly of the softest mode; above this value the mode need not be computed.
Solid bodies have 1e-5 and more.
"""


@dataclass(frozen=True, eq=False)
class Regular:
    """An inverse of a tangent's free part, and what its softest motion meets.

    `at`: whose tangent. `inverse`: of the free part. `diagonal`: of the free part (f,) in N/m.
    """

    at: Configuration
    inverse: Factor | Cycles
    diagonal: Array

    @property
    def softness(self) -> float:
        """Energy of the softest motion over what its components would cost one by one."""
        return self._softest[0]

    @property
    def mode(self) -> Array:
        """The motion (n·d,) that the tangent resists least."""
        return self._softest[1]

    @property
    def rate(self) -> float:
        """Upper bound of the error after a correction, relative to the error before."""
        own = 0.0 if isinstance(self.inverse, Factor) else PART
        return max(own, contraction_bound(self.softness))

    @property
    def negative(self) -> int:
        """Number of negative eigenvalues, or 1 where there are some and nobody counted."""
        return self.inverse.negative

    @cached_property
    def _softest(self) -> tuple[float, Array]:
        found, weight = self.inverse, np.abs(self.diagonal)
        if isinstance(found, Factor):
            return self._judged(inverse_iteration(found.solve, len(weight), weight))
        way, _, told = found.probed
        _refuse_unsettled(told)
        soft, mode = self._judged(way)
        if 0 < soft < SOFT:
            way, told = found.softer(way)
            soft, mode = self._judged(way)
        if not is_certain(soft):  # so little may be rounding: a purer motion tells
            purer = softest_motion(found.A, self.at)
            if purer.any():
                soft, mode = self._judged(purer[~self.at.network.fixed.ravel()])
        _refuse_unsettled(told)
        return soft, mode

    def _judged(self, direction: Array) -> tuple[float, Array]:
        """Relative stiffness of a motion (f,), and the motion (n·d,).

        A motion without stiffness is refused.
        """
        free = ~self.at.network.fixed.ravel()
        mode, met = np.zeros(free.shape), np.zeros(free.shape)
        mode[free], met[free] = direction, self.diagonal
        soft = relative_stiffness(self.at, mode, met)
        if not abs(soft) > NO_STIFFNESS:  # NaN is nothing too
            raise SolverError(describe_motion(self.at.network, mode))
        return soft, mode


class Solver:
    """Inverts the tangents of one network, at one place after another.

    Raises `ProblemError` if there is no such solver.

    `network`: others with the same points, springs and supports may be asked about as well.
    `purpose`: "direct", "multigrid", or "auto", which counts what a factor takes. `cycle`: of a
    place close by, for the first multigrid.
    """

    def __init__(self, network: Network, purpose: str = "auto", cycle: Cycle | None = None) -> None:
        require_one_of("solver", purpose, SOLVERS)
        self.purpose, self._network = purpose, network
        self.is_indefinite = False
        """True if multigrid stopped at a tangent that is not positive definite."""
        self._cycle = cycle
        self._last: Cycles | None = None
        self._looked = False
        self._order: Index | None = None
        self.choice = self._chosen()

    @property
    def is_direct(self) -> bool:
        """True if tangents are factorised."""
        return self.choice.name == "direct"

    def regular(self, at: Configuration, K: bsr_array | None = None) -> Regular:
        """Inverse of the free part of the tangent K there.

        A factor, and the first multigrid, are looked at: some motion may meet no stiffness. Later
        ones are when they are asked.

        Raises `SolverError` if some motion meets no stiffness, or memory does not suffice.
        """
        K = at.tangent() if K is None else K
        diagonal = K.diagonal()[~at.network.fixed.ravel()]
        found = Regular(at, self.inverse(at, K, mend=self.is_direct), diagonal)
        if self.is_direct:
            _ = found.softness  # a mechanism is refused here
        if self.is_direct or self._looked:
            return found
        try:
            _refuse_rounding(found.softness)
        except NotConvergedError as error:
            try:
                self.fall_back_to_factor(error)
            except SolverError:
                # Where no factor will name it, a mechanism is looked for.
                if isinstance(found.inverse, Cycles) and not found.inverse.probed[2]:
                    refuse_mechanism_motion(found.inverse.A, at)
                raise
            return self.regular(at, K)
        self._looked = True
        return found

    def inverse(self, at: Configuration, K: bsr_array, *, mend: bool = False) -> Factor | Cycles:
        """Unchecked inverse of the free part of K; `mend` as for `factorise`.

        Raises `RuntimeError` if a pivot is zero; `SolverError` if nothing at all resists a
        component, or memory does not suffice.
        """
        network, alone = at.network, K.diagonal()
        inside = np.flatnonzero(~network.fixed.ravel())
        if not alone[inside].all():  # nothing at all is in the way
            mode = np.zeros(len(alone))
            mode[inside[alone[inside] == 0][0]] = 1.0
            raise SolverError(describe_motion(network, mode))
        if not self.is_direct:
            return self._multigrid(at, K)
        if self._order is None:
            self._order = dissection(self._network).order
        A = csr_array(K)[inside][:, inside]
        return factorise(A, free_unknowns(self._order, network.fixed), mend=mend)

    def fall_back_to_factor(self, error: SolverError, most: float = np.inf) -> None:
        """Use a factor from now on, because multigrid failed.

        Raise its error if no factor can be made.

        `most` entries are the largest that is taken.
        """
        if self.purpose != "auto" or self.is_direct:
            raise SolverError(f"{error}; take solver 'direct'") from error
        self.refuse_too_large(str(error), most)
        self._cycle = self._last = None
        self.choice = Choice("direct", f"multigrid gave up: {error}")

    def refuse_too_large(self, what: str, most: float = np.inf) -> None:
        """Raise `SolverError` with what failed where no factor is had, unless one was asked for."""
        if self.purpose == "direct":
            return
        entries = self._network.dim**2 * dissection(self._network).entries
        if entries > min(most, choice.MOST_IN_NEED):
            raise SolverError(
                f"{what}; a factor would take {BYTES * entries / 1e9:.0f} GB: take solver "
                "'direct' where there is so much"
            )

    def _chosen(self) -> Choice:
        if self.purpose != "auto":
            return Choice(self.purpose, QUESTIONS)
        network, d = self._network, self._network.dim
        entries = d**2 * len(network.blocks.column)
        chosen, found = choose(network.points, connected_pairs(network), d, entries)
        self._order = found.order if len(found.order) else None
        return chosen

    def _multigrid(self, at: Configuration, K: bsr_array) -> Cycles:
        last = self._last.cycle if self._last else self._cycle
        A = bsr_array((K.data.copy(), K.indices, K.indptr), shape=K.shape)
        restrain_in_place(A, ~at.network.fixed)
        self._last = Cycles(A, at, last or make_cycle(A, at), last is None)
        return self._last


class Once(Solver):
    """Solver that inverts one tangent for any loads, until it is renewed."""

    _first: tuple[Choice, Regular] | None = None

    def regular(self, at: Configuration, K: bsr_array | None = None) -> Regular:
        """As `Solver.regular`, of the first configuration that was asked about."""
        if self._first is None or self._first[0] is not self.choice:
            found = super().regular(at, K)
            self._first = self.choice, found
        return self._first[1]

    def renew(self) -> None:
        """Invert the next tangent anew, as of a network that has lost springs."""
        self._first = None


def elimination_order(network: Network) -> Index:
    """Free components (f,) of a network in the order to eliminate them."""
    return free_unknowns(dissection(network).order, network.fixed)


def dissection(network: Network) -> Dissection:
    """The order to eliminate a network's points in, and what a factor takes."""
    return nested_dissection(network.points, connected_pairs(network))


def connected_pairs(network: Network) -> Index:
    """Pairs (p, 2) of points that springs and cells join."""
    return np.concatenate([network.springs, pairs_in(network.resisting)])


def _refuse_unsettled(has_message: bool) -> None:
    if not has_message:
        raise NotConvergedError("multigrid: conjugate gradients do not tell whether it is stable")


def _refuse_rounding(softness: float) -> None:
    if not is_certain(softness):
        raise NotConvergedError(
            f"multigrid: the softest motion meets {abs(softness):.1g} of what its points meet one "
            "by one, too little to be told from rounding"
        )
