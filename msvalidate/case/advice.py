"""Springs for a material, for another engine: constants, masses, steps, with their formulas.

The numbers are those of the calibration, the formulas are beside them as text, in μ and λ, the
thickness t and the spacing h. In plane stress λ′ = Eν/(1 - ν²) stands for λ.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from msvalidate.constants.calibration import Calibration
from msvalidate.constants.routes import ROUTES, calibrate_by_route
from msvalidate.constants.stiffness import ALIKE, UNIT
from msvalidate.constants.waves import highest_frequency
from msvalidate.dynamics import spectrum
from msvalidate.dynamics.damping import Damping
from msvalidate.dynamics.integrators import INTEGRATORS
from msvalidate.dynamics.step_limits import SAFETY, stability_limit
from msvalidate.lattice import Pattern, boundary_weights, fill
from msvalidate.lattice.patterns import all_patterns
from msvalidate.network import spring_network
from msvalidate.network.laws.volumes import Volumes
from msvalidate.problem import Box, Isotropic, ProblemError
from msvalidate.problem.checks import require_one_of, require_type
from msvalidate.problem.records import dataclass

FORMULAS: Mapping[str, tuple[tuple[str, str], ...]] = {
    "square": (("the axes", "2μt"), ("the diagonals", "μt")),
    "triangular": (("the triangles' sides", "4/√3·μt"),),
    "honeycomb": (("the hexagons' sides", "2√3·({λ} - μ)t"), ("their short diagonals", "2/√3·μt")),
    "cubic18": (("the axes", "μh"), ("the faces' diagonals", "μh")),
    "cubic26": (
        ("the axes", "11/7·μh"),
        ("the faces' diagonals", "3/7·μh"),
        ("the cubes' diagonals", "3/7·μh"),
    ),
    "bcc": (("half the cubes' diagonals", "3/2·μh"), ("the axes", "μh")),
    "fcc": (("half the faces' diagonals", "μh"), ("the axes", "1/4·μh")),
}
"""Lattice -> where the springs of each kind run, and their constant in N/m, {λ} by the state.

Source: the tensors of `lattice.patterns`, [BornHuang1954] (triangular: [OstojaStarzewski2002]),
equal to the material's. Many sets of three constants do for cubic26; these have k2 = k3."""
SOURCE = "[BornHuang1954]"
SOURCES = {"triangular": "[OstojaStarzewski2002]"}
VOLUME, VOLUME_SOURCE = {2: "({λ} - μ)t", 3: "λ - μ"}, "[Golec2020]"
"""Axes -> κ of a cell, N/m in the plane or Pa in space."""
BOUNDARY = {
    "shared": "springs in a side of the body count 1/2{edge}, points there have their part of mass",
    "equal": "springs in a side of the body are whole, points there have their part of mass",
    "cut": "springs of cut cells count by the part in the body, points have their part of mass",
    "edges": "points have their part of their cells' mass",
    "per_cell": "springs count once for each cell that they border",
}
"""Boundary rule -> what it does, {edge} in space."""
SCHEMES = ("leapfrog", "euler_cromer")
BLOCKS = (2, 3)
"""Cells along the edges of the blocks whose highest frequency is taken for any body's of whole
cells: larger ones came to no more."""


@dataclass(frozen=True)
class SpringKind:
    """Springs of one kind.

    Parameters
    ----------
    name, along
        Such as "k1", "the axes".
    constant, length
        N/m, and at rest in m.
    formula
        The constant's, "2μt"; "" where it was given.
    """

    name: str
    along: str
    constant: float
    length: float
    formula: str


