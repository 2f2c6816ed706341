"""The contract of every page's first screen, at two widths, in a real browser."""

from __future__ import annotations

import re
from dataclasses import replace

import pandas as pd
import pytest

from msvalidate.bench.judging.columns import read_columns
from msvalidate.bench.output import page, stored
from msvalidate.case.file.case import Case
from msvalidate.case.judge.results import Result
from msvalidate.case.report.run import case_files, judged_files
from msvalidate.problem import Box, Isotropic, Problem, Support, Traction
from msvalidate.simulators.bodies.tetrahedra import of_law
from msvalidate.simulators.exchange.asked import Asked
from msvalidate.simulators.verdict.judgement import judge_simulator
from msvalidate.simulators.verdict.page import PAGE, sheet_files
from msvalidate.simulators.verdict.sheet import sheet_of
from msvalidate.studies import poisson
from reference_fem import box_discretisation, solve_problem
from tests.msvalidate.bench.output.test_page import judged as passed
from tests.msvalidate.bench.output.test_page_in_a_browser import (  # noqa: F401  `browser` is a fixture
    CONTRAST,
    WIDTHS,
    browser,
    open_page,
    pytestmark,
)
from tests.msvalidate.simulators import test_lattice as lattices

KINDS = ("study", "all", "case", "judged field", "simulator", "lattice")
PICTURE = (
    b'<svg xmlns="http://www.w3.org/2000/svg" width="400pt" height="300pt" viewBox="0 0 400 300">'
    b'<rect width="400" height="300" fill="#56B4E9"/></svg>'
)
BLOCK = Box((0.37, 0.2))


def study(name, tables):
    columns = read_columns(poisson.__file__)
    labels = {key: words.label for key, words in columns.items() if words.label}
    return stored.Stored(
        name=name,
        question=poisson.__doc__,
        findings=("Claim: The formula fails. It is of [Hansen1996].",),
        columns={key: str(words) for key, words in columns.items()},
        labels=labels,
        origin={"command": "python -m msvalidate.study poisson"},
        verdict=pd.DataFrame([passed()]),
        tables={"summary": tables["summary"].astype(str)},
        pictures={"emblem": ("The body is drawn at rest and deformed.", PICTURE)},
    )


def block():
    held = Support(BLOCK.side("left"), (0.0, 0.0))
    load = Traction(BLOCK.side("right"), (1e3, -1e3))
    problem = Problem(BLOCK, Isotropic(1e9, 0.3, thickness=0.2), (held,), (load,), "block")
    quantities = "displacement", "reactions", "mean stress"
    return Case(problem, cells=5, unit="mm", quantities=quantities, accuracy=0.02)


def softer(case):
    """Field of the case in a material 1 % softer."""
    body = box_discretisation(BLOCK, (32, 16), "Q2")
    soft = replace(case.problem, material=replace(case.problem.material, E=0.99e9))
    found = solve_problem(soft, body).at(body.points)
    return Result("softer.csv", found, body.points, None, float("nan"))


@pytest.fixture(scope="module")
def pages(tmp_path_factory, small_tables):
    """Kind of page -> its address."""
    case = block()
    ours = [study(name, small_tables("poisson")) for name in ("poisson", "displacement")]
    asked = Asked(of_law("linear"))
    solid = Isotropic(1e7, 0.3, "solid")
    judged = judge_simulator(asked, solid, parts=("bodies",), meshes=("tet4",))
    sheet = sheet_of(judged, asked, ("bodies",))
    lattice, _, of_lattice = lattices.judged(lattices.example())
    made = {
        "study": page.render_page(ours[:1]).encode(),
        "all": page.render_page(ours).encode(),
        "case": case_files(case)[-1]["case.html"],
        "judged field": judged_files(replace(case, accuracy=1e-3), softer(case))[1]["case.html"],
        "simulator": sheet_files("toy", judged, sheet, {}, {})[PAGE],
        "lattice": sheet_files("toy", lattice, of_lattice, {}, {})[PAGE],
    }
    folder, found = tmp_path_factory.mktemp("pages"), {}
    for kind, html in made.items():
        file = folder / f"{kind}.html"
        file.write_bytes(html)
        found[kind] = file.as_uri()
    return found


