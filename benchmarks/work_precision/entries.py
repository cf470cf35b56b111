"""A problem as a table: each contender with its numbers of steps or its tolerances."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from benchmarks.work_precision.galvi_methods import gauss_collocation
from benchmarks.work_precision.problem import (
    EPS,
    Participant,
    Setting,
    Truth,
    WorkPrecisionProblem,
    adaptive,
    fixed,
    galvi_label,
    largest_difference,
    stopped_early_too,
)
from galvi import Problem
from references import Contender

SECOND_VALUE, MIDDLE_VALUES = slice(1, 2), slice(1, 3)  # values that the quick form keeps


class Entry(NamedTuple):
    """A contender of a problem.

    Attributes
    ----------
    values
        numbers of steps if all are int, otherwise tolerances
    label
        label in tables; "" for the contender's name
    quick_values
        slice of the values that the quick form keeps; all where that is empty
    stops_early_too
        whether settings are added that stop galvi's iterations early, except in the quick form
    options
        options of every setting
    """

    contender: Contender
    values: Sequence[float]
    label: str = ""
    quick_values: slice = SECOND_VALUE
    stops_early_too: bool = False
    options: Mapping[str, Any] = {}

    def participant(self, duration: float, quick: bool) -> Participant:
        """The contender with its settings, from coarse to fine."""
        values = self.values[self.quick_values] or self.values if quick else self.values
        are_steps = all(isinstance(number, int) for number in values)
        settings: list[Setting] = (
            [fixed(duration, int(number)) for number in values]
            if are_steps
            else adaptive("tolerance", values)
        )
        settings = [{**setting, **self.options} for setting in settings]
        if self.stops_early_too and not quick:
            settings = stopped_early_too(settings)
        return Participant(self.label or self.contender.name, self.contender, settings)


def galvi_entries(counts: Mapping[int, Sequence[int]], **fields: Any) -> list[Entry]:
    """Entries of Gauss collocation from degree -> numbers of steps; `fields` are fields of each."""
    return [
        Entry(gauss_collocation(degree), steps, galvi_label(degree), **fields)
        for degree, steps in counts.items()
    ]


def general_kernel(degree: int, counts: Sequence[int]) -> Entry:
    """The entry of this degree, solved by Newton's method alone."""
    label = f"{galvi_label(degree)}, general kernel"
    return Entry(gauss_collocation(degree), counts, label, options={"solver": "newton"})


def compared(
    problem: Problem,
    duration: float,
    quick: bool,
    entries: Sequence[Entry],
    truth: Callable[[], Truth],
    **fields: Any,
) -> WorkPrecisionProblem:
    """The entries on one problem; `fields` are further fields of WorkPrecisionProblem."""
    participants = tuple(entry.participant(duration, quick) for entry in entries)
    fields = {"distance": largest_difference, **fields}
    return WorkPrecisionProblem(problem, duration, participants, truth, **fields)


def truth_to_rounding(
    reference: Contender,
    problem: Problem,
    duration: float,
    quantity: str,
    size: float | None = None,
) -> Callable[[], Truth]:
    """A function that returns the truth of a reference whose error is the rounding of its numbers.

    Parameters
    ----------
    of
        the rounded numbers in words
    size
        size of the numbers; None for that of the largest
    """

    def truth() -> Truth:
        run = reference.run(problem, duration, {"samples": 1})
        largest = float(np.max(np.abs(run.q[-1]))) if size is None else size
        description = run.method.removesuffix(" samples=1")  # closed forms name their samples
        return Truth(
            run.q[-1], 0.5 * EPS * largest, f"{description}; to the rounding of the {quantity}"
        )

    return truth
