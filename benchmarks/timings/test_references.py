"""Time each reference on each problem it supports, for about ten revolutions."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import galvi
from benchmarks.timings.annotate import TIMER, annotate, timed
from references import REFERENCES, Contender
from references.closed_forms.kepler import KEPLER
from references.closed_forms.oscillator import OSCILLATOR
from references.closed_forms.pendulum import PENDULUM
from references.closed_forms.top_motion import FREE_TOP, THROWN_BODY
from references.mujoco.accelerations_ivp import MUJOCO_ACCELERATIONS
from references.stored.attitude import STORED_ATTITUDE
from references.stored.lagrangian import STORED_LAGRANGIAN
from references.stored.planets import STORED_TRUTH

PROBLEMS: dict[str, tuple[galvi.Problem, float, Contender | None]] = {
    "oscillator": (galvi.problems.harmonic_oscillator(), 10 * math.tau, OSCILLATOR),
    "kepler": (galvi.problems.kepler(0.6), 10 * math.tau, KEPLER),
    "planar pendulum": (galvi.problems.planar_pendulum(), 60.0, PENDULUM),
    "henon-heiles": (galvi.problems.henon_heiles(), 40.0, STORED_LAGRANGIAN),
    "fpu chain": (galvi.problems.fermi_pasta_ulam_tsingou(), 20.0, STORED_LAGRANGIAN),
    "solar system": (galvi.problems.solar_system(), 1000.0, STORED_TRUTH),
    "solar system without Pluto": (
        galvi.problems.solar_system(pluto=False),
        730.5,
        STORED_TRUTH,
    ),
    "outer solar system": (galvi.problems.outer_solar_system(), 36_525.0, STORED_TRUTH),
    "applegate": (galvi.problems.applegate(), 100.0, STORED_TRUTH),
    "free rigid body": (galvi.problems.free_rigid_body(), 20.0, FREE_TOP),
    "free box": (galvi.problems.free_box(), 20.0, FREE_TOP),
    "3D pendulum": (galvi.problems.pendulum_3d(), 10.0, STORED_ATTITUDE),
    "heavy top": (galvi.problems.heavy_top(), 10.0, STORED_ATTITUDE),
    "spherical pendulum": (galvi.problems.spherical_pendulum(), 10.0, None),
    "body on SE(3)": (galvi.problems.free_body_se3(), 10.0, THROWN_BODY),
    "elastic pendulum": (galvi.problems.elastic_pendulum(), 5.0, STORED_LAGRANGIAN),
    "polar Kepler": (galvi.problems.kepler_polar(), 20.0, None),
    "double pendulum": (galvi.problems.double_pendulum(), 1.0, None),
    "planar chain": (galvi.problems.planar_chain(), 1.0, None),
    "brownout": (galvi.problems.brownout(), 2.0, None),
    "skew arm": (galvi.problems.skew_arm(), 1.0, MUJOCO_ACCELERATIONS),
    "floating arm": (galvi.problems.skew_arm(floating=True), 5.0, MUJOCO_ACCELERATIONS),
}
STEPS = 1000
PAIRS = [
    pytest.param(contender, name, id=f"{contender.name}: {name}")
    for contender in REFERENCES
    for name, (problem, _, _) in PROBLEMS.items()
    if contender.missing or contender.supports(problem)
]


def setting_of(contender: Contender, problem: galvi.Problem, duration: float) -> dict[str, Any]:
    """One sample for adaptive contenders; STEPS equal steps for those that refuse samples.

    Skips the test, with the reason, when neither is accepted for this duration.
    """
    settings = ({"samples": 1}, {"step": duration / STEPS, "save_every": STEPS})
    refusal = ""
    for setting in settings:
        try:
            contender.run(problem, duration, setting)
        except ValueError as error:
            refusal = refusal or str(error)
        else:
            return setting
    pytest.skip(f"{contender.name}: {refusal}")


@pytest.mark.benchmark(timer=TIMER)
@pytest.mark.parametrize(("contender", "name"), PAIRS)
def test_a_reference(benchmark: Any, contender: Contender, name: str) -> None:
    problem, duration, truth = PROBLEMS[name]
    if contender.missing:
        pytest.skip(contender.missing)
    setting = setting_of(contender, problem, duration)
    run = timed(benchmark, lambda: contender.run(problem, duration, setting))
    error = None
    if truth is not None and run.success:
        end = truth.run(problem, duration, {"samples": 1}).q[-1]
        error = float(np.max(np.abs(run.q[-1] - end)))
    settings = {"contender": contender.name, "duration": duration, **setting}
    if truth is not None:
        settings["truth"] = truth.name
    annotate(
        benchmark,
        problem=problem.name,
        error=error,
        counts=run.counts,
        status=run.status,
        settings=settings,
        kind="reference",
    )
