"""One step of galvi, from the call to the trajectory: what a caller waits for."""

from __future__ import annotations

from typing import Any

import pytest

import galvi
from benchmarks.contenders import gauss_collocation
from benchmarks.timings.annotate import timed_run
from references.ias15 import IAS15
from references.kepler import KEPLER

KEPLER_STEPS = {4: 0.1, 8: 0.25, 16: 0.75}
PLANET_STEPS = {4: 4.0, 8: 8.0, 16: 32.0}
OUTER_STEPS = {6: 270.0, 8: 540.0, 12: 1080.0, 16: 1440.0}


@pytest.mark.parametrize("degree", KEPLER_STEPS)
def test_a_step_of_the_kepler_problem(benchmark: Any, degree: int) -> None:
    problem, setting = galvi.problems.kepler(0.6), {"step": KEPLER_STEPS[degree]}
    contender = gauss_collocation(degree)
    end = KEPLER.run(problem, setting["step"], {"samples": 1}).q[-1]
    run = timed_run(
        benchmark,
        lambda: contender.run(problem, setting["step"], setting),
        end,
        {"contender": contender.name, **setting},
    )
    assert run.success


@pytest.mark.parametrize("degree", PLANET_STEPS)
def test_a_step_of_the_solar_system(benchmark: Any, degree: int) -> None:
    _time(benchmark, galvi.problems.solar_system(), degree, PLANET_STEPS[degree])


@pytest.mark.parametrize("degree", OUTER_STEPS)
def test_a_step_of_the_outer_solar_system(benchmark: Any, degree: int) -> None:
    _time(benchmark, galvi.problems.outer_solar_system(), degree, OUTER_STEPS[degree])


def _time(benchmark: Any, problem: galvi.Problem, degree: int, step: float) -> None:
    setting = {"step": step}
    contender = gauss_collocation(degree)
    end = IAS15.run(problem, setting["step"], {"samples": 1}).q[-1]
    run = timed_run(
        benchmark,
        lambda: contender.run(problem, setting["step"], setting),
        end,
        {"contender": contender.name, **setting},
    )
    assert run.success
