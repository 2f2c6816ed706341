"""The page: what it says, in which order, and that nothing a study says can become markup."""

from dataclasses import fields, replace
from html.parser import HTMLParser
from urllib.parse import unquote_to_bytes

import pandas as pd
import pytest

from msvalidate.bench.output import page
from msvalidate.bench.output.stored import NUMBERS, Stored

VOID = {"meta", "link", "img", "br"}
APART = {"dt", "li", "p", "td", "th"}
LOADING = {"src", "srcset", "action", "data", "poster", "background"}
SVG = b'<svg xmlns="http://www.w3.org/2000/svg" width="%dpt" height="9pt"></svg>'


class Read(HTMLParser):
    """The words of a page, its elements with their attributes, and whether they nest."""

    def __init__(self, html):
        super().__init__()
        self.elements, self.words, self.within = [], [], []
        self.feed(html)
        self.close()
        assert self.within == []

    def handle_starttag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))
        if tag not in VOID:
            self.within.append(tag)

    def handle_endtag(self, tag):
        assert self.within.pop() == tag
        if tag in APART:
            self.words.append(" ")

    def handle_data(self, data):
        if "style" not in self.within:
            self.words.append(data)

    @property
    def text(self):
        return " ".join("".join(self.words).split())

    def all(self, tag):
        return [attributes for name, attributes in self.elements if name == tag]


def judged(quantity="gap", *, layer="theory", verdict="pass", **changed):
    row = {"layer": layer, "quantity": quantity, "unit": "m", "observed": 1.0, "reference": 0.5}
    row |= {"error": 0.5, "limit": 0.75, "verdict": verdict, "because": "half a gap"}
    return row | changed


def stored(name="lines", rows=(), **changed):
    verdict = pd.DataFrame(rows or [judged()])
    made = Stored(
        name=name,
        question="How long?\n\nAs long as `it` is.\n",
        findings=("A finding.",),
        columns={"x": "place (m)", "word": "what it is called"},
        origin={"seed": "0", "time": "2026-01-01 00:00 UTC"},
        verdict=verdict,
        tables={"line": pd.DataFrame({"x": ["0.0", "1.5"], "word": ["a", "b"]})},
        pictures={"line": ("A straight line.", SVG % 300)},
        seconds=9.64,
    )
    return replace(made, **changed)


NOTHING = pd.DataFrame(columns=["layer", "quantity", *NUMBERS, "verdict"])


# --- what it says ---------------------------------------------------------------------------------


def test_page_of_a_study_that_passed():
    html = page.render_page([stored()])
    text = Read(html).text
    said = (
        "How long? As long as it is. checks held The one tolerance of 1 study held. A finding.",
        "theory agreement regression baseline seconds time of run",
        "lines checks held 1 of 1 held none none none 9.6 2026-01-01 00:00 UTC",
        "What failed Nothing failed.",
        "What is asked, and what is judged checks held 1 of 1 tolerance held, 9.6 s tables",
        "line 2 rows, 2 columns",
        "x word 0.0 a 1.5 b",
        "x place (m)",
        "Tolerances, theory",
        "half a gap",
        "Provenance seed 0",
    )
    places = [text.find(piece) for piece in said]
    assert -1 not in places, said[places.index(-1)]
    assert places == sorted(places)
    assert "checks missed" not in text
    assert html.startswith("<!DOCTYPE html>")


def test_page_of_a_study_that_failed():
    rows = [judged(), judged("slope", verdict="fail", observed=2.0, unit="1", because="it was 1/2")]
    text = Read(page.render_page([stored(rows=rows), stored("other")])).text
    assert "checks missed 1 of 3 tolerances missed." in text
    assert "lines checks missed 1 of 2 held, 1 missed" in text
    assert "lines missed slope 2 0.5 0.5 0.75 1 it was 1/2" in text  # over all
    assert "slope (theory): observed 2, reference 0.5, error 0.5, limit 0.75, unit 1." in text
    assert text.count("Nothing failed.") == 1  # of the other


def test_page_of_one_study_begins_with_what_failed_and_where():
    row = judged("slope", verdict="fail", observed=2.0, unit="1", rows=6, at="body plate, cells 8")
    text = Read(page.render_page([stored(rows=[row])])).text
    assert "slope: error 0.5, limit 0.75, farthest at body plate, ce" in text


def test_page_of_a_study_that_did_not_finish():
    text = Read(page.render_page([stored(error="no pivot"), stored("other")])).text
    assert "not finished The one tolerance of 1 study held; did not finish: lines." in text
    assert "lines not finished no pivot 9.6 2026" in text
    assert "lines did not finish: no pivot" in text
    assert "not finished: no pivot The results shown here are from the run before." in text
    assert "Nothing failed in the run before." in text


def test_page_of_a_study_that_never_finished():
    empty = stored(verdict=NOTHING, tables={}, pictures={}, findings=(), error="no pivot")
    text = Read(page.render_page([empty])).text
    assert "There are no results of a run before." in text
    assert "Nothing was judged." in text


def test_page_of_a_study_that_judged_nothing():
    text = Read(page.render_page([stored(verdict=NOTHING)])).text
    assert "checks missed Judged nothing: lines." in text
    assert "What failed lines judged nothing" in text
    assert "Nothing failed" not in text


def test_page_of_no_study():
    assert "not finished No study has been run." in Read(page.render_page([])).text


@pytest.mark.parametrize(
    ("states", "verdict"),
    [("p", "pass"), ("pf", "FAIL"), ("pe", "not finished"), ("ef", "FAIL"), ("ppp", "pass")],
)
def test_overall_verdict_is_the_worst(states, verdict):
    sections = [
        page.study_section(
            stored(
                f"s{i}",
                rows=[judged(verdict="fail" if state == "f" else "pass")],
                error="stopped" if state == "e" else "",
            )
        )
        for i, state in enumerate(states)
    ]
    assert page.overall_verdict(sections)[0] == verdict


