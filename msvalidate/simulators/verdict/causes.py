"""What is said of a simulator, from what was read and what bodies owe to what."""

from __future__ import annotations

from msvalidate.problem import Isotropic
from msvalidate.simulators.bodies.bodies import EVEN, MORE, BodyRow
from msvalidate.simulators.bodies.large_strain import AtLargeStrain
from msvalidate.simulators.bodies.laws import LAWS, nearest_law
from msvalidate.simulators.gate.gate import GateRow
from msvalidate.simulators.probe.reading import BAND, SHOWN, Reading
from msvalidate.simulators.verdict.sentences import Cause
from msvalidate_check.causes import Phrase, phrase
from msvalidate_check.verdict import AGREES, NOT_AT_REST, Verdict

CAUSE = "differs with cause"
NOT_EXPLAINED = "not explained"
STOPPED = "gate"
NOTHING, OVER_DENSITY = Phrase(""), Phrase("over density")


def rows_verdict(
    material: Isotropic,
    predicted: tuple[float, float] | None,
    reading: Reading | None,
    law: tuple[float, float] | None,
    rows: tuple[BodyRow, ...] | None,
    large: AtLargeStrain | None,
    *,
    linear: bool = True,
    moving: float = 0.0,
) -> Verdict:
    """What the simulator is, and the causes, from what differs from what was asked.

    `rows` are None where no body was asked for, and empty where none could be represented. Of
    elements that are not `linear` what they are off by is told: it is by design, and no mesh's.
    `moving` is the part of the displacement of the gate's block that running longer changes: where
    there is one, nothing of the bodies is known. Where there is none, what is left of a body is not
    known where it is less than what the simulator says may still change.
    """
    missing, rows = rows == (), rows or ()
    residual_motion = max([moving, *(row.rest for row in rows if row.rest > BAND)])
    still = _residual_motion_causes(residual_motion)
    causes = [
        *_law_causes(material, reading, law),
        *still,
        *_factor_causes(rows, linear=linear),
        *(_rounded(row) for row in rows if row.is_rounded),
    ]
    left = [row for row in rows if not row.is_explained and not row.is_rounded]
    open_rows = [row for row in left if not moving and not row.may_settle]
    unread = reading is not None and not reading.is_valid
    band = BAND if reading is None else max(BAND, reading.shown)
    other = []
    if predicted is not None and law is not None and not _alike(law, predicted, band):
        said = dict(zip(("said_E", "said_nu"), predicted, strict=True))
        other.append(Cause("documents", law[0], phrase("documents", E=law[0], nu=law[1], **said)))
    if large is not None and large.apart > max(BAND, large.rest) and not moving:
        of = phrase("large strain", strain=large.strain, apart=large.apart)
        other.append(Cause("large strain", large.apart, of))
    if open_rows or unread or other or missing:
        causes += [*other, *map(_open, open_rows)]
        causes += [Cause("bodies", of=phrase("no bodies"))] if missing else []
        return Verdict(NOT_EXPLAINED, tuple(dict.fromkeys(causes)))
    if moving or left or (residual_motion and len(causes) == 1):
        return Verdict(NOT_AT_REST, tuple(dict.fromkeys([*still, *causes])))
    return Verdict(CAUSE if causes else AGREES, tuple(dict.fromkeys(causes)))


def stop_verdict(stops: tuple[GateRow, ...]) -> Verdict:
    """What stopped a simulator at the gate, and by how much."""
    found = []
    for row in stops:
        if row.unit:
            said = {"value": row.value, "unit": row.unit, "limit": row.limit}
            of = phrase("gate", row=row.name, **said, because=row.because)
            found.append(Cause("gate", row.value, of))
        else:
            of = phrase("gate failed", row=row.name, because=row.because)
            found.append(Cause("gate failed", of=of))
    return Verdict(STOPPED, tuple(found) or (Cause("nothing passed", of=phrase("nothing passed")),))


def _rounded(row: BodyRow) -> Cause:
    """A body whose positions are too coarse for what it moves."""
    apart = float("nan") if row.factors is None else row.factors.apart
    of = phrase(
        "rounded", apart=apart, case=row.case, mesh=row.mesh, loaded=row.loaded_more, times=MORE
    )
    return Cause("rounding", apart, of)


def _residual_motion_causes(residual_motion: float) -> list[Cause]:
    """That this part of a displacement may still change; nothing within the band."""
    whole = residual_motion >= 1
    part = phrase("all") if whole else phrase("percent", percent=100 * residual_motion)
    found = Cause("rest", residual_motion, phrase("moving", part=part))
    return [found] if residual_motion > BAND else []


def _open(row: BodyRow) -> Cause:
    """A body that the causes do not explain."""
    where = {"case": row.case, "mesh": row.mesh}
    if row.factors is None:
        return Cause("body", of=phrase("no law", **where))
    if row.even > EVEN:
        return Cause("one way", row.even, phrase("one way", **where, even=row.even))
    shape = NOTHING if row.shape is None else phrase("shape", cause=row.shape)
    of = phrase("unexplained", **where, apart=row.factors.apart, shape=shape)
    return Cause("body", row.factors.apart, of)


def is_over_density(part: float, density: float) -> bool:
    """Whether a modulus or mass is this part of what was asked as it is over the density."""
    return abs(part * density - 1) <= BAND and abs(density - 1) > BAND


def _law_causes(
    material: Isotropic, reading: Reading | None, law: tuple[float, float] | None
) -> list[Cause]:
    found, shown = [], SHOWN if reading is None else reading.shown
    if reading is not None and not reading.is_valid:
        found.append(Cause("reading", of=phrase("refused", refusals=reading.refusals())))
    elif reading is not None and reading.E is None:
        found.append(Cause("no solid", of=phrase("no solid", because=reading.elastic.because)))
    if reading is not None and reading.is_bound:
        found.append(Cause("bound", of=phrase("bound")))
    if law is not None and not _alike(law, (material.E, material.nu), shown):
        near, times = nearest_law(*law, material.E, material.nu), law[0] / material.E
        of = phrase(
            "law",
            times=times,
            nu=law[1],
            given=material.nu,
            near=phrase("near law", name=near, key=LAWS[near].key) if near else NOTHING,
            over=OVER_DENSITY if is_over_density(times, material.density) else NOTHING,
        )
        found.append(Cause("law", times, of))
    masses = reading.masses if reading is not None else None
    if masses is not None and masses.off > max(BAND, masses.error + shown - SHOWN):
        of = phrase("masses", pattern=masses.words, spread=masses.spread)
        found.append(Cause("mass", masses.off, of))
    return found


def _factor_causes(rows: tuple[BodyRow, ...], *, linear: bool) -> list[Cause]:
    """Mass, solver, and elements by design, where they do more than the band in a body."""
    found = []
    for name in ("mass", "solver") if linear else ("mass", "solver", "resolution"):
        each = [getattr(row.factors, name) for row in rows if row.factors is not None]
        worst = max(each, key=lambda one: abs(one - 1), default=1.0)
        if abs(worst - 1) > BAND:
            found.append(Cause(name, worst, phrase("factor", name=name, times=worst)))
    return found


def _alike(one: tuple[float, float], other: tuple[float, float], band: float) -> bool:
    return abs(one[0] / other[0] - 1) <= band and abs(one[1] - other[1]) <= band
