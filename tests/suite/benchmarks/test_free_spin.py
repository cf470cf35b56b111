"""Long spins: values of MuJoCo's own test, drifts, and a wrong motion that keeps its energy."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from benchmarks.checks.faults import reversed_clock
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
from benchmarks.work_precision.problems.rigid_bodies import MUJOCO_CONTENDERS
from galvi import Problem, Trajectory
from references.mujoco.steps import MUJOCO_EULER, MUJOCO_IMPLICITFAST, MUJOCO_RK4

needs_mujoco = pytest.mark.skipif(bool(MUJOCO_RK4.missing), reason=MUJOCO_RK4.missing or "present")
GALVI = DriftParticipant("galvi", gauss_collocation(4), 0.125)


def box(name: str, joint: str) -> dict[str, Any]:
    participant = next(r for r in ON_BOX if r.label == f"MuJoCo {name}, {joint} joint")
    (row,) = box_rows(participant)
    return row


GAINED, LOST = 0.0868945514, -0.0739917268  # relative energy errors, as in MuJoCo's own test


@needs_mujoco
@pytest.mark.parametrize(
    ("name", "joint", "gained"),
    [
        *(("Euler", joint, GAINED) for joint in ("free", "ball")),
        *((name, "free", LOST) for name in ("implicit", "implicitfast", "discrete")),
        *((name, "ball", GAINED) for name in ("implicitfast", "discrete")),  # damped as Euler's
        ("implicit", "ball", LOST),
    ],
)
def test_the_free_box_gains_or_loses_what_mujoco_s_own_test_sees(
    name: str, joint: str, gained: float
) -> None:
    row = box(name, joint)
    assert row["energy_error"] == pytest.approx(gained, abs=1e-8)
    assert row["momentum_error"] > 0.01 and row["attitude_error"] > 0.1


@needs_mujoco
def test_rk4_keeps_the_box_s_energy_to_ten_digits_and_galvi_to_round_off() -> None:
    assert abs(box("RK4", "free")["energy_error"]) < 1e-9  # 1.7e-10
    (galvi_row,) = box_rows(ON_BOX[0])
    # 4e-16 and 1.3e-15 were measured.
    assert abs(galvi_row["energy_error"]) < 1e-14 and galvi_row["attitude_error"] < 1e-13


def test_every_integrator_spins_and_the_marks_are_1_2_5() -> None:
    assert marks(1000) == [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000] and marks(1) == [1]
    assert marks(30) == [1, 2, 5, 10, 20, 30]
    labels = [participant.label for participant in PARTICIPANTS]
    assert len(set(labels)) == len(labels)
    for chosen, joints in ((PARTICIPANTS, ("free",)), (ON_BOX, ("free", "ball"))):
        for joint in joints:
            assert {
                integrator
                for r in chosen
                for integrator in MUJOCO_CONTENDERS
                if r.contender is integrator
            } == set(MUJOCO_CONTENDERS)
            assert sum(r.joint == joint for r in chosen) == len(MUJOCO_CONTENDERS)


@needs_mujoco
def test_the_energy_of_rk4_drifts_and_galvi_s_and_all_momenta_stay() -> None:
    rk4 = DriftParticipant("RK4", MUJOCO_RK4, 0.02, "free")
    rk4_rows, galvi_rows = (
        pd.DataFrame(body_rows(participant, 200)) for participant in (rk4, GALVI)
    )
    size = rk4_rows.set_index(np.arange(len(rk4_rows)))["energy_error"].abs()
    assert size.iloc[-1] > 5.0 * size.iloc[3] > 1e-13  # 200 and 10 turns: 1.8e-10 and 1.8e-11
    assert (
        galvi_rows["energy_error"].abs().max() < 1e-12
        and galvi_rows["momentum_error"].max() < 1e-14
    )
    assert list(rk4_rows["turn"]) == pytest.approx(marks(200), rel=2e-3)
    assert (
        rk4_rows["attitude_error"].notna().sum() == 1 and rk4_rows["attitude_error"].iloc[-1] > 1e-8
    )


@needs_mujoco
def test_a_run_that_bursts_says_so_and_keeps_what_was_before() -> None:
    burst = pd.DataFrame(body_rows(DriftParticipant("Euler", MUJOCO_EULER, 0.1, "free"), 200))
    assert burst["energy_error"].notna().iloc[0] and burst["energy_error"].isna().iloc[-1]
    assert "unstable" in burst["status"].iloc[-1] and burst["status"].iloc[0] == ""


@dataclass(frozen=True)
class Backwards:
    """galvi on a body that turns the other way, which its energy does not show."""

    name: str = "backwards"
    missing: str = ""

    def run(self, problem: Problem, duration: float, setting: Any) -> Trajectory:
        return GALVI.contender.run(reversed_clock(problem), duration, setting)


def test_a_wrong_motion_keeps_energy_and_stands_out_by_momentum_and_attitude() -> None:
    planted = pd.DataFrame(body_rows(DriftParticipant("planted", Backwards(), 0.125), 5))
    correct = pd.DataFrame(body_rows(GALVI, 5))
    assert planted["energy_error"].abs().max() < 1e-6
    assert planted["momentum_error"].max() > 0.1 and correct["momentum_error"].max() < 1e-14
    assert planted["attitude_error"].iloc[-1] > 0.1 > 1e-6 > correct["attitude_error"].iloc[-1]


def test_without_mujoco_a_row_says_why() -> None:
    @dataclass(frozen=True)
    class Absent:
        name: str = "absent"
        missing: str = "Install it."

    table = free_spin(
        True,
        participants=[DriftParticipant("absent", Absent(), 0.1)],  # type: ignore[arg-type]
        on_box=[GALVI],
    )
    assert list(table) == list(COLUMNS) and list(table["status"]) == ["", "Install it."]
    assert table["energy_error"].isna().tolist() == [False, True]


def test_the_long_form_is_kept_and_not_run_again(tmp_path: Path) -> None:
    messages: list[str] = []
    assert stored(tmp_path, messages.append).empty
    participants = (GALVI, DriftParticipant("fast", MUJOCO_IMPLICITFAST, 0.02, "free"))
    study_parts = parts(tmp_path, messages.append, 20, participants, "feedface")
    assert len(study_parts) == 1 + (not MUJOCO_IMPLICITFAST.missing)
    for part in study_parts:
        assert not part.is_complete()
        part.run(messages.append)
        assert part.is_complete()
    rows = stored(tmp_path, messages.append)
    assert set(rows["commit"]) == {"feedface"} and rows["date"].ne("").all()
    assert list(rows) == list(COLUMNS) and len(rows) == len(study_parts) * len(marks(20))
    assert not any(
        p.is_complete() for p in parts(tmp_path, messages.append, 20, participants, "another")
    )
    assert TURNS < parts(tmp_path, messages.append)[0].turns == 100_000
