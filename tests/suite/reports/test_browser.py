"""The site in a real browser: `python -m pytest -m browser tests/suite/reports`.

Needs a chromium of the system, playwright and axe (extra `dev`); skipped where one is missing.
REPORT=reports/out looks at that report instead of a small one.
"""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

import pytest

from reports.cli.commands import run
from reports.site.build import SiteBuilder
from reports.site.pages import PAGES
from tests.suite.reports.browsing import MARKS, WIDTHS, browsing, page_opener, violations
from tests.suite.reports.sites import BUILDER
from tests.suite.reports.small_reports import ROW, claim, suite_of

OPEN = "document.querySelectorAll('details').forEach(one => { one.open = true; })"
SHOW = "document.querySelectorAll('[hidden]').forEach(one => one.removeAttribute('hidden'))"
RESULTS = tuple(f"results/{name}" for name in PAGES)
DOCS = (  # a page of each kind, and those with the widest contents
    "index",
    "which",
    "trust",
    "multibody",
    "frames",
    "suite",
    "why",
    "tutorials/index",
    "tutorials/first_run",
    "theory/index",
    "theory/vector_spaces",
    "reference/index",
    "reference/run",
    "reference/systems",
    "commands",
    "peers",
    "defects",
    "genindex",
    "search",
)
NAMES = (*RESULTS, *DOCS)
A4 = 680  # pixels of CSS across a page of A4 within its margins
NOTICE = "[PST]:"  # in console lines of the theme
# Contents that may be wider than the window scroll in these boxes.
BOXES = "pre, .wide, .picture, .pst-scrollable-table-container, .ledger, mjx-container"
OVERFLOW = """([inside, scrolls, boxes]) => [...document.querySelectorAll(inside)].filter(one => {
    const box = one.getBoundingClientRect();
    if (!box.width || one.closest('mjx-assistive-mml, .headerlink')) return false;
    if (scrolls && one.closest(boxes)) return false;
    return box.right > innerWidth + 1 || box.left < -1;
}).slice(0, 5).map(one => one.tagName + '.' + one.className + ' ' + one.textContent.slice(0, 60))"""
UNLOADED = "[...document.images].filter(one => !one.naturalWidth).length"
VISIBLE = (
    "[...document.querySelectorAll('.claim')].filter(one => one.offsetParent).map(one => one.id)"
)

pytestmark = MARKS


@pytest.fixture(scope="module")
def out(tmp_path_factory):
    """The folder of the report to open."""
    if "REPORT" in os.environ:
        return Path(os.environ["REPORT"]).resolve()
    folder = tmp_path_factory.mktemp("report")
    exceeds = replace(ROW, verdict="exceeds", quantity="order", setup="x; " * 60)
    many = tuple(replace(ROW, quantity=f"number {k}") for k in range(9))
    suite = suite_of(claim("V1"), claim("L3", (exceeds,)), claim("V5", many))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(BUILDER, SiteBuilder)
        run(lambda: suite, ["build", "--quick", "--single-file", "--out", str(folder)])
    return folder


@pytest.fixture(scope="module")
def browser():
    with browsing() as started:
        yield started


@pytest.fixture
def opened(browser, out):
    """The function of `page_opener`, without a network; it waits until formulas are set."""
    with page_opener(browser, out, NOTICE) as open_page:

        def opened(name, width=1400, dark=False, scripts=True):
            page = open_page(name, width, dark, scripts, offline=True)
            if scripts:
                page.wait_for_function(
                    "!document.querySelector('.math') || document.querySelector('mjx-container')"
                )
            return page

        yield opened


def overflow(page, scrolls=True):
    """Elements that are wider than the window."""
    inside = "article *" if page.locator("article.bd-article").count() else "main *"
    return page.evaluate(OVERFLOW, [inside, scrolls, BOXES])


@pytest.mark.parametrize("name", (*NAMES, "report"))
def test_pictures_load_nothing_is_too_wide_and_the_console_is_silent_without_a_network(
    opened, out, name
):
    if "REPORT" in os.environ and not (out / f"{name}.html").exists():
        pytest.skip(f"{out} has no {name}.html: build it with --single-file")
    for width in WIDTHS:
        page = opened(name, width)
        page.evaluate("document.querySelectorAll('img').forEach(one => { one.loading = 'eager'; })")
        page.wait_for_function("[...document.images].every(one => one.complete)")
        assert page.evaluate(UNLOADED) == 0, (name, width)
        assert page.evaluate("document.documentElement.scrollWidth") <= width, (name, width)
        assert overflow(page) == [], (name, width)
        assert page.console_lines == []


