"""Routes: how far does each way to a Poisson's ratio go, and what does it ask in return?

Question   From which ratio to which a lattice is stable by springs alone and by the volume energy;
           how stiff its stiffest wave is, and with how many points each point is coupled.
Candidate  Springs, and beside them κ of every cell's volume.
Reference  Moduli above zero: κ > -(1 + 2/d) μ, d axes. Waves: those of an endless lattice, from a
           point's own row of stiffness.
Expected   With volumes only the moduli count, for a free block's softest motion is a uniform
           strain. The stiffest wave of cells that follow it alternates along x:
           4 (λ + 2μ) h^(d - 2) = ω² m.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import NamedTuple

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from scipy.linalg import eigh, eigvalsh
from scipy.sparse import csr_array

from msvalidate import kit
from msvalidate.springs.bodies.calibrate import calibrate
from msvalidate.springs.bodies.lattice_network import lattice_network
from msvalidate.springs.constants.calibration import Calibration
from msvalidate.springs.constants.stiffness import CAUCHY
from msvalidate.springs.constants.waves import least_stable_volume
from msvalidate.springs.lattice import Lattice, Pattern, fill, patterns
from msvalidate.springs.network import tangent

from .. import cases, loading
from . import waves

LATTICES = ("square", "triangular", "cubic18", "cubic26", "bcc")
QUICK = ("square", "triangular", "cubic18")
BODY = {2: 8, 3: 3}
"""Cells along an edge, about, of the body whose softest motion is looked for."""
PROBE = {2: 0.45, 3: 0.4}
"""Ratio at which the stiffest waves are compared."""
ALIGNED = ("square", "cubic 18", "cubic 26")
"""Lattices, as tables name them, whose springs cross no side, one point a cell."""
LEAST = ("least_moduli", "least_waves", "least_body")
ADDED = "volume energy"
ROUTES = ("springs", ADDED)
"""Of springs at rest; those under tension are in study `large_strain`."""


class Way(NamedTuple):
    """One lattice and one route."""

    lattice: str
    route: str

    @property
    def pattern(self) -> Pattern:
        """What repeats."""
        make: Callable[[], Pattern] = getattr(patterns, self.lattice)
        return make()


def _by_fourier_sums(rows: pd.DataFrame) -> list[float]:
    """Least κ/μ of the lattices of rows."""
    of = {Way(name, "springs").pattern.name: Way(name, "springs") for name in LATTICES}
    springs = [(of[name].pattern, calibrate_way(of[name])) for name in rows["lattice"]]
    return [
        least_stable_volume(pattern, found.constants) * 2 * (1 + found.nu)
        for pattern, found in springs
    ]


RULES = (
    kit.Rule(
        "volume energy: least κ/μ of free blocks whose springs cross no side, from -(1 + 2/d)",
        1e-9, "1",
        "their softest motion is a uniform strain, which they follow exactly: rounding of an "
        "eigenvalue",
        table="routes", rows={"route": ADDED, "lattice": ALIGNED},
        value="least_body", reference="least_moduli",
    ),
    kit.Rule(
        "least κ/μ of endless lattices, by rows of stiffness and by Fourier sums",
        1e-7, "1",
        "two routes to one eigenvalue; of the stiffness of waves of phase 1e-3 a part of 1e-6 is "
        "left, so that rounding of a hundred terms of 1e-16 makes 1e-8 of it",
        table="routes", rows={"route": ADDED}, value="least_waves", reference=_by_fourier_sums,
    ),
    kit.Rule(
        "volume energy: ω² m of square and cubic lattices, from 4 (λ + 2μ) h^(d - 2), relative",
        1e-10, "1",
        "a wave that alternates along x strains every cell alike: an identity",
        table="routes", rows={"lattice": ALIGNED},
        value="omega2_m_over", reference="omega2_theory_over",
    ),
)  # fmt: skip


def run(setting: kit.Setting) -> kit.Evidence:
    """Find how far each route goes."""
    names = QUICK if setting.quick else LATTICES
    ways = [Way(name, route) for name in names for route in ROUTES]
    table = pd.DataFrame(setting.sweep(measure, ways, "ranges of Poisson's ratio"))
    rows = table[table["route"] == ADDED]
    ranges = ", ".join(
        f"{row['lattice']} {row['nu_from']:.3g} to {row['nu_to']:.3g}" for _, row in rows.iterrows()
    )
    slow = ", ".join(f"{row['step_over']:.2g} ({row['lattice']})" for _, row in rows.iterrows())
    finding = (
        f"By {ADDED} free bodies are stable with ratios along the axes of {ranges}. Forces of a "
        f"point depend on {rows['coupled'].min():.3g} to {rows['coupled'].max():.3g} others; "
        f"the largest time step, over that of springs of one μ at Cauchy's ratio, is {slow}."
    )
    return kit.Evidence(
        {"routes": table},
        tolerances=RULES,
        figures={"routes": draw},
        columns=kit.columns(__file__),
        findings=(finding,),
    )


def measure(way: Way) -> dict[str, object]:
    """A row of the table."""
    pattern = way.pattern
    d = pattern.dim
    cauchy = CAUCHY[d]
    added = way.route == ADDED
    probe = PROBE[d] if added else cauchy
    plain = _waves(way._replace(route="springs"), cauchy)
    whole = _waves(way, probe)
    # The modulus of a calibration is 1: μ = 1/(2 (1 + nu)).
    over = waves.highest(whole) / waves.highest(plain) * (1 + probe) / (1 + cauchy)
    least: dict[str, float | str] = dict.fromkeys(LEAST, "none")
    ends = (cauchy, cauchy)
    if added:
        springs = calibrate_way(way._replace(route="springs"))
        with_mu = replace(springs, volume=1 / (2 * (1 + cauchy)))
        by_waves = waves.least_part(plain, wave_stiffness(pattern, with_mu).less(plain))
        by_body = of_body(pattern, springs, with_mu)
        least = dict(zip(LEAST, (-(1 + 2 / d), by_waves, by_body), strict=True))
        ends = reachable_ratios(way, by_body)
    theory = (2 * probe / (1 - (d - 1) * probe) + 2) / 3
    return {
        "lattice": pattern.name,
        "route": way.route,
        **least,
        "nu_from": ends[0],
        "nu_to": ends[1],
        "coupled": whole.coupled,
        "nu_of_wave": probe,
        "omega2_m_over": over,
        "omega2_theory_over": theory if pattern.name in ALIGNED else "none",
        "step_over": over**-0.5,
    }


def calibrate_way(way: Way, nu: float | None = None) -> Calibration:
    """Modulus 1 and a ratio, by default Cauchy's, along the lattice's own axes."""
    pattern = way.pattern
    nu = CAUCHY[pattern.dim] if nu is None else nu
    return calibrate(
        1.0, nu, pattern, "plane_stress" if pattern.dim == 2 else "solid", route=way.route
    )


def stiffness(lattice: Lattice, found: Calibration) -> csr_array:
    """Stiffness (n·d, n·d) of a free body, at rest."""
    problem = loading.uniform(cases.box_of(lattice), kit.Anisotropic(found.tensor), (0, 0), 0.0)
    network = lattice_network(problem, lattice, found)
    return tangent(network, network.points)


@cache
def _waves(way: Way, nu: float) -> waves.Stencil:
    """`wave_stiffness` of modulus 1 and a ratio; springs alone are asked for by every route."""
    return wave_stiffness(way.pattern, calibrate_way(way, nu))


def wave_stiffness(pattern: Pattern, found: Calibration) -> waves.Stencil:
    """What couples the points of a cell of the endless lattice with others."""
    lattice = waves.block(pattern)
    return waves.stencil(pattern, lattice, stiffness(lattice, found))


def of_body(pattern: Pattern, springs: Calibration, added: Calibration) -> float:
    """Least multiple of what is added for which no motion of a free body gains energy."""
    d = pattern.dim
    base = np.array(cases.proportions(pattern.size))
    cells = base * max(1, round(BODY[d] / base.max()))
    size = cells * np.array(pattern.size)
    lattice = fill(pattern, kit.Box(tuple(size.tolist())), tuple(cells.tolist()))
    K = stiffness(lattice, springs)
    more = (stiffness(lattice, added) - K).toarray()
    values, modes = eigh(K.toarray())
    rigid = d * (d + 1) // 2
    scaled = modes[:, rigid:] / np.sqrt(values[rigid:])
    return float(-1 / eigvalsh(scaled.T @ more @ scaled)[-1])


def reachable_ratios(way: Way, least: float) -> tuple[float, float]:
    """Lowest and highest ratio along the axes that a least κ/μ allows; -(1 + 2/d) gives -1."""
    d = way.pattern.dim
    low = (least + 1) / (d + 1 + (d - 1) * least) if least > -(1 + 2 / d) else -1.0
    return max(-1.0, low), 1 / (d - 1)


def draw(tables: kit.Tables) -> Figure:
    """Ranges of the ratio as bars, a row for each lattice and route."""
    table = tables["routes"]
    figure, (axis,) = kit.figures.new_figure(size=(5.2, 0.27 * len(table) + 1.3))
    names = list(dict.fromkeys(table["lattice"]))
    middle = []
    for place, (_, row) in enumerate(table.iterrows()):
        y = place + 0.6 * names.index(row["lattice"])
        middle.append(y)
        colour = kit.figures.COLOURS[list(ROUTES).index(row["route"])]
        low, high = row["nu_from"], row["nu_to"]
        label = row["route"] if place < len(ROUTES) else None
        if low == high:
            axis.plot([low], [y], "D", color=colour, label=label)
        else:
            axis.barh(y, high - low, left=low, color=colour, height=0.75, label=label)
        words = f"{low:.3g} to {high:.3g}" if low < high else f"{low:.3g}"
        axis.text(high + (0.02 if low < high else 0.05), y, words, va="center", fontsize=7)
    axis.set_yticks(np.reshape(middle, (-1, len(ROUTES))).mean(axis=1), names)
    axis.set(xlim=(-1.05, 1.6), xlabel="Poisson's ratio along the lattice's axes (1)")
    axis.set_ylabel("lattice")
    figure.suptitle("Ranges of Poisson's ratio by each route")
    axis.invert_yaxis()
    axis.grid(visible=False, axis="y")
    kit.figures.add_shared_legend(figure, [axis], columns=3)
    return figure
