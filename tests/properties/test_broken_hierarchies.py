"""Steps of a moving frame that are done in the inertial one, where bodies pass each other."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import galvi
from galvi.run.in_frame import engine, inertial

MASSES = [1.0, 1e-2, 1e-2]
CROSSING = galvi.Problem(
    galvi.NBody(MASSES),
    [[0.0, 0.0], [1.0, 0.0], [-1.1, 0.15]],
    [[0.0, 0.0], [0.0, 1.0], [0.02, -0.95]],
)
MEETING = galvi.Problem(
    galvi.NBody(MASSES),
    [[0.0, 0.0], [1.0, 0.0], [-1.0, 0.0]],
    [[0.0, 0.0], [0.0, 1.0], [0.0, 1.0]],
)
SAID = " of {} steps were done in the inertial frame, in parts"


def method(s: int, **given: Any) -> galvi.Galerkin:
    return galvi.Galerkin(galvi.Polynomials(s), galvi.gauss(s), chart=galvi.KeplerFrame(**given))


def test_a_passage_is_done_in_the_inertial_frame_and_counted() -> None:
    plain = galvi.Galerkin(galvi.Polynomials(12), galvi.gauss(12))
    fine = galvi.integrate(CROSSING, plain, 1e-2, 4_000)
    for h, bound in ((0.4, 1e-9), (-0.4, 1e-9), (0.1, 1e-6)):  # 5e-12, 2e-8
        run = galvi.integrate(CROSSING, method(8), h, duration=40.0)
        away = run.counts["inertial_steps"]
        assert run.success and f"{away}{SAID.format(run.counts['steps'])}" in run.status
        assert 0 < away < 0.2 * run.counts["steps"]
        energies = galvi.energy(run)
        assert np.ptp(energies) < 1e-12 * abs(energies[0])  # 2e-13
        turning = galvi.momentum_map(run)
        assert np.max(np.abs(turning - turning[0])) < 1e-13
        if h > 0.0:
            assert np.max(np.abs(run.q[-1] - fine.q[-1])) < bound
    calm = galvi.integrate(CROSSING, method(8), 0.02, 200)
    assert "inertial_steps" not in calm.counts and calm.status == "Completed."


@pytest.mark.slow_cases("-0.4")
@pytest.mark.parametrize("h", [0.4, -0.4])
def test_such_a_run_can_be_saved_continued_and_thinned_to_the_bit(h: float, tmp_path: Path) -> None:
    whole = galvi.integrate(CROSSING, method(8), h, 90)
    moved = np.flatnonzero(np.isnan(whole.curves.coefficients[:, -1, -1]))
    assert len(moved) == whole.counts["inertial_steps"] > 0
    for cut in {int(moved[0]), int(moved[0]) + 1, 31}:
        part = galvi.integrate(CROSSING, method(8), h, cut)
        galvi.save(part, tmp_path / "run.npz")
        rest = galvi.resume(galvi.load(tmp_path / "run.npz"), 90 - cut)
        assert np.array_equal(rest.q, whole.q[cut:]) and np.array_equal(rest.p, whole.p[cut:])
        for name in ("bases", "coefficients"):
            one, other = getattr(rest.curves, name), getattr(whole.curves, name)[cut:]
            assert np.array_equal(one, other, equal_nan=True)
    thin = galvi.integrate(CROSSING, method(8), h, 90, save_every=7)
    assert np.array_equal(thin.q[:-1], whole.q[::7]) and np.array_equal(thin.q[-1], whole.q[-1])
    assert thin.counts == whole.counts
    times = np.sort(np.append(np.linspace(0.0, 90 * h, 173), moved * h + 0.3 * h))
    assert np.array_equal(thin(times), whole(times))
    galvi.save(whole, tmp_path / "whole.npz")
    loaded = galvi.load(tmp_path / "whole.npz")
    assert np.array_equal(loaded(times), whole(times))
    assert np.array_equal(thin.velocity(times), loaded.velocity(times))


def test_curves_follow_the_motion_through_the_inertial_frame() -> None:
    h = 0.4
    run = galvi.integrate(CROSSING, method(8), h, 90)
    assert np.allclose(run(run.t), run.q, rtol=0.0, atol=1e-13)
    k = int(np.flatnonzero(np.isnan(run.curves.coefficients[:, -1, -1]))[0])
    times = np.linspace(k * h, (k + 1) * h, 23)
    begin = galvi.Problem(CROSSING.system, run.q[k], run.v[k], float(run.t[k]))
    plain = galvi.Galerkin(galvi.Polynomials(16), galvi.gauss(16))
    true = galvi.integrate(begin, plain, h / 16, 16)
    assert np.max(np.abs(run(times) - true(times))) < 1e-10
    assert np.max(np.abs(run.velocity(times)[:-1] - true.velocity(times)[:-1])) < 1e-8


def test_without_it_the_run_ends_and_names_the_bodies(monkeypatch: pytest.MonkeyPatch) -> None:
    """A fallback that never agrees with itself is the planted fault."""
    monkeypatch.setattr(inertial, "SAME", -1.0)
    run = galvi.integrate(CROSSING, method(8), 0.4, duration=40.0)
    assert not run.success and "bodies 1 and 2 pass" in run.status
    monkeypatch.setattr(inertial, "SAME", 1e-12)
    monkeypatch.setattr(inertial, "PARTS", (1, 1))  # so that parts always agree
    wrong = galvi.integrate(CROSSING, method(8), 1.0, duration=40.0)
    assert not wrong.success or np.ptp(galvi.energy(wrong)) > 1e-11  # 6e-13 otherwise


def test_bodies_that_meet_end_the_run_with_their_names() -> None:
    for h in (0.02, 0.1, 0.4):
        run = galvi.integrate(MEETING, method(8), h, duration=40.0)
        assert not run.success and run.failed_step is not None
        assert run.status.startswith(f"Stopped at step {run.failed_step} of ")
        assert "Kepler frame" in run.status and "bodies 1 and 2 " in run.status
        assert np.all(np.isnan(run.q[run.failed_step :]))
        assert np.all(np.isfinite(run.q[: run.failed_step]))
        last = run.checkpoint.state[0, :6].reshape(3, 2)
        assert np.array_equal(last, run.q[run.failed_step - 1])
        thin = galvi.integrate(MEETING, method(8), h, duration=40.0, save_every=1_000)
        assert thin.failed_step == run.failed_step and thin.status == run.status


def test_a_frame_that_never_applies_is_not_replaced() -> None:
    planets = galvi.problems.solar_system(pluto=False)
    run = galvi.integrate(planets, method(8), 130.0, 10)
    assert not run.success and run.failed_step == 1 and "inertial_steps" not in run.counts
    assert engine.IN_FRAME.in_other_way[0] == "inertial_steps"