BROKEN = """
const wide = innerWidth > 600, broken = [], e = document.documentElement;
const first = document.querySelector("header");
const rect = x => x ? x.getBoundingClientRect() : {top: 1e9, bottom: 1e9, width: 0, height: 0};
const one = s => document.querySelector(s), all = s => [...document.querySelectorAll(s)];
const need = (holds, words) => { if (!holds) broken.push(words); };
need(e.scrollWidth <= e.clientWidth, `scrolls sideways: ${e.scrollWidth} of ${e.clientWidth}`);
const image = one(".glance img");
need(rect(image).width > 100 && rect(image).height > 60, "no picture of a body");
need(rect(image).bottom <= innerHeight, "the picture is not on the first screen");
const verdict = one(".overall");
need(verdict && verdict.querySelector(".badge"), "no badge");
need(verdict && /[.]$/.test(verdict.textContent.trim()), "the verdict is no sentence");
need(rect(verdict).bottom <= innerHeight, "the verdict is not on the first screen");
need(rect(one(".advice")).bottom <= innerHeight, "no recommendation on the first screen");
const table = one(".glance table") || one(".chart");
need(wide ? rect(table).top < innerHeight - 200 : rect(table).top < innerHeight + 200,
     `the summary is not on the first screen: ${rect(table).top}`);
need(!one("header .overall .badge.pass") || !one("header .badge.fail, header .missed, header .off"),
     "the badge hides a difference");
const texts = `${one(".question")?.textContent}${one("h1").textContent}`;
need(/[?]/.test(texts), "no question");
need(rect(one(".question") ?? one("h1")).bottom <= innerHeight, "the question is cut");
const key = [...all("header .more")].find(x => x.textContent.startsWith("○"));
if (one(".chart") && wide)
  need(Math.max(rect(key).bottom, rect(one(".off")).bottom) <= innerHeight,
       "the key or the row that fails is below the first screen");
need(!/[0-9] (?:%|m?m|[kMG]?Pa)(?![a-z])/.test(first.textContent), "a number and its unit break");
for (const box of all(".stack"))
  need(box.scrollWidth <= box.clientWidth + 1, `not stacked: ${box.getAttribute("aria-label")}`);
if (one(".glance table")) need(!wide || rect(table).bottom <= innerHeight, "the summary is cut");
for (const box of all(".box"))
  if (wide && box.offsetParent && !box.closest("details"))
    need(box.scrollWidth <= box.clientWidth + 1,
         `columns are hidden: ${box.getAttribute("aria-label")}`);
for (const caption of all("figcaption")) {
  const words = caption.firstChild.textContent.trim();
  need(caption.offsetHeight > 0 && /\\w+ \\w+ .*[.]$/.test(words), `no sentence: ${words}`);
}
need(!/\\de-\\d+\\s%/.test(first.innerText), "a number is below its uncertainty");
const entries = all("#sources dt").map(x => x.textContent);
for (const [, key] of document.body.innerText.matchAll(/\\[([A-Z][a-z]\\w*\\d{4})\\]/g))
  need(entries.includes(key), `no entry of ${key}`);
scrollTo(0, e.scrollHeight);
const bar = rect(one("nav.contents"));
need(bar.top >= 0 && bar.bottom <= innerHeight && bar.height > 10, "the contents are out of view");
scrollTo(0, 0);
return broken;
"""
"""Clauses of the contract that a page breaks, each in a few words."""


@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize("kind", KINDS)
def test_first_screen(kind, width, browser, pages):  # noqa: F811
    open_page(browser, pages[kind], width)
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": []})
    assert browser.execute_script(BROKEN) == []


@pytest.mark.parametrize("kind", KINDS)
def test_words_stand_out_in_the_dark(kind, browser, pages):  # noqa: F811
    dark = {"features": [{"name": "prefers-color-scheme", "value": "dark"}]}
    open_page(browser, pages[kind], 390)
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", dark)
    assert browser.execute_script(CONTRAST, 4.5) == []
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": []})


def test_pages_state_what_was_compared(browser, pages):  # noqa: F811
    """The badge agrees with the advice, millimetres stay millimetres, the field is 1 % too soft."""
    texts = {}
    for kind in ("case", "judged field", "study"):
        open_page(browser, pages[kind], 1280)
        texts[kind] = browser.execute_script("return document.querySelector('header').innerText")
        texts[kind] = texts[kind].replace("\N{NO-BREAK SPACE}", " ")
    counted = re.search(r"springs agree with elasticity in (\d) of (\d) quantities", texts["case"])
    assert (counted[1] == counted[2]) == ("Use springs" in texts["case"])
    assert "largest displacement at compared points (mm)" in texts["case"]
    assert "mean stress (MPa)" in texts["case"]
    badge = "springs agree with reference in 7 of 9 rows"
    assert badge in texts["study"]
    assert "report's own block has 5 x 5 cells of equal springs" in texts["study"]
    # 1 % is planted in a field whose own accuracy is 1e-3 of it.
    sentence = r"The field is uniformly (1|0\.9[5-9]|1\.0\d?) % too soft\."
    assert re.search(sentence, texts["judged field"])
    assert "modulus E 0.99" in texts["judged field"]
    assert re.search(r" The formula fails\.\s+Recommendation", texts["study"])
    assert "Does this field agree with elasticity" in texts["judged field"]
    open_page(browser, pages["study"], 1280)
    sources = browser.execute_script("return document.querySelector('#sources').innerText")
    assert "Hansen1996" in sources


def test_a_page_that_breaks_the_contract_is_noticed(browser, pages):  # noqa: F811
    """Each clause is broken once, by a change of the page."""
    for change, words in {
        "document.querySelector('.glance img').remove()": "no picture of a body",
        "document.querySelector('.glance table').style.width = '3000px'": "columns are hidden",
        "document.querySelector('.overall').textContent = 'agrees'": "no badge",
        "document.querySelector('.advice').remove()": "no recommendation",
        "document.querySelector('nav.contents').style.position = 'static'": "out of view",
        "document.querySelector('figcaption').style.display = 'none'": "no sentence",
        "document.querySelector('#sources').remove()": "no entry of Hansen1996",
        "document.querySelector('.overall .badge').className = 'badge pass'": "badge hides",
        "document.querySelector('.question').textContent = 'Ratio.'": "no question",
        "document.querySelector('.advice').textContent = 'Expect 5 % here.'": "its unit break",
        "document.querySelector('.stack').style.width = '9rem'": "not stacked",
    }.items():
        open_page(browser, pages["study"], 1280)
        browser.execute_script(change)
        assert words in " ".join(browser.execute_script(BROKEN)), words
    chart = "document.querySelector('.chart')"
    open_page(browser, pages["all"], 1280)
    browser.execute_script(f"{chart}.append({chart}.children[1])")
    assert "the row that fails is below" in " ".join(browser.execute_script(BROKEN))
