"""The claims, comparisons and studies that the commands run, as one value."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field

from benchmarks.checks.claim import Claim
from benchmarks.work_precision.targets import Target
from reports.results.section import Measure, Section


@dataclass(frozen=True)
class Suite:
    """The claims, comparisons and studies of a report.

    Attributes
    ----------
    work_precision
        (quick, report) -> errors and times of contenders
    problems
        quick -> the values that the argument `problem` of `work_precision` may have; () by default
    cost
        (quick, report) -> costs of a step
    sections
        studies with their own sections
    targets
        targets for the times of `work_precision`
    engines
        () -> (name of an optional engine -> why it cannot be used here, or "")
    faults
        () -> sentences on the faults that external integrators have shown
    definitions
        id of the claim of an external integrator -> file and line of its class
    provenance
        command -> versions, commit, machine, date
    """

    claims: tuple[Claim, ...]
    work_precision: Measure
    cost: Measure
    provenance: Callable[[str], Mapping[str, str]]
    sections: tuple[Section, ...] = ()
    targets: tuple[Target, ...] = ()
    engines: Callable[[], Mapping[str, str]] = dict
    faults: Callable[[], Collection[str]] = tuple
    definitions: Mapping[str, tuple[str, int]] = field(default_factory=dict)
    problems: Callable[[bool], Sequence[str]] = lambda quick: ()
