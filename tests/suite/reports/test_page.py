"""The pages: every row and figure, nothing fetched, no number where nothing was measured."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

from reports.cli.commands import run
from reports.site.pages import PAGES, measured, time_spent
from tests.suite.reports.sites import pages_of_results
from tests.suite.reports.small_reports import ROW, claim, suite_of

VOID = ("meta", "link", "img", "source", "br", "input", "circle", "path", "ellipse")


@pytest.fixture(scope="module")
def out(tmp_path_factory):
    """The folder of a report: one claim holds, one differs, one raised; a fourth was left out."""
    out = tmp_path_factory.mktemp("page")
    differs = replace(ROW, verdict="contradicted", quantity="<drift> & 1e-9", setup="a^2")
    raised = claim("V3", raises=OSError("no such engine"))
    suite = suite_of(claim("V1"), claim("V2", (differs,)), raised, claim("V4"))
    arguments = ["build", "--claims", "V1,V2,V3", "--quick", "--single-file", "--out", str(out)]
    with pages_of_results():
        run(lambda: suite, arguments)
    return out


@pytest.fixture(scope="module")
def pages(out):
    """The text of each page by its name, and of the single file."""
    files = [*(out / "results").glob("*.html"), out / "report.html"]
    return {path.stem: path.read_text(encoding="utf-8") for path in files}


def main_part(page):
    """The article of a page, without navigation and style."""
    return page[page.index("<article") : page.index("</article>")]


class Balance(HTMLParser):
    """Fails on a tag that closes another than the last one opened."""

    def __init__(self):
        super().__init__()
        self.open: list[str] = []

    def handle_starttag(self, tag, attributes):
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        if tag not in VOID:
            assert self.open.pop() == tag


def broken_links(page, out):
    """Links and sources of a page that lead to no file of the folder, or no id in it."""
    broken = []
    for target in re.findall(r'(?:src|href)="(?!data:)([^"]*)"', page):
        file, _, anchor = target.partition("#")
        path = out / "results" / file
        text = path.read_text(errors="ignore") if path.is_file() else "" if file else page
        if not (path.is_file() or text) or (anchor and f'id="{anchor}"' not in text):
            broken.append(target)
    return broken


def test_every_part_is_a_well_formed_page_whose_tables_have_captions_and_all_are_in_one_file(pages):
    assert set(pages) == {*PAGES, "report"}
    assert all(f'<div class="part" id="{name}">' in pages["report"] for name in PAGES)
    for name, page in pages.items():
        parser = Balance()
        parser.feed(page)
        assert parser.open == [], name
        assert page.count("<table") == page.count("<caption>"), name
        assert not re.search(r"<th(?! scope=)", page.replace("<thead", ""))


def test_every_link_of_every_page_resolves_and_nothing_is_fetched(pages, out):
    for name, page in pages.items():
        assert broken_links(page if name == "report" else main_part(page), out) == [], name
    assert not re.findall(r'(?:src|href)="(?!data:|#)', pages["report"])


def test_a_link_that_leads_nowhere_would_be_found(pages, out):
    page = main_part(pages["index"])
    planted = page.replace('href="claims.html"', 'href="claims.html#V99"', 1)
    assert broken_links(planted, out) == ["claims.html#V99"]
    assert broken_links(page + '<a href="#nowhere">', out) == ["#nowhere"]


DIFFERS = "contradicted, expected holds"
SAYS = {
    "index": (
        'role="alert"', DIFFERS, "not run, expected holds (OSError: no such engine)", "J. Hall",
        "E. Miglio", "Not run in this build, which was restricted to some claims: V4.",
        "SciPy DOP853 wins from 0.01 to 10⁻⁴ (5.0 to 10 times faster)",
        "galvi is fastest from 10⁻⁶ to 10⁻⁸", "<select", "galvi degree 8, Gauss 8",
    ),
    "claims": (
        *(f'<div class="claim" id="{id}"' for id in ("V1", "V2", "V3")), "V1: title of V1",
        "<code>galvi verify --claims V3</code>", ">holds</span>", ">contradicted</span>",
        ">not run</span>", "0.250 ± 0.010", "so says | the theory", "OSError: no such engine",
        "&lt;drift&gt; &amp; 10<sup>\u22129</sup>",
        "H fig. 2.4 is not drawn: no run has a finite number of what it shows.",
        "H fig. 2.6 is not drawn: what it shows was not run.", 'loading="lazy"',
        "number of basis functions n from 4 to 29", "one-step 0.50^n",
    ),
    "comparisons": (
        "not reached", "The run failed: use smaller steps.",
        "Taylor is the reference and has no error", "<img ",
    ),
    "studies": (
        "<h2>Model against sky", "Far below 10<sup>\u22126</sup> au.",
        '<th scope="row">Mars</th><td class="number">1000</td><td class="number">1.23·10⁻⁷</td>',
        '<th scope="row">Sun</th><td class="number">1000</td><td class="number"></td>',
    ),
    "reproduce": ("<code>sky_and_model.csv</code>", 'href="claims.html#V2"'),
    "provenance": ("0123456789abcdef+dirty", "--claims V1,V2,V3 --quick"),
}  # fmt: skip
ON_ALL_PAGES = (
    "2026-01-02 03:04 UTC, commit 0123456789ab with changes, in the quick setting",
    "runs are fewer and shorter than texts and titles say",
)


@pytest.mark.parametrize("name", SAYS)
def test_a_page_says_what_was_found_from_what_and_what_is_missing(pages, out, name):
    page = re.sub(r"\s*\n\s*(?=<t[hd])", "", pages[name])
    assert [part for part in (*SAYS[name], *ON_ALL_PAGES) if part not in page] == []
    assert str(out) not in page and "--out" not in page


def test_no_missing_number_is_written_as_one(pages):
    left_out = r'src="data:[^"]*"|<script>.*?</script>|<style>.*?</style>'
    for page in pages.values():
        text = re.sub(left_out, "", page, flags=re.S)
        assert not re.search(r"\b(nan|NaN|None|inf)\b(?!-sup)", text)


def test_every_picture_has_a_size(pages):
    sizes = re.findall(
        r'<img src="[^"]*" alt="[^"]+" width="(\d+)" height="(\d+)"', pages["claims"]
    )
    assert sizes and all(int(width) > 100 and int(height) > 100 for width, height in sizes)
    assert len(sizes) == pages["claims"].count("<img ")


def test_times_that_were_spent_have_two_digits():
    assert [time_spent(time) for time in (0.456, 12.06, 119.0, 126.0, math.nan)] == [
        "0.46 s",
        "12 s",
        "120 s",
        "2.1 min",
        "",
    ]


@pytest.mark.parametrize(
    ("number", "error", "text"),
    [
        *((number, None, "12") for number in (12, 12.0, np.int64(12))),
        (np.float32(0.5), np.float32(0.25), "0.50 ± 0.25"),
    ],
)
def test_a_whole_number_is_shown_as_one_on_every_python(number, error, text):
    """`int.is_integer` is of Python 3.12: a contender's counts ended the build on 3.11."""
    assert measured(replace(ROW, measured=number, uncertainty=error)) == text


