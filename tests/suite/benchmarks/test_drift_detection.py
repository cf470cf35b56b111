"""A drift of 5 % is seen, as a trend and as an envelope, and a stationary run does not drift."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterator
from fractions import Fraction
from itertools import product

import numpy as np
import pandas as pd
import pytest

import galvi
from benchmarks.checks.bounds import ATTAINED, CONTRADICTED, HOLDS, NOT_RUN
from benchmarks.checks.claim import Claim
from benchmarks.checks.series_bounds import NoGrowth
from benchmarks.claims.vector_spaces import v02_oscillator_energy as v02
from benchmarks.claims.vector_spaces import v15_noether_quantities as v15
from benchmarks.statistics.drift import LEAST, drift
from galvi.arrays import Array
from references.closed_forms.oscillator import oscillator_step
from tests.suite.benchmarks.planted_tables import CLAIM
from tests.suite.benchmarks.quick_studies import quick

PLANTED = 0.05
Change = Callable[[Array], Array]


def rising(errors: Array) -> Array:
    return errors + PLANTED * np.max(np.abs(errors)) * np.linspace(0.0, 1.0, errors.size)


def falling(errors: Array) -> Array:
    return errors - PLANTED * np.max(np.abs(errors)) * np.linspace(0.0, 1.0, errors.size)


def widening(errors: Array) -> Array:
    return errors * (1.0 + PLANTED * np.linspace(0.0, 1.0, errors.size))


PLANTS: tuple[Change, ...] = (rising, falling, widening)


def verdict(errors: Array, limit: float = math.inf) -> str:
    return NoGrowth(limit).verdict(drift(np.arange(errors.size), errors))


# Stationary histories: functions of two or three phases, with incommensurate periods of 2 to 40
# samples, without or with a little white or coloured noise. The frequencies are Diophantine: a
# combination j of them, aliasing included, beats more than BEATS / |j| times a run. A beat slower
# than the run would be a trend to anyone.

RUNS, SAMPLES, BEATS = 400, 8000, 120.0
ORDERS = {2: 24, 3: 9}
COMBINATIONS = {
    count: np.array(
        [j for j in product(range(-most, most + 1), repeat=count) if 0 < sum(map(abs, j)) <= most]
    )
    for count, most in ORDERS.items()
}
SHAPES: tuple[Callable[[Array, Array], Array], ...] = (
    lambda a, phase: a @ np.cos(phase),
    lambda a, phase: (a @ np.cos(phase)) ** 2,
    lambda a, phase: a @ (1.0 + 0.6 * np.cos(phase)) ** -2,
    lambda a, phase: np.prod(1.0 + a[:, None] * np.cos(phase), axis=0),
)


def frequencies(rng: np.random.Generator) -> Array:
    """Per sample, incommensurate."""
    while True:
        count = int(rng.integers(2, 4))
        found: Array = np.exp(-rng.uniform(np.log(2.05), np.log(40.0), count))
        beats = COMBINATIONS[count] @ found
        size = np.sum(np.abs(COMBINATIONS[count]), axis=1)
        if np.min(np.abs(beats - np.round(beats)) * size) * SAMPLES > BEATS:
            return found


def filtered(memory: float, scale: float, noise: Array) -> Array:
    from scipy.signal import lfilter  # 0.4 s, in each process that collects the tests

    return lfilter([scale], [1.0, -memory], noise)


def stationary(seed: int) -> Iterator[Array]:
    rng = np.random.default_rng(seed)
    for run in range(RUNS):
        per_sample = frequencies(rng)
        sizes = np.exp(rng.uniform(np.log(0.05), 0.0, per_sample.size))
        places = np.arange(SAMPLES) + rng.uniform(0.0, SAMPLES, (per_sample.size, 1))
        errors = SHAPES[run % len(SHAPES)](sizes, math.tau * per_sample[:, None] * places)
        errors = errors - errors[0]
        memory = rng.choice([0.0, 0.9])
        noise = filtered(memory, math.sqrt(1.0 - memory**2), rng.standard_normal(SAMPLES))
        yield errors / np.max(np.abs(errors)) + rng.choice([0.0, 3e-3, 0.01]) * noise


@pytest.mark.slow(beside="test_a_drift_of_5_percent_planted_in_a_claim_s_history_is_caught")
def test_a_planted_drift_is_seen_and_hundreds_of_stationary_runs_give_no_alarm() -> None:
    found = {change: Counter[str]() for change in ("none", *PLANTS)}
    for errors in stationary(1):
        found["none"][verdict(errors)] += 1
        for change in PLANTS:
            found[change][verdict(change(errors))] += 1
    assert found["none"][CONTRADICTED] <= 1  # 0 of 5000 with other seeds, too
    for change in PLANTS:
        assert found[change][HOLDS] == 0, change
        assert found[change][CONTRADICTED] >= 0.99 * RUNS, change  # 997 of 1000, the others NOT_RUN


@pytest.mark.slow_cases("0.0")
@pytest.mark.parametrize("memory", [0.0, 0.9])
def test_noise_alone_is_no_drift_of_short_runs_either(memory: float) -> None:
    rng = np.random.default_rng(2)
    noise = filtered(memory, 1.0, rng.standard_normal((RUNS, 2000)))[:, 200:]
    assert sum(verdict(errors) == CONTRADICTED for errors in noise) <= 1


# The measured histories of the claims.


@pytest.mark.slow_cases(but=["V8-falling", "V8-widening", "L4-rising", "L4-falling", "L4-widening"])
@pytest.mark.parametrize("change", PLANTS)
@pytest.mark.parametrize(
    ("claim", "history", "quantity"),
    [
        (CLAIM["V2"], v02.QUANTITY, "energy error, n = 14"),
        (CLAIM["V8"], "energy error", "energy error, n = 8"),
        (
            CLAIM["V15"],
            v15.ALONG,
            f"error of {v15.ALONG}, over the largest of single steps from exact states",
        ),
        (CLAIM["L4"], "energy error, n = 8", "energy error, n = 8"),
        (CLAIM["L8"], "energy error", "energy error, n = 8"),
    ],
    ids=["V2", "V8", "V15", "L4", "L8"],
)
def test_a_drift_of_5_percent_planted_in_a_claim_s_history_is_caught(
    claim: Claim,
    history: str,
    quantity: str,
    change: Change,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def judged(table: pd.DataFrame) -> str:
        (row,) = (row for row in claim.judge(table) if row.quantity == quantity)
        return row.verdict

    table = quick(claim)
    assert judged(table) == HOLDS
    rows = (table["study"] == "history") & (table["quantity"] == history)
    planted = table.copy()
    planted.loc[rows, "value"] = change(table.loc[rows, "value"].to_numpy())
    assert judged(planted) == CONTRADICTED
    # Not because the largest error leaves its bound, which 5 % may do: within it, too.
    shrunk = planted.copy()
    shrunk.loc[rows, "value"] *= 0.5
    assert judged(shrunk) == CONTRADICTED


# Single histories.


def test_an_error_that_swings_does_not_grow_and_a_slow_drift_is_one() -> None:
    t = np.arange(4000.0)
    swings = 1e-3 * np.sin(0.37 * t)
    assert verdict(swings, 1e-2) == HOLDS and verdict(swings, 1e-4) == CONTRADICTED
    for slope in (2e-8, -2e-8):  # 8 % of the swings over the run
        assert verdict(slope * t + swings, 1.0) == CONTRADICTED
    assert verdict(1e-3 * (1.0 + 3e-5 * t), 1.0) == CONTRADICTED  # without any swing
    assert verdict(swings * (1.0 - 3e-5 * t), 1.0) == HOLDS  # what decays does not grow


def test_a_run_too_short_to_tell_is_not_called_good_and_a_plain_drift_is_still_seen() -> None:
    t = np.arange(200.0)
    swings = np.sin(0.09 * t)
    seen = drift(t, swings)
    assert NoGrowth(2.0).verdict(seen) == NOT_RUN and NoGrowth(0.5).verdict(seen) == CONTRADICTED
    assert NoGrowth(2.0, conclusive=False).verdict(seen) == HOLDS
    assert NoGrowth(9.0).verdict(drift(t, t / 20.0 + swings)) == CONTRADICTED


def test_the_standard_errors_of_noise_are_the_scatter_of_its_changes() -> None:
    noise = np.random.default_rng(4).standard_normal((400, 2000))
    seen = [drift(np.arange(2000.0), errors) for errors in noise]
    for name in ("trend", "growth"):
        scatter = np.std([getattr(one, name) for one in seen])
        told = np.mean([getattr(one, f"{name}_error") for one in seen])
        assert told == pytest.approx(scatter, rel=0.15)  # 0.02 and 0.03 were measured


def test_growth_of_rounding_errors_is_allowed_up_to_the_stated_level() -> None:
    t = np.arange(400.0)
    seen = drift(t, 1e-16 * t)
    assert NoGrowth(1.0, round_off=1e-13).verdict(seen) == HOLDS
    assert NoGrowth(1.0, round_off=1e-15).verdict(seen) == CONTRADICTED


def test_a_history_with_a_hole_or_too_short_is_not_judged_and_no_error_does_not_grow() -> None:
    t, error = np.arange(400.0), np.ones(400)
    assert NoGrowth(10.0).verdict(drift(t[: LEAST - 1], error[: LEAST - 1])) == NOT_RUN
    error[17] = math.nan
    assert NoGrowth(10.0).verdict(drift(t, error)) == NOT_RUN
    assert NoGrowth(0.0).verdict(drift(t, np.zeros(400))) == HOLDS
    with pytest.raises(ValueError, match="evenly spaced"):
        drift(t**2, np.ones(400))


# The oscillator's conserved form.


def test_the_form_that_bounds_the_oscillator_without_drift_is_that_of_galvi_s_step() -> None:
    problem = galvi.problems.harmonic_oscillator()
    for degree, h in ((1, Fraction(1, 2)), (2, Fraction(1)), (5, Fraction(3)), (13, Fraction(20))):
        form = oscillator_step(degree, h)
        method = galvi.Galerkin(galvi.Polynomials(degree), galvi.gauss(degree + 1))
        run = galvi.integrate(problem, method, float(h), 200)
        errors = np.ravel(run.q**2 + run.p**2 - 1.0)
        assert form.stable
        assert np.max(np.abs(errors - form.energy_errors(200))) < 1e-11  # 4e-13
        assert np.max(np.abs(errors)) <= form.largest_energy_error + 1e-11


def test_the_form_of_degree_one_is_known_and_without_one_there_is_no_bound() -> None:
    h = Fraction(1, 2)  # L_d = (q1 - q0)^2 / 2h - h (q0^2 + q0 q1 + q1^2) / 6
    form = oscillator_step(1, h)
    assert (form.a, form.b) == (1 / h - h / 3, -1 / h - h / 6)
    limit = Fraction(12) ** Fraction(1, 2)
    assert oscillator_step(1, Fraction(limit * 0.999)).stable
    unstable = oscillator_step(1, Fraction(limit * 1.001))
    assert not unstable.stable and unstable.largest_energy_error == math.inf


def test_a_form_of_another_degree_does_not_predict_the_drift_free_energy(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def judged() -> str:
        rows = CLAIM["V2"].judge(quick(CLAIM["V2"]))
        (row,) = (row for row in rows if row.quantity.startswith("largest energy error over"))
        return row.verdict

    assert judged() == ATTAINED
    sound = v02.oscillator_step
    monkeypatch.setattr(v02, "oscillator_step", lambda degree, step: sound(degree + 1, step))
    assert judged() == CONTRADICTED
