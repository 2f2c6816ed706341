"""The page in a real browser: wide and narrow, on real results and on ugly ones, and in print."""

import base64
import re
import shutil
from datetime import UTC, datetime

import pandas as pd
import pytest

from msvalidate.bench.judging.evidence import judge
from msvalidate.bench.judging.sweep import Setting
from msvalidate.bench.output import page, stored
from msvalidate.bench.output.provenance import collect_provenance
from msvalidate.studies import poisson

BROWSER = next(
    filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), ""
)
DRIVER = shutil.which("chromedriver") or ""
SWITCHES = (
    *("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run"),
    *("--disable-background-networking", "--disable-component-update", "--disable-sync"),
    "--disable-dev-shm-usage",
)
WIDTHS = (1280, 390)
"""A desk and a phone, in CSS pixels."""

pytestmark = pytest.mark.skipif(
    not (BROWSER and DRIVER), reason="no Chromium and chromedriver here: .ci/run installs them"
)


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    webdriver = pytest.importorskip("selenium.webdriver", reason="selenium is not installed")
    options = webdriver.ChromeOptions()
    options.binary_location = BROWSER
    profile = tmp_path_factory.mktemp("browser")
    for switch in (*SWITCHES, f"--user-data-dir={profile}"):
        options.add_argument(switch)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    service = webdriver.ChromeService(DRIVER)
    driver = webdriver.Chrome(options=options, service=service)
    driver.set_page_load_timeout(60)
    yield driver
    driver.quit()


def real_results(folder, evidence):
    """What a study found, through its files."""
    result = stored.Result("poisson", poisson.__doc__, evidence, judge(evidence))
    origin = collect_provenance(["a", "command"], 0, datetime.now(UTC), 1.5, form="quick")
    for name, content in stored.result_files(result, origin).items():
        (folder / name).write_bytes(content)
    return stored.read_result(folder)


LONG = "Donaudampfschifffahrtselektrizitätenhauptbetriebswerkbauunterbeamtengesellschaft" * 2
PICTURE = (
    b'<svg xmlns="http://www.w3.org/2000/svg" width="864pt" height="90pt" viewBox="0 0 864 90">'
    b'<rect width="864" height="90" fill="#56B4E9"/></svg>'
)


def ugly_results():
    """Long words everywhere, more columns than fit, other scripts, and all that can go wrong."""
    row = {"layer": "theory", "quantity": LONG, "unit": LONG, "observed": float("nan")}
    row |= {"reference": 1.0, "error": float("nan"), "limit": 0.0, "verdict": "fail"}
    verdict = pd.DataFrame([row | {"because": LONG}, row | {"because": "", "layer": "baseline"}])
    columns = {f"{name}_{LONG[: 3 * i]}": f"{LONG} ({i})" for i, name in enumerate("abcdefghijklm")}
    tables = {
        "cases": pd.DataFrame({column: [f"{i / 7}" for i in range(60)] for column in columns}),
        "long": pd.DataFrame({"word": ["μ"] * 60}),
        "words": pd.DataFrame({"word": [LONG, "短い 言葉", "كلمة", "μ ± σ²", "<b>x</b>", ""]}),
    }
    whole = stored.Stored(
        name=LONG,
        question=f"{LONG}?\n\n{LONG} `{LONG}`\n\n- {LONG}\n",
        findings=(LONG,),
        columns=columns | {"word": LONG},
        origin={LONG: LONG, "time": LONG},
        verdict=verdict,
        tables=tables,
        pictures={"picture": (LONG, PICTURE)},
    )
    stopped = stored.Stored("stopped", "", (), {}, {}, verdict[:0], {}, {}, f"{LONG} {LONG}")
    return [whole, stopped]


@pytest.fixture(scope="module")
def real(tmp_path_factory):
    evidence = poisson.finite_size.run(setting=Setting(quick=True))
    return real_results(tmp_path_factory.mktemp("poisson"), evidence)


@pytest.fixture(scope="module", params=["real", "ugly", "empty"])
def address(request, real, tmp_path_factory):
    studies = {"real": [real], "ugly": ugly_results(), "empty": []}[request.param]
    file = tmp_path_factory.mktemp("page") / "report.html"
    file.write_text(page.render_page(studies), encoding="utf-8")
    return file.as_uri()


