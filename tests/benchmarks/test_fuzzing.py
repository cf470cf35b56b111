"""Calls at random: the judge of a call sees each planted fault, and galvi's own refusals pass."""

from __future__ import annotations

import os
import time
import warnings
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

import galvi
from benchmarks.applications.fuzzing import targets, trials
from benchmarks.applications.fuzzing.judgement import judged
from benchmarks.applications.fuzzing.study import FEWER
from reports.studies.faults import fuzz_table

METHOD = galvi.Galerkin(galvi.Polynomials(2), galvi.gauss(2))


@pytest.fixture(scope="module")
def run():
    return galvi.integrate(galvi.problems.kepler(0.3), METHOD, 0.1, 5)


def raising(error):
    def call():
        raise error

    return call


def test_what_galvi_refuses_in_a_sentence_is_refused_and_what_it_computes_returned(run):
    assert judged(lambda: galvi.gauss(-1)) == "refused"
    assert judged(lambda: galvi.integrate(None, METHOD, 0.1, 5)) == "refused"
    assert judged(lambda: galvi.gauss(np.eye(3))) == "refused"  # and not shown over three lines
    assert judged(lambda: run) == judged(lambda: galvi.energy(run)) == "returned"


FAULTS = {
    "somebody else's error": (raising(ValueError("not galvi's.")), "ValueError outside galvi"),
    "an error below galvi": (lambda: galvi.Rn(2).hat, "AttributeError outside galvi"),
    "a warning": (
        lambda: warnings.warn("overflow", RuntimeWarning, stacklevel=1),
        "RuntimeWarning",
    ),
    "nan": (lambda: np.array([1.0, np.nan]), "nan in the result"),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_planted_fault_of_a_call_is_seen(fault):
    call, text = FAULTS[fault]
    assert judged(call).startswith(text)


def test_a_planted_fault_of_a_run_is_seen(run):
    changed = np.array(run.q)
    changed[-1] = np.nan
    assert "not finite, and called good" in judged(lambda: replace(run, q=changed))
    changed[-1] = 2.0 * run.q[-1]
    assert "energy from" in judged(lambda: replace(run, q=changed))
    assert "no sentence" in judged(lambda: replace(run, status="ok"))
    assert "no failed step" in judged(lambda: replace(run, success=False))
    stopped = replace(run, q=np.full_like(changed, np.nan), success=False)
    for one, end in ((run, "nan in the result"), (stopped, "returned")):
        assert judged(partial(lambda run: np.array([np.nan]), run=one)) == end


def found(monkeypatch, target, **options):
    """What the trials say of a target in this process or one like it."""
    monkeypatch.setitem(targets.TARGETS, "planted", target)
    return trials._calls("planted", 20, 1, options["folder"] / "last")


def test_calls_are_counted_and_a_file_left_behind_is_a_finding(monkeypatch, tmp_path):
    def target(data):
        from hypothesis import strategies as st

        n = data.draw(st.integers(0, 3))
        return lambda: galvi.gauss(n) if n else (open("left", "w").close(), galvi.gauss(0)), str(n)

    monkeypatch.chdir(tmp_path)
    seen = found(monkeypatch, target, folder=tmp_path)
    assert seen.calls == seen.returned + seen.refused and min(seen.returned, seen.refused) > 0
    assert list(seen.findings) == ["a file was written: left"]


@pytest.mark.slow_cases("hang")
@pytest.mark.parametrize("hangs", [True, False], ids=["hang", "crash"])
def test_a_hang_and_a_crash_are_findings_with_the_last_call(monkeypatch, hangs):
    monkeypatch.setattr(trials, "_calls", Ending(hangs))
    (finding,) = trials.tried("planted", 1, 1, patience=8.0).findings.items()
    assert finding == ("no answer in 8 s" if hangs else "the process ended (3)", "the last call")


class Ending:
    """In place of the calls of a target: a hang or a crash."""

    def __init__(self, hangs):
        self.hangs = hangs

    def __call__(self, name, calls, seed, last):
        last.write_text("the last call")
        time.sleep(60) if self.hangs else os._exit(3)


def test_every_target_draws_calls_that_are_text():
    from hypothesis import HealthCheck, given, settings
    from hypothesis import strategies as st

    @settings(max_examples=1, database=None, suppress_health_check=list(HealthCheck))
    @given(st.data())
    def each(data):
        for target in targets.TARGETS.values():
            call, text = target(data)
            assert callable(call) and isinstance(text, str)

    each()


def test_no_call_asks_for_more_steps_than_it_can_take_in_seconds():
    long = [10**6, 2**40, 1e9, np.uint64(10**9), targets.LARGEST]
    short = [3, 0, -1, 0.5, True, float("nan"), float("inf"), 2**70, np.int8(-128), "x", None]
    assert all(map(targets._is_long, long)) and not any(map(targets._is_long, short))


def test_targets_that_are_called_less_are_targets():
    assert FEWER.keys() <= targets.TARGETS.keys()


def test_the_table_counts_and_shows_what_was_found():
    import pandas as pd

    row = {"target": "gauss", "seed": 1, "commit": "a", "date": "", "finding": "", "example": ""}
    rows = [row | {"calls": 9, "returned": 5, "refused": 3}]
    rows += [row | {"calls": 0, "returned": 0, "refused": 0, "finding": "crash", "example": "g(1)"}]
    table, _ = fuzz_table(pd.DataFrame(rows))
    assert table.iloc[0].tolist() == ["gauss", "9", "5", "3", "1"]
    assert table.iloc[-1]["target"] == "gauss: crash: g(1)"
