"""The ledger of the papers' statements agrees with the rows, and orders' stated errors cover."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.checks.bounds import EXCEEDS, HOLDS, NOT_REPRODUCED
from benchmarks.checks.claim import Row
from benchmarks.checks.coverage import coverage
from benchmarks.claims import CLAIMS
from benchmarks.claims.statements import (
    EFFECTS,
    FALSE,
    STATUSES,
    Statement,
    counted,
    places,
    statements,
    unfounded,
)
from benchmarks.statistics import convergence_fits
from tests.benchmarks.quick_studies import quick

SECTIONS = {
    "M fig. 1": "M 6.1, fig. 1",
    "M fig. 2": "M 6.2, fig. 2",
    "M fig. 3": "M 6.2, fig. 3",
}


@pytest.fixture(scope="module")
def rows() -> list[Row]:
    """Of all claims, quick."""
    return [row for claim in CLAIMS for row in claim.judge(quick(claim))]


def test_every_status_is_what_the_rows_say_and_every_accusation_has_its_statement(
    rows: list[Row],
) -> None:
    assert unfounded(statements(), rows) == []


def test_lines_are_complete() -> None:
    ids = {claim.id for claim in CLAIMS}
    seen = set()
    for one in statements():
        assert one.status in STATUSES and one.where[:2] in ("H ", "M ")
        assert (one.effect in EFFECTS) == (one.status == FALSE)
        assert set(one.claims) <= ids and 0 < len(one.statement) <= 200
        assert one.status in ("reproduced", "future work done") or one.why
        assert (one.where, one.statement) not in seen
        seen.add((one.where, one.statement))
    assert {one.where[0] for one in statements()} == {"H", "M"}


def test_every_figure_of_a_claim_is_a_statement() -> None:
    told = {one.where for one in statements()}
    for claim in CLAIMS:
        for figure in claim.figures:
            if figure[2:5] == "fig":
                name = SECTIONS.get(figure[:8], figure)
                assert any(one.startswith(name) for one in told), figure


def test_a_status_that_no_row_supports_and_a_verdict_that_praises_are_told(
    rows: list[Row],
) -> None:
    """Planted: a figure that is not reproduced is called so; and its rows exceed it."""
    found = statements()
    wrong = [
        replace(one, status="reproduced", why="")
        if one.status == NOT_REPRODUCED and "L3" in one.claims
        else one
        for one in found
    ]
    assert any("L3 has a row that is not reproduced" in one for one in unfounded(wrong, rows))
    praised = [
        replace(row, verdict=EXCEEDS) if row.verdict == NOT_REPRODUCED else row for row in rows
    ]
    said = unfounded(found, praised)
    assert any(one.startswith("H fig. 2.9 ") for one in said)
    assert any("H fig. 2.9 exceeds what was measured" in one for one in said)


def test_a_row_founds_only_the_statements_of_its_place() -> None:
    """Planted: one row that holds, and statements of other places that name its claim."""
    row = Row("V1", "one-step error", "H fig. 2.3, thm. 2.3.4", verdict=HOLDS)
    wheres = ("H fig. 2.3", "H thm. 2.3.4", "H fig. 2.4", "H fig. 2.30", "H 2.3", "M fig. 2.3")
    first, second, *others = (
        Statement(where, "figure", "It is so.", "reproduced", "", ("V1",), "", "")
        for where in wheres
    )
    said = unfounded([first, second, *others], [row])
    assert len(said) == len(others)
    assert not any(one.startswith(("H fig. 2.3 ", "H thm. 2.3.4 ")) for one in said)
    here = replace(others[0], rows="H fig. 2.3: one-step")
    elsewhere = replace(here, rows="H fig. 2.3: curve")
    other_claim = replace(here, claims=("V2",))
    assert unfounded([here], [row]) == []
    assert all(len(unfounded([one], [row])) == 1 for one in (elsewhere, other_claim))


@pytest.mark.parametrize(
    ("source", "found"),
    [
        ("H thm. 2.1.1, 3.1.1, M thm. 4", ["H thm. 2.1.1", "H thm. 3.1.1", "M thm. 4"]),
        ("H fig. 2.11, sec. 2.4", ["H fig. 2.11"]),
        ("M (12), section 5", ["M (12)"]),
        ("M sec. 5, thm. 3", ["M thm. 3"]),
        ("H (3.9), H 3.4.3", ["H (3.9)"]),
        ("H 3.2.2, 3.4.3", ["H 3.2.2", "H 3.4.3"]),
        ("M sec. 5", ["M sec. 5"]),
    ],
)
def test_the_places_of_a_source_are_read(source: str, found: list[str]) -> None:
    assert places(source) == found


def test_every_statement_names_rows_that_there_are(rows: list[Row]) -> None:
    for one in statements():
        for name in one.rows.split("; ") if one.rows else ():
            assert any(replace(one, rows=name).speaks_of(row) for row in rows), (one.where, name)


def test_statements_are_counted_in_words() -> None:
    one = Statement("H fig. 1", "figure", "It is so.", "reproduced", "", (), "", "")
    slip = replace(one, status=FALSE, effect="harmless")
    said = counted([one, one, slip])
    assert said.startswith("Of 3 printed statements of the two papers, 2 are reproduced, ")
    assert "1 is false as printed (1 of them harmless misprints)" in said


def test_the_stated_errors_of_the_suites_orders_cover(rows: list[Row]) -> None:
    found = coverage(rows)
    assert found.orders > 150 and found.sound, str(found)
    small = [replace(row, misses=5.0 * row.misses) if row.misses else row for row in rows]
    assert not coverage(small).sound  # planted: errors a fifth of what they are


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 10**6))
def test_the_stated_errors_cover_orders_that_have_not_settled(seed: int) -> None:
    """C h^p (1 + a h + b h^2) with scatter: at most a fifth of a hundred orders are missed."""
    random, missed = np.random.default_rng(seed), 0
    h = 2.0 ** (-np.arange(2, 14) / 2)
    for _ in range(100):
        p, a, b = random.integers(1, 9), random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0)
        scatter = np.exp(0.02 * random.standard_normal(h.size))
        errors = 0.1 * h**p * (1.0 + 0.5 * a * h + 0.5 * b * h**2) * scatter
        fit = convergence_fits.algebraic(h, errors, floor=1e-15)
        missed += abs(fit.rate - p) > 2.0 * fit.uncertainty
    assert missed <= 20
