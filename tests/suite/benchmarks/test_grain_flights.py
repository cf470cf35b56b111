"""Flights of many grains: closed forms, the other kernels, contacts, lanes and threads."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import expm
from scipy.optimize import brentq

import galvi
from benchmarks.applications.brownout import flights
from benchmarks.applications.brownout.flights import (
    ALOFT,
    BOUNCING,
    FAILED,
    LANDED,
    WAITING,
    Ground,
    follow,
)

G = 9.80665
STILL = "def wind(q, decay):\n    return 0.0, 0.0, 0.0\n"
STOKES = galvi.SchillerNaumann(1e-30)  # its Reynolds number vanishes
NEWTON = galvi.QuadraticDrag()
NAMES = ("status", "t", "q", "v", "drag", "contact", "contacts", "steps", "passes", "places")


def gauss(s: int) -> galvi.Galerkin:
    return galvi.Galerkin(galvi.Polynomials(s), galvi.gauss(s))


def rates_of(problem: galvi.Problem, n: int) -> tuple[Any, Any]:
    """The drag law of a grain, and its numbers for n grains."""
    system: Any = problem.system
    law, factor = system.force.drag_law, system.force.factor / float(system.mass)
    return law, np.tile([[factor, *law.numbers]], (n, 1))


def thrown(n: int, seed: int, top: float = 8.0) -> tuple[Any, Any, Any]:
    """Random starts around the rotor: q, v and t."""
    random = np.random.default_rng(seed)
    r, angle = random.uniform(2.0, 12.0, n), random.uniform(0.0, 2.0 * np.pi, n)
    q = np.stack([r * np.cos(angle), r * np.sin(angle), random.uniform(0.01, top, n)], axis=1)
    return q, random.normal(size=(n, 3)), random.uniform(0.0, 0.5, n)


HEIGHTS = np.linspace(0.5, 1.0, 40)
RATE = 4.0  # 1/s, of Stokes' drag


def fallen(height: Any, fastest: float) -> tuple[Any, Any]:
    """Time and speed of a fall from rest with quadratic drag."""
    time = fastest / G * np.arccosh(np.exp(G * height / fastest**2))
    return time, fastest * np.tanh(G * time / fastest)


def risen(speed: Any) -> tuple[Any, Any]:
    """Time until a grain that rises from the ground is back, with Stokes' drag, and its speed."""
    fastest, times = G / RATE, []

    def height(t: float, u: float) -> float:
        return (u + fastest) / RATE * -math.expm1(-RATE * t) - fastest * t

    for u in speed:
        top = math.log1p(u / fastest) / RATE
        times.append(brentq(height, top, 10.0, args=(u,), xtol=1e-15, rtol=1e-15))
    time = np.array(times)
    return time, fastest - (speed + fastest) * np.exp(-RATE * time)


def drop(
    method: galvi.Galerkin, steps: int, ground: Ground, rate: float = G / 9.0, drag: Any = NEWTON,
    speed: float = 0.0,
) -> flights.Flights:  # fmt: skip
    """Grains that start at HEIGHTS with a vertical speed, for at most 2 s."""
    q, v = np.zeros((2, HEIGHTS.size, 3))
    q[:, 0], q[:, 2], v[:, 2] = 0.3, HEIGHTS, speed
    rates = np.tile([[rate, *drag.numbers]], (HEIGHTS.size, 1))
    return follow(method, q, v, 0.0 * HEIGHTS, rates, drag, 2.0 / steps, 2.0, gravity=G,
                  ground=ground, wind=STILL)  # fmt: skip


def rms(errors: Any) -> float:
    return float(np.sqrt(np.mean(errors**2)))


def slope(errors: list[float], steps: list[int]) -> float:
    return -float(np.polyfit(np.log(steps), np.log(errors), 1)[0])


