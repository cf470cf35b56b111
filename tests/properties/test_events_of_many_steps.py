"""Events of runs in frames and clocks, whose steps are looked at together, and of all pairs."""

from __future__ import annotations

import tracemalloc
from typing import Any

import numpy as np
import pytest

import galvi
from galvi.curves.clock_curves import ClockCurves
from galvi.curves.curves import FrameCurves
from galvi.events import asked as asked_module
from galvi.run import states

pytestmark = pytest.mark.skipif(not galvi.FAST, reason="the general kernel alone has none")

PLAIN = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
FRAME = galvi.Galerkin(galvi.Polynomials(6), galvi.gauss(6), chart=galvi.KeplerFrame())
EVEN = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8), chart=galvi.KeplerFrame(even=True))
NESTED = galvi.Galerkin(
    galvi.Polynomials(8), galvi.gauss(8), chart=galvi.KeplerFrame(hierarchy=(0, (1, 2), 3))
)
CLOCK = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8), clock=galvi.DynamicalTime())
SUNDMAN = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8), clock=galvi.Sundman())
OUTER = galvi.problems.outer_solar_system()


def planets(ratio: float, n: int = 4, e: float = 0.0, mass: float = 1e-5) -> galvi.Problem:
    """A star and n planets on orbits whose axes have that ratio, from their apocentres."""
    a, phase = ratio ** np.arange(n), 2.4 * np.arange(n)
    q, v = np.zeros((n + 1, 3)), np.zeros((n + 1, 3))
    out = np.stack([np.cos(phase), np.sin(phase), 0.01 * np.cos(3.0 * phase)], axis=1)
    along = np.stack([-np.sin(phase), np.cos(phase), 0.0 * phase], axis=1)
    q[1:] = (a * (1.0 + e))[:, None] * out
    v[1:] = np.sqrt((1.0 - e) / (1.0 + e) / a)[:, None] * along
    return galvi.Problem(galvi.NBody(np.append(1.0, np.full(n, mass))), q, v)


def moon() -> galvi.Problem:
    """A star, a planet with a moon, and another planet."""
    q = np.array([[0.0, 0.0], [1.0, 0.0], [1.01, 0.0], [-3.0, 0.1]])
    v = np.array([[0.0, 0.0], [0.0, 1.0], [0.0, 1.0 + 0.1**0.5], [0.0, -(3.0**-0.5)]])
    return galvi.Problem(galvi.NBody(np.array([1.0, 1e-3, 1e-6, 1e-4])), q, v)


RUNS: dict[str, Any] = {
    "frame": lambda: galvi.integrate(OUTER, FRAME, 400.0, 300),
    "frame backwards": lambda: galvi.integrate(OUTER, EVEN, -300.0, 400),
    "frame, long steps": lambda: galvi.integrate(planets(1.4), EVEN, 2.0, 120),
    "frame, eccentric": lambda: galvi.integrate(planets(1.9, 3, 0.3), EVEN, 1.0, 150),
    "frame, pairs": lambda: galvi.integrate(moon(), NESTED, 0.015, 400),
    "clock": lambda: galvi.integrate(OUTER, CLOCK, 0.4, duration=1.2e5),
    "clock backwards": lambda: galvi.integrate(planets(1.4), CLOCK, -0.2, duration=60.0),
    "clock, eccentric": lambda: galvi.integrate(planets(1.9, 3, 0.6), CLOCK, 0.2, duration=60.0),
    "own clock": lambda: galvi.integrate(
        galvi.problems.kepler(0.6), SUNDMAN, 0.3, duration=40.0
    ),
}  # fmt: skip


def densely(run: Any, function: Any, points: int = 150) -> Any:
    """The times at which a function (q, v, t) of many states rises or falls through 0 on the curves
    of a run, from many times in each step, by halving."""
    t = np.concatenate([a + (b - a) * np.arange(points) / points
                        for a, b in zip(run.t[:-1], run.t[1:], strict=True)])  # fmt: skip

    def value(t: Any) -> Any:
        return function(run(t), run.velocity(t), t)

    values = value(t)
    k = np.flatnonzero(values[1:] * values[:-1] < 0.0)
    k = k[k > 0]  # that at the start is none
    low, high, sign = t[k].copy(), t[k + 1].copy(), np.sign(values[k])
    for _ in range(45):
        middle = 0.5 * (low + high)
        before = value(middle) * sign > 0.0
        low, high = np.where(before, middle, low), np.where(before, high, middle)
    return 0.5 * (low + high)


