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

VOID = ("meta", "link", "img", "source", "br", "input", "circle", "path", "ellipse")


@pytest.fixture(scope="module")
def out(make_suite, make_claim, make_row, tmp_path_factory) -> Path:
    """Three claims: one holds, one differs, one raised; a fourth was not asked for."""
    out = tmp_path_factory.mktemp("page")
    suite = make_suite(
        make_claim("V1"),
        make_claim(
            "V2", (make_row(verdict="contradicted", quantity="<drift> & 1e-9", setup="a^2"),)
        ),
        make_claim("V3", raises=OSError("no such engine")),
        make_claim("V4"),
    )
    words = ["build", "--claims", "V1,V2,V3", "--quick", "--single-file", "--out", str(out)]
    with pages_of_results():
        run(lambda: suite, words)
    return out


@pytest.fixture(scope="module")
def pages(out) -> dict[str, str]:
    """The text of each page by its name, and of the single file."""
    files = [*(out / "results").glob("*.html"), out / "report.html"]
    return {path.stem: path.read_text(encoding="utf-8") for path in files}


def main_part(page: str) -> str:
    """What a page says, without navigation and style."""
    return page[page.index("<article") : page.index("</article>")]


class Balance(HTMLParser):
    """Fails on a tag that closes another than the last one opened."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []

    def handle_starttag(self, tag, attributes):
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        if tag not in VOID:
            assert self.open.pop() == tag


def test_every_part_is_a_page_and_all_are_in_one_file(pages):
    assert set(pages) == {*PAGES, "report"}
    for name in PAGES:
        assert f'<div class="part" id="{name}">' in pages["report"]


def test_the_pages_are_well_formed(pages):
    for page in pages.values():
        parser = Balance()
        parser.feed(page)
        assert parser.open == []


def broken_links(page: str, out: Path) -> list[str]:
    """Targets in a page's results that are neither embedded nor in the folder."""
    bad = (
        [] if not re.search(r"https?:(?!//www\.w3\.org)", page) else ["something from the network"]
    )
    for target in re.findall(r'(?:src|href)="([^"]*)"', page):
        file, _, anchor = target.partition("#")
        if target.startswith("data:"):
            continue
        there = page if not file else None
        if file:
            path = (out / "results" / file).resolve()
            if not path.is_file():
                bad.append(target)
                continue
            there = path.read_text(encoding="utf-8") if anchor else ""
        if anchor and f'id="{anchor}"' not in there:
            bad.append(target)
    return bad


def test_every_link_of_every_page_resolves_and_nothing_is_fetched(pages, out):
    for name, page in pages.items():
        assert broken_links(page if name == "report" else main_part(page), out) == [], name
    assert not re.findall(r'(?:src|href)="(?!data:|#)', pages["report"])


def test_a_link_that_leads_nowhere_would_be_found(pages, out):
    page = main_part(pages["index"])
    planted = page.replace('href="claims.html"', 'href="claims.html#V99"', 1)
    assert broken_links(planted, out) == ["claims.html#V99"]
    assert broken_links(page + '<a href="#nowhere">', out) == ["#nowhere"]


def test_the_claims_have_every_row_with_its_verdict_and_reason(pages):
    page = pages["claims"]
    for id in ("V1", "V2", "V3"):
        assert f'<div class="claim" id="{id}"' in page and f"{id}: title of {id}" in page
        assert f"<code>galvi verify --claims {id}</code>" in page
        assert f'href="claims.html#{id}"' in pages["reproduce"]
    for verdict in ("holds", "contradicted", "not run"):
        assert f">{verdict}</span>" in page
    assert "0.250 ± 0.010" in page and "so says | the theory" in page
    assert "OSError: no such engine" in page
    assert "&lt;drift&gt; &amp; 10<sup>\u22129</sup>" in page


def test_claims_are_listed_by_their_ids_and_commands_name_no_folder(pages, out):
    ids = re.findall(r'<a href="#([VLA]\d+)">\1</a>', pages["claims"])
    assert ids == ["V1", "V2", "V3"]
    assert [time_spent(time) for time in (0.456, 12.06, 119.0, 126.0, math.nan)] == [
        "0.46 s", "12 s", "120 s", "2.1 min", "",
    ]  # fmt: skip
    for name in ("reproduce", "provenance"):
        assert str(out) not in pages[name] and "--out" not in pages[name]


