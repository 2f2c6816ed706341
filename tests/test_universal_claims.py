"""Universal claims about results: each is sampled at random, or names its sample.

A claim over all values of a parameter is not shown by the few values of a table. The scan reads
where results are stated: README.md, docs/findings.md and docs/report.md, the findings of
docs/studies, what the ledger computed, the sentences of simulators' verdicts, and what studies
expect. Of these it takes the sentences that have

- *any*, *always*, *never*, *wherever* or *whatever*;
- *every* or *all* before a parameter (`PARAMETERS`): *every size*, *all ratios*.

*Every* or *all* before objects counts the members of one body or table (all springs, every study);
the table itself shows these. Manuals instruct and are not scanned. A sentence that is taken must
have a phrase of tests/universal_claims.toml: with the test that draws the parameter at random, or
with a reason why it is no claim about results. Otherwise the sentence is to name its sample.
"""

from __future__ import annotations

import ast
import re
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
ROWS = tomllib.loads((ROOT / "tests" / "universal_claims.toml").read_text("utf-8"))["claim"]
PARAMETERS = (
    "angle body cube depth direction distance fineness halving height length load mesh number "
    "place plate pressure rate ratio refinement rule seed size spacing step strain stretch time "
    "turn voltage"
)
UNIVERSAL = re.compile(
    r"\b(?:any|anything|always|never|wherever|whenever|whatever)\b|\b(?:every|all)\*? (?:"
    + PARAMETERS.replace(" ", "|")
    + r")(?:s|es)?\b",
    re.IGNORECASE,
)
RESULTS = ("found", "measure", "if", "topic")
"""Keys of the ledger that state what was found; others quote the report or give a theory."""


def texts() -> Iterator[tuple[str, str]]:
    """Places and texts that state results."""
    for name in ("README.md", "docs/findings.md", "docs/report.md"):
        yield name, re.sub(r"```.*?```", "", (ROOT / name).read_text("utf-8"), flags=re.DOTALL)
    for page in sorted(ROOT.glob("docs/studies/*.md")):
        findings = re.search(r"## Findings\n(.*?)\n## ", page.read_text("utf-8"), re.DOTALL)
        yield page.name, findings[1] if findings else ""
    for name, keys in (("studies/claims/ledger.toml", RESULTS),
                       ("msvalidate/simulators/verdict/sentences.toml", ())):  # fmt: skip
        content = tomllib.loads((ROOT / name).read_text("utf-8"))
        yield from ((name, text) for text in leaves(content, keys))
    for module in sorted(ROOT.glob("studies/**/*.py")):
        text = ast.get_docstring(ast.parse(module.read_text("utf-8"))) or ""
        expected = re.search(r"^Expected +(.*?)(?=\n\S|\n\n|\Z)", text, re.DOTALL | re.MULTILINE)
        yield str(module.relative_to(ROOT)), expected[1] if expected else ""


def leaves(content: object, keys: tuple[str, ...], key: str = "") -> Iterator[str]:
    """Texts of some keys, or of all."""
    if isinstance(content, dict):
        for name, value in content.items():
            yield from leaves(value, keys, name)
    elif isinstance(content, list):
        for value in content:
            yield from leaves(value, keys, key)
    elif isinstance(content, str) and (not keys or key in keys):
        yield content


def universal(text: str) -> list[str]:
    """Sentences, parts at semicolons and cells of tables that claim something universally."""
    quoted = re.sub(r"“[^”]*”", "", text)
    parts = re.split(r"(?<=[.;?!])\s+|\n\n|\n(?=[-|#])|\s\|\s", quoted)
    return [" ".join(part.split()) for part in parts if UNIVERSAL.search(" ".join(part.split()))]


def test_every_universal_claim_is_sampled_or_reworded():
    used, lost = set(), []
    for name, text in texts():
        for sentence in universal(text):
            phrases = {row["phrase"] for row in ROWS if row["phrase"] in sentence}
            used |= phrases
            if not phrases:
                lost.append(f"{name}: {sentence}")
    assert lost == []
    assert {row["phrase"] for row in ROWS} - used == set()


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row["phrase"])
def test_every_row_has_a_test_that_draws_parameters_or_a_reason(row):
    if "reason" in row:
        assert len(row["reason"].split()) >= 4
        return
    path, _, name = row["test"].partition("::")
    module = ast.parse((ROOT / "tests" / path).read_text("utf-8"))
    (function,) = (n for n in ast.walk(module) if isinstance(n, ast.FunctionDef) and n.name == name)
    assert re.search(r"\brng\b|default_rng|\bgiven\b", ast.unparse(function))


@pytest.mark.parametrize(
    "sentence",
    [
        "In square-8 it follows the nearest row at any turn.",
        "It runs along rows, wherever it begins.",
        "The ratio is 1/3 at every size.",
        "It is right at all ratios.",
        "| strength | the crack never leaves its row |",
    ],
)
def test_the_scan_takes_universal_claims(sentence):
    assert len(universal(f"First. {sentence} Last; all springs, every study.")) == 1
