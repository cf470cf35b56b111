"""Stiff springs in long steps: errors of the frame and of textbook methods, energy exchange."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from benchmarks.studies.moving_frames import stiff_springs as study
from benchmarks.test_problems.stiff_springs import stiff_springs, stiffness
from references.scipy.ivp import DOP853
from references.textbook import trigonometric
from reports.figures.picture import picture
from reports.results.section import Figure
from reports.studies.stiff_springs import (
    energy_exchange,
    errors_and_resonances,
    long_run,
    stiff_spring_table,
)


@pytest.fixture(scope="module")
def frame() -> pd.DataFrame:
    return study.stiff_spring_study(quick=True)


def values(frame: pd.DataFrame, name: str, quantity: str, below: float) -> pd.Series:
    rows = frame[(frame["contender"] == name) & (frame["quantity"] == quantity)]
    return rows[(rows["study"] == study.RESONANCE) & (rows["x"] < below)]["value"]


def test_the_frame_is_accurate_in_long_steps_and_textbook_methods_are_of_order_two(
    frame: pd.DataFrame,
) -> None:
    assert tuple(frame.columns) == study.COLUMNS
    eight, four = (f"galvi harmonic frame, Gauss {s}" for s in (8, 4))
    assert values(frame, eight, study.ERROR, 4.0).max() < 1e-7  # 3e-10
    assert values(frame, eight, study.ERROR, 15.0).max() < 0.1
    assert values(frame, four, study.ERROR, 2.0).max() < 1e-5
    for name in ("mollified impulse", "exponential integrator"):
        assert 1e-3 < values(frame, name, study.ERROR, 4.0).max() < 0.1
    assert values(frame, eight, study.CHANGE, 15.0).max() < 0.1


def test_peers_are_cheaper_at_an_error_of_1e_2_and_the_frame_at_1e_4(frame: pd.DataFrame) -> None:
    steps = frame[(frame["study"] == study.RESONANCE) & (frame["quantity"] == study.ERROR)]
    ours = steps["contender"].str.startswith("galvi")

    def fewest(rows: pd.DataFrame, error: float) -> float:
        return float(rows[rows["value"] <= error]["evaluations"].min())

    assert fewest(steps[~ours], 1e-2) < 0.9 * fewest(steps[ours], 1e-2)  # 0.73, the whole study 0.4
    assert fewest(steps[ours], 1e-4) < 0.8 * fewest(steps[~ours], 1e-4)


def test_errors_below_ten_times_that_of_the_truth_are_marked(frame: pd.DataFrame) -> None:
    bounds = frame[frame["status"] == study.BOUND]
    assert not bounds.empty and set(bounds["quantity"]) == {study.ERROR}
    assert bounds["value"].max() < 1e-9  # ten times 1e-11
    rest = frame[(frame["study"] == study.RESONANCE) & (frame["quantity"] == study.ERROR)]
    assert rest.drop(bounds.index)["value"].min() > bounds["value"].max()


def test_energies_are_exchanged_and_their_sum_stays(frame: pd.DataFrame) -> None:
    rows = frame[frame["study"] == study.EXCHANGE]
    springs = rows[rows["quantity"].str.startswith("I_")]
    table = springs.pivot(index="x", columns="quantity", values="value")
    assert table["I_3"].max() > 0.9 and table["I_1"].min() < 0.05  # all of it is passed on
    assert np.ptp(table.sum(axis=1)) < 0.15
    assert rows[rows["quantity"] == study.ERROR]["value"].item() < 1e-6  # 4e-9, against DOP853
    late = frame[(frame["study"] == study.LONG) & (frame["quantity"] == study.TOTAL)]["value"]
    assert late.max() < 1e-8 and late.iloc[-1] < 5.0 * late.iloc[0]
    assert "no drift seen" in long_run(frame)
    size = frame["value"].where(frame["quantity"] != study.TREND, 1.0)  # the planted fault
    assert "it drifts" in long_run(frame.assign(value=size))


def test_an_impulse_that_is_not_mollified_is_seen_by_its_error() -> None:
    """The planted fault: near h omega = pi, its own resonance."""
    problem = stiff_springs(study.OMEGA)
    truth = DOP853.run(problem, study.SHORT, {"samples": 1, "tolerance": 1e-10}).q[-1]
    sound = trigonometric.mollified_impulse(stiffness(study.OMEGA))
    raw = replace(sound, phi=np.ones_like, kick=np.ones_like)
    errors = [
        study._steps(problem, "", one, 2.0 * np.pi, study.SHORT, truth, 0.0)[0]["value"]
        for one in (sound, raw)
    ]
    assert errors[1] > 3.0 * errors[0]


def test_the_table_and_the_figures_show_it(frame: pd.DataFrame) -> None:
    lines, classes = stiff_spring_table(frame)
    assert set(classes) <= set(lines) and len(lines) == 10
    for draw in (errors_and_resonances, energy_exchange):
        assert picture(Figure("name", "title", draw), frame).svg
