"""Canonical systems in lanes: against the general kernel, over long runs, and where lanes end."""

from __future__ import annotations

from decimal import Decimal
from typing import Any

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import galvi
from benchmarks.statistics.drift import Growth, growth
from galvi.arrays import read_only
from galvi.extended_precision import extended_precision, scaled
from galvi.lanes import laws as potentials
from galvi.run import engines
from galvi.run.in_lanes import nystrom as nystrom_stepper
from galvi.systems.canonical import Canonical
from galvi.tracing.lane_law import WIDEST, WIDEST_COUPLED
from galvi.tracing.laws import slopes_of
from references.forces.force import gradient

EIGHT = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
HENON = """
def slopes(q, t, c):
    x, y = q
    return [x + 2.0 * x * y, y + x * x - y * y]
"""
RANDOM = "kepler", "pendulum", "henon-heiles"
DRIVEN = """
from galvi.lanes.elementary import cos, exp

def slopes(q, t, c):
    return [q[0] + cos(2.0 * t) * exp(0.1 * q[1]), 3.0 * q[1]]
"""


def both(problem: galvi.Problem, method: Any, step: float, steps: int, **given: Any) -> list[Any]:
    """The run in lanes and that of the general kernel."""
    runs = []
    with pytest.MonkeyPatch.context() as patch:
        for asked in (engines.ENGINES, (engines.GENERAL,)):
            patch.setattr(engines, "ENGINES", asked)
            runs.append(galvi.integrate(problem, method, step, steps, **given))
    return runs


def agree(runs: list[Any], bound: float = 2e-13) -> bool:
    """Whether two runs are the same up to round-off: 2e-14 after 30 steps at most."""
    lanes, general = runs
    times = np.linspace(lanes.t[0], lanes.t[-1], 37)
    pairs = ((lanes.q, general.q), (lanes.p, general.p), (lanes(times), general(times)))
    equal = all(np.allclose(one, other, rtol=bound, atol=bound) for one, other in pairs)
    return equal and bool(lanes.success and general.success)


def system(potential: Any, mass: Any, random: np.random.Generator, d: int) -> Canonical:
    """A canonical system with a mass of this kind."""
    root = random.normal(size=(d, d))
    masses = {
        "number": 1.3,
        "diagonal": random.uniform(0.5, 2.0, d),
        "full": root @ root.T + np.eye(d),
    }
    return galvi.Canonical(masses[mass], potential)


@pytest.mark.parametrize(
    "potential",
    [
        galvi.CentralForce(0.8),
        galvi.CosinePotential(1.2),
        galvi.LinearSpring(0.7),
        galvi.SpringChain(0.3, 0.5),
        galvi.UniformField([0.3, -0.8, 0.5]),
    ],
)
def test_the_functions_of_a_kernel_are_the_derivatives_of_the_potential(potential: Any) -> None:
    """At two stages; as written in Python, which is what is compiled."""
    law, Q = potential.law(), np.array([[0.3, 1.2], [-0.7, 0.4], [0.5, -0.9]])
    slopes, blocks = np.full((3, 2), np.nan), np.full((3, 3, 2), np.nan)
    law.gradient.py_func(Q, 0.0, law.constants, slopes)
    law.hessian.py_func(Q, 0.0, law.constants, blocks)
    for q, slope, block in zip(Q.T, slopes.T, blocks.T, strict=True):
        hessian = [gradient(lambda x, i=i: potential.gradient(x)[i], q) for i in range(3)]
        assert np.allclose(slope, gradient(potential, q), rtol=0.0, atol=1e-11)
        assert np.allclose(block, hessian, rtol=0.0, atol=1e-11)
        assert np.allclose(potential.hessian(q), hessian, rtol=0.0, atol=1e-11)


@pytest.mark.slow_cases(but=["centre"])
@pytest.mark.parametrize("kind", ["centre", "cosine", "spring", "chain", "field"])
@settings(max_examples=8)
@given(data=st.data())
def test_a_run_in_lanes_is_that_of_the_general_kernel(kind: str, data: st.DataObject) -> None:
    random = np.random.default_rng(data.draw(st.integers(0, 10**6)))
    d = data.draw(st.sampled_from((2, 3) if kind == "centre" else (1, 2, 4, 7)))
    potential = {
        "centre": galvi.CentralForce(0.8), "cosine": galvi.CosinePotential(1.2),
        "spring": galvi.LinearSpring(2.0), "chain": galvi.SpringChain(0.3, 0.5),
        "field": galvi.UniformField(random.normal(size=d)),
    }[kind]  # fmt: skip
    found = system(potential, data.draw(st.sampled_from(("number", "diagonal", "full"))), random, d)
    degree = data.draw(st.sampled_from((1, 2, 5, 8, 9)))
    points = degree + data.draw(st.sampled_from((0, 1, 3)))
    method = galvi.Galerkin(galvi.Polynomials(degree), galvi.gauss(points))
    q0 = random.uniform(0.6, 1.0, d)
    problem = galvi.Problem(found, q0, random.normal(size=d) * 0.3)
    step = data.draw(st.sampled_from((0.04, -0.05)))
    assert agree(both(problem, method, step, 20))


