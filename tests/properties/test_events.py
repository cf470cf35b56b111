"""Events on the curves of a run: every root of a step, at times of the steps' order."""

from __future__ import annotations

import functools
import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import galvi
from galvi.curves.clock_curves import ClockCurves
from galvi.curves.curves import FrameCurves
from galvi.events import bound_events
from galvi.run.states import RunStates

EIGHT = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
FRAME = galvi.Galerkin(galvi.Polynomials(6), galvi.gauss(6), chart=galvi.KeplerFrame())
FRAME_LINEAR_TIME = galvi.Galerkin(
    galvi.Polynomials(8), galvi.gauss(8), chart=galvi.KeplerFrame(even=True)
)
NESTED = galvi.Galerkin(
    galvi.Polynomials(8), galvi.gauss(8), chart=galvi.KeplerFrame(hierarchy=(0, (1, 2), 3))
)
CLOCK = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8), clock=galvi.DynamicalTime())
SUNDMAN = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8), clock=galvi.Sundman())
OSCILLATOR = galvi.problems.harmonic_oscillator()
OUTER = galvi.problems.outer_solar_system()
FREE = galvi.Problem(galvi.Canonical(1.0, galvi.UniformField([0.0])), [0.0], [1.0], name="free")
fast = pytest.mark.skipif(not galvi.FAST, reason="the general kernel alone has none")


def orbit(e: float = 0.3) -> galvi.Problem:
    """Two bodies from the pericentre, a = 1, G (m + m) = 1, inclined."""
    speed = math.sqrt((1.0 + e) / (1.0 - e))
    q = [[0.0, 0.0, 0.0], [1.0 - e, 0.0, 0.0]]
    v = [[0.0, 0.0, 0.0], [0.0, speed * 0.8, speed * 0.6]]
    return galvi.Problem(galvi.NBody([0.9, 0.1]), q, v, parameters={"bodies": ("star", "planet")})


# ---------------------------------------------------------------- closed forms


@pytest.mark.parametrize("method", [EIGHT, CLOCK])
def test_apsides_are_at_multiples_of_half_a_period(method: Any) -> None:
    run = galvi.integrate(orbit(), method, 0.4, duration=40.0)
    apsides = galvi.find_events(run, galvi.events.apsis("planet", "star"))
    assert len(apsides) == 12  # the one at the start does not count
    assert np.max(np.abs(apsides.t - math.pi * np.arange(1, 13))) < 1e-10
    assert np.allclose(apsides.value[::2], 1.3, atol=1e-11)
    assert np.allclose(apsides.value[1::2], 0.7, atol=1e-11)
    approaches = galvi.find_events(run, galvi.events.closest_approach(1, 0))
    assert np.array_equal(approaches.t, apsides.t[1::2])
    part = galvi.integrate(orbit(), method, 0.4, duration=8.0)
    resumed = galvi.find_events(galvi.resume(part, until=40.0), galvi.events.apsis(1, 0))
    assert np.allclose(resumed.t, apsides.t[apsides.t > 8.0], atol=1e-9)


@given(st.floats(-0.999, 0.999), st.floats(0.2, 1.5), st.sampled_from([-1, 0, 1]))
def test_every_crossing_of_an_oscillator_is_found_once(
    level: float, step: float, direction: int
) -> None:
    run = galvi.integrate(OSCILLATOR, EIGHT, step, 40)
    event = galvi.Event(lambda q, v, t: q[0] - level, direction)
    crossings = galvi.find_events(run, event)
    first = math.acos(level)
    falls = first + 2.0 * math.pi * np.arange(60)
    rises = 2.0 * math.pi - first + 2.0 * math.pi * np.arange(60)
    candidates = {1: rises, -1: falls, 0: np.sort(np.concatenate([falls, rises]))}[direction]
    expected = candidates[candidates < run.t[-1]]
    assert len(crossings) == len(expected)
    assert np.max(np.abs(crossings.t - expected), initial=0.0) < 1e-9
    assert np.allclose(crossings.q[:, 0], level, atol=1e-9)


