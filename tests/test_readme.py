"""README and docs: links lead somewhere, numbers and tables are there."""

from __future__ import annotations

import re
from pathlib import Path

import pandas as pd

import msvalidate
from msvalidate.bench.judging import catalogue
from msvalidate.bench.judging.columns import read_columns
from msvalidate.bench.judging.evidence import Evidence
from msvalidate.bench.output.front import first_screen, ledger, percent
from msvalidate.bench.output.results import read_numbers
from msvalidate.bench.output.stored import read_csv
from msvalidate.bench.output.summary import summary_lines
from tests.reference_fem.test_scikit_fem import EQUAL
from tests.table import table

ROOT = Path(__file__).resolve().parents[1]
FULL = ROOT / "reports" / "baseline" / "full"
PAGES = sorted([*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md")])
TEXTS = {str(page.relative_to(ROOT)): page.read_text(encoding="utf-8") for page in PAGES}
README = TEXTS["README.md"]
STUDIES = sorted(folder.name for folder in FULL.iterdir() if folder.is_dir())
MOST_WORDS = 800


@table("study", STUDIES)
def test_every_study_has_its_page_with_all_tables(study):
    text = TEXTS[f"docs/studies/{study}.md"]
    tables = {path.stem for path in (FULL / study).glob("*.csv")}
    linked = re.findall(rf"\[(\w+)\]\([./]*/reports/baseline/full/{study}/\1\.csv\)", text)
    assert tables == set(linked)


def test_every_link_leads_somewhere():
    lost = []
    for name, text in TEXTS.items():
        for link in re.findall(r"\]\(([^)#]+)[^)]*\)", text):
            built = link.startswith(("http", "auto_"))  # by the documentation site
            if not built and not (ROOT / name).parent.joinpath(link).exists():
                lost.append(f"{name}: {link}")
    assert lost == []


def test_the_first_table_is_that_of_the_committed_baseline():
    lines = first_screen([]).lines
    stored = read_csv(FULL / "overview" / "good_for.csv")
    for line, error, across in zip(
        lines, stored["error_coarse"], stored["across_coarse"], strict=True
    ):
        few = percent(error) + ("" if across == "" else f" at {across}")
        row = (line.body, line.springs, few, line.fine, line.verdict, line.condition)
        assert f"| {' | '.join(row)} |" in TEXTS["docs/findings.md"]
    short = [f"| {x.body} | {x.springs} | {x.fine} | {x.verdict} |" for x in lines]
    shown = [row for row in short if row in README]
    assert shown == [row for row in README.splitlines() if row in short]
    assert 4 < len(shown) <= 8


def test_readme_shows_the_summary_of_poisson_as_it_is_printed():
    table = read_numbers(read_csv(FULL / "poisson" / "summary.csv"))
    columns = read_columns(str(ROOT / "studies" / "poisson" / "columns.toml"))
    printed = summary_lines(table, Evidence({"summary": table}, columns=columns))
    assert "\n".join(["--table summary", *printed, "```"]) in README


@table("page", ["README.md", "docs/report.md"])
def test_the_reports_topics_are_those_of_the_committed_ledger(page):
    for topic in first_screen([]).topics:
        says = "" if topic.says in topic.topic else f": “{topic.says}”"
        result = topic.sentence if page == "README.md" else topic.found
        commands = ", ".join(f"`{name}`" for name in topic.studies.split())
        row = (f"**{topic.topic}**{says}", topic.verdict, result, commands)
        assert f"| {' | '.join(row)} |" in TEXTS[page]


def test_the_ledger_is_that_of_the_committed_baseline():
    for entry in ledger(pd.read_csv(FULL / "claims" / "ledger.csv")):
        row = (entry.sentence, entry.verdict, entry.number)
        assert f"| {' | '.join(row)} |" in TEXTS["docs/studies/claims.md"]


def test_readme_and_pages_describe_one_reference():
    page = (ROOT / "msvalidate/bench/output/templates/reference.html").read_text(encoding="utf-8")
    (sentences,) = re.findall(r"<p.*?>(.*)</p>", page)
    assert sentences in re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", " ".join(README.split()))
    rows = re.findall(r"^\| [A-Z]\d \|.* ([\d.]+) to ([\d.]+) \|$", TEXTS["docs/speed.md"], re.M)
    factors = [float(number) for row in rows for number in row]
    stated = f"{min(factors):.0f} to {max(factors):.0f} times faster"
    assert sentences.endswith(f"equal to scikit-fem's to {EQUAL:g} and {stated}.")


def test_pages_count_the_sentences_that_are_judged():
    entries = pd.read_csv(FULL / "claims" / "ledger.csv")
    background = entries["sentence"][entries["verdict"] == "background"]
    judged = len(entries) - len(background)
    for page in ("README.md", "docs/README.md", "docs/report.md", "docs/findings.md"):
        assert f"{judged} of its {len(entries)} sentences" in TEXTS[page], page
    others = TEXTS["docs/report.md"].partition("others are\nbackground: ")[2].partition(".\n")[0]
    assert set(re.findall(r"\d+", others)) == set(background.astype(str))


@table("study", STUDIES)
def test_findings_name_the_size_of_the_finest(study):
    findings = TEXTS[f"docs/studies/{study}.md"].partition("## Findings")[2].partition("\n## ")[0]
    for finding in findings.split("\n- "):
        if re.search("finest|coarsest", finding):
            assert re.search(r"[\d,]+ (cells|nodes|segments|spacings)", finding), finding


def test_readme_is_short():
    assert len(re.sub(r"\||---", " ", README).split()) <= MOST_WORDS


def test_findings_are_of_every_study_in_the_readers_order():
    told = re.findall(r"^## (\w+)$", TEXTS["docs/findings.md"], re.MULTILINE)
    ours = [
        name for name in catalogue.names() if not catalogue.load(name).__dict__.get("READS_RESULTS")
    ]
    assert told == ours


def test_the_citation_is_of_this_version():
    assert f"version: {msvalidate.__version__}\n" in (ROOT / "CITATION.cff").read_text("utf-8")
