"""The experiments behind choices say what the documentation says."""

from __future__ import annotations

import tracemalloc
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import galvi
from benchmarks.experiments import cost_of_events
from benchmarks.experiments import public_models as public
from benchmarks.experiments import two_time_scales as scales
from benchmarks.experiments.body_round_off import energy_growth
from benchmarks.statistics.drift import Growth
from benchmarks.work_precision.galvi_methods import gauss_collocation
from galvi.charts import CHARTS
from galvi.fast import law_stepper

FEW, MANY = 10_000, 100_000
SMALL, LARGE = 1e-18, 4e-18  # drifts in a step, relative, seen in many and in few steps


def growth_of_free_body(chart: object, steps: int, solver: str = "auto") -> Growth:
    method = gauss_collocation(12, chart).method
    return energy_growth(galvi.problems.free_rigid_body(), method, 0.5, steps, 12, solver)


@pytest.mark.slow_cases(but=["modified Rodrigues-auto"])
@pytest.mark.parametrize(
    "chart, solver",
    [*((chart, "auto") for chart in CHARTS), (galvi.Exponential(), "newton")],
    ids=lambda value: getattr(value, "name", value),
)
def test_a_free_body_has_no_drift_of_1e_18(chart: object, solver: str) -> None:
    found = growth_of_free_body(chart, FEW, solver)
    assert abs(found.drift) < 0.8 * SMALL, found
    assert found.drift_uncertainty < 0.25 * SMALL


@pytest.mark.slow(beside="test_a_free_body_has_no_drift_of_1e_18")
def test_neither_has_one_that_also_moves() -> None:
    method = gauss_collocation(12).method
    found = energy_growth(galvi.problems.free_body_se3(), method, 0.25, FEW, 12)
    assert abs(found.drift) < 0.8 * SMALL, found


