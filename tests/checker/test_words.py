"""No verdict or cause of the checker depends on how a sentence is worded."""

import numpy as np
import pytest

from msvalidate_check import causes, check
from tests.checker.faulty_fields import faulty_fields
from tests.checker.faulty_pairs import faulty_pairs

EVERY = 15


def decided():
    """Verdicts, kinds and numbers of every few of the faulty fields."""
    found = []
    for faulty in [*faulty_fields()][::EVERY] + [*faulty_pairs()][::EVERY]:
        case = faulty.case
        verdict = check(case, case.points[case.named], faulty.displacement, **faulty.more)
        each = [(c.kind, c.beside, c.value, c.left) for c in verdict.causes]
        material = (verdict.material.E, verdict.material.nu)
        found.append((verdict.word, bool(verdict), each, material))
    return found


def test_other_words_change_no_verdict_and_no_cause(monkeypatch):
    before = decided()
    for number, key in enumerate(causes.PHRASES):
        monkeypatch.setitem(causes.PHRASES, key, f"reworded {number} and mass")
    np.testing.assert_equal(decided(), before)


def test_two_causes_have_both_names():
    cause = causes.Cause("unit", 1e3, beside="ratio")
    assert (cause.name, cause.kinds) == ("unit and ratio", {"unit", "ratio"})
    with pytest.raises(KeyError):
        assert causes.Cause("unit", of=causes.phrase("no such phrase")).said
