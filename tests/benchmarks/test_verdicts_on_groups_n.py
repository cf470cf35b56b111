"""L1, L2, L6 and L9 tell runs for which H's statements hold from runs for which they do not."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pandas as pd
import pytest

from benchmarks.checks.bounds import CONTRADICTED, FINDING, HOLDS, NOT_RUN
from benchmarks.claims.lie_groups import l02_free_body_convergence_in_n as l02
from benchmarks.claims.lie_groups import l06_pendulum_convergence_in_n as l06
from benchmarks.claims.lie_groups import l09_pendulum_near_chart_limit as l09
from benchmarks.claims.lie_groups import steps_near_the_limit as steps
from benchmarks.claims.lie_groups.cayley_curve import cayley_rate, distance_of_polynomials, turned
from benchmarks.claims.lie_groups.curves_and_ends import DURATIONS, scan_of
from galvi.arrays import Array
from tests.benchmarks.quick_studies import quick

HELD = [l09.named(weight, "Cayley") for weight in l09.HELD]


@pytest.fixture(scope="module")
def table() -> pd.DataFrame:
    return quick(l09.L9)


def verdicts(table: pd.DataFrame) -> dict[str, str]:
    return {row.quantity: row.verdict for row in l09.judge(table)}


def changed(table: pd.DataFrame, change: Callable[[Any], Any], **where: Any) -> pd.DataFrame:
    """The frame with `change` applied to the values of these rows."""
    chosen = np.logical_and.reduce([table[name] == value for name, value in where.items()])
    wrong = table.copy()
    wrong.loc[chosen, "value"] = change(wrong.loc[chosen, "value"])
    return wrong


@pytest.mark.slow(beside="test_faults.py::test_a_planted_fault_is_caught")
def test_what_h_leaves_open_is_not_held_against_it(table: pd.DataFrame) -> None:
    found = {row.quantity: row for row in l09.judge(table)}
    assert CONTRADICTED not in {row.verdict for row in found.values()}
    assert all(found[f"steps done, {run}"].verdict == HOLDS for run in HELD)
    assert all("m g from 5 to 30" in found[f"steps done, {run}"].setup for run in HELD)
    other = ("9.81", "29.43", "of the scan", "exponential", "modified Rodrigues")
    assert all(
        row.verdict == FINDING for name, row in found.items() if any(word in name for word in other)
    )


@pytest.mark.slow(beside="test_faults.py::test_a_planted_fault_is_caught")
def test_a_run_that_ends_early_or_stays_away_from_pi_is_not_said_to_hold(
    table: pd.DataFrame,
) -> None:
    run = {"study": HELD[1]}
    assert verdicts(changed(table, lambda x: x - 1.0, quantity=l09.DONE, **run))[
        f"steps done, {HELD[1]}"
    ] == CONTRADICTED  # fmt: skip
    assert verdicts(changed(table, lambda x: 0.9 * x, quantity=steps.TURN, **run))[
        f"largest turn in a step [rad], {HELD[1]}"
    ] == CONTRADICTED  # fmt: skip


@pytest.mark.slow(beside="test_faults.py::test_a_planted_fault_is_caught")
def test_jumps_at_any_turn_are_not_put_down_to_the_chart(table: pd.DataFrame) -> None:
    random = np.random.default_rng(0)
    name = next(name for name in verdicts(table) if "growth of the median" in name)
    shuffled = changed(
        table, random.permutation, quantity=steps.CHANGE, study=steps.one_step("Cayley")
    )
    assert verdicts(shuffled)[name] == CONTRADICTED
    walk = changed(
        table,
        lambda x: 1e-9 * np.cumsum(random.standard_normal(len(x))),
        quantity=l09.ENERGY,
        study=HELD[1],
    )
    share = next(name for name in verdicts(table) if "share" in name and HELD[1] in name)
    assert verdicts(walk)[share] == CONTRADICTED


@pytest.mark.slow(beside="test_faults.py::test_a_planted_fault_is_caught")
@pytest.mark.parametrize("power", [0.5, 1.5])
def test_another_power_of_the_distance_is_caught(table: pd.DataFrame, power: float) -> None:
    name = next(name for name in verdicts(table) if name.startswith("power of the distance"))
    wrong = changed(
        table, lambda x: x**power, quantity=steps.CHANGE, study=steps.one_step("Cayley")
    )
    assert verdicts(table)[name] == FINDING
    assert verdicts(wrong)[name] == CONTRADICTED


def turn_about(axis: Array, angles: Array) -> Array:
    """Rotations (k, 3, 3) by Rodrigues' formula."""
    x, y, z = axis / np.linalg.norm(axis)
    hat = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    sines, versines = np.sin(angles)[:, None, None], (1.0 - np.cos(angles))[:, None, None]
    return np.eye(3) + sines * hat + versines * (hat @ hat)


