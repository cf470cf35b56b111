"""The contents of the report: claims, comparisons and studies. Only entry points import it."""

from __future__ import annotations

from benchmarks.claims import AGREEMENTS, CLAIMS
from benchmarks.claims.agreements import engines
from benchmarks.store.provenance import provenance
from benchmarks.work_precision.cost import cost_table
from benchmarks.work_precision.run import problems, work_precision
from benchmarks.work_precision.targets import TARGETS
from reports.results.suite import Suite
from reports.studies.costs import BROWNOUT_CLOUD, ENSEMBLES, NUMBER_OF_BODIES, START_UP
from reports.studies.engines import ENGINE_VERSIONS, EPHEMERIS, FORCES, TREES
from reports.studies.long_runs import FREE_BODY_DRIFT, ROUND_OFF
from reports.studies.taxonomy import TAXONOMY

SECTIONS = (  # in the order of the page
    ROUND_OFF,
    NUMBER_OF_BODIES,
    FREE_BODY_DRIFT,
    TREES,
    ENGINE_VERSIONS,
    TAXONOMY,
    EPHEMERIS,
    FORCES,
    BROWNOUT_CLOUD,
    START_UP,
    ENSEMBLES,
)


def load() -> Suite:
    """The report's suite."""
    return Suite(
        claims=(*CLAIMS, *AGREEMENTS),
        work_precision=work_precision,
        cost=cost_table,
        provenance=provenance,
        sections=SECTIONS,
        targets=TARGETS,
        engines=engines,
        problems=problems,
    )
