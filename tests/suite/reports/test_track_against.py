"""Two revisions side by side, with a galvi of ten lines: folders, processes, hangs, interrupts."""

from __future__ import annotations

import importlib.util
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import pytest

import galvi
from benchmarks.timings.case import TRAJECTORY, Case, Thresholds
from benchmarks.timings.catalogue import CASES
from benchmarks.timings.worker import check_end, described
from galvi.command import put_suite_first
from galvi.kernels.compile.cache import KERNELS_FOLDER
from reports.cli import track as command
from reports.cli.track import choose_cases, track_against
from reports.tracking.benches import TIME, read_history
from reports.tracking.checkouts import CannotCompare, Checkout, checkouts
from reports.tracking.tracked_problems import contender_cases, tracked
from reports.tracking.worker import Failed, Worker

ROOT = Path(__file__).parents[3]
STUB = """
import types, numpy as np

print("galvi says hello")

class Problem:
    q0, v0 = np.zeros(2), np.zeros(2)

class problems:
    kepler = staticmethod(lambda **given: Problem())

Polynomials = gauss = lambda number: number
Galerkin = lambda *parts: parts

def integrate(problem, method, step, steps, save_every):
    work = sum(range({work}))
    counts = dict(steps=steps, iterations={iterations})
    return types.SimpleNamespace(q=np.ones((2, 2)), counts=counts, success=True, status="ok")
"""
CASE = Case("orbit", TRAJECTORY, "kepler", 4, 4, 0.1, 10)


def stub(work=20_000, iterations=5):
    return STUB.format(work=work, iterations=iterations)


def git(folder, *arguments):
    settings = {"GIT_CONFIG_GLOBAL": os.devnull, "GIT_CONFIG_SYSTEM": os.devnull}
    name = ["-c", "user.name=a", "-c", "user.email=a@b", "-c", "commit.gpgsign=false"]
    subprocess.run(
        ["git", *name, *arguments],
        cwd=folder,
        env=os.environ | settings,
        check=True,
        capture_output=True,
    )


def write(folder, text):
    (folder / "galvi").mkdir(parents=True, exist_ok=True)
    (folder / "galvi" / "__init__.py").write_text(text)


@pytest.fixture
def checkout(tmp_path, monkeypatch):
    """The current folder: a repository with one commit of the stub; `tempfile` works beside it."""
    root, spare = tmp_path / "root", tmp_path / "spare"
    write(root, stub())
    spare.mkdir()
    git(root, "init", "--quiet")
    git(root, "add", ".")
    git(root, "commit", "--quiet", "-m", "first")
    monkeypatch.setattr(command, "ROOT", root)
    monkeypatch.chdir(root)
    monkeypatch.setattr("tempfile.tempdir", str(spare))
    monkeypatch.setattr("reports.tracking.rounds.MIN_ATTEMPT_SECONDS", 0.002)
    return root


def test_compiled_kernels_are_taken_along(checkout):
    """Without them both sides would compile all kernels."""
    kernel = Path("galvi", "__pycache__", KERNELS_FOLDER, "step.nbc")
    (checkout / kernel).parent.mkdir(parents=True)
    (checkout / kernel).write_bytes(b"code")
    with checkouts("HEAD", checkout) as sides:
        assert [(side.folder / kernel).read_bytes() for side in sides] == [b"code"] * 2


def test_files_that_archives_leave_out_are_on_both_sides(checkout):
    (checkout / ".gitattributes").write_text("galvi export-ignore\n")
    commit(checkout)
    with checkouts("HEAD", checkout) as sides:
        assert all((side.folder / "galvi" / "__init__.py").is_file() for side in sides)
        assert not any(side.changed for side in sides)


def compared(root, revision="HEAD"):
    """The status, against.json and against.md of a comparison."""
    out = root.parent / "out"
    status = track_against(checkouts(revision, root), (CASE,), out, {"date": "d"}, False)
    return status, json.loads((out / "against.json").read_text()), (out / "against.md").read_text()


def commit(folder, *arguments):
    git(folder, "add", ".")
    git(folder, "commit", "--quiet", "-m", "next", *arguments)


