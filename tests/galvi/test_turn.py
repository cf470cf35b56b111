"""One process compiles, the others wait: for as long as that one lives, and not for ever."""

from __future__ import annotations

import subprocess
import sys
import threading
import time

from galvi.kernels.compile.compile_lock import Turn

HOLDER = """
import sys
from pathlib import Path
from galvi.kernels.compile.compile_lock import Turn
turn = Turn(Path(sys.argv[1]))
turn.take()
print("taken", flush=True)
sys.stdin.read()
"""


def test_who_comes_first_does_not_wait_and_leaves_nothing(tmp_path):
    turn = Turn(tmp_path / "kernel.nbc")
    assert not turn.take()
    assert [path.name for path in tmp_path.iterdir()] == ["kernel.turn"]
    turn.end()
    turn.end()
    assert list(tmp_path.iterdir()) == []


def test_who_comes_second_waits_for_the_first(tmp_path):
    first, second = Turn(tmp_path / "kernel.nbc"), Turn(tmp_path / "kernel.nbc")
    assert not first.take()
    threading.Timer(0.3, first.end).start()
    begun = time.monotonic()
    assert second.take()
    assert time.monotonic() - begun >= 0.29
    second.end()


def test_nobody_waits_longer_than_patience(tmp_path):
    first, second = Turn(tmp_path / "kernel.nbc"), Turn(tmp_path / "kernel.nbc")
    first.take()
    assert second.take(patience=0.1)
    second.end()
    assert [path.name for path in tmp_path.iterdir()] == ["kernel.turn"]
    first.end()


def test_the_turn_of_a_killed_process_ends(tmp_path):
    holder = subprocess.Popen(
        [sys.executable, "-c", HOLDER, str(tmp_path / "kernel.nbc")],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
    )  # fmt: skip
    assert holder.stdout is not None and holder.stdout.readline() == "taken\n"
    threading.Timer(0.2, holder.kill).start()
    waiting = Turn(tmp_path / "kernel.nbc")
    assert waiting.take(patience=30.0)
    holder.communicate()
    waiting.end()


def test_without_a_place_for_it_everybody_goes_on(tmp_path):
    turn = Turn(tmp_path / "not" / "there" / "kernel.nbc")
    assert not turn.take()
    turn.end()
