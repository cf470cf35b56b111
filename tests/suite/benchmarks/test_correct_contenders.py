"""`verify` of correct integrators raises no alarm, whatever steps they offer; the same ones with a
small fault do."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import galvi
from benchmarks.applications.external import long_runs
from benchmarks.applications.external.check_problems import CHECK_PROBLEMS
from benchmarks.applications.external.checks import FAR, _own_floor
from tests.suite.benchmarks.contenders_at_hand import ORBIT, SWING, Inside, checked
from tests.suite.benchmarks.correct_contenders import (
    FOUR,
    METHODS,
    SETTINGS,
    SIX,
    Adaptive,
    Compiled,
)

(DRIVEN,) = (check for check in CHECK_PROBLEMS if check.problem.name == "driven oscillator")
SHORT = replace(ORBIT, long=20.3)
STALE = 3000  # steps after which some integrators become wrong


@pytest.mark.slow(beside="test_the_order_of_a_correct_method_is_seen_at_any_steps")
@pytest.mark.parametrize("numbers", SETTINGS.values(), ids=SETTINGS)
@pytest.mark.parametrize("method", METHODS)
def test_a_correct_method_raises_no_alarm(method, numbers):
    rows, differing, external = checked(
        Compiled(method, numbers=numbers, **METHODS[method]), *CHECK_PROBLEMS
    )
    assert differing == [] and external.faults == []
    (seen,) = (row for row in rows if row.quantity == "problems where its order is seen")
    assert seen.verdict == "holds"


@pytest.mark.slow(
    beside="test_contender_checks.py::test_an_order_that_is_not_seen_is_no_failure_and_says_what_to_do"
)
@pytest.mark.parametrize("order", [8, None])
@pytest.mark.parametrize("more", [-1, 0, 1])
def test_a_correct_adaptive_method_raises_no_alarm(order, more):
    adaptive = Adaptive()
    adaptive.order, adaptive.tolerances = order, tuple(k + more for k in Adaptive.tolerances)
    rows, differing, external = checked(adaptive, *CHECK_PROBLEMS)
    assert differing == [] and external.faults == []
    seen = [row.verdict for row in rows if row.quantity == "problems where its order is seen"]
    assert seen == ([] if order is None else ["not run"])


@pytest.mark.slow_cases("10 times coarser")
@pytest.mark.parametrize("numbers", SETTINGS.values(), ids=SETTINGS)
def test_the_order_of_a_correct_method_is_seen_at_any_steps(numbers):
    rows, differing, _ = checked(
        Compiled("Yoshida 6", numbers=numbers, **METHODS["Yoshida 6"]), SHORT
    )
    (order,) = (row for row in rows if row.quantity.startswith("order in the step"))
    assert differing == [] and order.measured == pytest.approx(6.0, abs=0.3)


def composition(outside: tuple[float, ...]) -> tuple[float, ...]:
    """Symmetric weights whose sum is 1."""
    return (*outside, 1.0 - 2.0 * sum(outside), *outside[::-1])


@pytest.mark.parametrize("numbers", SETTINGS.values(), ids=SETTINGS)
@pytest.mark.parametrize(
    ("order", "weights"),
    [
        (6, FOUR), (6, composition((SIX[0] + 1e-7, *SIX[1:]))), (4, composition(SIX)),
        (2, composition(SIX)), (8, composition(SIX)), (3, [1.0]), (1, [1.0]),
    ],
    ids=["4 for 6", "6, a coefficient off by 1e-7", "6 for 4", "6 for 2", "6 for 8", "2 for 3",
         "2 for 1"],
)  # fmt: skip
def test_another_order_than_declared_is_seen_at_any_steps(order, weights, numbers):
    wrong = Compiled("wrong", order, True, numbers, weights)
    differing = checked(wrong, SHORT)[1]
    assert any(row.quantity.startswith("order in the step") for row in differing)


class Single(Compiled):
    """Its states are rounded to single precision after each step."""

    def __init__(self, order: float, weights: Any, numbers: Any = (25, 100, 400, 1600)) -> None:
        super().__init__("single", order, False, numbers, weights)

    def run(self, problem: galvi.Problem, duration: float, setting: Any) -> galvi.Trajectory:
        h, every = np.float32(setting["step"]), setting["save_every"]
        q, v = (np.array(x, dtype=np.float32) for x in (problem.q0, problem.v0))
        saved = [(problem.q0, problem.v0)]
        for k in range(round(duration / setting["step"])):
            for w in np.array(self.weights, dtype=np.float32):
                q = q + np.float32(0.5) * w * h * v
                pull = problem.system.acceleration(q.astype(float), 0.0)
                v = v + w * h * pull.astype(np.float32)
                q = q + np.float32(0.5) * w * h * v
            saved += [(q.astype(float), v.astype(float))] if (k + 1) % every == 0 else []
        q, v = np.swapaxes(saved, 0, 1)
        t = problem.t0 + setting["step"] * every * np.arange(len(q))
        return galvi.Trajectory(problem, t, q, problem.system.momentum(v))


@pytest.mark.parametrize("numbers", [(25, 100, 400, 1600), (250, 1000)])
@pytest.mark.parametrize("declared", [1, 2, 3])
def test_the_order_of_a_method_in_single_precision_is_seen_where_its_errors_fall(
    declared, numbers, monkeypatch
):
    monkeypatch.setattr(long_runs, "MANY", 1000)
    rows, differing, _ = checked(Single(declared, [1.0], numbers), replace(SWING, long=5.0))
    (order,) = (row for row in rows if row.quantity.startswith("order in the step"))
    assert order.measured == pytest.approx(2.0, abs=0.15)
    differing = [row for row in differing if "finest over that" not in row.quantity]
    assert differing == ([] if declared == 2 else [order])


def test_the_limit_of_another_problem_is_no_level_of_round_off():
    h = 0.1 * 1.5 ** -np.arange(18.0)
    for other in (0.0, 1e-4, -1e-4):
        assert _own_floor(np.abs(h**2 + other), 1e-11) == 0.0
    noise = 1e-5 * np.random.default_rng(1).standard_normal(h.size)
    assert 1e-6 < _own_floor(np.abs(h**2 + noise), 1e-11) < 1e-3


class Clocked(Compiled):
    """Leapfrog with a wrong clock."""

    def __init__(self, clock: Any = lambda t, t0: t, sense: float = 1.0) -> None:
        super().__init__("clocked", 2, False, (250, 1000))
        self.clock, self.sense, self.order = clock, sense, None

    def run(self, problem: galvi.Problem, duration: float, setting: Any) -> galvi.Trajectory:
        h, every, q, v = setting["step"], setting["save_every"], problem.q0, problem.v0
        saved, step = [(q, v)], self.sense * h
        for k in range(round(duration / h)):
            q = q + 0.5 * step * v
            t = self.clock(problem.t0 + (k + 0.5) * h, problem.t0)
            v = v + step * problem.system.acceleration(q, t)
            q = q + 0.5 * step * v
            saved += [(q, v)] if (k + 1) % every == 0 else []
        q, v = np.swapaxes(saved, 0, 1)
        t = problem.t0 + h * every * np.arange(len(q))
        return galvi.Trajectory(problem, t, q, problem.system.momentum(v))


def test_a_wrong_time_and_a_reversed_one_are_seen(monkeypatch):
    monkeypatch.setattr(long_runs, "MANY", 4000)
    short = replace(DRIVEN, long=5.0)
    assert checked(Clocked(), short)[1] == []
    wrong = [
        Clocked(lambda t, t0: -t), Clocked(lambda t, t0: 0.0), Clocked(lambda t, t0: t - t0),
        Clocked(lambda t, t0: t + 1.0), Clocked(lambda t, t0: 2.0 * t0 - t),
    ]  # fmt: skip
    for contender in wrong:
        rows = {row.quantity: row for row in checked(contender, short)[1]}
        assert rows[f"error at its finest over the way from the start, {DRIVEN.problem.name}"]
    for check in CHECK_PROBLEMS:
        if check.problem.name.startswith(("harmonic", "planar pendulum", "driven")):
            rows = checked(Clocked(sense=-1.0), replace(check, long=5.0))[1]
            assert any("over the way" in row.quantity for row in rows), check.problem.name


class LateClock(Clocked):
    """Its time is wrong from step STALE of each run on."""

    def run(self, problem: galvi.Problem, duration: float, setting: Any) -> galvi.Trajectory:
        late = problem.t0 + STALE * setting["step"]
        self.clock = lambda t, t0: t + 1.0 if t > late else t
        return super().run(problem, duration, setting)


def test_a_clock_that_goes_wrong_after_many_steps_is_seen(monkeypatch):
    monkeypatch.setattr(long_runs, "MANY", 40_000)
    (row,) = long_runs.cut_run(Inside.of(LateClock()), DRIVEN)
    assert row["steps"] == 8000 and row["value"] > FAR
    sound = [Compiled(name, numbers=(100,), **METHODS[name]) for name in ("leapfrog", "Yoshida 6")]
    for contender in (*sound, Clocked(), Adaptive()):
        external = Inside.of(contender)
        (row,) = long_runs.cut_run(external, DRIVEN)
        assert row["value"] < 1e-6 and external.faults == []  # 3e-9 of Adaptive


class Late(Compiled):
    """Correct up to step STALE only."""

    def __init__(self, factor: float) -> None:
        super().__init__("late", numbers=(100, 400, 1600), **METHODS["leapfrog"])
        self.factor = factor

    def run(self, problem: galvi.Problem, duration: float, setting: Any) -> galvi.Trajectory:
        run = super().run(problem, duration, setting)
        late = np.arange(len(run.t)) * setting["save_every"] > STALE
        wrong = np.where(late, self.factor, 1.0)[:, None]
        return replace(run, q=run.q * wrong)


@pytest.mark.parametrize(
    ("factor", "name"),
    [(np.nan, "runs and answers that failed"), (1.01, "relative change of angular momentum")],
)
def test_what_goes_wrong_after_many_steps_only_is_seen(factor, name):
    assert checked(Late(1.0), SHORT)[1] == []
    differing = checked(Late(factor), SHORT)[1]
    assert any(row.quantity.startswith(name) for row in differing)


def test_the_longest_run_is_no_longer_than_the_time_limit_allows():
    rows, differing, _ = checked(Late(1.0), SHORT)
    (row,) = (row for row in rows if row.quantity.startswith("steps of its longest run"))
    assert differing == [] and 90_000 < row.measured < 110_000
