"""External forces: who takes them, that nobody leaves them out, and closed forms with drag."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest
from numba import njit

import galvi
from references import REFERENCES, Contender, reference
from references.closed_forms.top_motion import FREE_TOP
from references.newton import external_force, is_forced
from references.scipy.ivp import DOP853, TIGHT
from references.textbook.euler import SEMI_IMPLICIT_EULER

RATE, DURATION = 0.4, 1.0
SPRING = galvi.problems.harmonic_oscillator()
TURN = galvi.problems.free_rigid_body()
INERTIA = np.array(TURN.system.inertia)
PRESENT = [contender for contender in REFERENCES if not contender.missing]

# name: setting of a run of duration 1, tolerance on q; measured when set, in the comment
ON_VECTORS: Mapping[str, tuple[dict[str, Any], float]] = {
    "explicit Euler": ({"step": 1e-4}, 1e-4),  # 4e-5
    "symplectic Euler": ({"step": 1e-4}, 1e-4),  # 4e-5
    "semi-implicit Euler": ({"step": 1e-4}, 1e-4),  # 4e-5
    "SciPy RK45 (ode45)": ({"tolerance": 1e-9}, 1e-8),  # 1e-10
    "SciPy DOP853": (dict(TIGHT), 1e-14),  # 3e-16
    "SciPy Radau": ({"tolerance": 1e-9}, 1e-10),  # 9e-13
    "heyoka, Lagrangians": ({"compact_mode": True}, 1e-14),  # 1e-16
    "heyoka, Lagrangians, quadruple precision": ({}, 1e-15),  # 0
}
ON_BODIES: Mapping[str, tuple[dict[str, Any], float]] = {
    "explicit Euler, matrices": ({"step": 1e-3}, 1e-2),  # 2e-3
    "SciPy RK45 (ode45), matrices": ({"tolerance": 1e-9}, 1e-7),  # 1e-9
    "SciPy DOP853, quaternions": (dict(TIGHT), 1e-13),  # 1e-15
}
TAKERS = {**ON_VECTORS, **ON_BODIES}
TAKERS_HERE = [name for name in TAKERS if not reference(name).missing]


@njit
def friction(q, v):
    """-RATE v, (d,)."""
    return -RATE * v


@njit
def rubbing(R, w):
    """A torque -RATE J w, (3,)."""
    return -RATE * (INERTIA @ w)


def forced(problem: galvi.Problem, force: Any) -> galvi.Problem:
    """The same problem with an external force."""
    return replace(problem, system=replace(problem.system, force=force))


POINTS = ("harmonic_oscillator", "planar_pendulum", "henon_heiles")
TURNING = ("free_rigid_body", "pendulum_3d", "heavy_top")
OF_EVERY_KIND = {  # that some reference recognises, with a force upon it
    **{name: forced(getattr(galvi.problems, name)(), friction) for name in POINTS},
    **{name: forced(getattr(galvi.problems, name)(), rubbing) for name in TURNING},
    "kepler": forced(galvi.problems.kepler(0.3), friction),
}


def damped_spring(t: float) -> float:
    """q of q'' = -q - RATE q' from q = 1, q' = 0."""
    half = RATE / 2.0
    w = np.sqrt(1.0 - half**2)
    return float(np.exp(-half * t) * (np.cos(w * t) + half / w * np.sin(w * t)))


def damped_turn(t: float) -> Any:
    """R of p' = p x w - RATE p: the free motion at the time (1 - exp(-RATE t)) / RATE."""
    slowed = (1.0 - np.exp(-RATE * t)) / RATE
    return FREE_TOP.run(TURN, slowed, {"samples": 1}).q[-1]


def error(contender: Any) -> float:
    """Of q at the end against the closed form, over the contender's tolerance."""
    setting, tolerance = TAKERS[contender.name]
    if contender.name in ON_VECTORS:
        problem, exact = forced(SPRING, friction), damped_spring(DURATION)
    else:
        problem, exact = forced(TURN, rubbing), damped_turn(DURATION)
    run = contender.run(problem, DURATION, setting)
    assert run.success
    return float(np.abs(run.q[-1] - exact).max()) / tolerance


