"""A contender's process ends with ours, whatever it does, and leaves nothing behind."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from benchmarks.store.provenance import ROOT

TARGETS = """
import ctypes, multiprocessing, subprocess, sys, time
from benchmarks.external.worker_life import tie_to_parent

def started():
    subprocess.Popen(["sleep", "60"])  # of what it starts, too, nothing is left

def spins(connection, tied):
    guard = tie_to_parent() if tied else None
    started()
    print("there", flush=True)
    while True:
        pass

def holds_the_interpreter(connection, tied):
    guard = tie_to_parent() if tied else None
    started()
    print("there", flush=True)
    ctypes.PyDLL(None).sleep(60)

def locks(connection, tied):
    guard = tie_to_parent() if tied else None
    started()
    lock = multiprocessing.Lock()
    print("there", flush=True)
    try:
        connection.recv()
    except EOFError:
        return
"""
PARENT = """
import multiprocessing, sys, time
import targets
from benchmarks.external.worker_life import end

if __name__ == "__main__":
    context = multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe()
    target = getattr(targets, sys.argv[1])
    process = context.Process(target=target, args=(theirs, sys.argv[2] == "tied"), daemon=True)
    process.start()
    theirs.close()
    if sys.argv[3] == "end":
        time.sleep(float(sys.argv[4]))
        end(process, ours, gently=True)
    else:
        time.sleep(60.0)
"""
ENDLESS = """
class Endless:
    name = "endless"
    def supports(self, problem):
        print("there", flush=True)
        while True:
            pass
    def run(self, problem, duration, setting):
        return None
"""
BUILDS = """
import galvi
from benchmarks.external.integrator import ExternalIntegrator
if __name__ == "__main__":
    ExternalIntegrator.open("endless:Endless").supports(galvi.problems.kepler(0.6))
"""


def begun(folder: Path, *words: str) -> subprocess.Popen[str]:
    """A process of ours, whose own has started something; what they say ends when all are gone."""
    (folder / "targets.py").write_text(TARGETS)
    (folder / "parent.py").write_text(PARENT)
    path = {"PYTHONPATH": os.pathsep.join((str(folder), str(ROOT)))}
    process = subprocess.Popen(
        [sys.executable, str(folder / "parent.py"), *words],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | path,
        start_new_session=True,
    )
    if words[2] != "end":
        assert process.stdout is not None and process.stdout.readline() == "there\n"
    return process


needs_groups = pytest.mark.skipif(not hasattr(os, "setsid"), reason="there are no process groups")


@needs_groups
@pytest.mark.parametrize("how", ["spins", "holds_the_interpreter"])
def test_when_ours_is_killed_it_goes_and_what_it_started(tmp_path: Path, how: str) -> None:
    process = begun(tmp_path, how, "tied", "wait")
    process.kill()
    process.communicate(timeout=10.0)  # raises while any of them is left


@needs_groups
def test_one_that_is_not_tied_to_ours_stays(tmp_path: Path) -> None:
    """So that the others can fail."""
    process = begun(tmp_path, "spins", "loose", "wait")
    process.kill()
    with pytest.raises(subprocess.TimeoutExpired):
        process.communicate(timeout=1.0)
    os.killpg(process.pid, signal.SIGKILL)
    process.communicate(timeout=10.0)


@needs_groups
def test_one_that_is_asked_to_leave_clears_up_and_what_it_started_goes(tmp_path: Path) -> None:
    process = begun(tmp_path, "locks", "tied", "end", "0.5")
    said = process.communicate(timeout=10.0)
    assert said == ("there\n", "") and process.returncode == 0


@needs_groups
@pytest.mark.slow
def test_a_contender_that_never_returns_ends_with_ours(tmp_path: Path) -> None:
    (tmp_path / "endless.py").write_text(ENDLESS)
    words = [sys.executable, "-c", BUILDS]
    path = {"PYTHONPATH": os.pathsep.join((str(tmp_path), str(ROOT)))}
    streams = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    process = subprocess.Popen(words, env=os.environ | path, text=True, **streams)
    assert process.stderr is not None and process.stderr.readline() == "there\n"
    process.kill()
    process.communicate(timeout=10.0)
