"""The harmonic frame: exact for springs alone, and the same motion with any stiffness."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import galvi
from galvi.frames import harmonic_frame

RANDOM_MATRIX = np.random.default_rng(3).normal(size=(3, 3))
MASS = RANDOM_MATRIX @ RANDOM_MATRIX.T + np.eye(3)
SPRINGS = np.diag([1.0, 50.0, 2500.0]) + 0.3


def method(s: int, **options: Any) -> galvi.Galerkin:
    return galvi.Galerkin(
        galvi.Polynomials(s), galvi.gauss(s), chart=galvi.HarmonicFrame(**options)
    )


PLAIN = galvi.Galerkin(galvi.Polynomials(12), galvi.gauss(12))
KEPLER = galvi.problems.kepler(0.1)


def quartic(q: Any, t: float) -> float:
    """Stiff springs, and a weak, slowly driven coupling."""
    return 0.5 * q @ SPRINGS @ q + 0.05 * (q[0] * q[1] * q[2] + q[0] ** 4) + 0.01 * q[1] * np.sin(t)


STIFF = galvi.Problem(
    galvi.Canonical(MASS, quartic, explicit_time=True), [0.5, 0.1, -0.02], [0.3, 0.0, 0.5], t0=0.2
)


@given(step=st.floats(0.5, 500.0), stiffness=st.floats(0.1, 1e4))
def test_an_oscillator_is_exact_at_steps_of_any_length(step: float, stiffness: float) -> None:
    system = galvi.Canonical(1.0, galvi.LinearSpring(stiffness))
    problem = galvi.Problem(system, [1.0, -0.5], [0.0, 2.0])
    run = galvi.integrate(problem, method(1), step, 50)
    omega = stiffness**0.5
    t = np.arange(51) * step  # the times of the run, up to rounding
    for k, (x, v) in enumerate(zip(*(a.tolist() for a in (problem.q0, problem.v0)), strict=True)):
        exact = x * np.cos(omega * t) + v / omega * np.sin(omega * t)
        assert np.max(np.abs(run.q[:, k] - exact)) < 4e-16 * (10.0 + omega * t[-1]) * np.hypot(
            x, v / omega
        )


def test_a_long_run_of_an_oscillator_keeps_its_energy_to_rounding() -> None:
    """A rotation rounded to double precision would change it by 1e-11 in a million steps."""
    problem = galvi.Problem(galvi.Canonical(1.0, galvi.LinearSpring(9.0)), [1.0], [0.0])
    run = galvi.integrate(problem, method(1), 0.7, 1_000_000, save_every=10_000)
    assert np.max(np.abs(galvi.energy(run) / galvi.energy(run)[0] - 1.0)) < 2e-15  # 4e-16
    assert np.allclose(run.q[:, 0], np.cos(3.0 * run.t), rtol=0.0, atol=1e-9)


def test_a_full_mass_stiff_springs_and_explicit_time_in_steps_beyond_the_fast_period() -> None:
    """h omega = 25 for the fastest mode, where the general method needs fifty times more steps."""
    truth = galvi.integrate(STIFF, PLAIN, 0.01, duration=10.0, save_every=1_000)
    for s, h, bound in ((8, 0.5, 1e-4), (8, 0.25, 1e-5)):
        run = galvi.integrate(STIFF, method(s), h, duration=10.0)
        assert run.success and np.max(np.abs(run.q[-1] - truth.q[-1])) < bound


@pytest.mark.parametrize(
    ("problem", "stiffness"),
    [
        *((STIFF, K) for K in (None, np.zeros((3, 3)), np.eye(3), 2.0 * SPRINGS, -np.eye(3))),
        (KEPLER, np.eye(2)),  # whose own d2V/dq2 at 0 is infinite
    ],
)
def test_any_stiffness_gives_the_same_motion(problem: galvi.Problem, stiffness: Any) -> None:
    run = galvi.integrate(problem, method(12, stiffness=stiffness), 0.02, 50)
    truth = galvi.integrate(problem, PLAIN, 0.01, 100, save_every=2)
    assert run.success and np.max(np.abs(run.q - truth.q)) < 1e-11


def test_a_wrong_frequency_of_the_rotation_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    """Planted: the frame turns at another frequency than the remaining force assumes."""
    rotation = harmonic_frame._rotation
    monkeypatch.setattr(
        harmonic_frame, "_rotation", lambda squares, t: rotation(squares * (1 + 1e-9), t)
    )
    problem = galvi.Problem(galvi.Canonical(1.0, galvi.LinearSpring(4.0)), [1.0], [0.0])
    run = galvi.integrate(problem, method(1), 0.9, 1000)
    assert np.max(np.abs(run.q[:, 0] - np.cos(2.0 * run.t))) > 1e-9
