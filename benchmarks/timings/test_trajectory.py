"""Long runs of galvi: problems as H ran them, and at the steps one would choose."""

from __future__ import annotations

import math
from typing import Any

import pytest

import galvi
from benchmarks.contenders import Variational, gauss_collocation
from benchmarks.timings.annotate import timed_run
from references import Contender
from references.ias15 import IAS15
from references.kepler import KEPLER
from references.oscillator import OSCILLATOR
from references.truth import STORED_TRUTH


def papers(n: int) -> Variational:
    """H's choice: n basis functions, Gauss with 2 n points."""
    return Variational(galvi.Galerkin(galvi.Polynomials(n - 1), galvi.gauss(2 * n)))


CASES: dict[str, tuple[galvi.Problem, Variational, float, int, Contender]] = {
    "oscillator as in H": (galvi.problems.harmonic_oscillator(), papers(24), 20.0, 100, OSCILLATOR),
    "kepler as in H": (galvi.problems.kepler(0.6), papers(32), 2.0, 100, KEPLER),
    "solar system as in H": (galvi.problems.solar_system(), papers(25), 100.0, 100, IAS15),
    "outer solar system as in H": (
        galvi.problems.outer_solar_system(), papers(25), 1825.0, 100, IAS15,
    ),
    "kepler, degree 8": (
        galvi.problems.kepler(0.6), gauss_collocation(8), math.tau / 24.5, 2450, KEPLER,
    ),
    "solar system, degree 8": (
        galvi.problems.solar_system(), gauss_collocation(8), 8.0, 1000, IAS15,
    ),
    "solar system, degree 16": (
        galvi.problems.solar_system(), gauss_collocation(16), 32.0, 250, IAS15,
    ),
    "solar system, degree 12": (
        galvi.problems.solar_system(), gauss_collocation(12), 16.0, 625, STORED_TRUTH,
    ),
    "outer solar system, degree 8": (
        galvi.problems.outer_solar_system(), gauss_collocation(8), 365.25, 1000, STORED_TRUTH,
    ),
    "outer solar system, degree 12": (
        galvi.problems.outer_solar_system(), gauss_collocation(12), 730.5, 500, STORED_TRUTH,
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", CASES)
def test_a_trajectory(benchmark: Any, case: str) -> None:
    problem, contender, step, steps, truth = CASES[case]
    setting = {"step": step, "save_every": steps}
    end = truth.run(problem, step * steps, {"samples": 1}).q[-1]
    run = timed_run(
        benchmark,
        lambda: contender.run(problem, step * steps, setting),
        end,
        {"contender": contender.name, "duration": step * steps, "truth": truth.name, **setting},
    )
    assert run.success
