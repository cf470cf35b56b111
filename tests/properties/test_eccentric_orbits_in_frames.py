"""Eccentric orbits in the Kepler frame: right to 1e-12 a revolution, or not done in the frame.

The truth is Kepler's equation in 40 digits, from the float64 numbers of the start. Errors of
positions are relative to the semi-major axis. `python -m
tests.properties.test_eccentric_orbits_in_frames` prints the largest by eccentricity, also beyond
the limit.
"""

from __future__ import annotations

import math
import re
from typing import Any

import mpmath as mp
import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import galvi
from galvi.frames import kepler_frame
from galvi.lanes.frames.kepler_motion import LEAST_DISTANCE_RATIO

FRAME = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4), chart=galvi.KeplerFrame())
DIGITS = 40
STEPS_PER_REVOLUTION = (0.79, 0.9, 1.3, 2, 3, 5, 10, 30, 100)  # a revolution
PHASES = (0.0, np.pi, np.pi / 2, 0.05, -0.3)  # eccentric anomalies at the start
THIRD_BODY_DISTANCE = (
    40.0  # distance of a third body, with which nothing but the frame's motion acts
)


def relative_vector(q: Any) -> list[Any]:
    """The second vector less the first, exactly."""
    return [mp.mpf(b) - mp.mpf(a) for a, b in zip(*q[:2], strict=True)]


def anomaly(e: Any, mean: Any) -> Any:
    """The eccentric anomaly, by Newton's method in an interval."""
    low, high, E = mean - e, mean + e, mean + e * mp.sin(mean)
    for _ in range(200):
        gap = E - e * mp.sin(E) - mean
        low, high = (low, E) if gap > 0 else (E, high)
        next_E = E - gap / (1 - e * mp.cos(E))
        next_E = next_E if low < next_E < high else (low + high) / 2
        if abs(next_E - E) < mp.mpf(10) ** (4 - DIGITS):
            return next_E
        E = next_E
    return E


def norm(x: Any) -> Any:
    return mp.sqrt(mp.fdot(x, x))


class Orbit:
    """The motion of two bodies."""

    def __init__(self, masses: Any, q: Any, v: Any) -> None:
        self.mu, self.q, self.v = (
            mp.mpf(masses[0]) + mp.mpf(masses[1]),
            relative_vector(q),
            relative_vector(v),
        )
        self.r, self.along = norm(self.q), mp.fdot(self.q, self.v)
        self.beta = -2 * self.energy(q, v)
        self.axis = self.mu / self.beta

    def energy(self, q: Any, v: Any) -> Any:
        return mp.fdot(relative_vector(v), relative_vector(v)) / 2 - self.mu / norm(
            relative_vector(q)
        )

    def relative_position(self, t: Any) -> list[Any]:
        root = mp.sqrt(self.beta)
        cosine, sine = 1 - self.r / self.axis, self.along / mp.sqrt(self.mu * self.axis)
        E = mp.atan2(sine, cosine)
        mean = E - sine + t * self.beta * root / self.mu
        turned = anomaly(mp.hypot(cosine, sine), mean) - E
        G1, G2 = mp.sin(turned) / root, (1 - mp.cos(turned)) / self.beta
        f, g = 1 - self.mu * G2 / self.r, self.r * G1 + self.along * G2
        return [f * x + g * y for x, y in zip(self.q, self.v, strict=True)]


def state_on_orbit(
    e: float, E: float, ratio: float, turn: float, with_third_body: bool = False
) -> Any:
    """Masses, positions and velocities for a = 1 and the eccentric anomaly E, m_2 / m_1 = ratio."""
    b, r = math.sqrt((1.0 - e) * (1.0 + e)), 1.0 - e * math.cos(E)
    position = np.array([math.cos(E) - e, b * math.sin(E)])
    speed = math.sqrt(1.0 + ratio) / r * np.array([-math.sin(E), b * math.cos(E)])
    axes = np.array([[math.cos(turn), math.sin(turn)], [-math.sin(turn), math.cos(turn)]])
    weight = ratio / (1.0 + ratio)
    q, v = (np.array([-weight * x, (1.0 - weight) * x]) @ axes for x in (position, speed))
    if not with_third_body:
        return np.array([1.0, ratio]), q, v
    third_speed = ((1.0 + ratio) / THIRD_BODY_DISTANCE) ** 0.5
    q, v = np.vstack([q, [0.0, THIRD_BODY_DISTANCE]]), np.vstack([v, [-third_speed, 0.0]])
    return np.array([1.0, ratio, 0.0]), q, v