@pytest.mark.parametrize("name", ["central_force", "linear_spring", "pendulum", "spring_chain"])
def test_slopes_are_the_gradient_of_the_potential(name: str) -> None:
    potential: Any = {
        "central_force": galvi.CentralForce(0.8), "linear_spring": galvi.LinearSpring(2.0),
        "pendulum": galvi.CosinePotential(1.2), "spring_chain": galvi.SpringChain(0.3, 0.5),
    }[name]  # fmt: skip
    law, q = potential.law(), np.array([0.7, -0.4, 0.9])
    found = slopes_of(galvi.Canonical(1.0, potential))
    assert found is not None and found[0].endswith(f" import {name} as slopes")
    assert np.array_equal(found[1], law.constants)
    slope = np.array(getattr(potentials, name)(q, 0.0, law.constants))
    np.testing.assert_allclose(slope, potential.gradient(q), rtol=1e-14)
    step = 1e-5 * np.eye(3)
    slopes = (potential(q + step) - potential(q - step)) / 2e-5
    np.testing.assert_allclose(slope, slopes, rtol=1e-8)


@pytest.mark.slow_cases("the mass left out")
@pytest.mark.parametrize("fault", ["another potential", "its sign", "the mass left out"])
def test_a_wrong_force_in_lanes_does_not_agree(fault: str, monkeypatch: Any) -> None:
    mass = np.array([1.3, 0.7]) if fault == "the mass left out" else 1.0
    found = Canonical(mass, galvi.CosinePotential(1.2))
    lines = {
        "another potential": "return [c[0] * x for x in q]",
        "its sign": "return [-(c[0] * sin(x)) for x in q]",
        "the mass left out": "return [c[0] * sin(q[0]) * 1.3, c[0] * sin(q[1]) * 0.7]",
    }[fault]
    given_slopes(
        f"from galvi.lanes.elementary import sin\n\ndef slopes(q, t, c):\n    {lines}\n",
        monkeypatch,
    )
    assert not agree(both(galvi.Problem(found, [0.7, 0.2], [0.1, 0.4]), EIGHT, 0.1, 10))


def given_slopes(lines: str, monkeypatch: Any) -> None:
    """Let every canonical system have these slopes in lanes."""
    monkeypatch.setattr(
        nystrom_stepper, "slopes_of", lambda system: (lines, (slopes_of(system) or ["", []])[1])
    )


def test_lines_of_code_for_a_gradient_run_in_lanes(monkeypatch: Any) -> None:
    given_slopes(HENON, monkeypatch)
    lanes, general = both(galvi.problems.henon_heiles(), EIGHT, 0.3, 40)
    assert agree([lanes, general])
    assert not np.array_equal(lanes.q, general.q)  # another kernel


def test_lines_of_code_know_the_time(monkeypatch: Any) -> None:
    def potential(q: Any, t: float) -> float:
        return float(q[0] ** 2 / 2 + q[0] * np.cos(2 * t) * np.exp(q[1] / 10) + 1.5 * q[1] ** 2)

    def gradient(q: Any, t: float) -> Any:
        return np.array([q[0] + np.cos(2 * t) * np.exp(q[1] / 10), 3.0 * q[1]])

    found = galvi.Canonical(1.0, potential, gradient, explicit_time=True, check=False)
    given_slopes(DRIVEN, monkeypatch)
    assert agree(both(galvi.Problem(found, [0.4, 0.2], [0.1, -0.3], t0=0.7), EIGHT, 0.1, 12))


def test_a_step_too_long_for_the_iteration_is_left_to_newtons_method() -> None:
    problem = galvi.Problem(galvi.Canonical(1.0, galvi.LinearSpring(30.0)), [0.7], [0.2])
    runs = both(problem, galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4)), 1.5, 40)
    assert all(run.counts["linear_solves"] > 0 for run in runs)
    assert agree(runs)


def test_a_step_that_nothing_solves_ends_as_with_the_general_kernel() -> None:
    runs = both(galvi.problems.kepler(0.9), EIGHT, 2.5, 8, solver="fixed_point")
    assert not runs[0].success
    assert runs[0].status == runs[1].status and runs[0].failed_step == runs[1].failed_step


@pytest.mark.parametrize(
    ("wide", "mass"), [(WIDEST + 1, 1.0), (WIDEST_COUPLED + 1, np.eye(WIDEST_COUPLED + 1))]
)
def test_many_coordinates_are_left_to_the_general_kernel(wide: int, mass: Any) -> None:
    problem = galvi.Problem(
        Canonical(mass, galvi.SpringChain(0.2)), 0.1 * np.ones(wide), np.zeros(wide)
    )
    lanes, general = both(problem, EIGHT, 0.1, 3)
    np.testing.assert_array_equal(lanes.q, general.q)