@pytest.mark.parametrize("contender", REFERENCES, ids=lambda contender: contender.name)
def test_only_references_that_are_listed_here_take_a_force_and_others_refuse_it(contender):
    takes = [name for name, problem in OF_EVERY_KIND.items() if contender.supports(problem)]
    assert bool(takes) == (contender.name in TAKERS), takes
    for problem in () if takes else OF_EVERY_KIND.values():
        with pytest.raises(ValueError, match="does not solve this kind of problem"):
            contender.run(problem, DURATION, {"step": DURATION})


@pytest.mark.slow_cases("explicit Euler")
@pytest.mark.parametrize("name", TAKERS_HERE)
def test_a_reference_that_takes_forces_finds_the_closed_form(name):
    assert error(reference(name)) <= 1.0


@dataclass(frozen=True)
class Deaf:
    """Deliberately broken: takes a problem with a force, and solves it without."""

    inner: Contender

    @property
    def name(self) -> str:
        return self.inner.name

    def run(self, problem, duration, setting):
        return self.inner.run(forced(problem, None), duration, setting)


@pytest.mark.parametrize("name", TAKERS_HERE)
def test_a_reference_that_leaves_the_force_out_is_caught(name):
    assert error(Deaf(reference(name))) > 10.0


@pytest.mark.slow(
    beside="test_a_force_of_galvis_own_runs_compiled_and_is_the_function_it_is_called_as"
)
def test_a_force_of_time_and_one_in_plain_python_act_at_their_time():
    def driven(q, v, t):
        return np.array([np.cos(2.0 * t) - 0.1 * v[0]])

    made = [
        replace(SPRING, system=replace(SPRING.system, force=f, timed_force=True))
        for f in (driven, njit(driven))
    ]
    exact = DOP853.run(made[0], DURATION, TIGHT).q[-1]
    for problem in made:
        assert is_forced(problem)
        found = SEMI_IMPLICIT_EULER.run(problem, DURATION, {"step": 1e-4}).q[-1]
        assert np.abs(found - exact).max() < 1e-4  # 3e-5
    late = replace(made[0], t0=1.0)
    assert np.abs(DOP853.run(late, DURATION, TIGHT).q[-1] - exact).max() > 0.01


def test_semi_implicit_euler_is_of_first_order_and_symplectic_euler_without_a_force():
    steps = (100, 200, 400, 800)
    problem = forced(SPRING, friction)
    errors = [
        abs(SEMI_IMPLICIT_EULER.run(problem, 1.0, {"step": 1.0 / n}).q[-1, 0] - damped_spring(1.0))
        for n in steps
    ]
    slopes = np.diff(np.log(errors)) / np.diff(np.log(steps))
    assert np.all(np.abs(slopes + 1.0) < 0.05)  # 0.004
    setting = {"step": 0.01}
    free = SEMI_IMPLICIT_EULER.run(SPRING, 1.0, setting)
    same = reference("symplectic Euler").run(SPRING, 1.0, setting)
    np.testing.assert_allclose(free.q, same.q, rtol=0, atol=1e-14)


def test_a_force_of_galvis_own_runs_compiled_and_is_the_function_it_is_called_as():
    problem = galvi.problems.brownout(100e-6)
    drag = problem.system.force
    plain = replace(problem.system, force=lambda q, v, t: drag(q, v, t))
    known, called = (
        SEMI_IMPLICIT_EULER.run(replace(problem, system=system), 0.5, {"step": 1e-3})
        for system in (problem.system, plain)
    )
    np.testing.assert_allclose(known.q, called.q, rtol=0, atol=1e-13)  # 2e-15
    assert external_force(problem).compiled
    assert not external_force(replace(problem, system=plain)).compiled


def test_galvi_finds_the_closed_form_of_a_braked_free_body():
    method = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
    run = galvi.integrate(forced(TURN, rubbing), method, 0.25, 4)
    assert np.abs(run.q[-1] - damped_turn(1.0)).max() < 1e-13  # 3e-16
