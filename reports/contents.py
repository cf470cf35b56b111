"""The contents of the report: claims, comparisons and studies. Only entry points import it."""

from __future__ import annotations

from benchmarks.claims import AGREEMENTS, CLAIMS
from benchmarks.claims.agreements import engines
from benchmarks.store.provenance import provenance
from benchmarks.work_precision.cost import cost_table
from benchmarks.work_precision.run import problems, work_precision
from benchmarks.work_precision.targets import TARGETS
from reports.results.suite import Suite
from reports.studies.costs import BROWNOUT_CLOUD, START_UP
from reports.studies.engine_versions import ENGINE_VERSIONS
from reports.studies.ensembles import ENSEMBLES
from reports.studies.ephemeris import EPHEMERIS
from reports.studies.faults import MUTANTS
from reports.studies.forces import FORCES
from reports.studies.free_body_drift import FREE_BODY_DRIFT
from reports.studies.number_of_bodies import NUMBER_OF_BODIES
from reports.studies.round_off import ROUND_OFF
from reports.studies.taxonomy import TAXONOMY
from reports.studies.trees import TREES

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
    MUTANTS,
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
