"""Forces of position in the Kepler frame, besides what `test_frames.py` has of every frame."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import galvi
from galvi.frames import kepler_frame
from galvi.problem import Problem
from galvi.run.in_frame import kernel, passes
from tests.properties.celestial_cases import OF_VELOCITY, OTHERS, bodies
from tests.properties.test_kepler_hierarchy import MOON, TREE

FINE = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))


def framed(s: int, **given: Any) -> galvi.Galerkin:
    return galvi.Galerkin(galvi.Polynomials(s), galvi.gauss(s), chart=galvi.KeplerFrame(**given))


def off(problem: Problem, used: galvi.Galerkin, step: float, steps: int, parts: int) -> float:
    """How far the end is from that of short steps in the inertial frame."""
    run = galvi.integrate(problem, used, step, steps, save_every=steps)
    true = galvi.integrate(problem, FINE, step / parts, steps * parts, save_every=steps * parts)
    assert run.status == "Completed." and not run.counts.get("inertial_steps")
    ends = (run.q[-1] - true.q[-1], run.v[-1] - true.v[-1])
    return max(float(np.max(np.abs(gap))) for gap in ends)


@pytest.mark.slow(beside="tests/agreement/test_agreement.py::test_every_problem_agrees")
@settings(max_examples=15, deadline=None)
@given(seed=st.integers(0, 10_000), count=st.integers(2, 5), D=st.integers(2, 3))
def test_any_order_of_bodies_and_any_sources(seed: int, count: int, D: int) -> None:
    """Nested orbits in a random order; each of two bodies with a mass has three forces."""
    random = np.random.default_rng(seed)
    a = 1.7 ** np.arange(1, count)
    turn = random.uniform(0.0, 6.0, count - 1)
    q, v, masses = np.zeros((count, D)), np.zeros((count, D)), np.ones(count)
    q[1:, :2] = a[:, None] * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    v[1:, :2] = np.stack([-np.sin(turn), np.cos(turn)], axis=1) / np.sqrt(a)[:, None]
    q[1:, D - 1] += 0.1 * (D - 2) * np.sin(3.0 * turn)
    masses[1:] = random.choice([0.0, 1e-2, 1e-3], count - 1)
    order = random.permutation(count)
    masses, q, v = masses[order], q[order], v[order]
    pole = (0.3 * (D - 2), 0.2 * (D - 2), 1.0)
    forces = [
        force
        for body in np.argsort(-masses)[:2].tolist()
        if masses[body] > 0.0
        for force in (
            galvi.Oblateness(body, 0.02, 0.4, pole=pole),
            galvi.PowerLaw(body, 1e-2 * masses[body], random.choice([-2.5, 1.0])),
            galvi.Relativity(10.0, body, form="potential"),
        )
    ]
    problem = galvi.Problem(galvi.NBody(masses, 1.0, forces[:: random.choice([1, -1])]), q, v)
    left = [int(np.flatnonzero(order == k)[0]) for k in range(count)]
    tree = left[0]
    for body in left[1:]:
        tree = (tree, body)
    for frame in ({}, {"hierarchy": tree}):
        assert off(problem, framed(12, **frame), 0.6, 6, 20) < 1e-11  # 1e-13


OBLATE = (
    galvi.Oblateness(2, 0.02, 5e-4, pole=(0.3, 0.2, 0.9)),
    galvi.Oblateness(0, 2e-4, 4.65e-2, pole=(0.1, 0.0, 1.0)),
    galvi.Relativity(173.14463, form="potential"),
)
MOON_OF_OBLATE = galvi.Problem(
    galvi.NBody(MOON.system.masses, forces=OBLATE), MOON.q0, MOON.v0, parameters=MOON.parameters
)


def test_the_moon_of_an_oblate_planet() -> None:
    """The planet's J2 moves the Moon by 8e-5 in 100 days; neither energy nor momentum drifts."""
    true = galvi.integrate(MOON_OF_OBLATE, FINE, 0.5, 200)
    run = galvi.integrate(MOON_OF_OBLATE, framed(16, hierarchy=TREE), 5.0, 20)
    assert np.max(np.abs(run.q - true.q[::10])) < 1e-13  # 1e-15
    times = np.linspace(0.0, 100.0, 31)
    assert np.max(np.abs(run(times) - true(times))) < 1e-12
    long = galvi.integrate(MOON_OF_OBLATE, framed(8, hierarchy=TREE), 4.0, 9_000, save_every=100)
    energies = galvi.energy(long)
    assert np.ptp(energies) < 1e-13 * abs(energies[0])  # 1e-15
    momenta = galvi.linear_momentum(long)
    assert np.max(np.abs(momenta - momenta[0])) < 1e-13 * np.max(np.abs(long.p))


def one_planet(force: Any, e: float, tilt: float) -> Problem:
    """At the pericentre of an orbit of semi-major axis 1 about a mass of 1."""
    pace = np.sqrt((1.0 + e) / (1.0 - e)) * np.array([0.0, np.cos(tilt), np.sin(tilt)])
    q, v = [[0.0, 0.0, 0.0], [1.0 - e, 0.0, 0.0]], [[0.0, 0.0, 0.0], pace]
    return galvi.Problem(galvi.NBody([1.0, 1e-9], forces=force), q, v)


