"""The generated tables of README.md and docs/: what they say is what the suite says."""

from pathlib import Path

import pandas as pd
import pytest

from benchmarks.claims import CLAIMS
from reports.cli.commands import run
from reports.results.origins import note_origin
from reports.tables.readme import (
    ASKED,
    BODIES,
    CHOICES,
    EVIDENCE,
    HEADLINES,
    PAGES,
    PROBLEMS,
    RESULTS,
    SPEED,
    TIMES,
    choices,
    evidence,
    marks,
    renew,
    results,
    times,
    with_table,
)

ROOT = Path(__file__).parents[3]
README, TRUST, WHICH = (ROOT / name for name in ("README.md", "docs/trust.md", "docs/which.md"))


def table_of(page: str, name: str) -> str:
    """The text between the marks of a generated table."""
    begin, end = marks(name)
    return page.partition(begin)[2].partition(end)[0].strip()


def expected_rows():
    nothing = pd.DataFrame()
    rows = [row for claim in CLAIMS for row in claim.judge(nothing)]
    return {(row.id, row.quantity): row for row in rows}


@pytest.mark.slow(beside="test_a_headline_that_is_gone_is_named")
def test_every_headline_is_a_row_of_the_claims_and_has_its_verdict():
    rows = expected_rows()
    lines = table_of(TRUST.read_text(), RESULTS).splitlines()[2:]
    assert len(lines) == len(HEADLINES)
    for line, headline in zip(lines, HEADLINES, strict=True):
        claim, quantity, claimed, measured, verdict = (
            cell.strip() for cell in line.strip("|").split("|")
        )
        row = rows[headline]
        assert (claim, quantity, claimed) == (f"{row.id}, {row.source}", row.quantity, row.claimed)
        assert verdict.partition(",")[0] == row.expected
        assert measured


def test_a_headline_that_is_gone_is_named():
    with pytest.raises(KeyError, match="base of the one-step error"):
        results(pd.DataFrame({"id": ["V1"], "quantity": ["something else"]}))


def test_a_page_without_marks_is_refused():
    begin, _ = marks(RESULTS)
    with pytest.raises(ValueError, match=f"must hold the marks {begin}"):
        with_table("no marks", RESULTS, "a table")
    half = f"before {begin} old"
    with pytest.raises(ValueError, match="must hold the marks"):
        with_table(half, RESULTS, "a table")


def test_ratios_are_shown_with_what_was_not_reached_and_who_took_no_part():
    ratios = pd.DataFrame(
        {
            "problem": ["outer solar system"] * 3,
            "contender": ["REBOUND IAS15", "REBOUND IAS15, GLOBAL", "heyoka"],
            "error": [1e-4, 1e-4, 1e-4],
            "ratio": ["27.1", "37.2", "not reached"],
            "low": [25.2, float("nan"), float("nan")],
            "high": [28.3, float("nan"), float("nan")],
            "noise_low": 0.97, "noise_high": 1.04,
            "outcome": ["faster", "", ""],
        }
    )  # fmt: skip
    lines = times(ratios, *TIMES[SPEED]).splitlines()
    assert lines[2].startswith("| REBOUND IAS15 | 27 (25-28) | - |")
    assert lines[-1].startswith("| galvi against itself | 0.97-1.04 | - |")
    assert any(line.startswith("| heyoka | not reached | - |") for line in lines)
    blocks = table_of(README.read_text(), SPEED).split("\n\n")
    assert blocks[::2] and all(line.startswith("On ") for line in blocks[::2])
    assert all(len(block.splitlines()) == len(lines) for block in blocks[1::2])


def test_rigid_bodies_have_a_table_of_their_own():
    ratios = pd.DataFrame(
        {
            "problem": ["free rigid body"],
            "contender": ["MuJoCo RK4"],
            "error": [1e-4],
            "ratio": [1.04],
            "low": 0.9, "high": 1.2, "noise_low": 0.95, "noise_high": 1.05, "outcome": "tie",
        }
    )  # fmt: skip
    lines = times(ratios, *TIMES[BODIES]).splitlines()
    assert lines[2].startswith("| MuJoCo RK4 | - | tie, 1 (0.9-1.2) | - |")
    blocks = table_of(README.read_text(), BODIES).split("\n\n")
    assert blocks[::2] and all(line.startswith("On ") for line in blocks[::2])
    assert all(len(block.splitlines()) == len(lines) for block in blocks[1::2])


def test_the_page_counts_the_statements_of_the_papers(tmp_path):
    (tmp_path / "docs").mkdir()
    for page in PAGES:
        (tmp_path / page).write_text((ROOT / page).read_text())
    assert renew(tmp_path, tmp_path / "nothing") == []
    for page in PAGES:
        assert (tmp_path / page).read_text() == (ROOT / page).read_text()


def test_the_fastest_code_at_each_error_is_named_with_galvis_beside_it():
    runs = pd.DataFrame(
        {
            "problem": "kepler e=0.6",
            "quantity": "position",
            "contender": ["heyoka", "heyoka", "galvi degree 8", "galvi degree 8"],
            "settings": ["tolerance=1e-5", "tolerance=1e-9", "step=0.2", "step=0.1"],
            "error": [1e-5, 1e-9, 2e-5, 1e-7],
            "smallest": [1e-5, 1e-9, 2e-5, 1e-7],
            "largest": [1e-5, 1e-9, 2e-5, 1e-7],
            "seconds": [2.0, 4.0, 1.0, 8.0],
            "is_truth": False,
            "stops_early": False,
            "status": "",
        }
    )
    (line,) = choices(runs).splitlines()[2:]
    cells = [cell.strip() for cell in line.strip("|").split("|")]
    assert cells[0] == "Kepler, e = 0.6" and cells[1].startswith("**galvi degree 8, step=0.2")
    assert cells[2].startswith("heyoka, tolerance=1e-9") and "; galvi degree 8" in cells[2]
    assert cells[3].startswith("heyoka") and "galvi" not in cells[3]
    page = table_of(WHICH.read_text(), CHOICES).splitlines()
    assert len(page) == 2 + len(PROBLEMS) and page[0].count("error") == len(ASKED)


def test_the_evidence_is_counted(tmp_path):
    columns = {"id": ["V1", "V1", "L1"], "verdict": ["holds"] * 3, "expected": ["holds"] * 3}
    pd.DataFrame(columns).to_csv(tmp_path / "claims.csv")
    lines = evidence(tmp_path).splitlines()
    assert "| claims | 2, in 3 checks | `galvi verify` |" in lines
    assert len(lines) <= len(table_of(TRUST.read_text(), EVIDENCE).splitlines())


def test_the_pages_take_no_rows_of_the_quick_setting(tmp_path, capsys):
    note_origin(tmp_path, "work_precision.csv", {"date": "2026-01-02"}, quick=True)
    with pytest.raises(ValueError, match=r"work_precision.csv of the quick setting; run"):
        renew(ROOT, tmp_path)
    assert run(None, ["readme", "--out", str(tmp_path)]) == 2
    told = capsys.readouterr().err
    assert "of the quick setting; run build without --quick first." in told
    assert "could not be carried out" not in told
