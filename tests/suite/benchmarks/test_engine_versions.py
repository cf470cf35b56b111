"""Versions of MuJoCo are compared by their motions; one that cannot be installed says why."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from benchmarks.applications.releases.requirements import installed
from benchmarks.statistics.convergence_fits import algebraic
from benchmarks.store.isolated_environment import EnvironmentUnavailable, output_of
from benchmarks.studies import engine_versions
from benchmarks.studies.engine_versions import COLUMNS, STEPS, parts, rows_of, stored
from references.mujoco.own_model import NO_INTEGRATOR
from references.mujoco.steps import MUJOCO_RK4

needs_mujoco = pytest.mark.skipif(bool(MUJOCO_RK4.missing), reason=MUJOCO_RK4.missing or "present")
OLD = "3.6.0"


@pytest.fixture(scope="module")
def answers():
    """The answers of the installed version of MuJoCo."""
    return engine_versions.answers()


def order(table: pd.DataFrame, joint: str, integrator: str) -> float:
    rows = table[(table["joint"] == joint) & (table["integrator"] == integrator)]
    assert list(rows["step"]) == list(STEPS)
    return algebraic(list(rows["step"]), list(rows["attitude_error"]), floor=1e-12).rate


@pytest.mark.slow_cases("ball")
@needs_mujoco
@pytest.mark.parametrize("joint", ["ball", "free"])
def test_the_installed_version_turns_bodies_with_order_4_by_rk4_and_1_by_the_others(answers, joint):
    table = pd.DataFrame(rows_of(answers))
    assert set(table["status"]) == {""}
    assert order(table, joint, "RK4") == pytest.approx(4.0, abs=0.05)  # 4.001
    for integrator in ("Euler", "implicit", "implicitfast", "discrete"):
        assert order(table, joint, integrator) == pytest.approx(1.0, abs=0.02)  # 0.998


@needs_mujoco
def test_a_wrong_attitude_is_seen_though_its_energy_is_right_and_a_failure_is_a_status(answers):
    motions = list(answers["ball"].motions)
    first = len(STEPS)  # RK4 at the largest step
    correct = motions[first]
    positions = correct.positions[:, [1, 2, 3, 0]]
    motions[first] = replace(correct, positions=positions)
    ended = np.full_like(correct.velocities, np.nan)
    motions[first + 1] = replace(correct, velocities=ended, failure="MuJoCo warned.")
    motions[first + 2] = replace(correct, failure=f"{NO_INTEGRATOR} RK4.")
    before = rows_of({"ball": answers["ball"]})
    after = rows_of({"ball": replace(answers["ball"], motions=tuple(motions))})
    assert len(after) == len(before) - 1
    good, wrong, failed = before[first], after[first], after[first + 1]
    assert good["attitude_error"] < 1e-5 and wrong["attitude_error"] > 0.1
    assert good["energy_error"] == wrong["energy_error"] < 1e-7
    assert np.isnan(failed["attitude_error"]) and failed["status"] == "MuJoCo warned."


def test_a_version_that_is_absent_is_a_row_in_the_short_form(monkeypatch):
    monkeypatch.setitem(sys.modules, "mujoco", None)
    table = engine_versions.engine_versions()
    assert len(table) == 1 and list(table) == list(COLUMNS)
    assert "Install mujoco-core" in table["status"].iloc[0]


@contextmanager
def without_old_version(package: str, version: str, folder: Path) -> Iterator[Path]:
    """A stand-in for `interpreter`: this Python for all versions but OLD, which it lacks."""
    if version == OLD:
        raise EnvironmentUnavailable("No matching distribution found.")
    yield Path(sys.executable)


@pytest.mark.slow(beside="test_a_version_that_is_absent_is_a_row_in_the_short_form")
@needs_mujoco
def test_a_study_keeps_its_rows_and_tries_again_what_could_not_be_installed(tmp_path, monkeypatch):
    monkeypatch.setattr(engine_versions, "interpreter", without_old_version)
    monkeypatch.setattr(engine_versions, "USUAL_RELEASES", {"mujoco": (OLD,)})
    messages: list[str] = []
    assert stored(tmp_path, messages.append).empty
    for part in parts(tmp_path, messages.append):
        assert not part.is_complete()
        part.run(messages.append)
    assert [part.is_complete() for part in parts(tmp_path, messages.append)] == [False, True]
    rows = stored(tmp_path, messages.append)
    assert "mujoco 3.6.0: No matching distribution found." in messages
    assert rows["status"].iloc[0] == "No matching distribution found."
    assert rows["engine"].iloc[-1] == f"mujoco-core {installed('mujoco')}"
    assert len(rows) == 1 + 3 * 5 * len(STEPS) and rows["commit"].ne("").all()
    assert list(rows) == list(COLUMNS)
    monkeypatch.setattr(engine_versions, "_digest", lambda: "ffffffff")  # the digest of other runs
    assert stored(tmp_path, messages.append).empty


def test_the_reason_has_no_addresses_and_no_folders():
    text = (
        "WARNING: retrying\nERROR: nothing at https://example.org/simple/x/ for /some/where/y==1\n"
    )
    command = [sys.executable, "-c", f"import sys; sys.exit({text!r})"]
    with pytest.raises(EnvironmentUnavailable, match=r"^nothing at \.\.\. for \.\.\.$"):
        output_of(command)
    with pytest.raises(EnvironmentUnavailable, match="FileNotFoundError"):
        output_of(["no-such-program"])
    assert output_of([sys.executable, "-c", "print(input())"], "heard") == "heard\n"


@pytest.mark.slow(
    beside="test_the_installed_version_turns_bodies_with_order_4_by_rk4_and_1_by_the_others"
)
def test_rk4_turned_bodies_with_order_2_before_version_4(tmp_path):
    (part,) = parts(tmp_path, print, ["3.17.0"])
    part.run(print)
    table = part.files.read(part.name)
    if not part.is_complete():
        pytest.skip(table["status"].iloc[0])
    assert order(table, "ball", "RK4") == pytest.approx(2.0, abs=0.01)
    assert not list(tmp_path.rglob("pyvenv.cfg"))
