"""The numbers that are 0 of a body that is what a probe takes it for, each with its limit."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from msvalidate.linear_algebra.norms import max_abs
from msvalidate.problem import Array
from msvalidate.problem.records import replace
from msvalidate.simulators.exchange.protocol import ROUNDING
from msvalidate.simulators.probe.bench import ENGINEERING, Bench, Push, voigt
from msvalidate.simulators.probe.masses import Masses
from msvalidate.simulators.probe.reading import BAND, DAMPING, INNER, Flag
from msvalidate_check.causes import Phrase, phrase

EXACT = 1e-3
"""Limit of what vanishes of any elastic body: a fifth of the half percent that is shown."""
RELAXES = 0.05
"""Limit of forces inside: letting nodes move changes energy by about the square, 0.25 %."""
STRESSED = 1e-4
"""Limit of stress at rest over the stiffness: a geometric stiffness of this part is not seen."""
IDLE = 0.01
"""Limit of forces at rest over those of strained states: they cancel between +G and -G to first
order, and from there on they are as likely to be contact as rounding."""
SMOOTH = 16.0
"""Limit of the second-order part over the strain: smooth laws have 1 to 5; contact, or a limit on
one side alone, has 1 over the strain."""
SHORTEST = {"float64": 1 / 256, "float32": 1 / 4}
"""Wave travel in a short step, relative to the smallest cell.

If forces act at the end of a step, inner nodes are checked after such a step: a wave from the
surface reaches them by the square of this part, but at once if the mass matrix is not diagonal. In
single precision shorter steps are lost in rounding.
"""
AXIS = np.array([1.0, 2.0, 3.0]) / np.sqrt(14.0)
"""Axis of a small turn, which is none of the block's own."""
ACROSS = 0.1
"""Largest fraction of a loss of velocity across the weight for damping."""
PLACED = 3.0
"""Standard deviations of sums over rounded positions, within which they are taken to be."""


def rounding_parts(
    bench: Bench, strain: float, largest: float, shrunk: float = 1.0
) -> tuple[float, float]:
    """Errors of C by rounding of stresses and strains, relative to its largest component.

    Arithmetic: deformation gradients near I are rounded, over the strain. A cell's stress is off by
    some ten roundings at random, the mean over 200 cells by less than one; what is the same in +G
    and -G drops out. Where velocities are differences of positions, a coordinate is rounded by up
    to half the spacing of numbers there, δ in the root of the mean square, and half the difference
    of two states by δ/√2. A node's force is then off by m δ/dt², and n such at places up to r add
    up to ρ δ r/(√n dt²) in the mean stress, and to δ times the root of the sum of squares of the
    block's weights in the mean strain. Of both, a strain of which only the part `shrunk` is left at
    the end shows that much more.
    """
    u, block = ROUNDING[bench.precision], bench.block
    part, of_strain = u / strain, 0.0
    if bench.forces_at == "end":
        X = block.mesh.points
        spacing = np.spacing(np.abs(X).astype(bench.precision)).astype(float)
        delta = float(np.sqrt((spacing**2).mean() / 24))  # half of it, squared, over 3 and 2
        r = max_abs(X)
        stress = block.material.density * delta * r / np.sqrt(len(X)) / bench.dt**2
        gradient = delta * float(np.linalg.norm(block.weights, axis=0).max())
        part += PLACED * stress / largest / (strain * shrunk)
        of_strain = PLACED * gradient / (strain * shrunk)
    return float(part), of_strain


