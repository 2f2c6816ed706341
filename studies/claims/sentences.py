"""The report's sentences that can be checked, in their order in the ledger."""

from __future__ import annotations

from . import cost_claims, electric_claims, lattice_claims, loads_claims, motion_claims
from .record import Claim

SENTENCES = 65
"""How many there are."""
SUBJECTS = (cost_claims, lattice_claims, motion_claims, loads_claims, electric_claims)
CLAIMS: tuple[Claim, ...] = tuple(
    sorted((claim for of in SUBJECTS for claim in of.CLAIMS), key=lambda claim: claim.number)
)
