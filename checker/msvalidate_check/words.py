"""Verdicts, and when each is said."""

from __future__ import annotations

AGREES, DIFFERS, NOT_RESOLVED, NOT_AT_REST = "agrees", "differs", "not resolved", "not at rest"


def agreement(
    difference: float, uncertainty: float, band: float, residual_motion: float = 0.0
) -> str:
    """Whether a candidate agrees with its reference within a band, whatever they leave open.

    Parameters
    ----------
    difference
        From the reference, in the unit of the band.
    uncertainty
        How far the reference may be off.
    band
        Largest difference that agrees.
    residual_motion
        How far the candidate may still be from where it comes to rest.

    Returns
    -------
    str
        `AGREES` or `DIFFERS` where neither uncertainty nor residual motion can change that; else
        `NOT_AT_REST` or `NOT_RESOLVED`, after the larger of the two.
    """
    left = abs(uncertainty) + abs(residual_motion)
    if abs(difference) + left <= band:
        return AGREES
    if abs(difference) - left > band:
        return DIFFERS
    return NOT_AT_REST if abs(residual_motion) > abs(uncertainty) else NOT_RESOLVED
