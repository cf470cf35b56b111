"""The gates of a comparison, on fake samples: what goes red, with which words, what does not."""

from __future__ import annotations

import json
import math
import re
from contextlib import AbstractContextManager, contextmanager
from dataclasses import replace
from itertools import chain, repeat
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

from benchmarks.timings.case import LONG, ROUND_OFF, TRAJECTORY, Case
from reports.results.metrics import write_metrics
from reports.tracking import against
from reports.tracking.against import compare
from reports.tracking.checkouts import Checkout
from reports.tracking.gates import ERROR, GATES, TIME
from reports.tracking.head_metrics import head_metrics
from reports.tracking.junit_cases import as_junit, junit_cases
from reports.tracking.outcome import as_json, summary
from reports.tracking.worker import Failed
from tests.suite.reports import services

CASE = Case("orbit", TRAJECTORY, "kepler", 4, 4, 0.1, 10, rounding=1e-14)
OTHER = replace(CASE, name="other")
COUNTS = {"steps": 10, "iterations": 50, "force_evaluations": 200}


class Fake:
    """A stand-in for a worker's process: a call takes about `factor` seconds, a run returns
    `reached`; it raises Failed with the text `why`, or in `time` if it `hangs`.

    noise   by which its ends differ from run to run
    leaves  bytes that each call leaves; a worker makes two between its answers on the memory
    need    bytes that each call needs for a while
    """

    def __init__(
        self,
        factor=1.0,
        why="",
        hangs=False,
        scatter=0.01,
        noise=0.0,
        leaves=math.nan,
        need=0.0,
        **reached,
    ):
        self.factor, self.why, self.hangs, self.scatter = factor, why, hangs, scatter
        self.noise, self.leaves, self.need, self.reached = noise, leaves, need, reached
        self.random = np.random.default_rng(3)
        self.memory = 2e8

    def run(self, case):
        if self.why:
            raise Failed(self.why)
        self.memory += 2.0 * self.leaves
        end = 1.0 + 1e-9 + self.noise * self.random.standard_normal()
        reached = {"ends": [[end, 0.0]], "counts": COUNTS, "success": True, "status": "ok"}
        reached |= {"first_call": 1.0, "warm": 0.01, "problem": {}, "offered": ""}
        return reached | {"memory": self.memory, "need": self.need} | self.reached

    def time(self, case, repeats, attempts):
        if self.hangs:
            raise Failed("It gave no answer within 600 seconds and was ended.")
        return self.factor * float(np.exp(self.scatter * self.random.standard_normal()))


class Processes(AbstractContextManager["Processes"]):
    """A worker of these processes, one after the other."""

    def __init__(self, fakes):
        self.fakes = fakes
        self.stop()

    def __exit__(self, *error):
        return None

    def stop(self):
        self.process = next(self.fakes)
        self.run, self.time = self.process.run, self.process.time


@contextmanager
def studies(name, title):
    yield lambda text: None


def truth(case):
    if case.problem == "unknown":
        raise ValueError("no engine.")
    return [np.array([1.0, 0.0])]


Side = Fake | tuple[Fake, Fake]  # in the first round, and in further ones


@pytest.fixture
def compared(monkeypatch: pytest.MonkeyPatch):
    """A function that compares two fakes."""

    def compare_fakes(base, head, *cases):
        fakes = {"base": base, "head": head}

        def worker(checkout, limit):
            side = fakes[checkout.commit]
            first, later = side if isinstance(side, tuple) else (side, side)
            return Processes(chain([first], repeat(later)))

        monkeypatch.setattr(against, "Worker", worker)
        monkeypatch.setattr(against, "true_ends", truth)
        sides = Checkout(Path("b"), "base"), Checkout(Path("h"), "head")
        outcome = compare(*sides, cases or (CASE,), studies)
        json.loads(as_json(outcome, {}))
        return outcome

    return compare_fakes


