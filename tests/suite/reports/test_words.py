"""Numbers and plain-text mathematics as people read them."""

from __future__ import annotations

import math
from dataclasses import replace

import pandas as pd
import pytest

from benchmarks.checks.claim import AGREEMENT
from benchmarks.claims.statements import Statement
from benchmarks.work_precision.fronts import ratios
from reports.results import summary as outcome
from reports.results.summary import Summary
from reports.site.claims import after, shared_parts
from reports.site.comparisons import absent_engines, installed_engines
from reports.site.typeset import typeset
from reports.tables.comparison_tables import fastest_lines, fastest_per_error
from reports.tables.number_format import plain, readable, seconds, with_uncertainty
from reports.tables.summary_sentences import summary_sentences


@pytest.mark.parametrize(
    ("number", "text"),
    [
        (0, "0"),
        (0.55342, "0.553"),
        (12.44, "12.4"),
        (-0.5, "\u22120.500"),
        (99999.0, "1.00·10⁵"),
        (3.14159e-10, "3.14·10⁻¹⁰"),
        (math.nan, ""),
        (math.inf, ""),
        (None, ""),
    ],
)
def test_a_number_has_three_digits_or_none(number, text):
    assert readable(number) == text


def test_uncertainty_sets_the_digits():
    assert with_uncertainty(0.553421, 0.00123) == "0.5534 ± 0.0012"
    assert with_uncertainty(5.0, 0.25) == "5.00 ± 0.25"
    assert with_uncertainty(1.5, 7.3e-6) == "1.5000000 ± 0.0000073"
    assert with_uncertainty(3.0, None) == "3.00"
    assert with_uncertainty(3.0, 0.0) == "3.00"
    assert with_uncertainty(1e-12, 2e-14) == "1.00·10⁻¹² ± 2.0·10⁻¹⁴"
    assert with_uncertainty(None, 0.1) == ""


def test_times_have_the_unit_that_fits():
    assert [seconds(t) for t in (2.0, 0.0123, 4.5e-6, math.nan)] == [
        "2.00\u202fs",
        "12.3\u202fms",
        "4.50\u202fµs",
        "",
    ]
    assert plain(1.23456e-7) == "1.23e-07"


@pytest.mark.parametrize(
    ("text", "html"),
    [
        ("O(0.56^n) or so", "O(0.56<sup>n</sup>) or so"),
        ("O(h^(n/2 + 2))", "O(h<sup>n/2\u00a0+\u00a02</sup>)"),
        ("N^-(3/2 - b)", "N<sup>\u2212(3/2\u00a0\u2212\u00a0b)</sup>"),
        ("h = 2^(-j/2), j", "h\u00a0=\u00a02<sup>\u2212j/2</sup>, j"),
        ("at most 1e-10", "at most 10<sup>\u221210</sup>"),
        ("2.5e-3 of it", "2.5·10<sup>\u22123</sup> of it"),
        ("0.56 -+ 0.005", "0.56\u00a0±\u00a00.005"),
        ("1e-3 <b>", "10<sup>\u22123</sup> &lt;b&gt;"),
        ("in W^{1,1} and L^infinity", "in W<sup>1,1</sup> and L<sup>\u221e</sup>"),
        ("on 2000-01-01", "on 2000-01-01"),
        ("order 2 (n - 1)", "order 2 (n\u00a0\u2212\u00a01)"),
        ("this - and that", "this - and that"),
    ],
)
def test_plain_mathematics_is_set(text, html):
    assert typeset(text) == html


def test_what_the_row_above_says_is_not_said_again():
    long = "a long explanation of what is to be seen in this row"
    assert after(long, long) == "as above" and after("", "") == ""
    assert after(f"{long}; n = 4", f"{long}; n = 3") == "as above; n = 4"
    assert after("short; n = 4", "short; n = 3") == "short; n = 4"


def test_what_all_rows_share_is_shared_parts():
    assert shared_parts(["a; b; n = 3", "a; b; n = 4"]) == ("a; b", ["n = 3", "n = 4"])
    assert shared_parts([]) == ("", [])