def radial(q: Any, v: Any, t: Any) -> Any:
    """q . v of bodies 1 and 2, or of one."""
    if q.ndim == 2:
        return np.sum(q * v, axis=1)
    return np.sum((q[:, 1] - q[:, 2]) * (v[:, 1] - v[:, 2]), axis=1)


@pytest.mark.slow_cases(but=["frame, long steps", "clock backwards"])
@pytest.mark.parametrize("name", RUNS)
def test_events_of_many_steps_are_those_of_a_dense_search(name: str) -> None:
    run = RUNS[name]()
    assert run.success, run.status
    if run.q.ndim == 2:
        event = galvi.Event(lambda q, v, t: q[0] * v[0] + q[1] * v[1])
    else:
        event = galvi.events.apsis(1, 2)
    found, expected = galvi.find_events(run, event), densely(run, radial)
    assert found.status == "" and len(expected) > 5
    assert len(found) == len(expected)
    step = np.abs(np.diff(run.t)).max()
    assert np.max(np.abs(found.t - expected)) < 1e-6 * step  # 5e-7: that of the curves
    if found.q.ndim == 3:
        gap = np.linalg.norm(found.q[:, 1] - found.q[:, 2], axis=1)
        assert np.allclose(found.value, gap, rtol=1e-14)
        at = galvi.states_at(run, found.t[:3])[0]
        assert np.allclose(found.q[:3], at, rtol=1e-11, atol=1e-11 * np.abs(at).max())


def test_a_function_of_velocity_and_time_is_found_in_frames_and_clocks() -> None:
    for name in ("frame", "clock"):
        run = RUNS[name]()
        middle = 0.41234 * run.t[-1]
        event = galvi.Event(lambda q, v, t, middle=middle: v[1, 0] * (t - middle))
        expected = densely(run, lambda q, v, t, middle=middle: v[:, 1, 0] * (t - middle), 40)
        found = galvi.find_events(run, event)
        assert len(found) == len(expected) > 20
        assert np.max(np.abs(found.t - expected)) < 1e-6 * np.abs(np.diff(run.t)).max()


