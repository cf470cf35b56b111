"""A user's integrators are found and checked, and leave nothing of their process behind."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections import OrderedDict
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest

import galvi
from benchmarks.applications.external import worker
from benchmarks.applications.external.check_problems import CHECK_PROBLEMS
from benchmarks.applications.external.checks import contender_checks
from benchmarks.applications.external.integrator import ExternalIntegrator
from benchmarks.applications.external.loading import ContenderError, load_class
from benchmarks.applications.external.timed_run import TimedRun
from benchmarks.applications.external.validation import valid_run
from benchmarks.applications.external.worker import settings
from benchmarks.statistics.timing import interleaved, warmed
from benchmarks.store.foreign_texts import log_line
from benchmarks.store.provenance import ROOT
from benchmarks.work_precision.galvi_methods import gauss_collocation
from tests.suite.benchmarks.contenders_at_hand import Gauss


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
    """Puts contenders, and classes that are none, into the module outside_module."""
    outside = ModuleType("outside_module")
    for contender in (Whole, Nameless, Ours, Lines, Marked, Lacking, Stubborn):
        setattr(outside, contender.__name__, contender)
    monkeypatch.setitem(sys.modules, outside.__name__, outside)


@pytest.mark.parametrize(
    ("path", "message"),
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
def test_a_path_that_leads_to_no_contender_is_answered_in_a_sentence(module, path, message):
    assert load_class("outside_module:Whole").name == "whole"
    with pytest.raises(ContenderError, match=message):
        load_class(path)


ORBIT = galvi.problems.kepler(0.6)


def finished(**parts):
    """A valid run of ORBIT for {"samples": 2} over 1 unit of time, with some parts replaced."""
    t, q, p = np.array([0.0, 0.5, 1.0]), np.array([ORBIT.q0] * 3), np.array([ORBIT.p0] * 3)
    return galvi.Trajectory(**{"problem": ORBIT, "t": t, "q": q, "p": p, **parts})


@pytest.mark.parametrize(
    ("parts", "message"),
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
def test_a_run_of_another_shape_or_time_is_refused(parts, message):
    good = valid_run(finished(), ORBIT, 1.0, {"samples": 2})
    assert good["success"] and good["q"].shape == (3, 2)
    with pytest.raises(ContenderError, match=message):
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
    run, seconds = warmed(call)
    assert run.success and seconds == 2.0
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


TROUBLE = """
import ctypes, multiprocessing, os, subprocess, sys, threading, time
from pathlib import Path
import numpy as np
import galvi

lock = multiprocessing.Lock()

def child():
    process = subprocess.Popen(["sleep", "60"])
    Path(__file__).with_name("pids").write_text(f"{os.getpid()} {process.pid}")

class Trouble:
    name = "trouble"

    def supports(self, problem):
        if problem.name == "unsure":
            raise RuntimeError("who knows")
        return True

    def run(self, problem, duration, setting):
        print("a line that is no part of any table")
        what = setting.get("what", "")
        if what == "sleeps":
            child()
            time.sleep(60.0)
        if what == "holds the interpreter":
            child()
            ctypes.PyDLL(None).sleep(60)
        if what == "dies":
            child()
            os._exit(3)
        if what == "exits":
            sys.exit("that is all")
        if what == "prints":
            for k in range(3000):
                print("::error::line", k, chr(27), flush=True)
            sys.stderr.write("##[error]" + "x" * 10**6)
        if what == "dies later":
            threading.Timer(0.2, os._exit, (4,)).start()
        t = problem.t0 + duration * np.arange(2)
        q, p = (np.array([start] * 2) for start in (problem.q0, problem.p0))
        return galvi.Trajectory(problem, t, q, p)

class Hashing(Trouble):
    def run(self, problem, duration, setting):
        run = super().run(problem, duration, {})
        saved = round(duration / setting["step"]) // setting["save_every"]
        t = problem.t0 + np.linspace(0.0, duration, saved + 1)
        q, p = (np.array([start] * len(t)) for start in (problem.q0, problem.p0))
        q[1:] += hash("a") * 1e-25
        return galvi.Trajectory(problem, t, q, p)

