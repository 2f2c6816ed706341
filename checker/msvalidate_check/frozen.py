"""Checksums of the frozen sets, by version: written by `make cases`, never changed."""

from __future__ import annotations

DIGESTS = {
    1: "460a82360ca6dcbd82f6abc745b22fccf2ce3e8589b3979be265fe8df4f495c5",
    2: "6267258d842572f3168bea84f0af982a39ec0f9bf42d251e19c46cced2d30ab1",
}
"""Version -> SHA-256 of its file."""
