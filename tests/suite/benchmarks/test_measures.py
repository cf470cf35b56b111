"""Measures of a run: frames, shapes of orbits, matrices of groups, angles turned, samples."""

from __future__ import annotations

import math
import time
from dataclasses import asdict
from itertools import combinations
from types import SimpleNamespace

import mpmath
import numpy as np
import pandas as pd
import pytest
from scipy.stats import rankdata

import galvi
from benchmarks.measures import independent_invariants, matrix_group, orbit_shape, rigid_invariants
from benchmarks.statistics.rank_test import (
    FEWEST_SAMPLES,
    SIGNIFICANCE,
    holm,
    p_value,
    relative_growth,
    samples_needed,
    slower,
)
from benchmarks.store import tables
from benchmarks.timings import annotate, worker
from benchmarks.timings.catalogue import CASES
from references.closed_forms.kepler import KEPLER
from references.textbook.nystrom import Nystrom


def table() -> pd.DataFrame:
    return tables.table_of(
        tables.row(study="s", quantity="e", n=n, step=0.5**n, value=0.1**n) for n in (3, 1, 2)
    )


def test_a_table_has_the_same_columns_and_types_with_rows_and_without() -> None:
    for rows in (table(), tables.table_of([])):
        assert list(rows.columns) == list(tables.COLUMNS)
        assert [str(kind) for kind in rows.dtypes] == [kind for _, kind in tables.COLUMNS.values()]


def test_what_a_row_does_not_say_is_nan_or_empty() -> None:
    row = tables.row(study="s", value=1.0)
    assert math.isnan(row["x"]) and row["status"] == "" and row["value"] == 1.0
    with pytest.raises(KeyError, match="speed"):
        tables.row(speed=3.0)


def test_a_series_comes_in_the_order_of_refinement() -> None:
    n, errors = tables.series(table(), "n", study="s")
    assert n.tolist() == [1.0, 2.0, 3.0] and np.all(np.diff(errors) < 0.0)
    step, errors = tables.series(table(), "step", study="s")
    assert step.tolist() == [0.5, 0.25, 0.125] and np.all(np.diff(errors) < 0.0)


def test_one_number_is_one_number() -> None:
    assert tables.number(table(), n=2.0) == pytest.approx(0.01)
    assert math.isnan(tables.number(table(), n=7.0))
    assert math.isnan(tables.number(pd.DataFrame(), n=2.0))
    with pytest.raises(ValueError, match="3"):
        tables.number(table(), study="s")


ECCENTRICITY = 0.2


def planet() -> galvi.Problem:
    """A light body about a star, from its pericentre on the x axis, a = GM = 1."""
    speed = math.sqrt((1.0 + ECCENTRICITY) / (1.0 - ECCENTRICITY))
    return galvi.Problem(
        galvi.NBody([1.0 - 1e-9, 1e-9]),
        [[0.0, 0.0, 0.0], [1.0 - ECCENTRICITY, 0.0, 0.0]],
        [[0.0, 0.0, 0.0], [0.0, speed, 0.0]],
    )


def test_period_extent_and_perihelion_of_an_ellipse() -> None:
    problem = planet()
    assert orbit_shape.period(problem, 1) == pytest.approx(math.tau)
    run = KEPLER.run(problem, 3 * math.tau, {"samples": 300})
    closest, farthest = orbit_shape.extent(run.t, run.q, 1, 1.0, 1.0 + math.tau)
    assert closest == pytest.approx(1.0 - ECCENTRICITY, abs=1e-5)
    assert farthest == pytest.approx(1.0 + ECCENTRICITY, abs=1e-5)
    vector = orbit_shape.perihelion(run, 1)
    assert vector == pytest.approx(np.tile([ECCENTRICITY, 0.0, 0.0], (301, 1)), abs=1e-12)


def test_angles_are_accurate_when_tiny_and_when_right() -> None:
    x = np.array([1.0, 0.0, 0.0])
    assert orbit_shape.angle(x, np.array([1.0, 1e-9, 0.0])) == pytest.approx(1e-9)
    assert orbit_shape.angle(x, np.array([0.0, 0.0, 2.0])) == pytest.approx(0.5 * math.pi)


@pytest.mark.parametrize("size", [1e-8, 0.9, 7.9])
def test_the_exponential_is_exact_to_a_few_roundings(size):
    X = np.random.default_rng(0).standard_normal((4, 4))
    for matrix in (X * size / np.linalg.norm(X), np.diag([size, 0.0, 0.0])):
        with mpmath.workdps(40):
            exact = np.array(mpmath.expm(mpmath.matrix(matrix.tolist())).tolist(), dtype=float)
        gap = np.abs(matrix_group.exponential(matrix) - exact)
        assert np.max(gap) <= 1e-14 * np.max(np.abs(exact))


TOP = galvi.problems.heavy_top()


