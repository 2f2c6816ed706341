"""Routes: how far does each way to a Poisson's ratio go, and what does it ask in return?

Question   From which ratio to which a lattice is stable by springs alone and by the volume energy;
           how wrong a stretched block is, and how that falls with its size; how stiff its stiffest
           wave is, and with how many points each point is coupled.
Candidate  Springs, and beside them κ of every cell's volume.
Reference  Moduli above zero: κ > -(1 + 2/d) μ, d axes. Waves: those of an endless lattice, from a
           point's own row of stiffness. A uniform strain, exact.
Expected   With volumes only the moduli count, for a free block's softest motion is a uniform
           strain, and a stretched block is exact wherever springs alone are. Where springs cross
           sides both have an error of order 1. The stiffest wave of cells that follow it alternates
           along x: 4 (λ + 2μ) h^(d - 2) = ω² m.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import NamedTuple

import numpy as np
import pandas as pd
from scipy.linalg import eigh, eigvalsh
from scipy.sparse import csr_array

from msvalidate.bodies.calibrate import calibrate
from msvalidate.bodies.lattice_network import lattice_network
from msvalidate.constants.calibration import Calibration
from msvalidate.constants.routes import ROUTES
from msvalidate.constants.stiffness import CAUCHY
from msvalidate.constants.waves import least_stable_volume
from msvalidate.judging.compare import farthest_value
from msvalidate.judging.evidence import Evidence, Observed, Tolerance, by_quantity
from msvalidate.judging.sweep import Setting
from msvalidate.lattice import Lattice, Pattern, fill, patterns
from msvalidate.network import tangent
from msvalidate.problem import Anisotropic, Box
from msvalidate.problem.material import State

from .. import cases, loading
from . import waves
from .ranges import draw

LATTICES = ("square", "triangular", "cubic18", "cubic26", "bcc")
QUICK = ("square", "triangular", "cubic18")
BODY = {2: 8, 3: 3}
"""Cells along an edge, about, of the body whose softest motion is looked for."""
PROBE = {2: 0.45, 3: 0.4}
"""Ratio at which the stiffest waves are compared."""
ALIGNED = ("square", "cubic18", "cubic26")
"""Lattices whose springs cross no side, one point a cell."""
LEAST = ("least_moduli", "least_waves", "least_body")
LOWEST = {2: -2.0, 3: -5 / 3}
"""κ/μ = -(1 + 2/d), where the ratio is -1."""
ADDED = "volume energy"
TOLERANCES = (
    Tolerance(
        "volume energy: least κ/μ of free blocks whose springs cross no side, from -(1 + 2/d)",
        1e-9, "1",
        "their softest motion is a uniform strain, which they follow exactly: rounding of an "
        "eigenvalue",
    ),
    Tolerance(
        "least κ/μ of endless lattices, by rows of stiffness and by Fourier sums",
        1e-7, "1",
        "two routes to one eigenvalue; of the stiffness of waves of phase 1e-3 a part of 1e-6 is "
        "left, so that rounding of a hundred terms of 1e-16 makes 1e-8 of it",
    ),
    Tolerance(
        "volume energy: ω² m of square and cubic lattices, from 4 (λ + 2μ) h^(d - 2), relative",
        1e-10, "1",
        "a wave that alternates along x strains every cell alike: an identity",
    ),
)  # fmt: skip
COLUMNS = {
    "lattice": cases.COLUMNS["lattice"],
    "route": "what makes the ratio: springs alone or volume energy",
    "least_moduli": 'least κ/μ for moduli above zero, or "none" (1)',
    "least_waves": 'the same for every wave of the endless lattice to cost energy, or "none" (1)',
    "least_body": "the same for every motion of a free block of 8 x 8 or 3 x 3 x 3 cells, about, "
    'or "none" (1)',
    "nu_from": "lowest Poisson's ratio along the lattice's axes that this leaves open (1)",
    "nu_to": "the highest, itself excluded but with springs alone (1)",
    "coupled": "other points that a point's force depends on",
    "nu_of_wave": "ratio at which omega2_m_over is taken (1)",
    "omega2_m_over": "highest frequency squared times a point's mass, at that ratio, over that of "
    "springs alone at Cauchy's of the same shear modulus (1)",
    "omega2_theory_over": "the same on paper, (λ + 2μ)/3μ where cells follow the wave that "
    'alternates along x, or "none" (1)',
    "step_over": "largest stable time step over that of springs alone (1)",
}


class Way(NamedTuple):
    """One lattice and one route."""

    lattice: str
    route: str

    @property
    def pattern(self) -> Pattern:
        """What repeats."""
        make: Callable[[], Pattern] = getattr(patterns, self.lattice)
        return make()


def ways(setting: Setting) -> list[Way]:
    """Every lattice by every route."""
    names = QUICK if setting.quick else LATTICES
    return [Way(name, route) for name in names for route in ROUTES]


def run(setting: Setting) -> Evidence:
    """Find how far each route goes."""
    found = setting.sweep(measure, ways(setting), "ranges of Poisson's ratio")
    table = pd.DataFrame([row for row, _ in found])
    fourier = pd.Series([ratio for _, ratio in found])
    added = table["route"] == ADDED
    known = table["omega2_theory_over"] != "none"
    free = table[known & added]
    values = (
        _worst(free["least_body"], free["least_moduli"]),
        _worst(table[added]["least_waves"], fourier[added]),
        _worst(table[known]["omega2_m_over"], table[known]["omega2_theory_over"]),
    )
    return Evidence(
        tables={"routes": table},
        observed=by_quantity(TOLERANCES, values),
        tolerances=TOLERANCES,
        figures={"routes": draw},
        columns=COLUMNS,
        rounding=dict.fromkeys(("least_body", "least_waves", "nu_from", "nu_to"), 1e-7),
        findings=findings(table),
    )


def _worst(values: pd.Series, references: pd.Series) -> Observed:
    return farthest_value(values.astype(float), references.astype(float))


def findings(table: pd.DataFrame) -> tuple[str, ...]:
    """How far the volume energy goes, and at what price."""
    rows = table[table["route"] == ADDED]
    told = ", ".join(
        f"{row['lattice']} {row['nu_from']:.3g} to {row['nu_to']:.3g}" for _, row in rows.iterrows()
    )
    slow = ", ".join(f"{row['step_over']:.2g} ({row['lattice']})" for _, row in rows.iterrows())
    said = (
        f"By {ADDED} free bodies are stable with ratios along the axes of {told}. Forces of a "
        f"point depend on {rows['coupled'].min():.3g} to {rows['coupled'].max():.3g} others; "
        f"the largest time step, over that of springs of one μ at Cauchy's ratio, is {slow}."
    )
    return (said,)


def measure(way: Way) -> tuple[dict[str, object], float]:
    """A row of the table, and the least of what is added by Fourier sums (0 if nothing is)."""
    pattern = way.pattern
    d = pattern.dim
    cauchy, probe = CAUCHY[d], PROBE[d] if way.route == ADDED else CAUCHY[d]
    alone = way._replace(route="springs")
    springs, plain = calibrate_way(alone, cauchy), calibrated_waves(alone, cauchy)
    whole = calibrated_waves(way, probe)
    # The modulus of a calibration is 1: μ = 1/(2 (1 + nu)).
    over = waves.highest(whole) / waves.highest(plain) * (1 + probe) / (1 + cauchy)
    head: dict[str, object] = {"lattice": pattern.name, "route": way.route}
    least, fourier = (
        limits(way, springs) if way.route == ADDED else (dict.fromkeys(LEAST, "none"), 0.0)
    )
    ends = (
        (cauchy, cauchy)
        if way.route != ADDED
        else reachable_ratios(way, float(str(least[LEAST[2]])))
    )
    row = (
        head
        | least
        | {
            "nu_from": ends[0],
            "nu_to": ends[1],
            "coupled": whole.coupled,
            "nu_of_wave": probe,
            "omega2_m_over": over,
            "omega2_theory_over": (2 * probe / (1 - (d - 1) * probe) + 2) / 3
            if way.lattice in ALIGNED
            else "none",
            "step_over": over**-0.5,
        }
    )
    return row, fourier


def limits(way: Way, springs: Calibration) -> tuple[dict[str, object], float]:
    """Least κ/μ beside `springs`, by moduli, waves and a body."""
    pattern = way.pattern
    d = pattern.dim
    mu = 1 / (2 * (1 + springs.nu))
    added = replace(springs, volume=mu)
    plain = calibrated_waves(way._replace(route="springs"), springs.nu)
    by_waves = waves.least_part(plain, wave_stiffness(pattern, added).less(plain))
    values = (-(1 + 2 / d), by_waves, of_body(way, springs, added))
    return dict(zip(LEAST, values, strict=True)), (
        least_stable_volume(pattern, springs.constants) / mu
    )


def calibrate_way(way: Way, nu: float) -> Calibration:
    """Modulus 1 and a ratio, along the lattice's own axes."""
    state: State = "plane_stress" if way.pattern.dim == 2 else "solid"
    return calibrate(1.0, nu, way.pattern, state, route=way.route)


