"""A user's integrators are found, checked and run."""

from __future__ import annotations

import sys
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest

import galvi
from benchmarks.applications.external.loading import ContenderError, load_class
from benchmarks.applications.external.timed_run import TimedRun
from benchmarks.applications.external.validation import valid_run
from benchmarks.applications.external.worker import settings
from benchmarks.statistics.timing import interleaved, warmed
from benchmarks.work_precision.galvi_methods import gauss_collocation


class Whole:
    name = "whole"

    def supports(self, problem):
        return True

    def run(self, problem, duration, setting):
        raise NotImplementedError


class Nameless(Whole):
    name = ""


class Ours(Whole):
    name = "galvi, improved"


class Lines(Whole):
    name = "two\nlines"


class Marked(Whole):
    name = "a <b>bold</b> one"


class Lacking:
    name, supports = "lacking", True


class Stubborn(Whole):
    def __init__(self):
        raise OSError("no licence")


NAMES_OF_OTHERS = ["=1+1", "@SUM(A1)", "+a", "-a", " =1", "\uff1d1", "\x1b[31mred", "\u202ea",
                   "a\x00", "REBOUND IAS15", "rebound  ias15", "REBOUND IAS15, GLOBAL", "heyoka",
                   "Galvi, improved", " galvi"]  # fmt: skip


@pytest.mark.parametrize("name", NAMES_OF_OTHERS)
def test_a_name_that_is_a_formula_or_another_code_s_is_refused(module, monkeypatch, name):
    monkeypatch.setattr(Whole, "name", name)
    with pytest.raises(ContenderError, match="that no other code of the suite has; received") as no:
        load_class("outside_module:Whole")
    assert str(no.value).isprintable()


@pytest.mark.parametrize("name", ["my REBOUND IAS15", "IAS15", "a = b", "x-1", "heyoka's way"])
def test_a_name_that_only_reminds_of_one_is_taken(module, monkeypatch, name):
    monkeypatch.setattr(Whole, "name", name)
    assert load_class("outside_module:Whole").name == name


@pytest.fixture
def module(monkeypatch):
    """Contenders, and none, in a module of their own."""
    made = ModuleType("outside_module")
    for thing in (Whole, Nameless, Ours, Lines, Marked, Lacking, Stubborn):
        setattr(made, thing.__name__, thing)
    monkeypatch.setitem(sys.modules, made.__name__, made)


@pytest.mark.parametrize(
    ("path", "said"),
    [
        ("Whole", "named package.module:Class; received 'Whole'"),
        ("outside_module:", "named package.module:Class"),
        ("outside modul:Whole", "named package.module:Class"),
        ("outside_module.Whole", "did you mean 'outside_module:Whole'?"),
        ("./outside_module.py:Whole", "did you mean 'outside_module:Whole'?"),
        ("outside_module.py", "did you mean 'outside_module:Class'?"),
        (
            "benchmarks.outside:Whole",
            "'benchmarks' is here a package of galvi's own.* and name outside:Whole$",
        ),
        ("outside_module:Zebra", "has no 'Zebra'$"),
        ("outside_module:Lines", r"words in one line, .* received 'two\\nlines'"),
        ("outsid_module:Whole", "no module 'outsid_module' to take Whole from"),
        ("outside_module:Hole", "has no 'Hole'; did you mean 'Whole'"),
        ("outside_module:Lacking", "lacks 'supports' and 'run'; a contender has name"),
        ("outside_module:Nameless", "do not begin with 'galvi'.* received ''"),
        ("outside_module:Marked", "none of <>.*received 'a <b>bold</b> one'"),
        ("outside_module:Ours", "received 'galvi, improved'"),
        ("outside_module:Stubborn", r"Stubborn\(\) raised OSError: no licence"),
    ],
)
def test_a_path_that_leads_to_no_contender_is_answered_in_a_sentence(module, path, said):
    assert load_class("outside_module:Whole").name == "whole"
    with pytest.raises(ContenderError, match=said):
        load_class(path)


ORBIT = galvi.problems.kepler(0.6)


def finished(**parts):
    """What a run on ORBIT for {"samples": 2} over 1 should be, with some parts replaced."""
    t, q, p = np.array([0.0, 0.5, 1.0]), np.array([ORBIT.q0] * 3), np.array([ORBIT.p0] * 3)
    return galvi.Trajectory(**{"problem": ORBIT, "t": t, "q": q, "p": p, **parts})


