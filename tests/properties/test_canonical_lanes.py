"""Canonical systems in lanes: their derivatives, over long runs, and where lanes end."""

from __future__ import annotations

from decimal import Decimal
from typing import Any

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import galvi
from benchmarks.statistics.drift import Growth, growth
from galvi.extended_precision import extended_precision, scaled
from galvi.run import engines
from galvi.run.in_lanes import nystrom as nystrom_stepper
from galvi.run.in_lanes.tables import LawTables
from galvi.systems.canonical import Canonical
from galvi.tracing.lane_law import WIDEST_COUPLED_FORCE, WIDEST_FORCE
from references.forces.force import gradient

EIGHT = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
RANDOM = "kepler", "pendulum", "henon-heiles"


def both(problem: galvi.Problem, method: Any, step: float, steps: int, **given: Any) -> list[Any]:
    """The run in lanes and that of the general kernel."""
    runs = []
    with pytest.MonkeyPatch.context() as patch:
        for asked in (engines.ENGINES, (engines.GENERAL,)):
            patch.setattr(engines, "ENGINES", asked)
            runs.append(galvi.integrate(problem, method, step, steps, **given))
    return runs


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
    """At two stages."""
    kernel = galvi.Canonical(1.0, potential).force_kernel(3)
    Q, t = np.array([[0.3, 1.2], [-0.7, 0.4], [0.5, -0.9]]), np.zeros(2)
    slopes, blocks = np.full((3, 2), np.nan), np.full((3, 3, 2), np.nan)
    kernel.force(Q, t, kernel.constants, slopes)
    assert kernel.slope is not None
    kernel.slope(Q, t, kernel.constants, blocks)
    for q, slope, block in zip(Q.T, slopes.T, blocks.T, strict=True):
        hessian = [gradient(lambda x, i=i: potential.gradient(x)[i], q) for i in range(3)]
        assert np.allclose(slope, gradient(potential, q), rtol=0.0, atol=1e-11)
        assert np.allclose(block, hessian, rtol=0.0, atol=1e-11)
        assert np.allclose(potential.hessian(q), hessian, rtol=0.0, atol=1e-11)


def test_a_step_that_nothing_solves_ends_as_with_the_general_kernel() -> None:
    runs = both(galvi.problems.kepler(0.9), EIGHT, 2.5, 8, solver="fixed_point")
    assert not runs[0].success
    assert runs[0].status == runs[1].status and runs[0].failed_step == runs[1].failed_step


@pytest.mark.parametrize(
    ("wide", "mass"),
    [(WIDEST_FORCE + 1, 1.0), (WIDEST_COUPLED_FORCE + 1, np.eye(WIDEST_COUPLED_FORCE + 1))],
)
def test_many_coordinates_are_left_to_the_general_kernel(wide: int, mass: Any) -> None:
    problem = galvi.Problem(
        Canonical(mass, galvi.SpringChain(0.2)), 0.1 * np.ones(wide), np.zeros(wide)
    )
    lanes, general = both(problem, EIGHT, 0.1, 3)
    np.testing.assert_array_equal(lanes.q, general.q)


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

    def rounded(table: Any, form: Any) -> LawTables:
        made = sound(table, form)
        tables, P = made.tables.copy(), made.tables.shape[1]
        tables[P : 2 * P], tables[3 * P : 4 * P], tables[4 * P + 1 : 4 * P + 3] = 0.0, 0.0, 0.0
        return made._replace(tables=tables)

    monkeypatch.setattr(nystrom_stepper, "nystrom_tables", rounded)
    found = energy_growth("kepler", 10**5, 8)
    assert found.drifts and found.exponent > 0.9


@pytest.mark.parametrize("step", [1e155, 1e200])
def test_a_step_whose_square_overflows_fails_without_a_warning(step: float) -> None:
    method = galvi.Galerkin(galvi.Polynomials(5), galvi.gauss(5))
    run = galvi.integrate(galvi.problems.kepler(0.3), method, step, 2)
    assert not run.success and run.failed_step == 1