class Work:
    """How many states were made one by one: places on curves, and states at times."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.places = self.states = 0
        for kind in (FrameCurves, ClockCurves):
            for name in ("position", "velocity"):
                monkeypatch.setattr(kind, name, self.counted(getattr(kind, name)))
        before = states.Reaching.__call__

        def reached(one: Any, times: Any, stages: Any = None) -> Any:
            self.states += len(times)
            return before(one, times, stages)

        monkeypatch.setattr(states.Reaching, "__call__", reached)

    def counted(self, function: Any) -> Any:
        def wrapped(one: Any, t: Any) -> Any:
            self.places += np.size(t)
            return function(one, t)

        return wrapped


@pytest.mark.parametrize("name", ["frame", "frame, pairs", "clock", "own clock"])
def test_no_place_is_sought_and_no_state_reached_by_itself(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = RUNS[name]()
    work = Work(monkeypatch)
    event = galvi.Event(radial_of_one) if run.q.ndim == 2 else galvi.events.apsis(1, 2)
    found = galvi.find_events(run, event)
    assert len(found) > 5
    assert work.places == 0 and work.states == 0  # else 48 a step, and 2 a root or more


def radial_of_one(q: Any, v: Any, t: Any) -> Any:
    return q[0] * v[0] + q[1] * v[1]


NEAR = planets(1.06, 6, mass=3e-6)
METHODS = {"equal": (PLAIN, 0.3, 1000), "frame": (FRAME, 0.6, 500), "clock": (CLOCK, 0.2, 3000)}


@pytest.mark.parametrize("name", METHODS)
def test_one_event_of_all_pairs_is_those_of_each(name: str) -> None:
    run = galvi.integrate(NEAR, *METHODS[name])
    every = galvi.find_events(run, galvi.events.within("any", "any", 0.1))
    each = [galvi.events.within(i, j, 0.1) for i in range(7) for j in range(i + 1, 7)]
    apart = galvi.find_events(run, each)
    assert len(every) > 10 and len(set(every.name)) > 3
    assert np.array_equal(every.t, apart.t) and every.name == apart.name
    assert np.array_equal(every.value, apart.value) and np.all(every.index == 0)
    three = galvi.find_events(run, galvi.events.within("any", 3, 0.1))
    own = [k for k, one in enumerate(apart.name) if one.startswith("3 ") or " and 3 " in one]
    assert np.array_equal(three.t, apart.t[own]) and len(own) > 0


def test_hill_radii_are_those_of_the_pair_at_that_time() -> None:
    run = galvi.integrate(NEAR, PLAIN, 0.3, 1000)
    found = galvi.find_events(run, galvi.events.within("any", "any", hill_radii=7.0))
    names = {f"{i} and {j} at 7 Hill radii": (i, j) for i in range(7) for j in range(7)}
    assert len(found) > 10
    for k, name in enumerate(found.name):
        i, j = names[name]
        q = found.q[k]
        about = np.linalg.norm(q[i] - q[0]) + np.linalg.norm(q[j] - q[0])
        radius = np.cbrt(2.0 * 3e-6 / 3.0) * 0.5 * about
        assert abs(np.linalg.norm(q[i] - q[j]) / radius - 7.0) < 1e-10 and 0 not in (i, j)

    def outside(q: Any, i: int, j: int) -> Any:
        norm = np.linalg.norm
        about = norm(q[:, i] - q[:, 0], axis=1) + norm(q[:, j] - q[:, 0], axis=1)
        return norm(q[:, i] - q[:, j], axis=1) - 7.0 * np.cbrt(2e-6) * 0.5 * about

    dense = [densely(run, lambda q, v, t, i=i, j=j: outside(q, i, j), 8)
             for i in range(1, 7) for j in range(i + 1, 7)]  # fmt: skip
    expected = np.sort(np.concatenate(dense))
    assert len(expected) == len(found) and np.max(np.abs(found.t - expected)) < 1e-7
    one = galvi.find_events(run, galvi.events.within(2, 3, hill_radii=7.0))
    own = [name == "2 and 3 at 7 Hill radii" for name in found.name]
    assert np.array_equal(one.t, found.t[own])


def test_pairs_that_stay_apart_cost_bounds_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    count = 0
    before = asked_module.Function.__init__

    def made(*given: Any) -> None:
        nonlocal count
        count += 1
        before(*given)

    monkeypatch.setattr(asked_module.Function, "__init__", made)
    run = galvi.integrate(planets(1.5, 8), CLOCK, 0.2, duration=40.0)
    assert len(galvi.find_events(run, galvi.events.within("any", "any", 0.05))) == 0
    assert count == 0


def test_an_event_of_all_pairs_ends_a_run_and_names_the_pair(tmp_path: Any) -> None:
    watched = galvi.integrate(NEAR, PLAIN, 0.3, 1000, events=galvi.events.within("any", "any", 0.1))
    event = galvi.events.within("any", "any", 0.1)
    stop = galvi.Event(event.function, -1, terminal=True)
    run = galvi.integrate(NEAR, PLAIN, 0.3, 1000, events=stop)
    assert run.success and run.t[-1] == watched.events.t[0]
    assert run.status.startswith(f"Ended by the event {watched.events.name[0]}, at t = ")
    galvi.save(run, tmp_path / "run.npz")
    loaded = galvi.load(tmp_path / "run.npz", problem=NEAR)
    assert loaded.events.name == run.events.name == (watched.events.name[0],)


REFUSED = [
    (lambda: galvi.events.within(0, 1), "either distance or hill_radii"),
    (lambda: galvi.events.within(0, 1, 1.0, hill_radii=1.0), "either distance or hill_radii"),
    (lambda: galvi.events.within("any", "any", hill_radii=-1.0), "hill_radii"),
    (lambda: sought(galvi.events.within("any", 9, 1.0)), "a body must be"),
    (lambda: sought(galvi.events.within(0, 1, hill_radii=1.0)), "heaviest body has no Hill"),
    (lambda: sought(galvi.events.within("any", 0, hill_radii=1.0)), "no such pair"),
]  # fmt: skip


def sought(event: Any) -> Any:
    return galvi.find_events(galvi.integrate(NEAR, PLAIN, 0.1, 2), event)


@pytest.mark.parametrize(("call", "words"), REFUSED)
def test_pairs_that_cannot_be_are_refused_in_words(call: Any, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        call()


@pytest.mark.slow(beside="test_one_event_of_all_pairs_is_those_of_each")
def test_an_event_takes_at_most_200_bytes() -> None:
    """Of an oscillator that passes its centre so often, whose run keeps two states."""
    event = galvi.Event(lambda q, v, t: q[0], name="centre")
    method = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
    counts, bytes_held = [], []
    for passages in (2_000, 12_000):
        steps = int((passages + 0.5) * np.pi / 2.0)
        problem = galvi.problems.harmonic_oscillator()
        run = galvi.integrate(problem, method, 2.0, steps, save_every=steps)
        tracemalloc.start()
        counts.append(len(galvi.find_events(run, event)))
        bytes_held.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert abs(counts[0] - 2_000) <= 1 and abs(counts[1] - 12_000) <= 1
    assert (bytes_held[1] - bytes_held[0]) / (counts[1] - counts[0]) < 200.0