@pytest.mark.parametrize("v0", [0.0, 0.5])
@pytest.mark.parametrize("potential", [galvi.UniformField([0.0, -9.81]), galvi.LinearSpring(2.0)])
def test_a_motion_from_the_origin_is_right(potential: Any, v0: float) -> None:
    problem = galvi.Problem(galvi.Canonical(1.0, potential), [0.0, 0.0], [v0, 0.0])
    assert agree(both(problem, EIGHT, 0.1, 20))


def energy_growth(name: str, steps: int, members: int) -> Growth:
    """Growth of the relative energy error, evaluated with 40 digits, of the state with its low
    part."""
    problem, step, potential = {
        "kepler": (galvi.problems.kepler(0.3), 0.15, lambda q: -1 / mp.norm(q)),
        "pendulum": (galvi.problems.planar_pendulum(), 0.2, lambda q: -mp.cos(q[0])),
        "henon-heiles": (
            galvi.problems.henon_heiles(),
            0.3,
            lambda q: (q[0] ** 2 + q[1] ** 2) / 2 + q[0] ** 2 * q[1] - q[1] ** 3 / 3,
        ),
    }[name]
    at = np.unique(np.geomspace(steps / 50, steps, 9).round().astype(int))
    errors = np.empty((members, at.size))
    with mp.workdps(40):
        for row in range(members):
            away = 1.0 + 1e-3 * np.random.default_rng([7, row]).standard_normal((2, 1))
            start = problem.with_initial_state(problem.q0 * away[0], problem.v0 * away[1])
            run = galvi.integrate(start, EIGHT, step, int(at[0]), save_every=int(at[0]))
            for column, number in enumerate(at):
                if column:
                    more = int(number - at[column - 1])
                    run = galvi.resume(run, more, save_every=more)
                assert run.success and run.checkpoint is not None, run.status
                states = [
                    [mp.mpf(x) + mp.mpf(y) for x, y in zip(high, low, strict=True)]
                    for high, low in (run.checkpoint.state[:2], run.checkpoint.state[2:])
                ]
                before = [[mp.mpf(x) for x in row] for row in (start.q0, start.v0)]
                first, last = (
                    sum(x * x for x in v) / 2 + potential(q) for q, v in (before, states)
                )
                errors[row, column] = float((last - first) / abs(first))
    return growth(step * at, errors)


@pytest.mark.slow_cases("kepler-100000-8", "henon-heiles-100000-8")
@pytest.mark.parametrize(
    ("name", "steps", "members"),
    [*((name, 10**5, 8) for name in RANDOM), *(
        pytest.param(name, 10**6, 16, marks=pytest.mark.slow) for name in RANDOM
    )],
)  # fmt: skip
def test_the_energy_error_is_a_random_walk(name: str, steps: int, members: int) -> None:
    """Measured: exponents 0.50 to 0.62; 5e-15 to 1e-14 after 1e5 steps, 4e-14 after 1e6."""
    found = energy_growth(name, steps, members)
    assert not found.drifts, found.sigmas
    assert found.exponent < 0.85
    assert found.final < 5e-17 * steps**0.5


NUMBERS = st.floats(-1e3, 1e3).filter(lambda x: x == 0.0 or abs(x) > 1e-100)


@given(NUMBERS, st.floats(-1.0, 1.0), st.floats(1e-30, 1e30), st.sampled_from((-1.0, 1.0)))
def test_a_table_times_a_step_is_rounded_to_a_hundred_bits(
    high: float, share: float, step: float, sign: float
) -> None:
    low = 0.49 * share * float(np.spacing(high)) if high else 0.0
    for power in (1, 2):
        kept, lost = scaled(np.array([high, low]), sign * step, power)
        with extended_precision():
            exact = (Decimal(high) + Decimal(low)) * Decimal(sign * step) ** power
            missing = abs(exact - Decimal(float(kept)) - Decimal(float(lost)))
            assert missing <= abs(exact) * Decimal(2.0**-98)
        assert abs(lost) <= 0.51 * np.spacing(abs(kept))


def test_a_table_rounded_to_float64_drifts_and_is_seen_to(monkeypatch: Any) -> None:
    """Without the low parts of h b, h^2 beta, h^2 A and c the energy drifts by 2e-18 a step."""
    sound = nystrom_stepper.nystrom_tables

    def rounded(table: Any, step: float, lanes: int) -> tuple[Any, ...]:
        kicks, ahead, series, tables, *others = sound(table, step, lanes)
        kicks, tables, P = kicks.copy(), tables.copy(), tables.shape[1]
        kicks[:, 2:], tables[1] = 0.0, 0.0
        tables[2:].reshape(-1, 2, P, P)[:, 1] = 0.0
        return read_only(kicks), ahead, series, tables, *others

    monkeypatch.setattr(nystrom_stepper, "nystrom_tables", rounded)
    found = energy_growth("kepler", 10**5, 8)
    assert found.drifts and found.exponent > 0.9
