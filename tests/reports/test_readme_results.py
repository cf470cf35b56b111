"""The README's results table says what the claims' judges expect."""

from pathlib import Path

import pandas as pd
import pytest

from benchmarks.claims import CLAIMS
from reports.tables.readme import (
    BODIES,
    HEADLINES,
    RESULTS,
    SPEED,
    bodies,
    marks,
    results,
    speed,
    table_of,
    with_statements,
)

README = Path(__file__).parents[2] / "README.md"


def expected_rows():
    nothing = pd.DataFrame()
    rows = [row for claim in CLAIMS for row in claim.judge(nothing)]
    return {(row.id, row.quantity): row for row in rows}


def test_every_headline_is_a_row_of_the_claims_and_has_its_verdict():
    rows = expected_rows()
    lines = table_of(README.read_text(), RESULTS).splitlines()[2:]
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
    with pytest.raises(KeyError, match=r"claims\.csv has no row V3, base of the one-step error"):
        results(pd.DataFrame({"id": ["V1"], "quantity": ["something else"]}))


def test_a_page_without_marks_is_refused():
    begin, _ = marks(RESULTS)
    with pytest.raises(ValueError, match=f"must hold the marks {begin}"):
        table_of("no marks", RESULTS)


def test_ratios_are_shown_with_what_was_not_reached_and_who_took_no_part():
    ratios = pd.DataFrame(
        {
            "problem": ["outer solar system"] * 3,
            "contender": ["REBOUND IAS15", "REBOUND IAS15, GLOBAL", "heyoka"],
            "error": [1e-4, 1e-4, 1e-4],
            "ratio": ["27.1", "37.2", "not reached"],
        }
    )
    lines = speed(ratios).splitlines()
    assert lines[2].startswith("| REBOUND IAS15 | 27 | - |")
    assert any(line.startswith("| heyoka | not reached | - |") for line in lines)
    assert len(table_of(README.read_text(), SPEED).splitlines()) == len(lines)


def test_rigid_bodies_have_a_table_of_their_own():
    ratios = pd.DataFrame(
        {
            "problem": ["free rigid body"],
            "contender": ["MuJoCo RK4"],
            "error": [1e-8],
            "ratio": ["123.4"],
        }
    )
    lines = bodies(ratios).splitlines()
    assert lines[2].startswith("| MuJoCo RK4 | - | 120 | - |")
    assert len(table_of(README.read_text(), BODIES).splitlines()) == len(lines)


def test_the_page_counts_the_statements_of_the_papers():
    page = README.read_text()
    assert with_statements(page) == page
    with pytest.raises(ValueError, match="must hold the marks <!-- statements"):
        with_statements("no marks")
