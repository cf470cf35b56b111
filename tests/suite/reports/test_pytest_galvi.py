"""`pytest --galvi mine:It` in another project: items beside its own tests, in any layout."""

from __future__ import annotations

import importlib
import os
import re
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from xml.etree import ElementTree as tree

import pytest

from galvi import command

ROOT = Path(__file__).parents[3]
# A stand-in for galvi in tests of the plugin alone: it lists four items, and measures none.
ANSWERS = """
import json, os, signal, sys

ITEMS = [
    ("accuracy", "Kepler, e = 0.3"), ("conservation", "a::b [1/2]"), ("memory", "x"), ("order", ""),
]
ENDS = {
    "accuracy": ("passed", ""), "memory": ("skipped", "No steps are offered."),
    "order": ("failed", "order in the step: measured 2; bound: within 0.2 of 4. Declared."),
    "conservation": ("passed", ""),
}

def serve_checks():
    with open("pids", "a") as file:
        print(os.getpid(), file=file)
    asked = json.loads(sys.stdin.readline())
    for line in sys.stdin:
        request = json.loads(line)
        if "nowhere" in asked["contenders"][0]:
            answer = {"usage": "--galvi nowhere:It: there is no module 'nowhere'."}
        elif "do" in request:
            keys = ("contender", "name", "check", "problem")
            answer = {"items": [
                dict(zip(keys, (path, path.partition(":")[2], *item)))
                for path in asked["contenders"] for item in ITEMS
            ]}
        elif "Dying" in request["contender"]:
            raise SystemExit("out of memory")
        elif "Killed" in request["contender"]:
            os.kill(os.getpid(), signal.SIGKILL)
        else:
            answer = dict(zip(("outcome", "text"), ENDS[request["check"]]))
        print(json.dumps(answer), flush=True)
"""
TEST = "def test_ours():\n    pass\n"
IMPORTED = """
import sys

def test_nothing_of_galvi_is_imported():
    assert {"galvi", "numpy", "numba", "pandas", "subprocess"} & set(sys.modules) <= ALLOWED
"""
CONTENDERS = """
import numpy as np

import galvi


class Leapfrog:
    name, order, symmetric = "my leapfrog", 2, True
    conserves = {"energy": 1e-2}
    strength, weight = 1.0, 0.5

    def supports(self, problem):
        return type(problem.system) is galvi.Canonical

    def settings(self, problem, duration):
        return [{"step": duration / n, "save_every": n} for n in (200, 800)]

    def run(self, problem, duration, setting):
        h, every, q, v = setting["step"], setting["save_every"], problem.q0, problem.v0
        saved, w = [(q, v)], self.weight
        for k in range(round(duration / h)):
            q = q + w * h * v
            v = v + self.strength * h * problem.system.acceleration(q, problem.t0)
            q = q + (1.0 - w) * h * v
            saved += [(q, v)] if (k + 1) % every == 0 else []
        q, v = np.swapaxes(saved, 0, 1)
        t = problem.t0 + h * every * np.arange(len(q))
        return galvi.Trajectory(problem, t, q, problem.system.momentum(v))


class FirstOrder(Leapfrog):
    name, symmetric, weight = "first order", False, 0.4
    conserves = {}


class FalselySymmetric(Leapfrog):
    name, order, weight = "falsely symmetric", 1, 0.4
    conserves = {}


class Damped(Leapfrog):
    name, order, symmetric = "damped", None, False

    def run(self, problem, duration, setting):
        run = super().run(problem, duration, setting)
        lost = np.exp(-1e-3 * (run.t - problem.t0))[:, None]
        return galvi.Trajectory(problem, run.t, run.q, run.p * lost)


class Random(Leapfrog):
    name, symmetric = "random", False
    noise = np.random.default_rng()

    def run(self, problem, duration, setting):
        run = super().run(problem, duration, setting)
        p = run.p.copy()
        p[1:] *= 1.0 + 1e-14 * self.noise.standard_normal()
        return galvi.Trajectory(problem, run.t, run.q, p)


class Leaking(Leapfrog):
    name, kept = "leaking", []

    def run(self, problem, duration, setting):
        self.kept.append(np.ones(300_000))
        return super().run(problem, duration, setting)


class Bare:
    name = "bare"


def swing():
    return galvi.problems.planar_pendulum(rate=0.5), 10.0
"""


