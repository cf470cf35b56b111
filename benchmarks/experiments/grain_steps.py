"""The step of a grain here and in an older checkout.

git worktree add FOLDER 4724a64
python -m benchmarks.experiments.grain_steps FOLDER

Grains of one motion in the rotor's wind, without contacts: 60 steps of 30 ms with two Gauss points
and C_d = 0.44, iterated to rounding. There each is a run of `galvi.integrate`, less one of a single
step, which takes away what a call costs; here they are a cloud in one thread. Each side has a
process of its own, and they take turns; times are of the processor.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from benchmarks.store.provenance import ROOT

STEPS, STEP, GRAINS, RUNS, ROUNDS = 60, 0.03, 4000, 50, 9
DIAMETERS = (100e-6, 400e-6)  # m
SIDE = """
import json, sys, time
import numpy as np
import galvi

diameter, steps, step, grains, runs = json.loads(sys.argv[1])
problem = galvi.problems.brownout(diameter, [8.5, 0.0, 12.0], [0.0, 1.0, 0.0])
method = galvi.Galerkin(galvi.Polynomials(2), galvi.gauss(2))


def seconds(call):
    begin = time.process_time()
    for _ in range(runs):
        result = call()
    return (time.process_time() - begin) / runs, result


%s
turn()
for line in sys.stdin:
    each, end = turn()
    print(json.dumps([1e6 * each, list(end)]), flush=True)
"""
THERE = """
def run(steps):
    return lambda: galvi.integrate(problem, method, step, steps, save_every=steps)


def turn():
    (short, _), (whole, found) = seconds(run(1)), seconds(run(steps))
    assert found.success
    return (whole - short) / (steps - 1), found.q[-1]
"""
HERE = """
from benchmarks.applications.brownout.cloud import CONSTANT, Cloud
from galvi.problems.brownout import GRAVITY
from benchmarks.applications.brownout.flights import follow

law, rates = Cloud(diameter, CONSTANT).rates
q, v, rates = (np.tile(x, (grains, 1)) for x in (problem.q0, problem.v0, rates))
start, runs = np.zeros(grains), 1


def turn():
    whole, found = seconds(lambda: follow(
        method, q, v, start, rates, law, step, step * steps, gravity=GRAVITY, threads=1
    ))
    assert found.steps.sum() == steps * grains
    return whole / steps / grains, found.q[-1]
"""


class Side:
    """A process of a checkout that steps when it is told."""

    def __init__(self, checkout: Path, code: str, diameter: float) -> None:
        self.process = subprocess.Popen(
            [sys.executable, "-c", SIDE % code,
             json.dumps([diameter, STEPS, STEP, GRAINS, RUNS])],
            cwd=checkout, env={**os.environ, "PYTHONPATH": str(checkout)}, text=True,
            stdin=subprocess.PIPE, stdout=subprocess.PIPE,
        )  # fmt: skip

    def turn(self) -> tuple[float, np.ndarray[Any, Any]]:
        """Microseconds of a step, and where the grain ends."""
        assert self.process.stdin is not None and self.process.stdout is not None
        self.process.stdin.write("\n")
        self.process.stdin.flush()
        microseconds, end = json.loads(self.process.stdout.readline())
        return microseconds, np.array(end)

    def close(self) -> None:
        """End it."""
        self.process.communicate()


def grain_steps(checkout: Path) -> pd.DataFrame:
    """A row for each diameter: microseconds of a step, medians of the rounds, and their ratio."""
    rows = []
    for diameter in DIAMETERS:
        there, here = Side(checkout, THERE, diameter), Side(ROOT, HERE, diameter)
        turns = [(there.turn(), here.turn()) for _ in range(ROUNDS)]
        there.close()
        here.close()
        old, new = (np.array([turn[side][0] for turn in turns]) for side in (0, 1))
        ratio = old / new
        rows.append({
            "micrometres": 1e6 * diameter, "there [us]": np.median(old),
            "here [us]": np.median(new), "ratio": np.median(ratio), "lowest": ratio.min(),
            "highest": ratio.max(), "apart [m]": np.abs(turns[0][0][1] - turns[0][1][1]).max(),
        })  # fmt: skip
    return pd.DataFrame(rows)


def main() -> None:
    """Print the table."""
    folder = Path(sys.argv[1]).resolve() if len(sys.argv) == 2 else None
    if folder is None or not (folder / "galvi").is_dir():
        sys.exit(f"expected the folder of a checkout that has galvi; received {sys.argv[1:]}.")
    print(grain_steps(folder).to_string(index=False))


if __name__ == "__main__":
    main()