def raise_flags(
    bench: Bench,
    pairs: Sequence[tuple[Push, Push]],
    rest: Push,
    C: Array,
    strain: float,
    curvature: float,
    masses: Masses | None,
) -> tuple[Flag, ...]:
    """All flags of a reading. Asks the simulator some ten times more."""
    largest = max_abs(C)
    exact = EXACT + bench.solves_to  # over what strained states or a weight do
    stress = np.array([there.odd(back).stress for there, back in pairs])
    forces = np.array([there.odd(back).force for there, back in pairs])
    strength = max_abs(forces)
    # Over the strongest state: some strains of some laws make no force.
    resultant = max_abs(forces.sum(axis=1)) / float(np.abs(forces).sum(axis=(1, 2)).max())
    skew = max_abs(stress - np.swapaxes(stress, 1, 2))
    flags = [
        _flag("net force", resultant, exact),
        _flag("symmetry of P", skew / (strain * largest), exact),
        _flag("symmetry of C", max_abs(C - C.T) / largest, exact),
        _flag("stress at rest", max_abs(rest.stress) / largest, STRESSED),
        _flag("forces at rest", max_abs(rest.force) / strength, IDLE),
        _flag("second-order part", curvature / strain, SMOOTH),
        _flag("small turn", _of_turn(bench, strain) / (strain * largest), EXACT),
        _flag(INNER, _inner(bench, forces, strain, largest), RELAXES),
    ]
    value, noise = _other_step(bench, C, strain)
    flags.append(_flag("half the step, another strain", value, exact + noise))
    if masses is not None:
        name, value, noise = _free_fall(bench, rest, strain)
        flags.append(_flag(name, value, exact + noise))
        matrix = "mass matrix" if bench.consistent else "measured masses"
        because = phrase(matrix, pattern=masses.words)
        limit = BAND + masses.error + bench.solves_to
        flags.append(Flag("masses", masses.off, limit, because, refuses=bench.consistent))
    changed = _repeated(bench, rest, pairs[0][0], strain)
    return (*flags, _flag("asked again", changed / strength, exact))


def _flag(name: str, value: float, limit: float) -> Flag:
    return Flag(name, value, limit, Phrase(f"why {name}"))


def _of_turn(bench: Bench, strain: float) -> float:
    """Largest stress (Pa) of a small turn."""
    x, y, z = strain * AXIS
    W = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return max_abs(bench.push(W).odd(bench.push(-W)).stress)


def _inner(bench: Bench, forces: Array, strain: float, largest: float) -> float:
    """Forces on inner nodes over those on the surface, in uniform strain."""
    block = bench.block
    if bench.forces_at == "end":
        crossing = block.height * np.sqrt(block.material.density / largest)
        dt = min(bench.dt, SHORTEST[bench.precision] * float(crossing))
        short, G = replace(bench, dt=dt), _generic(strain)
        forces = short.push(G).odd(short.push(-G)).force[None]
    inner = block.inner
    return max_abs(forces[:, inner]) / (max_abs(forces[:, ~inner]) or 1.0)


def _generic(strain: float) -> Array:
    """A strain with all six components, none of them another's multiple."""
    G = np.array([[3.0, 1.5, -1.0], [1.5, -2.0, 0.5], [-1.0, 0.5, 1.0]])
    return np.asarray(strain * G / 4)


def _repeated(bench: Bench, rest: Push, first: Push, strain: float) -> float:
    """By how much (N) the first strained state and rest are others, asked after all the others."""
    G = np.zeros((3, 3))
    G[0, 0] = strain
    again, idle = bench.push(G).force, bench.push(np.zeros((3, 3))).force
    return max(max_abs(again - first.force), max_abs(idle - rest.force))


def _other_step(bench: Bench, C: Array, strain: float) -> tuple[float, float]:
    """Stress of another strain after half the step, beside C times that; and what rounding may."""
    short, G = replace(bench, dt=bench.dt / 2), _generic(strain)
    odd = short.push(G).odd(short.push(-G))
    expected = C @ (voigt(odd.gradient) * ENGINEERING[3])
    noise = sum(rounding_parts(short, strain, max_abs(C)))
    return max_abs(voigt(odd.stress) - expected) / (strain * max_abs(C)), noise


def _free_fall(bench: Bench, rest: Push, strain: float) -> tuple[str, float, float]:
    """Acceleration at rest under a weight that moves it as far as strains do, less the weight.

    The flag's name; the difference over the weight; and what rounding may make of that. An
    acceleration along the weight that is too small is damping.
    """
    size = strain * bench.block.height / bench.dt**2
    weight = np.array([1.0, 2.0, -3.0]) / np.sqrt(14.0) * size
    force = bench.push(np.zeros((3, 3)), gravity=tuple(weight.tolist())).force - rest.force
    mass = bench.inertia(np.ones(force.shape)).sum(axis=0)
    off = (force.sum(axis=0) / mass - weight) / size
    lost = -float(off @ weight) / size
    along = max_abs(off + lost * weight / size) <= ACROSS * lost < ACROSS
    reach = max_abs(bench.block.mesh.points) / bench.block.height
    noise = PLACED * ROUNDING[bench.precision] * (1 + reach) / strain
    return (DAMPING, lost, noise) if along else ("free fall", max_abs(off), noise)