def project(folder, files=None):
    """A repository with these files and a test."""
    (folder / ".git").mkdir()
    for name, text in {"tests/test_ours.py": TEST, **(files or {})}.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return folder


def run(folder, *arguments, fake=False):
    """pytest with the plugin of this checkout, in a project without settings of galvi's."""
    path = [str(folder / "fake")] * fake + [str(ROOT)]
    variables = {"PYTHONPATH": os.pathsep.join(path), "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}
    inherited = {key: value for key, value in os.environ.items() if not key.startswith("PYTEST")}
    command = [sys.executable, "-P", "-m", "pytest", "-p", "reports.pytest_galvi", *arguments]
    return subprocess.run(
        command, cwd=folder, env=inherited | variables, capture_output=True, text=True
    )


@pytest.fixture
def faked(tmp_path):
    """A project beside the stand-in for galvi."""
    return project(tmp_path, {"fake/galvi/__init__.py": "", "fake/galvi/command.py": ANSWERS})


def still_running(folder):
    """Ids of the started processes that still run."""
    pids = [int(pid) for pid in (folder / "pids").read_text().split()]
    listed = subprocess.run(["ps", "-o", "pid=", *map(str, pids)], capture_output=True, text=True)
    return [int(pid) for pid in listed.stdout.split()]


IDS = [
    "galvi: It::accuracy, Kepler, e = 0.3",
    "galvi: It::conservation, a: :b [1/2]",
    "galvi: It::memory, x",
    "galvi: It::order",
]


def test_items_stand_beside_the_tests_and_a_failure_is_its_sentence(faked):
    completed = run(faked, "--galvi", "mine:It", "-v", "-rs", "--junitxml=out.xml", fake=True)
    assert completed.returncode == 1, completed.stdout + completed.stderr
    assert f"{IDS[0]} PASSED" in completed.stdout and f"{IDS[3]} FAILED" in completed.stdout
    assert f"{IDS[2]} SKIPPED (No steps are offered.)" in completed.stdout
    _, _, failure = completed.stdout.partition("= FAILURES =")
    assert "collected 5 items" in completed.stdout and "_ It: order _" in failure
    assert "\norder in the step: measured 2; bound: within 0.2 of 4. Declared.\n" in failure
    assert (
        "Traceback" not in failure and "check_items.py:" not in failure.partition("short test")[0]
    )
    cases = {
        f"{case.get('classname')}::{case.get('name')}": [part.tag for part in case]
        for case in tree.parse(faked / "out.xml").iter("testcase")
    }
    assert cases == {
        "tests.test_ours::test_ours": [],
        IDS[0]: [],
        IDS[1]: [],
        IDS[2]: ["skipped"],
        IDS[3]: ["failure"],
    }
    assert still_running(faked) == []


def listed(completed):
    assert completed.returncode == 0, completed.stdout + completed.stderr
    return [line for line in completed.stdout.splitlines() if "::" in line]


def test_words_select_and_the_last_failures_are_run_again(faked):
    contenders = ("--galvi", "mine:It", "--galvi", "mine:Other", "-q")
    assert listed(run(faked, *contenders, "--collect-only", "-k", "It", fake=True)) == IDS
    chosen = run(faked, *contenders, "--collect-only", "-k", "Other and conservation", fake=True)
    assert listed(chosen) == [IDS[1].replace("It", "Other")]
    assert "1/9 tests collected (8 deselected)" in chosen.stdout
    marked = run(faked, *contenders, "--strict-markers", "--collect-only", "-m", "galvi", fake=True)
    assert listed(marked) == [*IDS, *(name.replace("It", "Other") for name in IDS)]
    assert run(faked, *contenders, fake=True).returncode == 1
    assert listed(run(faked, *contenders, "--lf", "--collect-only", fake=True)) == [
        IDS[3],
        IDS[3].replace("It", "Other"),
    ]


def test_workers_share_the_items_beside_a_benchmark_and_with_warnings_as_errors(faked):
    (faked / "pytest.ini").write_text("[pytest]\nfilterwarnings = error\n")
    (faked / "tests/test_quick.py").write_text(
        "import sys\n\ndef test_quick(benchmark):\n    benchmark(int)\n"
        "    assert not {'galvi', 'numpy'} & set(sys.modules)\n"
    )
    options = ["-p", "xdist", "-p", "pytest_benchmark.plugin", "--galvi", "mine:It"]
    for workers in ("0", "2"):
        # with workers the benchmark plugin warns that it is off
        warnings = ["-p", "no:warnings"] if workers == "2" else []
        completed = run(faked, *options, *warnings, "-k", "not order", "-n", workers, fake=True)
        assert completed.returncode == 0 and "4 passed, 1 skipped" in completed.stdout, (
            completed.stdout
        )
    assert still_running(faked) == []


@pytest.mark.parametrize("workers", [[], ["-p", "xdist", "-n", "2"]], ids=["alone", "workers"])
def test_what_cannot_be_loaded_ends_the_run_with_a_sentence_and_status_4(faked, workers):
    completed = run(faked, "--galvi", "nowhere:It", *workers, fake=True)
    assert completed.returncode == 4
    assert completed.stderr.strip() == "ERROR: --galvi nowhere:It: there is no module 'nowhere'."
    assert still_running(faked) == []


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("Dying", "ended with status 1, at Dying, accuracy, Kepler, e = 0.3. out of memory"),
        pytest.param(
            "Killed",
            "ended by the signal 'Killed', at Killed, accuracy, Kepler, e = 0.3.",
            marks=pytest.mark.skipif(os.name != "posix", reason="signals are of POSIX"),
        ),
    ],
)
def test_a_process_that_ends_fails_the_item_with_its_last_words_and_others_go_on(
    faked, name, message
):
    options = ("--galvi", f"mine:{name}", "--galvi", "mine:It", "-k", "accuracy")
    completed = run(faked, *options, fake=True)
    assert completed.returncode == 1 and "1 failed, 1 passed" in completed.stdout
    assert message in completed.stdout


