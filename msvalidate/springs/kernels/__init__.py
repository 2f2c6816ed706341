"""The compiled loops: forces of springs and cells, and steps of what moves by them.

The only compiled code of the package beside `dielectric.kernels`, by Numba [Numba2015]. Its plain
form is `springs.network.internal_force` and the plain loop of `springs.dynamics.integrate`; tests
hold them together on random networks. A uniform lattice takes steps by `stencil`, which knows its
springs without lists, any other network by `sweep`.

Displacements are advanced, not positions: a spring is its vector at rest plus the difference of two
displacements. Positions are rounded to an eps of the body, and stiff modes that decay slowly gather
that rounding over 1/(damping·dt) steps; on long bodies of many points it would keep Algorithm 1
from coming to rest.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from msvalidate.problem import Array, ProblemError
from msvalidate.problem.checks import require_one_of, require_type, whole_number
from msvalidate.springs.kernels import bending, stencil
from msvalidate.springs.kernels.general import MOST_WAVES, Sweep, Threads
from msvalidate.springs.kernels.grid import recognised
from msvalidate.springs.network import Configuration, Network
from msvalidate.springs.network.breakage import Breakage
from msvalidate.springs.network.ground import Ground

Path = Literal["auto", "general", "lattice", "plain"]
Moving = tuple[Array, Array, Array, Array]
"""Displacement and velocity (n, d), and the factors (n,) of a step; see `Motion.advance`."""
PATHS: tuple[Path, ...] = ("auto", "general", "lattice", "plain")


class Motion:
    """A network made ready for many calls: its places in memory, found once.

    Parameters
    ----------
    network
        Springs, and cells if there are any.
    path
        "general": by lists of springs; "lattice": by a stencil, for uniform lattices only; "auto"
        takes this where it serves; "plain": NumPy's, of laws that compiled loops do not have, and
        then taken by "auto". Results agree to rounding.
    threads
        Among which the general path shares its points; they change no bit of the motion. A lattice
        with more than one takes the general path.
    waves
        Steps that may follow each other through the caches on the general path; with 1 memory is
        passed over once a step. They change no bit either.
    ground
        Ground springs that `advance` steps by too. It takes the general path then, one step after
        the other in one thread; `force_and_energy` is without them.
    breakage
        Springs that `advance` breaks, on the general path in one thread.

    Raises
    ------
    ProblemError
        If the network is no uniform lattice but is to be one, or an argument is out of range.
    """

    def __init__(
        self,
        network: Network,
        *,
        path: Path = "auto",
        threads: int = 1,
        waves: int = MOST_WAVES,
        ground: Ground | None = None,
        breakage: Breakage | None = None,
    ) -> None:
        require_type("network", network, Network)
        require_one_of("path", path, PATHS)
        whole_number("threads", threads, 1)
        whole_number("waves", waves, 1)
        self._plain = path == "plain" or (path == "auto" and not compiles(network))
        if not (self._plain or compiles(network)):
            laws = [network.law.name] + ([network.volumes.law.name] if network.volumes else [])
            raise ProblemError(f"path: {path}, for laws {', '.join(laws)}; take path auto or plain")
        alone = ground is None and breakage is None
        lattice = path == "lattice" or (alone and (path, threads) == ("auto", 1))
        if not alone and (path == "lattice" or threads > 1):
            what = "ground springs" if breakage is None else "breaking springs"
            raise ProblemError(f"{what}: on path lattice or in threads; leave both out")
        grid = recognised(network) if lattice and not self._plain else None
        if path == "lattice" and (grid is None or threads > 1):
            why = "more than one thread" if grid else "a network that is no uniform lattice"
            raise ProblemError(f"path: lattice, for {why}; take path auto or general")
        self._network, self._grid, self._threads = network, grid, threads
        self._waves, self._ground, self._breakage = waves, ground, breakage
        self._sweep: Sweep | None = None
        self._shared: Threads | None = None
        self._held = np.flatnonzero(network.fixed)

    @property
    def path(self) -> Path:
        """The path taken: "general", "lattice" or "plain"."""
        return "plain" if self._plain else "general" if self._grid is None else "lattice"

    @property
    def bytes_a_step(self) -> int:
        """Bytes that pass between memory and processor in a step, where no cache holds them."""
        return (
            self._general.bytes_a_step if self._grid is None else stencil.bytes_a_step(self._grid)
        )

    @property
    def _general(self) -> Sweep:
        if self._sweep is None:
            self._sweep = Sweep(self._network, None, self._waves, self._breakage)
        return self._sweep

    def force_and_energy(self, displacement: Array, out: Array) -> float:
        """Write the force (n, d) in N at a displacement into `out`; return the energy (J)."""
        self._refuse_shape(displacement=displacement, out=out)
        force = _written("out", out)
        if self._plain:
            at = Configuration(self._whole, displacement)
            force[:], stored = at.force(), at.energy()
        else:
            stored = self._general.force(_flat(displacement), force)
        _put_back((out, force))
        return stored

    def balance(self, displacement: Array) -> Array:
        """Out-of-balance force (n, d) in N that `advance` steps by, 0 where it is held.

        On a lattice it is not that of `force_and_energy`: springs that lead the same way are alike
        there, in the network but for the rounding of coordinates.
        """
        network = self._network
        force = np.zeros_like(network.points)
        if self._grid is None:
            self.force_and_energy(displacement, force)
            force += network.force
        else:
            once = np.ones(len(force))
            self.advance(np.array(displacement, dtype=float), force, 0 * once, once, 0.0, 1)
            force *= network.mass[:, None]
        force[network.fixed] = 0.0
        return force

    def advance(
        self,
        displacement: Array,
        velocity: Array,
        keep: Array,
        push: Array,
        dt: float,
        steps: int,
        *,
        kinetic: float = 0.0,
        to_peak: bool = False,
    ) -> tuple[int, float, bool]:
        """Advance displacement (m) and velocity (m/s), both (n, d), in place; held components stay.

        v = keep·v + push·(F_internal + F_external)/m, then u += dt·v, with `keep` (n,) and `push`
        (n,) in s: every scheme with one velocity a step and viscosity. Returns the steps done, the
        kinetic energy (J) of the last, and whether it ended there because that fell: `to_peak`
        stops after the first such step, counted from `kinetic`, and is for one thread.

        Raises `ProblemError` if an array is of another shape, or displacement or velocity are none
        of float64 that can be written to. Numbers are not looked at: a NaN comes out as one.
        """
        self._refuse_shape(displacement=displacement, velocity=velocity, keep=keep, push=push)
        u, v = _written("displacement", displacement), _written("velocity", velocity)
        v.ravel()[self._held] = 0.0
        moving, dt, kinetic = (u, v, _flat(keep), _flat(push)), float(dt), float(kinetic)
        ended = 0, kinetic, False
        if whole_number("steps", steps, 0):
            ended = self._advance(moving, dt, steps, kinetic, to_peak)
        _put_back((displacement, u), (velocity, v))
        return ended

    def _advance(
        self, moving: Moving, dt: float, steps: int, kinetic: float, to_peak: bool
    ) -> tuple[int, float, bool]:
        if self._plain:
            return self._advance_plainly(moving, dt, steps, kinetic, to_peak)
        if self._grid is not None:
            return stencil.advance(self._grid, *moving, dt, steps, kinetic, to_peak)
        if self._threads == 1 or to_peak:
            return self._general.advance(*moving, dt, steps, kinetic, to_peak, self._ground)
        if self._shared is None:
            self._shared = Threads(self._network, self._threads, self._waves)
        return self._shared.advance(*moving, dt, steps)

    def _advance_plainly(
        self, moving: Moving, dt: float, steps: int, kinetic: float, to_peak: bool
    ) -> tuple[int, float, bool]:
        (u, v, keep, push), network, held = moving, self._network, self._held
        for step in range(1, steps + 1):
            if self._breakage is not None:
                self._breakage.look(u)
            force = Configuration(self._whole, u).force() + network.force
            if self._ground is not None:
                force[self._ground.points] += self._ground.push(u[self._ground.points])
            v *= keep[:, None]
            v += (push / network.mass)[:, None] * force
            v.ravel()[held] = 0.0
            u += dt * v
            before, kinetic = kinetic, 0.5 * float(network.mass @ (v**2).sum(axis=1))
            if to_peak and kinetic < before:
                return step, kinetic, True
        return steps, kinetic, False

    @property
    def _whole(self) -> Network:
        network, breakage = self._network, self._breakage
        return network if breakage is None else breakage.whole(network)

    def _refuse_shape(self, **values: Array) -> None:
        """Compiled code looks at no index: other shapes would read, or write, beside the arrays."""
        shape = self._network.points.shape
        for name, value in values.items():
            needed = shape[:1] if name in {"keep", "push"} else shape
            if np.shape(value) != needed:
                raise ProblemError(f"{name}: shape {np.shape(value)}; give {needed}")


def _flat(values: Array) -> Array:
    """As compiled code takes arrays, so that it is compiled once: C-contiguous and writable."""
    kept = type(values) is np.ndarray and values.dtype == np.float64
    if kept and values.flags.c_contiguous and values.flags.writeable:
        return values  # as below, in a tenth of the time
    return np.require(values, np.float64, ("C", "W"))


def _written(name: str, values: Array) -> Array:
    """An array to be written to, or a copy of it that is `_flat`; see `_put_back`."""
    if not (isinstance(values, np.ndarray) and values.dtype == np.float64):
        kind = getattr(values, "dtype", type(values).__name__)
        raise ProblemError(f"{name}: {kind}; give an array of float64, which is written to")
    if not values.flags.writeable:
        raise ProblemError(f"{name}: read-only; give a copy, which is written to")
    return _flat(values)


def _put_back(*written: tuple[Array, Array]) -> None:
    for given, flat in written:
        if flat is not given:
            given[...] = flat


def curvature(network: Network, displacement: Array, direction: Array) -> float:
    """Second derivative (N·m) of the stored energy along `direction` d, (n, d) in m: dᵀ K d."""
    if network.law.straight or network.law.loops is None or network.volumes:
        return Configuration(network, displacement).mode_energy(direction)
    axes, each = tuple(range(network.dim)), (network.stiffness, network.rest_length)
    springs = network.springs, network.vector
    return float(bending.curvature(axes, displacement, direction, *springs, *each))


def compiles(network: Network) -> bool:
    """Return True if compiled loops have the laws of springs and cells."""
    cells = network.volumes
    return network.law.loops is not None and (cells is None or cells.law.compiled)
