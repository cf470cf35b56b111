"""The releases of an engine between which a user's own run changed, and the changes."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path

import numpy as np

from benchmarks.applications.releases.behaviour import CHANGE_FLOORS, Behaviour, ReleaseQuestions
from benchmarks.applications.releases.own_run import OwnRun
from benchmarks.applications.releases.requirements import (
    RANGE,
    by_age,
    installed,
    interpreter,
    listed,
)
from benchmarks.applications.releases.run_truth import RunTruth, truth_of
from benchmarks.store.isolated_environment import EnvironmentUnavailable
from galvi.arrays import Array

ORDER_CHANGE = 0.5  # orders that differ by more are not the same
# compiled models, and archives that older releases cannot read
ONE_RELEASE_SUFFIXES = (".mjb", ".mjz")


@dataclass(frozen=True)
class Difference:
    """The largest difference of a quantity between two releases; of differences that are changes,
    if there are any.

    Attributes
    ----------
    quantity
        positions, velocities, energy, accelerations
    sample
        index of the row
    size, relative
        largest difference of an entry, and its ratio to the row's largest entry in the earlier
        release
    floors
        the difference in units of the floor
    """

    quantity: str
    sample: int
    size: float
    relative: float
    floors: float

    @property
    def is_change(self) -> bool:
        """Whether it is larger than CHANGE_FLOORS floors."""
        return self.floors > CHANGE_FLOORS


@dataclass(frozen=True, eq=False)
class Step:
    """The step from one release to the next."""

    earlier: Behaviour
    later: Behaviour

    @property
    def differences(self) -> list[Difference]:
        """The largest difference of each quantity; empty where the run fails in a release."""
        before, after = self.earlier.quantities, self.later.quantities
        if before is None or after is None:
            return []
        return [
            _difference(
                name,
                before[name].values,
                after[name].values,
                np.maximum(before[name].floors, after[name].floors),
            )
            for name in before
        ]

    @property
    def order_changed(self) -> bool:
        """Whether both show an order and the orders differ by more than ORDER_CHANGE."""
        return abs(self.earlier.order - self.later.order) > ORDER_CHANGE

    @property
    def failure_changed(self) -> bool:
        """Whether the run fails in one of the two only."""
        return bool(self.earlier.failure) != bool(self.later.failure)

    @property
    def changed(self) -> bool:
        """Whether the run changed; the order, measured at other steps, does not count."""
        return self.failure_changed or any(difference.is_change for difference in self.differences)


def _difference(quantity: str, before: Array, after: Array, floors: Array) -> Difference:
    sizes = np.abs(after - before).max(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratios = np.where(sizes > 0.0, sizes / floors, 0.0)
    above = ratios > CHANGE_FLOORS
    k = int(np.argmax(np.where(above, sizes, 0.0) if above.any() else sizes))
    scale = float(np.abs(before[k]).max())
    relative = sizes[k] / scale if scale else sizes[k]
    return Difference(quantity, k, float(sizes[k]), float(relative), float(ratios[k]))


@dataclass(frozen=True, eq=False)
class Versions:
    """The behaviours of the compared releases.

    Attributes
    ----------
    behaviours
        behaviours by version, oldest first, including missing ones
    truth
        the truth of the run; None where there is none, for the `reason_without_truth`
    """

    run: OwnRun
    behaviours: dict[str, Behaviour]
    truth: RunTruth | None
    reason_without_truth: str = ""
    notes: list[str] = field(default_factory=list)

    @property
    def newest(self) -> Behaviour:
        """The behaviour of the installed release."""
        return self.behaviours[installed(self.run.package)]

    @property
    def steps(self) -> list[Step]:
        """The steps between successive releases that are not missing."""
        present = [behaviour for behaviour in self.behaviours.values() if not behaviour.missing]
        return [Step(*pair) for pair in pairwise(present)]

    def error(self, behaviour: Behaviour) -> float:
        """The error of the user's own run; NaN without a truth."""
        if self.truth is None or behaviour.motion is None:
            return math.nan
        return self.truth.error(behaviour.motion)


def compare_releases(
    run: OwnRun,
    versions: Sequence[str],
    halved: bool,
    folder: Path,
    report: Callable[[str], None] = lambda sentence: None,
) -> Versions:
    """A user's run in these releases and in the installed one.

    Parameters
    ----------
    halved
        whether further releases between the first and the last are run, by bisection, so that each
        change is between neighbours
    folder
        folder in which environments are made, one after the other, and removed

    Raises
    ------
    ValueError
        Where fewer than two releases can do it, or the file is of one release only.
    EnvironmentUnavailable
        Where the installed release cannot do it.
    """
    file = Path(run.job.get("file", ""))
    if file.suffix in ONE_RELEASE_SUFFIXES:
        raise ValueError(
            f"other releases cannot read {file.name}, which holds what one of them compiled; give "
            f"the .xml or .urdf that it was made from."
        )
    all_versions = sorted({*versions, installed(run.package)}, key=by_age)
    if len(all_versions) < 2:
        raise ValueError(f"name a release besides the installed one, {all_versions[0]}.")
    report(f"{run.package} {installed(run.package)}: your run")
    questions = ReleaseQuestions.of(run)
    behaviours: dict[str, Behaviour] = {}

    def behaviour_of(version: str) -> Behaviour:
        if version not in behaviours:
            report(f"{run.package} {version}")
            behaviours[version] = _behaviour(questions, version, folder)
        return behaviours[version]

    for version in all_versions:
        behaviour_of(version)
    notes = _halve(run.package, versions, behaviour_of) if halved else []
    ordered = {version: behaviours[version] for version in sorted(behaviours, key=by_age)}
    missing = [
        f"{name}: {behaviour.missing}" for name, behaviour in ordered.items() if behaviour.missing
    ]
    if len(ordered) - len(missing) < 2:
        raise ValueError("; ".join(["fewer than two releases can do your run", *missing]))
    report("truth")
    compared = Versions(run, ordered, *truth_of(run), notes)
    if not halved:
        notes += [
            f"To find the release: --releases {step.earlier.version}{RANGE}{step.later.version}."
            for step in compared.steps
            if step.changed
        ]
    return compared


def _behaviour(questions: ReleaseQuestions, version: str, folder: Path) -> Behaviour:
    """The behaviour of a release, or the reason why it is missing."""
    try:
        with interpreter(questions.run.package, version, folder) as python:
            return questions.behaviour_of(version, python)
    except (EnvironmentUnavailable, ValueError) as error:  # ValueError: other coordinates, no JSON
        return Behaviour(version, " ".join(str(error).split()))


def _halve(
    package: str, ends: Sequence[str], behaviour_of: Callable[[str], Behaviour]
) -> list[str]:
    """Run releases between the two ends until each change is between neighbours that can be run.

    Returns no notes, or one where an end is missing, so that there is nothing to halve.
    """
    earlier, later = behaviour_of(ends[0]), behaviour_of(ends[-1])
    missing = [behaviour for behaviour in (earlier, later) if behaviour.missing]
    if missing:
        return [f"No releases between the ends were tried, since {missing[0].version} is left out."]
    versions = listed(package)
    open_steps = [Step(earlier, later)]
    while open_steps:
        step = open_steps.pop()
        first, last = by_age(step.earlier.version), by_age(step.later.version)
        between = [version for version in versions if first < by_age(version) < last]
        while between and step.changed:
            middle = behaviour_of(between.pop(len(between) // 2))
            if not middle.missing:
                open_steps += [Step(step.earlier, middle), Step(middle, step.later)]
                break
    return []
