"""Rows of V9, V11, V15, V22 and V24 rest on derived bounds or on scaling, and catch its absence."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pandas as pd
import pytest

import galvi
from benchmarks.checks.bounds import CONTRADICTED, FINDING, HOLDS
from benchmarks.checks.claim import Claim
from benchmarks.claims.vector_spaces import euler_readings, v09_solar_system_in_long_steps
from benchmarks.claims.vector_spaces import v11_euler_methods_on_planets as v11
from benchmarks.claims.vector_spaces import v15_noether_quantities as v15
from benchmarks.claims.vector_spaces import v22_best_approximation as v22
from benchmarks.claims.vector_spaces import v24_brownout_cost as v24
from benchmarks.claims.vector_spaces.implicit_euler_orbit import distances, follow, least_solvable
from benchmarks.studies.long_steps import ALONG, DISTANCE, ENERGY, FRAME_DISTANCE, FRAME_ENERGY
from references.textbook.implicit_euler import IMPLICIT_EULER
from tests.benchmarks.planted_tables import CLAIM
from tests.benchmarks.quick_studies import quick

V9, V11, V15, V22 = v09_solar_system_in_long_steps.V9, v11.V11, v15.V15, v22.V22


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
    closed = follow(problem.q0[None], problem.v0[None], np.ones(1), np.array([h]), steps * h)
    assert run.failed_step is not None and closed.unsolved[0] == run.failed_step - 1
    q, v = run.q[closed.unsolved[0]], run.p[closed.unsolved[0]]
    energy = 0.5 * v @ v - 1.0 / np.linalg.norm(q)
    assert closed.last[0] == pytest.approx(energy, rel=1e-9)


def test_only_the_smaller_solution_throws_a_planet_out() -> None:
    h = np.array([0.005])
    larger = euler_readings.two_body(v11.problem(), h)
    assert np.all(larger.energy < 0.0)
    assert (larger.unsolved + 1).tolist() == [18, 73, 179, 606]
    at_once = euler_readings.two_body(v11.problem(), h, smaller_at=np.ones(4))
    assert np.all(at_once.escaped)


def test_a_late_step_at_its_smaller_solution_throws_out_those_of_the_caption() -> None:
    """So do the fifth to the twelfth step before the one without a solution, in 1 to 2.9 years."""
    h, stops = np.array([0.005]), np.array([18, 73, 179, 606])
    for late in range(5, 13):
        for years in (1.0, 2.5, 2.9):
            orbits = euler_readings.two_body(v11.problem(), h, years, stops - late)
            assert orbits.escaped.tolist() == [True, True, True, False]


@pytest.mark.parametrize(
    ("name", "value", "quantity"),
    [
        (euler_readings.STOPPED, 1.1, euler_readings.STOPPED),
        (euler_readings.SOLVED, 0.9, euler_readings.SOLVED),
    ],
)
def test_a_stop_that_is_not_for_want_of_a_solution_is_caught(
    name: str, value: float, quantity: str
) -> None:
    table = table_of(V11)
    table.loc[table["quantity"] == name, "value"] = value
    found = verdicts(V11, table)
    assert next(v for q, v in found.items() if q.startswith(quantity)) == CONTRADICTED


def test_a_planet_that_most_steps_keep_would_be_told() -> None:
    """Mars thrown out by half of its steps: then the caption could be decided."""
    table = table_of(V11)
    table.loc[(table["study"] == v11.SMALLER) & (table["label"] == "Mars"), "value"] = 0.5
    found = verdicts(V11, table)
    assert next(v for q, v in found.items() if q.startswith("least share")) == CONTRADICTED


def test_an_escape_from_solved_steps_would_be_caught() -> None:
    table = table_of(V11)
    escape = (table["study"] == v11.LARGER) & (table["quantity"] == v11.ESCAPES)
    table.loc[table.index[escape][0], "value"] = 1.0
    found = verdicts(V11, table)
    assert next(v for q, v in found.items() if q.startswith("share of inner")) == CONTRADICTED


@pytest.mark.slow(beside="test_an_escape_from_solved_steps_would_be_caught")
@pytest.mark.parametrize(
    ("module", "name", "quantities"),
    [
        (
            euler_readings,
            "symplectic_change",
            {f"order of the {v11.BEYOND}, {v11.SYMPLECTIC}"},
        ),
        (
            v11,
            "explicit_slope",
            {f"order of the {v11.SECOND}, {label}" for label in (v11.EXPLICIT, v11.IMPLICIT)},
        ),
    ],
    ids=["symplectic", "explicit and implicit"],
)
def test_another_first_order_term_of_the_energy_is_caught(
    module: Any, name: str, quantities: set[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    derived: Callable[..., Any] = getattr(module, name)
    sound = v11.methods()
    monkeypatch.setattr(v11, "methods", lambda: {k: sound[k] for k in sound if k != v11.BLIND})
    monkeypatch.setattr(v11, "two_body_rows", lambda *given: [])
    monkeypatch.setattr(module, name, lambda *given: 0.9 * derived(*given))
    found = verdicts(V11, V11.study(galvi.Galerkin, True, lambda sentence: None))
    assert {found[quantity] for quantity in quantities} == {CONTRADICTED}


# ---- the solar system in long steps


def test_mercurys_base_is_that_of_the_singularity_of_its_orbit() -> None:
    e, year = 0.2056, 87.97
    t = year / (2.0 * math.pi) * (math.acosh(1.0 / e) - math.sqrt(1.0 - e**2))
    rho = 2.0 * t / 100.0 + math.hypot(1.0, 2.0 * t / 100.0)
    assert v09_solar_system_in_long_steps.mercury_base() == pytest.approx(rho**-2, abs=1e-3)


@pytest.mark.parametrize(("quantity", "word"), [(DISTANCE, "Mercury's largest"), (ENERGY, "energ")])
def test_another_base_of_mercurys_error_is_caught(quantity: str, word: str) -> None:
    table = table_of(V9)
    chosen = table["quantity"] == quantity
    table.loc[chosen, "value"] *= 1.08 ** table.loc[chosen, "n"]
    found = verdicts(V9, table)
    assert next(v for q, v in found.items() if q.startswith("base") and word in q) == CONTRADICTED


def test_orbits_that_differ_visibly_are_caught() -> None:
    table = table_of(V9)
    table.loc[table["quantity"] == ALONG, "value"] *= 2.0
    found = verdicts(V9, table)
    quantity = next(q for q in found if "on the curve" in q)
    assert verdicts(V9, table_of(V9))[quantity] == HOLDS and found[quantity] == CONTRADICTED


def test_a_frame_that_gains_too_little_is_caught() -> None:
    """There is room for 36 and 42 times what was measured: a hundredfold error must not pass."""
    sound = verdicts(V9, table_of(V9))
    for series in (FRAME_DISTANCE, FRAME_ENERGY):
        table = table_of(V9)
        table.loc[table["quantity"] == series, "value"] *= 100.0
        found = verdicts(V9, table)
        changed = [q for q in found if found[q] != sound[q]]
        assert len(changed) == 1 and "Kepler frame" in changed[0]
        assert found[changed[0]] == CONTRADICTED


# ---- Noether quantities


@pytest.mark.slow(beside="test_a_drift_of_another_order_is_caught")
def test_components_that_share_a_space_after_all_are_caught() -> None:
    """Their angular momentum is then conserved: no order is left to be found."""

    def make(space: Any, rule: Any) -> galvi.Galerkin:
        shared = galvi.Polynomials(max(space.degrees)) if hasattr(space, "degrees") else space
        return galvi.Galerkin(shared, rule)

    found = verdicts(V15, V15.study(make, True, lambda sentence: None))
    orders = [v for q, v in found.items() if q.startswith("order of the change of angular")]
    assert len(orders) == len(v15.MIXED) and FINDING not in orders


def test_a_drift_of_another_order_is_caught() -> None:
    table = table_of(V15)
    chosen = table["study"] == v15.ROTATION
    table.loc[chosen, "value"] *= table.loc[chosen, "step"]
    found = verdicts(V15, table)
    orders = [v for q, v in found.items() if q.startswith("order of the change of angular")]
    assert orders == [CONTRADICTED] * len(v15.MIXED)


# ---- best approximation, and the cost


def test_a_path_by_lobatto_of_n_nodes_that_is_one_order_better_is_caught() -> None:
    table = table_of(V22)
    chosen = (table["study"] == "Lobatto N") & (table["quantity"] == v22.PATH)
    table.loc[chosen, "value"] *= table.loc[chosen, "step"]
    found = verdicts(V22, table)
    lobatto = [v for q, v in found.items() if "smooth, Lobatto N, N" in q]
    assert lobatto == [CONTRADICTED] * 3


def test_a_rough_path_below_ms_lower_bound_is_caught() -> None:
    table = table_of(V22)
    chosen = (table["study"] == "rough") & (table["quantity"] == v22.PATH)
    table.loc[chosen, "value"] /= table.loc[chosen, "step"]
    found = [v for q, v in verdicts(V22, table).items() if f"{v22.PATH}, rough" in q]
    assert found[1:] == [CONTRADICTED] * 3  # of degree 1 the bound is 1


def test_no_verdict_about_the_cost_rests_on_a_time() -> None:
    table = table_of(CLAIM["V24"])
    sound, random = verdicts(CLAIM["V24"], table), np.random.default_rng(1)
    chosen = table["quantity"].isin([v24.SECONDS, v24.FASTEST, v24.SLOWEST])
    for scale in (1e-3, 1.0, 1e3):
        table.loc[chosen, "value"] *= scale * random.uniform(0.1, 10.0, chosen.sum())
        assert verdicts(CLAIM["V24"], table) == sound
