"""Springs for a material, for another engine: constants, masses, steps, with their formulas.

Numbers are those of the calibration. Formulas stand beside them as text: in μ and λ, in plane
stress λ′ = Eν/(1 - ν²) for λ, with the thickness t and the spacing h.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from msvalidate.case.file.units import quantity_text
from msvalidate.problem import Box, Isotropic, Problem, ProblemError, SolverError, Support
from msvalidate.problem.checks import positive_number, require_one_of, require_type
from msvalidate.problem.records import dataclass, replace
from msvalidate.springs.bodies.lattice_network import lattice_network
from msvalidate.springs.constants.calibration import Calibration
from msvalidate.springs.constants.routes import ROUTES, calibrate_by_route
from msvalidate.springs.constants.stiffness import ALIKE, CAUCHY, UNIT
from msvalidate.springs.dynamics.damping import Damping
from msvalidate.springs.dynamics.integrators import INTEGRATORS
from msvalidate.springs.dynamics.spectrum import natural_frequencies
from msvalidate.springs.dynamics.step_limits import SAFETY, stability_limit
from msvalidate.springs.lattice import Constants, Pattern, fill
from msvalidate.springs.lattice.patterns import all_patterns
from msvalidate_check.text import align_table, number_text

VOLUME = {2: "({λ} - μ)t", 3: "λ - μ"}
"""Axes -> κ of a cell, N/m in the plane or Pa in space. Source: [Golec2020]."""
UNDER_PRESSURE = {2: "{λ}t", 3: "λ"}
"""Axes -> stiffness of its cells."""
BOUNDARY = {
    "shared": "springs in the body's sides count 1/2{edge}, points there have their cells' part",
    "cut": "springs and points of cut cells count by the part in the body",
    "edges": "springs and points have the part of each cell that they border",
}
"""Rule of a lattice's `boundary` -> what is less there: filled, by "shared" of
`springs.lattice.WEIGHTS`; cut; or of a mesh's edges."""
NONE = 1e-12
"""Constants relative to the largest that are shown as 0."""
WHOSE, BLOCK = "bodies of whole cells, two or more across", 2
"""Whose highest frequency is taken, and cells along the edges of the free block that stands for
them: larger ones had no higher frequency, but for 0.8 %."""


@dataclass(frozen=True)
class SpringKind:
    """Springs of one kind: k1, where they run, N/m, length (m), formula ("" of given ones)."""

    name: str
    along: str
    constant: float
    length: float
    formula: str


@dataclass(frozen=True)
class Advice:
    """Springs that stand for a material, and how to move them.

    Parameters
    ----------
    material, lattice, spacing, route
        What they stand for; a name in `springs.lattice.patterns`; m; one of
        `springs.constants.routes.ROUTES`.
    kinds
        The springs, one entry a kind.
    mass
        Of a point inside (kg).
    omega, whose
        Highest frequency (rad/s), and of what it is: it sets the steps.
    source
        Keys of docs/references.bib.
    weights
        A key of `BOUNDARY`.
    damping, undamped
        Of a body under its load; None where there is none, and why.
    volume, volume_formula
        κ of a cell (N/m in the plane, Pa in space), 0 if cells resist nothing.
    pressure
        Of cells at rest, in the units of `volume`: springs then have no rest length.
    E, nu, zener
        Of the lattice, as `Calibration` has them; NaN where they are not known.
    """

    material: Isotropic
    lattice: str
    spacing: float
    route: str
    kinds: tuple[SpringKind, ...]
    mass: float
    omega: float
    whose: str
    source: str
    weights: str = "shared"
    damping: Damping | None = None
    undamped: str = "damping goes by body and load, not by E and nu"
    volume: float = 0.0
    volume_formula: str = ""
    pressure: float = 0.0
    E: float = math.nan
    nu: float = math.nan
    zener: float = math.nan

    @property
    def limits(self) -> dict[str, float]:
        """Integrator -> largest stable step (s), with the damping if there is one."""
        return step_limits(self.omega, self.damping.rate if self.damping else 0.0)

    @property
    def steps_to_rest(self) -> int:
        """Steps of leapfrog until the body is at rest; 0 where it has no damping."""
        step = SAFETY * self.limits["leapfrog"]
        return math.ceil(self.damping.seconds / step) if self.damping else 0

    @property
    def boundary(self) -> str:
        """Weights of springs and points in the body's sides, in words."""
        edge = ", in its edges 1/4" if self.material.dim == 3 else ""
        return BOUNDARY[self.weights].format(edge=edge)


def step_limits(omega: float, damping: float = 0.0) -> dict[str, float]:
    """Integrator -> largest stable step (s) up to a frequency (rad/s), damped at a rate (1/s)."""
    schemes = ("leapfrog", "euler_cromer")
    return {name: stability_limit(INTEGRATORS[name], omega, omega, damping) for name in schemes}


