"""Events on the curves of a run: every root of a step, at times of the steps' order."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import galvi

EIGHT = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
CLOCK = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8), clock=galvi.DynamicalTime())
OSCILLATOR = galvi.problems.harmonic_oscillator()


def orbit(e: float = 0.3) -> galvi.Problem:
    """Two bodies from the pericentre, a = 1, G (m + m) = 1, inclined."""
    speed = math.sqrt((1.0 + e) / (1.0 - e))
    q = [[0.0, 0.0, 0.0], [1.0 - e, 0.0, 0.0]]
    v = [[0.0, 0.0, 0.0], [0.0, speed * 0.8, speed * 0.6]]
    return galvi.Problem(galvi.NBody([0.9, 0.1]), q, v, parameters={"bodies": ("star", "planet")})


@pytest.mark.parametrize("method", [EIGHT, CLOCK])
def test_apsides_are_at_multiples_of_half_a_period(method: Any) -> None:
    run = galvi.integrate(orbit(), method, 0.4, duration=40.0)
    found = galvi.find_events(run, galvi.events.apsis("planet", "star"))
    assert len(found) == 12  # that at the start is none
    assert np.max(np.abs(found.t - math.pi * np.arange(1, 13))) < 1e-10
    assert np.allclose(found.value[::2], 1.3, atol=1e-11)
    assert np.allclose(found.value[1::2], 0.7, atol=1e-11)
    near = galvi.find_events(run, galvi.events.closest_approach(1, 0))
    assert np.array_equal(near.t, found.t[1::2])


@given(st.floats(-0.999, 0.999), st.floats(0.2, 1.5), st.sampled_from([-1, 0, 1]))
@settings(max_examples=25, deadline=None)
def test_every_crossing_of_an_oscillator_is_found_once(
    level: float, step: float, direction: int
) -> None:
    run = galvi.integrate(OSCILLATOR, EIGHT, step, 40)
    event = galvi.Event(lambda q, v, t: q[0] - level, direction)
    found = galvi.find_events(run, event)
    first = math.acos(level)
    falls = first + 2.0 * math.pi * np.arange(60)
    rises = 2.0 * math.pi - first + 2.0 * math.pi * np.arange(60)
    every = {1: rises, -1: falls, 0: np.sort(np.concatenate([falls, rises]))}[direction]
    expected = every[every < run.t[-1]]
    assert len(found) == len(expected)
    assert np.max(np.abs(found.t - expected), initial=0.0) < 1e-9
    assert np.allclose(found.q[:, 0], level, atol=1e-9)


def test_two_roots_within_a_step_that_nearly_touch_are_found() -> None:
    run = galvi.integrate(OSCILLATOR, EIGHT, 0.9, 100)
    close = galvi.find_events(run, galvi.Event(lambda q, v, t: q[0] - 1.0 + 1e-9))
    assert len(close) == 2 * 14 + 1  # the first one leaves the start
    none = galvi.find_events(run, galvi.Event(lambda q, v, t: q[0] - 1.0 - 1e-9))
    assert len(none) == 0


def test_times_have_the_order_of_the_steps_and_not_of_the_curve() -> None:
    three = galvi.Galerkin(galvi.Polynomials(3), galvi.gauss(3))
    errors, steps = [], np.array([0.5, 0.4, 0.3])
    for h in steps:
        run = galvi.integrate(OSCILLATOR, three, h, math.ceil(12.0 / h))
        t = galvi.find_events(run, galvi.Event(lambda q, v, t: q[0] - 0.3, 1)).t[:1]
        errors.append(abs(float(t[0]) - (2.0 * math.pi - math.acos(0.3))))
    order = np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert 5.3 < order < 6.7, (order, errors)


def test_roots_at_the_ends_of_steps_are_counted_once() -> None:
    run = galvi.integrate(OSCILLATOR, EIGHT, math.pi / 4, 64)
    found = galvi.find_events(run, galvi.Event(lambda q, v, t: q[0]))
    assert len(found) == 16 and np.allclose(np.diff(found.t), math.pi, atol=1e-9)
    back = galvi.integrate(OSCILLATOR, EIGHT, -math.pi / 4, 64)
    assert np.allclose(galvi.find_events(back, galvi.Event(lambda q, v, t: q[0])).t, -found.t)


def test_transits_and_planes_and_distances() -> None:
    run = galvi.integrate(orbit(), EIGHT, 0.2, 200)
    asked = [
        galvi.events.transit("planet", "star", (1.0, 0.0, 0.0)),
        galvi.events.plane_crossing((0.0, 1.0, 0.0), body="planet"),
        galvi.events.within(0, 1, 1.0),
    ]
    found = galvi.find_events(run, asked)
    assert np.all(np.diff(found.t) >= 0.0) and set(found.index) == {0, 1, 2}
    transits = found["t"][found["index"] == 0]
    assert len(transits) == 6 and np.allclose(np.diff(transits), 2.0 * math.pi, atol=1e-9)
    distances = np.linalg.norm(found.q[:, 0] - found.q[:, 1], axis=1)[found.index == 2]
    assert np.allclose(distances, 1.0, atol=1e-11) and len(distances) == 13
    table = found.to_frame()
    assert list(table.columns) == ["t", "name", "step", "value", "index"]
    assert "transit of planet in front of star" in set(table["name"])


def test_angles_of_a_pendulum_pass_up_to_whole_turns() -> None:
    problem = galvi.Problem(galvi.Canonical(1.0, galvi.CosinePotential(1.0)), [0.0], [2.5])
    run = galvi.integrate(problem, EIGHT, 0.2, 100)
    found = galvi.find_events(run, galvi.events.angle(0, 1.0))
    turns = (found.value - 1.0) / (2.0 * math.pi)
    assert len(found) == math.floor((run.q[-1, 0] - 1.0) / (2.0 * math.pi)) + 1
    assert np.allclose(turns, np.arange(len(found)), atol=1e-9)


def two_rods() -> Any:
    shoulder, elbow = (galvi.Joint("hinge", (0, 1, 0), name=n) for n in ("shoulder", "elbow"))
    links = (galvi.Link(shoulder, 1.0, (0, 0, -1), 0.1), galvi.Link(elbow, 1.0, (0, 0, -2), 0.1, 0))
    problem = galvi.Problem(galvi.Multibody(links), [1.0, 0.5], [0.0, 0.0])
    return galvi.integrate(problem, EIGHT, 0.05, 40)


def test_a_joint_is_given_by_number_or_by_name() -> None:
    run = two_rods()
    named, numbered = (
        galvi.find_events(run, galvi.events.angle(joint, 0.2)) for joint in ("elbow", 1)
    )
    assert len(named) > 0 and np.array_equal(named.t, numbered.t)
    with pytest.raises(ValueError, match=r"a joint must be one of \['shoulder', 'elbow'\], or"):
        galvi.find_events(run, galvi.events.angle("wrist", 0.2))
    arm = galvi.integrate(galvi.problems.skew_arm(), EIGHT, 0.01, 2)  # without names
    for name in ("elbow", ""):
        with pytest.raises(ValueError, match=f"must be a number below 3; received '{name}'"):
            galvi.find_events(arm, galvi.events.angle(name, 0.2))


@pytest.fixture(scope="module")
def hip_and_knee() -> Any:
    """A run of a thigh on a ball joint and a shin on a hinge, whose angle is entry 9 of q."""
    hip = galvi.Link(galvi.Joint("ball", name="hip"), 1.0, (0, 0, -0.5), 0.01)
    knee = galvi.Joint("hinge", axis=(0, 1, 0), name="knee")
    shin = galvi.Link(knee, 1.0, (0, 0, -0.5), 0.01, parent=0, place=(0, 0, -1))
    legs = galvi.Multibody([hip, shin])
    start = legs.group.join(np.eye(3), np.zeros(1))
    return galvi.integrate(galvi.Problem(legs, start, [1.0, 0.0, 0.0, 2.0]), EIGHT, 0.02, 50)


@pytest.mark.slow(beside="test_a_joint_is_given_by_number_or_by_name")
def test_a_joint_beside_a_ball_joint_is_given_by_its_name(hip_and_knee: Any) -> None:
    named, numbered = (
        galvi.find_events(hip_and_knee, galvi.events.angle(joint, 0.0)) for joint in ("knee", 9)
    )
    assert len(named) == 3 and np.array_equal(named.t, numbered.t)
    free = galvi.Multibody([galvi.Link(galvi.Joint("free", name="base"), 1.0, inertia=1.0)])
    height = galvi.integrate(
        galvi.Problem(free, free.group.join([0, 0, 1.0], np.eye(3)), np.zeros(6)), EIGHT, 0.1, 10
    )
    assert galvi.find_events(height, galvi.events.angle(2, 0.5)).t == pytest.approx(
        [math.sqrt(1.0 / 9.81)], abs=1e-13
    )


@pytest.mark.parametrize("joint, words", [
    ("hip", "one angle or length; received 'hip', a ball joint"),
    ("ankle", r"must be one of \['knee'\], or its number; received 'ankle'"),
    (1, "received 1, an entry of the rotation matrix of a ball joint"),
])  # fmt: skip
def test_what_has_no_angle_is_refused(joint: Any, words: str, hip_and_knee: Any) -> None:
    with pytest.raises(ValueError, match=words):
        galvi.find_events(hip_and_knee, galvi.events.angle(joint, 0.0))


def test_two_joints_or_bodies_of_one_name_are_refused_where_it_is_used() -> None:
    bend = galvi.Joint("hinge", (0, 1, 0), name="bend")
    links = (galvi.Link(bend, 1.0, (0, 0, -1)), galvi.Link(bend, 1.0, (0, 0, -2), 0.0, 0))
    problem = galvi.Problem(galvi.Multibody(links), [1.0, 0.5], [0.0, 0.0])
    run = galvi.integrate(problem, EIGHT, 0.05, 2)
    galvi.find_events(run, galvi.events.angle(1, 0.2))
    with pytest.raises(ValueError, match=r"received 'bend', the name of numbers \[0, 1\]"):
        galvi.find_events(run, galvi.events.angle("bend", 0.2))
    pair = replace(orbit(), parameters={"bodies": ("star", "star")})
    run = galvi.integrate(pair, EIGHT, 0.1, 2)
    with pytest.raises(ValueError, match="a body must have a name of its own; received 'star'"):
        galvi.find_events(run, galvi.events.apsis("star", 0))


REFUSED = [
    (lambda: galvi.Event(3), "must be a function"),
    (lambda: galvi.Event(lambda q, v, t: 0.0, 2), "direction"),
    (lambda: galvi.find_events(run_of(), [3]), "galvi.Event values"),
    (lambda: galvi.find_events(run_of(), galvi.events.apsis("moon", 0)), "a body must be one of"),
    (lambda: galvi.find_events(run_of(), galvi.events.apsis(1, 1)), "two bodies"),
    (lambda: galvi.find_events(run_of(), galvi.events.angle(0, 1.0)), "coordinate of a vector"),
    (lambda: galvi.find_events(run_of(), galvi.Event(lambda q, v, t: np.nan)), "finite number"),
    (lambda: galvi.find_events(3, galvi.events.apsis(1, 0)), "runs of galvi.integrate"),
    (lambda: galvi.events.within(0, 1, -1.0), "distance"),
    (lambda: galvi.events.plane_crossing((0.0, 0.0)), "vector other than 0"),
]  # fmt: skip


def run_of() -> Any:
    return galvi.integrate(orbit(), EIGHT, 0.2, 5)


@pytest.mark.parametrize(("call", "words"), REFUSED)
def test_bad_events_are_refused_in_words(call: Any, words: str) -> None:
    with pytest.raises((ValueError, TypeError), match=words):
        call()


def test_a_run_that_was_resumed_has_the_events_from_its_own_begin() -> None:
    for method in (EIGHT, CLOCK):
        whole = galvi.integrate(orbit(), method, 0.4, duration=20.0)
        part = galvi.integrate(orbit(), method, 0.4, duration=8.0)
        found = galvi.find_events(galvi.resume(part, until=20.0), galvi.events.apsis(1, 0))
        every = galvi.find_events(whole, galvi.events.apsis(1, 0))
        assert np.allclose(found.t, every.t[every.t > 8.0], atol=1e-9)


FREE = galvi.Problem(galvi.Canonical(1.0, galvi.UniformField([0.0])), [0.0], [1.0], name="free")


@pytest.mark.slow_cases("1-1")
@pytest.mark.parametrize(("power", "many"), [(1, 1), (3, 1), (9, 1), (0, 0)])
def test_a_multiple_root_is_one_event_and_a_function_that_is_0_none(power: int, many: int) -> None:
    run = galvi.integrate(FREE, EIGHT, 0.7, 10)
    event = galvi.Event(lambda q, v, t: (q[0] - 3.0) ** power if power else 0.0 * q[0])
    found = galvi.find_events(run, event)
    assert len(found) == many and np.all(np.abs(found.t - 3.0) < 0.1)


@pytest.mark.parametrize("value", [5e-324, -1e-310, 1e300, -1e300])
def test_a_constant_however_small_or_large_has_no_event(value: float) -> None:
    run = galvi.integrate(galvi.problems.double_pendulum(), EIGHT, -0.1, 12)
    assert len(galvi.find_events(run, galvi.Event(lambda q, v, t: value, -1))) == 0


def test_states_at_many_times_are_those_at_each() -> None:
    for problem, save_every in ((orbit(), 1), (orbit(), 4), (galvi.problems.heavy_top(), 4)):
        run = galvi.integrate(problem, EIGHT, 0.1, 22, save_every=save_every)
        times = np.array([0.03, 2.2, 0.0, 1.0, 0.7123, 1.4])
        q, p = galvi.states_at(run, times)
        for k, t in enumerate(times.tolist()):
            for some, one in zip((q, p), galvi.states_at(run, t), strict=True):
                assert np.array_equal(some[k], one)
        assert np.max(np.abs(q - run(times))) < 1e-9
