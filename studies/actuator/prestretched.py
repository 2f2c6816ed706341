"""Pre-stretch: is a pre-stretched, fully covered film nearly a uniform compression?

Question   "For DEA with pre-stretching along area directions has nearly uniform force distribution,
           result should be like a simple compression case": how much of a film is compressed alike,
           and pulled alike, and is it the pre-stretch that does it?
Candidate  The actuator at rest: a slab six times as long as high, stretched by up to 2, then bonded
           and its ends held by a frame; beside them films never stretched, but as slender.
Reference  Closed form of a film that strains as a whole; finite elements at large strain, whose law
           is that of the stretched fibres.
Expected   Edges disturb about a height on either side at each stretch; a stretch makes a film
           longer and thinner, so less of it is margin. The compression is uniform because the film
           is slender, not because it is stretched.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import pandas as pd

from msvalidate import kit
from msvalidate.dielectric.actuator import Actuator, slab, uniform
from msvalidate.dielectric.actuator.models import charge_actuator
from reference_fem import facing_slab
from reference_fem.actuator import SoftSlab, equilibrium_at
from reference_fem.large_strain import Law, Solid, square_fibres

from . import prestretched_drawing
from .bodies import AXIAL, DIAGONAL, HEIGHT, LENGTH, ActuatorSolver, springs, upper_face

STRETCHES, QUICK_STRETCHES = (1.0, 1.5, 2.0), (1.0, 2.0)
LAYERS, QUICK_LAYERS = 10, 6
THINNING = 0.02
"""Part by which the voltage makes a film thinner that strains as a whole."""
ALIKE = 0.05
"""Part of the middle's value within which a place counts as like it."""
NEARLY = 0.8
"""Part of the film that must be alike for the remark to hold."""
RULES = (
    kit.Rule(
        "pre-stretched films: thinning of the middle over that of a uniform film", 0.03, "1",
        "the margin of a film six heights long still lifts the middle by 1.6 %, as finite elements "
        "show; that of longer ones by nothing that can be seen",
        table="prestretched", value="thinning", reference=1.0,
    ),
    kit.Rule(
        "pre-stretched films: thinning of the middle, springs over FEM", 0.003, "1",
        "three heights from the margin it still lifts the middle by exp(-0.9·3) of a quarter, 1.7 "
        "%, of which springs, of order 1, miss a sixth with the 6 layers of the small form",
        layer="agreement",
        table="prestretched", value=kit.Quotient("thinning", "thinning_fem"), reference=1.0,
    ),
    kit.Rule(
        "pre-stretched films: margin in heights, springs - FEM", 0.5, "1",
        "a cell of the lattice, which a stretch by 2 makes 0.45 of a film of 6 layers",
        layer="agreement",
        table="prestretched", value="margin_heights", reference="margin_heights_fem",
    ),
)  # fmt: skip


@dataclass(frozen=True)
class Film:
    """A film to bond: its length before the stretch (m), and the stretch."""

    length: float
    stretch: float
    name: str

    @property
    def height(self) -> float:
        """Once stretched (m)."""
        return HEIGHT * uniform.relaxed_thickness(self.stretch, axial=AXIAL, diagonal=DIAGONAL)

    @property
    def voltage(self) -> float:
        """V."""
        ratio = self.height / HEIGHT * (1 - THINNING)
        return uniform.voltage(ratio, height=HEIGHT, stretch=self.stretch)

    def bonded(self, layers: int) -> Actuator:
        """The film as an actuator of springs, fully covered, its ends held along it by a frame."""
        how: dict[str, Any] = {"prestretch": self.stretch, "sides": "sliding"}
        return slab(self.length, HEIGHT, layers, axial=AXIAL, diagonal=DIAGONAL, **how)


@dataclass(frozen=True, eq=False)
class Framed(SoftSlab):
    """A soft slab whose ends a frame holds along it, and lets slide up and down."""

    @cached_property
    def solid(self) -> Solid:
        """The slab with its supports."""
        (x, y), near = self.body.points.T, self.slab.tolerance
        held = np.repeat((np.abs(y) <= near)[:, None], 2, axis=1)
        held[np.minimum(x, self.slab.length - x) <= near, 0] = True
        return Solid(self.body, self.law, held, self.depth)


@dataclass(frozen=True, eq=False)
class Stretched:
    """A law of bodies that are already stretched: W(F·F0)/det F0, F0 the stretch (d, d)."""

    law: Law
    F0: kit.Array

    @property
    def dim(self) -> int:
        """Number of axes."""
        return self.law.dim

    def energy(self, F: kit.Array) -> kit.Array:
        """W (q,) in J/m³ of the stretched body."""
        return np.asarray(self.law.energy(F @ self.F0) / np.linalg.det(self.F0))

    def stress(self, F: kit.Array) -> kit.Array:
        """P (q, d, d) in Pa."""
        found = self.law.stress(F @ self.F0) @ self.F0.T
        return np.asarray(found / np.linalg.det(self.F0))

    def tangent(self, F: kit.Array) -> kit.Array:
        """A (q, d, d, d, d) in Pa."""
        A = self.law.tangent(F @ self.F0)
        found = np.einsum("qiJkL,aJ,bL->qiakb", A, self.F0, self.F0, optimize=True)
        return np.asarray(found / np.linalg.det(self.F0))


