"""Which of several stored versions a report shows, whatever their hashes sort like."""

from __future__ import annotations

import pandas as pd
import pytest

from benchmarks.store.row_files import of_one_version
from reports.studies import costs, faults

# Sorted by the name of their files, as they are read.
DATES = {"0a": "2026-02-03", "5b": "2026-03-01", "fc": "2026-01-02"}
FRAME = pd.DataFrame({"commit": [*DATES, *DATES], "date": [*DATES.values()] * 2})


@pytest.mark.parametrize(("current", "shown"), [("0a", "0a"), ("fc", "fc"), ("77+1", "5b")])
def test_the_current_version_is_shown_or_else_the_newest_by_date(current, shown):
    rows = of_one_version(FRAME, current)
    assert len(rows) == 2 and set(rows["commit"]) == {shown}


def test_of_no_rows_there_are_none():
    assert of_one_version(FRAME[:0], "0a").empty


@pytest.mark.parametrize("current", ["0a", "unknown"])
def test_the_tables_show_that_version(monkeypatch, current):
    for section in (faults, costs):
        monkeypatch.setattr(section, "version", lambda: current)
    shown = current if current in DATES else "5b"
    calls = FRAME[:3].assign(target="gauss", calls=[1, 2, 3], returned=0, refused=0, finding="")
    table, _ = faults.fuzz_table(calls)
    assert table["calls"].iloc[-1] == str([1, 2, 3][[*DATES].index(shown)])
    runs = FRAME[:3].assign(case="a", processor="generic", units=[1.0, 2.0, 3.0], status="")
    table, _ = costs.processors_table(runs)
    assert table.loc[0, "generic"].startswith("123"[[*DATES].index(shown)])