def shown(name):
    return Path(f"out/results/{name}.html").read_text(encoding="utf-8")


@pytest.mark.usefixtures("undrawn")
def test_the_pages_are_written_again_from_kept_rows_with_times_where_any_were_taken(ask):
    assert ask("build --kept").status == 2
    suite = claim("V1", raises=OSError("nothing is measured")), claim("V2")
    for command, timed in (("verify --quick", False), ("verify", True)):
        ask(command)
        assert ask("build --kept", *suite).status == 0
        assert "0.250 ± 0.010" in shown("claims") and "nothing is measured" not in shown("claims")
        assert (">time</th>" in shown("reproduce")) == timed
        assert ("the time its study took" in shown("reproduce")) == timed


@pytest.mark.usefixtures("undrawn")
@pytest.mark.parametrize("options", ["", "--contender mine:Leapfrog", "--claims V1"])
def test_kept_rows_of_external_integrators_are_shown_where_nothing_else_was_checked(ask, options):
    claims = map(claim, ("V1", "A-my-leapfrog", "W9"))
    assert ask("verify --claims A-my-leapfrog,W9", *claims).status == 0
    completed = ask(f"build --kept {options}")
    assert completed.status == 0 and "received some of W9, which are left out" in completed.err
    assert "an external integrator and the truth" in shown("claims") and "W9" not in shown("claims")
    assert "--claims A-my-leapfrog --contender package.module:Class</code>" in shown("claims")


@pytest.mark.slow(
    beside="test_kept_rows_of_external_integrators_are_shown_where_nothing_else_was_checked"
)
def test_kept_rows_of_several_runs_are_each_shown_with_their_own_origin(ask):
    def ask_at(commit, date, command):
        origin = {"date": date, "commit": commit, "numpy": commit[:1]}
        provenance = lambda command: {**origin, "command": command}  # noqa: E731
        return ask(command, replace(suite_of(claim("V1"), claim("V2")), provenance=provenance))

    first, second, third = "a" * 40, "b" * 40, "c" * 40
    ask_at(first, "2026-01-01 01:00 UTC", "verify --claims V1")
    ask_at(second, "2026-01-02 02:00 UTC", "compare --quick --out out")
    ask_at(third, "2026-01-03 03:00 UTC", "build --kept")
    for name in PAGES:
        footer = shown(name)[shown(name).index('class="soft small measured"') :]
        assert f"Claims: 2026-01-01 01:00 UTC, commit {first[:12]}." in footer, name
        assert f"commit {second[:12]}, in the quick setting." in footer, name
        assert third[:12] not in shown(name), name
    assert "No rows are kept of: V2." in shown("index")
    ask_at(third, "2026-01-03 03:00 UTC", "verify --claims V2 --quick")
    ask_at(third, "2026-01-03 03:00 UTC", "build --kept")
    phrase = "Claims: 2026-01-01 01:00 UTC to 2026-01-03 03:00 UTC, commits aaaaaaaaaaaa and "
    assert f"{phrase}cccccccccccc, partly in the quick setting." in shown("index")


def test_a_build_leaves_nothing_beside_its_folder(pages, out):
    """Extensions of Sphinx write beside the folder of the pages."""
    assert not (out.parent / "jupyter_execute").exists() and not (out / "doctrees").exists()