NOT_FINITE = {"ends": [[math.nan, 0.0]]}
FAILED = {"success": False, "status": "Newton failed."} | NOT_FINITE
EXACT = {"ends": [[1.0, 0.0]]}
PROBLEM = {"start": [0.0, 1.0], "acceleration": [-1.0, 1e-17, math.nan]}
ABSENT = "AttributeError: no kepler"
# As if its result depended on the hash of a text: its ends differ between processes.
OTHER_PROCESS = Fake(), Fake(ends=[[1.0 + 1e-9, 1e-15]])
# (base, head, the gate that is red or "", pattern of the report, fields of the benchmark)
SITUATIONS: dict[str, tuple[Any, ...]] = {
    "a head slower by a seventh": (Fake(), Fake(1.15), "time", r"\(time\): It is 1.* % slower \(p"),
    "a head at half the speed": (Fake(), Fake(2.0), "time", " % in a second round"),
    "a head slower by five percent, where no second round is run": (
        Fake(),
        (Fake(1.05), Fake(hangs=True)),
        "",
        "not worse",
    ),
    "what a second round does not confirm": (
        Fake(),
        (Fake(1.3), Fake()),
        "",
        "; a second round did not confirm it",
    ),
    "a benchmark that asks for a larger size": (Fake(), Fake(1.3), "", "", {"slower": 0.5}),
    "rounding, which is not timed": (Fake(), Fake(3.0), "", "", {"kind": ROUND_OFF}),
    "a head that cannot run": (
        Fake(),
        Fake(why=ABSENT),
        "status",
        f"The head cannot run it: {ABSENT}",
    ),
    "a head that hangs": (Fake(), Fake(hangs=True), "status", "cannot run it: It gave no answer"),
    "a head that hangs in the second round": (
        Fake(),
        (Fake(1.3), Fake(hangs=True)),
        "status",
        "cannot run it: It gave no answer",
    ),
    "a base that lacks it": (Fake(why=ABSENT), Fake(), "", "not compared.*cannot be run. Base: "),
    "a head whose run fails": (
        Fake(),
        Fake(**FAILED),
        "status",
        "The head's run failed: Newton failed.",
    ),
    "a base whose run fails": (
        Fake(**FAILED),
        Fake(),
        "",
        "not compared.*The base's run failed: Newton failed.",
    ),
    "runs that fail on both sides": (Fake(**FAILED), Fake(**FAILED), "", "not compared"),
    "a head whose runs differ": (
        Fake(),
        Fake(noise=1e-13),
        "not deterministic",
        r"Two runs of the head differ by \d\S*e-1[34]",
    ),
    "sides whose runs differ": (
        Fake(noise=1e-13),
        Fake(noise=1e-13),
        "",
        "Two runs of the base differ by ",
    ),
    "a head whose processes differ": (
        Fake(),
        OTHER_PROCESS,
        "not deterministic",
        "Runs of the head in two processes differ",
    ),
    "sides whose processes differ": (
        OTHER_PROCESS,
        OTHER_PROCESS,
        "",
        "Runs of the base in two processes differ",
    ),
    "a leak": (
        Fake(leaves=0.0),
        Fake(leaves=60e6),
        "memory",
        "Each run leaves 60 MB in memory, up from 0 MB.",
    ),
    "a small leak": (Fake(leaves=0.0), Fake(leaves=2.5e6), "", ""),
    "a leak of both": (Fake(leaves=60e6), Fake(leaves=60e6), "", ""),
    "a leak beside a base that does not tell": (Fake(), Fake(leaves=60e6), "", ""),
    "more memory for a while": (
        Fake(need=1e6),
        Fake(need=2e9),
        "memory",
        "A run needs up to 2000 MB, up from 1 MB.",
    ),
    "little more memory for a while": (Fake(need=1e6), Fake(need=30e6), "", ""),
    "memory for a while that the base does not tell": (
        Fake(need=math.nan),
        Fake(need=2e9),
        "",
        "",
    ),
    "one more iteration": (
        Fake(),
        Fake(counts=COUNTS | {"iterations": 51}),
        "counts",
        r"Iterations rose from 50 to 51 \(\+2 %\).",
    ),
    "one more evaluation": (
        Fake(),
        Fake(counts=COUNTS | {"force_evaluations": 201}),
        "counts",
        "from 200 to 201",
    ),
    "one iteration less": (Fake(counts=COUNTS | {"iterations": 51}), Fake(), "", ""),
    "a count that one side lacks": (
        Fake(),
        Fake(counts={"steps": 10, "force_evaluations": 200, "passes": 9}),
        "",
        "Only one side reports iterations, passes, which cannot be compared.",
    ),
    "an error beyond its tolerance": (Fake(), Fake(ends=[[1.0 + 1.02e-9, 0.0]]), "error", "rose"),
    "an error within its tolerance": (Fake(), Fake(ends=[[1.0 + 1.005e-9, 0.0]]), "", ""),
    "a smaller error": (Fake(), Fake(ends=[[1.0 + 0.5e-9, 0.0]]), "", ""),
    "an error that is rounding": (Fake(**EXACT), Fake(ends=[[1.0, 9e-15]]), "", ""),
    "an error that rounding moves by more than its tolerance": (
        Fake(ends=[[1.0 + 2e-13, 0.0]]),
        Fake(ends=[[1.0 + 2.08e-13, 0.0]]),
        "",
        "",
    ),
    "an error above rounding": (Fake(**EXACT), Fake(ends=[[1.0, 2e-14]]), "error", "rose"),
    "an end that is not finite": (
        Fake(),
        Fake(**NOT_FINITE),
        "error",
        "head's final state is not fin",
    ),
    "an end that is not finite, without a truth": (
        Fake(),
        Fake(**NOT_FINITE),
        "error",
        "",
        {"problem": "unknown"},
    ),
    "a truth that is not known": (
        Fake(),
        Fake(),
        "",
        "Its error is unknown: no engine.",
        {"problem": "unknown"},
    ),
    "a base whose end is not finite": (Fake(**NOT_FINITE), Fake(), "", "errors cannot be compared"),
    "a force that the truth would hide": (
        Fake(ends=[[5.0, 0.0]], problem=PROBLEM),
        Fake(problem=PROBLEM | {"acceleration": [1.0, 0.0, math.nan]}),
        "problem",
        r"The problem itself changed \(acceleration\).",
    ),
    "a problem of another dimension": (
        Fake(problem=PROBLEM),
        Fake(ends=[[1.0, 0.0, 0.0]], problem=PROBLEM | {"start": [0.0, 1.0, 2.0]}),
        "problem",
        "changed",
    ),
    "a force that was rounded otherwise": (
        Fake(problem=PROBLEM),
        Fake(problem={"acceleration": [-1.0 - 2e-16, -1e-17, math.nan], "more": [1.0]}),
        "",
        "",
    ),
    "other settings of the base": (
        Fake(offered="{'step': 0.1}"),
        Fake(offered="{'step': 1.0}"),
        "",
        "of the base is {'step': 0.1}, that of the head {'step': 1.0}",
    ),
}