def largest_errors(start: Any, steps: float, backwards: bool = False) -> tuple[float, float]:
    """The largest errors of the position, over the semi-major axis, and of the energy, relative,
    in a revolution.

    Both count at the ends of steps; that of the position also at one time in the last step.
    """
    masses, q, v = start
    with mp.workdps(DIGITS):
        orbit, largest = Orbit(*start), [0.0, 0.0]
        h = 2.0 * math.pi * (1.0 + masses[1]) ** -0.5 / steps * (-1.0 if backwards else 1.0)
        count = max(1, round(steps))
        run = galvi.integrate(galvi.Problem(galvi.NBody(masses), q, v), FRAME, h, count)
        assert run.success and "inertial_steps" not in run.counts, run.status
        energy = orbit.energy(q, v)
        between = float(run.t[-1] - 0.3 * h)
        positions = [(mp.mpf(h) * k, run.q[k]) for k in range(1, count + 1)]
        for t, state_q in [*positions, (mp.mpf(between), run(between))]:
            gap = [
                x - y
                for x, y in zip(relative_vector(state_q), orbit.relative_position(t), strict=True)
            ]
            largest[0] = max(largest[0], float(norm(gap) / orbit.axis))
        for state_q, speed in zip(run.q, run.v, strict=True):
            largest[1] = max(largest[1], abs(float(orbit.energy(state_q, speed) / energy - 1)))
        return largest[0], largest[1]


@pytest.mark.slow(beside="test_the_limit_is_where_it_is_for_a_reason")
@settings(max_examples=60)
@example(e=0.9, E=0.0, ratio=0.3, turn=0.4, steps=2.0, with_third_body=True, backwards=False)
@example(e=0.9, E=np.pi, ratio=0.3, turn=0.4, steps=0.79, with_third_body=False, backwards=True)
@example(
    e=0.8,
    E=-2.4767434253357143,
    ratio=0.3,
    turn=0.4,
    steps=2.0,
    with_third_body=True,
    backwards=False,
)
@given(
    e=st.floats(0.0, 0.9),
    E=st.floats(-3.2, 3.2),
    ratio=st.just(0.0) | st.floats(1e-9, 1.0),
    turn=st.floats(0.0, 6.3),
    steps=st.floats(0.79, 100.0),
    with_third_body=st.booleans(),
    backwards=st.booleans(),
)
def test_up_to_the_limit_a_revolution_is_right_to_1e_12(
    e: float,
    E: float,
    ratio: float,
    turn: float,
    steps: float,
    with_third_body: bool,
    backwards: bool,
) -> None:
    """Any start, step, masses, direction; with a third body too, whose step is half as long."""
    start = state_on_orbit(e, E, ratio, turn, with_third_body)
    position_error, energy_error = largest_errors(
        start, max(steps, 1.4) if with_third_body else steps, backwards
    )
    assert position_error < 1e-12 and energy_error < 1e-13, (
        position_error,
        energy_error,
    )  # 4e-13, 1e-14


def test_the_limit_is_where_it_is_for_a_reason(monkeypatch: pytest.MonkeyPatch) -> None:
    """Planted: without the limit the frame errs by more at e = 0.98."""
    monkeypatch.setattr(kepler_frame, "MAX_ECCENTRICITY", 1.0)
    worst = max(
        largest_errors(state_on_orbit(0.98, E, 0.3, 0.4), n)[0] for E in PHASES[:3] for n in (2, 5)
    )
    assert worst > 1e-12, worst