def test_a_telephone_is_shown_the_narrow_figures(opened):
    for width, narrow in ((max(WIDTHS), False), (400, True)):
        page = opened("results/claims", width)
        page.evaluate(OPEN)
        sources = page.evaluate(
            "Promise.all([...document.querySelectorAll('.picture img')]"
            ".map(one => { one.loading = 'eager';"
            " return one.decode().then(() => one.currentSrc); }))"
        )
        assert sources and all(source.endswith("-narrow.svg") == narrow for source in sources)


@pytest.mark.parametrize(
    ("query", "address"),
    [("integrate_ensemble", "reference/ensembles"), ("printed statement", "results/claims")],
)
def test_one_search_finds_names_of_the_reference_and_claims(opened, out, query, address):
    page = opened("search")
    page.goto(f"{(out / 'search.html').as_uri()}?q={query}")
    page.wait_for_selector(f"#search-results a[href*='{address}']")


@pytest.mark.parametrize("name", NAMES)
def test_print_cuts_nothing_off_and_leaves_navigation_out(opened, name):
    page = opened(name, A4)
    page.evaluate(OPEN)
    page.emulate_media(media="print")
    assert overflow(page, scrolls=False) == []
    assert not page.locator(".bd-sidebar-primary").is_visible()


def test_something_too_wide_would_be_found(opened):
    page = opened("index", 400)
    wide = "<div style='width: 900px; height: 9px'>wide</div>"
    page.evaluate(f"document.querySelector('article').insertAdjacentHTML('beforeend', `{wide}`)")
    assert overflow(page) != []


@pytest.mark.parametrize("dark", (False, True))
@pytest.mark.parametrize("name", NAMES)
def test_contrast_names_and_alternative_texts_satisfy_axe(opened, name, dark):
    page = opened(name, 1400, dark)
    if name in RESULTS:
        page.evaluate(OPEN)
        page.evaluate(f"document.querySelectorAll('article').forEach(() => {{ {SHOW} }})")
    assert violations(page) == []


def test_axe_finds_a_picture_without_a_text_and_pale_words(opened):
    page = opened("results/provenance")
    page.evaluate(
        "document.querySelector('article').innerHTML += '<img src=\"data:,\">"
        '<p style="color: #ddd; background: #fff">pale</p>\''
    )
    assert {"image-alt", "color-contrast"} <= {rule for rule, _ in violations(page)}


@pytest.mark.parametrize("name", ("results/claims", "report"))
def test_claims_are_found_by_their_names_their_words_and_their_verdicts(opened, out, name):
    if not (out / f"{name}.html").exists():
        pytest.skip(f"{out} has no {name}.html: build it with --single-file")
    page = opened(name)
    everything = page.evaluate(VISIBLE)
    page.fill("#claim-search", "l3")
    assert page.evaluate(VISIBLE) == ["L3"]
    assert page.inner_text("form.search output").startswith("1 of ")
    page.fill("#claim-search", "no such words anywhere")
    assert page.evaluate(VISIBLE) == []
    page.fill("#claim-search", "")
    page.select_option("#claim-verdict", "exceeds")
    chosen = page.evaluate(VISIBLE)
    assert 0 < len(chosen) < len(everything) and ("L3" in chosen or "REPORT" in os.environ)


def test_the_table_of_integrators_can_be_filtered(opened):
    page = opened("results/index")
    rows = "[...document.querySelectorAll('#chooser tbody tr')].filter(one => !one.hidden).length"
    before = page.evaluate(rows)
    page.select_option("form.filter select >> nth=1", index=1)
    assert 0 < page.evaluate(rows) < before
    assert page.inner_text("form.filter output").startswith(str(page.evaluate(rows)))


def test_without_scripts_everything_is_shown(opened):
    page = opened("results/claims", scripts=False)
    assert page.locator(".claim:visible").count() == page.locator(".claim").count()
    assert page.locator("form.search:visible").count() == 0
