"""Which of a study's own faults a failed judgement looks like.

A fault moves what is observed; a fault of another size moves each quantity by as many times more or
less, but for the second order of its size. So a judgement that moved is held to what each recorded
fault moves, times one number, and the share of quantities that fit says how alike they are.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
import pandas as pd

from msvalidate.problem import Array

FITS = 0.2
"""Part of a move by which it may differ from the fault's: the second order of faults up to 10 %."""
ALIKE = 0.7
"""Least share of moved quantities that fit a suspect. Some do not, however alike the faults: where
the farthest of many cases is observed, another one may be it."""
APART = 0.15
"""By which the share of the next fault must be less: else neither is named."""
LEAST = 0.1
"""Move over its limit that counts as one: below it is what rounding and sampling give."""


PLAIN = 1e3
"""Move over its limit of a quantity that is an identity but for rounding. One that moves the other
way than under a fault clears it; orders and other fitted numbers may go either way."""


class Suspect(NamedTuple):
    """A fault, and its size over that of the recorded one."""

    fault: str
    size: float


def record_faults(sound: pd.DataFrame, spoilt: Mapping[str, pd.DataFrame]) -> pd.DataFrame:
    """What each fault moves: a row a quantity, a column a fault.

    Parameters
    ----------
    sound
        The verdict of the study as it is.
    spoilt
        Fault -> the verdict under it.

    Returns
    -------
    pandas.DataFrame
        quantity, sound (observed less reference), and for each fault the move over the limit.
    """
    off = sound["observed"] - sound["reference"]
    found = pd.DataFrame({"quantity": sound["quantity"], "sound": off})
    for fault, verdict in spoilt.items():
        # A fault may be asked of some questions of the study only: of others nothing is known.
        alike = verdict.set_index("quantity").reindex(sound["quantity"])
        found[fault] = _moves(off, alike)
    return found


def find_suspect(verdict: pd.DataFrame, recorded: pd.DataFrame) -> Suspect | None:
    """The fault that a verdict looks like, if there is one and no other is as near.

    Parameters
    ----------
    verdict
        Of the same form of the study; rows of the baseline are left out.
    recorded
        As `record_faults` returns it.
    """
    judged = verdict[verdict["layer"] != "baseline"]
    if list(judged["quantity"]) != list(recorded["quantity"]):
        return None
    moved = _moves(recorded["sound"], judged)
    found = []
    for fault in recorded.columns[2:]:
        known = recorded[fault].to_numpy(float)
        plain = np.isfinite(moved) & np.isfinite(known)
        share, size = _likeness(moved[plain], known[plain])
        found.append((share, str(fault), size))
    found.sort(key=lambda each: -each[0])
    if not found or found[0][0] < ALIKE or (len(found) > 1 and found[1][0] > found[0][0] - APART):
        return None
    return Suspect(found[0][1], found[0][2])


def _likeness(moved: Array, known: Array) -> tuple[float, float]:
    """Share of what moved, or should have, that a fault explains, and the fault's size."""
    strong = np.abs(known) > LEAST
    if not strong.any():
        return 0.0, 0.0
    size = float(np.median(moved[strong] / known[strong]))
    expected = size * known
    telling = (np.abs(moved) > LEAST) | (np.abs(expected) > LEAST)
    if size == 0 or not telling.any():
        return 0.0, 0.0
    against = moved * expected < 0
    if (against & (np.minimum(np.abs(moved), np.abs(expected)) > PLAIN)).any():
        return 0.0, 0.0
    fits = np.abs(moved - expected) <= FITS * np.abs(expected) + LEAST
    return float(fits[telling].mean()), size


def _moves(sound: pd.Series, verdict: pd.DataFrame) -> Array:
    """Moves off the references, over the limits; over 1 where a limit is 0.

    Not of what is observed: where it is the farthest of many cases, another may be it.
    """
    limit = verdict["limit"].to_numpy(float)
    off = verdict["observed"].to_numpy(float) - verdict["reference"].to_numpy(float)
    return np.asarray((off - sound.to_numpy(float)) / np.where(limit > 0, limit, 1.0))
