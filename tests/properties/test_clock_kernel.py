"""Steps of point masses in a clock, in lanes, against independent formulas and solvers."""

from __future__ import annotations

from decimal import Decimal
from itertools import combinations
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import galvi
from galvi.arrays import Array
from galvi.checkpoint import Checkpoint
from galvi.extended_precision import decimals, extended_precision
from galvi.kernels.forces.celestial import pulls
from galvi.lanes.clocks.rows import COLUMNS, TURN
from galvi.run.clocked import in_lanes as clock_stepper
from galvi.run.clocked.in_lanes import (
    as_moving,
    energy_of,
    masses_in_clock,
    mean_velocity,
    motion_in_lanes,
)
from galvi.run.clocked.motion import Motion, Taken
from galvi.run.clocked.transformed import motion_in_transformed_time
from galvi.run.request import ROUND_OFF
from galvi.run.stepper import Declined
from galvi.systems.nbody import NBody

# Burrau's problem at t = 63, the first body: quadruple precision, another engine.
BURRAU_AT_63 = 2.8394339724915002, 8.1128544246959514


FLAT = galvi.Oblateness(1, 0.02, 0.5)
TILTED = galvi.Oblateness(0, 0.02, 0.5, J4=-0.03, pole=(0.2, 0.3, 1.0))
SMALL = galvi.Oblateness(0, 0.02, 0.02, J4=-0.03, pole=(0.2, 0.3, 1.0))
BENT = galvi.Relativity(12.0, form="potential")
LOGARITHM = galvi.PowerLaw(0, -0.05, -1)


def gauss(s: int) -> galvi.Galerkin:
    return galvi.Galerkin(galvi.Polynomials(s), galvi.gauss(s), clock=galvi.DynamicalTime())


def begin(problem: galvi.Problem, s: int, energy: float = np.nan) -> tuple[Any, ...]:
    d = problem.q0.size
    state = np.zeros((4, d))
    state[0], state[2] = problem.q0.ravel(), problem.v0.ravel()
    system: Any = problem.system
    M, mean = system.G * system.masses, mean_velocity(system, problem.v0)
    told = [energy, 0.0] if np.isnan(energy) else as_moving([energy, 0.0], M, problem.v0, mean)
    clock = np.array([problem.t0, 0.0, *told])
    return state, np.zeros((2 * d, s)), np.zeros(3, dtype=np.int64), clock


def advance(problem: galvi.Problem, s: int) -> Any:
    motion = motion_in_lanes(problem, gauss(s), None)
    assert isinstance(motion, Motion)

    def step(
        state: Array, stages: Array, known: Any, clock: Array, h: float, n: int, keep: bool
    ) -> tuple[Any, ...]:
        if np.isnan(clock[2]):
            clock = motion.at(problem.q0, problem.v0, problem.t0).clock
        start = Checkpoint(0, state, stages, known, "auto", ROUND_OFF, clock=clock)
        found = motion.advance(start, h, n, None, keep)
        after = found.after
        return (
            found.taken, after.state, after.stages, after.solver_state, after.clock, found.code
        )  # fmt: skip

    return step


def several(masses: Any, dimension: int, G: float = 1.0, forces: Any = ()) -> galvi.Problem:
    """Bodies about a unit apart, at moderate speeds."""
    rng = np.random.Generator(np.random.Philox(11))
    n = len(masses)
    q = 1.5 * np.arange(n)[:, None] ** [[1.0, 0.5, 0.2][:dimension]] + 0.2 * rng.normal(
        size=(n, dimension)
    )
    return galvi.Problem(NBody(masses, G, forces), q, 0.3 * rng.normal(size=(n, dimension)))


def burrau() -> galvi.Problem:
    q = np.array([[1.0, 3.0], [-2.0, -1.0], [1.0, -1.0]])
    return galvi.Problem(NBody([3.0, 4.0, 5.0]), q, np.zeros_like(q))


def pace(problem: galvi.Problem, q: Any, given: Any = None) -> Any:
    """g, from its definition; q (bodies, dimension) may be complex.

    given  places of bodies in pairs that hold a massless one
    """
    system: Any = problem.system
    total = 0.0
    for i, j in combinations(range(len(q)), 2):
        mass = system.G * (system.masses[i] + system.masses[j])
        heavy = given is None or (system.masses[i] > 0.0 and system.masses[j] > 0.0)
        gap = q[i] - q[j] if heavy else given[i] - given[j]
        total = total + (mass / np.sum(gap**2) ** 1.5) if mass else total
    return total**-0.5


def energy(problem: galvi.Problem, q: Any, v: Any) -> Any:
    system: Any = problem.system
    m = system.masses
    total = 0.5 * np.sum(m * np.sum(v * v, axis=1))
    for i, j in combinations(range(len(q)), 2):
        total = total - system.G * m[i] * m[j] / np.sqrt(np.sum((q[i] - q[j]) ** 2))
    return total + pulls(system.acting.terms, system.acting.poles, q)[1]