@pytest.mark.parametrize("situation", SITUATIONS)
def test_a_change_is_red_at_its_gate_alone(compared, situation):
    base, head, gate, pattern, *case_fields = SITUATIONS[situation]
    outcome = compared(base, head, *(replace(CASE, **fields) for fields in case_fields))
    (finding,) = outcome.findings
    assert list(finding.alarms) == ([gate] if gate else [])
    assert re.search(pattern, outcome.report(), re.S)
    assert finding.compared == ("not compared" not in pattern)
    assert finding.compared or "Nothing of head could be compared with base" in str(outcome)


def test_equal_sides_are_green_in_one_sentence(compared):
    outcome = compared(Fake(), Fake())
    assert str(outcome).startswith("head is not worse than base in 1 benchmark: ")
    assert outcome.findings[0].moved == 0.0
    assert "(smallest detectable growth of a time: 11 %)" in str(outcome)
    assert outcome.table()["detectable from [%]"].tolist() == [11.0]


def test_with_times_that_scatter_by_a_third_only_a_large_growth_could_be_seen(
    compared,
):
    assert 0.2 < compared(Fake(scatter=0.33), Fake(scatter=0.33)).findings[0].visible < 3.0


MINE = replace(CASE, contender="a:B")


@pytest.mark.parametrize(
    ("base", "head", "red", "message"),
    [
        (Fake(), Fake(1.07), True, "head is slower than base in 3 benchmarks taken together. a:B:"),
        (Fake(), Fake(1.03), False, "not worse"),
        (Fake(1.07), Fake(), False, "not worse"),
        (Fake(), (Fake(1.07), Fake(1.02)), False, "; further rounds did not confirm it."),
        (Fake(), Fake(1.3), True, "(note): Its 3 timed benchmarks together are 30.0 % slower"),
    ],
)
def test_what_is_below_the_size_of_each_is_red_by_all_together(
    compared, monkeypatch, base, head, red, message
):
    """Times that are red one by one need no further rounds together."""
    monkeypatch.setattr(against, "long_runs", lambda *_: [])
    three = [replace(MINE, name=name) for name in ("one", "two", "three")]
    outcome = compared(base, head, *three)
    assert outcome.has_alarms == json.loads(as_json(outcome, {}))["worse"] == red
    assert message in f"{outcome} {outcome.report()}"
    assert not compared(base, head, *three[:2]).together


