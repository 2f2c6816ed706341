"""Verdict on a simulator by its probe and causes of errors."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable

from msvalidate.problem import Isotropic
from msvalidate.simulators.bodies.bodies import EVEN, MORE, BodyRow
from msvalidate.simulators.bodies.large_strain import AtLargeStrain
from msvalidate.simulators.bodies.laws import LAWS, nearest_law
from msvalidate.simulators.gate.rows import TIMES, UNSTATED, Gate, GateRow, size_rows
from msvalidate.simulators.probe.reading import BAND, DAMPING, SHOWN, Reading
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
    gate: Gate,
    linear: bool = True,
) -> Verdict:
    """Determine the state of a simulator and the causes of its differences.

    `rows` are None where no body was asked for, and empty where none could be represented. Of
    elements that are not `linear` what they are off by is told: it is by design, and no mesh's.
    If the displacement of the `gate`'s block is not converged, nothing of the bodies is known. Else
    what is left of a body is not known where it is less than what the simulator says may still
    change. Causes of that come first, before those of material and scale.
    """
    missing, rows, moving = rows == (), rows or (), gate.moving
    change = max([moving, *(row.rest for row in rows if row.rest > BAND)])
    still = convergence_causes(gate, change)
    pulled = law[0] if law else next((r.on_mesh.E for r in rows if r.body == "pulled"), 0.0)
    total = law[0] / reading.E if law and reading and reading.E else 1.0
    units = _gate_causes(gate.units or size_rows("body", pulled / material.E))
    causes = [
        *(units if gate.shows_units else []),
        *still,
        *_law_causes(material, reading, law, rows),
        *units,
        *_factor_causes(rows, total, linear=linear),
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
        causes += [*other, *_shape_causes(open_rows), *map(_open, open_rows)]
        causes += [Cause("bodies", of=phrase("no bodies"))] if missing else []
        return Verdict(NOT_EXPLAINED, tuple(dict.fromkeys(causes)))
    if left or still:
        return Verdict(NOT_AT_REST, tuple(dict.fromkeys(causes)))
    return Verdict(CAUSE if causes else AGREES, tuple(dict.fromkeys(causes)))


def stop_verdict(gate: Gate) -> Verdict:
    """Report what stopped a simulator; units come first if a short step shows them."""
    units, still = _gate_causes(gate.units), convergence_causes(gate)
    first = [*units, *still] if gate.shows_units else [*still, *units]
    found = [*first, *_gate_causes(gate.stops)]
    return Verdict(STOPPED, tuple(found) or (Cause("nothing passed", of=phrase("nothing passed")),))


def _rounded(row: BodyRow) -> Cause:
    """A body whose positions are too coarse for what it moves."""
    apart = float("nan") if row.factors is None else row.factors.apart
    of = phrase(
        "rounded", apart=apart, case=row.case, mesh=row.mesh, loaded=row.loaded_more, times=MORE
    )
    return Cause("rounding", apart, of)


def convergence_causes(gate: Gate, change: float = 0.0) -> list[Cause]:
    """Causes of a displacement that is not converged, by this part or by tests."""
    change = max(change, gate.unconverged.value if gate.unconverged else 0.0)
    if change <= UNSTATED:
        return []
    part = phrase("all") if change >= 1 else phrase("percent", percent=100 * change)
    rival = " or" if len(gate.remedies) > 1 else ""
    return [
        Cause(each, change, phrase(f"not converged {each}{rival}", part=part))
        for each in gate.remedies
    ]


def _gate_causes(rows: Iterable[GateRow]) -> list[Cause]:
    """Rows of the gate as causes."""
    named = [("units" if r.unit == TIMES else "gate" if r.unit else "gate failed", r) for r in rows]
    return [Cause(kind, r.value, phrase(kind, row=r.name, **vars(r))) for kind, r in named]


def _open(row: BodyRow) -> Cause:
    """A body that the causes do not explain."""
    where = {"case": row.case, "mesh": row.mesh}
    if row.factors is None:
        return Cause("body", of=phrase("no law", **where))
    if row.even > EVEN:
        return Cause("one way", row.even, phrase("one way", **where, even=row.even))
    of = phrase("unexplained", **where, apart=row.factors.apart)
    return Cause("body", row.factors.apart, of)


def _shape_causes(rows: list[BodyRow]) -> list[Cause]:
    """Rivals that explain the most bodies, then those of the other bodies."""
    causes: list[Cause] = []
    while rivals := [each for row in rows for each in row.shapes]:
        counts = Counter(each.kind for each in rivals)
        best = {e.kind: e for e in rivals if counts[e.kind] == max(counts.values())}
        causes += [Cause(e.kind, e.value, phrase("rival", cause=e)) for e in best.values()]
        rows = [row for row in rows if not any(each.kind in best for each in row.shapes)]
    return causes


def is_over_density(part: float, density: float) -> bool:
    """Return True if a modulus or mass is divided by the density."""
    return abs(part * density - 1) <= BAND and abs(density - 1) > BAND


def _law_causes(
    material: Isotropic,
    reading: Reading | None,
    law: tuple[float, float] | None,
    rows: tuple[BodyRow, ...],
) -> list[Cause]:
    found, shown = [], SHOWN if reading is None else reading.shown
    flags = () if reading is None else [flag for flag in reading.flags if not flag.holds]
    lost = [flag.value for flag in flags if flag.name == DAMPING]
    found += [Cause(DAMPING, part, phrase("damped", lost=part)) for part in lost]
    if reading is not None and not reading.is_valid and len(reading.refusals()) > len(lost):
        found.append(Cause("reading", of=phrase("refused", refusals=reading.refusals())))
    elif reading is not None and reading.is_valid and reading.E is None:
        found.append(Cause("no solid", of=phrase("no solid", because=reading.elastic.because)))
    if reading is not None and reading.is_bound:
        found.append(Cause("bound", of=phrase("bound")))
    if law is not None and not _alike(law, (material.E, material.nu), shown):
        rival = "or loads" if reading is None else "or masses"
        pulled = [row.body == "pulled" and row.driven == "loads" for row in rows]
        known = reading is not None and (reading.masses is None or any(pulled))
        near, times = nearest_law(*law, material.E, material.nu), law[0] / material.E
        of = phrase(
            "law",
            times=times,
            nu=law[1],
            given=material.nu,
            near=phrase("near law", name=near, key=LAWS[near].key) if near else NOTHING,
            over=OVER_DENSITY if is_over_density(times, material.density) else NOTHING,
            rival=NOTHING if known else phrase(rival, times=1 / times),
        )
        found.append(Cause("law", times, of))
    masses = reading.masses if reading is not None else None
    if masses is not None and masses.off > max(BAND, masses.error + shown - SHOWN):
        of = phrase("masses", pattern=masses.words, spread=masses.spread)
        found.append(Cause("mass", masses.off, of))
    return found


def _factor_causes(rows: tuple[BodyRow, ...], total: float = 1.0, *, linear: bool) -> list[Cause]:
    """Mass, solver, and elements by design, where they do more than the band in a body.

    `total` is the mass by steps and by forces, relative to the requested one.
    """
    found = []
    for name in ("mass", "solver") if linear else ("mass", "solver", "resolution"):
        each = [getattr(row.factors, name) for row in rows if row.factors is not None]
        each += [total] if name == "mass" else []
        worst = max(each, key=lambda one: abs(one - 1), default=1.0)
        if abs(worst - 1) > BAND:
            found.append(Cause(name, worst, phrase(f"factor {name}", times=worst)))
    return found


def _alike(one: tuple[float, float], other: tuple[float, float], band: float) -> bool:
    return abs(one[0] / other[0] - 1) <= band and abs(one[1] - other[1]) <= band
