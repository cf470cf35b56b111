"""Derivatives by extrapolation: which steps, and what each extrapolation removes."""

from __future__ import annotations

import math

import pytest

from references.forces import force


def test_the_first_step_is_a_sixteenth_of_the_scale_and_each_further_one_half_of_it():
    asked = []
    force.derivative(lambda x: asked.append(x) or math.exp(x), 3.0)
    assert asked[::2] == [3.0 / 16.0 / 2.0**k for k in range(force.ROWS)]
    assert asked[1::2] == [-x for x in asked[::2]]


@pytest.mark.parametrize("power", [3, 5, 7])
def test_each_extrapolation_removes_a_power_of_the_step(monkeypatch, power):
    """Two rows on which a column is exact agree, and that column is taken."""
    monkeypatch.setattr(force, "ROWS", (power + 3) // 2)
    assert force.derivative(lambda x: x**power + x, 1.0) == pytest.approx(1.0, abs=1e-15)
