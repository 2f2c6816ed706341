"""Nothing that is decided of a simulator depends on how a sentence is worded."""

from types import SimpleNamespace

import numpy as np
import pytest

from msvalidate.simulators.exchange.asked import Asked
from msvalidate.simulators.verdict import sentences
from msvalidate.simulators.verdict.advice import next_step
from msvalidate.simulators.verdict.causes import _factor_causes
from msvalidate.simulators.verdict.judgement import judge_simulator
from msvalidate.simulators.verdict.record import record_of
from msvalidate.simulators.verdict.sheet import sheet_of
from msvalidate_check import causes
from studies.simulators.judged import ASKED
from studies.simulators.synthetic import Faulty, clean, synthetic_faults

FAULTS = {**synthetic_faults(), "none": Faulty(clean, "agrees")}
MESHES = (("", 0.49), ("_2", 0.21))
LAW = "Saint Venant-Kirchhoff"


def decided(faulty, law):
    """State, kinds and numbers of causes and advice, and whether it passed; nothing of words."""
    asked = Asked(faulty.simulate)
    found = judge_simulator(asked, ASKED, law=law, meshes=("tet4",))
    sheet = sheet_of(found, asked)
    kinds = [(cause.kind, cause.value) for cause in found.causes]
    shown = (len(sheet.causes), len(sheet.notes), [len(table.rows) for table in sheet.tables])
    reworded = [*sheet.causes, sheet.next, sheet.word]
    return (found.word, kinds, next_step(found, asked).kind, sheet.agrees, shown), reworded, found


@pytest.mark.parametrize(
    ("fault", "law"),
    [
        ("none", ""), ("none", LAW), ("1 % too stiff", LAW), ("0.9 converged", ""),
        ("a full cell's mass on each node", ""), ("0.9 converged, and says so", ""),
        ("points swapped", ""), ("k = E h on each edge", ""), ("resets itself", ""),
        ("one way more than the other", ""), ("all over the density, but forces", ""),
    ],
)  # fmt: skip
def test_other_words_change_no_state_cause_or_advice(monkeypatch, fault, law):
    before, _, found = decided(FAULTS[fault], law)
    if not law:
        assert FAULTS[fault].is_named_in(found)
    for number, key in enumerate(sentences.SENTENCES):
        monkeypatch.setitem(sentences.SENTENCES, key, f"word {number} mass law: read as")
    for key in causes.PHRASES:
        monkeypatch.setitem(causes.PHRASES, key, "gate and ratio")
    after, words, found = decided(FAULTS[fault], law)
    np.testing.assert_equal(after, before)
    assert all(each.startswith("word ") for each in words)
    assert record_of(found)["kinds"] == [kind for kind, _ in before[1]]


def test_a_coarse_mesh_is_to_be_refined():
    rows = [SimpleNamespace(body="bent", case="c", mesh=f"tet4{n}", error=e) for n, e in MESHES]
    found = SimpleNamespace(word="agrees", bodies=rows, causes=())
    advice = next_step(found, SimpleNamespace(ended=False, failures=()))
    errors = "49 % on tet4, 21 % on tet4_2"
    assert advice.said == f"refine the mesh: the bent beam has an error of {errors}"


@pytest.mark.parametrize(
    ("given", "kind"),
    [
        ({"causes": [causes.Cause("documents")]}, "name another"),
        ({"causes": [causes.Cause("law")], "bodies": ()}, "answer rest"),
        ({"reading": SimpleNamespace(is_valid=True, flags=())}, "whole body"),
    ],
)
def test_what_helps_goes_by_what_is_there(given, kind):
    plain = {"word": "not explained", "reading": None, "causes": (), "bodies": (1,)}
    plain["is_accepted"] = False
    found = SimpleNamespace(**plain | {"predicted": (1e7, 0.3)} | given)
    assert next_step(found, SimpleNamespace(ended=False, failures=())).kind == kind


def test_a_body_that_moves_by_half_has_its_cause():
    body = SimpleNamespace(factors=SimpleNamespace(mass=0.5, solver=1.0, resolution=1.0))
    assert [(one.kind, one.value) for one in _factor_causes((body,), linear=True)] == [
        ("mass", 0.5)
    ]