def test_two_roots_within_a_step_that_nearly_touch_are_found() -> None:
    run = galvi.integrate(OSCILLATOR, EIGHT, 0.9, 100)
    close = galvi.find_events(run, galvi.Event(lambda q, v, t: q[0] - 1.0 + 1e-9))
    assert len(close) == 2 * 14 + 1  # the first one leaves the start
    none = galvi.find_events(run, galvi.Event(lambda q, v, t: q[0] - 1.0 - 1e-9))
    assert len(none) == 0


def test_roots_at_the_ends_of_steps_are_counted_once() -> None:
    run, back = (galvi.integrate(OSCILLATOR, EIGHT, h * math.pi / 4, 64) for h in (1, -1))
    crossings, before = (
        galvi.find_events(motion, galvi.Event(lambda q, v, t: q[0])) for motion in (run, back)
    )
    assert len(crossings) == 16 and np.allclose(np.diff(crossings.t), math.pi, atol=1e-9)
    assert np.allclose(before.t, -crossings.t)


def test_transits_and_planes_and_distances() -> None:
    run = galvi.integrate(orbit(), EIGHT, 0.2, 200)
    events = [
        galvi.events.transit("planet", "star", (1.0, 0.0, 0.0)),
        galvi.events.plane_crossing((0.0, 1.0, 0.0), body="planet"),
        galvi.events.within(0, 1, 1.0),
    ]
    hits = galvi.find_events(run, events)
    assert np.all(np.diff(hits.t) >= 0.0) and set(hits.index) == {0, 1, 2}
    transits = hits["t"][hits["index"] == 0]
    assert len(transits) == 6 and np.allclose(np.diff(transits), 2.0 * math.pi, atol=1e-9)
    distances = np.linalg.norm(hits.q[:, 0] - hits.q[:, 1], axis=1)[hits.index == 2]
    assert np.allclose(distances, 1.0, atol=1e-11) and len(distances) == 13
    table = hits.to_frame()
    assert list(table.columns) == ["t", "name", "step", "value", "index"]
    assert "transit of planet in front of star" in set(table["name"])


def test_angles_of_a_pendulum_pass_up_to_whole_turns() -> None:
    problem = galvi.Problem(galvi.Canonical(1.0, galvi.CosinePotential(1.0)), [0.0], [2.5])
    run = galvi.integrate(problem, EIGHT, 0.2, 100)
    hits = galvi.find_events(run, galvi.events.angle(0, 1.0))
    revolutions = (hits.value - 1.0) / (2.0 * math.pi)
    assert len(hits) == math.floor((run.q[-1, 0] - 1.0) / (2.0 * math.pi)) + 1
    assert np.allclose(revolutions, np.arange(len(hits)), atol=1e-9)


def test_a_joint_is_given_by_number_or_by_name() -> None:
    """In a configuration the height of the torso is entry 2, and the angle of the knee entry 12."""
    torso = galvi.Link(galvi.Joint("free", name="torso"), 1.0, inertia=1.0)
    knee = galvi.Joint("hinge", axis=(0, 1, 0), name="knee")
    tree = galvi.Multibody([torso, galvi.Link(knee, 1.0, (0, 0, -0.5), 0.01, parent=0)])
    start = tree.group.join([0, 0, 1.0], np.eye(3), np.array([0.5]))
    run = galvi.integrate(galvi.Problem(tree, start, [*np.zeros(6), -2.0]), EIGHT, 0.05, 10)
    named, numbered, height = (
        galvi.find_events(run, galvi.events.angle(joint, at))
        for joint, at in (("knee", 0.2), (12, 0.2), (2, 0.5))
    )
    assert len(named) > 0 and np.array_equal(named.t, numbered.t)
    assert np.allclose(named.q[:, 12], 0.2, atol=1e-9)
    assert len(height) == 1 and abs(height.q[0, 2] - 0.5) < 1e-9


