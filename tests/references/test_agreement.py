"""References against closed forms and each other, and their refusals and failures."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

import galvi
from references import REFERENCES, Contender, reference
from references.closed_forms.kepler import KEPLER
from references.closed_forms.oscillator import OSCILLATOR
from references.heyoka import taylor as heyoka_taylor
from references.heyoka.taylor import HEYOKA
from references.rebound import bulirsch_stoer, leapfrog, saba, whfast, whfast512
from references.rebound.bulirsch_stoer import BULIRSCH_STOER
from references.rebound.ias15 import IAS15
from references.rebound.whfast import WHFAST
from references.scipy.ivp import DOP853, ODE45, TIGHT
from references.setting import fixed_steps, sample_times
from references.textbook.euler import EXPLICIT_EULER, STORMER_VERLET, SYMPLECTIC_EULER
from references.textbook.fourth_order import FOREST_RUTH, RK4
from references.textbook.implicit_euler import IMPLICIT_EULER

# name: setting of a run of duration 1, tolerance on the position; measured errors in comments
SETTINGS: Mapping[str, tuple[dict[str, Any], float]] = {
    "oscillator, closed form": ({}, 1e-15),
    "Kepler, closed form": ({}, 1e-15),
    "explicit Euler": ({"step": 1e-4}, 4e-4),  # 2e-4
    "implicit Euler": ({"step": 1e-3}, 4e-3),  # 2e-3
    "symplectic Euler": ({"step": 1e-4}, 4e-4),  # 1e-4
    "semi-implicit Euler": ({"step": 1e-4}, 4e-4),  # 1e-4
    "Stormer-Verlet": ({"step": 1e-4}, 1e-8),  # 5e-9
    "Forest-Ruth": ({"step": 1e-2}, 1e-7),  # 2e-8
    "RK4": ({"step": 1e-2}, 1e-7),  # 1e-9
    "SciPy RK45 (ode45)": ({"tolerance": 1e-9}, 1e-7),  # 4e-9
    "SciPy DOP853": (dict(TIGHT), 1e-13),  # 2e-14
    "SciPy Radau": ({"tolerance": 1e-10}, 1e-11),  # 8e-14
    "REBOUND IAS15": ({}, 1e-14),  # 1e-16
    "REBOUND BS": (dict(bulirsch_stoer.BEST), 1e-12),  # 1e-14
    "REBOUND WHFast": ({"step": 0.1, **whfast.BEST}, 1e-13),  # 5e-15
    "REBOUND WHFast512": ({"step": 0.1, **whfast512.BEST}, 1e-13),  # 5e-15
    "REBOUND SABA": ({"step": 0.1, **saba.BEST}, 1e-13),  # 8e-16
    "REBOUND MERCURIUS": ({"step": 1e-4}, 1e-11),  # 1e-12
    "REBOUND TRACE": ({"step": 1e-4}, 1e-11),  # 1e-12
    "REBOUND leapfrog": ({"step": 0.005, **leapfrog.BEST}, 1e-12),  # 4e-15
    "heyoka": ({**heyoka_taylor.BEST, "compact_mode": True}, 1e-14),  # 1e-16
    "heyoka, quadruple precision": ({}, 1e-15),  # 0
    "heyoka, Lagrangians": ({**heyoka_taylor.BEST, "compact_mode": True}, 1e-14),
    "heyoka, Lagrangians, quadruple precision": ({}, 1e-15),
}


PRESENT = [contender for contender in REFERENCES if not contender.missing]
SOUND = [c for c in (STORMER_VERLET, DOP853, IAS15, WHFAST) if not c.missing]


def disagreement(contender: Contender, problem: galvi.Problem) -> float:
    """Largest error of a coordinate at the end, over the tolerance of the contender's name."""
    truth = next(c for c in (OSCILLATOR, KEPLER) if c.supports(problem))
    setting, tolerance = SETTINGS[contender.name]
    run = contender.run(problem, 1.0, setting)
    assert run.success
    return float(np.abs(run.q[-1] - truth.run(problem, 1.0, {}).q[-1]).max()) / tolerance


PROBLEMS = {
    "oscillator": galvi.problems.harmonic_oscillator(),
    "orbit": galvi.problems.kepler(0.3),
    "orbit in space": galvi.Problem(
        galvi.Canonical(2.0, galvi.CentralForce(2.6)), [0.5, -1.0, 0.3], [0.8, 0.2, -0.5]
    ),
    "two bodies, the light one first": galvi.Problem(
        galvi.NBody([1e-3, 0.9], G=1.2),
        [[1.0, 0.2, 0.0], [0.0, 0.1, 0.0]],
        [[0, 0.9, 0.1], [0, 0, 0]],
    ),
}


