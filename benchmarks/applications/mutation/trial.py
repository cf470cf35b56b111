"""Whether the tests that reach a mutant find it."""

from __future__ import annotations

import math
import os
import re
import subprocess
import sys
import tempfile
import time
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from benchmarks.applications.mutation.mutants import Mutant
from benchmarks.applications.mutation.reach import Reach, copied, in_copy

KILLED, SURVIVED, NOT_REACHED = "killed", "survived", "not reached"
START, SLOWER = 240.0, 2.0  # seconds to start and compile; times the tests' seconds under coverage
SOON = 40  # tests that run first: of many, collecting takes longer than these
LOOKED = 1.0  # seconds from one look at a run to the next
BUSY = 10.0  # a clock's second against one of processor time, at most


@dataclass(frozen=True)
class Outcome:
    """``killed`` (by which test), ``survived`` or ``not reached``, and the seconds it took."""

    outcome: str
    test: str
    seconds: float


def tried(mutant: Mutant, reach: Reach, sources: Path) -> Outcome:
    """Run the tests that reach the mutant in a copy of the sources, until one fails.

    Parameters
    ----------
    sources
        a copy of reach.root, whose files trials share but for the mutant's

    Notes
    -----
    A run that takes SLOWER times as much processor time as usual, or a test as much time as that,
    counts as killed: it hangs.
    """
    tests = reach.chosen(reach.tests(mutant.file, mutant.line))
    if not tests:
        return Outcome(NOT_REACHED, "", 0.0)
    start = time.perf_counter()
    with tempfile.TemporaryDirectory(prefix="galvi-mutant-") as folder:
        copy = copied(sources, Path(folder) / "sources", os.link)
        (copy / mutant.file).unlink()
        (copy / mutant.file).write_text(mutant.source(reach.root), encoding="utf-8")
        for part in filter(None, (tests[:SOON], tests[SOON:])):
            chosen = Path(folder) / "tests.txt"
            chosen.write_text("\n".join(part), encoding="utf-8")
            code, text = _run(copy, chosen, START + SLOWER * reach.duration(part))
            if code != 0:
                break
    seconds = time.perf_counter() - start
    if code == 0:
        return Outcome(SURVIVED, "", seconds)
    # The text of pytest is all there is.
    failed = re.search(r"^(?:FAILED|ERROR) (\S+)", text, re.MULTILINE)
    if failed:
        return Outcome(KILLED, failed[1], seconds)
    hangs = code < 0 or "+ Timeout +" in text  # the latter by pytest-timeout
    return Outcome(KILLED, "it hangs or crashes" if hangs else "import", seconds)


def _run(copy: Path, tests: Path, patience: float) -> tuple[int, str]:
    seconds = math.ceil(patience)
    command = [
        sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider",
        "-p", "benchmarks.applications.mutation.first_failure", f"--timeout={seconds}", f"@{tests}",
    ]  # fmt: skip
    output = tests.with_suffix(".out")
    with (
        output.open("w") as file,
        subprocess.Popen(
            command, cwd=copy, env=in_copy(copy), start_new_session=True, stdout=file,
            stderr=subprocess.STDOUT,
        ) as process,
    ):  # fmt: skip
        begin = time.perf_counter()
        try:
            while time.perf_counter() - begin < BUSY * patience and _spent(process.pid) < patience:
                with suppress(subprocess.TimeoutExpired):
                    return process.wait(LOOKED), output.read_text("utf-8", "replace")
            return -9, ""
        finally:
            if process.poll() is None:
                os.killpg(process.pid, 9)


def _spent(process: int) -> float:
    """Seconds of processor time; a limit by the system would make the clock of the tests coarse."""
    fields = Path(f"/proc/{process}/stat").read_text(encoding="ascii").rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
