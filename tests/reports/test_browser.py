"""The pages in a real browser: `python -m pytest -m browser tests/reports`.

Needs a chromium of the system, playwright and axe (extra `dev`); skipped where one is missing.
REPORT=reports/out looks at that report instead of a small one.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from reports.cli.commands import run
from reports.page.render import PARTS
from tests.reports.browsing import MARKS, WIDTHS, browsing, looking, violations

OPEN = "document.querySelectorAll('details').forEach(one => { one.open = true; })"
SHOW = "document.querySelectorAll('[hidden]').forEach(one => one.removeAttribute('hidden'))"
SHOWN = "[...document.querySelectorAll('{}')].filter(one => !one.hidden)"
A4 = 1047  # pixels of CSS across a landscape page of A4 within its margins
FIRST_VIEW = 1_000_000  # bytes of the start with what it shows before scrolling
NAMES = tuple(part.name for part in PARTS)
OVERFLOW = """() => [...document.querySelectorAll('body *')].filter(one => {
    const box = one.getBoundingClientRect();
    if (!box.width || one.closest('.wide, .picture, .skip, aside, nav')) return false;
    return box.right > innerWidth + 1 || box.left < -1;
}).slice(0, 5).map(one => one.tagName + '.' + one.className + ' ' + one.textContent.slice(0, 40))"""
SIDEWAYS = """() => [...document.querySelectorAll('.wide')]
    .filter(one => one.scrollWidth > one.clientWidth + 1)
    .map(one => one.innerText.slice(0, 40))"""

pytestmark = MARKS


@pytest.fixture(scope="module")
def out(make_suite, make_claim, make_row, tmp_path_factory) -> Path:
    """The report to look at."""
    if "REPORT" in os.environ:
        return Path(os.environ["REPORT"]).resolve()
    folder = tmp_path_factory.mktemp("report")
    suite = make_suite(
        make_claim("V1"),
        make_claim("L3", (make_row(verdict="exceeds", quantity="order", setup="x; " * 60),)),
        make_claim("V5", tuple(make_row(quantity=f"number {k}") for k in range(9))),
    )
    run(lambda: suite, ["build", "--quick", "--single-file", "--out", str(folder)])
    return folder


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with browsing() as started:
        yield started


@pytest.fixture
def opened(browser, out) -> Iterator[Any]:
    """See `looking`."""
    with looking(browser, out) as look:
        yield look


@pytest.mark.parametrize("name", (*NAMES, "report"))
def test_nothing_is_too_wide_and_the_console_is_silent(opened, out, name):
    if "REPORT" in os.environ and not (out / f"{name}.html").exists():
        pytest.skip(f"{out} has no {name}.html: build it with --single-file")
    for width in WIDTHS:
        page = opened(name, width)
        assert page.evaluate("document.documentElement.scrollWidth") <= width, (name, width)
        assert page.evaluate(OVERFLOW) == [], (name, width)
        assert page.said == []


def test_a_telephone_is_shown_the_narrow_figures(opened):
    for width, narrow in ((max(WIDTHS), False), (400, True)):
        page = opened("claims", width)
        page.evaluate(OPEN)
        sources = page.evaluate(
            "[...document.querySelectorAll('.picture img')]"
            ".map(one => { one.loading = 'eager'; return one.decode().then(() => one.currentSrc) })"
            ".reduce((all, one) => all.then(list => one.then(it => [...list, it])),"
            " Promise.resolve([]))"
        )
        assert sources and all(one.endswith("-narrow.svg") == narrow for one in sources)


@pytest.mark.parametrize("name", NAMES)
def test_no_table_scrolls_sideways_in_a_wide_window(opened, name):
    page = opened(name, max(WIDTHS))
    page.evaluate(OPEN)
    assert page.evaluate(SIDEWAYS) == []
    wide = "<div class='wide'><div style='width: 2000px'>wide</div></div>"
    page.evaluate(f"document.querySelector('main').insertAdjacentHTML('beforeend', `{wide}`)")
    assert page.evaluate(SIDEWAYS) == ["wide"]


@pytest.mark.parametrize("name", NAMES)
def test_print_cuts_nothing_off(opened, name):
    page = opened(name, A4)
    page.evaluate(OPEN)
    page.emulate_media(media="print")
    assert page.evaluate("document.documentElement.scrollWidth") <= A4
    assert page.evaluate(OVERFLOW.replace(".wide, .picture, ", "")) == []


def test_a_table_that_is_too_wide_would_be_found(opened):
    page = opened("index", 400)
    wide = "<div style='width: 900px; height: 9px'></div>"
    page.evaluate(f"document.querySelector('main').insertAdjacentHTML('beforeend', `{wide}`)")
    assert page.evaluate(OVERFLOW) != []


@pytest.mark.parametrize("dark", (False, True))
@pytest.mark.parametrize("name", NAMES)
def test_contrast_names_and_alternative_texts_satisfy_axe(opened, name, dark):
    page = opened(name, 1400, dark)
    page.evaluate(OPEN)
    page.evaluate(SHOW)
    assert violations(page) == []


def test_axe_finds_a_picture_without_a_text_and_pale_words(opened):
    page = opened("provenance")
    page.evaluate("document.querySelector('main').innerHTML += '<img src=\"data:,\">"
                  "<p style=\"color: #ddd; background: #fff\">pale</p>'")  # fmt: skip
    assert {"image-alt", "color-contrast"} <= {rule for rule, _ in violations(page)}


def test_every_picture_loads(opened):
    for name in ("index", "claims", "comparisons", "studies"):
        page = opened(name)
        page.evaluate(OPEN)
        page.evaluate("document.querySelectorAll('img').forEach(one => { one.loading = 'eager'; })")
        page.wait_for_function("[...document.images].every(one => one.complete)")
        assert page.evaluate("[...document.images].filter(one => !one.naturalWidth).length") == 0


def test_the_search_finds_a_claim_by_its_name_its_words_and_its_verdict(opened):
    page = opened("claims")
    visible = SHOWN.format("article.claim") + ".map(one => one.id)"
    everything = page.evaluate(visible)
    page.fill("#claim-search", "l3")
    assert page.evaluate(visible) == ["L3"]
    assert page.inner_text("form.search output").startswith("1 of ")
    page.fill("#claim-search", "no such words anywhere")
    assert page.evaluate(visible) == []
    page.fill("#claim-search", "")
    page.select_option("#claim-verdict", "exceeds")
    chosen = page.evaluate(visible)
    assert "L3" in chosen and len(chosen) < len(everything)


def test_the_table_of_integrators_can_be_filtered(opened):
    page = opened("index")
    rows = SHOWN.format("#chooser tbody tr") + ".length"
    before = page.evaluate(rows)
    page.select_option("form.filter select >> nth=1", index=1)
    assert 0 < page.evaluate(rows) < before
    assert page.inner_text("form.filter output").startswith(str(page.evaluate(rows)))


def test_without_scripts_everything_is_shown(opened):
    page = opened("claims", scripts=False)
    assert page.locator("article.claim:visible").count() == page.locator("article.claim").count()
    assert page.locator("form.search:visible").count() == 0


def test_the_first_view_is_small(out, opened):
    page = opened("index")
    early = "one.getBoundingClientRect().top < 900 || one.loading != 'lazy'"
    eager = f"[...document.images].filter(one => {early})"
    seen = page.evaluate(f"{eager}.map(one => one.getAttribute('src'))")
    files = ["index.html", "assets/page.css", "assets/page.js", *seen]
    assert sum((out / name).stat().st_size for name in files) < FIRST_VIEW


def test_a_moving_picture_rests_until_asked_where_motion_is_unwanted(opened):
    page = opened("index")
    for button in page.locator("figure.motion button").all():
        assert button.inner_text() == "Play"
    if page.locator("figure.motion").count():
        before = page.get_attribute("figure.motion .moving", "cx")
        page.locator("figure.motion button").first.click()
        place = "document.querySelector('figure.motion .moving').getAttribute('cx')"
        page.wait_for_function(f"{place} != '{before}'")


def test_links_between_pages_and_anchors_lead_somewhere(out):
    pages = {path.name: path.read_text(encoding="utf-8") for path in out.glob("*.html")}
    for name in (f"{one}.html" for one in (*NAMES, "report")):
        for target in set(re.findall(r'href="([^":]*)"', pages.get(name, ""))):
            file, _, anchor = target.partition("#")
            if not file or file.endswith(".html"):
                assert not anchor or f'id="{anchor}"' in pages[file or name], (name, target)
            else:
                assert (out / file).is_file(), (name, target)


CUT = """() => [...document.querySelectorAll('.wide')].filter(one => {
    const caption = one.querySelector('caption span');
    const end = caption ? caption.getBoundingClientRect().right : 0;
    return end > one.getBoundingClientRect().right + 1;
}).map(one => one.ariaLabel)"""


@pytest.mark.parametrize("name", NAMES)
def test_captions_are_as_wide_as_the_box_of_their_table(opened, name):
    for width in WIDTHS:
        page = opened(name, width)
        page.evaluate(OPEN)
        assert page.evaluate(CUT) == [], width


def test_a_caption_that_is_cut_would_be_found(opened):
    page = opened("comparisons", 400)
    page.add_style_tag(content="caption span { display: block !important; width: 3000px; "
                       "max-width: none !important; }")  # fmt: skip
    assert page.evaluate(CUT) != []