SUPPORTED = [(c, name) for c in PRESENT for name, p in PROBLEMS.items() if c.supports(p)]


@pytest.mark.slow_cases(
    "REBOUND MERCURIUS-orbit",
    "REBOUND MERCURIUS-orbit in space",
    "REBOUND MERCURIUS-two bodies, the light one first",
    "REBOUND TRACE-orbit",
    "REBOUND TRACE-orbit in space",
    "REBOUND TRACE-two bodies, the light one first",
)
@pytest.mark.parametrize(
    ("contender", "name"), SUPPORTED, ids=[f"{c.name}-{name}" for c, name in SUPPORTED]
)
def test_every_contender_finds_the_closed_form(contender, name):
    assert disagreement(contender, PROBLEMS[name]) <= 1.0


@dataclass(frozen=True)
class ReversedTime:
    """Deliberately broken: solves for the start with its velocity reversed, then hides that."""

    inner: Contender

    @property
    def name(self) -> str:
        return self.inner.name

    def run(self, problem, duration, setting):
        start = galvi.Problem(problem.system, problem.q0, -problem.v0)
        run = self.inner.run(start, duration, setting)
        return galvi.Trajectory(problem=problem, t=run.t, q=run.q, p=-run.p)


@pytest.mark.parametrize("contender", SOUND, ids=lambda c: c.name)
def test_a_contender_with_time_reversed_keeps_the_energy_and_is_caught(contender):
    problem = PROBLEMS["orbit"]
    broken = ReversedTime(contender)
    run = broken.run(problem, 1.0, SETTINGS[contender.name][0])
    np.testing.assert_allclose(galvi.energy(run), galvi.energy(run)[0], rtol=1e-7)
    assert disagreement(broken, problem) > 1e6


def test_scipy_with_defaults_is_worse_than_tight():
    problem, truth = PROBLEMS["orbit"], KEPLER.run(PROBLEMS["orbit"], 6.0, {"samples": 3})
    loose = np.abs(ODE45.run(problem, 6.0, {"samples": 3}).q - truth.q).max()
    tight = np.abs(DOP853.run(problem, 6.0, {"samples": 3, **TIGHT}).q - truth.q).max()
    assert loose > 1e-3  # 4e-2: what ode45 gives a user who sets nothing
    assert tight < 1e-11  # 6e-13
    assert "rtol=0.001 atol=1e-06" in ODE45.run(problem, 6.0, {}).method


@pytest.mark.slow_cases("2")
@pytest.mark.parametrize("dimension", [2, 3])
def test_scipy_has_forces_of_point_masses(dimension):
    q, v = np.zeros((2, dimension)), np.zeros((2, dimension))
    q[1, 0], v[1, 1] = 1.0, 0.9
    forces = galvi.Relativity(20.0, 0, "potential"), galvi.PowerLaw(0, 1e-3, -2.5)
    problem = galvi.Problem(galvi.NBody([1.0, 1e-3], 1.0, forces), q, v)
    method = galvi.Galerkin(galvi.Polynomials(12), galvi.gauss(12))
    by_galvi = galvi.integrate(problem, method, 0.1, 60).q[-1]
    by_scipy = DOP853.run(problem, 6.0, {"samples": 3, **TIGHT}).q[-1]
    assert np.abs(by_scipy - by_galvi).max() < 1e-11  # 2e-12; without the forces 0.1


@pytest.mark.parametrize(
    "gradient", [lambda q: -np.exp(20 * q), lambda q: q if q[0] > -0.5 else q * np.nan]
)
def test_scipy_that_cannot_go_on_says_so_and_does_not_hang(gradient):
    system = galvi.Canonical(1.0, lambda q: 0.0, gradient, check=False)
    start = [0.0], [1.0 if gradient(np.ones(1))[0] < 0.0 else -1.0]
    run = DOP853.run(galvi.Problem(system, *start), 5.0, {"samples": 50})
    assert not run.success and "SciPy gave up before sample" in run.status
    assert 0 < run.failed_step < 50
    assert np.all(np.isfinite(run.q[: run.failed_step]))
    assert np.all(np.isnan(run.q[run.failed_step :]))


def test_default_tolerances_that_are_no_truth_say_so():
    for name, problem in (
        ("SciPy DOP853, chains", galvi.problems.double_pendulum()),
        ("SciPy DOP853", PROBLEMS["oscillator"]),
        ("SciPy RK45 (ode45), matrices", galvi.problems.heavy_top()),
        ("DOP853 on quaternions, compiled", galvi.problems.heavy_top()),
        ("REBOUND BS", galvi.problems.kepler(0.3)),
    ):
        if reference(name).missing:
            continue
        loose = reference(name).run(problem, 1.0, {})
        tight = reference(name).run(problem, 1.0, {"tolerance": 1e-12})
        assert loose.success and "for a truth, set" in loose.status
        assert tight.status == "Completed."


