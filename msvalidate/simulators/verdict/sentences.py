"""All sentences on simulators: templates of sentences.toml, filled from records last.

Nothing decides by a template: state, advice, sheet and page look at kinds, values and numbers.
"""

from __future__ import annotations

import tomllib
from pathlib import Path

from msvalidate.problem.records import dataclass
from msvalidate_check import causes
from msvalidate_check.causes import say

SENTENCES: dict[str, str] = tomllib.loads(
    Path(__file__).with_suffix(".toml").read_text(encoding="utf-8")
)
"""Key of a phrase -> template."""


@dataclass(frozen=True)
class Cause(causes.Cause):
    """Why a simulator differs, or what to do next: a kind, and what its sentence names."""

    @property
    def said(self) -> str:
        """As a sentence."""
        return say(self.of, SENTENCES)


def text_of(of: object) -> str:
    """A phrase, or several, as text; a text as it is."""
    return say(of, SENTENCES)
