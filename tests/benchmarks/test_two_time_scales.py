"""Waves against polynomials on two time scales: where they win, and where they do not."""

import numpy as np
import pytest

from benchmarks.experiments import two_time_scales as scales


def errors(table):
    return dict(zip(table["label"], table["error"], strict=True))


@pytest.fixture(scope="module")
def pair():
    """The stiff pair with a step of one turn; the truth is DOP853's."""
    problem, period = scales.stiff_pair(), 2.0 * np.pi / scales.OMEGA
    truth = scales.DOP853.run(problem, 50.0 * period, {"samples": 1, **scales.TIGHT}).q[-1]
    return scales.study(problem, period, 50.0 * period, (1.0,), truth)


def test_for_each_unknown_waves_win_on_two_time_scales(pair):
    error = errors(pair)
    assert error[scales.WAVES] < 1e-3 * error[scales.AS_MANY_UNKNOWNS]  # 5.5e-6
    assert pair["unknowns"].tolist()[:2] == [6, 6]


def test_for_each_force_evaluation_gauss_collocation_wins(pair):
    error, cost = errors(pair), dict(zip(pair["label"], pair["evaluations"], strict=True))
    assert error[scales.AS_MANY_POINTS] < error[scales.WAVES]
    assert cost[scales.AS_MANY_POINTS] < cost[scales.WAVES]


def test_on_an_orbit_nothing_is_won():
    error = errors(scales.orbit_study().query("turns == 0.25"))
    assert 0.5 < error[scales.WAVES] / error[scales.AS_MANY_UNKNOWNS] < 2.0  # 0.91
