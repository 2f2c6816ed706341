"""Controls: which faults does the study notice, by which quantity, and how small may they be?

Question   Every fault that it must notice; and the smallest one of each kind.
Candidate  The springs' linear response to forces with one known fault, or of a faulty network.
Reference  The tolerances of `profile`.
Expected   Forces and stiffnesses that are wrong by a part p are seen in the limit of fine lattices,
           as far as the extrapolation reaches: some parts in a thousand. What only moves forces
           within a spring leaves the limit as it is, and shows in how fast it is reached.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import pandas as pd

from msvalidate import kit
from msvalidate.bench.judging.evidence import judge
from msvalidate.dielectric.actuator import Actuator
from msvalidate.dielectric.actuator.models import charge_actuator

from . import profile
from .bodies import ActuatorSolver, Spoil, linear_response


def weaken_forces(size: float, actuator: Actuator, pull: kit.Array) -> kit.Array:
    """Forces smaller by the part `size`."""
    return (1 - size) * pull


def swap_faces(size: float, actuator: Actuator, pull: kit.Array) -> kit.Array:
    """The part `size` of the way from each electrode's forces to those of the face across."""
    top, bottom = actuator.electrodes
    x = actuator.network.start[:, 0]
    own, across = np.split(pull, [len(top)])
    seen = [
        np.column_stack([np.interp(x[there], x[other], part) for part in force.T])
        for there, other, force in ((top, bottom, across), (bottom, top, own))
    ]
    return (1 - size) * pull + size * np.concatenate(seen)


def halve_to_ends(size: float, actuator: Actuator, pull: kit.Array) -> kit.Array:
    """The part `size` of the way to charge times the field at each middle, half to each end."""
    charges = charge_actuator(actuator, actuator.network.start, 1.0).charges
    electrodes = charges.moments.electrodes
    force = actuator.depth * charges.charge[:, None] * charges.field(electrodes.middle)
    halves = np.zeros_like(pull)
    for end in electrodes.segments.T:
        np.add.at(halves, end, 0.5 * force)
    return (1 - size) * pull + size * scale_of(actuator, pull) * halves


def without_edge_force(size: float, actuator: Actuator, pull: kit.Array) -> kit.Array:
    """The part `size` of the force along the electrode left out at its edges."""
    (top, _), less = actuator.electrodes, np.array(pull)
    less[[0, len(top) - 1], 0] *= 1 - size
    return less


def stiffer(size: float, actuator: Actuator, voltage: float) -> kit.Array:
    """Every spring stiffer by the part `size`."""
    faulty = replace(actuator, network=actuator.network.scaled(1 + size))
    return linear_response(None, faulty, voltage)


def report_charges(size: float, actuator: Actuator, pull: kit.Array) -> kit.Array:
    """The part `size` of the way to the report's charges and point forces, springs 1 m deep."""
    here, volts = actuator.network.start, scale_of(actuator, pull)
    as_report = replace(actuator, model="as_report")
    return (1 - size) * pull + size * volts * charge_actuator(as_report, here, 1.0).forces()


def forces_without_air(size: float, actuator: Actuator, pull: kit.Array) -> kit.Array:
    """The part `size` of the way to the forces without air: on the electrodes alone."""
    plane = replace(actuator, model="plane")
    here, volts = actuator.network.start, scale_of(actuator, pull)
    electric, air = charge_actuator(plane, here, 1.0), charge_actuator(actuator, here, 1.0)
    spread = np.zeros_like(here)
    spread[electric.loaded] = electric.forces()
    return (1 - size) * pull + size * volts * spread[air.loaded]


def scale_of(actuator: Actuator, pull: kit.Array) -> float:
    """Square of the voltage (V²) that makes the forces (k, 2) of the actuator at its start."""
    unit = charge_actuator(actuator, actuator.network.start, 1.0).forces()
    return float(np.vdot(unit, pull) / np.vdot(unit, unit))


