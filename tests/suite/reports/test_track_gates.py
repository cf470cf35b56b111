"""The gates of a comparison, on fake samples: what goes red, with which words, what does not."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import replace
from itertools import chain, repeat
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

from benchmarks.timings.case import LONG, ROUND_OFF, TRAJECTORY, Case
from reports.tracking import against
from reports.tracking.against import compare
from reports.tracking.checkouts import Checkout
from reports.tracking.gates import GATES, judge
from reports.tracking.outcome import Outcome, as_json, as_junit, summary
from reports.tracking.rounds import Pair
from reports.tracking.worker import Failed

CASE = Case("orbit", TRAJECTORY, "kepler", 4, 4, 0.1, 10, rounding=1e-14)
OTHER = replace(CASE, name="other")
COUNTS = {"steps": 10, "iterations": 50, "force_evaluations": 200}
HANGS = "It gave no answer within 600 seconds and was ended."


class Fake:
    """A process with these times, and what its first call reaches; fails where it says so."""

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
        reached |= {"first_call": 1.0, "warm": 0.01, "problem": {}, "offered": ""}
        return reached | {"memory": math.nan, "need": math.nan} | self.reached

    def time(self, case: Case, repeats: int, attempts: int) -> float:
        if self.hangs:
            raise Failed(HANGS)
        self.samples += 1
        return self.factor * (1.0 + 0.01 * float(self.random.standard_normal()))


class Processes(AbstractContextManager["Processes"]):
    """A worker of these processes, one after the other."""

    def __init__(self, fakes: Iterator[Fake]) -> None:
        self.fakes = fakes
        self.stop()

    def __exit__(self, *error: object) -> None:
        return None

    def stop(self) -> None:
        self.process = next(self.fakes)
        self.run, self.time = self.process.run, self.process.time


@contextmanager
def studies(name: str, title: str) -> Iterator[Any]:
    yield lambda text: None


@pytest.fixture
def compared(monkeypatch: pytest.MonkeyPatch) -> Any:
    """Compare two fakes; `again` is the head of the later rounds, `base_again` the base."""

    def do(
        base: Fake,
        head: Fake,
        again: Fake | None = None,
        cases: Any = (CASE,),
        base_again: Fake | None = None,
    ) -> Outcome:
        fakes = {"base": (base, base_again or base), "head": (head, again or head)}

        def worker(checkout: Checkout, limit: float) -> Processes:
            first, later = fakes[checkout.commit]
            return Processes(chain([first], repeat(later)))

        monkeypatch.setattr(against, "Worker", worker)
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
    assert "(smallest detectable growth of a time: 11 %)" in str(outcome)
    assert outcome.table()["detectable from [%]"].tolist() == [11.0]


@pytest.mark.parametrize("factor", [1.15, 1.3, 2.0])
def test_a_slower_head_is_red_at_the_gate_of_time_alone(compared: Any, factor: float) -> None:
    outcome = compared(Fake(), Fake(factor))
    assert set(alarms(outcome)) == {"time"}
    assert "% slower (p = " in alarms(outcome)["time"] and "second round" in alarms(outcome)["time"]
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


class Elsewhere(Fake):
    """Each process reaches ends of its own, and the same in all its runs."""

    def __init__(self, process: int) -> None:
        super().__init__(ends=[[1.0 + 1e-9, 1e-15 * process]])


def test_a_head_whose_processes_differ_is_red_unless_those_of_the_base_do(compared: Any) -> None:
    """As where it depends on the hash of a text."""
    outcome = compared(Fake(), Elsewhere(0), again=Elsewhere(1))
    assert set(alarms(outcome)) == {"not deterministic"}
    assert "Runs of the head in two processes differ" in alarms(outcome)["not deterministic"]
    both = compared(Elsewhere(0), Elsewhere(0), Elsewhere(1), base_again=Elsewhere(1))
    assert not both.worse and "in two processes" in " ".join(both.findings[0].notes)


class Needing(Fake):
    """Each call needs so many bytes for a while."""

    def run(self, case: Case) -> dict[str, Any]:
        return super().run(case) | {"memory": 1e8, "need": self.reached["bytes_"]}


def test_a_head_that_needs_more_memory_for_a_while_is_red(compared: Any) -> None:
    said = alarms(compared(Needing(bytes_=1e6), Needing(bytes_=2e9)))
    assert said == {"memory": "A run needs up to 2000 MB, up from 1 MB."}
    assert not compared(Needing(bytes_=1e6), Needing(bytes_=30e6)).worse
    assert not compared(Needing(bytes_=math.nan), Needing(bytes_=2e9)).worse


THREE = tuple(replace(CASE, name=name, contender="a:B") for name in ("one", "two", "three"))


@pytest.fixture
def three(compared: Any, monkeypatch: pytest.MonkeyPatch) -> Any:
    """Compare three benchmarks of an integrator, without a long run."""
    monkeypatch.setattr(against, "long_runs", lambda *_: [])
    return lambda *fakes: compared(*fakes, cases=THREE)


def test_what_is_below_the_size_of_each_is_red_by_all_together(three: Any) -> None:
    outcome = three(Fake(), Fake(1.07))
    assert not outcome.worse and outcome.red
    assert "is slower than base in 3 benchmarks taken together. a:B: Its 3 timed" in str(outcome)
    assert json.loads(as_json(outcome, {}))["worse"] is True
    for base, head in ((Fake(), Fake(1.03)), (Fake(1.07), Fake())):
        assert not three(base, head).red


def test_times_that_are_red_one_by_one_need_no_further_rounds_together(three: Any) -> None:
    outcome = three(Fake(), Fake(1.3))
    assert len(outcome.worse) == 3 and len(outcome.together[0].growth) == 2
    assert "a:B (note): Its 3 timed benchmarks together are 30.0 % slower" in outcome.report()
    assert "did not confirm" not in outcome.report()


def test_what_later_rounds_do_not_confirm_of_all_together_is_a_note(three: Any) -> None:
    outcome = three(Fake(), Fake(1.07), Fake(1.02))
    assert not outcome.red
    assert "; further rounds did not confirm it." in outcome.report()


def test_two_benchmarks_are_too_few_to_be_taken_together(compared: Any) -> None:
    cases = THREE[:2]
    assert not compared(Fake(), Fake(1.07), cases=[replace(one, contender="") for one in cases]).red


def test_a_long_run_is_as_long_as_the_time_allows_and_sees_what_fails_late(compared: Any) -> None:
    class Late(Fake):
        def run(self, case: Case) -> dict[str, Any]:
            reached = super().run(case) | {"warm": self.reached["warm"]}
            if case.kind == LONG:
                assert case.setting == {"step": 0.1, "save_every": 10 * case.steps}
                reached["ends"] = [[math.nan, 0.0]]
            return reached

    mine = replace(
        CASE, contender="a:B", setting={"step": 0.1, "save_every": 10}, step=1.0, steps=1
    )
    outcome = compared(Fake(warm=1e-4), Late(warm=1e-4), cases=(mine,))
    assert [one.name for one in outcome.worse] == ["orbit, 10000 times as long"]
    slow = compared(Fake(warm=0.1), Fake(warm=0.1), cases=(mine,))
    assert slow.findings[1].name == "orbit, 100 times as long"
    assert slow.findings[1].notes == ("Shortened from 10000 times as long, to fit the time limit.",)
    slowest = compared(Fake(warm=8.0), Fake(warm=8.0), cases=(mine,))
    assert slowest.findings[0].notes == (
        "No long run was made, because this one already takes 8 s.",
    )


def test_a_head_whose_ends_are_not_finite_is_red_without_a_truth() -> None:
    lost = Fake(ends=[[math.nan, 0.0]])
    pair = Pair(CASE, {"base": [Fake().run(CASE)] * 2, "head": [lost.run(CASE)] * 2})
    (finding,) = judge([pair], {"orbit": "no engine."})
    assert set(finding.alarms) == {"error"}


def test_the_junit_file_has_a_case_for_each_gate_and_is_well_formed(
    compared: Any,
) -> None:
    hostile = replace(CASE, name="a <b> & \x1b ]]> é")
    outcome = compared(Fake(), Fake(why="<script>\x00 ]]>"), cases=(hostile, OTHER))
    root = ElementTree.fromstring(as_junit(outcome, "galvi track"))
    cases = root.findall("testsuite/testcase")
    assert {one.get("name") for one in cases} == set(GATES) and len(cases) == 2 * len(GATES)
    (failed, _) = root.findall("testsuite/testcase/failure")
    assert "The head cannot run it: <script>" in failed.get("message", "")


class Growing(Fake):
    """Each call leaves so many bytes; a worker makes two between its answers on the memory."""

    def __init__(self, bytes_: float) -> None:
        super().__init__()
        self.bytes_, self.whole = bytes_, 2e8

    def run(self, case: Case) -> dict[str, Any]:
        self.whole += 2.0 * self.bytes_
        return super().run(case) | {"memory": self.whole}


def test_a_leak_is_red_by_its_memory(compared: Any) -> None:
    said = alarms(compared(Growing(0.0), Growing(60e6)))
    assert said == {"memory": "Each run leaves 60 MB in memory, up from 0 MB."}
    assert not compared(Growing(0.0), Growing(2.5e6)).worse
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
    assert "; a second round did not confirm it." in outcome.findings[0].notes[0]


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
    "an error that rounding moves by more than its tolerance": (
        {"ends": [[1.0 + 2e-13, 0.0]]},
        {"ends": [[1.0 + 2.08e-13, 0.0]]},
        set(),
    ),
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
    assert counts == {"counts": "Iterations rose from 50 to 51 (+2 %)."}
    assert "The problem itself changed (acceleration)." in problem["problem"]


def test_a_count_that_one_side_lacks_is_a_note(compared: Any) -> None:
    outcome = compared(Fake(), Fake(counts={"steps": 10, "force_evaluations": 200, "passes": 9}))
    assert not outcome.worse and outcome.table()["more counts"].tolist() == [0.0]
    assert outcome.findings[0].notes == (
        "Only one side reports iterations, passes, which cannot be compared.",
    )


def test_a_base_whose_ends_are_not_finite_does_not_accuse_the_head(compared: Any) -> None:
    outcome = compared(Fake(ends=[[math.nan, 0.0]]), Fake())
    assert not outcome.worse and "errors cannot be compared" in outcome.findings[0].notes[0]


def test_a_run_that_fails_is_red_once_and_a_base_that_fails_is_a_note(compared: Any) -> None:
    failed = {"success": False, "status": "Newton failed.", "ends": [[math.nan, math.nan]]}
    outcome = compared(Fake(), Fake(**failed))
    assert alarms(outcome) == {"status": "The head's run failed: Newton failed."}
    other = compared(Fake(**failed), Fake())
    assert not other.worse and other.findings[0].notes == ("The base's run failed: Newton failed.",)


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
    pair = Pair(CASE, {"base": [Fake().run(CASE)] * 2, "head": [Fake().run(CASE)] * 2})
    (finding,) = judge([pair], {"orbit": "no engine."})
    assert finding.compared and finding.notes == ("Its error is unknown: no engine.",)
    assert math.isnan(finding.errors[1]) and finding.alarms == {}


def test_markdown_has_the_sentence_the_table_and_the_alarms(compared: Any) -> None:
    text = summary(compared(Fake(), Fake(1.3), cases=(CASE, OTHER)), {"commit": "c"})
    lines = text.splitlines()
    assert lines[0].startswith("**head is worse than base in 2 of 2 benchmarks: orbit (time)")
    columns = [column.strip() for column in lines[2].strip("|").split("|")]
    assert columns == [
        "benchmark", "time [%]", "p", "detectable from [%]", "more counts", "error of base",
        "error of head", "final state moved", "verdict",
    ]  # fmt: skip
    assert sum(line.startswith("| orbit ") for line in lines) == 1
    assert any(line.startswith("- orbit (time): It is ") for line in lines)
    assert lines[-1] == "commit: c"


def test_a_benchmark_that_fails_on_both_sides_is_not_compared(compared: Any) -> None:
    fails = {"success": False, "status": "It went astray."}
    outcome = compared(Fake(**fails), Fake(**fails))
    assert not outcome.findings[0].compared and "could be compared" in str(outcome)


def test_other_settings_of_the_base_are_noted(compared: Any) -> None:
    sides = (Fake(offered="{'step': 0.1}"), Fake(offered="{'step': 1.0}"))
    (note,) = compared(*sides).findings[0].notes
    assert "of the base is {'step': 0.1}, that of the head {'step': 1.0}" in note
