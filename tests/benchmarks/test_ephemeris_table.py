"""Point masses against DE421: how far apart, and that it is the model and not the integrator."""

from __future__ import annotations

import pandas as pd
import pytest

from benchmarks.studies import ephemeris
from references.jpl import states as jpl


@pytest.fixture(scope="module")
def table() -> pd.DataFrame:
    if jpl.missing():
        pytest.skip(jpl.missing())
    return ephemeris.ephemeris_table()


def test_every_body_has_a_row_for_every_time(table: pd.DataFrame) -> None:
    assert tuple(table.columns) == ephemeris.COLUMNS
    assert len(table) == 2 * 10 * len(ephemeris.DAYS)
    assert not table.duplicated(["contender", "body", "days"]).any()
    assert table[table["body"] != "Sun"].notna().all(axis=None)


def test_the_run_is_converged(table: pd.DataFrame) -> None:
    planets = table[table["body"] != "Sun"]
    assert table["integration_error_au"].max() < 2e-12  # 3e-13 when this was written
    floor = 2e-14  # some ulps of the outer planets' places
    assert (planets["integration_error_au"] < 1e-4 * planets["difference_au"] + floor).all()


def test_the_differences_are_of_the_size_that_relativity_explains(table: pd.DataFrame) -> None:
    inner = table[table["body"].isin(["Mercury", "Venus", "Earth", "Mars"])]
    assert inner["difference_au"].between(1e-7, 1e-4).all()
    ratio = inner["difference_au"] / inner["relativity_au"]
    assert ratio.between(0.85, 1.15).all()
    outer = table[table["body"].isin(["Saturn", "Uranus", "Neptune", "Pluto"])]
    assert (outer["difference_au"] < 1e-6).all()


def test_the_angle_is_the_one_that_the_distance_allows(table: pd.DataFrame) -> None:
    """From the Sun, whose own place differs too: Mercury is between 0.3 and 0.5 au away."""
    mercury = table[table["body"] == "Mercury"]
    seen = mercury["difference_arcsec"] * ephemeris.ARC_SECOND
    assert (seen <= mercury["difference_au"] / 0.3).all()


def test_without_the_ephemeris_it_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(jpl, "missing", lambda: "Install jplephem and de421.")
    with pytest.raises(ModuleNotFoundError, match="Install jplephem"):
        ephemeris.ephemeris_table()
