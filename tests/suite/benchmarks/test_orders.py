"""Orders from errors at decreasing steps: the fit, and what is left out of it."""

import csv
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.statistics.orders import BOUND, ROUND_OFF, STALLED, TOO_COARSE, orders
from benchmarks.studies.orders import as_text, cases
from benchmarks.studies.orders import rows as measured_rows

H = 0.5 ** np.arange(2, 10)


@given(
    order=st.integers(1, 16),
    constant=st.floats(1e-3, 1e3),
    size=st.floats(1e-6, 1e6),
    floor=st.floats(3e-16, 1e-12),
    seed=st.integers(0, 2**32 - 1),
)
def test_a_power_of_the_step_is_recovered_above_a_rough_floor(order, constant, size, floor, seed):
    noisy_floor = floor * np.random.default_rng(seed).uniform(0.5, 1.5, H.size)
    errors = constant * (H / H[0]) ** order + noisy_floor
    measured = orders(H, size * errors, size)
    uncertainty = measured.fit.uncertainty
    if measured.fit.points and uncertainty < 0.1:
        assert abs(measured.fit.rate - order) < max(0.02, 3.0 * uncertainty)
    clean = (constant * (H / H[0]) ** order > 100.0 * floor) & (errors < 0.1)
    assert measured.fit.points or np.sum(clean) < 4
    # An error of the floor that still falls by chance is used, and widens the interval.
    assert uncertainty > 0.05 or not np.any(measured.used & (errors < 2.0 * floor))


def test_each_error_that_is_left_out_says_why():
    errors = [3.0, 1e-2, 6.2e-4, 3.9e-5, 2.4e-6, 1.5e-7, 9.5e-9, 6e-10]
    measured = orders(H, errors, 1.0, truth_error=1e-10)
    assert measured.notes[0] == TOO_COARSE and not measured.used[0]
    assert measured.notes[-1] == BOUND
    assert measured.fit.rate == pytest.approx(4.0, abs=0.05)
    stalled = orders(H, [1e-2, 6.2e-4, 3.9e-5, 2.4e-6, 1.5e-7, 1.2e-11, 1.4e-11, 1.1e-11])
    assert stalled.notes[-3:] == (ROUND_OFF,) * 3
    assert stalled.fit.rate == pytest.approx(4.0, abs=0.02)


def test_errors_that_stop_falling_far_above_round_off_are_named():
    """As with a method that converges to another problem's solution, or a truth of few digits."""
    measured = orders(H, 1e-5 + 0.05 * (H / H[0]) ** 4)
    assert STALLED in measured.notes and ROUND_OFF not in measured.notes
    assert measured.fit.rate == pytest.approx(4.0, abs=0.2)
    flat = orders(H, np.full(H.size, 1e-3))
    assert set(flat.notes) == {STALLED} and not flat.fit.points


def test_a_failed_run_has_no_local_order_and_no_note():
    measured = orders(H[:5], [np.nan, 1e-2, 2.5e-3, 6.25e-4, 1.5625e-4])
    assert measured.notes[0] == "" and np.isnan(measured.local[:2]).all()
    assert measured.local[2:] == pytest.approx([2.0, 2.0, 2.0])


@pytest.mark.parametrize("errors", [[], [1e-3], [1e-3, 1e-4]])
def test_too_few_errors_have_no_order(errors):
    measured = orders(H[: len(errors)], errors)
    assert not measured.fit.points and not measured.used.any()
    assert measured.local.size == len(errors)


def rows_of_the_page():
    """Those of docs/which.md."""
    with (Path(__file__).parents[3] / "docs" / "orders.csv").open(encoding="utf-8") as file:
        return list(csv.DictReader(file))


def agrees(row):
    """Whether the measured order of a row is theory's, within 0.15 or twice its uncertainty."""
    measured, error = map(float, row["order measured"].split(" ± "))
    return abs(measured - float(row["order of theory"])) < max(0.15, 2.0 * error)


def test_the_table_has_the_columns_of_the_page():
    numbers = {"order": 4, "fitted": 4.0, "fitted_se": 0.01, "symmetry": 1e-15}
    names = {"on, in": "clock", "method": "a", "problem": "b"}
    row = names | numbers | {"symplecticity": 1e-11, "momentum": float("nan")}
    shown = as_text(pd.DataFrame([row]))
    assert list(shown) == list(rows_of_the_page()[0])
    assert shown["order measured"].item() == "4.000 ± 0.010" and shown["momentum"].item() == "-"


def test_the_table_of_the_page_has_every_class_and_the_orders_of_theory():
    rows = rows_of_the_page()
    expected = [(case.where, name) for case in cases() for name in case.methods]
    assert [(row["on, in"], row["method"]) for row in rows] == expected
    assert {row["on, in"] for row in rows} == {"vector space", "Lie group", "moving frame", "clock"}
    assert all(map(agrees, rows))
    assert not agrees({"order measured": "3.6 ± 0.05", "order of theory": "4"})


@pytest.mark.slow(beside="test_the_table_of_the_page_has_every_class_and_the_orders_of_theory")
def test_the_table_is_what_is_measured(suite_in_this_process):
    shown = {row["method"]: row["order measured"].split(" ± ")[0] for row in rows_of_the_page()}
    for row in measured_rows():
        assert row["fitted"] == pytest.approx(float(shown[row["method"]]), abs=0.05)
