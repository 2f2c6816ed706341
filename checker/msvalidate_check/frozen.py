"""Checksums of the frozen sets, by version: written by `make cases`, never changed."""

from __future__ import annotations

DIGESTS = {1: "a3980c1d80d381374dd908c918e8b7b8ccb50fa72d9629e84141a7181c66aad0"}
"""Version -> SHA-256 of its file."""