def test_a_package_of_the_suite_that_is_not_installed_is_named_with_the_remedy(tmp_path):
    absent = "raise ModuleNotFoundError(\"No module named 'pandas'\", name='pandas')\n"
    project(tmp_path, {"fake/pandas.py": absent})
    completed = run(tmp_path, "--galvi", "mine:It", fake=True)
    assert completed.returncode == 4
    assert "of which pandas is not installed. Install them: pip install 'galvi[suite]'." in (
        completed.stderr
    )


def test_a_module_that_is_missing_while_it_measures_is_no_package_of_the_suite(monkeypatch):
    def serve():
        raise ModuleNotFoundError("No module named 'mine'", name="mine")

    monkeypatch.setattr(command, "put_suite_first", lambda: None)
    monkeypatch.setattr(importlib, "import_module", lambda name: SimpleNamespace(serve=serve))
    with pytest.raises(ModuleNotFoundError, match="mine"):
        command.serve_checks()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--galvi-problem", "mine:swing"], "--galvi-problem needs an integrator: --galvi"),
        (["--galvi", "m:A", "--galvi-timeout", "-1"], "must be a positive, finite number"),
        (["--galvi", "m:A", "--galvi-timeout", "inf"], "number of seconds; received inf"),
    ],
)
def test_options_that_make_no_sense_are_a_sentence(tmp_path, options, message):
    completed = run(project(tmp_path), *options)
    assert completed.returncode == 4 and message in completed.stderr


def test_without_the_option_nothing_is_imported_and_nothing_changes(tmp_path):
    allowed = "ALLOWED = {name for name in ('subprocess',) if name in sys.modules}\n"
    without = run(project(tmp_path, {"tests/test_imports.py": IMPORTED + allowed}))
    assert without.returncode == 0 and "2 passed" in without.stdout, without.stdout


