"""Pictures of a page: made smaller, inside the page where they fit, else linked."""

from __future__ import annotations

import re
from collections.abc import Mapping
from urllib.parse import quote

from msvalidate.problem.records import dataclass

WIDE = 460.0
"""Width (pt) beyond which a picture is not shrunk to a phone's screen but scrolls there."""
LARGE = 120_000
"""Bytes beyond which a picture is linked, however few there are."""

_SAFE = " /:=,;?@&+$-_.~()!*'"
_WIDTH = re.compile(r"<svg\b[^>]*?\swidth=\"([0-9.]+)(?:pt)?\"")
_PATH = re.compile(rb' d="[^"]*"')
_DIGITS = re.compile(rb"-?\d+\.\d{3,}")


@dataclass(frozen=True)
class Picture:
    """A picture: its caption, its address in the page or "", its file, and whether it is wide."""

    caption: str
    source: str
    file: str
    wide: bool


def shorten_paths(svg: bytes) -> bytes:
    """An SVG whose paths have hundredths of a point, which no eye and no printer tells apart."""
    return _PATH.sub(lambda path: _DIGITS.sub(_to_hundredths, path[0]).replace(b" \n", b"\n"), svg)


def embed_pictures(
    study: str, pictures: Mapping[str, tuple[str, bytes]], room: int, large: int = LARGE
) -> tuple[Picture, ...]:
    """A study's pictures in their order: inside the page as long as there is room (bytes).

    Those of more than `large` bytes are linked.
    """
    found = []
    for name, (caption, svg) in pictures.items():
        text = svg.decode("utf-8", errors="replace")
        source = "data:image/svg+xml," + quote(text, safe=_SAFE)
        fits = len(source) <= min(room, large)
        room -= len(source) if fits else 0
        width = _WIDTH.search(text)
        wide = bool(width and float(width[1]) > WIDE)
        found.append(Picture(caption, source if fits else "", f"{study}/{name}.svg", wide))
    return tuple(found)


def _to_hundredths(number: re.Match[bytes]) -> bytes:
    short = (b"%.2f" % float(number[0])).rstrip(b"0").rstrip(b".")
    return b"0" if short == b"-0" else short
