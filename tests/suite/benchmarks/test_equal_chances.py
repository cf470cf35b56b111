"""Ratios have intervals that cover, and codes have settings without gaps."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pandas as pd
import pytest

from benchmarks.statistics import paired
from benchmarks.statistics.paired import FASTER, SLOWER, TIE, Interval, interval, outcome, ratio
from benchmarks.work_precision.asked import code_of
from benchmarks.work_precision.grid import (
    MAX_ADDED,
    add_settings,
    fineness_of,
    gaps,
    line_of,
    wide_gaps,
)
from benchmarks.work_precision.participants import with_externals
from benchmarks.work_precision.peers import PEERS
from benchmarks.work_precision.problem import Setting
from benchmarks.work_precision.problems import work_precision_problems

ROUNDS, JOBS = 7, 600


def scattered(seed: int, rounds: int = ROUNDS) -> np.ndarray:
    """Times of equal calls as a busy machine has them: mostly equal, at times far above."""
    draw = np.random.default_rng(seed)
    return 1.0 + 0.01 * draw.standard_exponential(rounds) * draw.choice([1.0, 20.0], rounds)


def fraction_told_apart(width_factor: float = 1.0) -> float:
    """Fraction of JOBS pairs of equal calls that are called faster or slower, by intervals whose
    distances from the median are multiplied by `width_factor`."""

    def band(a: Any, b: Any) -> Interval:
        low, middle, high = ratio(list(a), list(b))
        return Interval(
            middle - width_factor * (middle - low), middle, middle + width_factor * (high - middle)
        )

    wrong = 0
    for job in range(JOBS):
        left, repeated, right = (scattered(3 * job + k) for k in range(3))
        wrong += outcome(band(right, left), band(repeated, left)) != TIE
    return wrong / JOBS


def test_equal_calls_tie_and_a_noise_band_that_is_too_small_is_seen() -> None:
    assert fraction_told_apart() < 0.02  # 0 of 600 when this was written
    assert fraction_told_apart(width_factor=0.1) > 0.1  # 0.16


@pytest.mark.parametrize("n", [6, 7, 9, 15, 40])
def test_the_interval_covers_the_median_as_often_as_it_says_and_no_narrower_one_does(
    n: int,
) -> None:
    rank = paired._rank(n)
    coverages = [
        1.0 - 2.0 * sum(math.comb(n, j) for j in range(k)) * 0.5**n for k in (rank, rank + 1)
    ]
    assert coverages[0] >= paired.COVERAGE > coverages[1]
    values = np.random.default_rng(n).standard_exponential((4000, n))
    intervals = [interval(list(row)) for row in values]
    covered_fraction = np.mean([band.low <= math.log(2.0) <= band.high for band in intervals])
    assert covered_fraction == pytest.approx(coverages[0], abs=0.02)


def test_few_rounds_have_a_median_and_no_interval() -> None:
    short = interval([3.0, 1.0, 2.0])
    assert short.median == 2.0 and math.isnan(short.low) and outcome(short, short) == ""
    assert math.isnan(interval([]).median)
    with pytest.raises(ValueError, match="zip"):
        ratio([1.0], [1.0, 2.0])


def test_a_ratio_decides_only_outside_the_noise() -> None:
    noise = Interval(0.95, 1.0, 1.1)
    assert outcome(Interval(1.2, 1.3, 1.4), noise) == FASTER
    assert outcome(Interval(0.7, 0.8, 0.9), noise) == SLOWER
    for tie in ((1.05, 1.2, 1.3), (0.8, 0.9, 0.96), (0.99, 1.2, 1.4)):
        assert outcome(Interval(*tie), noise) == TIE
    assert outcome(Interval(1.02, 1.05, 1.08), Interval(0.9, 0.95, 0.98)) == FASTER


def rows(*runs: tuple[str, float, float, float]) -> pd.DataFrame:
    """Runs: contender, step, error, seconds."""
    table = pd.DataFrame(runs, columns=["contender", "step", "error", "seconds"])
    settings = [f"step={step:.5g}" for step in table["step"]]
    return table.assign(problem="p", status="", settings=settings)


@pytest.mark.parametrize("order", [1, 16])
def test_an_unequal_grid_is_seen_and_filled(order: int) -> None:
    """A code at two settings, between which its errors fall by eight decades."""
    settings = [
        ("peer", {"step": 1000.0 * error ** (1.0 / order), "save_every": 1})
        for error in (1e-2, 1e-10)
    ]

    def table() -> pd.DataFrame:
        steps = [(code, setting["step"]) for code, setting in settings]
        return rows(*((code, h, (h / 1000.0) ** order, 1e-9 / h) for code, h in steps))

    (message,) = wide_gaps(table())
    assert message.startswith("peer has no setting in 8.0 decades")
    by_number = dict(enumerate(settings))

    def add(code: str, setting: Setting) -> None:
        by_number[len(settings)] = (code, setting)
        settings.append((code, setting))

    add_settings(table, by_number, 1e12, add)
    assert not wide_gaps(table()) and len(settings) <= MAX_ADDED + 2
    assert gaps(table())["gap"].item() <= 0.61  # at an end the step ratio is sqrt 2
    assert all(
        1e12 / setting["step"] == pytest.approx(setting["save_every"])
        for _, setting in settings[2:]
    )


def test_a_setting_that_was_run_but_is_slower_closes_a_gap_of_its_own_line_only() -> None:
    for line, gap in (("heyoka", 2.0), ("heyoka, chains", 4.0)):
        table = rows(
            ("heyoka", 0.4, 1e-3, 2.5), (line, 0.2, 1e-5, 90.0), ("heyoka", 0.1, 1e-7, 9.0)
        )
        assert gaps(table)["gap"].item() == pytest.approx(gap)


def test_a_code_that_cannot_be_loose_is_told() -> None:
    table = rows(("IAS15", 0.4, 1.6e-11, 2.5), ("IAS15", 0.2, 4e-12, 5.0))
    assert wide_gaps(table) == ["IAS15 has no setting in 8.8 decades above 2e-11."]


def test_the_step_says_how_fine_a_setting_is_before_its_tolerance() -> None:
    assert fineness_of({"tolerance": 1e-9, "step": 0.1, "save_every": 3}) == ("step", 0.1)
    assert fineness_of({"samples": 1, "epsilon": 1e-5})[0] == "epsilon"
    assert line_of({"step": 0.1, "save_every": 3, "kernel": "LAZY"}) == (("kernel", "LAZY"),)


def test_every_peer_of_a_problem_has_its_documented_options_on_one_page() -> None:
    codes = {
        code_of(participant.label)
        for case in work_precision_problems(False)
        for participant in case.participants
    }
    own_codes = {"galvi", "Stormer-Verlet", "symplectic Euler"}
    documented = (*PEERS, "RK4 on quaternions", "DOP853 on quaternions", "MuJoCo", "SciPy")
    assert not {code for code in codes - own_codes if not code.startswith(documented)}
    for name, peer in PEERS.items():
        assert peer.open and peer.built and peer.source, name


def test_a_contender_without_a_step_is_asked_for_its_last_state() -> None:
    """As the documentation of --contender says: without ``step`` a setting has ``samples``."""

    class Adaptive:
        name = "adaptive"

        def supports(self, problem: object) -> bool:
            return True

        def settings(self, problem: object, duration: float, fewest: int) -> list[dict[str, float]]:
            return [{"tolerance": 1e-6}, {"step": 0.1, "save_every": 10}]

    case = next(iter(work_precision_problems(quick=True)))
    (*_, participant) = with_externals(case, [Adaptive()]).participants
    assert participant.settings == [
        {"samples": 1, "tolerance": 1e-6},
        {"step": 0.1, "save_every": 10},
    ]
