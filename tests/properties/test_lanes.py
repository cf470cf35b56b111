"""Steps in lanes: long runs, loops in place of code that is written out, and limits of lanes."""

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
from galvi.lanes import dense, laws
from galvi.run import engines
from galvi.run.in_lanes import law_kernel
from galvi.run.in_lanes import nystrom as nystrom_stepper
from galvi.run.in_lanes.tables import LawTables
from galvi.tracing import lane_law
from tests.agreement.on_vector_spaces import chain, symbolic

EIGHT = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))


def in_general_kernel(problem: galvi.Problem, *arguments: Any, **options: Any) -> galvi.Trajectory:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(engines, "ENGINES", (engines.GENERAL,))
        return galvi.integrate(problem, *arguments, **options)


# ---------------------------------------------------------------- long runs


def energy_growth(name: str, steps: int, members: int) -> Growth:
    """The growth of the relative energy error of states with their low parts, in 40 digits."""
    problem, step, potential = {
        "kepler": (galvi.problems.kepler(0.3), 0.15, lambda q: -1 / mp.norm(q)),
        "pendulum": (galvi.problems.planar_pendulum(), 0.2, lambda q: -mp.cos(q[0])),
    }[name]
    step_counts = np.unique(np.geomspace(steps / 50, steps, 9).round().astype(int))
    errors = np.empty((members, step_counts.size))
    with mp.workdps(40):
        for row in range(members):
            start_factors = 1.0 + 1e-3 * np.random.default_rng([7, row]).standard_normal((2, 1))
            start = problem.with_initial_state(
                problem.q0 * start_factors[0], problem.v0 * start_factors[1]
            )
            run = galvi.integrate(
                start, EIGHT, step, int(step_counts[0]), save_every=int(step_counts[0])
            )
            for column, steps_done in enumerate(step_counts):
                if column:
                    added_steps = int(steps_done - step_counts[column - 1])
                    run = galvi.resume(run, added_steps, save_every=added_steps)
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
    return growth(step * step_counts, errors)


@pytest.mark.slow_cases(but=["pendulum-100000-8"])
@pytest.mark.parametrize(
    ("name", "steps", "members"),
    [("pendulum", 10**5, 8), ("pendulum", 10**6, 16), ("kepler", 10**6, 16)],
)
def test_the_energy_error_is_a_random_walk(name: str, steps: int, members: int) -> None:
    """Measured: exponents 0.50 to 0.62; 5e-15 to 1e-14 after 1e5 steps, 4e-14 after 1e6."""
    growth_of_error = energy_growth(name, steps, members)
    assert not growth_of_error.drifts, growth_of_error.sigmas
    assert growth_of_error.exponent < 0.85
    assert growth_of_error.final < 5e-17 * steps**0.5


def test_a_table_rounded_to_float64_drifts_and_is_seen_to(monkeypatch: Any) -> None:
    """Without the low parts of h b, h^2 beta, h^2 A and c the energy drifts by 2e-18 a step."""
    nystrom_tables = nystrom_stepper.nystrom_tables

    def rounded(table: Any, form: Any) -> LawTables:
        arrays = nystrom_tables(table, form)
        tables, P = arrays.tables.copy(), arrays.tables.shape[1]
        tables[P : 2 * P], tables[3 * P : 4 * P], tables[4 * P + 1 : 4 * P + 3] = 0.0, 0.0, 0.0
        return arrays._replace(tables=tables)

    monkeypatch.setattr(nystrom_stepper, "nystrom_tables", rounded)
    growth_of_error = energy_growth("kepler", 10**5, 8)
    assert growth_of_error.drifts and growth_of_error.exponent > 0.9


NUMBERS = st.floats(-1e3, 1e3).filter(lambda x: x == 0.0 or abs(x) > 1e-100)


@given(NUMBERS, st.floats(-1.0, 1.0), st.floats(1e-30, 1e30), st.sampled_from((-1.0, 1.0)))
def test_a_table_times_a_step_is_rounded_to_a_hundred_bits(
    high: float, fraction: float, step: float, sign: float
) -> None:
    low = 0.49 * fraction * float(np.spacing(high)) if high else 0.0
    for power in (1, 2):
        high_part, low_part = scaled(np.array([high, low]), sign * step, power)
        with extended_precision():
            exact = (Decimal(high) + Decimal(low)) * Decimal(sign * step) ** power
            error = abs(exact - Decimal(float(high_part)) - Decimal(float(low_part)))
            assert error <= abs(exact) * Decimal(2.0**-98)
        assert abs(low_part) <= 0.51 * np.spacing(abs(high_part))