def advise(material: Isotropic, lattice: str, spacing: float, route: str | None = None) -> Advice:
    """Springs on a lattice, of a spacing (m), that stand for a material.

    Raises
    ------
    ProblemError
        With the reason, if the lattice cannot be the material by the route (None: by any).
    """
    require_type("material", material, Isotropic)
    known, dim = all_patterns(), material.dim
    require_one_of("lattice", lattice, known)
    pattern = known[lattice]()
    if pattern.dim != dim:
        able = ", ".join(name for name, make in known.items() if make().dim == dim)
        where = "in space, and the material is in the plane" if dim == 2 else "of the plane"
        raise ProblemError(f"lattice: {lattice!r} is {where}; choose {able}, or another state")
    found = calibrate_by_route(material, pattern, spacing, route)
    omega = block_frequency(material, pattern, found, 0.0, found.spacing)
    return advice_of(material, lattice, found, omega, WHOSE)


def lame_name(material: Isotropic) -> str:
    """λ as formulas have it: λ′ of plane stress."""
    return "λ′" if material.state == "plane_stress" else "λ"


def advice_of(
    material: Isotropic,
    lattice: str,
    found: Calibration,
    omega: float,
    whose: str,
    damping: Damping | None = None,
    weights: str = "shared",
) -> Advice:
    """The same from a calibration, the highest frequency (rad/s) of what is named, and damping."""
    pattern = all_patterns()[lattice]()
    lame = lame_name(material)
    formulas, own = pattern.formulas, f"[{pattern.formulas.source}]"
    every = found.spacing * np.linalg.norm(pattern.vectors, axis=1)
    rest = [float(every[pattern.kind == kind].mean()) for kind in range(pattern.kinds)]
    space = float(pattern.volume.mean()) * found.spacing**pattern.dim  # of a point inside
    by_route = found.route in ROUTES  # constants that were given have no formula
    along = formulas.kinds or tuple((f"kind {n + 1}", "") for n in range(pattern.kinds))
    cells, cells_source = VOLUME, ", κ [Golec2020]" * bool(found.volume)
    if found.pressure:
        cells, cells_source = UNDER_PRESSURE, ", cells [SimoPister1984]"
        along = tuple((where, formulas.zero_length) for where, _ in along)
    k = np.where(np.abs(found.constants) > NONE * np.abs(found.constants).max(), found.constants, 0)
    springs = zip(along, k, rest, strict=True)
    return Advice(
        material=material,
        lattice=lattice,
        spacing=found.spacing,
        route=found.route,
        kinds=tuple(
            SpringKind(f"k{number}", where, float(k), length, by_route * formula.format(λ=lame))
            for number, ((where, formula), k, length) in enumerate(springs, 1)
        ),
        mass=material.density * material.thickness * space,
        omega=omega,
        whose=whose,
        source=own + cells_source,
        weights=weights,
        damping=damping,
        volume=found.volume,
        volume_formula=cells[pattern.dim].format(λ=lame) if found.volume and by_route else "",
        pressure=found.pressure,
        E=found.E,
        nu=found.nu if abs(found.nu) > ALIKE else 0.0,
        zener=found.zener,
    )


def block_frequency(
    material: Isotropic,
    pattern: Pattern,
    constants: Constants | Calibration,
    volume: float,
    spacing: float,
) -> float:
    """Highest frequency (rad/s) of free blocks of whole cells, `BLOCK` or more across.

    At free sides points are lighter than springs are soft: it is up to a third above that of the
    endless lattice, whose waves of phases 0 and pi are among a block's motions.

    Parameters
    ----------
    material
        Gives density (kg/m³) and thickness (m).
    pattern, constants, volume, spacing
        What repeats, N/m, κ (N/m in the plane, Pa in space), and m; a calibration brings its own κ.

    Raises
    ------
    ProblemError
        If a free block is unstable: its sides cut springs but no cells.
    """
    box = Box(tuple(spacing * BLOCK * edge for edge in pattern.size))
    held = Problem(box, material, (Support(box.side("left"), (0.0,) * pattern.dim),))
    network = lattice_network(held, fill(pattern, box, BLOCK), constants, volume=volume)
    free = replace(network, fixed=np.zeros_like(network.fixed))
    try:
        return natural_frequencies(free, 1, rigid=True)[1]
    except SolverError as error:
        raise ProblemError(
            f"{pattern.name} lattice: a free block of {BLOCK} cells an edge does not hold, for its "
            f"sides cut springs ({error}); take another lattice, or a ratio nearer to "
            f"{CAUCHY[pattern.dim]:.3g} along its axes"
        ) from error