@pytest.fixture(params=WIDTHS)
def opened(request, browser, address):
    """The browser with the page opened at one width."""
    return open_page(browser, address, request.param)


def open_page(browser, address, width):
    # A window has a least width; a device does not.
    screen = {"width": width, "height": 844, "deviceScaleFactor": 1, "mobile": width < 600}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", screen)
    browser.get_log("browser")  # forget what was said before
    browser.get(address)
    return browser


def test_page_is_as_wide_as_the_screen(opened):
    for width in ("document.documentElement.scrollWidth", "document.body.scrollWidth"):
        seen = opened.execute_script(f"return [{width}, document.documentElement.clientWidth]")
        assert seen[0] <= seen[1]
    opened.execute_script("for (const d of document.querySelectorAll('details')) d.open = true")
    seen = opened.execute_script(
        "const e = document.documentElement; return [e.scrollWidth, e.clientWidth]"
    )
    assert seen[0] <= seen[1]


def test_what_is_wider_scrolls_in_its_own_box(opened):
    stray = opened.execute_script(
        """
        const far = document.documentElement.clientWidth + 1;
        return [...document.body.querySelectorAll("*")]
          .filter(e => !e.closest(".box, .frame") && e.getBoundingClientRect().right > far)
          .map(e => e.outerHTML.slice(0, 80));
        """
    )
    assert stray == []


def test_pictures_are_shown(opened):
    seen = opened.execute_script(
        "return [...document.images].map(i => [i.complete, i.naturalWidth, i.clientWidth, i.alt])"
    )
    assert all(complete and own > 0 and shown > 0 for complete, own, shown, _ in seen), seen
    expected = opened.execute_script("return document.querySelectorAll('figure').length")
    assert len(seen) == expected


def test_browser_has_nothing_to_complain_of(opened):
    said = [e for e in opened.get_log("browser") if e["level"] in ("SEVERE", "WARNING")]
    assert said == []
    assert opened.execute_script("return document.compatMode") == "CSS1Compat"
    loaded = opened.execute_script(
        "return performance.getEntriesByType('resource').map(e => e.name.slice(0, 5))"
    )
    assert set(loaded) <= {"data:"}


def test_words_stand_out_from_their_ground(opened):
    """Contrast of 4.5 to 1 or more, as WCAG 2 asks of text of this size."""
    assert opened.execute_script(CONTRAST, 4.5) == []


CONTRAST = """
const colour = text => {
  const n = text.match(/[\\d.]+/g).map(Number);
  return [n[0], n[1], n[2], n.length > 3 ? n[3] : 1];
};
const over = (top, below) => [0, 1, 2].map(i => top[i] * top[3] + below[i] * (1 - top[3]));
const ground = e => e ? over(colour(getComputedStyle(e).backgroundColor), ground(e.parentElement))
                      : [255, 255, 255];
const light = c => {
  const [r, g, b] = c.map(v => v / 255).map(
    v => v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4);
  return 0.2126 * r + 0.7152 * g + 0.0722 * b + 0.05;
};
const faint = new Set();
for (const e of document.body.querySelectorAll("*")) {
  if (![...e.childNodes].some(n => n.nodeType === 3 && n.data.trim())) continue;
  const [a, b] = [light(colour(getComputedStyle(e).color)), light(ground(e))];
  const ratio = Math.max(a, b) / Math.min(a, b);
  if (ratio < arguments[0]) faint.add(`${e.tagName} ${e.className} ${ratio.toFixed(2)}`);
}
return [...faint];
"""


def test_closed_tables_are_printed(browser, address):
    open_page(browser, address, 1280)
    closed = browser.execute_script(
        "return document.querySelectorAll('details:not([open])').length"
    )
    assert closed or not browser.execute_script(
        "return document.querySelectorAll('section section, details').length"
    )
    as_it_is = printed_pages(browser)
    browser.execute_script("for (const d of document.querySelectorAll('details')) d.open = true")
    assert as_it_is == printed_pages(browser) > 0


def printed_pages(browser):
    """How many sheets of paper the page takes."""
    printed = browser.execute_cdp_cmd("Page.printToPDF", {"preferCSSPageSize": True})
    return len(re.findall(rb"/Type\s*/Page\b", base64.b64decode(printed["data"])))
