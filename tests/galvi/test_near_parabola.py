"""Two bodies in the Kepler frame, to what one ulp of their start changes, for any e < 1.

The truth is Kepler's equation with 50 digits, from the numbers that are given. What it changes by
when one of these moves by an ulp is the bound: near a pericentre with 1 - e = 1e-12 that is much.
"""

from __future__ import annotations

from typing import Any

import mpmath as mp
import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import galvi
from galvi.fast.lanes.frames import near_parabola

FRAME = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4), chart=galvi.KeplerFrame())
ULPS = 10
mp.mp.dps = 50


def relative(masses: Any, q: Any, v: Any) -> tuple[Any, list[Any], list[Any]]:
    """G M, place and velocity of the second body from the first, exactly."""
    mu = mp.mpf(masses[0]) + mp.mpf(masses[1])
    gaps = ([mp.mpf(b) - mp.mpf(a) for a, b in zip(*x, strict=True)] for x in (q, v))
    return mu, *gaps


def truth(masses: Any, q: Any, v: Any, t: Any) -> Any:
    """(q, v) of the second body from the first after t, (2, D); None where they are not bound."""
    mu, Q, V = relative(masses, q, v)
    r0, eta = mp.sqrt(mp.fdot(Q, Q)), mp.fdot(Q, V)
    beta = 2 * mu / r0 - mp.fdot(V, V)
    if beta <= 0:
        return None
    a, root = mu / beta, mp.sqrt(beta)
    cosine, sine = 1 - r0 / a, eta / mp.sqrt(mu * a)
    e, E0 = mp.hypot(cosine, sine), mp.atan2(sine, cosine)
    M = E0 - sine + t * beta * root / mu
    turns = 2 * mp.pi * mp.nint(M / (2 * mp.pi))
    M -= turns
    low, high = (mp.mpf(0), mp.pi) if M >= 0 else (-mp.pi, mp.mpf(0))
    E = (low + high) / 2
    for _ in range(300):
        gap = E - e * mp.sin(E) - M
        low, high = (low, E) if gap > 0 else (E, high)
        new = E - gap / (1 - e * mp.cos(E))
        new = new if low < new < high else (low + high) / 2
        if abs(new - E) <= mp.mpf(10) ** -45 * abs(E):
            break
        E = new
    turned = E + turns - E0
    G1, G2 = mp.sin(turned) / root, (1 - mp.cos(turned)) / beta
    f, g = 1 - mu * G2 / r0, r0 * G1 + eta * G2
    r = r0 + eta * G1 + (mu - beta * r0) * G2
    place = [f * x + g * y for x, y in zip(Q, V, strict=True)]
    speed = [(1 - mu * G2 / r) * y - mu * G1 / (r * r0) * x for x, y in zip(Q, V, strict=True)]
    return np.array([place, speed])


def size(x: Any) -> float:
    return float(mp.sqrt(mp.fdot(x, x)))


def changed_by_ulps(masses: Any, q: Any, v: Any, t: Any) -> Any:
    """The most that place and velocity change when one number of the start moves by an ulp."""
    here, most = truth(masses, q, v, t), [0.0, 0.0]
    for vector in (0, 1):
        for entry in np.ndindex(q.shape):
            moved = q.copy(), v.copy()
            moved[vector][entry] = np.nextafter(moved[vector][entry], np.inf)
            there = truth(masses, *moved, t)
            if there is None:
                return here, [np.inf, np.inf]
            most = [max(x, size(y)) for x, y in zip(most, there - here, strict=True)]
    return here, most


def of_an_orbit(
    rest: float, anomaly: float, ratio: float, turn: float, backwards: bool, size: float = 1.0
) -> tuple[Any, Any, Any]:
    """Masses, places and velocities: 1 - e = ``rest``, the eccentric anomaly, m_2 / m_1."""
    masses = np.array([1.0, ratio])
    mu, e = 1.0 + ratio, 1.0 - rest
    b = np.sqrt(rest * (1.0 + e))
    half = np.sin(0.5 * anomaly)
    r = rest + 2.0 * e * half * half
    place = size * np.array([rest - 2.0 * half * half, b * np.sin(anomaly)])
    speed = np.sqrt(mu / size) / r * np.array([-np.sin(anomaly), b * np.cos(anomaly)])
    axes = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    place, speed = place @ axes, speed @ axes * (-1.0 if backwards else 1.0)
    share = ratio / mu
    q, v = (np.array([-share * x, (1.0 - share) * x]) for x in (place, speed))
    return masses, q, v