def matched(*times: tuple[str, float]) -> pd.DataFrame:
    return pd.DataFrame(
        [
            {
                "problem": "kepler",
                "contender": who,
                "error": 1e-6,
                "seconds": time,
                "ratio": (time or math.nan) / (times[0][1] or math.nan),
                "outcome": "",
            }
            for who, time in times
        ]
    )


@pytest.mark.parametrize(
    ("ours", "peer", "said"),
    [
        (1.0, 0.5, "Kepler: peer wins at 10⁻⁶ (2.0 times faster)."),
        (0.5, 1.0, "Kepler: galvi is fastest at 10⁻⁶."),
        (1.0, 1.05, "Kepler: galvi is within 10 % of peer at 10⁻⁶."),
        (1.05, 1.0, "Kepler: galvi is within 10 % of peer at 10⁻⁶."),
        (math.nan, 1.0, "Kepler: peer wins at 10⁻⁶ (not reached by galvi)."),
        (1.0, math.nan, "Kepler: galvi is fastest at 10⁻⁶."),
        (math.nan, math.nan, "Kepler: nobody reaches 10⁻⁶."),
    ],
)
def test_who_wins_is_said_from_the_times(ours, peer, said):
    table = matched(("galvi, best", ours), ("galvi degree 8", ours), ("peer", peer))
    assert summary_sentences(table) == [said]


def test_a_rival_that_was_run_far_too_accurately_is_said_beside_who_is_fastest():
    parts = [
        matched(("galvi, best", 1.0), ("peer", 9.0)).assign(error=10.0**-k, closer=closer)
        for k, closer in ((2, 5e3), (4, 50.0), (6, math.nan))
    ]
    assert summary_sentences(pd.concat(parts)) == [
        "Kepler: galvi is fastest from 0.01 to 10⁻⁴ (peer at its loosest is 50 to 5000 times as "
        "accurate as asked), at 10⁻⁶."
    ]


def test_consecutive_errors_with_one_outcome_are_a_range():
    times = ((1.0, 2.0), (1.6, 1.0), (1.7, 1.0), (3.0, 4.0), (3.0, 4.0), (2.0, 1.0), (None, 1.0))
    parts = [
        matched(("galvi, best", ours), ("peer", peer)).assign(error=10.0**-k)
        for k, (ours, peer) in enumerate(times, 4)
    ]
    nobody = [matched(("galvi, best", math.nan)).assign(error=10.0**-k) for k in (11, 12)]
    assert summary_sentences(pd.concat([*parts, *nobody])) == [
        "Kepler: peer wins from 10⁻⁵ to 10⁻⁶ (1.6 to 1.7 times faster), at 10⁻⁹ (2.0 times "
        "faster), at 10⁻¹⁰ (not reached by galvi); galvi is fastest at 10⁻⁴, from 10⁻⁷ to 10⁻⁸; "
        "nobody reaches 10⁻¹¹ to 10⁻¹²."
    ]


def choices(runs: pd.DataFrame, *errors: float) -> pd.DataFrame:
    return fastest_per_error(ratios(runs, errors), runs)


def test_an_error_that_the_truth_cannot_tell_is_a_bound(make_suite):
    runs = make_suite().work_precision(True, print).assign(truth_error=1e-10)
    table = choices(runs.assign(error=runs["error"].clip(1e-9)), 1e-8)
    assert list(fastest_lines(table)["its error"]) == ["1.0·10⁻⁹ (bound)"]


def test_a_setting_is_called_stopped_early_by_its_row_and_not_by_its_words(make_suite):
    runs = make_suite().work_precision(True, print)
    runs.loc[1, "settings"] = "tolerance=1e-9"
    for early, said in ((False, ""), (True, " (stopped early)")):
        table = choices(runs.assign(stops_early=early), 1e-8)
        assert list(fastest_lines(table)["setting"]) == [f"tolerance=1e-9{said}"]


