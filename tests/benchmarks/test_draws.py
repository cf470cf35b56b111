"""Burrau's problem a hundred times, each start with a truth of its own."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from benchmarks.studies import draws
from benchmarks.studies.draws import COLUMNS, draws_table
from references.stored.draws import DRAWS, burrau_draws
from references.stored.encounters import burrau

pytest.importorskip("rebound")


@pytest.fixture(scope="module")
def table() -> pd.DataFrame:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(draws, "QUICK", 7)
        return draws_table(quick=True)


def test_starts_differ_by_roundings_and_ends_by_what_triples_make_of_them() -> None:
    known = burrau_draws()
    assert known.starts.shape == known.ends.shape == (DRAWS, 3, 2)
    apart = np.abs(known.starts - burrau().q0)
    assert 0.0 < apart.max() < 2e-14 and len(np.unique(known.ends[:, 0, 0])) == DRAWS
    spread = known.ends.std(axis=0).max()
    assert 1e-9 < spread < 1e-4


def test_a_clock_is_nearer_to_the_truth_than_adaptive_codes_at_their_defaults(
    table: pd.DataFrame,
) -> None:
    assert tuple(table.columns) == COLUMNS
    ours = table[table["contender"].str.startswith("galvi clock")].set_index("settings")
    assert (ours["status"] == "").all() and (ours["runs"] == 7).all()
    assert (ours["lower_quartile"] <= ours["median"]).all()
    ias15 = table[table["contender"] == "REBOUND IAS15"].iloc[0]
    assert ours.loc["step=0.4", "median"] < 0.1 * ias15["median"]


def test_an_error_is_that_from_the_truth_of_the_same_start(monkeypatch: pytest.MonkeyPatch) -> None:
    known = burrau_draws()
    moved = known.ends + 1e-3 * np.eye(3)[0][:, None]
    monkeypatch.setattr(draws, "burrau_draws", lambda: known._replace(ends=moved))
    monkeypatch.setattr(draws, "QUICK", 7)
    monkeypatch.setattr(draws, "PARTICIPANTS", draws.PARTICIPANTS[3:4])
    assert draws_table(quick=True)["median"].iloc[0] == pytest.approx(1e-3, rel=0.01)
