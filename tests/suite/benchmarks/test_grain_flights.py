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


def gauss(s: int) -> galvi.Galerkin:
    return galvi.Galerkin(galvi.Polynomials(s), galvi.gauss(s))


def rates_of(problem: galvi.Problem, n: int) -> tuple[Any, Any]:
    """The drag law of a grain, and its rates (n, numbers) for n grains."""
    system: Any = problem.system
    law, factor = system.force.drag_law, system.force.factor / float(system.mass)
    return law, np.tile([[factor, *law.numbers]], (n, 1))


def still(
    s: int,
    q: Any,
    v: Any,
    step: float,
    until: float,
    rate: float = 0.0,
    drag: Any = NEWTON,
    t0: Any = 0.0,
    **options: Any,
) -> flights.Flights:
    """Flights in still air, or in the `wind` of the options, by Gauss's rule of s points."""
    q, v = np.broadcast_arrays(np.asarray(q, float), np.asarray(v, float))
    rates = np.tile([[rate, *drag.numbers]], (len(q), 1))
    options = {"gravity": G, "wind": STILL} | options
    return follow(gauss(s), q, v, t0 + np.zeros(len(q)), rates, drag, step, until, **options)


def upright(z: Any, speed: Any) -> tuple[Any, Any]:
    """Starts at these heights with vertical speeds, q and v."""
    z, speed = np.broadcast_arrays(z, speed)
    q, v = np.zeros((2, z.size, 3))
    q[:, 0], q[:, 2], v[:, 2] = 0.3, z, speed
    return q, v


def thrown(n: int, seed: int, top: float = 8.0) -> tuple[Any, Any, Any]:
    """Random starts around the rotor: q, v and t."""
    random = np.random.default_rng(seed)
    r, angle = random.uniform(2.0, 12.0, n), random.uniform(0.0, 2.0 * np.pi, n)
    q = np.stack([r * np.cos(angle), r * np.sin(angle), random.uniform(0.01, top, n)], axis=1)
    return q, random.normal(size=(n, 3)), random.uniform(0.0, 0.5, n)


HEIGHTS = np.linspace(0.5, 1.0, 40)
RATE = 4.0  # 1/s, of Stokes' drag


def fallen(height: Any, terminal_speed: float) -> tuple[Any, Any]:
    """Time and speed of a fall from rest with quadratic drag."""
    time = terminal_speed / G * np.arccosh(np.exp(G * height / terminal_speed**2))
    return time, terminal_speed * np.tanh(G * time / terminal_speed)


def landed(height: Any, up: Any) -> tuple[Any, Any]:
    """Time and speed of landing with Stokes' drag, from a height with a speed upwards."""
    terminal_speed = G / RATE
    height, up = np.broadcast_arrays(height, up)

    def above(t: float, z: float, u: float) -> float:
        return z + (u + terminal_speed) / RATE * -math.expm1(-RATE * t) - terminal_speed * t

    time = np.array(
        [
            brentq(
                above,
                math.log1p(u / terminal_speed) / RATE,
                10.0,
                args=(z, u),
                xtol=1e-15,
                rtol=1e-15,
            )
            for z, u in zip(height, up, strict=True)
        ]
    )
    return time, terminal_speed - (up + terminal_speed) * np.exp(-RATE * time)


def drop(
    s: int, steps: int, ground: Ground, rate: float = G / 9.0, drag: Any = NEWTON
) -> flights.Flights:
    """Grains that fall from HEIGHTS, for at most 2 s."""
    return still(s, *upright(HEIGHTS, 0.0), 2.0 / steps, 2.0, rate, drag, ground=ground)


def rms(errors: Any) -> float:
    return float(np.sqrt(np.mean(errors**2)))


def has_order(order: float, errors: list[float], steps: list[int]) -> bool:
    return abs(np.polyfit(np.log(steps), np.log(errors), 1)[0] + order) < 0.4


