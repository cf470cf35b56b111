"""All that the commands run, as one value: `reports.contents` makes it, tests make small ones."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import pandas as pd

from benchmarks.checks.claim import Claim
from benchmarks.work_precision.targets import Target
from reports.results.section import Measure, Section


@dataclass(frozen=True)
class Suite:
    """The claims, comparisons and studies of a report.

    make_method     the constructor of claims' methods, `galvi.Galerkin`
    work_precision  (quick, report) -> errors and times of contenders
    problems        quick -> those that it can be asked for one by one, as `problem`; none
    cost            (quick, report) -> costs of a step
    sections        studies with sections of their own
    targets         aims for the times of `work_precision`
    engines         name: why it cannot be used here, or nothing; of every engine
    unavailable     the sentences by which contenders say that their engine is absent
    faults          sentences on what external integrators did wrong so far
    provenance      command -> versions, commit, machine, date
    in_workers      by id, the claims that time nothing: (quick) -> frame, which another process can
                    import and call
    """

    claims: tuple[Claim, ...]
    make_method: Any
    work_precision: Measure
    cost: Measure
    provenance: Callable[[str], Mapping[str, str]]
    sections: tuple[Section, ...] = ()
    targets: tuple[Target, ...] = ()
    engines: Callable[[], Mapping[str, str]] = dict
    unavailable: Callable[[], Collection[str]] = tuple
    faults: Callable[[], Collection[str]] = tuple
    problems: Callable[[bool], Sequence[str]] = lambda quick: ()
    in_workers: Mapping[str, Callable[[bool], pd.DataFrame]] = field(default_factory=dict)