@pytest.mark.slow_cases("0.44")
@pytest.mark.parametrize("coefficient", [0.44, None])
@given(
    s=st.integers(1, 4),
    diameter=st.sampled_from([20e-6, 100e-6, 400e-6]),
    seed=st.integers(0, 2**30),
)
@settings(max_examples=8, deadline=None)
def test_a_flight_is_the_run_of_the_general_kernel(
    coefficient: float | None, s: int, diameter: float, seed: int
) -> None:
    q, v, _ = thrown(3, seed)
    q[:, 2] += 4.0
    start = galvi.problems.brownout(diameter, drag_coefficient=coefficient)
    law, rates = rates_of(start, 3)
    found = follow(gauss(s), q, v, np.zeros(3), rates, law, 1 / 64, 0.25, gravity=G, saves=4)
    assert np.all(found.status == ALOFT)
    for k in range(3):
        run = galvi.integrate(start.with_initial_state(q[k], v[k]), gauss(s), 1 / 64, 16)
        assert run.success
        np.testing.assert_allclose(found.places[k], run.q[::4], rtol=0, atol=1e-10)  # 4e-13
        np.testing.assert_allclose(found.v[k], start.system.velocity(run.p[-1]), atol=1e-9)


@pytest.mark.slow_cases("0.44")
@pytest.mark.parametrize("coefficient", [0.44, None])
def test_far_from_the_ground_flights_are_members_of_an_ensemble(coefficient: float | None) -> None:
    q, v, _ = thrown(21, 8)
    q[:, 2] += 5.0
    start = galvi.problems.brownout(200e-6, drag_coefficient=coefficient)
    law, rates = rates_of(start, 21)
    found = follow(gauss(2), q, v, np.zeros(21), rates, law, 1 / 64, 0.25, gravity=G)
    states = np.asarray(galvi.integrate_ensemble(start, q, v, gauss(2), 1 / 64, 16))
    assert np.all(found.status == ALOFT)
    np.testing.assert_allclose(found.q, states[:, 0], rtol=0, atol=1e-12)  # 1e-14
    mass = float(start.system.mass)  # type: ignore[attr-defined]
    np.testing.assert_allclose(found.v, states[:, 1] / mass, rtol=0, atol=1e-11)


@pytest.mark.parametrize("s", [1, 2, 3])
def test_the_time_of_landing_is_of_the_order_of_the_steps(s: int) -> None:
    time, speed = fallen(HEIGHTS, 3.0)
    steps, times, speeds = [16, 24, 32, 48], [], []
    for n in steps:
        found = drop(gauss(s), n, Ground())
        assert np.all(found.status == LANDED) and np.all(found.q == [0.3, 0.0, 0.0])
        times.append(rms(found.t - time))
        speeds.append(rms(found.contact[:, 2] - speed))
    for errors in (times, speeds):
        assert abs(slope(errors, steps) - 2 * s) < 0.4, errors


@pytest.mark.slow(beside="test_the_time_of_landing_is_of_the_order_of_the_steps")
def test_a_landing_with_many_points_is_exact_in_coarse_steps() -> None:
    found = drop(gauss(8), 8, Ground())
    assert np.all(found.status == LANDED)
    np.testing.assert_allclose(found.t, fallen(HEIGHTS, 3.0)[0], rtol=1e-13)  # 3e-15


def vacuum(
    z: Any, speed: Any, s: int, ground: Ground, until: float = 2.0, **how: Any
) -> flights.Flights:
    """Grains thrown upwards without drag, in steps of 1/16 s."""
    z, speed = np.broadcast_arrays(z, speed)
    q, v = np.zeros((2, z.size, 3))
    q[:, 2], v[:, 2] = z, speed
    return follow(gauss(s), q, v, np.zeros(z.size), np.zeros((z.size, 1)), NEWTON, 1 / 16, until,
                  gravity=G, ground=ground, wind=STILL, **how)  # fmt: skip


