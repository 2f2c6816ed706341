"""The numbers that are 0 of a body that is what a probe takes it for, each with its limit."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from msvalidate.problem import Array
from msvalidate.problem.records import replace
from msvalidate.simulators.probe.bench import ENGINEERING, ROUNDING, Bench, Push, Station, voigt
from msvalidate.simulators.probe.masses import Masses
from msvalidate.simulators.probe.reading import INNER, Flag
from msvalidate_check.causes import phrase

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
SHARE = 0.01
"""Limit of masses over asked: what a law is asked to be told apart by."""
SHORTEST = {"float64": 1 / 256, "float32": 1 / 4}
"""Where forces act at the end of a step, inner nodes are looked at after one in which a wave
crosses this part of the smallest cell: by its square it reaches them from the surface, and at once
where the mass matrix is not diagonal. In single precision shorter steps are lost in rounding."""
AXIS = np.array([1.0, 2.0, 3.0]) / np.sqrt(14.0)
"""Of a small turn: none of the block's own."""
ARITHMETIC = 1.0
"""Roundings of the mean stress, each of one part in 2²⁴ or 2⁵³ of the stiffness: a cell's is off by
some ten at random, the mean over 200 cells by less than one. What is the same in +G and -G drops
out."""
OF_SOLVED = {
    "net force", "symmetry of P", "symmetry of C", "half the step, another strain", "free fall",
    "masses", "asked again",
}  # fmt: skip
"""Flags over what strained states or a weight do: a solver may leave the part that it states."""
PLACED = 3.0
"""Standard deviations of sums over rounded positions, within which they are taken to be."""


def rounding_parts(
    bench: Bench, strain: float, largest: float, forces_at: str, shrunk: float = 1.0
) -> tuple[float, float]:
    """Errors of C by rounding of stresses and strains, relative to its largest component.

    Arithmetic: deformation gradients near I are rounded, over the strain. Where velocities are
    differences of positions, a coordinate is rounded by up to half the spacing of numbers there, δ
    in the root of the mean square, and half the difference of two states by δ/√2. A node's force is
    then off by m δ/dt², and n such at places up to r add up to ρ δ r/(√n dt²) in the mean stress,
    and to δ times the root of the sum of squares of the block's weights in the mean strain. Of
    both, a strain of which only the part `shrunk` is left at the end shows that much more.
    """
    u, block = ROUNDING[bench.precision], bench.block
    part, of_strain = ARITHMETIC * u / strain, 0.0
    if forces_at == "end":
        X = block.mesh.points
        spacing = np.spacing(np.abs(X).astype(bench.precision)).astype(float)
        delta = float(np.sqrt((spacing**2).mean() / 24))  # half of it, squared, over 3 and 2
        r = float(np.abs(X).max())
        stress = block.material.density * delta * r / np.sqrt(len(X)) / bench.dt**2
        gradient = delta * float(np.linalg.norm(block.weights, axis=0).max())
        part += PLACED * stress / largest / (strain * shrunk)
        of_strain = PLACED * gradient / (strain * shrunk)
    return float(part), of_strain


def raise_flags(
    station: Station,
    pairs: Sequence[tuple[Push, Push]],
    rest: Push,
    C: Array,
    strain: float,
    curvature: float,
    masses: Masses | None,
) -> tuple[Flag, ...]:
    """All flags of a reading. Asks the simulator some ten times more."""
    largest = float(np.abs(C).max())
    odd = [((a.stress - b.stress) / 2, (a.force - b.force) / 2) for a, b in pairs]
    forces = [f for _, f in odd]
    strength = max(float(np.abs(f).max()) for f in forces)
    found = (
        *_balance(odd, C, strain),
        *_at_rest(rest, largest, strength),
        _one_sided(curvature, strain),
        _infinitesimal_turn(station, strain, strain * largest),
        _inner(station, forces, strain, largest),
        _other_step(station, C, strain),
        *([] if masses is None else [_free_fall(station, rest, strain)]),
        *_of_masses(masses, station.consistent),
        _repeat(station, rest, pairs[0][0], strain, strength),
    )
    left = station.solves_to
    return tuple(replace(f, limit=f.limit + left) if f.name in OF_SOLVED else f for f in found)


def _balance(odd: Sequence[tuple[Array, Array]], C: Array, strain: float) -> list[Flag]:
    """Forces without resultant, and symmetry of the mean stress and of C."""
    largest = float(np.abs(C).max())
    skew = max(float(np.abs(P - P.T).max()) for P, _ in odd)
    return [
        Flag(
            "net force",
            _resultant([f for _, f in odd]),
            EXACT,
            "forces between nodes have no resultant; another comes from outside, or masses are off",
        ),
        Flag(
            "symmetry of P", skew / (strain * largest), EXACT, "forces between nodes turn nothing"
        ),
        Flag(
            "symmetry of C",
            float(np.abs(C - C.T).max()) / largest,
            EXACT,
            "a law with an energy is symmetric",
        ),
    ]