def inclined(e: float) -> galvi.Problem:
    """A planet whose orbit another star makes more eccentric, by Kozai's effect, from ``e`` on."""
    tilt = np.radians(85.0)
    q, v = np.zeros((3, 3)), np.zeros((3, 3))
    axis = np.array([0.0, np.cos(tilt), np.sin(tilt)])
    q[1], v[1, 0] = -(1.0 + e) * axis, ((1.0 - e) / (1.0 + e)) ** 0.5
    q[2] = 8.0 * np.array([np.cos(1.0), np.sin(1.0), 0.0])
    v[2] = 0.5 * np.array([-np.sin(1.0), np.cos(1.0), 0.0])
    masses = np.array([1.0, 1e-6, 1.0])
    mass_fractions = masses / 2.000001
    return galvi.Problem(galvi.NBody(masses), q - mass_fractions @ q, v - mass_fractions @ v)


def test_passages_of_orbits_that_become_too_eccentric_are_done_in_the_inertial_frame() -> None:
    """Which steps these are does not depend on how often states are saved."""
    problem = inclined(0.85)
    method = galvi.Galerkin(galvi.Polynomials(16), galvi.gauss(16), chart=galvi.KeplerFrame())
    run = galvi.integrate(problem, method, 0.5, 600)
    assert run.success and 0 < run.counts["inertial_steps"] < 100, run.status
    assert "or an orbit too eccentric for it" in run.status
    assert galvi.orbital_elements(run).eccentricity[-1, 0] > 0.98
    assert np.ptp(galvi.energy(run)) < 1e-9
    rarely = galvi.integrate(problem, method, 0.5, 600, save_every=200)
    assert np.array_equal(rarely.q[-1], run.q[-1])
    clock = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8), clock=galvi.DynamicalTime())
    true = galvi.integrate(problem, clock, step=0.05, duration=300.0)
    assert np.max(np.abs(run.q[-1] - true.q[-1])) < 0.05


def comet(speed_factor: float) -> galvi.Problem:
    """A comet from the pericentre, at ``speed_factor`` times the speed for e = 0.5."""
    masses, q, v = state_on_orbit(0.5, 0.0, 0.0, 0.0)
    return galvi.Problem(
        galvi.NBody(masses), q, speed_factor * v, parameters={"bodies": ("Sun", "comet")}
    )


TWO_ORBITS = galvi.Problem(  # a circle, and a pericentre at 0.12
    galvi.NBody([1.0, 1e-9, 1e-9]),
    [[0.0, 0.0], [1.0, 0.0], [0.0, 0.12]],
    [[0.0, 0.0], [0.0, 1.0], [np.sqrt(1.9 / 0.12), 0.0]],
)


@pytest.mark.parametrize(
    ("problem", "step", "pattern"),
    [
        (comet(1.0), 8.1, r"the step is 1\.29 revolutions of body comet, more than"),
        (comet(1.2), 0.1, "the orbit of body comet is not bound any more"),
        (comet(0.1), 0.1, r"of body comet.*clock=galvi.DynamicalTime\(\) from there on"),
        (comet(1.0), 0.1, "^$"),
        (TWO_ORBITS, 2.2 * np.pi, "revolutions of body 2"),
    ],
)
def test_an_orbit_that_is_not_covered_any_more_is_named(
    problem: galvi.Problem, step: float, pattern: str
) -> None:
    assert re.search(pattern, galvi.KeplerFrame().leaves(problem, step))


def table() -> None:
    """Prints the largest errors of a revolution by eccentricity, also beyond the limit."""
    kepler_frame.MAX_ECCENTRICITY = 1.0
    for e in (*np.arange(10) / 10, 0.95, 0.97, 0.98, 0.99, 0.995, 0.999):
        random = np.random.default_rng(int(1e4 * e))
        largest = np.zeros(2)
        for steps in STEPS_PER_REVOLUTION:
            for E in (*PHASES, *random.uniform(-np.pi, np.pi, 7)):
                for with_third_body in (False, True)[
                    : 1 + (steps >= 2 and e <= 1.0 - LEAST_DISTANCE_RATIO)
                ]:
                    ratio, turn = random.choice([0.0, 1e-3, 0.3]), random.uniform(0.0, 6.3)
                    start = state_on_orbit(e, E, ratio, turn, with_third_body)
                    largest = np.maximum(largest, largest_errors(start, steps))
        print(f"e = {e:5}: places {largest[0]:.1e}, energy {largest[1]:.1e}", flush=True)


if __name__ == "__main__":
    table()
