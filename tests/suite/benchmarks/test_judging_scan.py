"""What a judgement tries: for how long, how fine and how coarse, and what it says of each."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, cast

import numpy as np
import pytest

import galvi
from benchmarks.applications.judging import bodies, clock
from benchmarks.applications.judging.candidate import Candidate, Kind, Model, Own
from benchmarks.applications.judging.judgement import YOURS, Judgement, judge
from benchmarks.applications.judging.scan import Limits, Search, Tried, explained, scan
from galvi import Problem, Trajectory
from references.closed_forms.kepler import KEPLER
from references.rebound.leapfrog import LEAPFROG
from reports.judge.files import rendered
from reports.judge.sentences import sentences

pytest.importorskip("rebound")

YEAR = 2.0 * math.pi
SPAN = 4.0 * YEAR
ROOMY = Limits(1.0, 5.0, 10.0, 1.0)


def planet(**own: Any) -> Problem:
    """A star and a massless planet, whose motion is known."""
    q, v = np.zeros((2, 3)), np.zeros((2, 3))
    q[1, 0], v[1, 1] = 1.0, 1.1
    parameters = {"integrator": "leapfrog", "dt": YEAR / 100, **own}
    return Problem(galvi.NBody([1.0, 0.0]), q, v, parameters=parameters)


@dataclass(frozen=True, eq=False)
class Slow:
    """REBOUND's leapfrog after so many seconds of set-up; ``ran`` holds who ran."""

    setup: float = 0.0
    label: str = ""
    ran: list[str] = field(default_factory=list)
    name: str = "slow leapfrog"
    order: int = 2
    exact: bool = False
    missing: str = ""

    def supports(self, problem: Problem) -> bool:
        return True

    def run(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Trajectory:
        time.sleep(self.setup)
        self.ran.append(self.label)
        return LEAPFROG.run(problem, duration, setting)


def search(wanted: float) -> Search:
    truth = KEPLER.run(planet(), SPAN, {"samples": 100})
    return Search(cast(Kind, bodies), SPAN, truth, wanted)


def leapfrog(steps: int, contender: Any = LEAPFROG) -> Candidate:
    return Candidate("leapfrog", contender, {}, steps)


@pytest.mark.parametrize("pause", [0.0, 0.04])  # in the third call, as of a busy machine
@pytest.mark.parametrize(("setup", "step"), [(0.06, 1e-6), (0.0, 1e-3), (0.5, 1e-3), (1e-4, 1e-5)])
def test_the_time_of_a_run_is_foreseen_without_its_set_up_in_every_step(
    monkeypatch: pytest.MonkeyPatch, setup: float, step: float, pause: float
) -> None:
    """On a clock that runs only where it is told to."""
    now, calls = [0.0], [0]
    monkeypatch.setattr(clock.time, "perf_counter", lambda: now[0])

    def run(count: int) -> None:
        calls[0] += 1
        now[0] += setup + count * step + (pause if calls[0] == 3 else 0.0)

    whole, enough = 10_000, 1.0
    real = setup + whole * step
    found = clock.expected(run, whole, enough)
    assert found == pytest.approx(real, rel=1e-9) or real <= found <= enough


def test_a_long_set_up_keeps_no_integrator_from_being_tried() -> None:
    """Two steps take 0.03 s, so that 20,000 would take 300 s if all steps were like these."""
    rows = search(1e-4).of([leapfrog(20_000, Slow(0.03))], limit=2.0)
    assert rows[0].reached and rows[0].error < 1e-4


def test_an_integrator_is_tried_with_finer_steps_until_its_time_is_over() -> None:
    """Even where another reaches the error in a microsecond."""
    found = search(1e-5)
    own = Tried("mine", "dt = 1", error=1e-6, seconds=1e-6)
    table, _ = scan(found.kind, [[leapfrog(100)]], SPAN, found.truth, 1e-5, print, ROOMY, own)
    rows = table[table["integrator"] == "leapfrog"]
    assert rows["reached"].any() and len(rows) > 3
    assert table.iloc[0]["integrator"] == "mine"


def test_what_does_not_reach_the_error_says_how_fine_it_was_tried() -> None:
    rows = search(1e-15).of([leapfrog(100)], limit=0.2)
    last = rows[-1]
    assert len(rows) > 2 and not any(row.reached for row in rows)
    told = f"not reached with the finest setting tried, {last.setting}, error {last.error:.2g}: "
    assert last.status.startswith(told) and len(last.status) > len(told)
    assert all(row.status for row in rows)
    best = Tried("one", "dt = 2", rows[0].candidate, error=0.1, status="missed")
    worse = replace(best, setting="dt = 1", error=0.2)
    failed = replace(best, setting="dt = 1", error=math.nan, status="It failed.")
    for finest, word in ((worse, "error 0.2"), (failed, "failed")):
        told = [row.status for row in explained([best, finest], "why")]
        assert told[0] == f"not reached with the finest setting tried, dt = 1, {word}: why"
        assert told[1] == ("It failed." if finest is failed else told[0])
    steps = [row.candidate.count(100) for row in rows if row.candidate is not None]
    assert steps == sorted(steps)


def test_coarser_steps_are_tried_while_they_reach_the_error() -> None:
    rows = search(1e-2).of([leapfrog(20_000)], limit=5.0)
    assert rows[0].reached and not rows[-1].reached and all(row.reached for row in rows[:-1])
    steps = [row.candidate.count(100) for row in rows if row.candidate is not None]
    assert steps == sorted(steps, reverse=True) and len(steps) > 2


def test_fewer_steps_than_states_are_compared_at_some_of_the_states() -> None:
    few = leapfrog(30)
    assert (few.states(100), few.count(100)) == (25, 50)
    assert leapfrog(100).states(100) == 100 and leapfrog(7).states(100) == 100
    run = few.run(planet(), SPAN, 100)
    assert len(run.t) == 26 and np.allclose(run.t, search(1.0).truth.t[::4])


def test_times_are_taken_in_turns_and_have_a_spread() -> None:
    ran: list[str] = []
    pair = [leapfrog(100, Slow(0.0, label, ran)) for label in "ab"]
    times = clock.race([*pair, leapfrog(100)], [1e-3, 1e-3, 1e3], planet(), SPAN, 100, 1.0)
    assert "".join(ran).replace("ab", "") == "" and len(ran) >= 2 * clock.FEWEST
    assert times[0].size == times[1].size >= clock.FEWEST and times[2].size == 0
    middle, low, high = clock.quartiles(np.array([5.0, 1.0, 2.0, 4.0, 3.0]))
    assert (low, middle, high) == (2.0, 3.0, 4.0)


@pytest.fixture(scope="module")
def found() -> Judgement:
    return judge(planet(), duration=SPAN, error=0.5, quick=True)


def test_the_own_run_is_a_row_and_larger_steps_than_its_own_are_tried(found: Judgement) -> None:
    mine = found.table[found.table["integrator"] == f"REBOUND leapfrog{YOURS}"]
    steps = mine["setting"].str.removeprefix("dt = ").astype(float)
    own = mine[mine["setting"] == found.own["setting"]].iloc[0]
    assert steps.max() > 1.5 * YEAR / 100 and own["reached"] and found.passed
    assert own["error"] == found.own["error"] and own["seconds"] == found.own["seconds"]
    reached = found.table[found.table["reached"]]
    best = found.recommended
    assert best is not None and best["reached"] and best["error"] <= found.error
    assert best["seconds"] == reached["seconds"].min()
    assert (found.table.loc[~found.table["reached"], "error"].dropna() > found.error).all()


def test_where_the_own_run_is_the_cheapest_that_is_said(found: Judgement) -> None:
    mine = found.table["setting"] == found.own["setting"]
    table = found.table.assign(seconds=np.where(mine, 1e-9, 1.0), seconds_low=1.0, seconds_high=1.0)
    table = table.sort_values(["reached", "seconds"], ascending=[False, True])
    said = sentences(replace(found, table=table))
    assert any("your own run reaches an error of 0.500" in one for one in said)
    assert not any("The cheapest that reaches" in one for one in said)
    other = found.table[~mine & found.table["reached"]].iloc[:2]
    other = other.assign(seconds=[1.0, 2.0], seconds_low=[0.9, 1.1], seconds_high=[1.2, 2.5])
    slow, alike = ({"seconds": 3.0, "seconds_low": low, "seconds_high": 4.0} for low in (2.9, 1.0))
    for times, words in (
        (slow, ", 2.4 to 4.4 times as fast as your run."),
        (alike, "within quartiles no faster than your run."),
    ):
        given = replace(found, table=other, own={**found.own, **times})
        (said,) = [one for one in sentences(given) if "The cheapest that reaches" in one]
        assert words in said and "As fast, within quartiles: " in said
    hasty = {**found.own, "seconds": 0.5, "seconds_low": 0.4, "seconds_high": 0.6}
    assert not any("your run." in one for one in sentences(replace(given, own=hasty))[2:])


def test_every_row_has_a_status_and_what_reaches_the_error_a_spread(found: Judgement) -> None:
    assert (found.table["status"] != "").all()
    reached = found.table[found.table["reached"]].dropna(subset="seconds_low")
    assert f"REBOUND leapfrog{YOURS}" in set(reached["integrator"])
    assert (reached["seconds_low"] <= reached["seconds"]).all()
    assert (reached["seconds"] <= reached["seconds_high"]).all()
    assert "(quartiles " in sentences(found)[0]


def test_errors_are_given_at_the_end_too_and_with_the_number_of_times(found: Judgement) -> None:
    assert found.own["last_error"] == found.own_errors["error"].iloc[-1]
    told = f"at the end (measured at {len(found.own_errors) - 1} times, not between them;"
    assert told in sentences(found)[0]
    tried = found.table.dropna(subset="error")
    assert (tried["last_error"] <= tried["error"]).all() and tried["last_error"].notna().all()
    assert f"at the {found.samples} times compared" in rendered(found, "planet", {})


@pytest.mark.slow(beside="test_errors_are_given_at_the_end_too_and_with_the_number_of_times")
def test_units_that_are_not_set_are_those_of_the_simulation(found: Judgement) -> None:
    told = "in the units of the simulation, in which G = 1"
    assert any(told in note for note in found.notes)
    sim = pytest.importorskip("rebound").Simulation()
    sim.add(m=1.0)
    sim.add(a=1.0)
    own = Own("", LEAPFROG, {}, 0.1)
    read = Model(galvi.from_rebound(sim))
    assert bodies.unit(read.problem, "length") == " units of length"
    assert told in bodies.notes(read, own, found.truth)[0]
    assert " units of length over 25.1 units of time" in sentences(found)[0]
    page = rendered(found, "planet", {})
    assert "in units of length" in page and "dt in units of time" in page
    named = replace(planet(), units="length au, time yr, mass msun")
    assert bodies.unit(named, "time") == " yr" and bodies.unit(planet(), "time") == " units of time"
    assert not judge(named, duration=SPAN, error=0.5, quick=True).notes


def tried(steps: int, **told: Any) -> Tried:
    return Tried("leapfrog", "", leapfrog(steps), 1e-9, 1e-9, wall=1e-3, **told)


def test_where_newtons_method_does_steps_more_of_them_are_tried() -> None:
    """They may take less time; where none is left to it, the search ends."""
    looking = search(1e-6)
    hard = tried(100, reached=True, hard=True)
    candidate, _ = looking._next([hard], [], 10.0)
    assert candidate is not None and candidate.steps == 200
    easy = tried(200, reached=True)
    assert looking._next([tried(50), hard, easy], [], 10.0) == (None, "")


def test_a_stop_that_no_step_cures_ends_a_search() -> None:
    looking, rows = search(1e-6), [tried(100, stopped=0.5), tried(200, stopped=0.51)]
    candidate, why = looking._next(rows, [], 10.0)
    assert candidate is None and why == "a force reaches its limit at t = 0.51, whatever the step"
    candidate, _ = looking._next([*rows, tried(400, stopped=1.0)], [], 10.0)
    assert candidate is not None