J2, RADIUS, E, TILT, SPEED = 1e-3, 0.1, 0.3, 0.4, 300.0
ABOUT_A_TURN = RADIUS**2 * J2 / (1.0 - E**2) ** 2


def drift_from_theory() -> dict[str, float]:
    """Relative errors of secular rates, from 170 revolutions in 400 steps."""
    oblate = galvi.integrate(
        one_planet(galvi.Oblateness(0, J2, RADIUS), E, TILT), framed(16), 2.7, 400
    )
    bent = galvi.integrate(
        one_planet(galvi.Relativity(SPEED, form="potential"), E, TILT), framed(16), 2.7, 400
    )
    found = {}
    for name, run, expected in (
        ("node", oblate, -1.5 * ABOUT_A_TURN * np.cos(TILT)),
        ("pericentre", oblate, 0.75 * ABOUT_A_TURN * (5.0 * np.cos(TILT) ** 2 - 1.0)),
        ("pericentre", bent, 3.0 / (SPEED**2 * (1.0 - E**2))),
    ):
        elements = galvi.orbital_elements(run)
        angle = elements.node if name == "node" else elements.pericentre
        slope = np.polyfit(run.t, np.unwrap(angle[:, 0]), 1)[0]
        found[f"{name} {'oblate' if run is oblate else 'bent'}"] = float(slope / expected - 1.0)
    return found


def test_secular_rates_are_those_of_theory_and_not_without_the_terms(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    for name, error in drift_from_theory().items():
        assert abs(error) < 2e-3, name
    sound = kepler_frame._terms

    def unforced(problem: Problem, found: Any) -> Any:
        starts, rows = sound(problem, found)
        return np.zeros_like(starts), rows

    monkeypatch.setattr(kepler_frame, "_terms", unforced)
    kernel.motion_of.cache_clear()
    passes.checks_of.cache_clear()
    for name, error in drift_from_theory().items():
        assert abs(error + 1.0) < 1e-3, name
    assert off(MOON_OF_OBLATE, framed(16, hierarchy=TREE), 5.0, 4, 10) > 1e-8
    kernel.motion_of.cache_clear()
    passes.checks_of.cache_clear()


def test_steps_where_what_is_left_is_too_strong_are_done_elsewhere() -> None:
    """A comet from its apocentre, which an oblate star bends where it is near."""
    problem = one_planet(galvi.Oblateness(0, 0.1, 0.1), 0.8, 0.4)
    far = galvi.integrate(problem, FINE, 0.01, 314)
    comet = galvi.Problem(problem.system, far.q[-1], far.v[-1])
    run = galvi.integrate(comet, framed(8), 0.05, 500)
    true = galvi.integrate(comet, FINE, 0.00125, 20_000, save_every=40)
    assert run.success and 0 < run.counts["inertial_steps"] < 50  # 20
    assert np.max(np.abs(run.q - true.q)) < 1e-11  # 1e-13
    times = np.linspace(0.0, 25.0, 200)
    assert np.max(np.abs(run(times) - true(times))) < 1e-7


@pytest.mark.slow(
    beside="test_eccentric_orbits_in_frames.py::test_orbits_beyond_the_limit_are_refused_by_name"
)
def test_forces_of_velocity_and_functions_are_refused_by_name() -> None:
    for name, words in (
        ("tides", "with Tides. Use another chart"), ("one source", "with Relativity. Use"),
        ("a function of time", "with Force. Use"), ("a function", "with Force. Use"),
        ("Python", "with Drag, Force. Use"),
    ):  # fmt: skip
        with pytest.raises(ValueError, match=r"forces that have an energy \(Obl.*" + words):
            galvi.integrate(bodies({**OF_VELOCITY, **OTHERS}[name]), framed(4), 0.05, 4)


def test_two_bodies_with_a_force_are_not_exact_at_any_step() -> None:
    """Alone they are; with a force the series of the iteration limit the step, in words."""
    problem = one_planet(galvi.Oblateness(0, J2, 0.1 * RADIUS), 0.9, 0.4)
    run = galvi.integrate(problem, framed(8), 7.0, 2)
    assert not run.success and "revolutions of body" in run.status
    alone = galvi.Problem(galvi.NBody([1.0, 1e-9]), problem.q0, problem.v0)
    assert galvi.integrate(alone, framed(8), 7.0, 2).success


@pytest.mark.parametrize("steps", [1, 7])
def test_states_a_bit_of_time_after_kept_ones_are_those(steps):
    problem = galvi.Problem(
        galvi.NBody([1.0, 1e-6], forces=galvi.Oblateness(0, 1e-3, 0.1)),
        [[0, 0, 0], [0.8, 0, 0.3]], [[0, 0, 0], [0.1, 0.5, 0]],
    )  # fmt: skip
    method = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8), chart=galvi.KeplerFrame())
    run = galvi.integrate(problem, method, 0.03, 42, save_every=steps)
    q, p = galvi.states_at(run, np.nextafter(run.t[:-1], np.inf))
    assert np.allclose(q, run.q[:-1], rtol=0, atol=1e-14)
    assert np.allclose(p, run.p[:-1], rtol=0, atol=1e-19)  # of 3e-6