@pytest.mark.slow_cases("0.44")
@pytest.mark.parametrize("coefficient", [0.44, None])
@given(
    s=st.sampled_from([1, 4]),
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
    grains = follow(gauss(s), q, v, np.zeros(3), rates, law, 1 / 64, 0.25, gravity=G, saves=4)
    assert np.all(grains.status == ALOFT)
    for k in range(3):
        run = galvi.integrate(start.with_initial_state(q[k], v[k]), gauss(s), 1 / 64, 16)
        assert run.success
        np.testing.assert_allclose(grains.places[k], run.q[::4], rtol=0, atol=1e-10)  # 4e-13
        np.testing.assert_allclose(grains.v[k], start.system.velocity(run.p[-1]), atol=1e-9)


def a_fall() -> tuple[Any, Any, int, tuple[Any, ...]]:
    return *fallen(HEIGHTS, 3.0), 1, (Ground(),)


def a_rebound() -> tuple[Any, Any, int, tuple[Any, ...]]:
    """A rebound with half the speed, and the second landing."""
    time, speed = landed(HEIGHTS, 0.0)
    second_time, second_speed = landed(0.0, 0.5 * speed)
    return time + second_time, 1.5 * speed + second_speed, 2, (Ground(0.5, 0.9), RATE, STOKES)


@pytest.mark.parametrize("motion", [a_fall, a_rebound])
@pytest.mark.parametrize("s", [1, 2])
def test_times_and_impulses_of_contacts_are_of_the_order_of_the_steps(s: int, motion: Any) -> None:
    time, impulse, contacts, arguments = motion()
    steps, times, impulses = [32, 64, 128], [], []
    for n in steps:
        grains = drop(s, n, *arguments)
        assert np.all(grains.status == LANDED) and np.all(grains.q == [0.3, 0.0, 0.0])
        assert np.all(grains.contacts == contacts)
        times.append(rms(grains.t - time))
        impulses.append(rms(grains.contact[:, 2] - impulse))
    assert has_order(2 * s, times, steps) and has_order(2 * s, impulses, steps)


def vacuum(z: Any, speed: Any, s: int, ground: Ground, until: float = 2.0, **options: Any) -> Any:
    """Grains thrown upwards without drag, in steps of 1/16 s."""
    return still(s, *upright(z, speed), 1 / 16, until, ground=ground, **options)


@pytest.mark.parametrize("s", [2, 8])
def test_a_landing_at_the_end_of_a_step_is_seen(s: int) -> None:
    """Within rounding of it, where the curve may end above the ground and the step below it."""
    for steps in (1, 4, 7):
        height = 0.5 * G * (steps / 16) ** 2
        heights = height + np.arange(-40, 40) * np.spacing(height)
        grains = vacuum(heights, 0.0, s, Ground())
        assert np.all(grains.status == LANDED) and np.all(grains.contacts == 1)
        np.testing.assert_allclose(grains.t, steps / 16, rtol=1e-12)
        last = vacuum(heights, 0.0, s, Ground(), until=steps / 16)
        assert np.array_equal(last.status == LANDED, last.q[:, 2] == 0.0)
        assert set(last.status) == {ALOFT, LANDED} and np.all(last.q[:, 2] >= 0.0)


def test_the_smallest_jump_from_the_ground_comes_down() -> None:
    grains = vacuum(0.0, np.array([1e-15, 1e-19, 1e-25, 1e-200]), 2, Ground())
    assert np.all(grains.status == LANDED) and np.all(grains.contacts == 1)
    assert np.all(grains.t < 1e-12)


def test_a_grain_that_bounces_without_end_says_so_where_it_is() -> None:
    """With e = 1/2 all rebounds end after three times the fall."""
    height = np.array([0.25, 0.5])
    grains = vacuum(height, 0.0, 2, Ground(0.5, 0.0), saves=4)
    assert np.all(grains.status == BOUNCING) and not np.any(grains.success)
    np.testing.assert_allclose(grains.t, 3.0 * np.sqrt(2.0 * height / G), rtol=1e-9)
    assert np.all(grains.q[:, 2] == 0.0) and np.all(grains.contacts == 1000)
    assert np.all(np.isnan(grains.places[:, 4])) and np.all(np.isfinite(grains.places[:, 0]))
    assert vacuum(0.5, 0.0, 2, Ground(0.0, 0.0)).contacts == 1
    elastic = vacuum(height[:1], 0.0, 2, Ground(1.0, 0.0))
    assert elastic.status[0] == ALOFT and elastic.contacts[0] == 4
    energy = G * elastic.q[0, 2] + 0.5 * elastic.v[0, 2] ** 2
    assert energy == pytest.approx(G * height[0], rel=1e-12)


def test_the_root_of_the_curve_alone_is_of_the_order_of_the_curve() -> None:
    time, _ = fallen(HEIGHTS, 3.0)
    steps = [32, 64, 128]
    errors = [rms(drop(2, n, Ground(exact=False)).t - time) for n in steps]
    assert has_order(3, errors, steps)


def test_stokes_drag_in_rotation_and_strain_is_a_matrix_exponential() -> None:
    wind = "def wind(q, decay):\n    return 1.5 * q[0] - 2.0 * q[1], 2.0 * q[0] - 1.5 * q[1], 0.0\n"
    start = np.array([0.4, -0.2, 50.0, 0.3, 1.0, 0.0])
    generator = np.zeros((7, 7))
    generator[:3, 3:6], generator[3:5, :2] = np.eye(3), RATE * np.array([[1.5, -2.0], [2.0, -1.5]])
    generator[3:6, 3:6], generator[5, 6] = -RATE * np.eye(3), -G
    exact = (expm(generator) @ np.append(start, 1.0))[:6]
    steps, errors = [8, 16, 32], []
    for n in steps:
        grains = still(2, start[None, :3], start[None, 3:], 1.0 / n, 1.0, RATE, STOKES, wind=wind)
        errors.append(np.abs(np.append(grains.q, grains.v) - exact).max())
    assert has_order(4, errors, steps)


def cloud(order: Any = slice(None), threads: int = 1) -> flights.Flights:
    q, v, t = (array[order] for array in thrown(100, 3, top=1.0))
    law, rates = rates_of(galvi.problems.brownout(300e-6, drag_coefficient=None), len(q))
    step = np.where(np.arange(100) < 40, 1 / 32, 1 / 64)[order]
    return follow(gauss(2), q, v, t, rates, law, step, 1.0, gravity=G, saves=8,
                  ground=Ground(0.5), threads=threads)  # fmt: skip


def test_a_grains_numbers_depend_on_nothing_but_the_grain(monkeypatch: pytest.MonkeyPatch) -> None:
    grains = cloud()
    assert {ALOFT, LANDED} <= set(grains.status) and grains.contacts.max() > 2
    monkeypatch.setattr(flights, "BATCH_GRAINS", 7)
    for order in (np.random.default_rng(1).permutation(100), np.array([17]), np.arange(50, 59)):
        for name, numbers in vars(cloud(order, threads=2)).items():
            np.testing.assert_array_equal(getattr(grains, name)[order], numbers, name)


def test_the_momentum_of_each_grain_is_accounted_for() -> None:
    _, v, t = thrown(100, 3, top=1.0)
    grains = cloud()
    change = grains.v - v
    change[:, 2] += G * (grains.t - t)
    size = np.abs(v).max() + np.abs(grains.drag).max() + np.abs(grains.contact).max()
    assert np.abs(change - grains.drag - grains.contact).max() < 5e-14 * size  # 1e-14
    assert np.abs(grains.contact).max() > 0.1 * size


def test_places_are_kept_from_the_start_to_the_end_and_on_the_ground() -> None:
    grains = cloud()
    _, _, t = thrown(100, 3, top=1.0)
    times = np.linspace(0.0, 1.0, 9)
    before = times[None, :] < t[:, None]
    assert np.array_equal(np.isnan(grains.places[:, :, 0]), before)
    later = ~before & (times[None, :] >= grains.t[:, None])
    ends = np.broadcast_to(grains.q[:, None], grains.places.shape)
    np.testing.assert_array_equal(grains.places[later], ends[later])
    assert np.all(grains.places[~before][:, 2] >= 0.0)


def test_grains_that_cannot_be_solved_fail_alone() -> None:
    """The wind is NaN beyond x = 4."""
    wind = (
        "from galvi.lanes.elementary import sqrt\n\n\n"
        "def wind(q, decay):\n    return 2.0 + 0.0 * sqrt(4.0 - q[0]), 0.0, 0.0\n"
    )
    q = np.stack([np.linspace(-4.0, 3.9, 20), np.zeros(20), np.full(20, 60.0)], axis=1)
    grains = still(2, q, [[2.0, 0.0, 0.0]], 1 / 16, 1.0, 5.0, STOKES, wind=wind, saves=4)
    fails = q[:, 0] + 2.0 > 4.0
    assert np.array_equal(grains.status == FAILED, fails) and np.any(fails) and not np.all(fails)
    assert np.all(np.isnan(grains.q[fails])) and np.all(np.isnan(grains.places[fails, -1]))
    np.testing.assert_allclose(grains.q[~fails, 0], q[~fails, 0] + 2.0, atol=1e-12)


@given(step=st.integers(3, 999).map(lambda k: 1.0 / k))
@settings(max_examples=30, deadline=None)
def test_a_grain_that_starts_at_the_end_of_a_step_takes_whole_steps(step: float) -> None:
    """Also where the division of its time by the step is rounded down; thrown from the ground."""
    k = np.arange(min(40, round(0.5 / step)))
    grains = still(2, *upright(0.0 * k, 2.0), step, 1.0, G / 9.0, t0=k * step)
    has_landed = grains.status == LANDED
    assert has_landed[0] and np.all(has_landed | (k * step + grains.t[0] > 1.0 - 2.0 * step))
    np.testing.assert_allclose((grains.t - k * step)[has_landed], grains.t[0], atol=1e-9)
    assert np.all(grains.steps[has_landed] - grains.steps[0] <= 2)


@given(parts=st.integers(1, 400), fraction=st.floats(0.0, 1.0, exclude_max=True))
@settings(max_examples=60, deadline=None)
def test_a_start_at_a_saved_time_is_a_saved_place(parts: int, fraction: float) -> None:
    """Although k / n may not be k (1 / n); also a unit in the last place before or after."""
    k = int(fraction * parts)
    t = k / parts + np.array([-1.0, 0.0, 1.0]) * np.spacing(k / parts) * (k > 0)
    grains = still(2, *upright([9.0] * 3, 0.0), 1.0 / parts, 1.0, 1.0, t0=t, saves=parts)
    assert np.all(np.isnan(grains.places[:, :k])) and not np.any(np.isnan(grains.places[:, k:]))
    assert np.all(grains.places[:, k, 2] == 9.0) and np.all(grains.steps == parts - k)


def test_a_grain_that_starts_after_the_end_waits() -> None:
    t = [0.2, 1.0, 1.5, 1e19, 1e300]
    grains = still(2, *upright([9.0] * 5, 0.0), 0.25, 1.0, 1.0, t0=np.array(t))
    assert list(grains.status) == [ALOFT] + 4 * [WAITING] and np.all(grains.steps[1:] == 0)
    assert grains.steps[0] == 4 and grains.t[0] == 1.0 and list(grains.t[1:]) == t[1:]
    assert np.all(grains.success)


def test_a_start_from_two_steps_saves_passes() -> None:
    """60 steps with two points take 280 passes; 292 with a start from one step, 336 with none."""
    start = galvi.problems.brownout(200e-6, [8.5, 0.0, 12.0])
    law, rates = rates_of(start, 1)
    grains = follow(gauss(2), [start.q0], [start.v0], [0.0], rates, law, 0.03, 1.8, gravity=G)
    assert 270 < grains.passes[0] < 288


@pytest.mark.parametrize(
    ("changed", "sentence"),
    [
        ({"method": galvi.Galerkin(galvi.Polynomials(2), galvi.gauss(3))}, "take Gauss colloc"),
        ({"method": gauss(9)}, "at most 8 points; received 9"),
        ({"step": 1e-15}, r"step must be at least until / 1e\+09; received 1e-15 for 1.0"),
        ({"step": [0.25, 0.3]}, "a whole fraction of until.* received 0.3 for 1.0"),
        ({"step": 1e308}, "a whole fraction of until"),
        ({"step": -0.25}, "step must be positive; received -0.25"),
        ({"rates": -1.0}, "rates must not be negative; received -1.0"),
        ({"saves": -1}, "saves must be a whole number"),
        ({"threads": -1}, "threads must be a whole number"),
        ({"t0": 0.0}, "shape"),
        ({"q0": [[1.0, 0.0, -0.1], [1.0, 0.0, 1.0]]}, "ground.* received 1 o"),
        ({"q0": [[1.0, 0.0, 0.0]] * 2}, "on it with an upward velocity"),
        ({"t0": [-1.0, 0.0]}, "from t = 0 on"),
        ({"v0": [[0.0, 0.0]]}, r"v0 must have shape \(2, 3\)"),
    ],
)
def test_bad_input_gets_one_clear_sentence(changed: dict[str, Any], sentence: str) -> None:
    arguments: dict[str, Any] = {
        "method": gauss(2),
        "q0": [[1.0, 0.0, 1.0]] * 2,
        "v0": np.zeros((2, 3)),
        "t0": [0.0] * 2,
        "rates": 1.0,
        "drag": NEWTON,
        "step": 0.25,
        "until": 1.0,
        "gravity": G,
    } | changed
    arguments["rates"] = [[arguments["rates"]]] * 2
    with pytest.raises(ValueError, match=sentence):
        follow(**arguments)


@pytest.mark.parametrize("name", ["restitution", "slowest"])
def test_a_ground_is_checked(name: str) -> None:
    for value in (-0.5, math.nan):
        with pytest.raises(ValueError, match=f"{name} must"):
            Ground(**{name: value})


@pytest.mark.parametrize(("s", "within"), [(1, 2e-2), (2, 1e-6)])
def test_a_small_jump_from_the_ground_is_a_flight(s: int, within: float) -> None:
    """Much shorter than the step: the curve's own velocity at its start points downwards."""
    speed = np.array([1e-3, 1e-2, 5e-2])
    grains = still(s, *upright(0.0, speed), 0.25, 1.0, RATE, STOKES)
    assert np.all(grains.status == LANDED) and np.all(grains.contacts == 1)
    np.testing.assert_allclose(grains.t, landed(0.0, speed)[0], rtol=within)  # 7e-3


UPWARDS = "def wind(q, decay):\n    return 1.0, 0.0, 8.0\n"


def test_the_ground_never_pulls() -> None:
    """Where a coarse curve dips below the ground but the step rises, there is no contact."""
    random, n = np.random.default_rng(1), 400
    q, v = np.zeros((2, n, 3))
    q[:, 2], v[:, 0], v[:, 2] = random.uniform(1e-4, 0.5, n), 1.0, -random.uniform(0.1, 20.0, n)
    for exact in (True, False):
        grains = still(2, q, v, 0.25, 1.0, 15.0, STOKES, ground=Ground(exact=exact), wind=UPWARDS)
        assert np.all(grains.contact[:, 2] >= 0.0)
        assert np.all((grains.contact[:, 2] > 0.0) == (grains.status == LANDED))
        assert np.any(grains.status == LANDED) and np.any(grains.status == ALOFT)
        np.testing.assert_allclose(grains.q[:, 0], grains.t, atol=1e-12)  # with the wind
        assert np.all(np.abs(grains.v[grains.status == ALOFT, 0] - 1.0) < 1e-12)