@pytest.mark.parametrize("s", [1, 2, 3, 8])
def test_a_landing_at_the_end_of_a_step_is_seen(s: int) -> None:
    """Within rounding of it, where the curve may end above the ground and the step below it."""
    for steps in (1, 4, 7):
        height = 0.5 * G * (steps / 16) ** 2
        heights = height + np.arange(-40, 40) * np.spacing(height)
        found = vacuum(heights, 0.0, s, Ground())
        assert np.all(found.status == LANDED) and np.all(found.contacts == 1)
        np.testing.assert_allclose(found.t, steps / 16, rtol=1e-12)
        last = vacuum(heights, 0.0, s, Ground(), until=steps / 16)
        assert np.array_equal(last.status == LANDED, last.q[:, 2] == 0.0)
        assert set(last.status) == {ALOFT, LANDED} and np.all(last.q[:, 2] >= 0.0)


def test_the_smallest_jump_from_the_ground_comes_down() -> None:
    found = vacuum(0.0, np.array([1e-15, 1e-19, 1e-25, 1e-200]), 2, Ground())
    assert np.all(found.status == LANDED) and np.all(found.contacts == 1)
    assert np.all(found.t < 1e-12)


def test_a_grain_that_bounces_without_end_says_so_where_it_is() -> None:
    """With e = 1/2 all rebounds end after three times the fall."""
    height = np.array([0.25, 0.5])
    found = vacuum(height, 0.0, 2, Ground(0.5, 0.0), saves=4)
    assert np.all(found.status == BOUNCING) and not np.any(found.success)
    np.testing.assert_allclose(found.t, 3.0 * np.sqrt(2.0 * height / G), rtol=1e-9)
    assert np.all(found.q[:, 2] == 0.0) and np.all(found.contacts == 1000)
    assert np.all(np.isnan(found.places[:, 4])) and np.all(np.isfinite(found.places[:, 0]))
    elastic = vacuum(height[:1], 0.0, 2, Ground(1.0, 0.0))
    assert elastic.status[0] == ALOFT and elastic.contacts[0] == 4
    energy = G * elastic.q[0, 2] + 0.5 * elastic.v[0, 2] ** 2
    assert energy == pytest.approx(G * height[0], rel=1e-12)


def test_a_grain_without_rebound_stays_at_its_first_contact() -> None:
    found = vacuum(0.5, 0.0, 2, Ground(0.0, 0.0))
    assert found.status[0] == LANDED and found.contacts[0] == 1


@pytest.mark.parametrize("s", [2, 3])
def test_the_root_of_the_curve_alone_is_of_the_order_of_the_curve(s: int) -> None:
    time, _ = fallen(HEIGHTS, 3.0)
    steps = [32, 64, 128]
    errors = [rms(drop(gauss(s), n, Ground(exact=False)).t - time) for n in steps]
    assert abs(slope(errors, steps) - (s + 1)) < 0.3, errors


@pytest.mark.parametrize("s", [1, 2])
def test_a_rebound_and_the_rest_of_its_step_keep_the_order(s: int) -> None:
    """Up again with half the speed, and down."""
    fastest = G / RATE
    time = np.array([
        brentq(lambda t, z=z: z - fastest * (t + math.expm1(-RATE * t) / RATE), 0.0, 9.0,
               xtol=1e-15, rtol=1e-15) for z in HEIGHTS
    ])  # fmt: skip
    speed = -fastest * np.expm1(-RATE * time)
    again, second = risen(0.5 * speed)
    steps, times, speeds = [32, 64, 128, 256], [], []
    for n in steps:
        found = drop(gauss(s), n, Ground(0.5, 0.9), RATE, STOKES)
        assert np.all(found.contacts == 2) and np.all(found.status == LANDED)
        times.append(rms(found.t - (time + again)))
        speeds.append(rms(found.contact[:, 2] - (1.5 * speed + second)))
    for errors in (times, speeds):
        assert abs(slope(errors, steps) - 2 * s) < 0.4, errors


