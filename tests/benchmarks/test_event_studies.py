"""Transits: who sees them."""

from __future__ import annotations

import pytest

from benchmarks.studies import transits

pytest.importorskip("rebound")


def test_transits_are_all_found_to_a_second(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("heyoka")
    monkeypatch.setattr(transits, "QUICK_YEARS", 4.0)
    table = transits.transits_table(quick=True)
    assert tuple(table.columns) == transits.COLUMNS and (table["status"] == "").all()
    assert table["transits"].nunique() == 1 and table["transits"].iloc[0] >= 12
    assert (table["lost"] == 0).all() and (table["largest_s"] < 1.0).all()