@pytest.mark.parametrize(
    ("warm", "times", "note"),
    [
        (1e-4, 10_000, None),
        (0.1, 100, "Shortened from 10000 times as long, to fit the time limit."),
        (8.0, None, "No long run was made, because this one already takes 8 s."),
    ],
)
def test_a_long_run_is_as_long_as_the_time_allows_and_sees_what_fails_late(
    compared, warm, times, note
):
    class Late(Fake):
        def run(self, case):
            late = case.kind == LONG and case.setting["save_every"] == 10 * case.steps
            return super().run(case) | (NOT_FINITE if late else {})

    case = replace(MINE, setting={"step": 0.1, "save_every": 10}, step=1.0, steps=1)
    outcome = compared(Fake(warm=warm), Late(warm=warm), case)
    long = [f"orbit, {times} times as long"] if times else []
    assert [finding.name for finding in outcome.alarming] == long
    assert outcome.findings[-1].notes == ((note,) if note else ())


def test_the_junit_file_has_a_case_for_each_gate_and_is_well_formed(compared):
    hostile = replace(CASE, name="a <b> & \x1b ]]> é")
    outcome = compared(Fake(), Fake(why="<script>\x00 ]]>"), hostile, OTHER)
    root = ElementTree.fromstring(as_junit(outcome, junit_cases(outcome), "galvi track"))
    cases = root.findall("testsuite/testcase")
    assert {case.get("name") for case in cases} == set(GATES) and len(cases) == 2 * len(GATES)
    (failed, _) = root.findall("testsuite/testcase/failure")
    assert "The head cannot run it: <script>" in failed.get("message", "")


def test_track_xml_has_both_sides_the_bound_and_the_class_and_metrics_are_of_the_head(
    compared, tmp_path
):
    case = replace(CASE, contender="mine:It", defined_at=("src/mine.py", 7))
    outcome = compared(Fake(), Fake(1.3, ends=[[1.0 + 1e-6, 0.0]]), case)
    (tmp_path / "track.xml").write_text(as_junit(outcome, junit_cases(outcome), "galvi track"))
    cases = services.junit_cases(tmp_path / "track.xml")
    error, time, counts = (cases["orbit", gate] for gate in (ERROR, TIME, "counts"))
    assert (error["base"], error["head"], error["verdict"]) == ("1e-09", "1e-06", "worse")
    assert error["bound"] == "at most 1.01e-09" and error["at"] == ("src/mine.py", "7")
    assert time["results"] == ["Failure"] and time["bound"] == "at most 10.0 %"
    assert 25.0 < float(time["growth"].split()[0]) < 35.0 and float(time["p"]) < 1e-3
    assert counts["base"] == counts["head"] and "force evaluations 200" in counts["head"]
    write_metrics(tmp_path, "track", head_metrics(outcome))
    measured = services.bencher_metrics(tmp_path / "track-bencher.json")["orbit"]
    assert measured["error"]["value"] == pytest.approx(1e-6)
    assert measured["latency"]["value"] == pytest.approx(1.3e9, rel=0.05)
    assert measured["force-evaluations"] == {"value": 200.0} and "steps" not in measured


def test_a_head_that_fails_has_no_metrics(compared):
    for head in (Fake(**FAILED), Fake(why="no")):
        assert list(head_metrics(compared(Fake(), head))) == []


def test_markdown_has_the_sentence_the_table_and_the_alarms(compared):
    text = summary(compared(Fake(), Fake(1.3), CASE, OTHER), {"commit": "c"})
    assert text.startswith("**head is worse than base in 2 of 2 benchmarks: orbit (time), other")
    for line in ("| benchmark", "| orbit ", "| other ", "- orbit (time): It is ", "commit: c"):
        assert text.count(f"\n{line}") == 1
