"""Time to the first result of a fresh process, and memory of a long run."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from benchmarks.store.provenance import ROOT, version
from benchmarks.store.row_files import RowFiles, stored_rows

COLUMNS: Mapping[str, type] = {
    "problem": str,
    "import": float,
    "cold": float,
    "warm": float,
    "import_in_numpys": float,
    "warm_in_numpys": float,
    "few_steps": float,
    "many_steps": float,
}
WARM_PROCESSES = 2  # the first one fills the cache; the fastest counts
STEPS, MANY_STEPS = 10**4, 10**5
EXPLANATION = (
    "Seconds in a fresh process: to import galvi, then to the end of a first run of ten steps. "
    "Cold: nothing is compiled, in processor time, once for each kernel, and empty where another "
    "row has the same kernel, or where make studies measures it: the general kernel takes a "
    "third of a minute; warm: everything is in the cache on disk. Since seconds of different "
    "machines do not compare, they are also given relative to the import of numpy. Memory is the "
    f"peak of the process after {STEPS:,} steps, and after a second run of {MANY_STEPS:,} "
    "(a fiftieth for the Lagrangian and the force), of which only the ends are kept."
)
OWN_MODULE = """
import numba, numpy as np, galvi

@numba.njit(cache=True)
def potential(q):
    return -np.cos(q[0])

@numba.njit(cache=True)
def gradient(q):
    return np.sin(q)

@numba.njit(cache=True)
def drag(q, v):
    return -0.1 * v

@numba.njit(cache=True)
def slopes(R, w):
    found = np.zeros(12)
    found[0], found[1], found[2], found[11] = w[0], 2.0 * w[1], 3.0 * w[2], -1.0
    return found

def swinging(**force):
    return galvi.Problem(galvi.Canonical(1.0, potential, gradient, **force), [3.0], [0.0])

def pendulum():
    return swinging()

def damped():
    return swinging(force=drag)

def top():
    def L(R, w):
        return 0.5 * (w[0] ** 2 + 2.0 * w[1] ** 2 + 3.0 * w[2] ** 2) - R[2, 2]
    return galvi.Problem(galvi.Lagrangian(L, galvi.SO3(), slopes), np.eye(3), [0.1, 1.0, 0.2])
"""
TIMED_PROGRAM = """
import json, resource, sys, time
clock = time.perf_counter()
import numpy
numpys = time.perf_counter() - clock
import galvi
imported = time.perf_counter() - clock
method = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4))

def peak():  # MiB; rusage may count the memory of the process that started this one
    try:
        with open("/proc/self/status") as lines:
            (line,) = [line for line in lines if line.startswith("VmHWM")]
        return int(line.split()[1]) / 1024
    except OSError:
        most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        return most / (2**20 if sys.platform == "darwin" else 1024)

clock, processors = time.perf_counter(), time.process_time()
{imports}
problem = {problem}
run = galvi.integrate(problem, method, {step}, 10)
first, processor = time.perf_counter() - clock, time.process_time() - processors
assert run.success, run.status
peaks = []
for steps in {steps}:
    assert galvi.integrate(problem, method, {step}, steps, save_every=steps).success
    peaks.append(peak())
