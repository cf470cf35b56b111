"""What events cost that do not occur, and what a million of them need.

python -m benchmarks.experiments.cost_of_events

The Sun and the outer planets at degree 8 and 200 days: three pairs of planets never come within
half an au of each other. Runs with and without these events are interleaved, in processor time, and
the ratios are medians of the rounds with their intervals. A harmonic oscillator passes its centre a
million times; the memory is by how much the search raises the most that the process has held.
"""

from __future__ import annotations

import resource
import time
from typing import Any

import numpy as np

import galvi
from benchmarks.statistics.paired import Interval, ratio

ROUNDS, STEPS = 15, 50_000
STEP = 200.0  # days
APART = 0.5  # au
EVENTS = 1_000_000


def shares(rounds: int = ROUNDS, steps: int = STEPS) -> dict[str, Interval]:
    """The time of a run with three events over that without, for states kept at all steps, with
    their curves, and at each hundredth, without."""
    problem = galvi.problems.outer_solar_system()
    method = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
    events = [galvi.events.within(k, k + 1, APART) for k in (1, 2, 3)]

    def seconds(**options: Any) -> float:
        begin = time.process_time()
        run = galvi.integrate(problem, method, STEP, steps, **options)
        spent = time.process_time() - begin
        assert run.events is None or len(run.events) == 0
        return spent

    found = {}
    for name, every in (("all states and curves kept", 1), ("each hundredth state kept", 100)):
        times = [[seconds(save_every=every, events=one) for one in (events, ())]
                 for _ in range(rounds + 1)]  # fmt: skip
        with_events, without = zip(*times[1:], strict=True)
        found[name] = ratio(with_events, without)
    return found


def passing(count: int) -> tuple[galvi.Trajectory, galvi.Event]:
    """A run with so many events, which keeps two states."""
    problem = galvi.problems.harmonic_oscillator()
    method = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
    event = galvi.Event(lambda q, v, t: q[0], name="centre")
    steps = int((count + 0.5) * np.pi / 2.0)
    return galvi.integrate(problem, method, 2.0, steps, save_every=steps), event


def megabytes(count: int = EVENTS) -> tuple[int, float]:
    """How many events are found, and by how much that raises the most memory held."""
    galvi.find_events(*passing(100))  # compiles
    run, event = passing(count)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    found = galvi.find_events(run, event)
    return len(found), (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1024.0


def main() -> None:
    """Print them."""
    count, size = megabytes()  # first: what comes before has held less
    print(f"{count} events: {size:.0f} MB", flush=True)
    for name, found in shares().items():
        print(f"{name:30} {found.median:6.3f}  ({found.low:.3f} to {found.high:.3f})")


if __name__ == "__main__":
    main()