class Breaking(Trouble):
    def __init__(self):
        raise OSError("no licence")
"""
SCRIPT = """
import sys
import galvi
from benchmarks.applications.external.integrator import ExternalIntegrator

if __name__ == "__main__":
    external = ExternalIntegrator.open("trouble:Trouble")
    try:
        external.run(galvi.problems.kepler(0.6), 1.0, {"samples": 1, "what": sys.argv[1]})
    finally:
        external.close()
"""
needs_groups = pytest.mark.skipif(os.name != "posix", reason="there are no process groups")


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder of the contender's module, on the path of new processes."""
    (tmp_path / "trouble.py").write_text(TROUBLE)
    monkeypatch.syspath_prepend(str(tmp_path))
    return tmp_path


def still_running(folder: Path) -> list[int]:
    """Ids of the contender's process and its child that run after ten seconds; they are killed."""
    pids = [int(pid) for pid in (folder / "pids").read_text().split()]
    for _ in range(100):
        running = [pid for pid in pids if is_running(pid)]
        if not running:
            return []
        time.sleep(0.1)
    for pid in running:
        with suppress(ProcessLookupError):
            os.kill(pid, signal.SIGKILL)
    return running


def is_running(pid: int) -> bool:
    state = subprocess.run(["ps", "-o", "stat=", "-p", str(pid)], capture_output=True, text=True)
    return state.stdout.strip() not in ("", "Z", "Zs", "ZN")


def test_it_knows_where_its_class_begins_also_of_one_that_another_module_names(
    tmp_path, monkeypatch
):
    code = "\n\nclass It:\n    name = 'it'\n    def supports(self, p): pass\n    run = supports\n"
    (tmp_path / "src" / "inner").mkdir(parents=True)
    (tmp_path / ".git").mkdir()
    (tmp_path / "src" / "inner" / "__init__.py").write_text("from inner.it import It\nit = It()\n")
    (tmp_path / "src" / "inner" / "it.py").write_text(code)
    dynamic_code = "It = type('It', (), {'name': 'it', 'supports': print, 'run': print})\n"
    (tmp_path / "made.py").write_text(dynamic_code)
    for folder in (tmp_path, tmp_path / "src"):
        monkeypatch.syspath_prepend(str(folder))
    monkeypatch.chdir(tmp_path / "src")
    definition = "src/inner/it.py", 3
    elsewhere = tmp_path.parent / f"{tmp_path.name}-site-packages"
    elsewhere.mkdir()
    (elsewhere / "installed.py").write_text(code)
    monkeypatch.syspath_prepend(str(elsewhere))
    nowhere = "", 0
    for path, expected in (
        ("inner:It", definition),
        ("inner:it", definition),
        ("made:It", nowhere),
        ("installed:It", nowhere),
    ):
        external = ExternalIntegrator.open(path)
        external.close()
        assert external.defined_at == expected