def test_the_start_says_what_differs_names_both_papers_and_leads_on(pages):
    page = pages["index"]
    assert 'role="alert"' in page and "contradicted, expected holds" in page
    assert "not run, expected holds (OSError: no such engine)" in page
    assert "J. Hall" in page and "E. Miglio" in page
    assert "Not run in this build, which was restricted to some claims: V4." in page
    assert "<select" in page and "galvi degree 8, Gauss 8" in page


def test_the_page_says_what_is_not_drawn(pages):
    page = pages["claims"]
    assert "H fig. 2.4 is not drawn: what it shows was not run." not in page  # V2 gave a frame
    assert "H fig. 2.4 is not drawn: no run has a finite number of what it shows." in page
    assert "H fig. 2.6 is not drawn: what it shows was not run." in page


def test_no_missing_number_is_written_as_one(pages):
    for page in pages.values():
        text = re.sub(
            r'src="data:[^"]*"|<script>.*?</script>|<style>.*?</style>', "", page, flags=re.S
        )
        assert not re.search(r"\b(nan|NaN|None|inf)\b(?!-sup)", text)


def test_the_pages_state_when_and_from_what_they_were_made(pages):
    for page in pages.values():
        assert (
            "2026-01-02 03:04 UTC, commit 0123456789ab with changes, in the quick setting" in page
        )
        assert "runs are fewer and shorter than texts and titles say" in page
    assert "0123456789abcdef+dirty" in pages["provenance"]
    assert "--claims V1,V2,V3 --quick" in pages["provenance"]


def test_every_picture_has_a_size_and_is_described_by_what_it_shows(pages):
    found = re.findall(
        r'<img src="([^"]*)" alt="([^"]+)" width="(\d+)" height="(\d+)"', pages["claims"]
    )
    assert found and all(int(width) > 100 and int(height) > 100 for _, _, width, height in found)
    words = " ".join(alternative for _, alternative, _, _ in found)
    assert "number of basis functions n from 4 to 29" in words and "one-step 0.50^n" in words
    assert pages["claims"].count('loading="lazy"') == len(found)
    assert pages["comparisons"].count("<img ") == 1


def test_tables_have_captions_and_scopes(pages):
    for name, page in pages.items():
        assert page.count("<table") == page.count("<caption>"), name
        assert not re.search(r"<th(?! scope=)", page.replace("<thead", ""))


def test_comparisons_say_who_wins_and_who_did_not_get_there(pages):
    assert "SciPy DOP853 wins from 0.01 to 10⁻⁴ (5.0 to 10 times faster)" in pages["index"]
    assert "galvi is fastest from 10⁻⁶ to 10⁻⁸" in pages["index"]
    page = pages["comparisons"]
    assert "not reached" in page
    assert "The run failed: use smaller steps." in page
    assert "Taylor is the reference and has no error" in page


def test_a_further_study_is_a_table_with_its_text(pages):
    page = pages["studies"]
    place = page[page.index("<h2>Model against sky") :]
    assert "Far below 10<sup>\u22126</sup> au." in place
    assert (
        '<th scope="row">Mars</th><td class="number">1000</td><td class="number">1.23·10⁻⁷</td>'
        in re.sub(r"\s*\n\s*", "", place)
    )
    assert re.search(r'Sun</th>\s*<td class="number">1000</td>\s*<td class="number"></td>', place)
    assert "note" not in place[place.index("<thead>") : place.index("</thead>")]
    assert "<code>sky_and_model.csv</code>" in pages["reproduce"]


def test_the_pages_are_written_again_from_kept_rows(make_suite, make_claim, out, tmp_path, capsys):
    suite = make_suite(make_claim("V1", raises=OSError("nothing is measured")), make_claim("V2"))
    before = (out / "results" / "claims.html").read_text(encoding="utf-8")
    try:
        assert run(lambda: suite, ["build", "--kept", "--out", str(out)]) == 0
        page = (out / "results" / "claims.html").read_text(encoding="utf-8")
    finally:
        (out / "results" / "claims.html").write_text(before, encoding="utf-8")
    assert "0.250 ± 0.010" in page and "nothing is measured" not in page
    assert run(lambda: suite, ["build", "--kept", "--out", str(tmp_path)]) == 2
    assert "holds no rows yet" in capsys.readouterr().err


