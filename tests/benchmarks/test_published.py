"""The problems published for IRKGL16-SIMD: starts, rows, a planted fault, the long form."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import galvi
from benchmarks.studies.moving_frames import published
from benchmarks.test_problems.planets import EPOCH, outer_planets_of_1969, regular_henon_heiles
from benchmarks.work_precision.galvi_methods import gauss_collocation
from references.jpl import states


def test_the_rows_stand_beside_what_is_printed() -> None:
    """Energies to rounding: a walk of an ulp in the square root of the steps is 1e-13 at most."""
    table = published.published(quick=True)
    assert tuple(table.columns) == tuple(published.COLUMNS)
    printed = table[table["contender"] == published.PRINTED]
    assert printed["energy_error"].tolist() == [3.6e-15, 5.6e-14]
    ours = table[table["contender"] != published.PRINTED]
    assert len(ours) == 5 and not any(ours["status"])
    walk = 2.0**-53 * np.sqrt(ours["steps"])
    assert np.all(ours["energy_error"] < walk)  # 1e-15 to 8e-15 of 5e-14
    assert ours["steps"].iloc[0] == 200_000 and ours["step"].iloc[0] == 50.0


def test_a_method_that_drifts_does_not_reach_what_is_printed() -> None:
    """The planted fault: two passes in the Kepler frame, which are not symplectic."""
    two = gauss_collocation(8, galvi.KeplerFrame(passes=2))
    seen = published._measured(published.CASES[0], "two passes", two, 400.0, 1)
    assert seen["energy_error"] > 100 * published.CASES[0].energy_error


def test_starts_are_as_published() -> None:
    start = regular_henon_heiles()
    energy = start.system.potential_energy(start.q0, 0.0) + 0.5 * start.v0 @ start.v0
    assert abs(energy - 1.0 / 12.0) < 1e-16
    if states.missing():
        pytest.skip(states.missing())
    sky, problem = states.ephemeris(EPOCH), outer_planets_of_1969()
    for k, name in enumerate(problem.parameters["bodies"][1:], start=1):
        own = np.concatenate([[problem.system.masses[k]], problem.q0[k], problem.v0[k]])
        assert np.array_equal(own, sky[name])
    inner = np.array(list(sky.values())[:5])
    for exact, ours in ((inner[:, 1:4], problem.q0), (inner[:, 4:], problem.v0)):
        centre = inner[:, 0] @ exact / np.sum(inner[:, 0])
        assert np.allclose(ours[0], centre, rtol=1e-15, atol=1e-20)


def test_the_long_form_keeps_its_rows(tmp_path: Path) -> None:
    cases = [replace(case, steps=1000, ours=case.ours[:1]) for case in published.CASES]
    parts = published.parts(tmp_path, print, cases, code="0123456789ab")
    assert [part.done() for part in parts] == [False, False]
    parts[0].run(print)
    assert [part.done() for part in parts] == [True, False]
    rows = published.stored(tmp_path, print)
    assert rows["commit"].tolist() == ["0123456789ab"] and rows["steps"].tolist() == [1000.0]