@pytest.mark.slow(beside="test_track_gates.py::test_equal_sides_are_green_in_one_sentence")
def test_a_clean_tree_is_green_by_its_commit(checkout, capsys):
    status, comparison, _ = compared(checkout)
    assert status == 0 and "is not worse than" in comparison["verdict"]
    assert "working tree" not in comparison["verdict"]
    assert comparison["verdict"] in " ".join(capsys.readouterr().out.split())
    assert list((checkout.parent / "spare").iterdir()) == []


@pytest.mark.slow(beside="test_track_gates.py::test_a_change_is_red_at_its_gate_alone")
def test_a_changed_tree_is_compared_as_it_is_and_said_to_be(checkout):
    write(checkout, stub(work=60_000, iterations=6))
    status, comparison, _ = compared(checkout)
    assert status == 1 and comparison["verdict"].startswith("The working tree (")
    assert "with changes) is worse than" in comparison["verdict"]
    (row,) = comparison["benchmarks"]
    assert set(row["alarms"]) == {"counts", "time"}


@pytest.mark.parametrize("revision", ["nope", "--help", "HEAD:galvi"])
def test_an_unknown_revision_is_a_sentence(checkout, revision):
    with pytest.raises(CannotCompare, match="expects a revision that git knows; received"):
        compared(checkout, revision)


def test_a_revision_without_galvi_is_a_sentence(checkout):
    git(checkout, "rm", "-r", "--quiet", "galvi")
    (checkout / "a").touch()
    commit(checkout)
    with pytest.raises(CannotCompare, match="expects a revision that has galvi"):
        compared(checkout)


def test_a_folder_without_git_and_another_repository_are_sentences(checkout, tmp_path, monkeypatch):
    """Another repository's HEAD would be compared as if it were galvi's own."""
    bare, foreign, inner = tmp_path / "bare", tmp_path / "other", checkout / "galvi" / "inner"
    for folder in (bare, foreign, inner):
        folder.mkdir()
    git(foreign, "init", "--quiet")
    with (
        pytest.raises(CannotCompare, match="run in a git checkout of galvi; rec"),
        checkouts("HEAD", bare),
    ):
        pass
    for folder in (bare, foreign):
        monkeypatch.chdir(folder)
        with pytest.raises(CannotCompare, match=f"run in {checkout}; received {folder}. Change to"):
            compared(checkout)
    monkeypatch.chdir(inner)
    with checkouts("HEAD", checkout):
        pass


def test_a_head_that_cannot_be_imported_is_red(checkout):
    write(checkout, "raise RuntimeError('broken')")
    status, comparison, text = compared(checkout)
    assert (
        status == 1 and "orbit (status)" in comparison["verdict"] and "RuntimeError: broken" in text
    )


def test_a_base_that_lacks_everything_cannot_be_compared(checkout):
    write(checkout, "nothing = 0")
    commit(checkout)
    write(checkout, stub())
    with pytest.raises(CannotCompare, match="Nothing could be compared"):
        compared(checkout)


def test_a_worker_that_hangs_dies_or_raises_is_a_sentence_and_can_go_on(tmp_path):
    write(tmp_path, "import os\nclass problems:\n    kepler = staticmethod(lambda: os._exit(3))\n")
    with Worker(Checkout(tmp_path, "base")) as worker:
        with pytest.raises(Failed, match="ended with status 3"):
            worker.run(CASE)
        write(tmp_path, "import time\nclass problems:\n    kepler = lambda: time.sleep(99)\n")
        worker.limit = 1.0
        with pytest.raises(Failed, match="no answer within 1 sec"):
            worker.run(CASE)
        worker.limit = 60.0
        write(tmp_path, "class problems:\n    pass\n")
        with pytest.raises(Failed, match=r"AttributeError: .* no attribute 'kepler'"):
            worker.run(CASE)
        worker.stop()
        write(tmp_path, stub())
        assert worker.time(CASE, 2, 1) > 0.0
        assert worker.run(CASE)["counts"] == {"steps": 10, "iterations": 5}
        worker.stop()
        shutil.rmtree(tmp_path / "galvi")
        with pytest.raises(Failed, match="not that of its own checkout"):
            worker.run(CASE)