def test_the_cover_is_in_the_page_before_other_pictures_take_the_room():
    pictures = {"line": ("A line.", SVG % 300), "body": ("A body.", SVG % 300)}
    room = len(page.study_section(stored(pictures=pictures)).pictures[0].source)
    section = page.study_section(stored(pictures=pictures, cover="body"), room)
    assert section.cover.file.endswith("body.svg")
    assert section.cover.source


def test_baseline_lists_only_what_failed():
    rows = [judged(f"held {i}", layer="baseline") for i in range(5)]
    rows.append(judged("moved", layer="baseline", verdict="fail"))
    (baseline,) = [x for x in page.study_section(stored(rows=rows)).layers if x.name == "baseline"]
    assert (baseline.judged, baseline.missed) == (6, 1)
    assert [row["quantity"] for row in baseline.listed] == ["moved"]
    text = Read(page.render_page([stored(rows=rows)])).text
    assert "5 of 6 held, 1 missed; those missed:" in text
    assert "held 3" not in text


def test_no_row_of_a_verdict_is_left_out():
    rows = [judged(), judged("odd", layer="something else", verdict="fail")]
    found = page.study_section(stored(rows=rows))
    assert [x.name for x in found.layers] == [*page.LAYERS, "something else"]
    assert (found.judged, found.missed) == (2, 1)


# --- markup ---------------------------------------------------------------------------------------

EVIL = """<script>alert("1")</script>'"><img src=x onerror=alert(2)>&amp;{{ 777*777 }}"""


def spoilt(name):
    """A study with markup in one of its fields."""
    table = pd.DataFrame({EVIL: [EVIL, "1"]})
    whole = {
        "name": EVIL,
        "question": f"{EVIL}\n\n{EVIL}\n\n- {EVIL}\n- `{EVIL}`",
        "findings": (EVIL,),
        "columns": {EVIL: EVIL, "x": EVIL},
        "origin": {EVIL: EVIL, "time": EVIL},
        "verdict": pd.DataFrame(
            [
                judged(EVIL, layer=EVIL, verdict=verdict, unit=EVIL, because=EVIL)
                for verdict in ("pass", EVIL)
            ]
        ),
        "tables": {"line": table, EVIL: table},
        "pictures": {EVIL: (EVIL, EVIL.encode())},
        "error": EVIL,
        "labels": {EVIL: EVIL, "x": EVIL},
    }
    assert set(whole) == set(TEXTS)
    return stored(**(whole if name == "all of them" else {name: whole[name]}))


TEXTS = [field.name for field in fields(Stored) if field.type != "float" and field.name != "cover"]
"""Fields that the page shows; the cover only selects a picture."""


@pytest.mark.parametrize("name", [*TEXTS, "all of them"])
def test_what_a_study_says_never_becomes_markup(name):
    html = page.render_page([spoilt(name)])
    read = Read(html)
    assert read.all("script") == []
    assert {tag for tag, _ in read.elements} <= {tag for tag, _ in Read(PLAIN).elements} | {
        *("p", "b", "ul", "li", "code", "h4", "i", "cite"),
    }
    assert not [key for _, found in read.elements for key in found if key.startswith("on")]
    assert all(image["src"].startswith("data:image/svg+xml,") for image in read.all("img"))
    if name != "pictures":
        assert "603729" not in read.text  # nor a template
        assert EVIL in "".join(read.words)


PLAIN = page.render_page([stored(rows=[judged(), judged(verdict="fail")])])


def test_page_loads_nothing_and_runs_nothing():
    read = Read(page.render_page([stored(), stored("b", error="https://example.org/why")]))
    assert read.all("script") == []
    for tag, found in read.elements:
        for key in LOADING & set(found):
            assert found[key].startswith("data:"), (tag, key)
        if "href" in found:
            assert found["href"].startswith(("#", "./")) or found["href"] == "data:,", tag
    style = page.render_page([]).partition("<style>")[2].partition("</style>")[0]
    assert style
    for loading in ("url(", "@import", "http:", "https:"):
        assert loading not in style
    policy = [m["content"] for m in read.all("meta") if "http-equiv" in m]
    (policy,) = policy
    assert policy.startswith("default-src 'none'; style-src 'unsafe-inline'; img-src data:; ")
    assert "script" not in policy


def test_picture_is_inside_the_page_with_its_caption():
    (image,) = Read(PLAIN).all("img")
    assert image["alt"] == "A straight line."
    assert unquote_to_bytes(image["src"].partition(",")[2]) == SVG % 300
    assert {"href": "./lines/line.svg"} in Read(PLAIN).all("a")


def test_page_can_be_read_without_seeing_it():
    read = Read(PLAIN)
    assert read.all("html") == [{"lang": "en"}]
    assert len(read.all("caption")) == len(read.all("table"))
    assert all(found.get("scope") in ("col", "row") for found in read.all("th"))
    boxes = [found for found in read.all("div") if found.get("class", "").startswith("box")]
    assert len(boxes) == len(read.all("table"))
    for box in boxes:
        assert (box["tabindex"], box["role"]) == ("0", "region")
        assert box["aria-label"]
    identifiers = [found["id"] for _, found in read.elements if "id" in found]
    assert len(identifiers) == len(set(identifiers))
    pointed = {a["href"][1:] for a in read.all("a") if a["href"].startswith("#")}
    pointed |= {s["aria-labelledby"] for s in read.all("section")}
    assert pointed <= set(identifiers)