@dataclass(frozen=True, eq=False)
class Advice:
    """Springs that stand for a material, and how to move them.

    Parameters
    ----------
    material, lattice, spacing, route
        What they stand for; a name in `lattice.patterns`; m; one of `constants.routes.ROUTES`.
    kinds
        The springs, one entry a kind.
    volume, volume_formula
        κ of a cell (N/m in the plane, Pa in space), 0 if cells resist nothing.
    E, nu, zener
        Of the lattice (Pa, -, 1 where it is isotropic): see `Calibration`.
    mass
        Of a point inside (kg).
    weights
        The rule of `BOUNDARY` for springs in the body's sides.
    omega, whose
        Highest frequency (rad/s), and of what it is: it sets the steps.
    damping
        Of a body under its load; None where there is none.
    """

    material: Isotropic
    lattice: str
    spacing: float
    route: str
    kinds: tuple[SpringKind, ...]
    volume: float
    volume_formula: str
    E: float
    nu: float
    zener: float
    mass: float
    weights: str
    omega: float
    whose: str
    damping: Damping | None = None

    @property
    def limits(self) -> dict[str, float]:
        """Integrator -> largest stable step (s), with the damping if there is one."""
        rate = self.damping.rate if self.damping else 0.0
        return {
            name: stability_limit(INTEGRATORS[name], self.omega, self.omega, rate)
            for name in SCHEMES
        }

    @property
    def steps(self) -> dict[str, float]:
        """Integrator -> step (s) to take, `SAFETY` of its limit."""
        return {name: SAFETY * limit for name, limit in self.limits.items()}

    @property
    def steps_to_rest(self) -> int:
        """Steps of leapfrog until the body is at rest; 0 where it has no damping."""
        return math.ceil(self.damping.seconds / self.steps["leapfrog"]) if self.damping else 0

    @property
    def boundary(self) -> str:
        """What springs and points in the body's sides have."""
        edge = ", on an edge 1/4" if self.material.dim == 3 else ""
        return BOUNDARY[self.weights].format(edge=edge)

    @property
    def source(self) -> str:
        """Keys of docs/references.bib."""
        own = SOURCES.get(self.lattice, SOURCE)
        return f"{own}, {VOLUME_SOURCE}" if self.volume else own


def pattern_for(material: Isotropic, lattice: str) -> Pattern:
    """The lattice of a name; raise `ProblemError` if it is none of the material's dimension."""
    known = all_patterns()
    require_one_of("lattice", lattice, known)
    found = known[lattice]()
    if found.dim != material.dim:
        able = ", ".join(name for name, make in known.items() if make().dim == material.dim)
        raise ProblemError(f"lattice: {lattice!r} is none of {material.state}; choose {able}")
    return found


def advise(material: Isotropic, lattice: str, spacing: float, route: str | None = None) -> Advice:
    """Springs on a lattice that stand for a material.

    The highest frequency is that of blocks of whole cells, at whose sides points are lighter than
    springs are soft: a body's may be a quarter above the endless lattice's.

    Parameters
    ----------
    material, lattice
        What is to be, and a name in `lattice.patterns`.
    spacing
        Length (m) of the pattern's unit.
    route
        One of `constants.routes.ROUTES`; None takes springs alone where they will do.

    Raises
    ------
    ProblemError
        With the reason, if the lattice cannot be the material.
    """
    require_type("material", material, Isotropic)
    pattern = pattern_for(material, lattice)
    found = calibrate_by_route(material, pattern, spacing, route)
    kappa = found.volume * found.spacing ** (pattern.dim - 2)
    mean = _point_mass(material, pattern, found.spacing)
    inside = math.sqrt(highest_frequency(pattern, found.constants, kappa) / mean)
    omega = max(inside, *(_block_frequency(material, pattern, found, n) for n in BLOCKS))
    whose = f"a body of whole cells, two or more across (of the endless lattice {inside:.6g})"
    return advice_of(material, lattice, found, omega, whose)


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
    pattern = pattern_for(material, lattice)
    lame = "λ′" if material.state == "plane_stress" else "λ"
    length = found.spacing * np.linalg.norm(pattern.vectors, axis=1)
    of_kind = [length[pattern.kind == kind].mean() for kind in range(pattern.kinds)]
    kinds = tuple(
        SpringKind(
            f"k{number}",
            along,
            k,
            float(rest),
            formula.format(λ=lame) if found.route in ROUTES else "",
        )
        for number, ((along, formula), k, rest) in enumerate(
            zip(FORMULAS[lattice], found.constants, of_kind, strict=True), 1
        )
    )
    return Advice(
        material=material,
        lattice=lattice,
        spacing=found.spacing,
        route=found.route,
        kinds=kinds,
        volume=found.volume,
        volume_formula=VOLUME[pattern.dim].format(λ=lame) if found.volume else "",
        E=found.E,
        nu=found.nu,
        zener=found.zener,
        mass=_point_mass(material, pattern, found.spacing),
        weights=weights,
        omega=omega,
        whose=whose,
        damping=damping,
    )


def _point_mass(material: Isotropic, pattern: Pattern, spacing: float) -> float:
    """Mean mass (kg) of a point."""
    share = math.prod(pattern.size) / len(pattern.points)
    return float(material.density * material.thickness * share * spacing**pattern.dim)


