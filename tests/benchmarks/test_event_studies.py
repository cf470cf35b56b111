"""Flybys and transits: what is known of them, and who sees them."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from benchmarks.studies import flybys as study
from benchmarks.studies import transits
from references.rebound.passages import nearest_on_cubics, nearest_sample
from references.stored.flybys import BODIES, KM, KM_S, flybys, hill_radius, surroundings

pytest.importorskip("rebound")


@pytest.fixture(scope="module")
def seen() -> pd.DataFrame:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(study, "QUICK", 16)
        return study.flybys_table(quick=True)


def test_the_stored_distances_are_the_pericentres_that_the_starts_were_made_for() -> None:
    known = flybys()
    assert len(known.t) == 1196 and set(known.targets) == {1, 2, 3, 4}
    assert (known.speeds.min(), known.speeds.max()) == (5.0, 70.0) and known.impacts.max() < 3.5
    masses = surroundings().system.masses  # type: ignore[attr-defined]
    size = masses[known.targets] / (known.speeds * KM_S) ** 2
    hill = np.array([hill_radius(k) for k in range(1, len(BODIES) - 1)])
    nearest = np.hypot(size, known.impacts * hill[known.targets - 1]) - size
    off = known.distance / nearest - 1.0  # impact parameters are stored to six digits
    again = off < -0.1  # passed a second time, nearer
    assert again.sum() == 1 and np.abs(off[~again]).max() < 5e-6


@pytest.mark.slow(beside="test_an_error_is_that_from_the_truth_of_the_same_flyby")
def test_events_miss_no_flyby_and_states_at_outputs_do(seen: pd.DataFrame) -> None:
    assert tuple(seen.columns) == study.COLUMNS
    rows = seen.groupby(["contender", "looks"], sort=False)[["missed", "largest_km"]]
    missed, wrong = rows.sum()["missed"], rows.max()["largest_km"]
    clock = ("galvi clock, Gauss 8", "events, step=0.2")
    assert missed[clock] == 0 and wrong[clock] < 1.0
    assert missed[study.IAS15, "outputs every 73 d"] > 4
    cubics = wrong[study.IAS15, "cubics between steps"]
    assert cubics < 0.01 * wrong[study.IAS15, "ends of steps"]


def test_an_error_is_that_from_the_truth_of_the_same_flyby(monkeypatch: pytest.MonkeyPatch) -> None:
    known = flybys()
    monkeypatch.setattr(study, "flybys", lambda: known._replace(distance=known.distance + 7.0 * KM))
    monkeypatch.setattr(study, "QUICK", 4)
    monkeypatch.setattr(study, "PARTICIPANTS", study.PARTICIPANTS[-1:])
    assert study.flybys_table(quick=True)["median_km"].to_numpy() == pytest.approx(7.0, rel=0.1)


def test_cubics_see_between_two_states_what_states_do_not() -> None:
    """A straight line at a distance of 2, passed between states at -1 and 3."""
    t = np.array([0.0, 4.0])
    q, v = np.array([[-1.0, 2.0, 0.0], [3.0, 2.0, 0.0]]), np.array([[1.0, 0.0, 0.0]] * 2)
    assert nearest_sample(t, q, v) == (0.0, pytest.approx(5.0**0.5))
    assert nearest_on_cubics(t, q, v) == (pytest.approx(1.0), pytest.approx(2.0))


def test_transits_are_all_found_to_a_second(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("heyoka")
    monkeypatch.setattr(transits, "QUICK_YEARS", 4.0)
    table = transits.transits_table(quick=True)
    assert tuple(table.columns) == transits.COLUMNS and (table["status"] == "").all()
    assert table["transits"].nunique() == 1 and table["transits"].iloc[0] >= 12
    assert (table["lost"] == 0).all() and (table["largest_s"] < 1.0).all()
