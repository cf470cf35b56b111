"""Rows of V9, V11, V15 and V24 rest on derived bounds or on scaling, and catch its absence."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pandas as pd
import pytest

import galvi
from benchmarks.checks.bounds import FINDING
from benchmarks.checks.claim import Claim
from benchmarks.claims.vector_spaces import v09_solar_system_in_long_steps as v09
from benchmarks.claims.vector_spaces import v11_euler_methods_on_planets as v11
from benchmarks.claims.vector_spaces import v15_noether_quantities as v15
from benchmarks.claims.vector_spaces import v24_brownout_cost as v24
from benchmarks.claims.vector_spaces.implicit_euler_orbit import (
    distances,
    follow,
    least_solvable,
    two_body,
)
from references.textbook.implicit_euler import IMPLICIT_EULER
from tests.suite.benchmarks.planted_tables import CLAIM
from tests.suite.benchmarks.quick_studies import quick


def table_of(claim: Claim) -> pd.DataFrame:
    """The quick study; a copy."""
    return quick(claim)


def verdicts(claim: Claim, table: pd.DataFrame) -> dict[str, str]:
    """Verdict by quantity."""
    return {row.quantity: row.verdict for row in claim.judge(table)}


# ---- the step of implicit Euler without a solution


def test_a_step_of_implicit_euler_has_a_solution_from_its_closed_limit_on() -> None:
    h, mu = np.array(0.005), np.array(39.478)
    least, a = least_solvable(mu, h), float(h**2 * mu)
    assert least == pytest.approx(0.1882, abs=5e-5)
    r = np.linspace(1e-3, 1.0, 1_000_001)
    assert np.min(r + a / r**2) == pytest.approx(float(least), rel=1e-9)
    for size in (1.001 * least, 2.0 * least):
        for root in distances(np.array([size]), np.array([a])):
            assert root[0] + a / root[0] ** 2 == pytest.approx(float(size), rel=1e-12)
    assert np.all(np.isnan(distances(np.array([0.999 * least]), np.array([a]))))


@pytest.mark.parametrize("h", [0.05, 0.1, 0.2])
def test_newtons_method_stops_where_the_closed_form_has_no_solution(h: float) -> None:
    problem = galvi.problems.kepler(0.3)
    steps = round(20.0 / h)
    run = IMPLICIT_EULER.run(problem, steps * h, {"step": h})
    start = problem.q0[None], problem.v0[None]
    (unsolved,), _, (last,) = follow(*start, np.ones(1), np.array([h]), steps * h)
    assert run.failed_step is not None and unsolved == run.failed_step - 1
    q, v = run.q[unsolved], run.p[unsolved]
    assert last == pytest.approx(0.5 * v @ v - 1.0 / np.linalg.norm(q), rel=1e-9)


def test_only_the_smaller_solution_throws_a_planet_out() -> None:
    h = np.array([0.005])
    unsolved, largest, _ = two_body(v11.problem(), h)
    assert np.all(largest < 0.0)
    assert (unsolved + 1).tolist() == [18, 73, 179, 606]
    unsolved, _, last = two_body(v11.problem(), h, smaller_at=np.ones(4))
    assert np.all(unsolved < 0) and np.all(last > 0.0)


def test_a_late_step_at_its_smaller_solution_throws_out_those_of_the_caption() -> None:
    """So do the fifth to the twelfth step before the one without a solution, in 1 to 2.9 years."""
    h, stops = np.array([0.005]), np.array([18, 73, 179, 606])
    for late in range(5, 13):
        for years in (1.0, 2.5, 2.9):
            unsolved, _, last = two_body(v11.problem(), h, years, stops - late)
            assert ((unsolved < 0) & (last > 0.0)).tolist() == [True, True, True, False]


# ---- the solar system in long steps


def test_mercurys_base_is_that_of_the_singularity_of_its_orbit() -> None:
    e, year = 0.2056, 87.97
    t = year / (2.0 * math.pi) * (math.acosh(1.0 / e) - math.sqrt(1.0 - e**2))
    rho = 2.0 * t / 100.0 + math.hypot(1.0, 2.0 * t / 100.0)
    assert v09.bounds()["mercury_base"] == pytest.approx(rho**-2, abs=1e-3)


# ---- Noether quantities


@pytest.mark.slow(beside="test_faults.py::test_a_planted_fault_is_caught")
def test_components_that_share_a_space_after_all_are_caught() -> None:
    """Their angular momentum is then conserved: no order is left to be found."""

    def make(space: Any, rule: Any) -> galvi.Galerkin:
        shared = galvi.Polynomials(max(space.degrees)) if hasattr(space, "degrees") else space
        return galvi.Galerkin(shared, rule)

    claim = CLAIM["V15"]
    found = verdicts(claim, claim.study(make, True, lambda sentence: None))
    orders = [v for q, v in found.items() if q.startswith("order of the change of angular")]
    assert len(orders) == len(v15.MIXED) and FINDING not in orders


# ---- the cost


def test_no_verdict_about_the_cost_rests_on_a_time() -> None:
    table = table_of(CLAIM["V24"])
    sound, random = verdicts(CLAIM["V24"], table), np.random.default_rng(1)
    chosen = table["quantity"].isin([v24.SECONDS, v24.FASTEST, v24.SLOWEST])
    for scale in (1e-3, 1.0, 1e3):
        table.loc[chosen, "value"] *= scale * random.uniform(0.1, 10.0, chosen.sum())
        assert verdicts(CLAIM["V24"], table) == sound
