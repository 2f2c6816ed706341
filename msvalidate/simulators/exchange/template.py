"""The commented adapter that `adapter new` writes: it runs as it is, on a toy solver."""

from __future__ import annotations

from pathlib import Path


def adapter_template(name: str) -> str:
    """Text of an adapter of a name, which is letters, digits, - and _ alone."""
    text = Path(__file__).with_suffix(".txt").read_text(encoding="utf-8")
    return text.replace("NAME=VALUE", "\0").replace("NAME", name).replace("\0", "NAME=VALUE")
