"""Canonical systems of a user's own functions: in vector instructions where they can be traced."""

from __future__ import annotations

import logging
import math
import pickle
from typing import Any

import numpy as np
import pytest
from numba import njit

import galvi
from galvi.tracing.lane_law import WIDEST_FORCE, fits
from galvi.tracing.laws_of_systems import slopes_of
from tests.agreement.on_vector_spaces import morse
from tests.properties.lagrangians import opaque
from tests.properties.test_canonical_lanes import EIGHT, both

STRENGTH = {"k": 1.0}


@njit
def branching(q):
    return q if q[0] > -1e9 else 2.0 * q


@pytest.mark.parametrize(
    ("gradient", "logs"), [(opaque(lambda q: q), 1), (branching, 0), (lambda q: q, 0)]
)
def test_only_an_untraced_function_of_python_is_announced(
    gradient: Any, logs: int, caplog: pytest.LogCaptureFixture
) -> None:
    system = galvi.Canonical(1.0, lambda q: 0.5 * q @ q, gradient)
    with caplog.at_level(logging.WARNING, logger="galvi"):
        for start in (0.3, 0.4):
            galvi.integrate(galvi.Problem(system, [start], [0.0]), EIGHT, 0.1, 2)
    assert sum("could be traced" in record.getMessage() for record in caplog.records) == logs


def with_strength(q: Any) -> Any:
    return 0.5 * STRENGTH["k"] * q @ q


@pytest.mark.parametrize("gradient", [None, lambda q: STRENGTH["k"] * q])
def test_a_number_that_changed_counts_from_the_next_run_on(
    gradient: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    problem = galvi.Problem(galvi.Canonical(1.0, with_strength, gradient), [0.5], [0.0])
    for strength in (1.0, 4.0):
        monkeypatch.setitem(STRENGTH, "k", strength)
        run = galvi.integrate(problem, EIGHT, 0.1, 20)
        assert run.success, run.status
        expected = 0.5 * np.cos(math.sqrt(strength) * run.t)
        np.testing.assert_allclose(run.q[:, 0], expected, rtol=0.0, atol=1e-12)


def test_a_gradient_that_changes_a_global_is_called_as_before() -> None:
    calls = []

    def gradient(q: Any) -> Any:
        calls.append(0)
        return q * (1.0 + 0.0 * len(calls)) + 1e-3 * len(calls)

    system = galvi.Canonical(1.0, lambda q: 0.5 * q @ q, gradient, check=False)
    problem = galvi.Problem(system, [0.5], [0.0])
    assert "something else" in system.untraced
    before = len(calls)
    galvi.integrate(problem, EIGHT, 0.1, 2)
    assert len(calls) - before > 16


@pytest.mark.parametrize("known", [True, False])
def test_what_a_function_raises_reaches_the_caller(known: bool) -> None:
    """A fall towards -1, where math.log is not defined."""

    def gradient(q: Any) -> Any:
        return np.array([1.0 + math.log(1.0 + q[0])]) + 1.0

    def potential(q: Any) -> Any:
        return (1.0 + q[0]) * math.log(1.0 + q[0]) + q[0]

    system = galvi.Canonical(1.0, potential, gradient if known else None)
    problem = galvi.Problem(system, [0.2], [-3.0])
    assert not system.untraced
    assert galvi.integrate(problem, EIGHT, 0.01, 20).success
    with pytest.raises(ValueError, match=r"domain error|positive input"):
        galvi.integrate(problem, EIGHT, 0.1, 40)


def test_a_wrong_gradient_ruins_the_energy_in_lanes_too() -> None:
    system = galvi.Canonical(
        1.0, lambda q: 0.5 * q @ q, lambda q: np.array([q[0] - q[1], q[0] + q[1]]), check=False
    )
    lanes, general = both(galvi.Problem(system, [0.5, 0.1], [0.0, 0.2]), EIGHT, 0.1, 200)
    assert not lanes.success and lanes.status == general.status


def test_a_saved_run_continues_to_the_last_bit(tmp_path: Any) -> None:
    problem = galvi.Problem(galvi.Canonical(1.3, morse), [0.3, 0.2], [0.1, -0.2])
    whole = galvi.integrate(problem, EIGHT, 0.2, 30)
    galvi.save(galvi.integrate(problem, EIGHT, 0.2, 13), tmp_path / "part")
    rest = galvi.resume(galvi.load(tmp_path / "part", problem=problem), 17)
    np.testing.assert_array_equal(rest.q, whole.q[13:])
    copied = galvi.integrate(pickle.loads(pickle.dumps(problem)), EIGHT, 0.2, 30)
    np.testing.assert_array_equal(copied.q, whole.q)


def test_a_start_where_the_slopes_are_not_finite_is_left_to_differences() -> None:
    def hill(q: Any) -> Any:
        return (q[0] ** 2) ** 1.5 / 3.0 + 0.5 * q[1] ** 2

    system = galvi.Canonical(1.0, lambda q: np.sqrt(hill(q) ** 2), None, check=False)
    galvi.Problem(system, [0.5, 0.2], [0.0, 0.1])
    assert not system.untraced
    at_rest = galvi.Problem(system, [0.0, 0.0], [0.0, 0.0])
    assert "not finite" in system.untraced
    assert galvi.integrate(at_rest, EIGHT, 0.1, 3).success


def test_more_coordinates_than_are_written_out_are_not_traced() -> None:
    wide = WIDEST_FORCE + 1
    system = galvi.Canonical(1.0, lambda q: 0.5 * q @ q, lambda q: q)
    problem = galvi.Problem(system, np.ones(wide), np.zeros(wide))
    assert slopes_of(system) is None and not system.untraced
    assert galvi.integrate(problem, EIGHT, 0.1, 1).success


def test_fewer_coordinates_are_written_out_where_the_mass_couples_them() -> None:
    assert [fits(d, False) for d in (13, 64, 65)] == [True, True, False]
    assert [fits(d, True) for d in (12, 13, 64)] == [True, False, False]