@pytest.mark.parametrize("sideways_speed", [0.0, 1e-8])
@pytest.mark.parametrize(
    "contender", [c for c in (IAS15, BULIRSCH_STOER, HEYOKA) if not c.missing], ids=lambda c: c.name
)
def test_a_collision_is_not_passed_off_as_a_result(contender, sideways_speed):
    q0, v0 = [[-0.5, 0.0], [0.5, 0.0]], [[0.0, 0.0], [0.0, sideways_speed]]
    setting = {"samples": 8} | ({"compact_mode": True} if contender is HEYOKA else {})
    run = contender.run(galvi.Problem(galvi.NBody([1.0, 1.0]), q0, v0), 2.0, setting)
    assert not run.success and run.failed_step == 4  # they meet at t = pi / 4
    assert contender is BULIRSCH_STOER or "bodies met" in run.status
    assert np.all(np.isfinite(run.q[:4])) and np.all(np.isnan(run.q[4:]))


REFUSED = [
    *(
        (fixed_steps, {"step": step}, r"step must divide.*Choose step = duration / \d+")
        for step in (0.3, 0.1 * (1 + 5e-9), 2.0, -0.1)
    ),
    *(
        (fixed_steps, {"step": step}, r"step must .*received")
        for step in (0.0, float("nan"), float("inf"), "fast")
    ),
    (fixed_steps, {}, "needs a 'step'"),
    (fixed_steps, {"step": 0.1, "save_every": 0}, "save_every must be a whole number"),
    (
        lambda duration, setting: sample_times(0.0, duration, setting),
        {"samples": 1.5},
        "samples must be a whole number",
    ),
]


@pytest.mark.parametrize(("read", "setting", "message"), REFUSED)
def test_a_setting_that_makes_no_sense_is_refused(read, setting, message):
    with pytest.raises(ValueError, match=message):
        read(1.0, setting)


@pytest.mark.parametrize(
    ("save_every", "saved"), [(4, [0, 4, 8, 10]), (5, [0, 5, 10]), (99, [0, 10])]
)
def test_saved_steps_hold_the_first_every_kth_and_the_last(save_every, saved):
    steps = fixed_steps(1.0, {"step": 0.1 * (1 + 5e-10), "save_every": save_every})
    assert steps.count == 10 and steps.saved.tolist() == saved


def test_times_are_those_of_the_steps_and_not_a_running_sum_and_samples_end_at_the_end():
    steps = fixed_steps(1e4, {"step": 0.1})
    assert np.array_equal(steps.times(3.0), 3.0 + np.arange(100_001) * 0.1)
    assert sample_times(1.0, -3.0, {"samples": 3}).tolist() == [1.0, 0.0, -1.0, -2.0]
    assert sample_times(0.0, 0.1, {}).tolist() == [0.0, 0.1]


METHODS = (EXPLICIT_EULER, SYMPLECTIC_EULER, IMPLICIT_EULER, STORMER_VERLET, RK4, FOREST_RUTH)
NAMES = [method.name for method in METHODS]
ORBIT = galvi.problems.kepler(0.3)


@pytest.mark.slow_cases("implicit Euler")
@pytest.mark.parametrize("method", METHODS, ids=NAMES)
def test_the_order_is_what_is_claimed_and_no_more(method):
    truth = KEPLER.run(ORBIT, 1.0, {})
    steps = 1.0 / np.array([400, 800, 1600, 3200] if method.order < 3 else [20, 40, 80, 160])
    errors = [np.abs(method.run(ORBIT, 1.0, {"step": h}).q[-1] - truth.q[-1]).max() for h in steps]
    slope = np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert abs(slope - method.order) < 0.05


def test_one_step_is_the_textbook_formula():
    q, v, h = ORBIT.q0, ORBIT.v0, 0.1
    a = lambda q: ORBIT.system.acceleration(q, 0.0)  # noqa: E731
    kicked = v + h * a(q)
    drifted = q + h * v + h**2 / 2 * a(q)
    for method, q1, v1 in (
        (EXPLICIT_EULER, q + h * v, kicked),
        (SYMPLECTIC_EULER, q + h * kicked, kicked),
        (STORMER_VERLET, drifted, v + h / 2 * (a(q) + a(drifted))),
    ):
        run = method.run(ORBIT, h, {"step": h})
        np.testing.assert_allclose(run.q[-1], q1, rtol=1e-15, atol=1e-16)
        np.testing.assert_allclose(run.p[-1], v1, rtol=1e-15, atol=1e-16)
    run = IMPLICIT_EULER.run(ORBIT, h, {"step": h})
    np.testing.assert_allclose(run.q[-1], q + h * run.p[-1], rtol=1e-15)
    np.testing.assert_allclose(run.p[-1], v + h * a(run.q[-1]), rtol=1e-14)