def rates(problem: galvi.Problem, e0: float) -> Any:
    """(q, v, t)' by tau: Hamilton's equations of g (H - E0) for the bodies with a mass, where the
    part of g from pairs with a massless one is a given function of tau; complex steps."""
    system: Any = problem.system
    shape, d = problem.q0.shape, problem.q0.size

    def right_side(_tau: float, y: Array) -> Array:
        q, v = y[:d].reshape(shape), y[d : 2 * d].reshape(shape)
        clock, slope = pace(problem, q), np.zeros(d)
        for k in range(d):
            moved = q.astype(complex)
            moved.flat[k] += 1e-30j
            slope[k] = np.imag(pace(problem, moved, q)) / 1e-30
        excess = energy(problem, q, v) - e0
        mass = np.where(system.masses > 0.0, system.masses, np.inf)[:, None]
        turn = clock * system.acceleration(q, 0.0) - excess * slope.reshape(shape) / mass
        return np.concatenate([clock * v.ravel(), turn.ravel(), [clock]])

    return right_side


@pytest.mark.slow_cases("masses0-2-1.0-8-forces0")
@pytest.mark.parametrize(
    ("masses", "dimension", "G", "s", "forces"),
    [
        ([3.0, 4.0, 5.0], 2, 1.0, 8, ()),
        ([1.0, 0.5, 0.0, 0.0, 0.7], 3, 2.5, 12, ()),
        ([2.0, 0.0], 3, 0.3, 3, ()),
        ([3.0, 4.0, 5.0], 2, 0.8, 8, (FLAT, LOGARITHM)),
        ([1.0, 0.5, 0.0, 0.0, 0.7], 3, 2.5, 12, (LOGARITHM, TILTED, BENT)),
        ([2.0, 0.0], 3, 0.3, 3, BENT),
    ],
)
def test_steps_solve_the_equations_of_the_clock(
    masses: Any, dimension: int, G: float, s: int, forces: Any
) -> None:
    """With an energy E0 that is not the state's, so that each term counts; massless bodies too."""
    problem = several(masses, dimension, G, forces)
    off = 1.1 * energy(problem, problem.q0, problem.v0) - 0.1
    h, n = (0.02, 10) if s == 3 else (0.1, 10)
    taken, state, *_rest, clock, code = advance(problem, s)(
        *begin(problem, s, G * off), h, n, False
    )
    assert code == 0
    y = np.concatenate([problem.q0.ravel(), problem.v0.ravel(), [problem.t0]])
    end = solve_ivp(
        rates(problem, off), (0.0, n * h), y, method="DOP853", rtol=1e-13, atol=1e-14
    ).y[:, -1]  # fmt: skip
    found = np.concatenate([state[0], state[2], clock[:1]])
    assert np.max(np.abs(found - end)) < 3e-11 * max(1.0, np.max(np.abs(end)))
    assert np.array_equal(taken.q[-1], state[0]) and taken.t[-1, 0] == clock[0]


@pytest.mark.slow_cases(but=["forces0"])
@pytest.mark.parametrize("forces", [(), TILTED, BENT, LOGARITHM])
def test_the_law_of_the_kernel_is_that_of_the_general_engines(forces: Any) -> None:
    """To rounding, also with an energy that is not the state's; without the forces it is not."""
    problem = several([3.0, 4.0, 5.0], 3, 1.3, forces)
    given = several([3.0, 4.0, 5.0], 3, 1.3), gauss(8)
    for told in (1.0, 1.3):
        E = told * energy(problem, problem.q0, problem.v0)
        ways = (
            motion_in_lanes(problem, gauss(8), E),
            motion_in_transformed_time(problem, gauss(8), E, "auto", ROUND_OFF),
            motion_in_lanes(*given, E),
        )
        fast, general, plain = (
            way.advance(way.at(problem.q0, problem.v0, 0.0), 0.1, 20, None, False).taken
            for way in ways
            if way is not None
        )
        assert np.max(np.abs(fast.q - general.q)) < 1e-13  # 1e-15
        assert np.max(np.abs(fast.t - general.t)) < 1e-13
        assert not forces or np.max(np.abs(plain.q - general.q)) > 1e-5


def at_time(problem: galvi.Problem, s: int, h: float, time: float) -> Taken:
    """The last step to a time, shortened by Newton's method for its length."""
    step = advance(problem, s)
    here = begin(problem, s)
    while True:
        taken, *there, code = step(*here, h, 1, False)
        assert code == 0
        if taken.t[0, 0] > time:
            break
        here = tuple(there)
    state, stages, _known, clock = here
    length = 0.5 * h
    for _ in range(12):
        taken = step(state, stages, np.zeros(3, dtype=np.int64), clock, length, 1, False)[0]
        shape = problem.q0.shape
        length -= (taken.t[0].sum() - time) / pace(problem, taken.q[0].reshape(shape))
    return taken