@pytest.mark.slow_cases("1-1")
@pytest.mark.parametrize(("power", "expected_count"), [(1, 1), (3, 1), (9, 1), (0, 0)])
def test_a_multiple_root_is_one_event_and_a_function_that_is_0_none(
    power: int, expected_count: int
) -> None:
    run = galvi.integrate(FREE, EIGHT, 0.7, 10)
    event = galvi.Event(lambda q, v, t: (q[0] - 3.0) ** power if power else 0.0 * q[0])
    hits = galvi.find_events(run, event)
    assert len(hits) == expected_count and np.all(np.abs(hits.t - 3.0) < 0.1)


@given(st.lists(st.floats(0.05, 5.95), min_size=1, max_size=5, unique=True), st.floats(0.3, 1.1))
def test_polynomials_of_a_uniform_motion_have_their_roots(roots: list[float], step: float) -> None:
    roots = sorted({round(root, 3) for root in roots})

    def polynomial(q: Any, v: Any, t: Any) -> Any:
        value = 1.0
        for root in roots:
            value = value * (q[0] - root)
        return value

    run = galvi.integrate(FREE, EIGHT, step, math.ceil(6.0 / step))
    hits = galvi.find_events(run, galvi.Event(polynomial))
    inside = [root for root in roots if root <= run.t[-1]]
    assert len(hits) == len(inside)
    assert np.max(np.abs(hits.t - inside), initial=0.0) < 1e-9
    # the same, called one state after another
    called = galvi.find_events(run, galvi.Event(lambda q, v, t: float(polynomial(q, v, t))))
    assert "could not be traced" in called.status and len(called) == len(hits)


@pytest.mark.parametrize("value", [5e-324, -1e-310, 1e300, -1e300])
def test_a_constant_however_small_or_large_has_no_event(value: float) -> None:
    run = galvi.integrate(FREE, EIGHT, -0.1, 12)
    assert len(galvi.find_events(run, galvi.Event(lambda q, v, t: value, -1))) == 0


def test_states_at_many_times_are_those_at_each() -> None:
    for problem, save_every in ((orbit(), 1), (orbit(), 4), (galvi.problems.heavy_top(), 4)):
        run = galvi.integrate(problem, EIGHT, 0.1, 22, save_every=save_every)
        times = np.array([0.03, 2.2, 0.0, 1.0, 0.7123, 1.4])
        q, p = galvi.states_at(run, times)
        for k, t in enumerate(times.tolist()):
            for rows, expected in zip((q, p), galvi.states_at(run, t), strict=True):
                assert np.array_equal(rows[k], expected)
        assert np.max(np.abs(q - run(times))) < 1e-9


# ---------------------------------------------------------------- many steps, in frames and clocks


def planets(ratio: float, n: int = 4, e: float = 0.0, mass: float = 1e-5) -> galvi.Problem:
    """A star and n planets at apocentre, whose semi-major axes grow by factors of ``ratio``."""
    a, phase = ratio ** np.arange(n), 2.4 * np.arange(n)
    q, v = np.zeros((n + 1, 3)), np.zeros((n + 1, 3))
    radial_directions = np.stack([np.cos(phase), np.sin(phase), 0.01 * np.cos(3.0 * phase)], axis=1)
    tangential_directions = np.stack([-np.sin(phase), np.cos(phase), 0.0 * phase], axis=1)
    q[1:] = (a * (1.0 + e))[:, None] * radial_directions
    v[1:] = np.sqrt((1.0 - e) / (1.0 + e) / a)[:, None] * tangential_directions
    return galvi.Problem(galvi.NBody(np.append(1.0, np.full(n, mass))), q, v)


def moon() -> galvi.Problem:
    """A star, a planet with a moon, and another planet."""
    q = np.array([[0.0, 0.0], [1.0, 0.0], [1.01, 0.0], [-3.0, 0.1]])
    v = np.array([[0.0, 0.0], [0.0, 1.0], [0.0, 1.0 + 0.1**0.5], [0.0, -(3.0**-0.5)]])
    return galvi.Problem(galvi.NBody(np.array([1.0, 1e-3, 1e-6, 1e-4])), q, v)


