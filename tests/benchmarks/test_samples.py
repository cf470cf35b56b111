"""When times count as slower: by rank and by size, corrected for how many are looked at."""

from __future__ import annotations

import math
import time
from dataclasses import asdict
from itertools import combinations
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import rankdata

from benchmarks.statistics.rank_test import (
    LEAST,
    LEVEL,
    holm,
    p_value,
    relative_growth,
    samples_needed,
    slower,
)
from benchmarks.timings import annotate, worker
from benchmarks.timings.catalogue import CASES


def times(factor: float, count: int = 12, spread: float = 0.02, seed: int = 0) -> list[float]:
    random = np.random.default_rng([seed, round(100 * factor)])
    return list(factor * (1.0 + spread * random.standard_normal(count)))


def test_the_chance_of_complete_separation_is_the_exact_one() -> None:
    base = [1.0 + k / 100 for k in range(10)]
    head = [2.0 + k / 100 for k in range(10)]
    assert p_value(base, head) == pytest.approx(1.0 / math.comb(20, 10), rel=1e-12)
    assert p_value(head, base) == pytest.approx(1.0, abs=1e-12)


def test_the_chance_is_exact_with_ties_too_and_never_far_above_what_holm_asks() -> None:
    base, head = [1.0, 1.1, 1.1, 1.2, 1.3, 1.3, 1.4, 1.5], [1.1, 1.3, 1.4, 1.4, 1.5, 1.6, 1.6, 1.7]
    ranks = rankdata(head + base)
    sums = [sum(some) for some in combinations(ranks, 8)]
    assert p_value(base, head) == np.mean(np.array(sums) >= sum(ranks[:8]))
    count = samples_needed(60)
    assert p_value([1.0] * count, [1.2] * count) < LEVEL / 60


def test_too_few_samples_and_equal_ones_decide_nothing() -> None:
    few = LEAST - 1
    assert p_value([1.0] * few, [2.0 + k for k in range(20)]) == 1.0
    assert p_value([1.0] * 10, [1.0] * 10) == 1.0


@pytest.mark.parametrize("wrong", [math.nan, math.inf, 0.0, -1.0])
def test_a_time_that_is_none_is_refused(wrong: float) -> None:
    with pytest.raises(ValueError, match="times of the head must be positive and finite"):
        p_value([1.0] * 8, [1.0] * 7 + [wrong])


@pytest.mark.parametrize("benchmarks", [1, 12, 40, 300])
def test_so_many_samples_are_enough_and_one_less_is_not(benchmarks: int) -> None:
    count = samples_needed(benchmarks)
    assert 1.0 / math.comb(2 * count, count) < LEVEL / benchmarks
    assert count >= LEAST
    if count > LEAST:
        assert 1.0 / math.comb(2 * count - 2, count - 1) > LEVEL / (20 * benchmarks)


def test_holm_asks_more_of_the_first_than_of_the_last() -> None:
    level = 0.05
    assert holm({"a": 0.016, "b": 0.024, "c": 0.049}, level) == {"a", "b", "c"}
    assert holm({"a": 0.017, "b": 0.001, "c": 0.9}, level) == {"a", "b"}
    assert holm({"a": 0.018, "b": 0.024, "c": 0.049}, level) == set()


def test_both_gates_are_needed() -> None:
    little = (times(1.0, 40, 0.01), times(1.05, 40, 0.01))
    assert p_value(*little) < LEVEL and relative_growth(*little) < 0.10
    noisy = ([0.5, 0.6, 0.7, 1.0, 1.5, 1.6, 1.7], [0.55, 0.65, 0.75, 1.4, 1.55, 1.65, 1.75])
    assert relative_growth(*noisy) > 0.10 and p_value(*noisy) > LEVEL
    much = (times(1.0), times(1.3))
    found = slower({"little": little, "noisy": noisy, "much": much}, dict.fromkeys(
        ("little", "noisy", "much"), 0.10))  # fmt: skip
    assert found == {"much"}


def test_a_faster_head_is_no_alarm() -> None:
    assert slower({"a": (times(1.3), times(1.0))}, {"a": 0.10}) == set()


def test_the_size_is_each_benchmark_s_own() -> None:
    pair = (times(1.0), times(1.3))
    assert slower({"a": pair, "b": pair}, {"a": 0.10, "b": 0.50}) == {"a"}


def test_equal_samples_pass_holm_as_rarely_as_stated() -> None:
    """Of 50 comparisons of 12 equal benchmarks each, the level 0.002 allows 0.1; none was red."""
    draws = 1.0 + 0.02 * np.random.default_rng(20).standard_normal((50, 12, 2, 10))
    chances = ({str(k): p_value(*pair) for k, pair in enumerate(one)} for one in draws)
    assert sum(bool(holm(one, LEVEL)) for one in chances) <= 1


def test_a_sample_is_the_mean_of_the_quickest_attempt(monkeypatch: pytest.MonkeyPatch) -> None:
    now = [0.0]
    seconds = iter([20.0, 1.0, 3.0, 5.0, 9.0, 1.0])

    def call() -> None:
        now[0] += next(seconds)

    clock = SimpleNamespace(process_time=lambda: now[0], perf_counter=lambda: 3.0 * now[0])
    monkeypatch.setattr(worker, "time", clock)
    assert worker.sample(call, 2, 3) == {"processor": 4.0, "wall": 12.0}


def test_calls_are_repeated_no_more_where_processor_time_stands_still(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """As it does for milliseconds under `ulimit -t`."""
    clock = SimpleNamespace(process_time=lambda: 0.0, perf_counter=iter(range(99)).__next__)
    monkeypatch.setattr(worker, "time", clock)
    monkeypatch.setattr(worker, "prepared", lambda case: list)
    monkeypatch.setattr(worker, "described", lambda runs: {})
    assert worker.run(asdict(CASES[0]), {})["warm"] == 1

    asked: list[int] = []
    benchmark = SimpleNamespace(
        extra_info={}, pedantic=lambda call, rounds, iterations: asked.append(iterations)
    )
    monkeypatch.setattr(annotate, "TIMER", lambda: 0.0)
    annotate.timed(benchmark, lambda: time.sleep(0.02))
    assert asked == [1]
