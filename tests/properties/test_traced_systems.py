"""Systems of a user's own functions: in vector instructions where these can be traced."""

from __future__ import annotations

import logging
import math
import pickle
from typing import Any

import numpy as np
import pytest
from numba import njit

import galvi
from tests.agreement.on_vector_spaces import LAGRANGIANS, M, morse
from tests.properties.lagrangians import opaque

EIGHT = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
COARSE = galvi.Galerkin(galvi.Polynomials(2), galvi.gauss(2))


@njit
def branching(q):
    return q if q[0] > -1e9 else 2.0 * q


def spring(gradient: Any) -> Any:
    return galvi.Canonical(1.0, lambda q: 0.5 * q @ q, gradient)


def lagrangian(function: Any) -> Any:
    return galvi.Lagrangian(function, galvi.Rn(2))


@pytest.mark.parametrize(
    ("system", "logs"),
    [
        (spring(opaque(lambda q: q)), 1),
        (spring(branching), 0),  # compiled
        (spring(lambda q: q), 0),  # traced
        (lagrangian(lambda q, v: 0.5 * v @ v - (q @ q if q[0] > 0.0 else 2.0 * q @ q)), 1),
        (lagrangian(lambda q, v: 0.5 * v @ np.linalg.solve(M, v) - 0.5 * q @ q), 1),
    ],
)
def test_an_untraced_function_of_python_is_called_and_this_is_said_once(
    system: Any, logs: int, caplog: pytest.LogCaptureFixture
) -> None:
    with caplog.at_level(logging.WARNING, logger="galvi"):
        for start in (0.3, 0.4):
            run = galvi.integrate(galvi.Problem(system, [start, 0.7], [0.5, -0.3]), COARSE, 0.05, 1)
            assert run.success
    assert sum("could be traced" in record.getMessage() for record in caplog.records) == logs


STRENGTH = {"k": 1.0}
OF_A_STRENGTH = {
    "potential": galvi.Canonical(1.0, lambda q: 0.5 * STRENGTH["k"] * q @ q),
    "gradient": galvi.Canonical(
        1.0, lambda q: 0.5 * STRENGTH["k"] * q @ q, lambda q: STRENGTH["k"] * q
    ),
    "Lagrangian": galvi.Lagrangian(
        lambda q, v: 0.5 * v @ v - 0.5 * STRENGTH["k"] * q @ q, galvi.Rn(1)
    ),
}


@pytest.mark.parametrize("solver", ["auto", "newton"])
@pytest.mark.parametrize("name", OF_A_STRENGTH)
def test_a_number_that_changed_counts_from_the_next_run_on(
    name: str, solver: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    problem = galvi.Problem(OF_A_STRENGTH[name], [0.5], [0.0])
    for strength in (1.0, 4.0):
        monkeypatch.setitem(STRENGTH, "k", strength)
        run = galvi.integrate(problem, EIGHT, 0.1, 20, solver=solver)
        assert run.success and run.engine == ("lanes" if solver == "auto" else "general")
        expected = 0.5 * np.cos(math.sqrt(strength) * run.t)
        np.testing.assert_allclose(run.q[:, 0], expected, rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("with_gradient", [True, False])
def test_what_a_function_raises_reaches_the_caller(with_gradient: bool) -> None:
    """A fall towards -1, where math.log is not defined."""

    def gradient(q: Any) -> Any:
        return np.array([1.0 + math.log(1.0 + q[0])]) + 1.0

    def potential(q: Any) -> Any:
        return (1.0 + q[0]) * math.log(1.0 + q[0]) + q[0]

    system = galvi.Canonical(1.0, potential, gradient if with_gradient else None)
    problem = galvi.Problem(system, [0.2], [-3.0])
    assert not system.untraced
    assert galvi.integrate(problem, EIGHT, 0.01, 20).success
    with pytest.raises(ValueError, match=r"domain error|positive input"):
        galvi.integrate(problem, EIGHT, 0.1, 40)


def test_a_wrong_gradient_ruins_the_energy_in_lanes_too() -> None:
    system = galvi.Canonical(
        1.0, lambda q: 0.5 * q @ q, lambda q: np.array([q[0] - q[1], q[0] + q[1]]), check=False
    )
    run = galvi.integrate(galvi.Problem(system, [0.5, 0.1], [0.0, 0.2]), EIGHT, 0.1, 200)
    assert run.engine == "lanes" and run.outcome.end is galvi.End.RUINED


@pytest.mark.parametrize("system", [galvi.Canonical(1.3, morse), LAGRANGIANS["mass matrix"][0]])
def test_a_traced_problem_can_be_pickled_and_its_saved_run_continues(
    system: Any, tmp_path: Any
) -> None:
    problem = galvi.Problem(system, [0.3, 0.2], [0.1, -0.2])
    uncut = galvi.integrate(problem, EIGHT, 0.1, 9)
    galvi.save(galvi.integrate(problem, EIGHT, 0.1, 4), tmp_path / "part")
    again = pickle.loads(pickle.dumps(problem))
    resumed = galvi.resume(galvi.load(tmp_path / "part", problem=again), 5)
    assert resumed.engine == "lanes"
    np.testing.assert_array_equal(resumed.q, uncut.q[4:])


@pytest.mark.parametrize(
    "system",
    [
        galvi.Canonical(1.0, lambda q: np.sqrt((q[0] ** 2) ** 3) / 3.0, None, check=False),
        galvi.Lagrangian(lambda q, v: 0.5 * v @ v - (q @ q) ** 0.75 * q[0] ** 2, galvi.Rn(1)),
    ],
)
def test_a_start_where_only_the_trace_has_no_derivatives_is_run_as_before(system: Any) -> None:
    galvi.Problem(system, [0.5], [0.1])
    assert not system.untraced
    at_rest = galvi.Problem(system, [0.0], [0.0])
    assert "not finite" in system.untraced
    run = galvi.integrate(at_rest, COARSE, 0.1, 2)
    assert run.success and not np.any(run.q)


def test_a_power_is_not_taken_for_one_by_an_expression_whose_index_is_the_exponent() -> None:
    def powers(q: Any, v: Any) -> Any:
        x, y = q
        return 0.5 * v @ v - 0.5 * q @ q - sum(x**p + x ** (y + p) for p in range(65, 90)) / 100

    system = lagrangian(powers)
    run = galvi.integrate(galvi.Problem(system, [0.9, 0.9], [0.1, 0.1]), COARSE, 0.05, 4)
    assert not system.untraced and run.engine == "lanes"