@pytest.mark.slow_cases("rotation-1", "rotation-3", "strain-3")
@pytest.mark.parametrize("s", [1, 2, 3])
@pytest.mark.parametrize(
    ("lines", "matrix"),
    [
        ("-2.0 * q[1], 2.0 * q[0], 0.0", [[0.0, -2.0, 0.0], [2.0, 0.0, 0.0], [0.0, 0.0, 0.0]]),
        ("1.5 * q[0], -1.5 * q[1], 0.0", np.diag([1.5, -1.5, 0.0])),
    ],
    ids=["rotation", "strain"],
)
def test_stokes_drag_in_a_linear_wind_is_a_matrix_exponential(
    s: int, lines: str, matrix: Any
) -> None:
    wind = f"def wind(q, decay):\n    return {lines}\n"
    rate, start = 4.0, np.array([0.4, -0.2, 50.0, 0.3, 1.0, 0.0])
    whole = np.zeros((7, 7))
    whole[:3, 3:6], whole[3:6, :3] = np.eye(3), rate * np.array(matrix)
    whole[3:6, 3:6], whole[5, 6] = -rate * np.eye(3), -G
    exact = (expm(whole) @ np.append(start, 1.0))[:6]
    steps, errors = [8, 16, 32], []
    for n in steps:
        found = follow(gauss(s), start[None, :3], start[None, 3:], [0.0], [[rate, 1e-30]], STOKES,
                       1.0 / n, 1.0, gravity=G, wind=wind)  # fmt: skip
        errors.append(np.abs(np.append(found.q, found.v) - exact).max())
    assert abs(slope(errors, steps) - 2 * s) < 0.3, errors


def cloud(order: Any = slice(None), threads: int = 1) -> flights.Flights:
    q, v, t = thrown(100, 3, top=1.0)
    start = galvi.problems.brownout(300e-6, drag_coefficient=None)
    law, rates = rates_of(start, 100)
    step = np.where(np.arange(100) < 40, 1 / 32, 1 / 64)
    return follow(gauss(2), q[order], v[order], t[order], rates, law, step[order], 1.0, gravity=G,
                  saves=8, ground=Ground(0.5), threads=threads)  # fmt: skip


def assert_same(one: flights.Flights, other: flights.Flights, order: Any) -> None:
    for name in NAMES:
        np.testing.assert_array_equal(getattr(one, name)[order], getattr(other, name), name)