@settings(max_examples=60)
@example(-12.0, 0.0, 0.0, 0.0, 0.05, 10, 0.3, False, False)
@example(-4.0, 0.0, 0.0, 0.0, 0.05, 10, 0.3, False, False)
@example(-2.0, 3.14159, 1e-6, 0.0, 0.477, 40, 0.3, False, False)
@example(-9.0, 3.0, 1.0, 0.3, 1.2, 7, 0.3, True, True)
@given(
    rest=st.floats(-12.0, 0.0), anomaly=st.floats(-3.2, 3.2),
    ratio=st.just(0.0) | st.floats(1e-9, 1.0), turn=st.just(0.0) | st.floats(0.0, 6.3),
    revolutions=st.floats(1e-3, 1.27), steps=st.integers(1, 12), share=st.floats(0.0, 1.0),
    backwards=st.booleans(), mirrored=st.booleans(),
)  # fmt: skip
def test_two_bodies_are_right_to_ulps_of_their_start(
    rest: float, anomaly: float, ratio: float, turn: float, revolutions: float, steps: int,
    share: float, backwards: bool, mirrored: bool,
) -> None:  # fmt: skip
    """Also between the steps' ends; 1 - e from 1e-12 to 1, any start, step, masses, direction."""
    masses, q, v = of_an_orbit(10.0**rest, anomaly, ratio, turn, mirrored)
    problem = galvi.Problem(galvi.NBody(masses), q, v)
    mu, Q, V = relative(masses, q, v)
    beta = 2 * mu / mp.sqrt(mp.fdot(Q, Q)) - mp.fdot(V, V)
    if beta <= 0:  # by rounding of the start
        with pytest.raises(ValueError, match="needs bound orbits"):
            galvi.integrate(problem, FRAME, 0.1, 1)
        return
    period = float(2 * mp.pi * mu / beta**1.5)
    h = revolutions * period * (-1.0 if backwards else 1.0)
    run = galvi.integrate(problem, FRAME, h, steps)
    assert run.status == "Completed.", run.status
    between = float(run.t[-1] - share * h)
    ends = mp.mpf(h) * steps, run.q[-1], run.v[-1]
    for t, place, speed in (ends, (mp.mpf(between), run(between), run.velocity(between))):
        true, most = changed_by_ulps(masses, q, v, t)
        by_time = truth(masses, q, v, t * (1 + mp.mpf(2) ** -53)) - true  # t is rounded too
        for found, x, bound, late in zip((place, speed), true, most, by_time, strict=True):
            error = size(found[1] - found[0] - x)
            rounding = 2.0**-53 * float(np.max(np.abs(found))) + size(late)
            assert error <= ULPS * (bound + rounding), (t, error, bound)


@pytest.mark.parametrize("rest", [1e-4, 1e-6, 1e-8])
def test_places_without_their_low_parts_are_seen(rest: float) -> None:
    """The planted fault: a motion in double-doubles between places in doubles."""
    masses, q, v = of_an_orbit(rest, np.pi, 0.0, 0.4, False)
    state = np.zeros((2, 8, 2))
    state[:, 4], state[:, 6] = q[1], v[1]
    h, steps, errors = np.pi / 10.0, 20, []
    for fault, one in enumerate(state):
        for _ in range(steps):
            near_parabola.follow_near_parabola(1.0, h, one, 0, 1, 2)
            one[5::2] *= 1.0 - fault
        true, most = changed_by_ulps(masses, q, v, mp.mpf(h) * steps)
        errors.append(size(one[4] - true[0]) / (most[0] + 2.0**-53 * size(true[0])))
    assert errors[0] < 1.0 and errors[1] > 10.0 * ULPS, errors


