"""Runs in a clock handed to others, on groups, and with steps of any size."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import galvi
from references.stored.encounters import sitnikov
from tests.properties.clock_problems import CASES, DYNAMICAL, three_bodies
from tests.properties.clock_problems import method as in_clock

FREE = galvi.problems.free_body_se3()


@pytest.mark.slow_cases(but=["Kepler, eccentric anomaly"])
@pytest.mark.parametrize("case", list(CASES))
def test_a_run_becomes_an_ode_result_with_its_own_times(case: str) -> None:
    problem, clock, duration, step = CASES[case]
    run = galvi.integrate(problem, in_clock(4, clock), step, duration=duration)
    found = run.to_scipy()
    assert found.success and np.array_equal(found.t, run.t)
    at = 0.37 * duration
    assert np.max(np.abs(found.sol(at)[: run.q[0].size] - run(at).ravel())) < 1e-14


@pytest.mark.slow_cases("three_bodies")
@pytest.mark.parametrize("make", [three_bodies, sitnikov])
def test_the_end_of_a_run_becomes_a_simulation(make: Any) -> None:
    pytest.importorskip("rebound")
    run = galvi.integrate(make(), in_clock(6, DYNAMICAL), 0.3, duration=3.0)
    sim = run.to_rebound()
    assert sim.t == 3.0
    assert np.array_equal([body.xyz for body in sim.particles], run.q[-1])


def test_what_cannot_be_handed_over_is_refused_by_name(tmp_path: Any) -> None:
    problem, clock, duration, step = CASES["elastic pendulum"]
    run = galvi.integrate(problem, in_clock(4, clock), step, duration=duration)
    with pytest.raises(ValueError, match="point masses"):
        run.to_rebound()
    with pytest.raises(ValueError, match=r"clock are galvi's own; received .*Clock\(upright\)"):
        galvi.save(run, tmp_path / "run.npz")


def along(q: Any) -> Any:
    return 1.0 / (1.5 + 0.5 * q[0, 0])


def called(q: Any) -> Any:
    return along(q) if q[0, 1] < 1e9 else 1.0


@pytest.mark.slow_cases(but=["1e+100-along", "-1e+300-along"])
@pytest.mark.parametrize("function", [along, called])
@pytest.mark.parametrize("step", [3.0, -5.0, 1e3, 1e100, -1e300])
def test_steps_of_any_size_end_in_a_status_and_without_a_warning(
    function: Any, step: float
) -> None:
    chosen = in_clock(2, galvi.Clock(function))
    for more in ({"steps": 5}, {"duration": 1.3 * abs(step)}):
        run = galvi.integrate(FREE, chosen, step, **more)
        assert not run.success and run.failed_step == 1
        assert "units of the clock" in run.outcome.notes[0]
        assert np.isfinite(run.q).all() and np.isfinite(galvi.energy(run)).all()
