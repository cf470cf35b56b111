"""Equal code is not called slower: a thousand comparisons drawn from recorded samples.

`equal_code.csv` has the samples of `track --against` of a commit with itself, in A B B A, on an
Intel Xeon at work with something else: seconds of both sides, 14 benchmarks.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from benchmarks.statistics.rank_test import slower
from benchmarks.statistics.smallest_change import smallest_change
from benchmarks.timings.catalogue import CASES
from reports.tracking.outcome import KnownChange, known_changes, reason_of

RECORDED = pd.read_csv(Path(__file__).with_name("equal_code.csv"))
SIZES = {case.name: case.slower for case in CASES}
COMPARISONS = 1000


def samples(random: np.random.Generator) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Two sides of each benchmark, drawn from all samples of it, whichever side they are of."""
    drawn = {}
    for name, rows in RECORDED.groupby("benchmark", sort=False):
        count = int((rows["side"] == "base").sum())
        drawn[str(name)] = tuple(random.choice(rows["seconds"].to_numpy(), (2, count)))
    return drawn


@pytest.mark.slow
def test_a_thousand_comparisons_of_equal_code_raise_no_alarm():
    """As in `track`: slower in a first round, and again in a second one."""
    random, alarms, looked = np.random.Generator(np.random.Philox(7)), 0, 0
    for _ in range(COMPARISONS):
        first = slower(samples(random), SIZES)
        looked += len(first)
        alarms += bool(first and first & slower(samples(random), SIZES))
    print(f"{COMPARISONS} comparisons of equal code: {alarms} alarms, {looked} suspects in round 1")
    assert alarms == 0
    assert looked <= 4  # the level is 0.002 a comparison; 0 when this was written


def test_code_that_is_slower_is_seen_in_the_same_samples():
    random = np.random.Generator(np.random.Philox(8))
    for name in SIZES.keys() & set(RECORDED["benchmark"]):
        drawn = samples(random)
        base, head = drawn[name]
        assert name in slower({**drawn, name: (base, 2.0 * head)}, SIZES)


def test_the_smallest_visible_change_grows_with_the_scatter_and_is_above_the_gate():
    random = np.random.Generator(np.random.Philox(9))
    quiet, loud = (1.0 + scatter * random.random((2, 14)) for scatter in (1e-3, 0.2))
    one, other = (smallest_change(*sides, 0.10, 17) for sides in (quiet, loud))
    assert 0.10 < one <= 0.12 < other
    assert smallest_change(*quiet, 0.0, 17) <= 0.02


def test_a_known_change_needs_a_reason_and_explains_its_commit_alone(tmp_path):
    assert all(one.reason for one in known_changes())
    known = (KnownChange("Kepler", "iterations", "0123456", "the guess was changed"),)
    why = "the guess was changed"
    assert reason_of(known, "Kepler, degree 8", "iterations", "0123456789ab") == why
    for benchmark, quantity, commit in (
        ("heavy top", "iterations", "0123456789ab"),
        ("Kepler, degree 8", "error", "0123456789ab"),
        ("Kepler, degree 8", "iterations", "1123456789ab"),
    ):
        assert reason_of(known, benchmark, quantity, commit) == ""
    file = tmp_path / "known.csv"
    for row in ("Kepler,error,0123456,", "Kepler,error,0123,because"):
        file.write_text(f"benchmark,quantity,commit,reason\n{row}\n")
        with pytest.raises(ValueError, match="a change needs a reason"):
            known_changes(file)
