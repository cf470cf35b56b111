"""Checks that the pytest plugin runs one by one have the outcomes of `verify`."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest

from benchmarks.applications.external import served_checks
from benchmarks.applications.external.checks import CHECKS, FAILURES
from benchmarks.applications.external.integrator import MOST_LATE_ANSWERS, ExternalIntegrator
from benchmarks.applications.external.loading import ContenderError, NotAsked
from benchmarks.applications.external.own_check_problems import own_check_problem
from benchmarks.applications.external.served_checks import ServedChecks, outcome
from tests.suite.benchmarks.contenders_at_hand import (
    BROKEN,
    ORBIT,
    SWING,
    Altered,
    Bare,
    Choosy,
    Drifting,
    Gauss,
    Inside,
    OneSided,
    Raising,
    Unseen,
    Unsure,
    WithoutLongRuns,
    WithoutSteps,
    checked,
    mirrored,
    unseeded,
)

SHORT = replace(ORBIT, long=20.3)
PROBLEMS = """
import numpy as np

import galvi


def potential(q):
    return 1e12 * (q[0] ** 4 / 4e44 + q[1] ** 2 / 2e22)


def gradient(q):
    return 1e12 * np.array([q[0] ** 3 / 1e44, q[1] / 1e22])


def spring():
    system = galvi.Canonical(1.0, potential, gradient)
    return galvi.Problem(system, [1e11, 3e10], [0.0, 2e5]), 1e6


def logarithm(q):
    return np.log(0.04 + q @ q) / 2


def pull(q):
    return q / (0.04 + q @ q)


def drag(q, v):
    return -0.001 * v


def galaxy():
    return galvi.Problem(galvi.Canonical(1.0, logarithm, pull), [1.0, 0.3], [0.1, 0.8]), 10.0


def damped():
    system = galvi.Canonical(1.0, logarithm, pull, force=drag)
    return galvi.Problem(system, [1.0, 0.3], [0.1, 0.8]), 10.0


def line():
    return galvi.problems.harmonic_oscillator(), 5.0


def local():
    return galvi.Problem(galvi.Canonical(1.0, lambda q: q @ q), [1.0], [0.0]), 1.0


def knotted():
    tree = galvi.Multibody
    return tree, 1.0
