"""The documentation in a real browser: `python -m pytest -m browser tests/reports`.

Needs what `tests/reports/test_browser.py` needs, and Sphinx (extra `docs`). DOCS=reports/out/docs
looks at pages that are built instead of building them.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.reports.browsing import MARKS, WIDTHS, browsing, looking, violations

ROOT = Path(__file__).parents[2]
A4 = 680  # pixels of CSS across a page of A4 within its margins
KINDS = (  # a page of each kind, and those with what is widest
    "index",
    "which",
    "trust",
    "multibody",
    "frames",
    "suite",
    "why",
    "tutorials/index",
    "tutorials/first_run",
    "tutorials/judged",
    "theory/index",
    "theory/vector_spaces",
    "theory/lie_groups",
    "reference/index",
    "reference/run",
    "reference/methods",
    "reference/systems",
    "generated/commands",
    "generated/peers/index",
    "generated/peers/galvi",
    "genindex",
    "search",
)
NOTICE = "[PST]:"  # of the theme, on what it does
# What may be wider than the window scrolls in a box of its own.
OVERFLOW = """scrolls => [...document.querySelectorAll('article *')].filter(one => {
    const box = one.getBoundingClientRect();
    if (!box.width || one.closest('mjx-assistive-mml, .headerlink')) return false;
    if (scrolls && one.closest('pre, .pst-scrollable-table-container, .ledger, mjx-container'))
        return false;
    return box.right > innerWidth + 1 || box.left < -1;
}).slice(0, 5).map(one => one.tagName + '.' + one.className + ' ' + one.textContent.slice(0, 60))"""

pytestmark = MARKS


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The documentation to look at."""
    if "DOCS" in os.environ:
        return Path(os.environ["DOCS"]).resolve()
    pytest.importorskip("sphinx_book_theme", reason="the extra docs is not installed")
    folder = tmp_path_factory.mktemp("site") / "docs"
    command = [sys.executable, "-m", "sphinx", "-n", "-W", "-q", str(ROOT / "docs"), str(folder)]
    subprocess.run(command, check=True, cwd=ROOT)
    return folder


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with browsing() as started:
        yield started


@pytest.fixture
def opened(browser: Any, site: Path) -> Iterator[Any]:
    """See `looking`; without a network, and with the formulas set."""
    with looking(browser, site, NOTICE) as look:

        def opened(name: str, width: int = 1400, dark: bool = False) -> Any:
            page = look(name, width, dark, offline=True)
            page.wait_for_function(
                "!document.querySelector('.math') || document.querySelector('mjx-container')"
            )
            return page

        yield opened


@pytest.mark.parametrize("name", KINDS)
def test_nothing_is_too_wide_and_the_console_is_silent_without_a_network(opened, name):
    for width in WIDTHS:
        page = opened(name, width)
        assert page.evaluate("document.documentElement.scrollWidth") <= width, (name, width)
        assert page.evaluate(OVERFLOW, True) == [], (name, width)
        assert page.said == []


@pytest.mark.parametrize("name", KINDS)
def test_print_cuts_nothing_off_and_leaves_navigation_out(opened, name):
    page = opened(name, A4)
    page.emulate_media(media="print")
    assert page.evaluate(OVERFLOW, False) == []
    assert not page.locator(".bd-sidebar-primary").is_visible()


@pytest.mark.parametrize("dark", (False, True))
@pytest.mark.parametrize("name", KINDS)
def test_contrast_names_and_alternative_texts_satisfy_axe(opened, name, dark):
    assert violations(opened(name, 1400, dark)) == []


@pytest.mark.parametrize("name", KINDS)
def test_every_picture_loads(opened, name):
    page = opened(name)
    page.evaluate("document.querySelectorAll('img').forEach(one => { one.loading = 'eager'; })")
    page.wait_for_function("[...document.images].every(one => one.complete)")
    assert page.evaluate("[...document.images].filter(one => !one.naturalWidth).length") == 0


def test_something_too_wide_would_be_found(opened):
    page = opened("index", 400)
    wide = "<div style='width: 900px; height: 9px'>wide</div>"
    page.evaluate(f"document.querySelector('article').insertAdjacentHTML('beforeend', `{wide}`)")
    assert page.evaluate(OVERFLOW, True) != []


def test_the_search_finds_a_name_of_the_reference(opened, site):
    page = opened("search")
    page.goto(f"{(site / 'search.html').as_uri()}?q=integrate_ensemble")
    page.wait_for_selector("#search-results a[href*='reference/ensembles']")


def test_the_navigation_leads_to_the_report(opened):
    for name, way in (("index", "../index.html"), ("reference/run", "../../index.html")):
        assert opened(name).get_attribute(".home a >> nth=1", "href").removeprefix("./") == way
