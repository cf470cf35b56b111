"""Work-precision problems of rigid bodies: participants, timing, and a wrong torque."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd
import pytest

import galvi
from benchmarks.statistics.convergence_fits import algebraic
from benchmarks.statistics.repeated_run import repeated_run
from benchmarks.work_precision import run as work_precision
from benchmarks.work_precision.galvi_methods import Variational, gauss_collocation
from benchmarks.work_precision.problem import ATTITUDE, Participant, Truth, WorkPrecisionProblem
from benchmarks.work_precision.problems.rigid_bodies import (
    MUJOCO,
    TEXTBOOK_DOP853,
    TEXTBOOK_RK4,
    free_body,
    heavy_top,
    pendulum,
)
from galvi import Problem, Trajectory
from galvi.charts import CHARTS
from references.mujoco.steps import MUJOCO_RK4

needs_mujoco = pytest.mark.skipif(bool(MUJOCO_RK4.missing), reason=MUJOCO_RK4.missing or "present")
OURS = "galvi degree 8, Gauss 8, Cayley"
WRONG = "galvi, wrong torque"


def study(case: WorkPrecisionProblem, *labels: str) -> pd.DataFrame:
    """The problem with these contenders only, in the quick setting."""
    few = tuple(one for one in case.participants if not labels or one.label in labels)
    alone = replace(case, participants=few)
    return work_precision._study(alone, lambda sentence: None, quick=True)


@pytest.mark.parametrize("make", [free_body, pendulum])
def test_everyone_takes_part_in_every_chart_and_by_every_integrator(make: Any) -> None:
    for quick in (True, False):
        case = make(quick)
        labels = {one.label for one in case.participants}
        assert {engine.name for engine in MUJOCO} | {TEXTBOOK_RK4, TEXTBOOK_DOP853} <= labels
        assert {
            f"galvi degree {degree}, Gauss {degree}, {chart.name}"
            for degree in (4, 6, 8, 10, 12)
            for chart in CHARTS
        } <= labels
        more = {f"galvi degree {degree}, Gauss {degree + 1}, Cayley" for degree in (6, 8, 10)}
        assert more & labels == (more if make is free_body else set())
        assert case.quantity == ATTITUDE and case.repeated_run
        assert all(one.contender.supports(case.problem) for one in case.participants)
        assert case.truth().error < 2e-16 and case.truth().source is None
    steps = {
        label: [one.get("step") for one in settings] for label, _, settings in case.participants
    }
    assert steps[MUJOCO_RK4.name] == steps[TEXTBOOK_RK4]


def test_fewer_take_part_on_the_heavy_top() -> None:
    case = heavy_top(False)
    labels = [one.label for one in case.participants]
    assert {MUJOCO_RK4.name, TEXTBOOK_DOP853, "heyoka, rigid bodies"} < set(labels)
    assert len(labels) == 7 and all(x.endswith("Cayley") for x in labels if x.startswith("galvi"))
    assert all(one.contender.supports(case.problem) for one in case.participants)
    ours = next(one for one in case.participants if one.label == OURS)
    errors = [
        case.distance(ours.contender.run(case.problem, case.duration, one).q[-1], case.truth().end)
        for one in ours.settings[1:]
    ]
    assert errors[0] < 1e-10 and errors[1] < 1e-12  # 4e-12, 9e-15


@pytest.mark.parametrize("make", [free_body, pendulum])
def test_errors_are_of_the_attitude_and_times_of_the_whole_run(make: Any) -> None:
    rows = study(make(True), OURS, TEXTBOOK_RK4, TEXTBOOK_DOP853)
    assert (rows["quantity"] == ATTITUDE).all() and rows["seconds"].gt(0.0).all()
    errors = rows.groupby("contender")["error"].min()
    assert errors[OURS] < 1e-10 and errors[TEXTBOOK_DOP853] < 1e-9  # 1.2e-11, 8.9e-11
    longer, shorter = rows[rows["contender"] == TEXTBOOK_RK4].to_dict("records")[::-1]
    assert longer["seconds"] / shorter["seconds"] > 4.0  # 16 times as many steps: 15 times


@needs_mujoco
def test_mujoco_s_rk4_comes_to_the_truth_with_order_4_and_the_others_with_order_1() -> None:
    case = pendulum(False)
    for engine in MUJOCO:
        settings = next(some for label, _, some in case.participants if label == engine.name)
        runs = [engine.run(case.problem, case.duration, one) for one in settings[:3]]
        errors = [case.distance(run.q[-1], case.truth().end) for run in runs]
        rate = algebraic([run.step for run in runs], errors, floor=1e-12).rate
        assert rate == pytest.approx(engine.order, abs=0.1)  # 4.01; 0.96 to 1.0


@dataclass(frozen=True)
class WrongTorque:
    """galvi on a body whose weight pulls up: a sign gone wrong."""

    method: Variational
    name: str = WRONG
    exact: bool = False
    missing: str = ""

    def supports(self, problem: Problem) -> bool:
        return self.method.supports(problem)

    def run(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Trajectory:
        weight: Any = problem.system.potential
        up = galvi.UniformGravity(weight.mass, weight.centre, -weight.g)
        body = galvi.RigidBody(problem.system.inertia, up)
        return self.method.run(Problem(body, problem.q0, problem.v0), duration, setting)


@pytest.mark.slow(beside="test_errors_are_of_the_attitude_and_times_of_the_whole_run")
def test_a_wrong_torque_stands_out_though_it_conserves_its_own_energy() -> None:
    case = pendulum(True)
    method = gauss_collocation(8)
    settings = next(some for label, _, some in case.participants if label == OURS)
    planted = replace(
        case, participants=(*case.participants, Participant(WRONG, WrongTorque(method), settings))
    )
    rows = study(planted)
    sound, wrong = rows[rows["contender"] != WRONG], rows[rows["contender"] == WRONG]
    assert sound["error"].max() < 0.01 < 0.5 < wrong["error"].min()  # 0.0044; 1.3
    times = work_precision.ratios(rows, (1e-2, 1e-6))
    assert set(times[times["contender"] == WRONG]["ratio"]) == {"not reached"}
    run = WrongTorque(method).run(case.problem, case.duration, {"step": 0.1})
    energy = galvi.energy(run)
    assert np.max(np.abs(energy / energy[0] - 1.0)) < 1e-11  # 3e-15


@dataclass(frozen=True)
class Counted:
    """Notes what it is asked for; fails from a duration on."""

    asked: list[tuple[float, Any]]
    until: float = np.inf
    missing: str = ""

    def run(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Trajectory:
        self.asked.append((duration, dict(setting)))
        run = gauss_collocation(4).run(problem, 1.0, {"step": 0.5})
        return run if duration < self.until else replace(run, success=False, status="It broke.")


def test_a_run_is_made_longer_by_a_whole_number_and_keeps_its_last_state() -> None:
    problem, noted = galvi.problems.free_rigid_body(), Counted([])
    made = repeated_run(noted, problem, 2.0, {"step": 0.5, "save_every": 4}, 1e-3, 0.01)
    assert noted.asked[0] == (20.0, {"step": 0.5, "save_every": 40})
    assert made.times >= 10 and made.failure == "" and made.seconds > 0.0
    made.call()
    assert noted.asked[-1] == (2.0 * made.times, {"step": 0.5, "save_every": 4 * made.times})
    slow = repeated_run(noted, problem, 2.0, {"samples": 1}, 5.0, 0.01)
    assert noted.asked[-1][1] == {"samples": 1} and slow.times >= 1


def test_a_setting_that_fails_later_has_its_error_and_no_time(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    case = free_body(True)
    one = Participant(
        OURS, Counted([], until=case.duration + 1.0), [{"step": 0.5, "save_every": 40}]
    )
    kept: Any = [replace(case, participants=(one,), truth=truth_of_start)]
    monkeypatch.setattr(work_precision, "work_precision_problems", lambda quick: kept)
    (row,) = work_precision.work_precision(quick=True).to_dict("records")
    assert np.isfinite(row["error"]) and np.isnan(row["seconds"])
    assert row["status"] == "Not timed, it fails later: It broke."


def truth_of_start() -> Truth:
    return Truth(np.eye(3), 0.0, "the start")