print(json.dumps([numpys, imported, first, processor, peaks]))
"""


ALL, NOTHING, LONG = "all", "nothing", "long"
FOLDER = "start_up"  # subfolder of the studies
SLOW_FRACTION = 0.02  # for the general kernel of groups, whose step takes fifty times as long


@dataclass(frozen=True)
class Start:
    """A problem for the first run.

    Attributes
    ----------
    label
        label in the table
    problem
        an expression that constructs it
    step
        step size of the run
    imports
        imports needed by the expression besides galvi
    cold
        ALL: a cold run is measured; NOTHING: it would compile nothing new; LONG: it is measured in
        the long form only
    share
        fraction of the many steps after which memory is measured
    """

    label: str
    problem: str
    step: float
    imports: str = ""
    cold: str = ALL
    share: float = 1.0


STARTS = (  # what compiles longest first: two processes compile at a time
    Start("Lagrangian on SO(3): heavy body", "own.top()", 0.1, "import own", LONG, SLOW_FRACTION),
    Start("point masses: outer solar system", "galvi.problems.outer_solar_system()", 200.0),
    Start("spring: harmonic oscillator", "galvi.problems.harmonic_oscillator()", 0.1),
    Start("rigid body: free", "galvi.problems.free_rigid_body()", 0.1),
    Start("law: double pendulum", "galvi.problems.double_pendulum()", 0.05),
    Start("force: damped pendulum", "own.damped()", 0.1, "import own", NOTHING, SLOW_FRACTION),
    Start("user's jitted functions: pendulum", "own.pendulum()", 0.1, "import own"),
)


@dataclass(frozen=True)
class Started:
    """One process: seconds to import numpy, to import galvi, and to the first result, the latter
    also in processor time; peaks of memory in MiB."""

    numpys: float
    imported: float
    first: float
    processor: float
    peaks: tuple[float, ...]


def started(start: Start, folder: Path, steps: tuple[int, ...] = (), cache: str = "") -> Started:
    """A fresh process that imports galvi, does ten steps, then runs of the lengths in ``steps``.

    Parameters
    ----------
    folder
        folder of the user's functions
    cache
        folder for compiled code; empty for the default
    """
    environment: Mapping[str, str] = os.environ | ({"NUMBA_CACHE_DIR": cache} if cache else {})
    code = TIMED_PROGRAM.format(
        problem=start.problem, step=start.step, imports=start.imports, steps=list(steps)
    )
    paths = [str(folder), str(ROOT)]
    code = f"import sys; sys.path[:0] = {paths!r}\n{code}"
    completed = subprocess.run(
        [sys.executable, "-c", code], env=environment, capture_output=True, text=True
    )
    if completed.returncode:
        raise RuntimeError(f"{start.label} could not be started: {completed.stderr.strip()}")
    *seconds, peaks = json.loads(completed.stdout)
    return Started(*seconds, tuple(peaks))


def start_up_table(
    quick: bool = False, report: Callable[[str], None] = lambda sentence: None
) -> pd.DataFrame:
    """One row for each problem.

    import, cold, warm                seconds, cold in processor time; cold is NaN where it is not
                                      measured, as in --quick
    import_in_numpys, warm_in_numpys  the same relative to the import of numpy in that process
    few_steps, many_steps             peak memory, MiB, after STEPS and after MANY_STEPS more
    """

    def cold(start: Start) -> float:
        if quick or start.cold != ALL:
            return float("nan")
        report(f"{start.label}, cold")
        return _compiling(start)

    with ThreadPoolExecutor(2) as pool:
        colds = list(pool.map(cold, STARTS))
    rows = []
    for start, seconds in zip(STARTS, colds, strict=True):
        report(start.label)
        with own_folder() as folder:
            rows.append(_row(start, folder, seconds))
    return pd.DataFrame(rows, columns=list(COLUMNS))


@dataclass(frozen=True)
class Part:
    """A cold run that only the long form makes, with the file of its row."""

    start: Start
    files: RowFiles

    @property
    def title(self) -> str:
        """The title in progress output and in the table."""
        return f"{self.start.label}, cold"

    @property
    def name(self) -> str:
        """The name of its file: the problem and the version."""
        return f"{re.sub('[^a-z0-9]+', '-', self.start.label.lower())}_{version()}"

    def is_complete(self) -> bool:
        """Whether its row exists."""
        return self.files.read(self.name) is not None

    def run(self, report: Callable[[str], None]) -> None:
        """Compile in an empty cache, and write the row."""
        report(self.title)
        row = {"problem": self.title, "cold": _compiling(self.start)}
        table = pd.DataFrame([row], columns=list(COLUMNS))
        self.files.write(self.name, table)


def parts(studies: Path, report: Callable[[str], None]) -> list[Part]:
    """The runs of the long form."""
    files = RowFiles(studies / FOLDER, COLUMNS, report)
    return [Part(start, files) for start in STARTS if start.cold == LONG]


stored = stored_rows(FOLDER, COLUMNS)


def _compiling(start: Start) -> float:
    """Processor seconds of the first run with an empty cache."""
    with own_folder() as folder:
        return started(start, folder, cache=str(folder / "cache")).processor


@contextmanager
def own_folder() -> Iterator[Path]:
    """A folder with the user's functions, none of them compiled."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "own.py").write_text(OWN_MODULE)
        yield folder


def _row(start: Start, folder: Path, cold: float) -> dict[str, Any]:
    warm = [started(start, folder) for _ in range(WARM_PROCESSES - 1)]
    warm.append(started(start, folder, (STEPS, max(STEPS, round(MANY_STEPS * start.share)))))
    imported = min(warm, key=lambda process: process.imported)
    first = min(warm, key=lambda process: process.first)
    few_steps, many_steps = warm[-1].peaks
    return {
        "problem": start.label,
        "import": imported.imported,
        "cold": cold,
        "warm": first.first,
        "import_in_numpys": imported.imported / imported.numpys,
        "warm_in_numpys": first.first / first.numpys,
        "few_steps": few_steps,
        "many_steps": many_steps,
    }
