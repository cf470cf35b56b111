"""The long frame: its columns, its types, and what is picked from it."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd
import pytest

from benchmarks.store import frames


def table() -> pd.DataFrame:
    return frames.frame(
        frames.row(study="s", quantity="e", n=n, step=0.5**n, value=0.1**n) for n in (3, 1, 2)
    )


def test_a_frame_has_the_same_columns_and_types_with_rows_and_without() -> None:
    for frame in (table(), frames.frame([])):
        assert list(frame.columns) == list(frames.COLUMNS)
        assert [str(kind) for kind in frame.dtypes] == [kind for _, kind in frames.COLUMNS.values()]


def test_what_a_row_does_not_say_is_nan_or_empty() -> None:
    row = frames.row(study="s", value=1.0)
    assert math.isnan(row["x"]) and row["status"] == "" and row["value"] == 1.0
    with pytest.raises(KeyError, match="speed"):
        frames.row(speed=3.0)


def test_a_series_comes_in_the_order_of_refinement() -> None:
    n, errors = frames.series(table(), "n", study="s")
    assert n.tolist() == [1.0, 2.0, 3.0] and np.all(np.diff(errors) < 0.0)
    step, errors = frames.series(table(), "step", study="s")
    assert step.tolist() == [0.5, 0.25, 0.125] and np.all(np.diff(errors) < 0.0)


def test_one_number_is_one_number() -> None:
    assert frames.number(table(), n=2.0) == pytest.approx(0.01)
    assert math.isnan(frames.number(table(), n=7.0))
    assert math.isnan(frames.number(pd.DataFrame(), n=2.0))
    with pytest.raises(ValueError, match="3"):
        frames.number(table(), study="s")