def test_more_points_cost_few_more_passes_and_energy_does_not_drift() -> None:
    """The measured drift is 3.2e-20 a step."""
    start, steps = symbolic("elastic pendulum"), 100_000
    collocation, overdetermined = (
        galvi.integrate(
            start, galvi.Galerkin(galvi.Polynomials(8), rule), 0.02, steps, save_every=200
        )
        for rule in (galvi.gauss(8), galvi.gauss(16))
    )
    energy = galvi.energy(overdetermined)
    assert overdetermined.success and overdetermined.counts["linear_solves"] == 0
    assert overdetermined.counts["iterations"] < 1.1 * collocation.counts["iterations"]
    slope = np.polyfit(np.arange(energy.size) * 200, energy, 1)[0]
    assert abs(slope) < 2e-19 * np.max(np.abs(energy))


# ---------------------------------------------------------------- loops


@pytest.mark.parametrize("points", [5, 6])
def test_steps_are_the_same_with_loops(points: int, monkeypatch: Any) -> None:
    """The passes are as many, too: a wrong factor of the mass would only add passes."""
    problem = chain(5)
    method = galvi.Galerkin(galvi.Polynomials(5), galvi.gauss(points))
    written_out = galvi.integrate(problem, method, 0.02, 10)
    caches = (law_kernel.law_on_space, law_kernel.law_on_group, lane_law.compiled_law)
    for cached in caches:
        cached.cache_clear()
    monkeypatch.setattr(dense, "WRITTEN_OUT_PRODUCTS", -1)
    monkeypatch.setattr(lane_law, "STEP", lane_law.STEP + "\n\n# in loops\n")  # another file
    in_loops = galvi.integrate(problem, method, 0.02, 10)
    for cached in caches:
        cached.cache_clear()
    assert in_loops.engine == written_out.engine == "lanes"
    assert in_loops.counts == written_out.counts
    np.testing.assert_allclose(in_loops.q, written_out.q, rtol=0, atol=1e-14)  # 4e-16
    np.testing.assert_allclose(in_loops.p, written_out.p, rtol=0, atol=1e-14)


# ---------------------------------------------------------------- masses of laws

FIELD = galvi.UniformField([0.3, -0.2, 1.0])
LAWS: dict[str, tuple[Any, Any]] = {  # the law, and its constants
    "chain": (laws.planar_chain(3), chain(3).system.function.numbers),
    **{
        name: (
            laws.canonical(laws.returning_slopes(FIELD.slopes), 3, name == "masses"),
            np.append(mass.ravel(), FIELD.constants),
        )
        for name, mass in (("masses", np.diag([1.0, 2.0, 3.0])), ("coupled", np.eye(3) + 0.3))
    },
}


@pytest.mark.parametrize("name", LAWS)
def test_the_mass_of_a_law_takes_velocities_to_momenta(name: str) -> None:
    """A wrong mass would not change the steps, only add passes."""
    law, constants = LAWS[name]
    q, v = np.random.default_rng(2).normal(size=(2, 3))
    _, momenta, rows = law(q, v, 0.0, constants)
    mass = np.array([[rows[max(i, j)][min(i, j)] for j in range(3)] for i in range(3)])
    np.testing.assert_allclose(mass @ v, momenta, rtol=1e-13)


# ---------------------------------------------------------------- where lanes end


def test_a_step_that_nothing_solves_ends_as_with_the_general_kernel() -> None:
    arguments = galvi.problems.kepler(0.9), EIGHT, 2.5, 8
    run = galvi.integrate(*arguments, solver="fixed_point")
    general = in_general_kernel(*arguments, solver="fixed_point")
    assert not run.success and run.outcome == general.outcome


@pytest.mark.parametrize("V", [galvi.SpringChain(0.2), lambda q: 0.5 * q @ q])
def test_many_coordinates_are_left_to_the_general_kernel(V: Any) -> None:
    for mass, in_lanes in ((np.ones(65), False), (np.eye(13), False), (np.eye(3), True)):
        start = 0.1 * np.ones(len(mass)), np.zeros(len(mass))
        run = galvi.integrate(galvi.Problem(galvi.Canonical(mass, V), *start), EIGHT, 0.1, 1)
        assert run.success and run.engine == ("lanes" if in_lanes else "general")
    assert lane_law.fits(64, coupled=False) and lane_law.fits(12, coupled=True)


@pytest.mark.parametrize("step", [1e155, 1e200])
def test_a_step_whose_square_overflows_fails_without_a_warning(step: float) -> None:
    method = galvi.Galerkin(galvi.Polynomials(5), galvi.gauss(5))
    run = galvi.integrate(galvi.problems.kepler(0.3), method, step, 2)
    assert not run.success and run.failed_step == 1