def test_close_triples_are_followed_to_their_end() -> None:
    """An error of 3e-7: an adaptive code at its defaults has 1e-3."""
    taken = at_time(burrau(), 8, 0.4, 63.0)
    assert abs(taken.t[0, 0] - 63.0) < 1e-12
    assert np.max(np.abs(taken.q[0, :2] - BURRAU_AT_63)) < 3e-5


@pytest.mark.slow_cases(but=["8"])
@pytest.mark.parametrize("s", [4, 8, 9])
def test_steps_continue_reverse_and_change_nothing_given(s: int) -> None:
    problem = several([3.0, 4.0, 5.0, 0.0], 2)
    step, start = advance(problem, s), begin(problem, s)
    copies = [array.copy() for array in start]
    whole = step(*start, 0.2, 12, True)
    half = step(*start, 0.2, 6, True)
    rest = step(*half[1:5], 0.2, 6, True)
    for one, other in zip(start, copies, strict=True):
        assert np.array_equal(one, other, equal_nan=True)
    for one, other in zip(whole[1:5], rest[1:5], strict=True):
        assert np.array_equal(one, other)
    for name in ("q", "v", "t", "coefficients", "rates"):
        parts = [getattr(taken, name) for taken in (half[0], rest[0])]
        assert np.array_equal(getattr(whole[0], name), np.concatenate(parts))
    assert np.array_equal(whole[0].counts, half[0].counts + rest[0].counts)
    state, stages, _known, clock = whole[1:5]
    back = step(state, stages, np.zeros(3, dtype=np.int64), clock, -0.2, 12, False)
    assert np.max(np.abs(back[1] - start[0])) < 1e-11
    assert abs(back[4][0]) < 1e-12


def test_curves_and_rates_are_those_of_the_steps() -> None:
    problem, s, h = burrau(), 8, 0.3
    method = gauss(s)
    taken = advance(problem, s)(*begin(problem, s), h, 5, True)[0]
    bases = np.concatenate([problem.q0.reshape(1, -1), taken.q[:-1]])
    table = method.table
    for k, base in enumerate(bases):
        curve = base[:, None] + taken.coefficients[k] @ table.psi.T
        assert np.allclose(base + taken.coefficients[k] @ table.end, taken.q[k], rtol=0, atol=1e-14)
        there = [pace(problem, q.reshape(problem.q0.shape)) for q in curve.T]
        assert np.allclose(taken.rates[k], there, rtol=1e-12)
    lengths = h * (taken.rates @ table.b)
    assert np.allclose(np.diff(taken.t[:, 0], prepend=0.0), lengths, rtol=1e-13)


def test_the_energy_of_the_start_has_a_low_part() -> None:
    problem = several([3.0, 1e-9, 5.0, 0.0], 3, 0.7)
    system: Any = problem.system
    state = begin(problem, 3)[0]
    state[1], state[3] = 1e-17 * np.arange(12), -1e-18 * np.arange(12)
    high, low = energy_of(masses_in_clock(system, 3), state.reshape(4, 4, 3))
    with extended_precision():
        M = decimals(system.G * system.masses)
        q, v = ((decimals(state[k]) + decimals(state[k + 1])).reshape(4, 3) for k in (0, 2))
        exact = sum(m * sum(x * x) for m, x in zip(M, v, strict=True)) / 2
        for i, j in combinations(range(4), 2):
            exact -= M[i] * M[j] / sum((q[i] - q[j]) ** 2).sqrt()
        error = abs(Decimal(float(high)) + Decimal(float(low)) - exact)
        assert error < abs(exact) * Decimal(2) ** -98


def test_a_step_that_fails_leaves_those_before_it() -> None:
    problem = burrau()
    step, start = advance(problem, 8), begin(problem, 8)
    taken, state, stages, known, clock, code = step(*start, 40.0, 3, True)
    assert code in (1, 2)
    assert [len(part) for part in taken[:5]] == [0] * 5
    assert np.array_equal(state, start[0]) and clock[0] == 0.0
    after = step(state, stages, known, clock, 0.4, 4, True)
    assert after[-1] == 0 and np.array_equal(after[0].q, step(*start, 0.4, 4, False)[0].q)


