"""Vectors of four lanes and of eight: the same motion, whatever the processor's registers hold."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import galvi
from galvi.lanes import functions, vectors
from galvi.run.in_lanes import lagrangian as law_stepper
from galvi.run.in_lanes import tables as method_tables
from tests.properties.lane_functions import compiled

STEP = 0.02


def moved(problem: galvi.Problem, method: galvi.Galerkin, monkeypatch: Any, wide: bool) -> Any:
    """A run as on a processor whose registers have eight lanes, or four."""
    monkeypatch.setattr(vectors, "AVX512", wide)
    return galvi.integrate(problem, method, STEP, 20)


def difference(one: Any, other: Any) -> float:
    """The largest difference of places and momenta, relative to 1 and their size."""
    pairs = ((one.q, other.q), (one.p, other.p))
    return max(float(np.abs(a - b).max() / (1.0 + np.abs(b).max())) for a, b in pairs)


@pytest.mark.parametrize("stages", [1, 4, 8, 9, 12, 13])
def test_only_stages_that_would_leave_a_register_idle_run_in_fours(stages, monkeypatch):
    monkeypatch.setattr(vectors, "AVX512", False)
    lanes = vectors.lanes_for(stages)
    assert lanes == (4 if stages in (1, 4, 9, 12) else 8)
    assert len(method_tables.stages_in_lanes(stages, lanes)) == -(-stages // lanes) * lanes
    monkeypatch.setattr(vectors, "AVX512", True)
    assert vectors.lanes_for(stages) == 8


def test_a_slip_of_one_lane_in_the_tables_for_fours_is_seen(monkeypatch):
    sound, problem = law_stepper.tables_on_space, galvi.problems.double_pendulum()
    method = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4))

    def slipped(table: Any, degrees: Any, form: Any) -> Any:
        made = sound(table, degrees, form)
        if form.lanes != 4:
            return made
        return made._replace(tables=np.roll(made.tables, 1, axis=1))

    monkeypatch.setattr(law_stepper, "tables_on_space", slipped)
    four, eight = (moved(problem, method, monkeypatch, wide) for wide in (False, True))
    assert four.counts["steps"] < 20 or difference(four, eight) > 1e-9


@pytest.mark.parametrize(
    "function", ["sine_cosine", "exponential", "logarithm", "inverse_fourth_root", "square_root"]
)
def test_functions_are_the_same_to_the_bit(function):
    x = np.exp(np.random.default_rng(3).uniform(-5.0, 5.0, 400))
    asked = getattr(functions, function)
    returned = 2 if function == "sine_cosine" else 1
    four, eight = (compiled(asked, 1, returned, lanes)(x) for lanes in (4, 8))
    np.testing.assert_array_equal(four, eight)
