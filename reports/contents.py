"""The contents of the report: claims, comparisons and studies. Only entry points import it."""

from __future__ import annotations

from functools import partial

import pandas as pd

import galvi
from benchmarks.claims import AGREEMENTS, CLAIMS
from benchmarks.claims.agreements import engines
from benchmarks.store.provenance import provenance
from benchmarks.work_precision.cost import cost_table
from benchmarks.work_precision.run import problems, work_precision
from benchmarks.work_precision.targets import TARGETS
from reports.results.suite import Suite
from reports.studies.costs import BROWNOUT_CLOUD, ENSEMBLES, NUMBER_OF_BODIES, START_UP
from reports.studies.engines import ENGINE_VERSIONS, EPHEMERIS, FORCES, TREES
from reports.studies.faults import MUTANTS
from reports.studies.long_runs import FREE_BODY_DRIFT, ROUND_OFF
from reports.studies.taxonomy import TAXONOMY

CHECKS = (*CLAIMS, *AGREEMENTS)
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
        claims=CHECKS,
        make_method=galvi.Galerkin,
        work_precision=work_precision,
        cost=cost_table,
        provenance=provenance,
        sections=SECTIONS,
        targets=TARGETS,
        engines=engines,
        problems=problems,
        in_workers={
            **{one.id: partial(study_claim, one.id) for one in CHECKS if not one.timed},
            **{one.title: partial(study_section, one.name) for one in SECTIONS if not one.timed},
        },
    )


def study_claim(name: str, quick: bool) -> pd.DataFrame:
    """Run the study of the claim with this id, without progress output; returns its frame."""
    (claim,) = (one for one in CHECKS if one.id == name)
    return claim.study(galvi.Galerkin, quick, lambda sentence: None)


def study_section(name: str, quick: bool) -> pd.DataFrame:
    """The frame of the section with this name, without progress output."""
    (section,) = (one for one in SECTIONS if one.name == name)
    return section.measure(quick, lambda sentence: None)
