"""Encounters from a hundred starts, each with a truth of its own."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from benchmarks.studies import draws
from benchmarks.studies.draws import COLUMNS, draws_table
from references.stored.draws import BINARY, BURRAU, DRAWS
from references.stored.draws import draws as stored
from references.stored.encounters import burrau

pytest.importorskip("rebound")


@pytest.fixture(scope="module")
def table() -> pd.DataFrame:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(draws, "QUICK", 7)
        return draws_table(quick=True)


def test_starts_differ_by_roundings_and_ends_by_what_triples_make_of_them() -> None:
    known = stored(BURRAU)
    assert known.starts.shape == known.ends.shape == (DRAWS, 3, 2)
    apart = np.abs(known.starts - burrau().q0)
    assert 0.0 < apart.max() < 2e-14 and len(np.unique(known.ends[:, 0, 0])) == DRAWS
    spread = known.ends.std(axis=0).max()
    assert 1e-9 < spread < 1e-4


def test_a_clock_is_nearer_to_the_truth_than_adaptive_codes_at_their_defaults(
    table: pd.DataFrame,
) -> None:
    assert tuple(table.columns) == COLUMNS
    table = table[table["problem"] == draws.TITLES[BURRAU]]
    ours = table[table["contender"].str.startswith("galvi clock")].set_index("settings")
    assert (ours["status"] == "").all() and (ours["runs"] == 7).all()
    assert (ours["lower_quartile"] <= ours["median"]).all()
    ias15 = table[table["contender"] == "REBOUND IAS15"].iloc[0]
    assert ours.loc["step=0.4", "median"] < 0.1 * ias15["median"]


def test_an_error_is_that_from_the_truth_of_the_same_start(monkeypatch: pytest.MonkeyPatch) -> None:
    known = stored(BURRAU)
    moved = known.ends + 1e-3 * np.eye(3)[0][:, None]
    monkeypatch.setattr(draws, "TITLES", {BURRAU: "Burrau"})
    monkeypatch.setattr(draws, "draws", lambda name: known._replace(ends=moved))
    monkeypatch.setattr(draws, "QUICK", 7)
    monkeypatch.setattr(draws, "PARTICIPANTS", draws.PARTICIPANTS[3:4])
    assert draws_table(quick=True)["median"].iloc[0] == pytest.approx(1e-3, rel=0.01)


def test_binaries_are_met_at_any_phase_and_distance() -> None:
    known = stored(BINARY)
    assert known.starts.shape == known.velocities.shape == known.ends.shape == (DRAWS, 3, 3)
    apart = known.starts[:, 1] - known.starts[:, 0]
    assert np.allclose(np.linalg.norm(apart, axis=1), 1.0, rtol=1e-14)
    assert np.ptp(np.arctan2(apart[:, 1], apart[:, 0])) > 6.0
    assert np.allclose(known.velocities.sum(axis=1), 0.0, atol=1e-15)


def test_an_ensemble_has_the_errors_of_its_members_one_by_one(table: pd.DataFrame) -> None:
    rows = table[table["problem"] == draws.TITLES[BINARY]].set_index(["contender", "settings"])
    for step in ("step=0.6", "step=0.4"):
        one, all_at_once = (
            rows.loc[("galvi clock, Gauss 8", step)],
            rows.loc[(draws.ENSEMBLE, step)],
        )
        names = ["median", "lower_quartile", "upper_quartile", "largest", "runs", "status"]
        assert one[names].tolist() == all_at_once[names].tolist()
    ours = rows.loc[("galvi clock, Gauss 8", "step=0.4"), "median"]
    assert ours < 1e-9
