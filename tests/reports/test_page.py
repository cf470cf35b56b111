"""The page: every row and figure, nothing fetched, no number where nothing was measured."""

from __future__ import annotations

import re
from html.parser import HTMLParser

import pytest

from reports.cli.commands import run


@pytest.fixture(scope="module")
def page(make_suite, make_claim, make_row, tmp_path_factory) -> str:
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
    run(lambda: suite, ["build", "--claims", "V1,V2,V3", "--quick", "--out", str(out)])
    return (out / "index.html").read_text(encoding="utf-8")


class Balance(HTMLParser):
    """Fails on a tag that closes another than the last one opened."""

    VOID = ("meta", "link", "img", "br")

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []

    def handle_starttag(self, tag, attributes):
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag


def test_the_page_is_well_formed(page):
    parser = Balance()
    parser.feed(page)
    assert parser.open == []


def test_the_page_fetches_nothing_and_runs_nothing(page):
    assert "http:" not in page and "https:" not in page and "<script" not in page
    for target in re.findall(r'(?:src|href)="([^"]*)"', page):
        assert target.startswith(("data:", "#"))
    for anchor in re.findall(r'href="#([^"]*)"', page):
        assert f'id="{anchor}"' in page


def test_the_page_has_every_row_with_its_verdict_and_reason(page):
    for id in ("V1", "V2", "V3"):
        assert f'<h2 id="{id}">{id}: title of {id}</h2>' in page
    for verdict in ("holds", "contradicted", "not run"):
        assert f">{verdict}</span>" in page
    assert "0.250 ± 0.010" in page
    assert "OSError: no such engine" in page
    assert "&lt;drift&gt; &amp; 10<sup>\u22129</sup>" in page


def test_differences_stand_at_the_top(page):
    top = page[: page.index('<h2 id="claims">')]
    assert 'role="alert"' in top
    assert "contradicted, expected holds" in top
    assert "not run, expected holds (OSError: no such engine)" in top


def test_the_page_says_what_was_not_run_and_what_is_not_drawn(page):
    assert "Not run in this build, which was restricted to some claims: V4." in page
    assert "H fig. 2.4 is not drawn: what it shows was not run." not in page  # V2 gave a frame
    assert "H fig. 2.4 is not drawn: no run has a finite error." in page
    assert "H fig. 2.6 is not drawn: what it shows was not run." in page


def test_no_missing_number_is_written_as_one(page):
    text = re.sub(r'src="data:[^"]*"', "", page)
    assert not re.search(r"\b(nan|NaN|None|inf)\b", text)


def test_the_page_states_when_and_from_what_it_was_made(page):
    assert "2026-01-02 03:04 UTC, commit 0123456789ab with changes, in the quick setting" in page
    assert "0123456789abcdef+dirty" in page
    assert "python -m reports build --claims V1,V2,V3 --quick" in page


def test_every_picture_is_in_the_page_and_described(page):
    titles = re.findall(r'<img src="data:image/svg[^"]*" alt="([^"]+)"', page)
    assert any(title.startswith("H fig. 2.3") for title in titles)
    assert "Kepler e=0.6: error against time" in titles
    assert "Time for one step" in titles


def test_comparisons_say_who_wins_and_who_did_not_get_there(page):
    assert "SciPy DOP853 wins at 10⁻⁴" in page
    assert "galvi is fastest at 10⁻⁶, 10⁻⁷, 10⁻⁸, 10⁻⁹" in page
    assert "not reached" in page
    assert "The run failed: use smaller steps." in page
    assert "Taylor is the reference and has no error" in page


def test_a_further_study_is_a_table_with_its_text(page):
    place = page[page.index('<h2 id="sky-and-model">Model against sky</h2>') :]
    assert "Far below 10<sup>\u22126</sup> au." in place
    assert '<td>Mars</td><td class="number">1000</td><td class="number">1.23·10⁻⁷</td>' in place
    assert '<td>Sun</td><td class="number">1000</td><td class="number"></td>' in place
    assert "note" not in place[place.index("<thead>") : place.index("</thead>")]
    assert "<code>sky_and_model.csv</code>" in place