"""


@pytest.fixture
def serve(monkeypatch: pytest.MonkeyPatch) -> Any:
    """A function that returns {(check, problem): (outcome, text)} of a contender on these problems;
    of the check `only` alone, if it is given."""

    def served(
        contender: Any, *problems: Any, only: str = ""
    ) -> dict[tuple[str, str], tuple[str, str]]:
        external = Inside.of(contender)
        contender.printed = external.printed
        monkeypatch.setattr(served_checks, "CHECK_PROBLEMS", problems or (SHORT,))
        monkeypatch.setattr(ExternalIntegrator, "open", lambda path, limit: external)
        checks = ServedChecks(["inside:It"], [], 60.0)
        items = checks.items()
        assert {(item["contender"], item["name"]) for item in items} == {
            ("inside:It", external.name)
        }
        return {
            (item["check"], item["problem"]): checks.measured(item)
            for item in items
            if item["check"] == (only or item["check"])
        }

    return served


def failed(outcomes: dict[tuple[str, str], tuple[str, str]]) -> dict[str, str]:
    """The text of each check that failed."""
    return {check: text for (check, _), (end, text) in outcomes.items() if end == "failed"}


def test_a_sound_contender_passes_each_check_that_it_has(serve):
    contender = Gauss()
    contender.symmetric = True
    outcomes = serve(contender, SHORT, replace(SWING, long=20.3))
    assert failed(outcomes) == {}
    orbit, swing = ORBIT.problem.name, SWING.problem.name
    on_each_problem = {check.name for check in (FAILURES, *CHECKS)} - {
        "order",
        "declarations",
        "longest run",
        "restart half way",
    }
    assert {key: end for key, (end, _) in outcomes.items()} == {
        **{(check, name): "passed" for check in on_each_problem for name in (orbit, swing)},
        ("order", ""): "passed",
        ("declarations", ""): "passed",
        ("longest run", orbit): "passed",
    }


class Modest(OneSided):
    """It declares nothing to be conserved."""

    conserves: ClassVar[dict[str, float]] = {}


class Wrong(Modest):
    """Its order differs from the one that it declares."""

    name, order = "wrong", 2


@pytest.mark.parametrize(
    ("contender", "check", "sentence"),
    [
        (Wrong(), "order", "bound: 1.75, less two standard errors (0.25 at most), to 2.25"),
        (Altered(unseeded), "determinism", "bound: at most 0. Two runs that were asked for alike"),
        (Drifting(), "conservation", "without a drift"),
        (Modest(), "time reversal", "a run back returns to the start, but for rounding"),
    ],
    ids=lambda value: getattr(value, "name", None),
)
def test_a_planted_fault_fails_its_own_check_with_measured_value_and_bound(
    contender, check, sentence, serve, monkeypatch
):
    monkeypatch.setattr("benchmarks.applications.external.long_runs.LONGEST_RUN_STEPS", 3000)
    contender.symmetric = check == "time reversal"
    problem = replace(SWING, long=40.3) if check == "conservation" else SHORT
    failures = failed(serve(contender, problem))
    assert sentence in failures.pop(check)
    # A contender that drifts fails in its longest run too.
    assert set(failures) <= ({"longest run"} if check == "conservation" else set())


@pytest.mark.parametrize("broken", BROKEN, ids=lambda kind: kind.__name__)
def test_a_run_that_fails_fails_each_check_in_which_it_occurs(broken, serve):
    failures = failed(serve(broken()))
    assert {"runs and answers", "accuracy", "determinism", "conservation"} <= set(failures)
    assert all(BROKEN[broken] in failures[check] for check in ("runs and answers", "determinism"))


JUDGED = [Gauss(), Drifting(), Bare(), *map(Altered, (unseeded, mirrored))]


@pytest.mark.parametrize("contender", JUDGED, ids=lambda contender: type(contender).__name__)
def test_outcomes_are_the_verdicts_of_verify(contender, serve, monkeypatch):
    monkeypatch.setattr("benchmarks.applications.external.long_runs.LONGEST_RUN_STEPS", 3000)
    _, differing, _ = checked(contender, SHORT)
    failures = "\n".join(text for end, text in serve(contender).values() if end == "failed")
    assert {row.quantity for row in differing} == {
        line.partition(": measured")[0] for line in failures.splitlines()
    }


def test_what_is_not_run_is_skipped_with_the_reason(serve):
    outcomes = serve(WithoutSteps())
    end, reason = outcomes["order", ""]
    assert end == "skipped" and "offer settings with a `step`" in reason
    end, reason = outcomes["conservation", ORBIT.problem.name]
    assert end == "skipped" and reason.startswith("Not declared")
    assert outcome([])[0] == "skipped"


class Hanging(Gauss):
    """Its runs on one problem do not end."""

    def run(self, problem, duration, setting):
        if problem.name == ORBIT.problem.name:
            raise TimeoutError
        return super().run(problem, duration, setting)


def test_a_hang_is_red_where_it_hangs_and_items_that_are_not_asked_then_are_skipped(
    serve, monkeypatch
):
    ask = Inside._ask

    def impatient(self: Inside, question: str, *arguments: Any, is_trial: bool = False) -> Any:
        if self._late[is_trial] >= MOST_LATE_ANSWERS:
            raise NotAsked("Answers before took longer.")
        try:
            return ask(self, question, *arguments, is_trial=is_trial)
        except ContenderError as error:
            self._late[is_trial] += "TimeoutError" in str(error)
            raise

    monkeypatch.setattr(Inside, "_ask", impatient)
    outcomes = serve(Hanging(), SHORT, replace(SWING, long=20.3))
    orbit, swing = ORBIT.problem.name, SWING.problem.name
    assert {key for key, (end, _) in outcomes.items() if end == "failed"} == {
        ("runs and answers", orbit),
        ("determinism", orbit),
    }
    assert outcomes["runs and answers", swing][0] == "passed"
    for key in (("accuracy", orbit), ("accuracy", swing), ("order", ""), ("longest run", orbit)):
        assert outcomes[key] == ("skipped", "Answers before took longer.")


def test_a_long_run_that_fails_has_the_same_outcome_alone_and_after_other_items(serve):
    problem = replace(SWING, long=6.5)
    after = failed(serve(WithoutLongRuns(), problem))
    for check in ("conservation", "longest run"):
        only_check = failed(serve(WithoutLongRuns(), problem, only=check))
        assert (
            set(only_check) == {check}
            and "too long" in only_check[check]
            and "too long" in after[check]
        )


def test_what_an_integrator_prints_in_an_item_that_fails_is_shown(serve):
    class Noisy(Raising):
        printed: Any

        def run(self, problem, duration, setting):
            self.printed.lines += 1
            self.printed.first.append("no licence")
            return super().run(problem, duration, setting)

    failures = failed(serve(Noisy()))
    assert failures["runs and answers"].endswith(
        "It printed (lines: 1; the first are shown):\nno licence"
    )


def test_what_is_declared_has_to_be_seen_somewhere(serve):
    assert "problems that it supports" in failed(serve(Choosy()))["declarations"]
    assert "OSError: who knows" in failed(serve(Unsure()))["runs and answers"]
    assert "its angular momentum" in failed(serve(Unseen(), SHORT, SWING))["declarations"]


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """A module of problems."""
    name = f"problems_{tmp_path.name}"
    (tmp_path / f"{name}.py").write_text(PROBLEMS)
    monkeypatch.syspath_prepend(str(tmp_path))
    return name


def test_a_problem_of_ones_own_keeps_what_its_truth_keeps(folder):
    problems = {
        name: own_check_problem(f"{folder}:{name}") for name in ("galaxy", "damped", "spring")
    }
    assert problems["galaxy"].conserved == ("energy", "angular momentum")
    assert problems["damped"].conserved == () and problems["spring"].conserved == ("energy",)
    assert (
        problems["spring"].size == pytest.approx(1e11, rel=0.1) and problems["spring"].floor < 1e-9
    )
    assert own_check_problem(f"{folder}:line").ordered == np.inf
    truth = problems["galaxy"].states()
    assert truth.success and len(truth.t) == 3 and truth.t[-1] == 10.0


@pytest.mark.parametrize(
    ("name", "message"),
    [("local", "at the top level of their module"), ("knotted", "must return a galvi.Problem")],
)
def test_a_problem_that_cannot_be_checked_on_is_a_sentence(folder, name, message, monkeypatch):
    monkeypatch.setattr(ExternalIntegrator, "open", lambda path, limit: Inside.of(Gauss()))
    with pytest.raises(ContenderError, match=re.escape(message)):
        own_check_problem(f"{folder}:{name}")
    path = f"{folder}:{name}"
    with pytest.raises(ContenderError, match=f"^--galvi-problem {path}: "):
        ServedChecks(["inside:It"], [path], 60.0).items()


def test_the_order_is_seen_on_a_problem_of_ones_own_in_any_units(folder, serve):
    spring = own_check_problem(f"{folder}:spring")
    contender = OneSided()
    contender.conserves = {"energy": 0.1}
    contender.settings = lambda problem, duration: [
        {"step": duration / n, "save_every": n} for n in (500, 2000)
    ]
    assert failed(serve(contender, spring)) == {}
    contender.order = 2
    assert set(failed(serve(contender, spring))) == {"order"}
