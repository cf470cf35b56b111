"""Close encounters, and eccentric orbits."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd
import pytest

from benchmarks.studies import high_eccentricity
from benchmarks.studies.high_eccentricity import (
    ECCENTRICITIES,
    high_eccentricity_table,
    through_pericentre,
)
from benchmarks.studies.survival import COLUMNS, survival_table
from references.closed_forms.kepler import KEPLER
from references.stored.encounters import burrau, heavy_planets


@pytest.fixture(scope="module")
def table() -> pd.DataFrame:
    return high_eccentricity_table(quick=True)


@pytest.mark.parametrize("eccentricity", ECCENTRICITIES)
def test_the_closed_form_returns_to_where_it_began(eccentricity: float) -> None:
    problem = through_pericentre(eccentricity)
    run = KEPLER.run(problem, math.tau, {"samples": 2})
    assert np.linalg.norm(run.q[-1] - problem.q0) < 1e-14
    assert run.q[1] == pytest.approx([1.0 - eccentricity, 0.0], abs=1e-7)
    assert np.linalg.norm(run.q[1]) == pytest.approx(1.0 - eccentricity, rel=1e-6)


def test_every_setting_has_an_error_or_says_why_not(table: pd.DataFrame) -> None:
    assert tuple(table.columns) == high_eccentricity.COLUMNS
    assert not table.duplicated(["eccentricity", "contender", "settings"]).any()
    silent = table["status"] == ""
    assert table.loc[silent, ["error", "energy_error"]].notna().all(axis=None)
    assert table.loc[silent, "error"].max() < 0.5  # what is off by more says so
    assert (table["error"].isna() == table["energy_error"].isna()).all()
    assert table.loc[~silent, "status"].str.len().min() > 20


def test_enough_steps_pass_where_they_can_be_had(table: pd.DataFrame) -> None:
    ours = table[table["contender"] == "galvi degree 16, Gauss 16"].set_index("eccentricity")
    assert ours.loc[[0.9], "error"].min() < 1e-13  # 6e-16 when this was written
    assert ours.loc[[0.99], "error"].min() < 1e-12  # 5e-14
    assert not (ours.loc[[0.999999], "error"] < 1.0).any(), "no such steps resolve it"


def test_a_run_that_misses_the_orbit_shows_in_its_energy(table: pd.DataFrame) -> None:
    missed = table[table["error"] > 1.0]
    assert len(missed) and (missed["energy_error"] > 0.1).all()


def test_steps_chosen_by_the_integrator_pass(table: pd.DataFrame) -> None:
    chosen = table[~table["contender"].str.startswith("galvi")]
    assert (chosen["error"] < 1e-6).all()  # 2e-8 when this was written


pytest.importorskip("rebound")


@pytest.fixture(scope="module")
def survivors() -> pd.DataFrame:
    return survival_table(quick=True)


@pytest.mark.slow(beside="test_steps_chosen_by_the_integrator_pass")
def test_adaptive_codes_keep_the_energy(survivors: pd.DataFrame) -> None:
    assert tuple(survivors.columns) == COLUMNS and set(survivors["problem"]) == {
        heavy_planets().name, burrau().name,
    }  # fmt: skip
    adaptive = survivors[survivors["contender"].isin(["REBOUND IAS15", "SciPy DOP853"])]
    assert len(adaptive) == 4 and adaptive["success"].all()
    assert (adaptive["energy_error"] < 1e-8).all()  # 2e-9, DOP853 on Burrau


@pytest.mark.slow(beside="test_steps_chosen_by_the_integrator_pass")
def test_steps_in_a_clock_keep_the_energy_as_adaptive_codes_do(survivors: pd.DataFrame) -> None:
    clock = survivors[survivors["contender"].str.startswith("galvi clock")]
    assert len(clock) == 4 and clock["success"].all()
    # After each step, the closest passages included: 2e-7 in steps of 0.6, 6e-10 in those of 0.3.
    assert (clock["energy_error"] < 1e-6).all()
    assert (clock.loc[clock["settings"] == "step 0.3", "energy_error"] < 1e-8).all()


@pytest.mark.slow(beside="test_a_run_that_misses_the_orbit_shows_in_its_energy")
def test_a_run_of_galvi_with_a_large_energy_error_says_so(survivors: pd.DataFrame) -> None:
    ours = survivors[survivors["contender"].str.startswith("galvi")]
    wrong = ours[~(ours["energy_error"] < 0.01)]
    assert len(wrong) and (wrong["status"] != "").all()
    told = survivors[survivors["contender"].str.startswith("REBOUND WHFast")]
    assert np.all(told["success"])  # WHFast does not say so


def test_burraus_bodies_are_at_rest_about_their_barycentre() -> None:
    problem = burrau()
    masses = problem.system.masses  # type: ignore[attr-defined]
    assert np.allclose(masses @ problem.q0, 0.0) and not np.any(problem.v0)
    sides = [np.linalg.norm(problem.q0[i] - problem.q0[j]) for i, j in ((1, 2), (0, 2), (0, 1))]
    assert np.allclose(sides, masses)