def stiffness(lattice: Lattice, found: Calibration) -> csr_array:
    """Stiffness (n·d, n·d) of a free body, at rest."""
    box = cases.box_of(lattice)
    problem = loading.uniform(box, Anisotropic(found.tensor), (0, 0), 0.0)
    network = lattice_network(problem, lattice, found)
    return tangent(network, network.points)


@cache
def calibrated_waves(way: Way, nu: float) -> waves.Stencil:
    """The same of modulus 1 and a ratio; springs alone are asked for by every route."""
    return wave_stiffness(way.pattern, calibrate_way(way, nu))


def wave_stiffness(pattern: Pattern, found: Calibration) -> waves.Stencil:
    """What couples the points of a cell of the endless lattice with others."""
    lattice = waves.block(pattern)
    return waves.stencil(pattern, lattice, stiffness(lattice, found))


def of_body(way: Way, springs: Calibration, added: Calibration) -> float:
    """Least multiple of what is added for which no motion of a free body gains energy."""
    pattern = way.pattern
    d = pattern.dim
    base = np.array(cases.proportions(pattern.size))
    cells = base * max(1, round(BODY[d] / base.max()))
    size = cells * np.array(pattern.size)
    lattice = fill(pattern, Box(tuple(size.tolist())), tuple(cells.tolist()))
    K = stiffness(lattice, springs)
    more = (stiffness(lattice, added) - K).toarray()
    values, modes = eigh(K.toarray())
    rigid = d * (d + 1) // 2
    scaled = modes[:, rigid:] / np.sqrt(values[rigid:])
    return float(-1 / eigvalsh(scaled.T @ more @ scaled)[-1])


def reachable_ratios(way: Way, least: float) -> tuple[float, float]:
    """Lowest and highest ratio along the axes that a least part leaves open."""
    d = way.pattern.dim
    low = max(-1.0, (least + 1) / (d + 1 + (d - 1) * least)) if least > LOWEST[d] else -1.0
    return low, 1 / (d - 1)