@pytest.mark.slow(beside="test_after_two_answers_that_were_late_it_is_not_asked_again")
def test_one_that_hangs_dies_or_exits_is_a_sentence_and_the_next_run_goes_on(
    folder: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    external = ExternalIntegrator.open("trouble:Trouble", limit=20.0)

    def run(action: str = "", limit: float = 20.0, is_trial: bool = False) -> galvi.Trajectory:
        external.limit = limit
        return external.timed(ORBIT, 1.0, {"samples": 1, "what": action}, is_trial=is_trial)()

    try:
        assert run().success
        for action, is_trial in (("sleeps", True), ("holds the interpreter", False)):
            hung = run(action, 1.0, is_trial)
            assert hung.status == "It did not answer within 1 s, and was stopped."
            assert np.isnan(hung.q).all() and hung.q.shape == (2, 2) and not hung.success
            assert still_running(folder) == []
            assert run().success
        assert (
            run("dies").status == "Its process ended, with status 3."
            and still_running(folder) == []
        )
        assert run("exits").status == "It raised SystemExit: that is all."
        assert run("dies later").success
        time.sleep(1.0)
        assert run().status.startswith("Its process ended") and run().success
        assert external.supports(replace(ORBIT, name="unsure")) is False
        assert external.faults[-1] == (
            "trouble, unsure, asked whether it supports the problem: "
            "It raised RuntimeError: who knows."
        )
    finally:
        external.close()
    printed = capfd.readouterr()
    assert printed == ("", "")
    assert external.printed.first[0] == "a line that is no part of any table"


def test_what_it_prints_is_counted_and_its_first_lines_are_kept_without_commands(
    folder: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    external = ExternalIntegrator.open("trouble:Trouble")
    try:
        assert external.run(ORBIT, 1.0, {"samples": 1, "what": "prints"}).success
    finally:
        external.close()
    assert capfd.readouterr() == ("", "")
    printed = external.printed
    assert printed.lines == 3002 and len(printed.first) == 20
    assert printed.first[1] == r": :error: :line 0 \x1b"
    assert printed.sentence() == (
        'printed 3,002 lines, the first of them "a line that is no part of any table".'
    )
    assert log_line("##[error]" + 10**6 * "x") == "# #[error]" + 188 * "x" + "..."


def test_after_two_answers_that_were_late_it_is_not_asked_again(folder: Path) -> None:
    external = ExternalIntegrator.open("trouble:Trouble", limit=20.0)
    external.limit = 1.0
    try:
        for _ in range(2):
            late = external.run(ORBIT, 1.0, {"samples": 1, "what": "sleeps"})
            assert late.status.startswith("It did not answer within 1 s")
        begin = time.monotonic()
        for action in ("sleeps", ""):
            assert external.run(ORBIT, 1.0, {"samples": 1, "what": action}).status == (
                "It was not asked: 2 answers before took longer than 1 s. Give a longer "
                "--timeout, in seconds, if it is only slow."
            )
        assert not external.supports(ORBIT) and time.monotonic() - begin < 0.5
    finally:
        external.close()


def test_problems_that_it_is_not_asked_about_any_more_are_one_sentence() -> None:
    external = ExternalIntegrator("m:Late", name="late")
    external._late[False] = 2
    assert not external.run(CHECK_PROBLEMS[0].problem, 5.0, {"step": 0.5}).success
    for check in CHECK_PROBLEMS:
        assert not external.supports(check.problem)
    assert not external.run(CHECK_PROBLEMS[1].problem, 5.0, {"step": 0.5}).success
    (fault,) = external.faults
    assert fault.startswith(f"late, {CHECK_PROBLEMS[0].problem.name} and 1 more, T = 5, step=0.5")
    assert "It was not asked: 2 answers before took longer than 60 s." in fault
    assert not any(external.faults_on(check.problem) for check in CHECK_PROBLEMS[2:])


def test_a_failure_that_it_words_like_a_request_that_was_not_made_is_a_fault_of_its_own() -> None:
    external = ExternalIntegrator("m:Late", name="late")
    for check in CHECK_PROBLEMS[:2]:
        external.add_fault(check.problem, "T = 5", "It was not asked for a step.")
    assert len(external.faults) == 2 and external.only_unasked == ""


class Text(str):
    def __str__(self) -> str:
        return self

    def __repr__(self) -> str:
        raise RuntimeError("no words")


class Count(int):
    pass


class Number(float):
    pass


class Array(np.ndarray):
    pass


class Refused(ContenderError):
    def __str__(self) -> str:
        return Text("not this one")


class Typed(Gauss):
    """Every value that it returns is of a class of its own."""

    name, order = Text("typed"), Number(4.0)
    conserves = {Text("energy"): Number(0.5)}  # noqa: RUF012

    def supports(self, problem: galvi.Problem) -> bool:
        raise Refused

    def settings(self, problem: galvi.Problem, duration: float) -> list[Any]:
        return [OrderedDict({Text("step"): np.float64(0.5), Text("save_every"): 10})]

    def claimed_error(self, problem: galvi.Problem, duration: float, setting: Any) -> float:
        return Number(0.5)

    def run(self, problem: galvi.Problem, duration: float, setting: Any) -> galvi.Trajectory:
        run = super().run(problem, duration, setting)
        status, counts = Text("done"), OrderedDict({Text("steps"): Count(10)})
        t, q, p = (x.view(Array) for x in (run.t, run.q, run.p))
        return galvi.Trajectory(problem, t, q, p, status=status, counts=counts)


def types_in(value: Any) -> set[type]:
    """The types of a value and of all that it holds."""
    inside: Iterable[Any] = ()
    if isinstance(value, Mapping):
        inside = (*value, *value.values())
    elif isinstance(value, tuple | list):
        inside = value
    return {type(value)}.union(*map(types_in, inside))


def test_nothing_of_its_classes_comes_back_from_its_process(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(worker, "contender_at", lambda path: Typed())
    arguments = ORBIT, 5.0, {"step": 0.5, "save_every": 10}
    answers = {
        "metadata": worker.answer("m:Typed", "metadata"),
        "settings": worker.answer("m:Typed", "settings", ORBIT, 5.0, 100),
        "claimed error": worker.answer("m:Typed", "claimed error", *arguments),
        "timed run": worker.answer("m:Typed", "timed run", *arguments),
    }
    plain = {str, int, float, bool, dict, list, tuple, np.ndarray}
    assert {name: types_in(value) - plain for name, value in answers.items()} == {
        name: set() for name in answers
    }
    with pytest.raises(ContenderError, match="not this one") as caught:
        worker.answer("m:Typed", "supports", ORBIT)
    assert type(caught.value) is ContenderError and types_in(caught.value.args) == {tuple, str}


def test_a_result_that_depends_on_the_process_is_not_deterministic(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("PYTHONHASHSEED", raising=False)
    external = ExternalIntegrator.open("trouble:Hashing", 60.0)
    try:
        (claim,) = contender_checks([external], CHECK_PROBLEMS[:1])
        rows = claim.check(claim.study(galvi.Galerkin, True, lambda sentence: None))
    finally:
        external.close()
    measured = {row.quantity.partition(",")[0]: row.measured for row in rows}
    assert measured["difference of two equal runs"] == 0.0
    assert measured["difference of equal runs of two processes"] > 0.0


def test_one_that_cannot_be_made_is_a_sentence_and_no_process_stays(folder: Path) -> None:
    with pytest.raises(ContenderError, match=r"Breaking\(\) raised OSError: no licence"):
        ExternalIntegrator.open("trouble:Breaking")


def client(folder: Path, action: str) -> subprocess.Popen[str]:
    """A process that runs the contender."""
    path = os.pathsep.join((str(folder), str(ROOT)))
    return subprocess.Popen(
        [sys.executable, "-c", SCRIPT, action],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | {"PYTHONPATH": path},
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )


@pytest.mark.slow_cases("2")
@needs_groups
@pytest.mark.parametrize(
    "how",
    [signal.SIGINT, signal.SIGKILL, pytest.param(signal.SIGTERM, marks=pytest.mark.slow)],
)
def test_when_we_are_stopped_it_goes_and_what_it_started(folder: Path, how: int) -> None:
    process = client(folder, "sleeps")
    for _ in range(600):
        if (folder / "pids").exists() and (folder / "pids").read_text().count(" "):
            break
        time.sleep(0.1)
    process.send_signal(how)
    errors = process.communicate(timeout=60.0)[1]
    assert process.returncode != 0 and still_running(folder) == []
    assert ("KeyboardInterrupt" in errors) is (how == signal.SIGINT)
