"""Lagrangians of a user's own functions: in vector instructions where they can be traced."""

from __future__ import annotations

import logging
import math
import pickle
from typing import Any

import numpy as np
import pytest

import galvi
from galvi.run.in_lanes.lagrangian import has_law
from tests.agreement.called_functions import called
from tests.agreement.on_vector_spaces import LAGRANGIANS, M, with_mass_matrix

METHOD = galvi.Galerkin(galvi.Polynomials(6), galvi.gauss(6))


@pytest.mark.slow_cases("masses and springs")
@pytest.mark.parametrize("name", LAGRANGIANS)
def test_momenta_and_energies_are_those_of_the_functions(name: str) -> None:
    system, q0, v0 = LAGRANGIANS[name]
    problem = galvi.Problem(system, q0, v0)
    blind: Any = called(problem)
    np.testing.assert_allclose(problem.p0, blind.p0, rtol=0.0, atol=1e-10)
    args = np.array([q0]), np.array([v0]), np.zeros(1)
    np.testing.assert_allclose(system.energy(*args), blind.system.energy(*args), atol=1e-10)


def test_the_solver_fixed_point_is_refused_with_the_reason() -> None:
    problem = galvi.Problem(galvi.Lagrangian(branching, galvi.Rn(2)), [0.4, 0.7], [0.5, -0.3])
    with pytest.raises(ValueError, match=r"could be traced; .* branches on"):
        galvi.integrate(problem, METHOD, 0.05, 6, solver="fixed_point")


def branching(q: Any, v: Any) -> Any:
    return 0.5 * v @ v - (q @ q if q[0] > 0.0 else 2.0 * q @ q)


def solving(q: Any, v: Any) -> Any:
    return 0.5 * v @ np.linalg.solve(M, v) - 0.5 * q @ q


def converting(q: Any, v: Any) -> Any:
    return 0.5 * v @ v - 0.5 * float(q[0]) ** 2 - 0.5 * q[1] ** 2


COARSE = galvi.Galerkin(galvi.Polynomials(2), galvi.gauss(2))


@pytest.mark.parametrize("function", [branching, solving, converting])
def test_a_function_that_cannot_be_traced_is_called_and_this_is_said_once(
    function: Any, caplog: pytest.LogCaptureFixture
) -> None:
    system = galvi.Lagrangian(function, galvi.Rn(2))
    problem = galvi.Problem(system, [0.4, 0.7], [0.5, -0.3])
    assert not has_law(problem, METHOD) and system.untraced
    with caplog.at_level(logging.WARNING, logger="galvi"):
        for _ in range(2):
            run = galvi.integrate(problem, COARSE, 0.05, 1)
    assert run.status == "Completed." and run.counts["linear_solves"] > 0
    said = [record.getMessage() for record in caplog.records]
    assert sum("could be traced" in message for message in said) == 1


def test_a_number_that_changes_between_two_runs_is_used() -> None:
    numbers = {"k": 1.0}
    system = galvi.Lagrangian(lambda q, v: 0.5 * v @ v - 0.5 * numbers["k"] * q @ q, galvi.Rn(1))
    problem = galvi.Problem(system, [1.0], [0.0])
    for k in (1.0, 4.0):
        numbers["k"] = k
        run = galvi.integrate(problem, METHOD, 0.1, 10)
        assert abs(run.q[-1, 0] - math.cos(math.sqrt(k))) < 1e-9
        assert run.counts["linear_solves"] == 0 and run.status == "Completed."
        general = galvi.integrate(problem, METHOD, 0.1, 10, solver="newton")
        np.testing.assert_allclose(general.q, run.q, rtol=0.0, atol=1e-13)


def test_a_start_where_only_the_trace_has_no_derivatives_is_run_as_before() -> None:
    system = galvi.Lagrangian(lambda q, v: 0.5 * v @ v - (q @ q) ** 0.75 * q[0] ** 2, galvi.Rn(1))
    away = galvi.Problem(system, [0.5], [0.0])
    assert has_law(away, METHOD)
    at_rest = galvi.Problem(system, [0.0], [0.0])
    run = galvi.integrate(at_rest, COARSE, 0.1, 2)
    assert run.success and not np.any(run.q)


def test_a_traced_problem_can_be_pickled() -> None:
    problem = galvi.Problem(galvi.Lagrangian(with_mass_matrix, galvi.Rn(2)), [0.4, 0.7], [0.5, 0.1])
    again = pickle.loads(pickle.dumps(problem))
    assert has_law(again, METHOD)
    one, other = (galvi.integrate(each, METHOD, 0.05, 3) for each in (problem, again))
    assert np.array_equal(one.q, other.q)


def test_a_power_is_not_taken_for_one_by_an_expression_whose_index_is_the_exponent() -> None:
    def powers(q: Any, v: Any) -> Any:
        x, y = q
        return 0.5 * v @ v - 0.5 * q @ q - sum(x**p + x ** (y + p) for p in range(65, 90)) / 100

    system = galvi.Lagrangian(powers, galvi.Rn(2))
    run = galvi.integrate(galvi.Problem(system, [0.9, 0.9], [0.1, 0.1]), COARSE, 0.05, 4)
    assert not system.untraced and run.engine == "lanes"