def _block_frequency(
    material: Isotropic, pattern: Pattern, found: Calibration, cells: int
) -> float:
    """Highest frequency (rad/s) of a free block of so many cells along each edge."""
    box = Box(tuple(found.spacing * cells * edge for edge in pattern.size))
    lattice = fill(pattern, box, cells)
    kappa = np.full(len(lattice.cells), found.volume)
    network = spring_network(
        lattice.points,
        lattice.springs,
        np.array(found.constants)[lattice.kind]
        * lattice.factor
        * boundary_weights(lattice, "shared"),
        mass=material.density * material.thickness * lattice.point_volume,
        volumes=Volumes(lattice.points, lattice.cells, kappa) if found.volume else None,
        cells=lattice.cells,
    )
    return spectrum.highest_frequency(network)


def advice_lines(advice: Advice) -> tuple[str, ...]:
    """What to take, in five lines, with units."""
    plane = advice.material.dim == 2
    if plane:
        grows = (
            "k and κ are the same at any spacing"
            if advice.volume
            else ("k is the same at any spacing")
        )
    else:
        grows = "k grows in proportion to the spacing" + (", κ doesn't" if advice.volume else "")
    steps = ", ".join(f"{INTEGRATORS[name].title} {h:.4g} s" for name, h in advice.steps.items())
    waves = f"highest frequency {advice.omega:.6g} rad/s of {advice.whose}"
    what = f"{advice.lattice}, spacing {advice.spacing:.6g} m, by {advice.route}"
    if math.isfinite(advice.E):
        what += f": E = {advice.E:.6g} Pa, nu = {advice.nu:.6g}"
        if abs(advice.zener - 1) > ALIKE:
            what += f" along the axes, by direction unequal (Zener ratio {advice.zener:.6g})"
    return (
        f"{what} {advice.source}",
        springs_words(advice),
        f"{grows}; a point inside has {advice.mass:.6g} kg; {advice.boundary}",
        f"steps, {SAFETY:g} of their limits: {steps}; {waves}",
        _damping_words(advice),
    )


def springs_words(advice: Advice) -> str:
    """The constants, with formulas and lengths."""
    springs = [
        f"{kind.name} = {kind.constant:.6g} N/m{f' ({kind.formula})' if kind.formula else ''} "
        f"along {kind.along}, {kind.length:.6g} m long"
        for kind in advice.kinds
    ]
    if advice.volume:
        unit = f"{UNIT[advice.material.dim]} ({advice.volume_formula})"
        springs.append(f"κ = {advice.volume:.6g} {unit} of each cell".replace(" ()", ""))
    return "; ".join(springs)


def _damping_words(advice: Advice) -> str:
    damping = advice.damping
    if damping is None:
        return "damping depends on body and load, not on E and nu"
    return (
        f"damping {damping.rate:.4g} 1/s, by the slowest motion that this load excites "
        f"({damping.omega:.4g} rad/s), not by E and nu: within {100 * damping.accuracy:g} % of "
        f"rest after {damping.seconds:.3g} s, {advice.steps_to_rest:,} steps of leapfrog"
    )


def advice_record(advice: Advice) -> dict[str, Any]:
    """The same for JSON, in SI units."""
    material, damping = advice.material, advice.damping
    return {
        "material": {
            "E_Pa": material.E,
            "nu": material.nu,
            "state": material.state,
            "density_kg_per_m3": material.density,
            "thickness_m": material.thickness if material.dim == 2 else None,
        },
        "lattice": advice.lattice,
        "spacing_m": advice.spacing,
        "route": advice.route,
        "springs": [
            {
                "name": kind.name,
                "along": kind.along,
                "stiffness_N_per_m": kind.constant,
                "rest_length_m": kind.length,
                "formula": kind.formula,
            }
            for kind in advice.kinds
        ],
        "kappa": advice.volume,
        "kappa_unit": UNIT[material.dim],
        "kappa_formula": advice.volume_formula,
        "source": advice.source,
        "E_Pa": advice.E,
        "nu": advice.nu,
        "zener_ratio": advice.zener,
        "mass_of_a_point_inside_kg": advice.mass,
        "boundary": {"rule": advice.weights, "means": advice.boundary},
        "highest_frequency_rad_per_s": advice.omega,
        "highest_frequency_of": advice.whose,
        "step_limit_s": advice.limits,
        "step_s": advice.steps,
        "damping": damping
        and {
            "rate_per_s": damping.rate,
            "slowest_excited_rad_per_s": damping.omega,
            "rest_within": damping.accuracy,
            "seconds": damping.seconds,
            "leapfrog_steps": advice.steps_to_rest,
        },
    }
