"""No correct symplectic integrator is said to lose its energy; a drift still is."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import galvi
from benchmarks.applications.external.check_problems import CHECK_PROBLEMS
from benchmarks.applications.external.checks import _growth
from benchmarks.applications.external.long_runs import GROUP_SIZE, LONG_RUN_PARTS, SEEDS, at_random
from benchmarks.measures import independent_invariants
from benchmarks.statistics.drift import drift
from tests.suite.benchmarks.contenders_at_hand import Gauss, Stepped
from tests.suite.benchmarks.correct_contenders import triple_jump

DURATIONS = np.random.default_rng(12).uniform(90.0, 150.0, 50)
FEW_DURATIONS = [123.0, *DURATIONS[:4]]  # the first once gave a false alarm
STEPS, FEWER_STEPS = 4000, 2000
NAMES = ("harmonic oscillator", "planar pendulum", "kepler", "henon-heiles")
PROBLEMS = {
    check.problem.name: (check.watched or check.problem, check.energy) for check in CHECK_PROBLEMS
}


INTEGRATORS = {"leapfrog, order 2": (Stepped(), STEPS)}
for order in (4, 8):
    INTEGRATORS[f"leapfrog, order {order}"] = Stepped(), FEWER_STEPS
    INTEGRATORS[f"leapfrog, order {order}"][0].weights = triple_jump(order)
for points in (1, 2, 3, 4):
    INTEGRATORS[f"Gauss {points}"] = Gauss(), FEWER_STEPS
    INTEGRATORS[f"Gauss {points}"][0].method = galvi.Galerkin(
        galvi.Polynomials(points), galvi.gauss(points)
    )


@cache
def changes(integrator: str, name: str, duration: float) -> tuple[np.ndarray, np.ndarray]:
    """Times and relative changes of the energy."""
    key = next(key for key in PROBLEMS if key.lower().startswith(name))
    problem, energy = PROBLEMS[key]
    contender, steps = INTEGRATORS[integrator]
    run = contender.run(problem, duration, {"step": duration / steps, "save_every": 1})
    values = (energy or independent_invariants.hamiltonian)(problem, run.q, run.p)
    return run.t - run.t[0], np.abs(values - values[0]) / abs(values[0])


def alarm(t: np.ndarray, values: np.ndarray) -> str:
    """The sentence of `verify` if the samplings of all seeds show a drift, else ""."""
    faults = [_growth(np.inf, drift(*at_random(t, values, seed))) for seed in SEEDS]
    return faults[0] if all(faults) else ""


@pytest.mark.slow_cases(
    "few-harmonic oscillator-leapfrog, order 4",
    "few-harmonic oscillator-leapfrog, order 8",
    "few-planar pendulum-leapfrog, order 2",
    "few-planar pendulum-leapfrog, order 4",
    "few-planar pendulum-leapfrog, order 8",
    "few-kepler-leapfrog, order 2",
    "few-kepler-leapfrog, order 4",
    "few-kepler-leapfrog, order 8",
    "few-henon-heiles-leapfrog, order 2",
    "few-henon-heiles-leapfrog, order 4",
    "few-henon-heiles-leapfrog, order 8",
)
@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize(
    "durations",
    [FEW_DURATIONS, pytest.param(DURATIONS, marks=pytest.mark.slow)],
    ids=["few", "fifty"],
)
def test_there_is_no_false_alarm(integrator, name, durations):
    alarms = {
        duration: alarm(*changes(integrator, name, float(duration))) for duration in durations
    }
    assert not any(alarms.values()), alarms


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("fraction", [0.05, -0.05])
def test_a_drift_of_a_twentieth_is_seen(name, fraction):
    for duration in FEW_DURATIONS:
        t, values = changes("leapfrog, order 2", name, float(duration))
        drifting = values + fraction * np.max(values) * t / t[-1]
        assert "Over the run" in alarm(t, drifting), duration


def test_samples_are_taken_at_random_where_there_are_enough():
    t = np.arange(GROUP_SIZE * LONG_RUN_PARTS * 2 + 1.0)
    (first, second), (middle, _) = (at_random(t, t, seed)[1] for seed in SEEDS), at_random(t, t, 1)
    assert len(first) == 2 * LONG_RUN_PARTS and np.max(np.abs(first - middle)) < GROUP_SIZE
    assert not np.array_equal(first, second) and np.ptp(np.diff(middle)) == 0.0
    assert np.array_equal(
        at_random(t[: LONG_RUN_PARTS + 1], t[: LONG_RUN_PARTS + 1], 1)[1], t[: LONG_RUN_PARTS + 1]
    )
