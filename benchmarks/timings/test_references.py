"""Each reference on a problem it supports: ten revolutions, or so many of the fastest planet."""

from __future__ import annotations

import math
from typing import Any

import pytest

import galvi
from benchmarks.timings.annotate import timed_run
from references import REFERENCES, Contender
from references.kepler import KEPLER
from references.oscillator import OSCILLATOR
from references.truth import STORED_TRUTH

PROBLEMS: dict[str, tuple[galvi.Problem, float, Contender]] = {
    "oscillator": (galvi.problems.harmonic_oscillator(), 10 * math.tau, OSCILLATOR),
    "kepler": (galvi.problems.kepler(0.6), 10 * math.tau, KEPLER),
    "solar system": (galvi.problems.solar_system(), 1000.0, STORED_TRUTH),
    "solar system without Pluto": (
        galvi.problems.solar_system(pluto=False), 730.5, STORED_TRUTH,
    ),
    "outer solar system": (galvi.problems.outer_solar_system(), 36_525.0, STORED_TRUTH),
}  # fmt: skip
STEPS = 1000


def setting_of(contender: Contender, problem: galvi.Problem, duration: float) -> dict[str, Any]:
    """One sample for what chooses its own steps; STEPS equal steps for what refuses that.

    Skips the test, with the reason, when it takes neither for this duration.
    """
    settings = ({"samples": 1}, {"step": duration / STEPS, "save_every": STEPS})
    refused = ""
    for setting in settings:
        try:
            contender.run(problem, duration, setting)
        except ValueError as error:
            refused = refused or str(error)
        else:
            return setting
    pytest.skip(f"{contender.name}: {refused}")


@pytest.mark.parametrize("problem_name", PROBLEMS)
@pytest.mark.parametrize("contender", REFERENCES, ids=lambda contender: contender.name)
def test_a_reference(benchmark: Any, contender: Contender, problem_name: str) -> None:
    problem, duration, truth = PROBLEMS[problem_name]
    if contender.missing:
        pytest.skip(contender.missing)
    if not contender.supports(problem):
        pytest.skip(f"{contender.name} does not solve the {problem.name}")
    setting = setting_of(contender, problem, duration)
    end = truth.run(problem, duration, {"samples": 1}).q[-1]
    timed_run(
        benchmark,
        lambda: contender.run(problem, duration, setting),
        end,
        {"contender": contender.name, "duration": duration, "truth": truth.name, **setting},
    )