def _at_rest(rest: Push, largest: float, strength: float) -> list[Flag]:
    """Stress and forces of the body as it was given."""
    return [
        Flag(
            "stress at rest",
            float(np.abs(rest.stress).max()) / largest,
            STRESSED,
            "over the stiffness; a body under stress is not a stiffness alone",
        ),
        Flag(
            "forces at rest",
            float(np.abs(rest.force).max()) / strength,
            IDLE,
            "over forces of strained states; contact, weight or what is left of other runs",
        ),
    ]


def _one_sided(curvature: float, strain: float) -> Flag:
    because = "over the strain; a law with a kink, or contact, pushes one way"
    return Flag("second-order part", curvature / strain, SMOOTH, because)


def _resultant(forces: Sequence[Array]) -> float:
    """Over the strongest state: some strains of some laws make no force."""
    strongest = max(float(np.abs(f).sum()) for f in forces)
    return max(float(np.abs(f.sum(axis=0)).max()) for f in forces) / strongest


def _skew(axis: Array) -> Array:
    x, y, z = axis
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def _infinitesimal_turn(station: Station, strain: float, unit: float) -> Flag:
    W = strain * _skew(AXIS)
    odd = (station.push(W).stress - station.push(-W).stress) / 2
    because = "a small turn strains nothing, in any law"
    return Flag("small turn", float(np.abs(odd).max()) / unit, EXACT, because)


def _inner(station: Station, forces: Sequence[Array], strain: float, largest: float) -> Flag:
    """Forces on inner nodes over those on the surface, in uniform strain."""
    if station.forces_at == "end":
        bench, block = station.bench, station.bench.block
        crossing = block.height * np.sqrt(block.material.density / largest)
        short = station.with_step(min(bench.dt, SHORTEST[bench.precision] * float(crossing)))
        G = _generic(strain)
        forces = [(short.push(G).force - short.push(-G).force) / 2]
    inner = station.bench.block.inner
    strongest = max(float(np.abs(f[~inner]).max()) for f in forces)
    value = max(float(np.abs(f[inner]).max()) for f in forces) / (strongest or 1.0)
    because = "uniform strain leaves inner nodes of one solid at rest; a lattice's would move, and "
    because += "C is an upper bound"
    return Flag(INNER, value, RELAXES, because)


def _generic(strain: float) -> Array:
    """A strain with all six components, none of them another's multiple."""
    G = np.array([[3.0, 1.5, -1.0], [1.5, -2.0, 0.5], [-1.0, 0.5, 1.0]])
    return np.asarray(strain * G / 4)


def _repeat(station: Station, rest: Push, first: Push, strain: float, strength: float) -> Flag:
    """The first strained state and rest again, after all the others."""
    G = np.zeros((3, 3))
    G[0, 0] = strain
    again, idle = station.push(G).force, station.push(np.zeros((3, 3))).force
    value = max(float(np.abs(again - first.force).max()), float(np.abs(idle - rest.force).max()))
    because = "over forces of strained states; the same question has the same answer, or state of "
    because += "earlier runs survives"
    return Flag("asked again", value / strength, EXACT, because)


def _other_step(station: Station, C: Array, strain: float) -> Flag:
    """Stress of another strain after half the step, beside C times that strain."""
    short = station.with_step(station.bench.dt / 2)
    G = _generic(strain)
    there, back = short.push(G), short.push(-G)
    found = voigt((there.stress - back.stress) / 2)
    expected = C @ (voigt((there.gradient - back.gradient) / 2) * ENGINEERING)
    value = float(np.abs(found - expected).max() / (strain * np.abs(C).max()))
    noise = sum(rounding_parts(short.bench, strain, float(np.abs(C).max()), station.forces_at))
    because = "a law knows no step, and strains add up; damping in a step's velocity does not"
    return Flag("half the step, another strain", value, EXACT + noise, because)


def _free_fall(station: Station, rest: Push, strain: float) -> Flag:
    """Acceleration of the body at rest under a weight that moves it as far as strains do."""
    bench = station.bench
    size = strain * bench.block.height / bench.dt**2
    weight = np.array([1.0, 2.0, -3.0]) / np.sqrt(14.0) * size
    force = station.push(np.zeros((3, 3)), gravity=tuple(weight.tolist())).force - rest.force
    mass = station.inertia(np.ones(force.shape)).sum(axis=0)
    value = float(np.abs(force.sum(axis=0) / mass - weight).max()) / size
    because = "of weight; a step from rest gives g dt, or velocities are not what forces made them"
    u, reach = ROUNDING[bench.precision], float(np.abs(bench.block.mesh.points).max())
    noise = PLACED * u * (1 / strain + reach / (strain * bench.block.height))
    return Flag("free fall", value, EXACT + noise, because)


def _of_masses(masses: Masses | None, consistent: bool) -> list[Flag]:
    if masses is None:
        return []
    because = phrase("mass matrix" if consistent else "measured masses", pattern=masses.words)
    return [Flag("masses", masses.off, SHARE + masses.error, because, refuses=consistent)]
