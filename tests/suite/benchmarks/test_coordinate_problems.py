"""Work-precision of Lagrangians and thrown bodies: who takes part, wrong laws, net times."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

import galvi
from benchmarks.statistics.repeated_run import NetTime, net_time
from benchmarks.work_precision import run as work_precision
from benchmarks.work_precision.cost import cost_table
from benchmarks.work_precision.galvi_methods import gauss_collocation
from benchmarks.work_precision.problem import COORDINATES, MOTION, Participant
from benchmarks.work_precision.problems.arms import brownout
from benchmarks.work_precision.problems.pendulums import (
    elastic_pendulum,
    fermi_pasta_ulam_tsingou,
    henon_heiles,
)
from benchmarks.work_precision.problems.planets import kepler_polar
from benchmarks.work_precision.problems.rigid_bodies import free_body_se3
from galvi import Problem, Trajectory
from references.scipy.ivp import DOP853, TIGHT
from references.scipy.lagrangian_ivp import LAGRANGIAN_DOP853

ON_COORDINATES = (elastic_pendulum, henon_heiles, fermi_pasta_ulam_tsingou, kepler_polar)


@pytest.mark.parametrize("make", ON_COORDINATES)
def test_everyone_takes_part_and_two_truths_are_the_same(make: Any) -> None:
    for quick in (True, False):
        case = make(quick)
        labels = {one.label for one in case.participants}
        assert "heyoka, Lagrangians" in labels and len(labels) == 6
        assert {f"galvi degree {s}, Gauss {s}" for s in (4, 6, 8, 12)} <= labels
        assert case.quantity == COORDINATES
        assert all(one.contender.supports(case.problem) for one in case.participants)
    peer = LAGRANGIAN_DOP853 if LAGRANGIAN_DOP853.supports(case.problem) else DOP853
    second = peer.run(case.problem, case.duration, {"samples": 1, **TIGHT})
    truth = case.truth()
    assert case.distance(second.q[-1], truth.end) < 1e-12  # 2e-13
    assert truth.error < 2e-15 * max(1.0, np.abs(truth.end).max())


def test_of_a_thrown_body_and_of_a_grain_the_general_kernel_takes_part() -> None:
    for make, quantity, degree in ((free_body_se3, MOTION, 5), (brownout, COORDINATES, 4)):
        for quick in (True, False):
            case = make(quick)
            by_label = {one.label: one for one in case.participants}
            ours = f"galvi degree {degree}, Gauss {degree}"
            general = by_label[f"{ours}, general kernel"]
            assert case.quantity == quantity and general.contender == by_label[ours].contender
            assert [
                {key: x for key, x in one.items() if key != "solver"} for one in general.settings
            ] == list(by_label[ours].settings)
            assert {one["solver"] for one in general.settings} == {"newton"}
            assert all(one.contender.supports(case.problem) for one in case.participants)


def test_the_truth_of_a_grain_holds_as_far_as_it_says() -> None:
    case = brownout(True)
    loose = {"samples": 1, "rtol": 10.0 * TIGHT["rtol"], "atol": 10.0 * TIGHT["atol"]}
    run = DOP853.run(case.problem, case.duration, loose)
    assert case.distance(run.q[-1], case.truth().end) < 4.0 * case.truth().error
    ours = gauss_collocation(6).run(case.problem, case.duration, {"step": 0.005})
    assert case.distance(ours.q[-1], case.truth().end) < 1e-11


@dataclass(frozen=True)
class WrongLaw:
    """galvi on a problem with a slightly wrong law."""

    problem: Problem
    name: str = "galvi, wrong law"
    missing: str = ""

    def supports(self, problem: Problem) -> bool:
        return True

    def run(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Trajectory:
        return gauss_collocation(8).run(self.problem, duration, setting)


@pytest.mark.parametrize(
    ("make", "wrong"),
    [
        (elastic_pendulum, galvi.problems.elastic_pendulum(stiffness=40.4)),
        (fermi_pasta_ulam_tsingou, galvi.problems.fermi_pasta_ulam_tsingou(beta=0.01)),
        (free_body_se3, galvi.problems.free_body_se3(g=(0.0, 0.0, -0.01))),
    ],
)
def test_a_wrong_law_stands_out_though_it_conserves_its_own_energy(
    make: Any, wrong: Problem
) -> None:
    case = make(True)
    ours = next(one for one in case.participants if one.label == "galvi degree 8, Gauss 8")
    planted = Participant("galvi, wrong law", WrongLaw(wrong), ours.settings)
    rows = work_precision._study(
        replace(case, participants=(ours, planted), repeated_run=False, net_time=False),
        lambda sentence: None,
        quick=True,
    )
    right, fault = (
        rows["error"][rows["contender"] == x].max() for x in (ours.label, planted.label)
    )
    assert right < 1e-5 < 1e-4 < fault
    energy = galvi.energy(planted.contender.run(wrong, case.duration, ours.settings[0]))
    assert np.ptp(energy) < 1e-6 * max(1.0, abs(energy[0]))


@dataclass
class Taking:
    """A call in another process, which takes these times."""

    times: list[float]

    def __call__(self) -> Any: ...

    def seconds(self, repeats: int) -> float:
        return self.times.pop(0)


def test_a_net_time_is_of_the_steps_alone() -> None:
    disturbed = Taking([4.5e-3, 4e-3, 5e-3, 4.5e-3, 4.5e-3])
    assert NetTime(disturbed, Taking([1e-3] * 5), steps=4).seconds(1) == pytest.approx(4e-3)
    assert math.isnan(NetTime(Taking([1e-3] * 6), Taking([4e-3] * 6), steps=4).seconds(6))
    assert NetTime(Taking([3.0]), Taking([1e-3]), steps=4).seconds(6) == pytest.approx(
        2.999 * 4 / 3
    )


def test_a_setting_without_a_net_time_says_so() -> None:
    case = replace(henon_heiles(True), repeated_run=False, net_time=True)
    one = case.participants[0]
    measured = work_precision._first_run(case, one.label, one.contender, one.settings[0], 0.001)
    measured.rounds = [1e-4, math.nan]
    row = work_precision._row(case, measured, case.truth())
    assert math.isnan(row["seconds"]) and row["rounds"] == ""
    assert row["error"] < 1.0 and row["status"].startswith("Not timed: its steps took no longer")


@dataclass(frozen=True)
class Noted:
    """Notes what it is asked for."""

    asked: list[Any]
    name: str = "noted"
    missing: str = ""

    def run(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Any:
        self.asked.append((duration, dict(setting)))


def test_the_short_run_of_a_net_time_is_one_step() -> None:
    noted, problem = Noted([]), galvi.problems.harmonic_oscillator()
    made = net_time(noted, problem, 2.0, {"step": 0.5, "save_every": 4}, 4)
    assert noted.asked == [(0.5, {"step": 0.5, "save_every": 1})]
    made()
    assert noted.asked[-1] == (2.0, {"step": 0.5, "save_every": 4}) and made.failure == ""
    net_time(noted, problem, 2.0, {"samples": 1, "tolerance": 1e-9}, 4)
    assert noted.asked[-1] == (2e-6, {"samples": 1, "tolerance": 1e-9})


def test_the_cost_of_some_problems_alone_has_their_rows() -> None:
    table = cost_table(quick=True, only=("free rigid body", "elastic pendulum"))
    assert list(table["problem"]) == ["elastic pendulum", "free rigid body", "free rigid body"]
    assert list(table["method"])[1:] != [] and table["seconds_per_step"].gt(0.0).all()
    assert (table["status"] == "").all()