@pytest.mark.slow_cases("100000-1e-18")
@pytest.mark.parametrize("steps, drift", [(FEW, LARGE), (MANY, SMALL)])
def test_a_drift_is_seen(steps: int, drift: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """A weight too large by some units in its last place turns the body too far in each step."""
    sound = growth_of_free_body(galvi.Cayley(), steps)
    tables_of = law_stepper.group_law_tables

    def larger(table, step, lanes):  # type: ignore[no-untyped-def]
        tables, *others = tables_of(table, step, lanes)
        (planted,) = law_stepper.aligned(tables.shape)
        planted[:] = tables
        planted[4 * tables.shape[1], table.c.size // 2] += excess
        return planted, *others

    monkeypatch.setattr(law_stepper, "group_law_tables", larger)
    excess = 1e-15
    excess *= drift / growth_of_free_body(galvi.Cayley(), FEW).drift
    faulty = growth_of_free_body(galvi.Cayley(), steps)
    assert faulty.drifts and abs(faulty.drift) > 5.0 * faulty.drift_uncertainty
    assert abs(faulty.drift - drift) < 0.5 * drift
    assert not sound.drifts


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


ROOT = Path(__file__).parents[2]
CLOSE = 1e-11  # 1e-12: MuJoCo's rounding and ours, in trees of 56 velocities


def stored() -> pd.DataFrame:
    table = pd.read_csv(ROOT / public.TABLE, keep_default_na=False)
    return table.assign(difference=pd.to_numeric(table["difference"]))


def changes(before: pd.DataFrame, now: pd.DataFrame) -> list[str]:
    """What is said of a model in one table and not in the other; and differences above CLOSE."""
    words = ["model", "version", "velocities", "left_out", "why_not"]
    rows = (table[words].itertuples(index=False) for table in (before, now))
    one, other = ({tuple(row) for row in table} for table in rows)
    large = now[now["difference"] > CLOSE]["model"]
    return sorted(f"{row}" for row in one ^ other) + sorted(large)


def test_the_table_is_of_the_wheels_that_are_kept() -> None:
    line = (ROOT / "Makefile").read_text().partition("\nMODELS ?= ")[2].partition("\nBIN")[0]
    pinned = dict(word.split("==") for word in line.replace("\\", " ").split())
    table = stored()
    folders = table["model"].str.partition("/")[0].str.replace("_", "-")
    found = dict(zip(folders, table["version"], strict=True))
    assert found.pop("mujoco")
    assert found == {name.replace("_", "-"): version for name, version in pinned.items()}


def test_every_public_model_that_moves_and_that_mujoco_reads_is_read() -> None:
    table = stored()
    assert len(table) == 153 and table["velocities"].max() == 132
    assert (table["why_not"] == "").equals(table["velocities"] > 0)
    assert table["difference"].max() <= CLOSE
    assert not changes(table, table)


@pytest.mark.parametrize("fault", ["a model that is refused", "another part", "misread", "gone"])
def test_a_change_is_seen(fault: str) -> None:
    before, now = stored(), stored()
    row = now.index[now["velocities"] == 132][0]
    if fault == "a model that is refused":
        now.loc[row, "why_not"] = "the model must be trees"
    elif fault == "another part":
        now.loc[row, "left_out"] += ", sleep"
    elif fault == "misread":
        now.loc[row, "difference"] = 1e-6
    else:
        now = now.drop(row)
    assert all("drosophila" in change for change in changes(before, now)) and changes(before, now)


@pytest.mark.slow(beside="test_a_change_is_seen")
def test_public_models_are_read_as_the_table_says() -> None:
    kept = {tuple(wheel.name.split("-")[:2]) for wheel in public.WHEELS.glob("*.whl")}
    asked = stored()
    engines = {("mujoco", version) for version in asked["version"]}
    packages = asked["model"].str.partition("/")[0]
    if not set(zip(packages, asked["version"], strict=True)) <= {*kept, *engines}:
        pytest.skip(f"{public.WHEELS.name} in the environment lacks wheels: make install")
    assert changes(asked, public.table()) == []


@pytest.mark.slow(beside="test_forces_of_position_keep_the_order_elsewhere")
def test_runs_with_forces_are_timed_with_what_they_name(monkeypatch) -> None:
    from benchmarks.experiments import force_costs
    from benchmarks.timings import forced_runs

    for name in ("STEPS", "ARM_STEPS", "SLOW_STEPS"):
        monkeypatch.setattr(forced_runs, name, 2)
    rows = force_costs.costs(rounds=1)
    assert all(microseconds > 0.0 for *_, microseconds, _ in rows)
    groups = forced_runs.calls()
    assert [row[:2] for row in rows] == [(one, name) for one in groups for name in groups[one]]
    ours = {name: call() for name, (call, _) in groups["galvi, outer planets"].items()}
    assert {run.engine for run in ours.values()} == {"lanes"}
    framed, clocked = (
        {name: call() for name, (call, _) in groups[f"galvi, {place}"].items()}
        for place in forced_runs.ELSEWHERE
    )
    assert {run.engine for run in framed.values()} == {"frame"}
    assert {run.engine for run in clocked.values()} == {"clock"}
    arms = {name: call() for name, (call, _) in groups["galvi, arm of three hinges"].items()}
    for runs in (ours, framed, clocked, arms):
        plain = runs.pop(forced_runs.NONE)
        assert all(np.any(run.q[-1] != plain.q[-1]) for run in runs.values())


def test_forces_of_position_keep_the_order_elsewhere() -> None:
    from benchmarks.experiments import forces_elsewhere

    for place, (_, _, s) in forces_elsewhere.PLACES.items():
        found, order, moved = forces_elsewhere.errors(place, "J2 of the planet")
        assert abs(order - 2 * s) < 0.3 and moved > 1e-6 and found[-1] < 0.01 * moved, place


@pytest.mark.slow(beside="test_the_cost_of_events_is_that_of_runs_with_and_without_them")
def test_an_event_takes_at_most_200_bytes() -> None:
    found = []
    for count in (2_000, 12_000):
        run, event = cost_of_events.passing(count)
        tracemalloc.start()
        events = galvi.find_events(run, event)
        found.append((len(events), tracemalloc.get_traced_memory()[1]))
        tracemalloc.stop()
    (few, little), (many, much) = found
    assert abs(few - 2_000) <= 1 and abs(many - 12_000) <= 1
    assert (much - little) / (many - few) < 200.0, found


def test_the_cost_of_events_is_that_of_runs_with_and_without_them() -> None:
    found = cost_of_events.shares(rounds=6, steps=200)
    assert len(found) == 2 and all(
        0.0 < one.low <= one.median <= one.high for one in found.values()
    )
