"""The matrix of forces: the truth is that of theory, and planted faults are seen."""

from __future__ import annotations

import pytest

import galvi
from benchmarks.experiments import forces_matrix as matrix


def test_galvi_is_right_and_a_wrong_sign_and_a_missing_kick_are_seen(monkeypatch):
    monkeypatch.setattr(matrix, "ORBITS", 20)
    monkeypatch.setattr(matrix, "TIMES", matrix.TIMES[: 20 * matrix.SAMPLES + 1])
    true = matrix.theory("J2")
    cells = [
        matrix.cell(lambda force=force: matrix.of_galvi(force), true)
        for force in (
            matrix.FORCES["J2"][1], galvi.Oblateness(0, -matrix.J2, matrix.RADIUS), (),
        )
    ]  # fmt: skip
    assert [one.partition(",")[0] for one in cells] == ["right", "wrong", "wrong"], cells


def test_reboundx_under_whfast_has_the_rates_of_theory(monkeypatch):
    pytest.importorskip("reboundx", reason="REBOUNDx is an extra")
    monkeypatch.setattr(matrix, "ORBITS", 20)
    monkeypatch.setattr(matrix, "TIMES", matrix.TIMES[: 20 * matrix.SAMPLES + 1])
    found = matrix.cell(
        lambda: matrix.of_the_force("gravitational_harmonics", "whfast"), matrix.theory("J2")
    )
    assert found.startswith("right"), found
