"""The stated brownout cloud: random numbers, emission, fall speeds, the pilot's ray, and costs."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import dblquad

import galvi
from benchmarks.applications.brownout import cost
from benchmarks.applications.brownout import emission as emissions
from benchmarks.applications.brownout.cloud import (
    CONSTANT_DRAG,
    DIAMETERS,
    END_TIME,
    PILOT_EYE,
    RAY_HALF_WIDTH,
    REYNOLDS_DRAG,
    SIGHT_TARGET,
    Cloud,
    optical_depth,
)
from benchmarks.applications.brownout.cost_at import cost_at, ratio_of
from benchmarks.applications.brownout.emission import (
    Emission,
    friction_speed,
    threshold,
    upward_flux,
)
from benchmarks.applications.brownout.flights import follow
from benchmarks.applications.brownout.philox import philox, uniforms
from benchmarks.statistics.estimate import Estimate

ONES = 0xFFFFFFFF


@pytest.mark.parametrize(
    ("counter", "key", "expected"),
    [
        ((0,) * 4, (0,) * 2, (0x6627E8D5, 0xE169C58D, 0xBC57AC4C, 0x9B00DBD8)),
        ((ONES,) * 4, (ONES,) * 2, (0x408F276D, 0x41C83B0E, 0xA20BC7C6, 0x6D5451FD)),
        (
            (0x243F6A88, 0x85A308D3, 0x13198A2E, 0x03707344),
            (0xA4093822, 0x299F31D0),
            (0xD16CFE09, 0x94FDCCEB, 0x5001E420, 0x24126EA1),
        ),
    ],
)
def test_the_random_numbers_are_those_of_their_authors(counter, key, expected) -> None:
    assert tuple(philox(counter, key)) == expected


@given(seed=st.integers(0, 2**32 - 1), order=st.permutations(range(20)))
@settings(max_examples=20, deadline=None)
def test_a_grains_random_numbers_follow_from_its_number(seed: int, order: list[int]) -> None:
    numbers = uniforms(np.arange(20), 3, seed)
    np.testing.assert_array_equal(uniforms(np.array(order), 3, seed), numbers[:, order])
    assert np.all((numbers > 0.0) & (numbers < 1.0))
    assert not np.any(np.isin(numbers, uniforms(np.arange(20), 4, seed)))


def test_thresholds_are_those_of_shao_and_lu() -> None:
    """Smallest near 75 micrometres; by hand for quartz in air."""
    thresholds = [threshold(d) for d in DIAMETERS]
    np.testing.assert_allclose(thresholds, [0.551, 0.271, 0.237, 0.259, 0.335], atol=6e-4)
    sizes = np.geomspace(1e-5, 1e-3, 400)
    size_of_minimum = math.sqrt(3e-4 / (2650.0 * 9.80665))
    assert abs(sizes[np.argmin([threshold(d) for d in sizes])] / size_of_minimum - 1.0) < 0.02


def test_the_flux_is_whites_and_begins_at_the_threshold() -> None:
    u, threshold_speed = 1.0, threshold(1e-4)
    stated = (
        1e-3 * 2.61 * 1.225 / 9.80665 * u**3 * (1 - threshold_speed) * (1 + threshold_speed) ** 2
    )
    assert upward_flux(u, 1e-4) == pytest.approx(stated, rel=1e-13)
    assert (
        upward_flux(0.999 * threshold_speed, 1e-4)
        == 0.0
        < upward_flux(1.001 * threshold_speed, 1e-4)
    )
    assert friction_speed(7.0, 4.0) == pytest.approx(0.4 * 25.4 / math.log(1000.0), rel=0.01)


def test_the_mass_lifted_is_an_adaptive_quadratures() -> None:
    emission = Emission(100e-6, END_TIME)
    exact = dblquad(lambda r, t: emission.density(r, t), 0.0, END_TIME, 0.5, 20.0, epsrel=1e-5)[0]
    assert emission.mass == pytest.approx(exact, rel=1e-4)  # 1e-5


def test_starts_are_distributed_as_the_mass() -> None:
    """Moments of radius and time within 5 standard errors; the angle and height uniform."""
    emission, n = Emission(100e-6, END_TIME), 20_000
    q, v, t = emission.starts(np.arange(n))
    r = np.hypot(q[:, 0], q[:, 1])
    grid = emissions._on_grid(emission)
    middles = (np.arange(len(grid)) + 0.5) / len(grid)
    for sample, values, axis in ((r, 0.5 + 19.5 * middles, 1), (t, END_TIME * middles, 0)):
        weights = grid.sum(axis=axis) / grid.sum()
        mean = float(weights @ values)
        spread = math.sqrt(float(weights @ (values - mean) ** 2))
        assert abs(sample.mean() - mean) < 5.0 * spread / math.sqrt(n)
    angles = np.arctan2(q[:, 1], q[:, 0]) / (2.0 * np.pi) % 1.0
    for uniform in (angles, q[:, 2]):
        assert abs(uniform.mean() - 0.5) < 5.0 / math.sqrt(12.0 * n)
    np.testing.assert_allclose(v[:, 2], friction_speed(r, t))
    assert np.all(v[:, 2] > threshold(100e-6))
    subset = emission.starts(np.array([5, 17_000, 3]))
    np.testing.assert_array_equal(subset[0], q[[5, 17_000, 3]])


def test_grains_that_no_wind_lifts_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(emissions, "MOST_ATTEMPTS", 3)
    with pytest.raises(RuntimeError, match="no place and time was drawn"):
        Emission(1e-2, END_TIME).starts(np.arange(4))


@pytest.mark.slow_cases("Schiller-Naumann-speeds1")
@pytest.mark.parametrize(
    ("drag", "speeds"), [(CONSTANT_DRAG, (0.80, 2.54, 5.07)), (REYNOLDS_DRAG, (0.0080, 0.58, 3.08))]
)
def test_fall_speeds_are_those_of_the_drag_laws(drag: str, speeds: tuple[float, ...]) -> None:
    """They solve weight = drag; a grain far from the rotor reaches them."""
    for diameter, stated in zip((10e-6, 100e-6, 400e-6), speeds, strict=True):
        law, rates = Cloud(diameter, drag).rates
        fall = follow(
            galvi.Galerkin(galvi.Polynomials(2), galvi.gauss(2)),
            [[1e6, 0.0, 50.0]],
            np.zeros((1, 3)),
            [0.0],
            rates[None],
            law,
            1 / 256,
            4.0,
            gravity=9.80665,
        ).v[0]
        assert fall[2] == pytest.approx(-stated, rel=0.012)
        assert rates[0] * law(-fall[2]) * -fall[2] == pytest.approx(9.80665, rel=1e-4)


def test_the_optical_depth_is_that_of_a_uniform_slab() -> None:
    """tau = n sigma L where the number density n is the same everywhere: r uniform in r^2."""
    random, n = np.random.default_rng(3), 400_000
    r, z = np.sqrt(random.uniform(0.0, 400.0, n)), random.uniform(-3.0, 8.0, n)
    q = np.stack([r, 0.0 * r, z], axis=1)
    length = math.hypot(SIGHT_TARGET[0] - PILOT_EYE[0], SIGHT_TARGET[1] - PILOT_EYE[1])
    mass = 2650.0 * math.pi * 1e-12 / 6.0
    tau = 2.0 * math.pi * 1e-8 / 4.0 * length / (math.pi * 400.0 * 11.0) / mass
    depths = optical_depth(q, 100e-6)
    assert abs(depths.mean() / tau - 1.0) < 5.0 * depths.std() / depths.mean() / math.sqrt(n) + 0.02
    assert 0.03 * length > RAY_HALF_WIDTH


@pytest.mark.slow(beside="test_the_long_form_keeps_what_is_done")
def test_the_cost_of_a_step_has_a_row_for_each_drag_and_size(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(cost, "QUICK_GRAINS", 40)
    monkeypatch.setattr(cost, "ROUNDS", 1)
    table = cost.cost_of_clouds(True)
    assert tuple(table.columns) == tuple(cost.COLUMNS)
    assert len(table[table["degree"] == 2]) == 2 * len(DIAMETERS)
    assert set(table["degree"]) == {1, 2, 4} and np.all(table["passes"] > 1.0)
    beside = table[table["single"].notna()]["micrometres"]
    assert set(np.rint(beside)) == {100.0, 400.0}


def test_the_long_form_keeps_what_is_done(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cost, "MILLION", 500)
    runs = cost.parts(tmp_path, print)
    assert len(runs) == len(DIAMETERS) and not any(run.is_complete() for run in runs)
    runs[2].run(lambda sentence: None)
    assert [run.is_complete() for run in runs] == [False, False, True, False, False]
    (row,) = cost.stored(tmp_path, print).to_dict("records")
    assert row["grains"] == 100 and row["micrometres"] == 100.0 and row["optical_depth"] >= 0.0
    assert row["commit"] and row["date"] and row["status"] == ""


# ---- costs at which an error is reached, between the steps at which it was measured

COSTS = 100.0 * 1.1 ** np.arange(12)
EXACT = np.zeros(12)


@given(st.floats(1.0, 6.0), st.floats(120.0, 250.0), st.sampled_from([-1.0, 1.0]))
def test_a_power_law_is_found_between_the_points(power: float, cost: float, sign: float) -> None:
    errors = sign * 1e-3 * (cost / COSTS) ** power
    assert cost_at(1e-3, COSTS, errors, EXACT).value == pytest.approx(cost, rel=0.01)


def test_an_error_that_changes_sign_is_below_only_after_its_last_excess() -> None:
    cost = cost_at(1.0, COSTS[:5], np.array([3.0, 0.5, -2.0, 0.0, 0.4]), EXACT[:5]).value
    assert cost == pytest.approx(COSTS[2] * 1.1**0.5)


def test_the_uncertainty_is_that_of_the_errors() -> None:
    errors, uncertainties = np.array([3.0, 1.2, 0.7]), np.array([0.1, 0.02, 0.03])
    cost = cost_at(1.0, COSTS[:3], errors, uncertainties)
    changes = [
        (cost_at(1.0, COSTS[:3], errors + d, uncertainties).value - cost.value)
        for d in 1e-4 * np.diag(uncertainties)
    ]
    assert cost.uncertainty == pytest.approx(1e4 * math.hypot(*changes), rel=1e-3)


@pytest.mark.parametrize(
    "errors",
    [[0.5, 0.4, 0.1], [3.0, 2.0, 1.1], [3.0, 2.0, math.nan], [3.0, 0.5, math.nan, 0.4], []],
)
def test_what_was_not_crossed_or_failed_below_has_no_cost(errors: list[float]) -> None:
    k = len(errors)
    assert math.isnan(cost_at(1.0, COSTS[:k], np.array(errors), EXACT[:k]).value)


def test_a_ratios_relative_errors_add_in_squares() -> None:
    ratio = ratio_of(Estimate(8.0, 0.8), Estimate(4.0, 0.3))
    assert ratio.value == 2.0
    assert ratio.uncertainty == pytest.approx(2.0 * math.hypot(0.1, 0.075))
