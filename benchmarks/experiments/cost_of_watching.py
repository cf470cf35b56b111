"""What judging the energy of a run takes, of each trajectory that `track` times.

python -m benchmarks.experiments.cost_of_watching

Processor time: the least of interleaved calls, so that other load counts little.
"""

from __future__ import annotations

import time
from dataclasses import asdict
from functools import partial

import numpy as np

from benchmarks.timings.catalogue import TRAJECTORIES
from benchmarks.timings.worker import method_of, problem_of
from galvi.run.integrate import checked
from galvi.run.loop import run_steps

SECONDS, ROUNDS = 1.0, 200  # of each, at most


def run_of(case):
    """Its run, prepared."""
    words = asdict(case)
    problem, method = problem_of(words), method_of(words)
    return partial(
        run_steps, *checked(problem, method, case.step, case.steps, save_every=case.steps)
    )


def seconds(call):
    """Processor time of one call."""
    begin = time.process_time()
    call()
    return time.process_time() - begin


def least(*calls):
    """The least time of each of some calls, interleaved."""
    once = sum(map(seconds, calls))
    rounds = int(min(max(SECONDS / once, 5), ROUNDS))
    return np.min([[seconds(call) for call in calls] for _ in range(rounds)], axis=0)


def main():
    """Print a line for each trajectory."""
    print("ms of the run, us of judging it, and its share")
    total, judging = 0.0, []
    for case in TRAJECTORIES:
        run = run_of(case)
        run()
        watched, other = least(run, partial(run, watched=False))
        total, share = total + watched, (watched - other) / watched
        judging.append((watched - other, share))
        print(f"{case.name:45s} {1e3 * watched:7.2f} {1e6 * judging[-1][0]:5.0f} {share:7.1%}")
    spent, shares = np.transpose(judging)
    print(f"{spent.sum() / total:.1%} of all, {np.median(shares):.1%} in the median")


if __name__ == "__main__":
    main()
