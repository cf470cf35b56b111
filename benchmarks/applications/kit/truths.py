"""A truth from two sources, with the error that their disagreement leaves it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.applications.judging.candidate import Source as Piecewise
from benchmarks.applications.judging.truth import in_pieces
from galvi import Problem, Trajectory
from galvi.arrays import Array

SAMPLES = 10  # largest number of times of a truth after its start
LARGEST_DISAGREEMENT = 1e-9  # of positions and velocities, relative to their largest entry
SAFETY = 10.0  # ratio of the stated error to the largest difference up to that time
ROUNDING = 8.0 * 2.0**-52  # relative to the largest entry
SHIFT = 2.0**-52  # of the start, relative
RULE = (
    f"{SAFETY:g} times the largest difference between the two sources up to that time, plus "
    f"{ROUNDING:.1e} times the largest entry; the second source also runs from positions shifted "
    f"by {SHIFT:.1e}, relatively, and the larger difference counts; states end where it exceeds "
    f"{LARGEST_DISAGREEMENT:g} of the largest entry"
)

States = tuple[Array, Array]  # positions and velocities at the start and SAMPLES times after it
Differences = Callable[[Array, Array], Array]


@dataclass(frozen=True)
class Source:
    """A label and a function that computes the states of a problem over a duration."""

    label: str
    states: Callable[[Problem, float], States]


@dataclass(frozen=True, eq=False)
class Truth:
    """States that two sources agree on, the start first.

    Attributes
    ----------
    t : array, shape (rows,)
    q, v : array, shape (rows, ...)
        states of the first source
    error_q, error_v : array, shape (rows,)
        stated errors by RULE; 0 at the start
    """

    t: Array
    q: Array
    v: Array
    error_q: Array
    error_v: Array


def distances(states: Array, reference_states: Array) -> Array:
    """Distances (rows, bodies) of points or velocities from reference ones, (rows, bodies, d)."""
    return np.linalg.norm(states - reference_states, axis=-1)


def agreed_truth(
    problem: Problem,
    duration: float,
    sources: tuple[Source, Source],
    shifted: Problem,
    differences: tuple[Differences, Differences] = (distances, distances),
) -> Truth:
    """The states of the first source, before the second one disagrees.

    Parameters
    ----------
    shifted
        the problem from a start that differs by SHIFT
    differences
        functions of two arrays (rows, ...), of positions and of velocities, that return differences

    Raises
    ------
    ValueError
        Where the sources disagree at the first time after the start.
    """
    q, v = sources[0].states(problem, duration)
    sizes = [float(np.max(np.abs(x))) for x in (q, v)]
    disagreements = [np.zeros(len(q)), np.zeros(len(q))]
    for start in (problem, shifted):
        compared = zip(
            disagreements, differences, (q, v), sources[1].states(start, duration), strict=True
        )
        disagreements = [
            np.maximum(gap, np.maximum.accumulate(largest(difference(x, y))))
            for gap, difference, x, y in compared
        ]
    agree = [
        gap <= LARGEST_DISAGREEMENT * size for gap, size in zip(disagreements, sizes, strict=True)
    ]
    is_lost = ~(agree[0] & agree[1])
    rows = int(np.argmax(is_lost)) if is_lost.any() else len(is_lost)
    if rows < 2:
        raise ValueError(
            f"two sources of the truth of {problem.name} must agree to {LARGEST_DISAGREEMENT:g} at "
            f"the first time; received differences of {disagreements[0][1]:.1e} in position "
            f"between {sources[0].label} and {sources[1].label}. Shorten its duration."
        )
    errors = [
        SAFETY * gap + ROUNDING * size for gap, size in zip(disagreements, sizes, strict=True)
    ]
    for error in errors:
        error[0] = 0.0
    t = problem.t0 + duration * np.arange(SAMPLES + 1) / SAMPLES
    return Truth(*(x[:rows] for x in (t, q, v, *errors)))


def largest(differences: Array) -> Array:
    """The largest magnitude of an entry of each row, (rows,)."""
    return np.max(np.abs(differences.reshape(len(differences), -1)), axis=1)


def sampled(contender: Any, label: str, setting: Mapping[str, Any] | None = None) -> Source:
    """The source of a contender that is as accurate between its steps as at their ends."""

    def states(problem: Problem, duration: float) -> States:
        run = contender.run(problem, duration, {"samples": SAMPLES, **(setting or {})})
        return completed(run, label)

    return Source(label, states)


def restarted(contender: Any, label: str, setting: Mapping[str, Any]) -> Source:
    """The source of a contender that is restarted at each time, since it interpolates between its
    steps."""
    piecewise = Piecewise(label, label, contender, setting)

    def states(problem: Problem, duration: float) -> States:
        ends = problem.t0 + duration * np.arange(1, SAMPLES + 1) / SAMPLES
        return completed(in_pieces(piecewise, problem, ends)[0], label)

    return Source(label, states)


def completed(run: Trajectory, label: str) -> States:
    """Positions and velocities of a run; ValueError where it failed or ended early."""
    if not run.success or len(run.t) != SAMPLES + 1:
        raise ValueError(f"{label} must reach the end of {run.problem.name}: {run.status}")
    return run.q, run.v