def failure_texts(folder, *arguments):
    """The texts of failed items, "" of others, by contender and check."""
    completed = run(folder, *arguments, "-q", "--junitxml=out.xml")
    assert completed.returncode in (0, 1), completed.stdout + completed.stderr
    cases = tree.parse(folder / "out.xml").iter("testcase")
    return {
        (
            case.get("classname", "").removeprefix("galvi: "),
            case.get("name", "").partition(",")[0],
        ): " ".join(part.text or "" for part in case.iter("failure"))
        for case in cases
    }


def test_an_integrator_in_a_src_layout_is_checked_on_a_problem_of_the_project(tmp_path):
    reading = (
        "import sys\n\nfrom mine.methods import Leapfrog, swing\n\nassert sys.stdin.read() == ''\n"
    )
    settings = "[pytest]\npythonpath = lib\n"
    files = {"src/mine/methods.py": CONTENDERS, "lib/ours.py": reading, "pytest.ini": settings}
    project(tmp_path, files)
    options = ("--galvi", "ours:Leapfrog", "--galvi-problem", "ours:swing")
    assert failure_texts(tmp_path, *options, "-k", "reversal or test_ours") == dict.fromkeys(
        [("tests.test_ours", "test_ours"), ("my leapfrog", "time reversal")], ""
    )


@pytest.mark.slow(beside="test_what_cannot_be_loaded_ends_the_run_with_a_sentence_and_status_4")
@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--galvi", "mine:Bare"], "--galvi mine:Bare: .* lacks 'supports' and 'run'"),
        (["--galvi", "mine:Leapfog"], "--galvi mine:Leapfog: .* did you mean 'Leapfrog'"),
        (["--galvi", "mine:Leapfrog", "--galvi-problem", "mine:no"], "--galvi-problem mine:no: "),
        (
            ["--galvi", "mine:Leapfrog", "--galvi", "again:Leapfrog"],
            "--galvi: two are called 'my leapfrog'",
        ),
    ],
)
def test_what_galvi_cannot_load_is_named_from_a_folder_inside_the_repository(
    tmp_path, options, message
):
    project(tmp_path, {"mine.py": CONTENDERS, "again.py": "from mine import Leapfrog\n"})
    completed = run(tmp_path / "tests", *options)
    assert completed.returncode == 4 and re.search(f"^ERROR: {message}", completed.stderr), (
        completed.stderr
    )


@pytest.mark.slow(
    beside="test_an_integrator_in_a_src_layout_is_checked_on_a_problem_of_the_project"
)
def test_planted_faults_fail_the_right_items_and_what_is_sound_passes(tmp_path):
    project(tmp_path, {"mine.py": CONTENDERS})
    names = ("Leapfrog", "FirstOrder", "FalselySymmetric", "Damped", "Random", "Leaking")
    options = [word for name in names for word in ("--galvi", f"mine:{name}")]
    texts = failure_texts(tmp_path, *options, "--galvi-problem", "mine:swing")
    assert len(texts) > 6 * len(names)
    failed = {key: text for key, text in texts.items() if text}
    expected = {
        ("first order", "order"): "bound: 1.75, less two standard errors (0.25 at most), to 2.25",
        ("falsely symmetric", "time reversal"): "It declares that it is symmetric",
        ("damped", "conservation"): "without a drift",
        ("random", "determinism"): "it is not deterministic",
        ("leaking", "memory"): "bound: at most 4. Of each of three equal rounds of runs",
    }
    assert set(failed) - {("damped", "longest run"), ("damped", "accuracy")} == set(expected)
    for key, message in expected.items():
        assert message in failed[key]


@pytest.mark.slow(
    beside="test_an_integrator_in_a_src_layout_is_checked_on_a_problem_of_the_project"
)
def test_the_example_of_the_page_passes_on_the_problems_of_the_suite(tmp_path):
    example = (ROOT / "docs" / "examples" / "mine.py").read_text(encoding="utf-8")
    project(tmp_path, {"mine.py": example})
    completed = run(tmp_path, "-p", "xdist", "-n", "2", "--galvi", "mine:Leapfrog", "-ra")
    assert completed.returncode == 0, completed.stdout + completed.stderr
