"""The study of round-off: energy errors are exact, a drift is caught, and no row is lost."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path

import mpmath
import numpy as np
import pandas as pd
import pytest

import galvi
from benchmarks.checks.faults import faulty
from benchmarks.measures.independent_invariants import exactly, relative_energy_error
from benchmarks.studies import round_off
from benchmarks.studies.round_off import gauss
from benchmarks.studies.round_off_participants import (
    SAMPLED_HUNDREDTHS,
    GalerkinParticipant,
    Sample,
)
from references.closed_forms.double_double import DoubleDouble


def test_the_energy_of_a_state_with_what_its_rounding_lost_is_exact() -> None:
    problem, rng = galvi.problems.outer_solar_system(), np.random.default_rng(6)
    state = [x * (1.0 + 1e-12 * rng.standard_normal(x.shape)) for x in (problem.q0, problem.v0)]
    low = [1e-17 * x * rng.standard_normal(x.shape) for x in state]
    error = relative_energy_error(problem, *map(DoubleDouble, state, low))
    exact = np.vectorize(mpmath.mpf, otypes=[object])
    m, (i, j) = exact(problem.system.masses), np.triu_indices(problem.system.masses.size, 1)

    def energy(q: np.ndarray, v: np.ndarray) -> mpmath.mpf:
        gaps = [mpmath.norm(gap) for gap in q[i] - q[j]]
        return np.sum(m * np.sum(v * v, axis=-1)) / 2 - np.sum(m[i] * m[j] / gaps)

    with mpmath.workdps(50):
        start = energy(exact(problem.q0), exact(problem.v0))
        end = energy(
            *(exact(x) + exact(remainder) for x, remainder in zip(state, low, strict=True))
        )
        truth = (end - start) / abs(start)
    assert float(error) == pytest.approx(float(truth), rel=1e-13, abs=1e-28)
    assert abs(float(relative_energy_error(problem, exactly(problem.q0), exactly(problem.v0)))) == 0


def test_the_runs_differ_by_1e_12_and_each_is_always_the_same() -> None:
    problem = galvi.problems.outer_solar_system()
    first, repeated, second = round_off.member(0), round_off.member(0), round_off.member(1)
    assert np.array_equal(first.q0, repeated.q0) and not np.array_equal(first.q0, second.q0)
    for x, y in ((first.q0, problem.q0), (first.v0, problem.v0)):
        assert 1e-13 < np.abs(x / y - 1.0).max() < 5e-12


@pytest.mark.slow(beside="test_drift.py::test_a_drift_below_the_walk_s_own_size_is_caught")
def test_a_method_whose_end_weights_are_off_by_1e_15_is_caught_as_a_drift() -> None:
    correct = gauss(8, 10)
    method = faulty(beta=1.0 + 1e-15)(correct.method.space, correct.method.rule)
    participants = (correct, GalerkinParticipant(method, 10))
    right, wrong = (
        round_off.growths(round_off.brouwer(True, participants=[participant]))[0][1]
        for participant in participants
    )
    assert wrong.drifts and abs(wrong.exponent - 1.0) < 0.1
    assert not right.drifts
    assert abs(wrong.drift) > 20.0 * abs(right.drift)


class Stop(Exception):
    """The study is killed."""


def study(folder: Path, messages: list[str], stop: int | None = None) -> pd.DataFrame:
    """Rows of a run of one method over 200 years; killed at sample number `stop`."""
    samples = 0

    def report(sentence: str) -> None:
        nonlocal samples
        messages.append(sentence)
        samples += sentence.endswith("years")
        if stop is not None and samples == stop:
            raise Stop

    for part in round_off.parts(folder, report, 200.0, 1, (gauss(6, 10),), code="0123456789ab"):
        if not part.is_complete():
            part.run(report)
    table = round_off.stored(folder, print).drop(columns="date")
    return table.sort_values("sample", ignore_index=True)


@pytest.fixture(scope="module")
def uninterrupted(tmp_path_factory: pytest.TempPathFactory) -> pd.DataFrame:
    return study(tmp_path_factory.mktemp("whole"), [])


def test_a_study_that_is_killed_goes_on_without_a_row_lost_or_doubled(
    tmp_path: Path, uninterrupted: pd.DataFrame
) -> None:
    assert (
        len(uninterrupted) == len(SAMPLED_HUNDREDTHS) and uninterrupted["error"].abs().max() < 1e-8
    )
    for stop in (len(SAMPLED_HUNDREDTHS) - 3, 2):
        with pytest.raises(Stop):
            study(tmp_path, [], stop)
    assert study(tmp_path, []).equals(uninterrupted)
    assert not list(tmp_path.rglob("*.npz"))
    messages: list[str] = []
    study(tmp_path, messages)
    assert messages == []


def test_a_damaged_or_foreign_run_is_set_aside_and_the_study_starts_it_anew(
    tmp_path: Path, uninterrupted: pd.DataFrame
) -> None:
    foreign = galvi.integrate(round_off.member(0), gauss(4, 10).method, 1.0, 3)
    for spoil in (lambda path: path.write_bytes(b"no run"), partial(galvi.save, foreign)):
        with pytest.raises(Stop):
            study(tmp_path, [], 5)
        (saved,) = tmp_path.rglob("*.npz")
        spoil(saved)
        messages: list[str] = []
        assert study(tmp_path, messages).equals(uninterrupted)
        assert any("anew" in sentence for sentence in messages)
        for path in tmp_path.rglob("*.csv"):
            path.unlink()


def test_rows_of_another_version_stay_and_say_of_which(tmp_path: Path) -> None:
    for code in ("aaaaaaaaaaaa", "bbbbbbbbbbbb"):
        for part in round_off.parts(tmp_path, print, 20.0, 1, (gauss(4, 20),), code=code):
            part.run(lambda sentence: None)
    groups = [group for group, _ in round_off.growths(round_off.stored(tmp_path, print))]
    assert [group["commit"] for group in groups] == ["aaaaaaaaaaaa", "bbbbbbbbbbbb"]
    assert all(len(group["date"]) == 10 for group in groups)


def test_a_run_that_fails_is_a_row_with_its_status() -> None:
    problem = replace(round_off.member(0), v0=0.0 * round_off.member(0).v0)
    samples = list(gauss(4, 20).samples(problem, 1e4, None, print))
    assert np.isnan(samples[-1].error) and samples[-1].status.startswith("Stopped")
    assert len(samples) < len(SAMPLED_HUNDREDTHS)


def test_galvi_and_ias15_walk_over_a_hundred_years() -> None:
    sample = {
        participant.label: list(participant.samples(round_off.member(0), 100.0, None, print))
        for participant in round_off.PARTICIPANTS
    }
    assert {len(run) for run in sample.values()} == {len(SAMPLED_HUNDREDTHS)}
    for label, run in sample.items():
        assert max(abs(point.error) for point in run) < 5e-15, label
    galvi_run = sample["galvi degree 8, Gauss 8"]
    assert any(point.error != point.error_of_rounded for point in galvi_run)
    assert isinstance(galvi_run[0], Sample)
