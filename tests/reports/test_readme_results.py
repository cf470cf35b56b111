"""The README's results table says what the claims' judges expect."""

from pathlib import Path

import pandas as pd
import pytest

from benchmarks.claims import CLAIMS
from reports.readme import BEGIN, HEADLINES, results, table_of

README = Path(__file__).parents[2] / "README.md"


def expected_rows():
    nothing = pd.DataFrame()
    rows = [row for claim in CLAIMS for row in claim.judge(nothing)]
    return {(row.id, row.quantity): row for row in rows}


def test_every_headline_is_a_row_of_the_claims_and_has_its_verdict():
    rows = expected_rows()
    lines = table_of(README.read_text()).splitlines()[2:]
    assert len(lines) == len(HEADLINES)
    for line, headline in zip(lines, HEADLINES, strict=True):
        claim, quantity, claimed, measured, verdict = (
            cell.strip() for cell in line.strip("|").split("|")
        )
        row = rows[headline]
        assert (claim, quantity, claimed) == (f"{row.id}, {row.source}", row.quantity, row.claimed)
        assert verdict == row.expected
        assert measured


def test_a_headline_that_is_gone_is_named():
    with pytest.raises(KeyError, match=r"claims\.csv has no row V1, smallest curve error"):
        results(pd.DataFrame({"id": ["V1"], "quantity": ["something else"]}))


def test_a_page_without_marks_is_refused():
    with pytest.raises(ValueError, match=f"must hold the marks {BEGIN}"):
        table_of("no marks")
