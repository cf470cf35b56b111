"""The gates of a comparison, on fake samples: what goes red, with which words, what does not."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.timings.case import ROUND_OFF, TRAJECTORY, Case
from reports.tracking import against
from reports.tracking.against import compare
from reports.tracking.gates import judge
from reports.tracking.outcome import Outcome, as_json, summary
from reports.tracking.project import Checkout
from reports.tracking.rounds import Pair
from reports.tracking.worker import Failed

CASE = Case("orbit", TRAJECTORY, "kepler", 4, 4, 0.1, 10, rounding=1e-14)
OTHER = replace(CASE, name="other")
COUNTS = {"steps": 10, "iterations": 50, "force_evaluations": 200}
HANGS = "It gave no answer within 600 seconds and was ended."


class Fake:
    """A worker with these times, and what its first call reaches; fails where it says so."""

    def __init__(
        self, factor: float = 1.0, why: str = "", hangs: bool = False, **reached: Any
    ) -> None:
        self.factor, self.why, self.hangs, self.reached = factor, why, hangs, reached
        self.random = np.random.default_rng(3)
        self.samples = 0

    def run(self, case: Case) -> dict[str, Any]:
        if self.why:
            raise Failed(self.why)
        reached = {"ends": [[1.0 + 1e-9, 0.0]], "counts": COUNTS, "success": True, "status": "ok"}
        return reached | {"first_call": 1.0, "warm": 0.01, "problem": {}} | self.reached

    def time(self, case: Case, repeats: int, attempts: int) -> float:
        if self.hangs:
            raise Failed(HANGS)
        self.samples += 1
        return self.factor * (1.0 + 0.01 * float(self.random.standard_normal()))


@contextmanager
def studies(name: str, title: str) -> Iterator[Any]:
    yield lambda text: None


@pytest.fixture
def compared(monkeypatch: pytest.MonkeyPatch) -> Any:
    """Compare two fakes; `again` is the head of the second round."""

    def do(base: Fake, head: Fake, again: Fake | None = None, cases: Any = (CASE,)) -> Outcome:
        heads = iter([head, again or head])

        @contextmanager
        def workers(*checkouts: Checkout) -> Iterator[dict[str, Any]]:
            yield {"base": base, "head": next(heads)}

        monkeypatch.setattr(against, "workers", workers)
        monkeypatch.setattr(against, "true_ends", lambda case: [np.array([1.0, 0.0])])
        sides = Checkout(Path("b"), "base"), Checkout(Path("h"), "head")
        outcome = compare(*sides, cases, studies)
        json.loads(as_json(outcome, {}))
        return outcome

    return do


def alarms(outcome: Outcome) -> dict[str, str]:
    return dict(outcome.findings[0].alarms)


def test_equal_sides_are_green_in_one_sentence(compared: Any) -> None:
    outcome = compared(Fake(), Fake())
    assert not outcome.worse
    assert str(outcome).startswith("head is not worse than base in 1 benchmark: ")
    assert outcome.findings[0].moved == 0.0
    assert "(smallest growth visible here: 10 %)" in str(outcome)
    assert outcome.table()["visible from"].tolist() == ["10 %"]


@pytest.mark.parametrize("factor", [1.15, 1.3, 2.0])
def test_a_slower_head_is_red_at_the_gate_of_time_alone(compared: Any, factor: float) -> None:
    outcome = compared(Fake(), Fake(factor))
    assert set(alarms(outcome)) == {"time"}
    assert "slower by" in alarms(outcome)["time"] and "second round" in alarms(outcome)["time"]
    assert str(outcome) == "head is worse than base in 1 of 1 benchmark: orbit (time)."


class Unseeded(Fake):
    """Its ends differ from run to run."""

    def run(self, case: Case) -> dict[str, Any]:
        reached = super().run(case)
        return reached | {"ends": [[1.0 + 1e-13 * self.random.standard_normal(), 0.0]]}


def test_a_head_whose_runs_differ_is_red_unless_those_of_the_base_do(compared: Any) -> None:
    outcome = compared(Fake(), Unseeded())
    assert "not deterministic" in str(outcome)
    said = alarms(outcome)["not deterministic"]
    assert re.match(r"Two runs of the head differ by \d\S*e-1[34]: it is not determ", said), said
    both = compared(Unseeded(), Unseeded())
    assert not both.worse and "Two runs of the base differ" in " ".join(both.findings[0].notes)


class Growing(Fake):
    """Each run leaves so many bytes."""

    def __init__(self, bytes_: float) -> None:
        super().__init__()
        self.bytes_, self.whole = bytes_, 2e8

    def run(self, case: Case) -> dict[str, Any]:
        self.whole += self.bytes_
        return super().run(case) | {"memory": self.whole}


def test_a_leak_is_red_by_its_memory(compared: Any) -> None:
    said = alarms(compared(Growing(0.0), Growing(60e6)))
    assert said == {"memory": "a run leaves 60 MB in memory, where it left 0."}
    assert not compared(Growing(0.0), Growing(5e6)).worse
    assert not compared(Growing(60e6), Growing(60e6)).worse
    assert not compared(Fake(), Growing(60e6)).worse  # the base does not tell


def test_what_could_have_been_seen_is_said(compared: Any) -> None:
    """With times that scatter by a third, a growth of a tenth is below what they show."""

    class Noisy(Fake):
        def time(self, case: Case, repeats: int, attempts: int) -> float:
            return float(np.exp(0.33 * self.random.standard_normal()))

    seen = compared(Noisy(), Noisy()).findings[0].visible
    assert 0.2 < seen < 3.0


def test_five_percent_slower_is_below_the_size_and_runs_no_second_round(compared: Any) -> None:
    again = Fake()
    assert not compared(Fake(), Fake(1.05), again).worse
    assert again.samples == 0


def test_what_a_second_round_does_not_confirm_is_a_note(compared: Any) -> None:
    outcome = compared(Fake(), Fake(1.3), again=Fake())
    assert not outcome.worse
    assert "which a second round did not confirm" in outcome.findings[0].notes[0]


KNOWN = {"start": [0.0, 1.0], "acceleration": [-1.0, 1e-17, math.nan]}
EXACT = {"ends": [[1.0, 0.0]]}
JUDGED: dict[str, tuple[dict[str, Any], dict[str, Any], set[str]]] = {
    "one more iteration": ({}, {"counts": COUNTS | {"iterations": 51}}, {"counts"}),
    "one more evaluation": ({}, {"counts": COUNTS | {"force_evaluations": 201}}, {"counts"}),
    "one iteration less": ({"counts": COUNTS | {"iterations": 51}}, {}, set()),
    "an error beyond its tolerance": ({}, {"ends": [[1.0 + 1.02e-9, 0.0]]}, {"error"}),
    "an error within its tolerance": ({}, {"ends": [[1.0 + 1.005e-9, 0.0]]}, set()),
    "a smaller error": ({}, {"ends": [[1.0 + 0.5e-9, 0.0]]}, set()),
    "an error that is rounding": (EXACT, {"ends": [[1.0, 9e-15]]}, set()),
    "an error above rounding": (EXACT, {"ends": [[1.0, 2e-14]]}, {"error"}),
    "an end that is not finite": ({}, {"ends": [[math.nan, 0.0]]}, {"error"}),
    "a force that the truth would hide": (
        {"ends": [[5.0, 0.0]], "problem": KNOWN},
        {"problem": KNOWN | {"acceleration": [1.0, 0.0, math.nan]}},
        {"problem"},
    ),
    "a problem of another dimension": (
        {"problem": KNOWN},
        {"ends": [[1.0, 0.0, 0.0]], "problem": KNOWN | {"start": [0.0, 1.0, 2.0]}},
        {"problem"},
    ),
    "a force that was rounded otherwise": (
        {"problem": KNOWN},
        {"problem": {"acceleration": [-1.0 - 2e-16, -1e-17, math.nan], "more": [1.0]}},
        set(),
    ),
}


@pytest.mark.parametrize("change", JUDGED)
def test_a_change_is_red_at_its_gate_alone(compared: Any, change: str) -> None:
    base, head, gates = JUDGED[change]
    assert set(alarms(compared(Fake(**base), Fake(**head)))) == gates


def test_an_alarm_names_what_changed(compared: Any) -> None:
    changed = [JUDGED["one more iteration"], JUDGED["a force that the truth would hide"]]
    counts, problem = (alarms(compared(Fake(**base), Fake(**head))) for base, head, _ in changed)
    assert counts == {"counts": "iterations 50 became 51, 2 % more."}
    assert "not the base's (acceleration)" in problem["problem"]


def test_a_count_that_one_side_lacks_is_a_note(compared: Any) -> None:
    outcome = compared(Fake(), Fake(counts={"steps": 10, "force_evaluations": 200, "passes": 9}))
    assert not outcome.worse and outcome.table()["counts"].tolist() == ["same"]
    assert outcome.findings[0].notes == (
        "Only one side counts iterations, passes, so that cannot be compared.",
    )


def test_a_base_whose_ends_are_not_finite_does_not_accuse_the_head(compared: Any) -> None:
    outcome = compared(Fake(ends=[[math.nan, 0.0]]), Fake())
    assert not outcome.worse and "errors do not compare" in outcome.findings[0].notes[0]


def test_a_run_that_fails_is_red_once_and_a_base_that_fails_is_a_note(compared: Any) -> None:
    failed = {"success": False, "status": "Newton failed.", "ends": [[math.nan, math.nan]]}
    outcome = compared(Fake(), Fake(**failed))
    assert alarms(outcome) == {"status": "The head's run fails: Newton failed."}
    other = compared(Fake(**failed), Fake())
    assert not other.worse and other.findings[0].notes == ("The base's run fails: Newton failed.",)


def test_a_head_that_cannot_run_or_hangs_in_either_round_is_red(compared: Any) -> None:
    for broken in (Fake(why="AttributeError: no kepler"), Fake(hangs=True)):
        outcome = compared(Fake(), broken)
        assert alarms(outcome)["status"].startswith("The head cannot run it: ")
        assert math.isnan(outcome.findings[0].growth)
    outcome = compared(Fake(), Fake(1.3), again=Fake(hangs=True))
    assert alarms(outcome) == {"status": f"The head cannot run it: {HANGS}"}


def test_a_benchmark_that_the_base_lacks_is_not_compared(compared: Any) -> None:
    outcome = compared(Fake(why="AttributeError: nothing"), Fake())
    assert not outcome.worse and not outcome.findings[0].compared
    assert "Nothing of head could be compared with base" in str(outcome)


def test_rounding_is_not_timed(compared: Any) -> None:
    outcome = compared(Fake(), Fake(3.0), cases=(replace(CASE, kind=ROUND_OFF),))
    assert not outcome.worse and math.isnan(outcome.findings[0].growth)


def test_a_benchmark_may_ask_for_a_larger_size(compared: Any) -> None:
    lax = replace(CASE, slower=0.5)
    outcome = compared(Fake(), Fake(1.3), cases=(lax, OTHER))
    assert [finding.name for finding in outcome.worse] == ["other"]


def test_a_truth_that_is_not_known_leaves_the_other_gates() -> None:
    pair = Pair(CASE, {"base": Fake().run(CASE), "head": Fake().run(CASE)})
    (finding,) = judge([pair], {"orbit": "no engine."})
    assert finding.compared and finding.notes == ("Its error is not known: no engine.",)
    assert math.isnan(finding.errors[1]) and finding.alarms == {}


def test_markdown_has_the_sentence_the_table_and_the_alarms(compared: Any) -> None:
    text = summary(compared(Fake(), Fake(1.3), cases=(CASE, OTHER)), {"commit": "c"})
    lines = text.splitlines()
    assert lines[0].startswith("**head is worse than base in 2 of 2 benchmarks: orbit (time)")
    columns = "benchmark | time | p | visible from | counts | error | ends moved | verdict"
    assert lines[2].split() == ["|", *columns.split(), "|"]
    assert sum(line.startswith("| orbit ") for line in lines) == 1
    assert any(line.startswith("- orbit: slower by ") for line in lines)
    assert lines[-1] == "commit: c"