def test_a_choice_is_a_run_that_was_made_and_reached_the_error(make_suite):
    runs = make_suite().work_precision(True, print)
    table = choices(runs, 1e-4, 1e-8, 1e-12)
    best = table[table["of"] == "all"]
    assert list(best["contender"]) == ["SciPy DOP853", "galvi degree 8, Gauss 8", "Taylor"]
    ours = table[table["of"] == "galvi"]
    assert list(ours["settings"]) == ["step=1", "step=1", ""]
    text = fastest_lines(table)
    assert list(text["its error"]) == ["1.0·10⁻⁵", "1.0·10⁻⁹", "1.0·10⁻⁹", "truth", ""]
    assert text["contender"].iloc[-1] == "not reached"


def test_claims_are_counted_apart_from_their_checks(make_row):
    rows = [
        make_row(),
        make_row(id="V2"),
        make_row(id="V2", verdict="contradicted", expected="contradicted"),
        *[make_row(id="V3", verdict="finding", expected="finding")] * 2,
        make_row(id="V4", verdict="not run", expected="not run"),
        make_row(id="V5", verdict="exceeds", expected="exceeds"),
        make_row(id="A1", source=AGREEMENT),
    ]
    seen = Summary(tuple(rows))
    assert "3 holds, 1 exceeded, 1 contradicted, 2 findings, 1 not run" in str(seen)


def test_an_engine_that_was_not_installed_is_named_with_what_is_missing(make_row):
    origin = {"scipy": "1", "heyoka": "not installed"}
    why = "Install heyoka."
    runs = pd.DataFrame({"contender": ["heyoka, chains", "peer"], "status": [why, "heyoka"]})
    targets = pd.DataFrame({"against": ["heyoka", "heyoka, chains", "peer"], "verdict": "not run"})
    rows = (
        make_row(id="A5", verdict="not run", reason=why, absent="heyoka"),
        make_row(id="V3", verdict="not run", reason="It broke, though heyoka was not asked."),
        make_row(),
    )
    (found,) = absent_engines(origin, runs, targets, rows)
    assert found.text.startswith(
        "heyoka was not installed for this build: its times, 2 targets and rows of A5 are missing"
    )
    assert found.reason == why and absent_engines({}, runs, targets, rows) == ()
    assert installed_engines(origin) == "REBOUND, MuJoCo and SciPy"
    assert installed_engines({}).endswith("SciPy and heyoka")


def test_orders_whose_stated_errors_are_too_small_are_no_success(make_row):
    """Planted: as many orders off by three of their stated errors as lie within two."""
    sound = [make_row(id=f"V{k}", measured=4.0 + k, misses=1.0) for k in range(10)]
    off = [make_row(id=f"V{k}", measured=4.0 + k, misses=3.0) for k in range(10, 20)]
    seen = Summary((*sound, *off[:1]))
    assert seen.passes()
    assert "The stated errors cover: of 11 fitted orders" in str(seen)
    seen = Summary((*sound, *off))
    assert not seen.passes() and not seen.differing
    assert (
        "The stated errors are too small: of 20 fitted orders whose true value is known, 10 miss it"
        in str(seen)
    )


def test_a_statement_that_its_rows_do_not_found_is_no_success(make_row, monkeypatch):
    """Only where every claim that statements name has rows, and all are as expected."""
    row = make_row(id="V1", source="H fig. 2.3")
    founded = Statement("H fig. 2.3", "figure", "It is so.", "reproduced", "", ("V1",), "", "")
    monkeypatch.setattr(outcome, "statements", lambda: (founded,))
    assert Summary((row,)).passes()
    elsewhere = replace(founded, where="H fig. 2.4")
    monkeypatch.setattr(outcome, "statements", lambda: (elsewhere,))
    assert not Summary((row,)).passes()
    assert (
        "1 printed statement unfounded: H fig. 2.4 (It is so.) is called reproduced; no row"
        in str(Summary((row,)))
    )
    monkeypatch.setattr(outcome, "statements", lambda: (replace(elsewhere, claims=("V2",)),))
    assert Summary((row,)).passes()
    monkeypatch.setattr(outcome, "statements", lambda: (elsewhere,))
    without_engine = replace(row, verdict="not run", expected="not run")
    assert Summary((row, without_engine)).passes()
    differing = replace(row, verdict="contradicted")
    assert Summary((*[row] * 99, differing)).passes(fail_under=90.0)