def test_kept_rows_of_external_integrators_are_shown_where_nothing_else_was_checked(
    make_suite, make_claim, tmp_path, capsys
):
    theirs = make_suite(make_claim("V1"), make_claim("A-my-leapfrog"), make_claim("W9"))
    words = ["verify", "--claims", "A-my-leapfrog,W9", "--out", str(tmp_path)]
    assert run(lambda: theirs, words) == 0
    for more in ([], ["--contender", "mine:Leapfrog"], ["--claims", "V1"]):
        assert run(make_suite, ["build", "--kept", *more, "--out", str(tmp_path)]) == 0
        page = (tmp_path / "results" / "claims.html").read_text(encoding="utf-8")
        assert "an external integrator and the truth" in page and "W9" not in page
        assert "received some of W9, which are left out" in capsys.readouterr().err
        assert "--claims A-my-leapfrog --contender package.module:Class</code>" in page


@pytest.mark.slow(
    beside="test_kept_rows_of_external_integrators_are_shown_where_nothing_else_was_checked"
)
def test_kept_rows_of_several_runs_are_each_shown_with_their_own_origin(
    make_suite, make_claim, tmp_path
):
    def at(commit, date):
        def provenance(command):
            return {"date": date, "commit": commit, "numpy": commit[:1], "command": command}

        return replace(make_suite(make_claim("V1"), make_claim("V2")), provenance=provenance)

    def made(suite, *words):
        return run(lambda: suite, [*words, "--out", str(tmp_path)])

    first, second, third = "a" * 40, "b" * 40, "c" * 40
    made(at(first, "2026-01-01 01:00 UTC"), "verify", "--claims", "V1")
    made(at(second, "2026-01-02 02:00 UTC"), "compare", "--quick")
    made(at(third, "2026-01-03 03:00 UTC"), "build", "--kept")
    pages = {
        path.stem: path.read_text(encoding="utf-8")
        for path in (tmp_path / "results").glob("*.html")
    }
    for name, page in pages.items():
        footer = page[page.index('class="soft small measured"') :]
        assert f"Claims: 2026-01-01 01:00 UTC, commit {first[:12]}." in footer, name
        assert f"commit {second[:12]}, in the quick setting." in footer, name
        assert third[:12] not in page, name
    assert "All numbers" not in pages["index"]
    assert "No rows are kept of: V2." in pages["index"] and "restricted" not in pages["index"]
    assert "the comparison holds none of their problems" in pages["index"]
    assert "numpy b" in pages["provenance"]
    again = pages["reproduce"]
    assert again.index(f"git checkout {first[:12]}") < again.index("reports verify --claims V1")
    assert again.index(f"git checkout {second[:12]}") < again.index("reports compare --quick")
    made(at(third, "2026-01-03 03:00 UTC"), "verify", "--claims", "V2", "--quick")
    made(at(third, "2026-01-03 03:00 UTC"), "build", "--kept")
    page = (tmp_path / "results" / "index.html").read_text(encoding="utf-8")
    told = "Claims: 2026-01-01 01:00 UTC to 2026-01-03 03:00 UTC, commits aaaaaaaaaaaa and "
    assert f"{told}cccccccccccc, partly in the quick setting." in page


def test_times_of_studies_are_left_out_where_nothing_was_timed(make_suite, tmp_path):
    for timed, words in ((False, ["verify", "--quick"]), (True, ["verify"])):
        for command in (words, ["build", "--kept"]):
            run(make_suite, [*command, "--out", str(tmp_path)])
        page = (tmp_path / "results" / "reproduce.html").read_text(encoding="utf-8")
        assert (">time</th>" in page) == timed
        assert ("the time its study took" in page) == timed


def test_a_whole_number_is_shown_as_one_on_every_python(make_row) -> None:
    """`int.is_integer` is of Python 3.12: a contender's counts ended the build on 3.11."""
    assert measured(make_row(measured=12, uncertainty=None)) == "12"
    assert measured(make_row(measured=12.0, uncertainty=None)) == "12"
    assert measured(make_row(measured=np.int64(12), uncertainty=None)) == "12"
    assert (
        measured(make_row(measured=np.float32(0.5), uncertainty=np.float32(0.25))) == "0.50 ± 0.25"
    )


def test_a_build_leaves_nothing_beside_its_folder(pages, out) -> None:
    """Extensions of Sphinx write beside the folder of the pages."""
    assert not (out.parent / "jupyter_execute").exists() and not (out / "doctrees").exists()
