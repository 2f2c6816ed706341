"""Checksums of the frozen sets, by version: written by `make cases`, never changed."""

from __future__ import annotations

DIGESTS = {1: ""}
"""Version -> SHA-256 of its file."""
