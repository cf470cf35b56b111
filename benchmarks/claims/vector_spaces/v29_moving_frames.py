"""V29: Gauss collocation in moving frames: orders, forms, momenta and energies."""

from __future__ import annotations

from typing import Any

import numpy as np

import galvi
from benchmarks.claims.kit import (
    Array,
    Fault,
    MakeMethod,
    Problem,
    Report,
    collocation,
    convergence_fits,
)
from benchmarks.measures.symplectic_form import canonical_defect, map_derivative
from references.scipy.ivp import DOP853
from references.stored.planets import STORED_TRUTH

STARS = Problem(
    galvi.NBody(np.ones(3)),
    np.array([[-0.05, 0.0], [0.95, 0.0], [-0.45, 3.5]]),
    np.array([[0.0, -0.7], [0.0, 0.7], [-0.9, 0.0]]),
    name="three equal masses, two of them close",
)
MOVED = "Kepler frame, moved nodes"  # nodes move with the start, unlike those of a difference
FRAMES: dict[str, tuple[Problem, Any, float, float]] = {  # problem, frame, longest step, T
    "harmonic frame": (
        galvi.problems.fermi_pasta_ulam_tsingou(masses=4, alpha=0.4, beta=0.3),
        galvi.HarmonicFrame(),
        0.4,
        4.8,
    ),
    "Kepler frame": (STARS, galvi.KeplerFrame(even=True), 0.3, 3.0),
    MOVED: (STARS, galvi.KeplerFrame(), 0.15, 3.0),
}
TEN_MILLENNIA_DAYS = 3_652_500.0  # 10,000 years in days
ENERGY = "error of the energy"


def measure(make_method: MakeMethod, quick: bool, report: Report) -> dict[str, Any]:
    """Orders and defects in each frame; momenta and energies of the outer planets."""
    numbers: dict[str, Any] = {}
    for name, (problem, chart, longest, duration) in FRAMES.items():
        report(name)
        truth = DOP853.run(problem, duration, {"samples": 1, "tolerance": 1e-13}).q[-1]
        counts = [round(duration / (longest * share)) for share in (1.0, 0.8, 0.625, 0.5)]
        for stages in (2, 3):
            method = collocation(make_method, stages, chart)
            ends = [galvi.integrate(problem, method, duration / k, k).q[-1] for k in counts]
            order = -convergence_fits.slope(counts, [np.max(abs(end - truth)) for end in ends])
            numbers[f"order of the error at the end, {name}, {stages} stages"] = order
        exact = galvi.step_derivative(problem, method, longest)
        DF = map_derivative(problem, method, longest)
        numbers[f"defect, from the step's exact derivative, {name}"] = canonical_defect(exact)
        numbers[f"defect of DF^T J DF = J, {name}"] = canonical_defect(DF)
        if name != MOVED:
            numbers[f"DF against central differences, {name}"] = np.max(abs(exact - DF))
    report("planets")
    spring = Problem(galvi.Canonical(1.0, galvi.LinearSpring(1e4)), np.ones(1), np.zeros(1))
    run = galvi.integrate(spring, collocation(make_method, 1, galvi.HarmonicFrame()), 1.0, 50)
    method = collocation(make_method, 8, galvi.KeplerFrame())
    two_passes = collocation(make_method, 8, galvi.KeplerFrame(passes=2))
    numbers |= planets(method, quick)
    two, many = planets(two_passes, quick)[ENERGY], numbers[ENERGY]
    return numbers | {
        "error after 50 steps of h omega = 100": np.max(abs(run.q[:, 0] - np.cos(100.0 * run.t))),
        f"{ENERGY}, over that of converged passes, two passes": two / many if many else np.nan,
        "root mean square of the energy's error": noise(method, quick),
    }


def planets(method: Any, quick: bool) -> dict[str, Any]:
    """Relative changes of energy and momenta of the outer planets over 10,000 years, 1000 in the
    quick form, at ten times; and the largest error of a coordinate at the end [au]."""
    problem, duration = (
        galvi.problems.outer_solar_system(),
        TEN_MILLENNIA_DAYS / 10 if quick else TEN_MILLENNIA_DAYS,
    )
    parts = round(duration / 400.0 / 10)
    run = galvi.integrate(problem, method, duration / (10 * parts), 10 * parts, save_every=parts)
    truth = STORED_TRUTH.run(problem, duration, {"samples": 1}).q[-1]
    energies, linear, angular = (
        galvi.energy(run),
        galvi.linear_momentum(run),
        galvi.momentum_map(run),
    )
    turning = np.max(np.linalg.norm(angular, axis=-1))
    return {
        ENERGY: np.max(abs(energies / energies[0] - 1.0)),
        "change of the linear momentum": np.max(abs(linear - linear[0])) / np.max(abs(run.p)),
        "change of the angular momentum": np.max(abs(angular - angular[0])) / turning,
        "error of the place at the end": np.max(abs(run.q[-1] - truth)),
    }


def noise(method: Any, quick: bool) -> Any:
    """The root mean square, over starts that differ by 1e-9, of the energy's relative error at the
    end."""
    problem, random = galvi.problems.outer_solar_system(), np.random.default_rng(5)
    starts, steps = (
        (2, round(TEN_MILLENNIA_DAYS / 300.0))
        if quick
        else (8, round(10.0 * TEN_MILLENNIA_DAYS / 300.0))
    )
    errors = []
    for _ in range(starts):
        nearby = problem.q0 * (1.0 + 1e-9 * random.normal(size=problem.q0.shape))
        start = Problem(problem.system, nearby, problem.v0)
        run = galvi.integrate(start, method, 300.0, steps, save_every=steps)
        errors.append(galvi.energy(run)[1] / galvi.energy(run)[0] - 1.0)
    return np.sqrt(np.mean(np.square(errors)))


def sheared(DF: Array) -> Array:
    """DF after a shear of the state; since the shear is symplectic, only differences can detect
    it."""
    return DF @ (np.eye(len(DF)) + 1e-8 * np.eye(len(DF), k=len(DF) // 2))


FAULTS = {
    "a state sheared before the step": Fault(
        wrong={"galvi.step_derivative": lambda original: lambda *step: sheared(original(*step))}
    )
}
