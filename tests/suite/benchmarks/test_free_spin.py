"""Long spins: what MuJoCo's own test says, what drifts, and a wrong torque that energy hides."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from benchmarks.studies.free_body_drift import (
    COLUMNS,
    ON_BOX,
    PARTICIPANTS,
    TURNS,
    DriftParticipant,
    body_rows,
    box_rows,
    free_spin,
    marks,
    parts,
    stored,
)
from benchmarks.work_precision.galvi_methods import gauss_collocation
from benchmarks.work_precision.problems.rigid_bodies import MUJOCO
from galvi import Problem, Trajectory
from references.as_trajectory import as_trajectory
from references.mujoco.steps import MUJOCO_EULER, MUJOCO_IMPLICITFAST, MUJOCO_RK4
from references.setting import fixed_steps

needs_mujoco = pytest.mark.skipif(bool(MUJOCO_RK4.missing), reason=MUJOCO_RK4.missing or "present")
OURS = DriftParticipant("galvi", gauss_collocation(4), 0.125)


def box(name: str, joint: str) -> dict[str, Any]:
    participant = next(r for r in ON_BOX if r.label == f"MuJoCo {name}, {joint} joint")
    (row,) = box_rows(participant)
    return row


@needs_mujoco
@pytest.mark.parametrize(
    ("name", "joint", "gained"),
    [
        ("Euler", "free", 0.0868945514),
        ("implicit", "free", -0.0739917268),
        ("implicitfast", "free", -0.0739917268),
        ("discrete", "free", -0.0739917268),
        ("Euler", "ball", 0.0868945514),
        ("implicit", "ball", -0.0739917268),
        ("implicitfast", "ball", 0.0868945514),  # as Euler's, damped on a free joint only
        ("discrete", "ball", 0.0868945514),
    ],
)
def test_the_free_box_gains_or_loses_what_mujoco_s_own_test_sees(
    name: str, joint: str, gained: float
) -> None:
    row = box(name, joint)
    assert row["energy_error"] == pytest.approx(gained, abs=1e-8)
    assert row["momentum_error"] > 0.01 and row["attitude_error"] > 0.1
    assert "4.0.1" not in row["engine"] or row["engine"] == "mujoco 4.0.1"


@needs_mujoco
def test_rk4_keeps_the_box_s_energy_to_ten_digits_and_galvi_to_round_off() -> None:
    assert abs(box("RK4", "free")["energy_error"]) < 1e-9  # 1.7e-10
    (ours,) = box_rows(ON_BOX[0])
    assert abs(ours["energy_error"]) < 1e-14 and ours["attitude_error"] < 1e-13  # 4e-16, 1.3e-15


def test_every_integrator_spins_and_the_marks_are_1_2_5() -> None:
    assert marks(1000) == [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000] and marks(1) == [1]
    assert marks(30) == [1, 2, 5, 10, 20, 30]
    labels = [participant.label for participant in PARTICIPANTS]
    assert len(set(labels)) == len(labels)
    for chosen, joints in ((PARTICIPANTS, ("free",)), (ON_BOX, ("free", "ball"))):
        for joint in joints:
            assert {one for r in chosen for one in MUJOCO if r.contender is one} == set(MUJOCO)
            assert sum(r.joint == joint for r in chosen) == len(MUJOCO)


@needs_mujoco
def test_the_energy_of_rk4_drifts_and_galvi_s_and_all_momenta_stay() -> None:
    rk4 = DriftParticipant("RK4", MUJOCO_RK4, 0.02, "free")
    theirs, ours = (pd.DataFrame(body_rows(one, 200)) for one in (rk4, OURS))
    size = theirs.set_index(np.arange(len(theirs)))["energy_error"].abs()
    assert size.iloc[-1] > 5.0 * size.iloc[3] > 1e-13  # 200 and 10 turns: 1.8e-10 and 1.8e-11
    assert ours["energy_error"].abs().max() < 1e-12 and ours["momentum_error"].max() < 1e-14
    assert list(theirs["turn"]) == pytest.approx(marks(200), rel=2e-3)
    assert theirs["attitude_error"].notna().sum() == 1 and theirs["attitude_error"].iloc[-1] > 1e-8


@needs_mujoco
def test_a_run_that_bursts_says_so_and_keeps_what_was_before() -> None:
    burst = pd.DataFrame(body_rows(DriftParticipant("Euler", MUJOCO_EULER, 0.1, "free"), 200))
    assert burst["energy_error"].notna().iloc[0] and burst["energy_error"].isna().iloc[-1]
    assert "unstable" in burst["status"].iloc[-1] and burst["status"].iloc[0] == ""


@dataclass(frozen=True)
class WrongTorque:
    """Runge and Kutta's method on p' = -(p x w): the gyroscopic torque with its sign wrong."""

    name: str = "wrong torque"
    exact: bool = False
    missing: str = ""

    def supports(self, problem: Problem) -> bool:
        return True

    def run(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Trajectory:
        steps = fixed_steps(duration, setting)
        inverse, h = np.linalg.inv(problem.system.inertia), steps.step

        def slope(y: Any) -> Any:
            R, p = y[:9].reshape(3, 3), y[9:]
            w = inverse @ p
            return np.concatenate([np.cross(R, w).ravel(), -np.cross(p, w)])

        y = np.concatenate([problem.q0.ravel(), problem.p0])
        saved = [y]
        for k in range(1, steps.count + 1):
            a = slope(y)
            b = slope(y + 0.5 * h * a)
            c = slope(y + 0.5 * h * b)
            y = y + h / 6.0 * (a + 2.0 * b + 2.0 * c + slope(y + h * c))
            saved += [y] if k in steps.saved else []
        states = np.array(saved)
        return as_trajectory(
            problem, self.name, steps.times(problem.t0), states[:, :9], p=states[:, 9:],
            counts={"steps": steps.count}, step=h,
        )  # fmt: skip


def test_a_wrong_torque_keeps_energy_and_stands_out_by_momentum_and_attitude() -> None:
    planted = pd.DataFrame(body_rows(DriftParticipant("planted", WrongTorque(), 0.02), 5))
    sound = pd.DataFrame(body_rows(OURS, 5))
    assert planted["energy_error"].abs().max() < 1e-6  # 4e-9: a wrong force conserves its own
    assert planted["momentum_error"].max() > 0.1 and sound["momentum_error"].max() < 1e-14
    assert planted["attitude_error"].iloc[-1] > 0.1 > 1e-6 > sound["attitude_error"].iloc[-1]


def test_without_mujoco_a_row_says_why() -> None:
    @dataclass(frozen=True)
    class Absent:
        name: str = "absent"
        missing: str = "Install it."

    frame = free_spin(True, participants=[DriftParticipant("absent", Absent(), 0.1)], on_box=[OURS])  # type: ignore[arg-type]
    assert list(frame) == list(COLUMNS) and list(frame["status"]) == ["", "Install it."]
    assert frame["energy_error"].isna().tolist() == [False, True]


def test_the_long_form_is_kept_and_not_run_again(tmp_path: Path) -> None:
    said: list[str] = []
    assert stored(tmp_path, said.append).empty
    participants = (OURS, DriftParticipant("fast", MUJOCO_IMPLICITFAST, 0.02, "free"))
    made = parts(tmp_path, said.append, 20, participants, "feedface")
    assert len(made) == 1 + (not MUJOCO_IMPLICITFAST.missing)
    for part in made:
        assert not part.done()
        part.run(said.append)
        assert part.done()
    rows = stored(tmp_path, said.append)
    assert set(rows["commit"]) == {"feedface"} and rows["date"].ne("").all()
    assert list(rows) == list(COLUMNS) and len(rows) == len(made) * len(marks(20))
    assert not any(p.done() for p in parts(tmp_path, said.append, 20, participants, "another"))
    assert TURNS < parts(tmp_path, said.append)[0].turns == 100_000