@dataclass(frozen=True)
class Kind:
    """A kind of fault: the unit of its size, and what it does to forces; if nothing, to springs."""

    unit: str
    spoil: Callable[[float, Actuator, kit.Array], kit.Array] | None = None

    def spoilt(self, size: float) -> ActuatorSolver:
        """The candidate with a fault of this size."""
        if self.spoil is None:
            return partial(stiffer, size)
        bound: Spoil = partial(self.spoil, size)
        return partial(linear_response, bound)

    def mixed(self, size: float, right: kit.Array, wrong: kit.Array) -> kit.Array:
        """Displacements with a fault of a size, from those without it and with one of size 1."""
        if self.spoil is None:
            return right / (1 + size)
        if self.spoil is weaken_forces:
            return (1 - size) * right
        return (1 - size) * right + size * wrong


KINDS = {
    "forces smaller": Kind("relative", weaken_forces),
    "forces of the other face": Kind("part of the way", swap_faces),
    "forces in halves": Kind("part of the way", halve_to_ends),
    "edge forces left out": Kind("part left out", without_edge_force),
    "the report's charges": Kind("part of the way", report_charges),
    "springs stiffer": Kind("relative"),
    "one medium all around": Kind("part of the way", forces_without_air),
}
ASKED = {
    "forces smaller": 0.02,
    "forces of the other face": 0.02,
    "forces in halves": 1.0,
    "edge forces left out": 0.05,
    "the report's charges": 0.02,
    "springs stiffer": 0.02,
}
"""What the study must notice: kind -> size."""
SLABS = ("partial",)
"""The slab that they are tried on; it has both a free face and straight edges."""
STEPS = (*(m * 10.0**-e for e in range(4, 0, -1) for m in (1, 2, 5)), 1.0)
"""Sizes tried: errors need not grow with a fault, whose sign may be opposite to theirs."""


def run(setting: kit.Setting = kit.FULL) -> kit.Evidence:
    """Try every kind of fault on the small form of one profile, whose answers are linear in it."""
    small = replace(setting, quick=True)
    right = profile.solve_faces(partial(linear_response, None), small, SLABS)
    table = pd.DataFrame([try_fault(name, right, small) for name in ASKED])
    own = (
        kit.Tolerance(
            "actuator: faults that the study must notice and does not", 0.0, "1",
            "a study that cannot fail proves nothing",
            observed=kit.Observed(float((table["noticed"] == "no").sum())),
        ),
    )  # fmt: skip
    return kit.Evidence(
        tables={"controls": table},
        tolerances=own,
        columns=kit.columns(__file__),
        findings=(
            "Smallest faults noticed: "
            + "; ".join(
                f"{row.fault} {row.smallest_noticed} ({row.fault_unit})"
                for row in table.itertuples()
            )
            + ".",
        ),
    )


def try_fault(name: str, right: dict[str, profile.Face], small: kit.Setting) -> dict[str, object]:
    """Row of a kind of fault."""
    kind = KINDS[name]
    needed = kind.spoil not in (None, weaken_forces)  # those scale the right answer
    wrong = profile.solve_faces(kind.spoilt(1.0), small, SLABS) if needed else right

    def failing(size: float) -> list[str]:
        verdict = judge(profile.evidence(mix_faces(kind, size, right, wrong)))
        return list(verdict.loc[verdict["verdict"] == "fail", "quantity"])

    found = next(((size, by) for size in STEPS if (by := failing(size))), None)
    row: dict[str, object] = {"fault": name, "fault_unit": kind.unit, "asked": ASKED[name]}
    row |= {"noticed": "yes" if failing(ASKED[name]) else "no"}
    row |= {"smallest_noticed": found[0] if found else "none"}
    return row | {"noticed_by": found[1][0] if found else "none"}


def mix_faces(
    kind: Kind, size: float, right: dict[str, profile.Face], wrong: dict[str, profile.Face]
) -> dict[str, profile.Face]:
    """Upper faces with a fault of a size; the reference's stay."""
    return {
        covered: {
            key: face
            if key == "FEM"
            else (face[0], kind.mixed(size, face[1], wrong[covered][key][1]), face[2])
            for key, face in faces.items()
        }
        for covered, faces in right.items()
    }