def test_an_orbit_that_is_not_bound_is_named_before_and_during_a_run() -> None:
    masses, q, v = of_an_orbit(1e-9, 0.0, 0.0, 0.0, False)
    problem = galvi.Problem(galvi.NBody(masses), q, v, parameters={"bodies": ("Sun", "comet")})
    fast = problem.with_initial_state(q, v * (1.0 + 1e-9))
    with pytest.raises(ValueError, match="received one of body comet that is not, at the start"):
        galvi.integrate(fast, FRAME, 0.1, 1)
    long = galvi.integrate(problem, FRAME, 8.1, 3).status
    assert "the step is 1.29 revolutions of body comet, more than the Kepler frame covers" in long
    said = galvi.KeplerFrame().leaves(fast, 0.1)
    assert said.startswith("the orbit of body comet is not bound any more, which the Kepler frame")
    assert said.endswith("Use another chart from there on.")


def test_bodies_that_pass_are_not_said_to_collide() -> None:
    """Into the pass, and from it; where a smaller step would help, it is what is said."""
    plain = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))

    def status(rest: float, anomaly: float, h: float, forces: Any = ()) -> str:
        masses, q, v = of_an_orbit(rest, anomaly, 1e-3, 0.0, False)
        problem = galvi.Problem(galvi.NBody(masses, forces=forces), q, v)
        run = galvi.integrate(problem, plain, h, int(4.0 / h))
        assert not run.success or run.status.startswith("Completed, but"), run.status
        return run.status

    adapt = "Use chart=galvi.KeplerFrame(), or clock=galvi.DynamicalTime(), whose steps follow"
    for anomaly, h in ((0.0, 0.3), (0.0, 1e-2), (np.pi, 0.3), (np.pi, 0.05)):
        said = status(1e-7, anomaly, h)
        assert "collide" not in said and "at a distance of about 1.0e-07" in said, said
        assert adapt in said and "smaller step" not in said, said
    assert "Use a smaller step or a higher degree." in status(1e-2, 0.0, 0.1)
    said = status(1e-7, 0.0, 0.3, galvi.Force(lambda q: 0.0 * q))  # which no frame takes
    assert "Use clock=galvi.DynamicalTime(), whose steps follow" in said and "Frame" not in said


def test_the_body_that_is_too_near_a_parabola_for_a_step_is_named() -> None:
    """Body 1 goes round in 2 pi, on a circle; body 2 is at a pericentre of 0.0012."""
    q, v = np.zeros((3, 2)), np.zeros((3, 2))
    q[1, 0], v[1, 1] = 1.0, 1.0
    q[2, 1], v[2, 0] = 1.2 * (1.0 - 0.999), np.sqrt(1.999 / 0.001 / 1.2)
    problem = galvi.Problem(galvi.NBody([1.0, 1e-9, 1e-9]), q, v)
    said = galvi.KeplerFrame().leaves(problem, 1.1 * 2.0 * np.pi)
    assert "revolutions of body 2" in said, said


def test_massless_bodies_do_not_collide_and_unbound_ones_are_not_sent_to_the_frame() -> None:
    q = np.array([[0.0, 0.0], [1.0, 0.0], [3.0, 2.0]])
    v = np.array([[0.0, 0.0], [0.0, 1.0], [0.5, 0.0]])
    two = galvi.Galerkin(galvi.Polynomials(2), galvi.gauss(2))
    run = galvi.integrate(galvi.Problem(galvi.NBody([1.0, 0.0, 0.0]), q, v), two, 10.0, 5)
    assert "bodies 0 and 1" in run.status, run.status
    passing = galvi.Problem(
        galvi.NBody([1.0, 0.1]), [[0.0, 0.0], [-10.0, 1e-3]], [[0.0, 0.0], [1.0, 0.0]]
    )
    six = galvi.Galerkin(galvi.Polynomials(6), galvi.gauss(6))
    run = galvi.integrate(passing, six, 0.3, 60)
    assert "KeplerFrame" not in run.status and "DynamicalTime()" in run.status, run.status
