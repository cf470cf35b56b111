"""The time of a first run, by the functions that it compiles.

`python -m benchmarks.studies.compile_times` prints the table for Kepler's problem, of a fresh
process with an empty cache.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile

import pandas as pd

from benchmarks.store.provenance import ROOT

SHOWN_FUNCTIONS = 12  # functions that are listed by name
COMPILER_STEPS = {"native_lowering": "machine code", "part_lowering": "LLVM's code"}
ANALYSIS = "types and rewriting"
COLUMNS = ("function", ANALYSIS, *COMPILER_STEPS.values(), "seconds")
COLD_PROGRAM = """
import json, time
before = time.process_time()
import galvi
imported = time.process_time() - before
from galvi.kernels.compile.internals import event

class Watch(event.Listener):
    open, own = [], {}

    def on_start(self, started):
        self.open.append([time.process_time(), 0.0])

    def on_end(self, ended):
        began, inside = self.open.pop()
        seconds, name = time.process_time() - began, ended.data["name"]
        self.own[name] = self.own.get(name, 0.0) + seconds - inside
        if self.open:
            self.open[-1][1] += seconds

event.register("numba:run_pass", Watch())
before = time.process_time()
problem = galvi.problems.kepler(eccentricity=0.6)
method = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
assert galvi.integrate(problem, method, 0.1, 10).success
print(json.dumps([imported, time.process_time() - before, Watch.own]))
"""


def compile_times() -> tuple[float, float, pd.DataFrame]:
    """Processor seconds of the import, of a first run with an empty cache, and of each function
    that it compiles: a row for each function with COLUMNS, those that take longest first.

    A function's machine code contains that of all functions that it calls; the rows of these have
    the steps before, types and LLVM's code.

    Raises
    ------
    RuntimeError
        Where the process fails.
    """
    with tempfile.TemporaryDirectory() as cache:
        environment = os.environ | {"NUMBA_CACHE_DIR": cache}
        completed = subprocess.run(
            [sys.executable, "-c", COLD_PROGRAM],
            env=environment,
            cwd=ROOT,
            capture_output=True,
            text=True,
        )
    if completed.returncode:
        raise RuntimeError(f"the first run failed: {completed.stderr.strip()}")
    imported, total, own_seconds = json.loads(completed.stdout)
    rows: dict[str, dict[str, float]] = {}
    for name, seconds in own_seconds.items():
        step, _, function = name.rstrip("]").partition(" [")
        row = rows.setdefault(function, dict.fromkeys(COLUMNS[1:], 0.0))
        row[COMPILER_STEPS.get(step, ANALYSIS)] += seconds
        row["seconds"] += seconds
    records = [{"function": function, **row} for function, row in rows.items()]
    table = pd.DataFrame(records, columns=list(COLUMNS))
    return imported, total, table.sort_values("seconds", ascending=False, ignore_index=True)


def main() -> None:
    """Print the total times, the slowest functions, and the sums of the others and of all."""
    imported, total, table = compile_times()
    numbers = list(COLUMNS[1:])
    sums = {
        f"{len(table) - SHOWN_FUNCTIONS} others": table[SHOWN_FUNCTIONS:],
        f"all {len(table)}": table,
    }
    lines = [
        table[:SHOWN_FUNCTIONS],
        *(pd.DataFrame([{"function": name, **part[numbers].sum()}]) for name, part in sums.items()),
    ]
    print(f"import galvi {imported:.2f} s, first run {total:.2f} s of processor time, of which")
    print(pd.concat(lines).to_markdown(index=False, floatfmt=".2f"))


if __name__ == "__main__":
    main()