@pytest.mark.parametrize(
    ("parts", "said"),
    [
        ({"q": np.zeros((3, 5))}, r"q must have the shape \(3, 2\); received \(3, 5\)"),
        ({"p": np.zeros(3)}, r"p must have the shape \(3, 2\); received \(3,\)"),
        ({"q": np.full((3, 2), np.nan)}, "says that it succeeded, and its states are not finite"),
        ({"t": np.array([0.0, 0.5, 1.1])}, "times must be the 3 from 0 to 1 .* received 3 from 0"),
        ({"t": np.array([0.0, 1.0])}, "received 2 from 0 to 1"),
        ({"t": np.array(1.0)}, "received an array of shape"),
        ({"q": "far away"}, "Its q must be an array of real numbers; received <U8"),
        ({"q": np.ones((3, 2)) + 0j}, "Its q must be an array of real numbers; received complex"),
        ({"t": np.arange(3) / 2 + 0j}, "Its t must be an array of real numbers; received complex"),
        ({"counts": {"steps": "many"}}, "counts must be whole numbers by their names; received"),
    ],
)
def test_a_run_of_another_shape_or_time_is_refused(parts, said):
    good = valid_run(finished(), ORBIT, 1.0, {"samples": 2})
    assert good["success"] and good["q"].shape == (3, 2)
    with pytest.raises(ContenderError, match=said):
        valid_run(finished(**parts), ORBIT, 1.0, {"samples": 2})


def test_settings_are_plain_and_say_at_which_times_a_run_has_states():
    def offering(**setting):
        return SimpleNamespace(settings=lambda problem, duration: [setting])

    assert settings(offering(step=np.float64(0.5), save_every=np.int64(2)), ORBIT, 1.0, 100) == [
        {"step": 0.5, "save_every": 2}
    ]
    with pytest.raises(ContenderError, match="x is a SimpleNamespace"):
        settings(offering(samples=2, x=SimpleNamespace()), ORBIT, 1.0, 100)
    with pytest.raises(ContenderError, match=r"step must be a positive number; received -0\.5"):
        settings(offering(step=-0.5), ORBIT, 1.0, 100)
    with pytest.raises(ContenderError, match="must say at which times a run has states"):
        valid_run(finished(), ORBIT, 1.0, {"step": 0.5, "save_every": "often"})


def test_a_run_that_says_it_failed_says_why_and_may_hold_nan():
    with pytest.raises(ContenderError, match="its status does not say why"):
        valid_run(finished(success=False, status=" "), ORBIT, 1.0, {"samples": 2})
    parts = {"q": np.full((3, 2), np.nan), "success": False, "status": "Too long a step."}
    assert valid_run(finished(**parts), ORBIT, 1.0, {"samples": 2})["status"] == "Too long a step."


def test_its_clock_is_its_own_and_a_failure_between_rounds_leaves_no_time():
    answers = iter([2.0, 1e-3, 1e-3])  # seconds; then it is gone
    failures = []

    def ask(repeats):
        for seconds in answers:
            return {name: np.zeros(1) for name in "tqp"}, seconds
        raise ContenderError("Gone.")

    call = TimedRun("answers", ORBIT, 1.0, {"samples": 1}, ask, failures.append)
    found, seconds = warmed(call)
    assert found.success and seconds == 2.0
    (timing,) = interleaved([call], 3, 1e-3, [1e-3])
    assert np.isnan(timing.seconds) and call.failure == "Gone."
    assert list(map(str, failures)) == ["Gone."]


def test_settings_reach_the_integrator_and_wrong_ones_are_refused() -> None:
    problem, contender = galvi.problems.kepler(0.3), gauss_collocation(4)
    newton = contender.run(problem, 1.0, {"step": 0.5, "solver": "newton"})
    assert newton.counts["hessian_evaluations"] > 0
    backwards = contender.run(problem, -1.0, {"step": -0.5})
    assert backwards.t.tolist() == [0.0, -0.5, -1.0]
    with pytest.raises(ValueError, match="Did you mean 'step'"):
        contender.run(problem, 1.0, {"stp": 0.5})
    with pytest.raises(ValueError, match="whole number of steps"):
        contender.run(problem, 1.0, {"step": 0.3})