def test_only_collocation_at_gauss_points_of_bodies_that_attract_is_taken() -> None:
    problem, light = burrau(), several([1.0], 2)
    assert isinstance(motion_in_lanes(several([1.0, 0.5], 2, 1.0, FLAT), gauss(4), None), Motion)
    for force in (galvi.Drag([0.1, 0.1]), galvi.Force(lambda q: 0.0 * q)):
        assert isinstance(
            motion_in_lanes(several([1.0, 0.5], 2, 1.0, force), gauss(4), None), Declined
        )
    assert isinstance(motion_in_lanes(light, gauss(4), None), Declined)
    assert isinstance(
        motion_in_lanes(galvi.problems.harmonic_oscillator(), gauss(4), None), Declined
    )
    assert isinstance(motion_in_lanes(problem, gauss(60), None), Declined)
    for space, rule in ((4, galvi.gauss(5)), (4, galvi.lobatto(5))):
        method = galvi.Galerkin(galvi.Polynomials(space), rule, clock=galvi.DynamicalTime())
        assert isinstance(motion_in_lanes(problem, method, None), Declined)


def drift(problem: galvi.Problem, blocks: int = 60, steps: int = 2000) -> tuple[float, float]:
    """The mean change of K = g (H - E0) in a step, in units of g |E0|, and its standard error."""
    system: Any = problem.system
    motion = motion_in_lanes(problem, gauss(8), None)
    assert isinstance(motion, Motion)
    state = motion.at(problem.q0, problem.v0, problem.t0)
    masses = masses_in_clock(system, problem.q0.shape[1])
    K = [0.0]
    for _ in range(blocks):
        state = motion.advance(state, 0.4, steps, None, False).after
        energy = energy_of(masses, state.state.reshape(4, *problem.q0.shape))
        K.append(float(motion.rate(state.state[0])) * float(np.sum(energy - state.clock[2:])))
    size = float(motion.rate(problem.q0.ravel())) * abs(state.clock[2])
    changes = np.diff(K) / (steps * size)
    return float(np.mean(changes)), float(np.std(changes, ddof=1) / np.sqrt(blocks))


def binary() -> galvi.Problem:
    """Two bodies of masses 3/4 and 1/4, e = 0.9, at pericentre, in a plane through no axis."""
    e, m = 0.9, np.array([[-0.25], [0.75]])
    x, y = np.array([0.8, 0.36, 0.48]), np.array([-0.6, 0.48, 0.64])
    return galvi.Problem(
        galvi.NBody([0.75, 0.25]), m * (1.0 - e) * x, m * np.sqrt((1.0 + e) / (1.0 - e)) * y
    )


@pytest.mark.slow(beside="test_steps_solve_the_equations_of_the_clock")
def test_the_energy_does_not_drift(monkeypatch: pytest.MonkeyPatch) -> None:
    """At most 4 standard errors of it; with an early stop there are more than 100."""
    plain = binary()
    forced = galvi.Problem(NBody(plain.system.masses, 1.0, (BENT, SMALL)), plain.q0, plain.v0)
    for problem in (plain, forced):
        mean, error = drift(problem)
        assert abs(mean) < 4.0 * error < 8e-17
    monkeypatch.setattr(clock_stepper, "CLOCK_TOLERANCE", 2.0**-48)
    monkeypatch.setattr(clock_stepper, "CLOCK_ROUNDING", 0.0)
    mean, error = drift(plain)
    assert abs(mean) > 8.0 * error


def test_the_path_of_a_light_body_tends_to_that_without_mass() -> None:
    """A comet about one of two stars, which sets the clock: off in proportion to its mass, and by
    1e-11: the rounding of H - E0 is not divided by its mass."""
    ends = {}
    for mass in (0.0, 1e-12, 1e-9, 1e-6, 1e-4):
        q = np.array([[0.0, 0.0, 0.0], [9.0, 4.0, 1.0], [0.2, 0.0, 0.05]])
        v = np.array([[0.0, 0.0, 0.0], [-0.15, 0.3, 0.1], [0.0, 2.9, 0.3]])
        problem = galvi.Problem(NBody([1.0, 0.5, mass]), q, v)
        ends[mass] = at_time(problem, 8, 0.3, 20.0).q[0].reshape(3, 3)
    for mass, end in ends.items():
        assert np.max(np.abs(end - ends[0.0])) < 200.0 * mass + 1e-11


def test_bodies_of_less_than_two_percent_of_the_second_are_light_and_turn_no_pair() -> None:
    masses = [1.0, 1e-3, 3e-5, 1e-5, 0.0]
    tables = [masses_in_clock(NBody(order), 3) for order in (masses, masses[::-1])]
    light = [table[3][1] == 0.0 for table in tables]
    assert light[0].tolist() == light[1][::-1].tolist() == [False, False, False, True, True]
    for table, small in zip(tables, light, strict=True):
        turns = table[0].reshape(-1, COLUMNS)[:, TURN] > 0.0
        both = [not (small[i] or small[j]) for i, j in combinations(range(5), 2)
                if masses[i] + masses[j] > 0.0]  # fmt: skip
        assert turns.tolist() == both