def test_a_grains_numbers_depend_on_nothing_but_the_grain(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = cloud()
    assert {ALOFT, LANDED} <= set(whole.status) and whole.contacts.max() > 2
    for order in (np.random.default_rng(1).permutation(100), np.array([17]), np.arange(50, 59)):
        monkeypatch.setattr(flights, "BATCH", 7)
        assert_same(whole, _some(order), order)


def _some(order: Any) -> flights.Flights:
    q, v, t = thrown(100, 3, top=1.0)
    start = galvi.problems.brownout(300e-6, drag_coefficient=None)
    law, rates = rates_of(start, len(order))
    step = np.where(order < 40, 1 / 32, 1 / 64)
    return follow(gauss(2), q[order], v[order], t[order], rates, law, step, 1.0, gravity=G,
                  saves=8, ground=Ground(0.5), threads=2)  # fmt: skip


def test_the_momentum_of_each_grain_is_accounted_for() -> None:
    _, v, t = thrown(100, 3, top=1.0)
    found = cloud()
    change = found.v - v
    change[:, 2] += G * (found.t - t)
    size = np.abs(v).max() + np.abs(found.drag).max() + np.abs(found.contact).max()
    assert np.abs(change - found.drag - found.contact).max() < 5e-14 * size  # 1e-14
    assert np.abs(found.contact).max() > 0.1 * size


def test_places_are_kept_from_the_start_to_the_end_and_on_the_ground() -> None:
    found = cloud()
    _, _, t = thrown(100, 3, top=1.0)
    times = np.linspace(0.0, 1.0, 9)
    before = times[None, :] < t[:, None]
    assert np.array_equal(np.isnan(found.places[:, :, 0]), before)
    later = ~before & (times[None, :] >= found.t[:, None])
    ends = np.broadcast_to(found.q[:, None], found.places.shape)
    np.testing.assert_array_equal(found.places[later], ends[later])
    assert np.all(found.places[~before][:, 2] >= 0.0)


def test_grains_that_cannot_be_solved_fail_alone() -> None:
    """The wind is not a number beyond x = 4."""
    wind = (
        "from galvi.lanes.elementary import sqrt\n\n\n"
        "def wind(q, decay):\n    return 2.0 + 0.0 * sqrt(4.0 - q[0]), 0.0, 0.0\n"
    )
    q = np.stack([np.linspace(-4.0, 3.9, 20), np.zeros(20), np.full(20, 60.0)], axis=1)
    v, rates = np.zeros((20, 3)), np.tile([[5.0, 1e-30]], (20, 1))
    v[:, 0] = 2.0
    given: Any = {"gravity": G, "wind": wind, "saves": 4}
    found = follow(gauss(2), q, v, np.zeros(20), rates, STOKES, 1 / 16, 1.0, **given)
    fails = q[:, 0] + 2.0 > 4.0
    assert np.array_equal(found.status == FAILED, fails) and np.any(fails) and not np.all(fails)
    assert np.all(np.isnan(found.q[fails])) and np.all(np.isnan(found.places[fails, -1]))
    np.testing.assert_allclose(found.q[~fails, 0], q[~fails, 0] + 2.0, atol=1e-12)


@given(step=st.integers(3, 999).map(lambda k: 1.0 / k))
@settings(max_examples=30, deadline=None)
def test_a_grain_that_starts_at_the_end_of_a_step_takes_whole_steps(step: float) -> None:
    """Also where the division of its time by the step is rounded down; thrown from the ground."""
    k = np.arange(min(40, round(0.5 / step)))
    q, v = np.zeros((2, k.size, 3))
    v[:, 2] = 2.0
    found = follow(gauss(2), q, v, k * step, np.full((k.size, 1), G / 9.0), NEWTON, step, 1.0,
                   gravity=G, wind=STILL)  # fmt: skip
    landed = found.status == LANDED
    assert landed[0] and np.all(landed | (k * step + found.t[0] > 1.0 - 2.0 * step))
    np.testing.assert_allclose((found.t - k * step)[landed], found.t[0], atol=1e-9)
    assert np.all(found.steps[landed] - found.steps[0] <= 2)


@given(parts=st.integers(1, 400), share=st.floats(0.0, 1.0, exclude_max=True))
@settings(max_examples=60, deadline=None)
def test_a_start_at_a_saved_time_is_a_saved_place(parts: int, share: float) -> None:
    """Although k / n may not be k (1 / n); also a unit in the last place before or after."""
    k = int(share * parts)
    t = k / parts + np.array([-1.0, 0.0, 1.0]) * np.spacing(k / parts) * (k > 0)
    found = follow(gauss(2), [[0.0, 0.0, 9.0]] * 3, np.zeros((3, 3)), t, [[1.0]] * 3, NEWTON,
                   1.0 / parts, 1.0, gravity=G, wind=STILL, saves=parts)  # fmt: skip
    assert np.all(np.isnan(found.places[:, :k])) and not np.any(np.isnan(found.places[:, k:]))
    assert np.all(found.places[:, k, 2] == 9.0) and np.all(found.steps == parts - k)


def test_a_grain_that_starts_after_the_end_waits() -> None:
    t = [0.2, 1.0, 1.5, 1e19, 1e300]
    found = follow(gauss(2), [[9.0, 0.0, 9.0]] * 5, np.zeros((5, 3)), t, [[1.0]] * 5,
                   NEWTON, 0.25, 1.0, gravity=G)  # fmt: skip
    assert list(found.status) == [ALOFT] + 4 * [WAITING] and np.all(found.steps[1:] == 0)
    assert found.steps[0] == 4 and found.t[0] == 1.0 and list(found.t[1:]) == t[1:]
    assert np.all(found.success)


def test_a_wrong_table_is_caught(monkeypatch: pytest.MonkeyPatch) -> None:
    """The curve's by the root of the curve, the step's by the landing."""
    numbers = flights._tables(gauss(2), G, 1e-14)
    time, _ = fallen(HEIGHTS, 3.0)
    right = rms(drop(gauss(2), 128, Ground(exact=False)).t - time)
    for changed, ground, wrong in (
        (slice(15, 19), Ground(exact=False), 10.0 * right), (slice(8), Ground(), 1e-5)
    ):  # fmt: skip
        factor = np.ones(numbers.size)
        factor[changed] = 1.01
        monkeypatch.setattr(flights, "_tables", lambda *given, by=factor: numbers * by)
        assert rms(drop(gauss(2), 128, ground).t - time) > wrong


def test_a_start_is_a_polynomial_through_the_stages_of_one_step_or_two() -> None:
    """Of degree 1 and 3 with two points, at the times of the next step's stages."""
    c, numbers = gauss(2).table.c, flights._tables(gauss(2), G, 1e-14)
    for degree, known, part in ((1, c, numbers[19:23]), (3, np.append(c - 1.0, c), numbers[23:])):
        line = np.poly1d(np.arange(1.0, degree + 2.0))
        np.testing.assert_allclose(part.reshape(2, -1) @ line(known), line(1.0 + c), rtol=1e-12)


def test_a_start_from_two_steps_saves_passes(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of 60 steps with two points: 280 passes, 292 with a start from one step, 336 with none."""
    numbers = flights._tables(gauss(2), G, 1e-14)
    start = galvi.problems.brownout(200e-6, [8.5, 0.0, 12.0])
    law, rates = rates_of(start, 1)
    passes = []
    for once, twice in ((1.0, 1.0), (1.0, 0.0), (0.0, 0.0)):
        changed = numbers.copy()
        changed[19:23] *= once
        if not twice:
            changed[23:] = np.hstack([np.zeros((2, 2)), changed[19:23].reshape(2, 2)]).ravel()
        monkeypatch.setattr(flights, "_tables", lambda *given, changed=changed: changed)
        found = follow(gauss(2), [start.q0], [start.v0], [0.0], rates, law, 0.03, 1.8, gravity=G)
        passes.append(int(found.passes[0]))
    two, one, none = passes
    assert 270 < two < one - 4 and one < 302 and one + 30 < none < 350


@pytest.mark.parametrize(
    ("changed", "sentence"),
    [
        ({"method": galvi.Galerkin(galvi.Polynomials(2), galvi.gauss(3))}, "take Gauss colloc"),
        ({"method": galvi.Galerkin(galvi.Polynomials(2), galvi.lobatto(2))}, "take Gauss colloc"),
        ({"method": gauss(9)}, "at most 8 points; received 9"),
        ({"step": 1e-15}, r"step must be at least until / 1e\+09; received 1e-15 for 1.0"),
        ({"rates": [[-1.0]]}, "rates must not be negative; received -1.0"),
        ({"step": [0.25, 0.3]}, "a whole fraction of until.* received 0.3 for 1.0"),
        ({"step": 1e-320}, "step must be at least until"),
        ({"step": 1e308}, "a whole fraction of until"),
        ({"method": galvi.Galerkin(galvi.Polynomials(64), galvi.gauss(70))}, "received 70"),
        ({"step": -0.25}, "step must be positive; received -0.25"),
        ({"saves": -1}, "saves must be a whole number"),
        ({"saves": 2.5}, "saves must be a whole number"),
        ({"threads": -1}, "threads must be a whole number"),
        ({"t0": 0.0}, "shape"),
        ({"gravity": np.nan}, "gravity must be a finite real number"),
        ({"q0": [[1.0, 0.0, -0.1], [1.0, 0.0, 1.0]], "step": [0.25] * 2}, "ground.* received 1 o"),
        ({"q0": [[1.0, 0.0, 0.0]]}, "on it with an upward velocity"),
        ({"t0": [-1.0]}, "from t = 0 on"),
        ({"v0": [[0.0, 0.0]]}, r"v0 must have shape \(1, 3\)"),
        ({"rates": [[1.0, 2.0]]}, r"rates must have shape \(1, 1\)"),
        ({"v0": [[0.0, 0.0, np.nan]]}, "v0 must hold finite numbers only"),
    ],
)
def test_bad_input_gets_one_clear_sentence(changed: dict[str, Any], sentence: str) -> None:
    known: dict[str, Any] = {
        "method": gauss(2), "q0": [[1.0, 0.0, 1.0]], "v0": [[0.0, 0.0, 0.0]], "t0": [0.0],
        "rates": [[1.0]], "drag": NEWTON, "step": 0.25, "until": 1.0, "gravity": G,
    }  # fmt: skip
    if isinstance(changed.get("step"), list):  # of two grains
        known |= {name: 2 * known[name] for name in ("q0", "v0", "t0", "rates")}
    with pytest.raises(ValueError, match=sentence):
        follow(**{**known, **changed})


@pytest.mark.parametrize(
    "changed", [{"restitution": -0.5}, {"restitution": np.nan}, {"slowest": np.nan}]
)
def test_a_ground_is_checked(changed: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match=f"{next(iter(changed))} must"):
        Ground(**changed)


@pytest.mark.slow_cases("3")
@pytest.mark.parametrize("s", [1, 2, 3])
def test_a_small_jump_from_the_ground_is_a_flight(s: int) -> None:
    """Much shorter than the step: the curve's own velocity at its start points downwards."""
    speed = np.array([1e-3, 1e-2, 5e-2])
    v = np.outer(speed, [0.0, 0.0, 1.0])
    rates = np.tile([[RATE, *STOKES.numbers]], (3, 1))
    found = follow(gauss(s), np.tile([[0.3, 0.0, 0.0]], (3, 1)), v, np.zeros(3), rates, STOKES,
                   0.25, 1.0, gravity=G, wind=STILL)  # fmt: skip
    assert np.all(found.status == LANDED) and np.all(found.contacts == 1)
    np.testing.assert_allclose(found.t, risen(speed)[0], rtol=[2e-2, 1e-6, 1e-10][s - 1])  # 7e-3


UPWARDS = "def wind(q, decay):\n    return 1.0, 0.0, 8.0\n"


@pytest.mark.slow_cases("3")
@pytest.mark.parametrize("s", [1, 2, 3])
def test_the_ground_never_pulls(s: int) -> None:
    """Where a coarse curve dips below the ground but the step rises, there is no contact."""
    random, n = np.random.default_rng(s), 400
    q, v = np.zeros((2, n, 3))
    q[:, 2], v[:, 0], v[:, 2] = random.uniform(1e-4, 0.5, n), 1.0, -random.uniform(0.1, 20.0, n)
    rates = np.tile([[15.0, *STOKES.numbers]], (n, 1))
    for exact in (True, False):
        found = follow(gauss(s), q, v, np.zeros(n), rates, STOKES, 0.25, 1.0, gravity=G,
                       ground=Ground(exact=exact), wind=UPWARDS)  # fmt: skip
        assert np.all(found.contact[:, 2] >= 0.0)
        assert np.all((found.contact[:, 2] > 0.0) == (found.status == LANDED))
        assert np.any(found.status == LANDED) and np.any(found.status == ALOFT)
        np.testing.assert_allclose(found.q[:, 0], found.t, atol=1e-12)  # with the wind
        assert np.all(np.abs(found.v[found.status == ALOFT, 0] - 1.0) < 1e-12)
