"""What says that it is symmetric is run back, and what keeps memory is caught."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import galvi
from benchmarks.applications.external.check_problems import CHECK_PROBLEMS
from benchmarks.applications.external.check_runs import GROWTH, Runs
from benchmarks.applications.external.checks import LEFT, Judge
from benchmarks.applications.external.reversed_runs import REVERSED
from benchmarks.applications.external.worker import memory_growth
from benchmarks.store.frames import frame
from tests.suite.benchmarks.contenders_at_hand import ORBIT, Gauss, Inside, checked
from tests.suite.benchmarks.correct_contenders import METHODS, Compiled

SHORT = replace(ORBIT, long=20.3)
DRIVEN = replace(
    CHECK_PROBLEMS[2], problem=replace(galvi.problems.driven_oscillator(), t0=0.0)
)  # fmt: skip


def turned_back(contender: Any, *check_problems: Any) -> list[Any]:
    """Its rows on the run back, on each problem that it supports."""
    contender.symmetric = True
    external = Inside.of(contender)
    judge = Judge("A", external, check_problems)
    rows = []
    for problem in check_problems:
        if external.supports(problem.problem):
            rows += judge.reversed(problem, frame(Runs(external).reversed(problem)))
    return rows


@pytest.mark.parametrize("method", METHODS)
def test_compositions_and_gauss_return_to_their_start_and_runge_and_kutta_do_not(method):
    contender = Compiled(method, numbers=(100, 400, 1600), **METHODS[method])
    rows = turned_back(contender, *CHECK_PROBLEMS)
    assert len(rows) >= 7
    expected = "contradicted" if method == "Runge-Kutta 4" else "holds"
    assert {row.verdict for row in rows} == {expected}, rows


class Midpoint(Gauss):
    """Symmetric on rotations too, with rotation vectors from the start of a step."""

    name, order = "midpoint", 2

    def run(self, problem: galvi.Problem, duration: float, setting: Any) -> galvi.Trajectory:
        method = galvi.Galerkin(galvi.Polynomials(1), galvi.gauss(1), galvi.Exponential())
        steps, every = round(duration / setting["step"]), setting["save_every"]
        return galvi.integrate(problem, method, setting["step"], steps, save_every=every)


def test_rotations_and_lagrangians_return_where_the_method_is_symmetric_on_them():
    last = [one for one in CHECK_PROBLEMS if one.problem.q0.shape != one.problem.v0.shape]
    (chain,) = (one for one in CHECK_PROBLEMS if one.problem.name == "double pendulum")
    rows = [*turned_back(Midpoint(), *last), *turned_back(Gauss(), chain)]
    assert len(rows) == 3 and {row.verdict for row in rows} == {"holds"}
    # Gauss's stages in the chart of a step's start are not symmetric.
    assert {row.verdict for row in turned_back(Gauss(), *last)} == {"contradicted"}


class OneSided(Gauss):
    """The symplectic Euler method, which is not symmetric."""

    name, order = "one-sided", 1

    def run(self, problem: galvi.Problem, duration: float, setting: Any) -> galvi.Trajectory:
        h, every, q, v = setting["step"], setting["save_every"], problem.q0, problem.v0
        saved = [(q, v)]
        for k in range(round(duration / h)):
            v = v + h * problem.system.acceleration(q, 0.0)
            q = q + h * v
            saved += [(q, v)] if (k + 1) % every == 0 else []
        q, v = np.swapaxes(saved, 0, 1)
        t = problem.t0 + h * every * np.arange(len(q))
        return galvi.Trajectory(problem, t, q, problem.system.momentum(v))


class OneWay(Gauss):
    """It cannot run backwards."""

    name = "one way"

    def run(self, problem: galvi.Problem, duration: float, setting: Any) -> galvi.Trajectory:
        if duration < 0.0:
            raise ValueError("the duration must be positive")
        return super().run(problem, duration, setting)


def test_a_method_that_is_not_symmetric_is_caught_where_it_says_so_and_nowhere_else():
    (row,) = turned_back(OneSided(), ORBIT)
    assert row.verdict == "contradicted" and row.measured > 1e-4
    assert row.quantity == f"{REVERSED}, {ORBIT.problem.name}" and "symmetric" in row.reason
    (row,) = turned_back(OneWay(), ORBIT)
    assert row.verdict == "contradicted" and row.measured is None
    assert row.reason == "It raised ValueError: the duration must be positive."
    rows, differing, external = checked(OneWay(), SHORT)
    assert differing == [] and external.faults == []
    assert not any(row.quantity.startswith(REVERSED) for row in rows)


def test_what_chooses_its_steps_is_not_run_back():
    class Adaptive(Gauss):
        def settings(self, problem, duration):
            return [{"tolerance": 1e-6}]

        def run(self, problem, duration, setting):
            step = {"step": duration / setting["samples"] / 40, "save_every": 40}
            return super().run(problem, duration, step)

    (row,) = turned_back(Adaptive(), ORBIT)
    assert row.verdict == row.expected == "not run" and "settings with a `step`" in row.reason


def from_zero(kind: type[Gauss]) -> Any:
    """A contender whose runs start at time 0 alone."""

    class FromZero(kind):
        def supports(self, problem):
            return problem.t0 == 0.0

    return FromZero()


def test_what_only_starts_at_time_zero_is_run_back_unless_time_matters():
    (row,) = turned_back(from_zero(OneSided), ORBIT)
    assert row.verdict == "contradicted" and row.measured > 1e-4
    (row,) = turned_back(from_zero(Gauss), ORBIT)
    assert row.verdict == "holds"
    (row,) = turned_back(from_zero(Gauss), DRIVEN)
    assert row.verdict == row.expected == "not run" and "t = 5" in row.reason
    external = Inside.of(from_zero(Gauss))
    rows = frame(Runs(external).restarted(DRIVEN))
    (row,) = Judge("A", external, (DRIVEN,)).restarted(DRIVEN, rows)
    assert row.verdict == row.expected == "not run" and row.reason.startswith("It does not support")


LEAK = 40_000_000  # bytes: more than the C library takes from what was freed before


class Keeping(Gauss):
    """It keeps so many bytes of each run."""

    name = "keeping"

    def __init__(self, size: int) -> None:
        self.size, self.kept = size, []

    def run(self, problem: galvi.Problem, duration: float, setting: Any) -> galvi.Trajectory:
        self.kept.append(np.ones(self.size // 8))
        return super().run(problem, duration, setting)


def test_memory_that_each_run_keeps_is_caught_and_what_is_taken_once_is_not(monkeypatch):
    monkeypatch.setattr("benchmarks.applications.external.worker.MOST_RUNS", 1)
    rows = {}
    for size in (0, LEAK):
        external = Inside.of(Keeping(size))
        external.watched = True
        judge = Judge("A", external, (ORBIT,))
        (rows[size],) = judge.memory(ORBIT, frame(Runs(external).memory(ORBIT)))
    assert rows[0].verdict == "holds" and rows[0].measured < LEFT
    assert rows[LEAK].verdict == "contradicted" and rows[LEAK].measured > LEFT
    assert rows[0].quantity == f"{GROWTH}, MB, {ORBIT.problem.name}"


def test_a_run_that_is_long_is_not_repeated_for_its_memory(monkeypatch):
    monkeypatch.setattr("benchmarks.applications.external.worker.SLOW", 0.0)
    assert np.isnan(memory_growth(Gauss(), ORBIT.problem, 5.0, {"step": 0.5, "save_every": 10}))
    external = Inside.of(Gauss())
    external.watched = True
    judge = Judge("A", external, (ORBIT,))
    (row,) = judge.memory(ORBIT, frame(Runs(external).memory(ORBIT)))
    assert row.verdict == row.expected == "not run" and "too long" in row.reason