def test_evaluations_are_counted_and_the_last_force_is_used_again():
    assert EXPLICIT_EULER.run(ORBIT, 1.0, {"step": 0.1}).counts["force_evaluations"] == 10
    assert STORMER_VERLET.run(ORBIT, 1.0, {"step": 0.1}).counts["force_evaluations"] == 11


@pytest.mark.parametrize("method", METHODS, ids=NAMES)
def test_keeping_fewer_states_does_not_change_them(method):
    full = method.run(ORBIT, 1.0, {"step": 0.01})
    seventh = method.run(ORBIT, 1.0, {"step": 0.01, "save_every": 7})
    saved_steps = [*range(0, 100, 7), 100]
    assert np.array_equal(seventh.q, full.q[saved_steps]) and np.array_equal(
        seventh.t, full.t[saved_steps]
    )


def test_a_long_run_is_the_same_whether_or_not_it_is_cut_into_calls(monkeypatch):
    uncut = STORMER_VERLET.run(ORBIT, 1.0, {"step": 0.001})
    monkeypatch.setattr("references.textbook.nystrom.CHUNK", 7)
    assert np.array_equal(STORMER_VERLET.run(ORBIT, 1.0, {"step": 0.001}).q, uncut.q)


def raising_force(q):
    if q[0] < 0.9:
        raise ZeroDivisionError("no force here")
    return q


def nan_force(q):
    return q if q[0] > 0.9 else q * np.nan


def particle(gradient):
    """A particle on a line whose potential has this gradient."""
    system = galvi.Canonical(1.0, lambda q: 0.0, gradient, lambda q: np.eye(1), check=False)
    return galvi.Problem(system, [1.0], [0.0])


@pytest.mark.parametrize("method", METHODS, ids=NAMES)
def test_a_force_that_raises_stops_the_run_and_one_that_turns_nan_ends_it(method):
    setting = {"step": 0.01, "save_every": 3}
    with pytest.raises(ZeroDivisionError, match="no force here"):
        method.run(particle(raising_force), 2.0, setting)
    run = method.run(particle(nan_force), 2.0, setting)
    first = run.failed_step
    assert not run.success and 40 < first < 50 and f"tep {first}," in run.status
    assert run.counts["steps"] == first - 1
    completed = np.append(np.arange(0, 200, 3), 200) < first
    for states in (run.q, run.p):
        assert np.all(np.isfinite(states[completed])) and np.all(np.isnan(states[~completed]))


def test_bodies_that_meet_end_the_run():
    problem = galvi.Problem(
        galvi.NBody([1.0, 1.0]), [[-0.5, 0.0], [0.5, 0.0]], [[1.0, 0], [-1.0, 0]]
    )
    run = EXPLICIT_EULER.run(problem, 2.0, {"step": 0.5})
    assert not run.success and run.failed_step == 2 and "bodies met" in run.status
    assert np.all(np.isnan(run.q[2:])) and np.all(np.isfinite(run.q[:2]))


def test_implicit_euler_passes_through_zero_without_a_stall():
    run = IMPLICIT_EULER.run(
        galvi.Problem(galvi.Canonical(1.0, galvi.LinearSpring(1.0)), [1.0], [-10.0 - 1e-10]),
        0.2,
        {"step": 0.1},
    )
    assert run.success and run.counts["iterations"] <= 4


@pytest.mark.slow(beside="test_implicit_euler_passes_through_zero_without_a_stall")
def test_implicit_euler_says_when_its_equations_have_no_solution_left():
    problem, step = galvi.problems.solar_system(), 0.005 * 365.25
    run = IMPLICIT_EULER.run(problem, 100 * step, {"step": step})
    assert not run.success and run.failed_step == 18 and "stopped converging" in run.status
    sunward = np.linalg.norm(run.q[:18, 1] - run.q[:18, 0], axis=1)
    assert np.all(np.diff(sunward) < 0.0) and sunward[-1] < 0.17
    unconverged = IMPLICIT_EULER.run(
        problem, 1000 * step, {"step": step, "save_every": 1000, "accept_unconverged": True}
    )
    assert unconverged.success and "not states of implicit Euler" in unconverged.status
    assert unconverged.counts["unconverged_steps"] > 0
    assert np.linalg.norm(unconverged.q[-1, 1] - unconverged.q[-1, 0]) > 10.0