RUNS: dict[str, Any] = {  # problem, method, step, duration or number of steps
    "frame": (OUTER, FRAME, 400.0, {"steps": 300}),
    "frame, long steps": (planets(1.4), FRAME_LINEAR_TIME, 2.0, {"steps": 60}),
    "frame backwards, eccentric": (planets(1.9, 3, 0.3), FRAME_LINEAR_TIME, -1.0, {"steps": 150}),
    "frame, pairs": (moon(), NESTED, 0.015, {"steps": 400}),
    "clock": (OUTER, CLOCK, 0.4, {"duration": 1.2e5}),
    "clock backwards": (planets(1.4, 3, 0.3), CLOCK, -0.2, {"duration": 30.0}),
    "own clock": (galvi.problems.kepler(0.6), SUNDMAN, 0.3, {"duration": 40.0}),
}


def run_of(name: str) -> galvi.Trajectory:
    *arguments, length = RUNS[name]
    return galvi.integrate(*arguments, **length)


def crossings_by_bisection(run: Any, function: Any, points: int = 150) -> Any:
    """The times at which a function of many states (q, v, t) changes sign on the curves of a run:
    from ``points`` times in each step, by bisection. A root at the start does not count."""
    t = np.concatenate(
        [
            a + (b - a) * np.arange(points) / points
            for a, b in zip(run.t[:-1], run.t[1:], strict=True)
        ]
    )

    def value(t: Any) -> Any:
        return function(run(t), run.velocity(t), t)

    values = value(t)
    k = np.flatnonzero(values[1:] * values[:-1] < 0.0)
    k = k[k > 0]  # a root at the start does not count
    low, high, sign = t[k].copy(), t[k + 1].copy(), np.sign(values[k])
    for _ in range(45):
        middle = 0.5 * (low + high)
        before = value(middle) * sign > 0.0
        low, high = np.where(before, middle, low), np.where(before, high, middle)
    return 0.5 * (low + high)


def radial(q: Any, v: Any, t: Any) -> Any:
    """q . v of body 1 relative to body 2, or of a single body, for many states."""
    if q.ndim == 2:
        return np.sum(q * v, axis=1)
    return np.sum((q[:, 1] - q[:, 2]) * (v[:, 1] - v[:, 2]), axis=1)


@fast
@pytest.mark.slow_cases(but=["frame, long steps", "clock backwards"])
@pytest.mark.parametrize("name", RUNS)
def test_events_of_many_steps_are_those_of_a_dense_search(name: str) -> None:
    run = run_of(name)
    assert run.success, run.status
    event = galvi.events.apsis(1, 2)
    if run.q.ndim == 2:
        event = galvi.Event(lambda q, v, t: q[0] * v[0] + q[1] * v[1])
    hits, expected = galvi.find_events(run, event), crossings_by_bisection(run, radial)
    assert hits.status == "" and len(expected) > 5
    assert len(hits) == len(expected)
    step = np.abs(np.diff(run.t)).max()
    assert np.max(np.abs(hits.t - expected)) < 1e-6 * step  # 5e-7: that of the curves
    if hits.q.ndim == 3:
        distances = np.linalg.norm(hits.q[:, 1] - hits.q[:, 2], axis=1)
        assert np.allclose(hits.value, distances, rtol=1e-14)
        states = galvi.states_at(run, hits.t[:3])[0]
        assert np.allclose(hits.q[:3], states, rtol=1e-11, atol=1e-11 * np.abs(states).max())


@fast
@pytest.mark.parametrize("name", ["frame", "clock"])
def test_a_function_of_velocity_and_time_is_found_in_frames_and_clocks(name: str) -> None:
    run = run_of(name)
    middle = 0.41234 * run.t[-1]
    hits = galvi.find_events(run, galvi.Event(lambda q, v, t: v[1, 0] * (t - middle)))
    expected = crossings_by_bisection(run, lambda q, v, t: v[:, 1, 0] * (t - middle), 40)
    assert len(hits) == len(expected) > 20
    assert np.max(np.abs(hits.t - expected)) < 1e-6 * np.abs(np.diff(run.t)).max()


# ---------------------------------------------------------------- all pairs

NEAR = planets(1.06, 6, mass=3e-6)
METHODS = {"equal": (EIGHT, 0.3, 1000), "frame": (FRAME, 0.6, 500), "clock": (CLOCK, 0.2, 3000)}


