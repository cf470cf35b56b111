"""A build shows a page early, and fills it as it goes on."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
import pytest

from reports.build.first_look import remembering
from tests.suite.reports.counted_suite import Bench

NOTE = "Still measuring"


@pytest.fixture
def bench(make_suite, make_claim, undrawn: None) -> Bench:
    return Bench(make_suite, make_claim)


@pytest.mark.slow_cases("study-the studies")
@pytest.mark.parametrize(
    ("part", "to_come"),
    [("ball", "all comparisons, the studies"), ("study", "the studies")],
)
def test_a_build_that_goes_on_has_a_page_that_says_what_is_to_come(
    bench: Bench, tmp_path: Path, part: str, to_come: str
) -> None:
    bench.stop = part
    assert bench("build", "--out", str(tmp_path))[0] == 2
    page = (tmp_path / "results" / "index.html").read_text()
    assert f"{NOTE}.</strong> To come: {to_come}." in page


@pytest.mark.slow(beside="test_a_build_that_goes_on_has_a_page_that_says_what_is_to_come")
def test_the_page_has_the_claims_that_finish_soon_and_is_whole_at_the_end(
    bench: Bench, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch
) -> None:
    def finishing(studies, cache):
        assert [study.name for study in studies] == ["V1", "V3"]
        for study in studies:
            cache.keep(study.name, study.measure(print), 0.1)
            yield study, 0.1

    monkeypatch.setattr("reports.build.first_look.study_in_workers", finishing)
    monkeypatch.setattr("reports.build.first_look.PATIENCE", 0.0)
    _, calls = bench("build", "--out", str(tmp_path))
    assert calls[:4] == ["V1", "V1", "V3", "ball"]  # V3 was too late for the first page
    said = [line for line in capsys.readouterr().out.splitlines() if "The page is" in line]
    assert [line.count(",") for line in said] == [2, 1, 0, 0]
    assert said[-1].startswith("The page is")
    assert NOTE not in (tmp_path / "results" / "index.html").read_text()


@pytest.mark.slow_cases("words1")
@pytest.mark.parametrize("words", [["--quick"], ["--claims", "V1"]])
def test_a_short_build_has_one_page(bench: Bench, tmp_path: Path, words: list[str]) -> None:
    _, calls = bench("build", "--out", str(tmp_path), *words)
    assert calls.count("V1") == 1


def test_what_was_drawn_is_not_drawn_again() -> None:
    class Figure:
        name = "orbit"

    drawn = []

    def each(function, jobs):
        drawn.extend(frame for _, frame in jobs)
        return [function(job) for job in jobs]

    draw = remembering(each)
    one, other = pd.DataFrame({"x": [1]}), pd.DataFrame({"x": [2]})
    first = draw(lambda job: object(), [(Figure, one)])
    again = draw(lambda job: object(), [(Figure, one), (Figure, other)])
    assert again[0] is first[0] and again[1] is not first[0]
    assert len(drawn) == 2
