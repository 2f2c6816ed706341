"""State and causes: what is said of a simulator from what was read and what bodies owe to what."""

from __future__ import annotations

import math

from msvalidate.problem import Isotropic
from msvalidate.simulators.bodies.bodies import BAND, EVEN, MORE, BodyRow
from msvalidate.simulators.bodies.large_strain import AtLargeStrain
from msvalidate.simulators.bodies.laws import LAWS, nearest_law
from msvalidate.simulators.probe.moduli import SHOWN
from msvalidate.simulators.probe.reading import Reading

AGREES = "agrees"
CAUSE = "differs with cause"
NOT_AT_REST = "not at rest"
NOT_EXPLAINED = "not explained"
STOPPED = "gate"
OVER = ": as E over the density; then divide forces by it too"
STATES = (AGREES, CAUSE, NOT_AT_REST, NOT_EXPLAINED, STOPPED)


def state_and_causes(
    material: Isotropic,
    predicted: tuple[float, float] | None,
    reading: Reading | None,
    law: tuple[float, float] | None,
    rows: tuple[BodyRow, ...] | None,
    large: AtLargeStrain | None,
    *,
    linear: bool = True,
    moving: float = 0.0,
) -> tuple[str, tuple[str, ...]]:
    """One of `STATES` and the causes in words, from what differs from what was asked.

    `rows` are None where no body was asked for, and empty where none could be represented. Of
    elements that are not `linear` what they are off by is told: it is by design, and no mesh's.
    `moving` is the part of the displacement of the gate's block that running longer changes: where
    there is one, nothing of the bodies is known. Where there is none, what is left of a body is not
    known where it is less than what the simulator says may still change.
    """
    missing, rows = rows == (), rows or ()
    residual_motion = max([moving, *(row.rest for row in rows if row.rest > BAND)])
    found = _law_causes(material, reading, law)
    causes = [
        *found,
        *_residual_motion_causes(residual_motion),
        *_factor_causes(rows, linear=linear),
    ]
    left = [row for row in rows if not row.is_explained and not row.is_rounded]
    open_rows = [row for row in left if not moving and not row.may_settle]
    causes += [_rounded_words(row) for row in rows if row.is_rounded]
    unread = reading is not None and not reading.is_valid
    band = BAND if reading is None else max(BAND, reading.shown)
    off = predicted is not None and law is not None and not _alike(law, predicted, band)
    if off and predicted is not None and law is not None:
        causes.append(
            f"law: read as E {law[0]:.4g} Pa, nu {law[1]:.4g}; its documents say "
            f"{predicted[0]:.4g} Pa, {predicted[1]:.4g}"
        )
    other = large is not None and large.apart > max(BAND, large.rest) and not moving
    if other and large is not None:
        causes.append(
            f"law: at {large.strain:.2g} strain {large.apart:.2g} of the displacement from "
            "elements of its documented law"
        )
    if open_rows or unread or off or other or missing:
        causes += [_open_words(row) for row in open_rows]
        causes += ["bodies at rest: it could represent none of them"] if missing else []
        return NOT_EXPLAINED, tuple(dict.fromkeys(causes))
    if moving or left or (residual_motion and len(causes) == 1):
        return NOT_AT_REST, tuple(
            dict.fromkeys([*_residual_motion_causes(residual_motion), *causes])
        )
    return (CAUSE if causes else AGREES), tuple(dict.fromkeys(causes))


def _rounded_words(row: BodyRow) -> str:
    """What is said of a body whose positions are too coarse for what it moves."""
    apart = math.nan if row.factors is None else row.factors.apart
    return (
        f"solver: positions in float32, {apart:.2g} of the displacement of {row.case} on "
        f"{row.mesh}, {row.loaded_more:.2g} under {MORE:g} times the loads"
    )


def _residual_motion_causes(residual_motion: float) -> list[str]:
    """What is said where this part of a displacement may still change; nothing within the band."""
    part = f"{residual_motion:.0%}" if residual_motion < 1 else "all"
    said = f"solver: run longer: {part.replace('%', ' %')} of a displacement may still change"
    return [said] if residual_motion > BAND else []


def _open_words(row: BodyRow) -> str:
    """What is said of a body that the causes do not explain."""
    where = f"{row.case} on {row.mesh}"
    if row.factors is None:
        return f"{where}: no law to hold it against"
    if row.even > EVEN:
        return f"{where}: {row.even:.2g} of the displacement goes one way, whatever the loads"
    shape = f": {row.shape}" if row.shape else ""
    return f"{where}: {row.factors.apart:.2g} of the displacement not explained{shape}"


def is_over_density(part: float, density: float) -> bool:
    """Whether a modulus or mass is this part of what was asked as it is over the density."""
    return abs(part * density - 1) <= BAND and abs(density - 1) > BAND


def _law_causes(
    material: Isotropic, reading: Reading | None, law: tuple[float, float] | None
) -> list[str]:
    found, shown = [], SHOWN if reading is None else reading.shown
    if reading is not None and not reading.is_valid:
        found.append(f"law: {'; '.join(reading.refusals())}")
    elif reading is not None and reading.E is None:
        found.append(f"law: no solid at rest; {reading.elastic.because}")
    if reading is not None and reading.is_bound:
        found.append("law: uniform strain pulls at inner nodes, so it is of no one solid")
    if law is not None and not _alike(law, (material.E, material.nu), shown):
        near, over = nearest_law(*law, material.E, material.nu), law[0] / material.E
        found.append(
            f"law: E {law[0] / material.E:.4g} times the asked, nu {law[1]:.4g} for {material.nu:g}"
            f"{f': as {near} (--law {LAWS[near].key})' if near else ''}"
            f"{OVER if is_over_density(over, material.density) else ''}"
        )
    masses = reading.masses if reading is not None else None
    if masses is not None and masses.off > max(BAND, masses.error + shown - SHOWN):
        found.append(f"mass: {masses.pattern}; {masses.spread}")
    return found


def _factor_causes(rows: tuple[BodyRow, ...], *, linear: bool) -> list[str]:
    """Mass, solver, and elements by design, where they do more than the band in a body."""
    found = []
    for name in ("mass", "solver") if linear else ("mass", "solver", "resolution"):
        each = [getattr(row.factors, name) for row in rows if row.factors is not None]
        worst = max(each, key=lambda one: abs(one - 1), default=1.0)
        if abs(worst - 1) > BAND:
            found.append(f"{name}: {worst:.4g} times the displacement")
    return found


def _alike(one: tuple[float, float], other: tuple[float, float], band: float) -> bool:
    return abs(one[0] / other[0] - 1) <= band and abs(one[1] - other[1]) <= band