def films(stretches: tuple[float, ...], layers: int) -> tuple[Film, ...]:
    """Stretched films, and as slender ones that were never stretched (to a whole cell)."""
    stretched = [Film(LENGTH, stretch, "stretched") for stretch in stretches]
    cell = HEIGHT / layers
    as_long = [
        Film(cell * round(one.stretch * LENGTH * HEIGHT / (one.height * cell)), 1.0, "as slender")
        for one in stretched[1:]
    ]
    return (*stretched, *as_long)


def run(candidate: ActuatorSolver = springs, setting: kit.Setting = kit.FULL) -> kit.Evidence:
    """Compress every film by its voltage."""
    stretches, layers = (QUICK_STRETCHES, QUICK_LAYERS) if setting.quick else (STRETCHES, LAYERS)
    found = [measure_film(candidate, film, layers) for film in films(stretches, layers)]
    table = pd.DataFrame([row for row, _ in found])
    return kit.Evidence(
        tables={"prestretched": table},
        tolerances=RULES,
        drawn={"prestretched_faces": pd.concat([face for _, face in found], ignore_index=True)},
        figures={"prestretched": prestretched_drawing.faces},
        columns=kit.columns(__file__),
        findings=(finding(table),),
    )


def measure_film(
    candidate: ActuatorSolver, film: Film, layers: int
) -> tuple[dict[str, object], pd.DataFrame]:
    """Row of a film, and its upper face."""
    actuator = film.bonded(layers)
    points, volts = actuator.network.points, film.voltage
    top = upper_face(points)
    rest, now = (candidate(actuator, voltage) for voltage in (0.0, volts))
    sunk = (rest - now)[top, 1]
    pull = pull_on_electrode(actuator, volts, points + now)
    x = points[top, 0]
    fem = deflection_by_elements(film, layers, points[top])
    middle = len(top) // 2
    row: dict[str, object] = {"prestretch": film.stretch, "film": film.name}
    row |= {"slenderness": x.max() / film.height, "film_voltage": volts}
    row |= {"thinning": sunk[middle] / (THINNING * film.height)}
    row |= {"thinning_fem": fem[middle] / (THINNING * film.height)}
    row |= {
        "alike": similar_fraction(x, sunk),
        "alike_fem": similar_fraction(x, fem),
        "pulled_alike": similar_fraction(x, pull),
    }
    for suffix in ("", "_fem"):
        part = float(str(row[f"alike{suffix}"]))
        row[f"margin_heights{suffix}"] = 0.5 * (1 - part) * x.max() / film.height
    row["like_compression"] = "yes" if float(str(row["alike"])) >= NEARLY else "no"
    face = pd.DataFrame({"prestretch": film.stretch, "film": film.name, "part": x / x.max()})
    face["slenderness"] = x.max() / film.height
    face["deflection"], face["pull"] = sunk / sunk[middle], pull / pull[middle]
    return row, face


def pull_on_electrode(actuator: Actuator, voltage: float, position: kit.Array) -> kit.Array:
    """Force down (p,) per length on the upper electrode's points, from left to right (N/m)."""
    electric, (top, _) = charge_actuator(actuator, position, voltage), actuator.electrodes
    down = -electric.forces()[: len(top), 1]
    return np.asarray(down / np.gradient(position[top, 0]))


def deflection_by_elements(film: Film, layers: int, places: kit.Array) -> kit.Array:
    """Deflection (p,) in m by the voltage at places (p, 2) on the upper face, finite elements."""
    F0 = np.diag([film.stretch, film.height / HEIGHT])
    slab = facing_slab(film.stretch * film.length, film.height)
    law = Stretched(square_fibres(AXIAL, DIAGONAL), F0)
    soft = Framed(slab, law, layers + layers % 2, element="Q1", grading=1.0)
    # In its frame the stretched film is at rest as it is, without a voltage.
    return -equilibrium_at(soft, film.voltage).at(places)[:, 1]


def similar_fraction(x: kit.Array, values: kit.Array) -> float:
    """Part of a film, around its middle, where values are like the middle's; linear between points.

    Left and right are looked at alone, and their mean is taken.
    """
    middle = len(x) // 2
    reach = []
    for way in (1, -1):
        along, away = x[middle::way], np.abs(values[middle::way] / values[middle] - 1)
        beyond = np.flatnonzero(away > ALIKE)
        if not len(beyond):
            reach.append(abs(along[-1] - along[0]))
            continue
        i = beyond[0]
        step = (ALIKE - away[i - 1]) / (away[i] - away[i - 1])
        reach.append(abs(along[i - 1] + step * (along[i] - along[i - 1]) - along[0]))
    return float(sum(reach) / (x.max() - x.min()))


def finding(table: pd.DataFrame) -> str:
    """What the remark comes to."""
    stretched = table[table["film"] == "stretched"]
    parts = ", ".join(
        f"{100 * part:.0f} % at a stretch of {stretch:g}"
        for part, stretch in zip(stretched["alike"], stretched["prestretch"], strict=True)
    )
    never = table[table["film"] != "stretched"].iloc[-1]
    return (
        f"A fully covered film is compressed alike over {parts} of its length; one as slender that "
        f"was not stretched over {100 * never['alike']:.0f} %. The margin is "
        f"{table['margin_heights'].min():.1f} to {table['margin_heights'].max():.1f} heights wide "
        "on either side: what makes the compression nearly uniform is that a stretched film is "
        "slender."
    )