def test_a_side_that_hangs_twice_is_not_asked_again_in_any_process(tmp_path):
    write(tmp_path, "import time\nclass problems:\n    kepler = lambda: time.sleep(99)\n")
    with Worker(Checkout(tmp_path, "head"), 0.5) as worker:
        for _ in range(2):
            with pytest.raises(Failed, match=r"gave no answer within 0.5 seconds"):
                worker.run(CASE)
            worker.stop()
        with pytest.raises(Failed, match=r"was not asked: 2 answers did not come within 0.5 sec"):
            worker.run(CASE)
        assert worker.process is None


@pytest.mark.slow(beside="test_what_an_integrator_says_is_harmless_and_what_it_starts_ends_with_it")
@pytest.mark.usefixtures("interruptible")
@pytest.mark.skipif(not Path("/proc/self/environ").exists(), reason="processes are not listed")
@pytest.mark.parametrize("signal_number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_leaves_no_folder_and_no_process(checkout, signal_number):
    write(checkout, stub() + "import time\ntime.sleep(60)\n")
    program = (
        "import sys, tempfile; from pathlib import Path\n"
        "tempfile.tempdir = sys.argv[2]\n"
        "from reports.cli import track\n"
        "from reports.tracking.checkouts import checkouts\n"
        "from benchmarks.timings.case import Case\n"
        f"case = Case(*{(CASE.name, CASE.kind, CASE.problem, 4, 4, 0.1, 10)!r})\n"
        "sides = checkouts('HEAD', Path(sys.argv[1]))\n"
        "track.track_against(sides, (case,), Path(sys.argv[3]), {}, False)\n"
    )
    spare, out = checkout.parent / "spare", checkout.parent / "out"
    command = [sys.executable, "-P", "-c", program, str(checkout), str(spare), str(out)]
    path = os.environ | {"PYTHONPATH": str(ROOT)}
    with subprocess.Popen(command, cwd=checkout, env=path, stderr=subprocess.DEVNULL) as process:
        deadline = time.monotonic() + 60.0
        while not _workers(spare) and time.monotonic() < deadline:
            time.sleep(0.05)
        assert _workers(spare)
        process.send_signal(signal_number)
        assert process.wait(30) != 0
    assert list(spare.iterdir()) == [] and not out.exists()
    assert _workers(spare) == []


def _workers(spare):
    """Processes whose galvi lies below the folder."""
    processes = []
    for path in Path("/proc").glob("[0-9]*/environ"):
        try:
            if f"PYTHONPATH={spare}".encode() in path.read_bytes():
                processes.append(path.parent.name)
        except OSError:
            continue
    return processes


def test_benchmarks_are_chosen_by_parts_of_their_names():
    assert {case.name for case in choose_cases(["rounding"], True)} == {
        "Kepler, rounding",
        "outer planets, rounding",
        "free body, rounding",
    }
    assert all(case.quick for case in choose_cases([], True))
    assert len(choose_cases([], False)) == len(CASES)


MINE = """
import numpy as np
import galvi

class Mine:
    name = "mine"

    def supports(self, problem):
        return isinstance(problem.system, galvi.Canonical)

    def settings(self, problem, duration):
        return [{{"tolerance": 1e-9}}]

    def run(self, problem, duration, setting):
        assert setting["samples"] == 1
        t, a = problem.t0 + np.array([0.0, duration]), duration * {rate}
        q = np.stack([problem.q0, np.cos(a) * problem.q0 + np.sin(a) * problem.v0])
        p = np.stack([problem.v0, np.cos(a) * problem.v0 - np.sin(a) * problem.q0])
        return galvi.Trajectory(problem, t, q, p, counts={{"force_evaluations": {count}}})
"""


@pytest.fixture
def project(tmp_path, monkeypatch):
    """Another project's repository, whose integrator is exact for oscillators; a folder in it."""
    inner = tmp_path / "project" / "inner"
    inner.mkdir(parents=True)
    (inner / "mine_to_track.py").write_text(MINE.format(rate=1.0, count=7))
    git(inner.parent, "init", "--quiet")
    git(inner.parent, "add", ".")
    git(inner.parent, "commit", "--quiet", "-m", "first")
    monkeypatch.chdir(inner)
    monkeypatch.syspath_prepend(str(inner))
    monkeypatch.setattr("reports.tracking.rounds.MIN_ATTEMPT_SECONDS", 0.002)
    monkeypatch.setattr(
        "reports.tracking.tracked_problems.PROBLEMS",
        (tracked("harmonic_oscillator", 5.0, "oscillator, closed form"),),
    )
    return inner


AGAINST = "track --against HEAD --contender mine_to_track:Mine"


@pytest.mark.slow(beside="test_track_gates.py::test_a_change_is_red_at_its_gate_alone")
def test_another_projects_integrator_is_compared_with_its_own_revision(ask, project):
    (project / "mine_to_track.py").write_text(MINE.format(rate=1.001, count=8))
    assert ask(AGAINST).status == 1
    comparison = json.loads(Path("out/against.json").read_text())
    row, long = comparison["benchmarks"]
    assert {"counts", "error"} <= set(row["alarms"])
    assert long["name"].startswith(f"{row['name']}, ") and "error" in long["alarms"]
    assert row["alarms"]["counts"] == "Force evaluations rose from 7 to 8 (+14 %)."
    assert comparison["head"].endswith("with changes)")
    failures = ElementTree.parse("out/track.xml").getroot().iter("failure")
    assert {failure.get("message") for failure in failures} >= set(row["alarms"].values())


@pytest.mark.slow(beside="test_track_history.py::test_each_quantity_of_each_bench_is_a_row")
def test_each_comparison_of_another_project_adds_a_point_to_its_history(ask, project):
    """Without a comparison, a sentence names the command that adds one."""
    printed = ask("track").out
    assert "`galvi track --against REV --contender package.module:Class` adds one" in printed
    assert ask(AGAINST).status == ask(AGAINST).status == 0
    assert ask("track").out.startswith("2 benchmark runs.\n")
    rows = read_history(Path("out/benchmarks"))
    head = subprocess.run(["git", "rev-parse", "HEAD"], capture_output=True, text=True, check=True)
    assert set(rows["commit"]) == {head.stdout[:12]}
    assert {TIME, "force_evaluations", "error"} < set(rows["quantity"])
    assert Path("out/figures/track-mine-harmonic-oscillator.svg").is_file()


@pytest.mark.slow_cases("--against HEAD --contender no_such:Mine-there is no module 'no_such'")
@pytest.mark.parametrize(
    ("options", "message"),
    [
        ("--against HEAD", "integrator of the latter with --contender package.module"),
        ("--against HEAD --contender no_such:Mine", "there is no module 'no_such'"),
        ("--against none --contender mine_to_track:Mine", "a revision that git knows"),
        ("--contender mine_to_track:Mine", "require --against REV"),
        ("--against HEAD --slower 5", "--less-accurate are for a --contender"),
        ("--against HEAD --contender mine_to_track:Mine --isolate", "are not for a"),
    ],
)
def test_what_cannot_be_tracked_in_another_project_is_a_sentence(ask, project, options, message):
    completed = ask(f"track {options}")
    assert completed.status == 2 and message in completed.err and completed.err.count("\n") == 1


@pytest.mark.slow(beside="test_track_gates.py::test_a_change_is_red_at_its_gate_alone")
def test_an_integrator_that_the_base_does_not_have_is_new_and_green(ask, project):
    (project / "moved_to_track.py").write_text(MINE.format(rate=1.0, count=7))
    completed = ask("track --against HEAD --contender moved_to_track:Mine")
    pattern = r"moved_to_track:Mine is new: \w{12} has no version that runs to compare"
    assert completed.status == 0 and re.search(pattern, completed.out)
    completed = ask(f"{AGAINST} --contender moved_to_track:Mine")
    assert completed.status == 0 and "is new" in completed.out and "not worse than" in completed.out


@pytest.mark.slow(beside="test_track_gates.py::test_a_change_is_red_at_its_gate_alone")
def test_thresholds_of_a_project_are_those_of_its_benchmarks(project):
    (case,) = contender_cases(["mine_to_track:Mine"], 60.0, Thresholds(0.2, 0.05))
    assert (case.slower, case.error_tolerance, case.rounding) == (0.2, 0.05, 1e-13)
    assert case.setting == {"tolerance": 1e-9, "samples": 1}


@pytest.mark.slow(beside="test_modules_of_the_repository_are_found_from_any_folder")
def test_a_file_of_the_name_of_galvi_is_not_taken_for_it(ask, project, monkeypatch):
    paths = [path for path in sys.path if path != str(project)]
    monkeypatch.setattr(sys, "path", [*paths, str(project)])  # as the command has it
    (project / "galvi.py").write_text("raise ImportError('not this one')")
    commit(project.parent)
    assert ask(AGAINST).status == 0


@pytest.mark.parametrize("subfolder", ["src", ""])
def test_modules_of_the_repository_are_found_from_any_folder(subfolder, tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "path", list(sys.path))
    below = tmp_path / "project" / "docs" / "deep"
    below.mkdir(parents=True)
    home = tmp_path / "project" / subfolder
    home.mkdir(exist_ok=True)
    git(tmp_path / "project", "init", "--quiet")
    (home / "only_here.py").write_text("")
    monkeypatch.chdir(below)
    put_suite_first()
    assert str(home) in sys.path and sys.path.index(str(home)) > 0
    assert importlib.util.find_spec("only_here") is not None


HOSTILE = """
import os, time
import numpy as np
import galvi

class Status(str):
    def __reduce__(self):
        return open, ({opened!r}, "w")

class Hostile:
    def settings(self, problem, duration):
        return [{{"step": duration / 4, "save_every": 4}}]

    def run(self, problem, duration, setting):
        if os.fork() == 0:
            while True:
                with open({alive!r}, "a") as file:
                    file.write("x")
                time.sleep(0.02)
        while not os.path.exists({alive!r}):
            time.sleep(0.01)
        if setting["step"] == duration:
            raise ValueError("\\x1b[31mred\\n::error::x")
        t = np.array([problem.t0, problem.t0 + duration])
        q, p = np.array([problem.q0] * 2), np.array([problem.p0] * 2)
        status = Status("\\x1b[1mbad\\n::error::y")
        return galvi.Trajectory(problem, t, q, p, success=False, status=status)
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no fork")
def test_what_an_integrator_says_is_harmless_and_what_it_starts_ends_with_it(
    tmp_path,
):
    opened, alive = tmp_path / "opened", tmp_path / "alive"
    (tmp_path / "odd.py").write_text(HOSTILE.format(opened=str(opened), alive=str(alive)))
    side = Checkout(tmp_path, "head", places=(tmp_path, ROOT))
    case = replace(CASE, contender="odd:Hostile", setting={"step": 0.25, "save_every": 4})
    with Worker(side) as worker:
        answer = worker.run(case)
        assert answer["status"] == r"\x1b[1mbad : :error: :y" and not opened.exists()
        assert answer["offered"] == "{'step': 0.25, 'save_every': 4}"
        with pytest.raises(Failed, match=r"^ValueError: \\x1b\[31mred : :error: :x$"):
            worker.run(replace(case, setting={"step": 1.0, "save_every": 1}))
    size = alive.stat().st_size
    time.sleep(0.2)
    assert alive.stat().st_size == size


def test_a_run_that_ends_at_another_time_is_none_and_momenta_are_ends_too():
    run = galvi.integrate(
        galvi.problems.kepler(0.3), galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4)), 0.1, 2
    )
    check_end(run, 0.0, 0.2)
    with pytest.raises(ValueError, match=r"its last time must be 5; received 0\.2"):
        check_end(run, 0.0, 5.0)
    (ends,) = described([run], momenta=True)["ends"]
    assert ends == [*run.q[-1], *run.p[-1]] and described([run])["ends"] == [ends[:2]]
