"""What a fresh process waits for before its first result, and what a long run keeps in memory."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from benchmarks.store.provenance import ROOT

COLUMNS = (
    "problem",
    "import",
    "cold",
    "warm",
    "import_in_numpys",
    "warm_in_numpys",
    "few_steps",
    "many_steps",
)
TIMES, QUICK_TIMES = 3, 2  # processes, the first to fill the cache; the quickest counts
STEPS, MANY_STEPS, QUICK_STEPS = 10**4, 10**6, 10**5
EXPLANATION = (
    "Seconds in a fresh process: to import galvi, then to the end of a first run of ten steps. "
    "Cold is with nothing compiled before (for the user's functions: with galvi's kernels compiled "
    "and these not), warm with all of it in the cache on disk. Seconds of different machines do "
    "not compare: beside them stands how often numpy could have been imported in that time. "
    f"Memory is the most that the process had after {STEPS:,} steps, and after a second run of "
    f"{MANY_STEPS:,} ({QUICK_STEPS:,} in the quick form), of which only the ends are kept."
)
OWN = """
import numba, numpy as np, galvi

@numba.njit(cache=True)
def potential(q):
    return -np.cos(q[0])

@numba.njit(cache=True)
def gradient(q):
    return np.sin(q)

def pendulum():
    return galvi.Problem(galvi.Canonical(1.0, potential, gradient), [3.0], [0.0])
"""
TIMED = """
import json, resource, sys, time
clock = time.perf_counter()
import numpy
numpys = time.perf_counter() - clock
import galvi
imported = time.perf_counter() - clock
method = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4))

def peak():  # MiB; rusage may count the memory of the process that started this one
    try:
        with open("/proc/self/status") as status:
            (line,) = [line for line in status if line.startswith("VmHWM")]
        return int(line.split()[1]) / 1024
    except OSError:
        most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        return most / (2**20 if sys.platform == "darwin" else 1024)

clock = time.perf_counter()
{imports}
problem = {problem}
run = galvi.integrate(problem, method, {step}, 10)
first = time.perf_counter() - clock
assert run.success, run.status
peaks = []
for steps in {steps}:
    assert galvi.integrate(problem, method, {step}, steps, save_every=steps).success
    peaks.append(peak())
print(json.dumps([numpys, imported, first, peaks]))
"""


@dataclass(frozen=True)
class Start:
    """One problem to start with.

    label    for the table
    problem  an expression that makes it
    step     of a run
    imports  what the expression needs besides galvi
    cold     whether it is worth compiling everything for: once for each kernel
    """

    label: str
    problem: str
    step: float
    imports: str = ""
    cold: bool = True


STARTS = (
    Start("point masses: outer solar system", "galvi.problems.outer_solar_system()", 200.0),
    Start("central force: Kepler, e = 0.6", "galvi.problems.kepler(0.6)", 0.1),
    Start("spring: harmonic oscillator", "galvi.problems.harmonic_oscillator()", 0.1, cold=False),
    Start("user's jitted functions: pendulum", "own.pendulum()", 0.1, "import own"),
)


@dataclass(frozen=True)
class Started:
    """One process: seconds to import numpy and galvi, to the first result; peaks of memory, MiB."""

    numpys: float
    imported: float
    first: float
    peaks: tuple[float, ...]


def started(start: Start, folder: Path, steps: tuple[int, ...] = (), cache: str = "") -> Started:
    """A fresh process that imports galvi, does ten steps, and then so many ``steps`` each.

    folder  where the user's functions are
    cache   folder for compiled code; empty means the usual one
    """
    environment: Mapping[str, str] = os.environ | ({"NUMBA_CACHE_DIR": cache} if cache else {})
    code = TIMED.format(
        problem=start.problem, step=start.step, imports=start.imports, steps=list(steps)
    )
    paths = [str(folder), str(ROOT)]
    code = f"import sys; sys.path[:0] = {paths!r}\n{code}"
    done = subprocess.run(
        [sys.executable, "-c", code], env=environment, capture_output=True, text=True
    )
    if done.returncode:
        raise RuntimeError(f"{start.label} could not be started: {done.stderr.strip()}")
    numpys, imported, first, peaks = json.loads(done.stdout)
    return Started(numpys, imported, first, tuple(peaks))


def start_up_table(
    quick: bool = False, report: Callable[[str], None] = lambda sentence: None
) -> pd.DataFrame:
    """One row for each problem.

    import, cold, warm                seconds; cold is NaN where it is not measured, as in --quick
    import_in_numpys, warm_in_numpys  the same over what numpy takes to import in that process
    few_steps, many_steps             MiB, the process's peak after STEPS and after MANY_STEPS more
    """
    rows = []
    for start in STARTS:
        report(start.label)
        with tempfile.TemporaryDirectory() as name:
            rows.append(_row(start, Path(name), quick))
    return pd.DataFrame(rows, columns=list(COLUMNS))


def _row(start: Start, folder: Path, quick: bool) -> dict[str, Any]:
    (folder / "own.py").write_text(OWN)
    cold = float("nan")
    if start.cold and not quick:
        cold = started(start, folder, cache="" if start.imports else str(folder / "cache")).first
    times, many = (QUICK_TIMES, QUICK_STEPS) if quick else (TIMES, MANY_STEPS)
    warm = [started(start, folder) for _ in range(times - 1)]
    warm.append(started(start, folder, (STEPS, many)))
    imported = min(warm, key=lambda one: one.imported)
    first = min(warm, key=lambda one: one.first)
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
