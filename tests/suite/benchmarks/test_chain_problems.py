"""Work-precision problems of chains: who takes part, and a wrong weight that is seen."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

import galvi
from benchmarks.work_precision import run as work_precision
from benchmarks.work_precision.problem import ANGLE, Participant, largest_difference
from benchmarks.work_precision.problems.pendulums import double_pendulum, planar_chain
from references.mujoco.steps import MUJOCO_RK4
from references.scipy.lagrangian_ivp import CHAIN_DOP853


@pytest.mark.parametrize("make", [double_pendulum, planar_chain])
def test_everyone_takes_part_and_the_truth_is_the_stored_one(make: Any) -> None:
    for quick in (True, False):
        case = make(quick)
        labels = {one.label for one in case.participants}
        assert {"MuJoCo RK4", "MuJoCo implicit", "SciPy DOP853, chains", "heyoka, chains"} <= labels
        assert {f"galvi degree {s}, Gauss {s}" for s in (4, 8)} <= labels
        assert case.quantity == ANGLE and case.net_time
        (taylor,) = (one.settings for one in case.participants if one.label == "heyoka, chains")
        assert not any("compact_mode" in setting for setting in taylor)
        assert all(one.contender.supports(case.problem) for one in case.participants)
        assert case.truth().error < 1e-15 * np.abs(case.truth().end).max()


@dataclass(frozen=True)
class WrongWeight:
    """A contender on chains whose weight is 1 % too large."""

    contender: Any
    name: str = "galvi, wrong weight"
    missing: str = ""

    def supports(self, problem: galvi.Problem) -> bool:
        return self.contender.supports(problem)

    def run(self, problem: galvi.Problem, duration: float, setting: Any) -> galvi.Trajectory:
        chain = replace(problem.system.function, gravity=1.01 * problem.system.function.gravity)
        heavy = galvi.Lagrangian(chain, galvi.Rn(len(problem.q0)))
        start = galvi.Problem(heavy, problem.q0, problem.v0)
        return self.contender.run(start, duration, setting)


@pytest.mark.slow(
    beside="test_coordinate_problems.py::test_a_wrong_law_stands_out_though_it_conserves_its_own_energy"
)
def test_a_wrong_weight_stands_out_though_it_conserves_its_own_energy() -> None:
    case = planar_chain(True)
    chosen = {"galvi degree 8, Gauss 8", CHAIN_DOP853.name, MUJOCO_RK4.name}
    few = tuple(
        one for one in case.participants if one.label in chosen and not one.contender.missing
    )
    (ours,) = (one for one in few if one.label.startswith("galvi"))
    planted = Participant("galvi, wrong weight", WrongWeight(ours.contender), ours.settings)
    rows = work_precision._study(
        replace(case, participants=(*few, planted), net_time=False),
        0.001,
        lambda sentence: None,
        quick=True,
    )
    wrong = rows["contender"] == "galvi, wrong weight"
    assert rows["error"][~wrong].max() < 1e-6 < 1e-2 < rows["error"][wrong].min()  # 3e-8; 0.10
    energy = galvi.energy(planted.contender.run(case.problem, case.duration, {"step": 0.05}))
    assert np.ptp(energy) < 1e-9  # 2e-11
    assert (rows["quantity"] == ANGLE).all() and rows["seconds"].gt(0.0).all()


def test_the_error_is_the_largest_difference_of_an_entry() -> None:
    assert largest_difference(np.array([1.0, -2.0]), np.array([1.5, 1.0])) == 3.0
    assert np.isnan(largest_difference(np.array([np.nan, 0.0]), np.zeros(2)))
