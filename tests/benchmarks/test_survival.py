"""Close encounters: who keeps the energy, and which run says that it did not."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from benchmarks.studies.survival import COLUMNS, survival_table
from references.stored.encounters import burrau, heavy_planets

pytest.importorskip("rebound")


@pytest.fixture(scope="module")
def table() -> pd.DataFrame:
    return survival_table(quick=True)


def test_adaptive_codes_keep_the_energy(table: pd.DataFrame) -> None:
    assert tuple(table.columns) == COLUMNS and set(table["problem"]) == {
        heavy_planets().name, burrau().name,
    }  # fmt: skip
    adaptive = table[table["contender"].isin(["REBOUND IAS15", "SciPy DOP853"])]
    assert len(adaptive) == 4 and adaptive["success"].all()
    assert (adaptive["energy_error"] < 1e-8).all()  # 2e-9, DOP853 on Burrau


def test_steps_in_a_clock_keep_the_energy_as_adaptive_codes_do(table: pd.DataFrame) -> None:
    clock = table[table["contender"].str.startswith("galvi clock")]
    assert len(clock) == 4 and clock["success"].all() and (clock["energy_error"] < 1e-8).all()


def test_a_run_of_galvi_with_a_large_energy_error_says_so(table: pd.DataFrame) -> None:
    ours = table[table["contender"].str.startswith("galvi")]
    wrong = ours[~(ours["energy_error"] < 0.01)]
    assert len(wrong) and (wrong["status"] != "").all()
    told = table[table["contender"].str.startswith("REBOUND WHFast")]
    assert np.all(told["success"])  # WHFast does not say so


def test_burraus_bodies_are_at_rest_about_their_barycentre() -> None:
    problem = burrau()
    masses = problem.system.masses  # type: ignore[attr-defined]
    assert np.allclose(masses @ problem.q0, 0.0) and not np.any(problem.v0)
    sides = [np.linalg.norm(problem.q0[i] - problem.q0[j]) for i, j in ((1, 2), (0, 2), (0, 1))]
    assert np.allclose(sides, masses)