@fast
@pytest.mark.parametrize("name", METHODS)
def test_one_event_of_all_pairs_is_those_of_each(name: str) -> None:
    run = galvi.integrate(NEAR, *METHODS[name])
    all_pairs = galvi.find_events(run, galvi.events.within("any", "any", 0.1))
    pairs = [galvi.events.within(i, j, 0.1) for i in range(7) for j in range(i + 1, 7)]
    by_pair = galvi.find_events(run, pairs)
    assert len(all_pairs) > 10 and len(set(all_pairs.name)) > 3
    assert np.array_equal(all_pairs.t, by_pair.t) and all_pairs.name == by_pair.name
    assert np.array_equal(all_pairs.value, by_pair.value) and np.all(all_pairs.index == 0)
    with_body_3 = galvi.find_events(run, galvi.events.within("any", 3, 0.1))
    rows_with_body_3 = [
        k for k, name in enumerate(by_pair.name) if name.startswith("3 ") or " and 3 " in name
    ]
    assert np.array_equal(with_body_3.t, by_pair.t[rows_with_body_3]) and len(rows_with_body_3) > 0


@fast
@pytest.mark.parametrize("name", ["frame", "clock"])
def test_no_place_is_sought_and_no_state_reached_by_itself(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = run_of(name)
    for kind in (FrameCurves, ClockCurves):
        for part in ("position", "velocity"):
            monkeypatch.setattr(kind, part, lambda *arguments: pytest.fail("a place by itself"))
    monkeypatch.setattr(RunStates, "__call__", lambda *arguments: pytest.fail("a state by itself"))
    assert len(galvi.find_events(run, galvi.events.apsis(1, 2))) > 5


@fast
def test_pairs_that_stay_apart_cost_bounds_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    run = galvi.integrate(planets(1.5, 8), CLOCK, 0.2, duration=40.0)
    monkeypatch.setattr(
        bound_events.Function, "__init__", lambda *arguments: pytest.fail("a pair by itself")
    )
    assert len(galvi.find_events(run, galvi.events.within("any", "any", 0.05))) == 0


@fast
def test_hill_radii_are_those_of_the_pair_at_that_time() -> None:
    run = galvi.integrate(NEAR, EIGHT, 0.3, 1000)

    def outside(q: Any, v: Any, t: Any) -> Any:
        star, inner, outer = q[:, 0], q[:, 2], q[:, 3]
        norm = functools.partial(np.linalg.norm, axis=1)
        summed_distances = norm(inner - star) + norm(outer - star)
        return norm(inner - outer) - 7.0 * np.cbrt(2e-6) * 0.5 * summed_distances

    expected = crossings_by_bisection(run, outside, 8)
    pair = galvi.find_events(run, galvi.events.within(2, 3, hill_radii=7.0))
    assert len(pair) == len(expected) > 2 and np.max(np.abs(pair.t - expected)) < 1e-7
    all_pairs = galvi.find_events(run, galvi.events.within("any", "any", hill_radii=7.0))
    is_pair = [name == "2 and 3 at 7 Hill radii" for name in all_pairs.name]
    assert np.array_equal(pair.t, all_pairs.t[is_pair]) and len(all_pairs) > 10


@fast
def test_an_event_of_all_pairs_ends_a_run_and_names_the_pair(tmp_path: Any) -> None:
    event = galvi.events.within("any", "any", 0.1)
    watched = galvi.integrate(NEAR, EIGHT, 0.3, 1000, events=event)
    assert len(galvi.find_events(watched, galvi.events.within("any", "any", 1e-4))) == 0
    stop = galvi.Event(event.function, -1, terminal=True)
    run = galvi.integrate(NEAR, EIGHT, 0.3, 1000, events=stop)
    assert run.success and run.t[-1] == watched.events.t[0]
    assert run.outcome.event == watched.events.name[0]
    galvi.save(run, tmp_path / "run.npz")
    loaded = galvi.load(tmp_path / "run.npz", problem=NEAR)
    assert loaded.events.name == run.events.name == (watched.events.name[0],)
