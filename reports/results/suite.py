"""What the commands run, as one value: tests hand in small ones."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from benchmarks.checks.claim import Claim
from benchmarks.work_precision.targets import Target
from reports.results.study import Measure, Study


@dataclass(frozen=True)
class Table:
    """A study that is shown as a table.

    name      of its files, e.g. "ephemeris"
    title     its heading on the page
    text      what the reader should know, in a few sentences
    measure   (quick, report) -> frame
    headings  column: what stands above it on the page
    open      whether outsiders take part: its measure takes them as `outsiders`
    """

    name: str
    title: str
    text: str
    measure: Measure
    headings: Mapping[str, str]
    open: bool = False


@dataclass(frozen=True)
class Suite:
    """The claims, and what else is measured.

    make_method     what claims build their methods with, `galvi.Galerkin`
    work_precision  (quick, report) -> errors and times of contenders
    problems        quick -> those that it can be asked for one by one, as `problem`; none
    cost            (quick, report) -> what a step costs
    tables          further studies, each shown as a table
    studies         those with sections of their own
    targets         what the times of `work_precision` are held against
    engines         name: why it cannot be used here, or nothing; of every engine
    unavailable     the sentences by which contenders say that their engine is absent
    faults          what outsiders did wrong so far
    provenance      command -> versions, commit, machine, date
    ahead           whether a second process may study claims, those of `load` by their ids
    """

    claims: tuple[Claim, ...]
    make_method: Any
    work_precision: Measure
    cost: Measure
    provenance: Callable[[str], Mapping[str, str]]
    tables: tuple[Table, ...] = ()
    studies: tuple[Study, ...] = ()
    targets: tuple[Target, ...] = ()
    engines: Callable[[], Mapping[str, str]] = dict
    unavailable: Callable[[], Collection[str]] = tuple
    faults: Callable[[], Collection[str]] = tuple
    problems: Callable[[bool], Sequence[str]] = lambda quick: ()
    ahead: bool = False


def load() -> Suite:
    """The real one; imported when called, so that a mistyped word is answered at once."""
    import galvi
    from benchmarks.claims import CLAIMS
    from benchmarks.claims.agreements import AGREEMENTS, engines, unavailable
    from benchmarks.store.provenance import provenance
    from benchmarks.studies import ephemeris, high_eccentricity, recommendation, start_up
    from benchmarks.work_precision.cost import cost_table
    from benchmarks.work_precision.run import problems, work_precision
    from benchmarks.work_precision.targets import TARGETS
    from reports.contents import STUDIES

    sky = Table(
        "ephemeris",
        "Point masses against JPL's ephemeris",
        ephemeris.EXPLANATION,
        ephemeris.ephemeris_table,
        {
            "contender": "contender",
            "body": "body",
            "days": "days",
            "difference_au": "from DE421 [au]",
            "difference_arcsec": "seen from the Sun [″]",
            "relativity_au": "relativity alone [au]",
            "integration_error_au": "error of the run [au]",
            "status": "status",
        },
        open=True,
    )
    stress = Table(
        "high_eccentricity",
        "Through the pericentre at high eccentricity",
        high_eccentricity.EXPLANATION,
        high_eccentricity.high_eccentricity_table,
        {
            "eccentricity": "eccentricity",
            "contender": "contender",
            "settings": "setting",
            "error": "error",
            "energy_error": "energy error",
            "evaluations": "force evaluations",
            "status": "status",
        },
        open=True,
    )
    advice = Table(
        "recommendation",
        "Which degree and step for an error: promises and findings",
        recommendation.EXPLANATION,
        recommendation.recommendation_table,
        {
            "problem": "problem",
            "asked": "error asked",
            "measured_over": "measured over",
            "degree": "degree",
            "step": "step",
            "predicted": "predicted",
            "found": "found",
            "evaluations": "force evaluations",
            "seconds": "time [s]",
            "scan_seconds": "time of the scan [s]",
            "promise": "promise",
        },
    )
    fresh = Table(
        "start_up",
        "The first call of a fresh process, and the memory of long runs",
        start_up.EXPLANATION,
        start_up.start_up_table,
        {
            "problem": "problem",
            "import": "import galvi [s]",
            "cold": "first run, cold [s of processor]",
            "warm": "first run, warm [s]",
            "import_in_numpys": "import galvi / import numpy",
            "warm_in_numpys": "warm / import numpy",
            "few_steps": "memory, few steps [MiB]",
            "many_steps": "memory, many steps [MiB]",
        },
    )
    tables = (sky, stress, advice, fresh)
    measured = (work_precision, cost_table, provenance)
    checks = (*CLAIMS, *AGREEMENTS)
    absences = (engines, unavailable)
    told = (tables, STUDIES, TARGETS, *absences)
    return Suite(checks, galvi.Galerkin, *measured, *told, problems=problems, ahead=True)