@pytest.mark.parametrize("angle", [0.3, 2.9, 3.1, 3.2, 5.0])
def test_a_turn_is_followed_beyond_pi(angle: float) -> None:
    path = turn_about(np.array([1.0, -2.0, 0.5]), np.linspace(0.0, angle, 161))
    assert turned(path) == pytest.approx(angle, abs=1e-12)  # 1e-15 was measured


def test_polynomials_are_as_far_from_a_steady_turn_as_its_pole_says() -> None:
    """n r^-n, with r of Bernstein's ellipse through the pole, which in xi' is a double one."""
    axis, angle, step = np.array([0.6, 0.0, 0.8]), 2.8, 0.6
    t = np.linspace(0.0, angle, 401)
    path, omega = turn_about(axis, t), np.tile(axis * angle / step, (401, 1))
    xi, rate = cayley_rate(path, omega)
    assert np.allclose(xi, 2.0 * np.tan(0.5 * t)[:, None] * axis, rtol=1e-12)
    assert np.allclose(rate, (angle / step / np.cos(0.5 * t) ** 2)[:, None] * axis, rtol=1e-12)
    away = 2.0 * np.pi / angle - 1.0
    r = away + np.sqrt(away**2 - 1.0)
    found = [distance_of_polynomials(path, omega, degree) for degree in (11, 13)]
    assert found[0] / found[1] == pytest.approx(11 / 13 * r**2, rel=0.05)  # 0.5 % was measured


@pytest.mark.parametrize("module", [l02, l06], ids=["L2", "L6"])
def test_n_star_is_not_drawn_round_what_was_measured(module: Any) -> None:
    """Curves of the longest run ten times worse: n* falls, the law from the shortest run stays."""
    claim = module.L2 if module is l02 else module.L6
    sound = quick(claim)
    before = {row.quantity: row for row in claim.judge(sound) if row.quantity.startswith("n*")}
    assert {row.verdict for row in before.values()} == {FINDING}
    worse = sound.copy()
    longest = worse["study"].str.endswith(f"T = {DURATIONS[-1]:g}")
    worse.loc[longest & (worse["quantity"] == "curve error"), "value"] *= 10.0
    after = {row.quantity: row for row in claim.judge(worse)}
    for name, row in before.items():
        assert after[name].bound == row.bound
        changes = name.endswith(f"T = {DURATIONS[-1]:g}")
        assert (after[name].verdict == CONTRADICTED) == changes or not np.isfinite(
            after[name].measured or np.nan
        )


def test_ends_whose_error_does_not_grow_with_t_are_caught() -> None:
    """Errors of all ends as at T = 5."""
    sound = quick(l02.L2)
    ends = {"quantity": "one-step error"}
    first = sound[(sound["study"] == scan_of(5.0)) & (sound["quantity"] == "one-step error")]
    still = changed(sound, lambda x: first["value"].to_numpy(), study=scan_of(500.0), **ends)
    verdict = {row.quantity: row.verdict for row in l02.judge(still)}
    # The curves are then behind for every n, so that there is no n*.
    assert verdict["n*, up to which the curves are as good as the ends, T = 500"] == NOT_RUN