def constants_lines(each: Sequence[Advice], unit: str = "m", density: str = "") -> list[str]:
    """Table of springs, a row per lattice or material; `unit` is that of the spacing.

    A density by default is marked by the word `density`. The step is `SAFETY` of the limit of
    leapfrog: without damping of filled bodies by `advise`, and of a case its own body's, with the
    damping that it has.
    """
    if not each:
        return []
    kinds = max(len(one.kinds) for one in each)
    kappa = any(one.volume for one in each)
    heads = ["springs", *(f"k{number} (N/m)" for number in range(1, kinds + 1))]
    heads += [f"κ ({UNIT[each[0].material.dim]})"] * kappa
    steps = f"step (s), {'un' * all(one.damping is None for one in each)}damped"
    heads += ["mass (kg)", steps, "density (kg/m³)"]
    rows = []
    for number, one in enumerate(each):
        label = f"{one.lattice}, {quantity_text(one.spacing, 'm', unit)}"
        if number and one.lattice == each[0].lattice:
            label = f"region {number}"
        constants = [f"{kind.constant:.4g}" for kind in one.kinds]
        constants += [""] * (kinds - len(constants)) + [f"{one.volume:.4g}"] * kappa
        mass, step = f"{one.mass:.4g}", f"{SAFETY * one.limits['leapfrog']:.3g}"
        rows.append([label, *constants, mass, step, number_text(one.material.density) + density])
    return align_table(heads, rows, [False, *[True] * (len(heads) - 1)])


def step_sentence(options: Sequence[Advice], step: float | None = None) -> str:
    """Describe the step of a material, and the largest E (Pa) for a step (s)."""
    text = "step in proportion to spacing·√(density/E)"
    if step is None:
        return text
    dt = positive_number("--step", step, "s")
    largest = [
        f"{one.material.E * (SAFETY * one.limits['leapfrog'] / dt) ** 2:.4g} Pa of {one.lattice}"
        for one in options
    ]
    return f"{text}: {dt:g} s allows E up to {', '.join(largest)}"


def advice_lines(advice: Advice) -> tuple[str, ...]:
    """Describe the advice in five lines, with units."""
    a, dim = advice, advice.material.dim
    grows = f"{'k, κ' if a.volume else 'k'} the same at any spacing"
    if dim == 3:
        grows = f"k in proportion to the spacing{', κ the same' if a.volume else ''}"
    solid = f"E = {a.E:.6g} Pa, nu = {a.nu:.6g}" if math.isfinite(a.E) else "E and nu not known"
    if abs(a.zener - 1) > ALIKE:
        solid += f" along the axes, by direction unequal (Zener ratio {a.zener:.6g})"
    damping = a.undamped
    if a.damping:
        damping = (
            f"damping force -c·m·v on each point, c = {a.damping.rate:.3g} 1/s, by the slowest "
            f"motion that this load excites ({a.damping.omega:.3g} rad/s), not by E and nu: within "
            f"{100 * a.damping.accuracy:g} "
            f"% of rest after {a.damping.seconds:.3g} s, {a.steps_to_rest:,} steps of leapfrog; "
            f"stiffness-proportional damping of ratio ζ: β = 2ζ/ω = {2 / a.damping.omega:.3g} ζ s"
        )
    return (
        f"{a.lattice}, spacing {a.spacing:.6g} m, route {a.route}: {solid} {a.source}",
        f"  {springs_words(a)}",
        f"  {grows}; mass of a point inside {a.mass:.6g} kg; {a.boundary}",
        f"  step of {step_words(a.limits)}; highest frequency {a.omega:.6g} rad/s of {a.whose}",
        f"  {damping}",
    )


def step_words(limits: Mapping[str, float]) -> str:
    """List the step (s) of each integrator, of those with one limit together."""
    schemes: dict[str, list[str]] = {}
    for name, limit in limits.items():
        shown = f"{SAFETY * limit:.4g} s ({SAFETY:g} of the limit {limit:.4g} s)"
        schemes.setdefault(shown, []).append(INTEGRATORS[name].title)
    return ", ".join(f"{' and '.join(names)} {shown}" for shown, names in schemes.items())


def springs_words(advice: Advice) -> str:
    """The constants, with formulas and lengths."""
    springs = [
        f"{kind.name} = {kind.constant:.6g} N/m{' = ' * bool(kind.formula)}{kind.formula} "
        f"along {kind.along} ({kind.length:.6g} m)"
        for kind in advice.kinds
    ]
    if advice.route in ROUTES and not all(kind.formula for kind in advice.kinds):
        springs.append("constants of the calibration, for which no formula is recorded")
    unit = UNIT[advice.material.dim]
    formula = " = " * bool(advice.volume_formula) + advice.volume_formula
    if advice.pressure:
        springs.append(
            "springs of no rest length; each cell stores -p ln J + (λ/2) ln²J of its volume, p = "
            f"{advice.pressure:.6g} {unit} = μ{'t' * (advice.material.dim == 2)}, "
            f"λ = {advice.volume:.6g} {unit}{formula}"
        )
    elif advice.volume:
        springs.append(f"κ = {advice.volume:.6g} {unit}{formula} of each cell")
    return "; ".join(springs)


def advice_record(advice: Advice) -> dict[str, Any]:
    """The same for JSON, all in SI units: m, kg, s, N/m, Pa."""
    return {
        **asdict(advice),
        "boundary": advice.boundary,
        "step_limit": advice.limits,
        "step": {name: SAFETY * limit for name, limit in advice.limits.items()},
        **({"steps_to_rest": advice.steps_to_rest} if advice.damping else {}),
    }