def test_the_values_are_those_written_out():
    """Moments (1, 1, 0.5), m = 1, l = 1, g = 2, spin 8, tilted by 0.5 about x."""
    R, p = TOP.q0[None], TOP.p0[None]
    assert rigid_invariants.energy(TOP, R, p) == pytest.approx(0.5 * 0.5 * 64.0 + 2.0 * np.cos(0.5))
    assert rigid_invariants.spatial_momentum(R, p)[:, 2] == pytest.approx(4.0 * np.cos(0.5))
    skewed = R + np.array([[0.0, 1e-3, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    assert rigid_invariants.orthogonality_defect(R) < 3e-16
    assert rigid_invariants.orthogonality_defect(skewed) == pytest.approx(1e-3, rel=1e-3)


METHOD = galvi.Galerkin(galvi.Polynomials(6), galvi.gauss(6))
J = [[3.0, 0.4, 0.2], [0.4, 2.5, -0.3], [0.2, -0.3, 3.4]]
WEIGHT = galvi.UniformGravity(1.3, (0.1, -0.4, 0.6), (1.0, 2.0, -5.0))


@pytest.mark.parametrize(
    ("problem", "step"),
    [
        (galvi.problems.harmonic_oscillator(), 0.5),
        (galvi.problems.planar_pendulum(2.0), 0.5),
        (galvi.problems.kepler(0.4), 0.2),
        (galvi.problems.solar_system(), 5.0),
        (galvi.problems.free_rigid_body(), 0.2),
        (galvi.problems.pendulum_3d(), 0.2),
        (galvi.Problem(galvi.RigidBody(J, WEIGHT), TOP.q0, (1.0, -2.0, 0.5)), 0.1),
        (galvi.problems.free_body_se3(g=(0.1, -0.2, -1.0)), 0.2),
    ],
    ids=lambda value: getattr(value, "name", None),
)
def test_invariants_are_those_of_galvi(problem, step):
    run = galvi.integrate(problem, METHOD, step, 20)
    v = problem.system.velocity(run.p)
    energy = independent_invariants.energy(problem, run.q, v)
    np.testing.assert_allclose(energy, galvi.energy(run), rtol=1e-13)
    if problem.q0.shape[-1] > 1 and not isinstance(problem.system, galvi.FreeBody):
        exact = galvi.momentum_map(run)
        momentum = independent_invariants.angular_momentum(problem, run.q, v)
        assert np.allclose(momentum, exact, rtol=1e-12, atol=1e-14 * np.abs(exact).max())
    if isinstance(problem.system, galvi.RigidBody):
        body_energy = rigid_invariants.energy(problem, run.q, run.p)
        np.testing.assert_allclose(body_energy, energy, rtol=1e-14)
        spatial = rigid_invariants.spatial_momentum(run.q, run.p)
        np.testing.assert_allclose(spatial, momentum, atol=1e-14)


def test_bodies_without_these_quantities_are_refused():
    orbit, wave = galvi.problems.kepler(0.3), galvi.problems.henon_heiles()
    with pytest.raises(TypeError, match="formula for a RigidBody"):
        rigid_invariants.energy(orbit, orbit.q0[None], orbit.p0[None])
    with pytest.raises(TypeError, match="there is no textbook energy here"):
        independent_invariants.energy(wave, wave.q0[None], wave.v0[None])


@pytest.mark.parametrize(("stages", "velocity"), [((0.0,), 2.0), ((0.5,), 1.0)])
def test_a_tableau_that_is_inconsistent_or_implicit_is_refused(stages, velocity):
    with pytest.raises(ValueError, match="weights that sum to 1 and stages below the diagonal"):
        Nystrom("wrong", 1, (stages,), (0.0,), (0.5,), (velocity,))


def times(factor: float, count: int = 12, spread: float = 0.02, seed: int = 0) -> list[float]:
    random = np.random.default_rng([seed, round(100 * factor)])
    return list(factor * (1.0 + spread * random.standard_normal(count)))


def test_the_chance_is_the_share_of_all_choices_and_is_what_holm_asks_of_equal_times() -> None:
    base, head = (
        [1.0, 1.1, 1.12, 1.2, 1.3, 1.32, 1.4, 1.5],
        [1.11, 1.31, 1.41, 1.51, 1.52, 1.6, 1.7, 1.8],
    )
    ranks = rankdata(head + base)
    sums = [sum(subset) for subset in combinations(ranks, 8)]
    assert p_value(base, head) == pytest.approx(np.mean(np.array(sums) >= sum(ranks[:8])))
    count = samples_needed(60)
    assert p_value([1.0] * count, [1.2] * count) < SIGNIFICANCE / 60


@pytest.mark.parametrize("slow", [1, 4, 6, 7, 11])
def test_equal_code_on_a_coarse_clock_looks_slower_no_more_often_than_stated(slow: int) -> None:
    """`slow` of 14 times are a tick longer, in all ways to divide them between the sides. Shared
    ranks in the distribution without ties would give probabilities up to 40 % too small."""
    chances = {
        count: p_value(
            [1.0] * (7 - slow + count) + [2.0] * (slow - count), [1.0] * (7 - count) + [2.0] * count
        )
        for count in range(max(0, slow - 7), min(slow, 7) + 1)
    }
    splits = {count: math.comb(slow, count) * math.comb(14 - slow, 7 - count) for count in chances}
    for stated in chances.values():
        alarms = sum(splits[count] for count in chances if chances[count] <= stated)
        assert alarms / math.comb(14, 7) <= stated * (1.0 + 1e-12)


def test_too_few_samples_and_equal_ones_decide_nothing() -> None:
    too_few = FEWEST_SAMPLES - 1
    assert p_value([1.0] * too_few, [2.0 + k for k in range(20)]) == 1.0
    assert p_value([1.0] * 10, [1.0] * 10) == 1.0


@pytest.mark.parametrize("wrong", [math.nan, math.inf, 0.0, -1.0])
def test_a_time_that_is_none_is_refused(wrong: float) -> None:
    with pytest.raises(ValueError, match="times of the head must be positive and finite"):
        p_value([1.0] * 8, [1.0] * 7 + [wrong])


@pytest.mark.parametrize("benchmarks", [1, 12, 40, 300])
def test_so_many_samples_are_enough_and_one_less_is_not(benchmarks: int) -> None:
    count = samples_needed(benchmarks)
    assert 1.0 / math.comb(2 * count, count) < SIGNIFICANCE / benchmarks
    assert count >= FEWEST_SAMPLES
    if count > FEWEST_SAMPLES:
        assert 1.0 / math.comb(2 * count - 2, count - 1) > SIGNIFICANCE / (20 * benchmarks)


def test_holm_asks_more_of_the_first_than_of_the_last() -> None:
    level = 0.05
    assert holm({"a": 0.016, "b": 0.024, "c": 0.049}, level) == {"a", "b", "c"}
    assert holm({"a": 0.017, "b": 0.001, "c": 0.9}, level) == {"a", "b"}
    assert holm({"a": 0.018, "b": 0.024, "c": 0.049}, level) == set()


def test_both_gates_are_needed() -> None:
    little = (times(1.0, 40, 0.01), times(1.05, 40, 0.01))
    assert p_value(*little) < SIGNIFICANCE and relative_growth(*little) < 0.10
    noisy = ([0.5, 0.6, 0.7, 1.0, 1.5, 1.6, 1.7], [0.55, 0.65, 0.75, 1.4, 1.55, 1.65, 1.75])
    assert relative_growth(*noisy) > 0.10 and p_value(*noisy) > SIGNIFICANCE
    much = (times(1.0), times(1.3))
    growing = slower(
        {"little": little, "noisy": noisy, "much": much},
        dict.fromkeys(("little", "noisy", "much"), 0.10),
    )
    assert growing == {"much"}


def test_a_faster_head_is_no_alarm_and_the_size_is_each_benchmark_s_own() -> None:
    pair = (times(1.0), times(1.3))
    assert slower({"a": pair[::-1]}, {"a": 0.10}) == set()
    assert slower({"a": pair, "b": pair}, {"a": 0.10, "b": 0.50}) == {"a"}


def test_a_sample_is_the_mean_of_the_quickest_attempt(monkeypatch: pytest.MonkeyPatch) -> None:
    clock_time = [0.0]
    seconds = iter([20.0, 1.0, 3.0, 5.0, 9.0, 1.0])

    def call() -> None:
        clock_time[0] += next(seconds)

    clock = SimpleNamespace(
        process_time=lambda: clock_time[0], perf_counter=lambda: 3.0 * clock_time[0]
    )
    monkeypatch.setattr(worker, "time", clock)
    assert worker.sample(call, 2, 3) == {"processor": 4.0, "wall": 12.0}


def test_calls_are_repeated_no_more_where_processor_time_stands_still(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Under `ulimit -t` it stands still for milliseconds."""
    clock = SimpleNamespace(process_time=lambda: 0.0, perf_counter=iter(range(99)).__next__)
    monkeypatch.setattr(worker, "time", clock)
    monkeypatch.setattr(worker, "prepared", lambda case: list)
    monkeypatch.setattr(worker, "described", lambda runs, momenta: {})
    assert worker.run(asdict(CASES[0]), {})["warm"] == 1

    repetitions: list[int] = []
    benchmark = SimpleNamespace(
        extra_info={}, pedantic=lambda call, rounds, iterations: repetitions.append(iterations)
    )
    monkeypatch.setattr(annotate, "TIMER", lambda: 0.0)
    annotate.timed(benchmark, lambda: time.sleep(0.02))
    assert repetitions == [1]
