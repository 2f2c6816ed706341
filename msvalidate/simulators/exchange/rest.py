"""How far an answer is from solved and from rest, from what its program says of it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from msvalidate.simulators.exchange.protocol import Answer, Request


def solves_to(about: Mapping[str, Any]) -> float:
    """Part of a step's change of velocity that its solver leaves, as stated; 0 if nobody says."""
    return float(about.get("solves_to") or 0.0)


def stated_residual_motion(request: Request, answer: Answer) -> float:
    """Part of its largest displacement that an answer may still change by; NaN if nobody says.

    `at_rest` of the answer holds one of

    - `change_when_twice_as_long` (m): over the largest displacement.
    - `largest_speed` v (m/s): the body swings by v/ω, with Rayleigh's estimate of its lowest
      frequency for the answer's own shape, ω² = Σ F u / Σ m u² [Rayleigh1877].
    - `residual` r (N), on any node: n nodes pulled by it all one way, over the sum of the loads'
      sizes: n r / Σ |F|.

    The last two are estimates, and need loads: a body that supports alone move gives NaN.
    """
    stated = dict(answer.about.get("at_rest", {}))
    u = answer.displacement
    if u is None or not stated:
        return math.nan
    size = float(np.linalg.norm(u, axis=1).max())
    if not size:
        return math.nan
    if "change_when_twice_as_long" in stated:
        return float(stated["change_when_twice_as_long"]) / size
    force = np.where(request.held, 0.0, request.force + request.mass[:, None] * request.gravity)
    work = float((force * u).sum())
    if "largest_speed" in stated:
        moved = float((request.mass[:, None] * u**2).sum())
        if work <= 0 or request.value.any():
            return math.nan
        return float(stated["largest_speed"]) * math.sqrt(moved / work) / size
    pull = float(np.linalg.norm(force, axis=1).sum())
    return len(u) * float(stated["residual"]) / pull if pull else math.nan
