"""The first pages of a build, before its measurements: quick claims and headline comparisons."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Sequence
from contextlib import closing, suppress
from typing import Any

import pandas as pd

from reports.build.workers import study_in_workers
from reports.figures.headlines import HEADLINES
from reports.results.cache import BuildCache
from reports.results.claim_results import ClaimResult, check, claim_studies
from reports.results.comparison import Comparison
from reports.results.suite import Suite

CLAIMS, COMPARISONS, STUDIES = "the claims in full", "all comparisons", "the studies"  # in order
PATIENCE_SECONDS = 75.0  # seconds for claims


def first_look(suite: Suite) -> tuple[list[ClaimResult], Comparison]:
    """The claims and comparisons of the first pages, in their quick form; nothing is stored.

    These are the untimed claims that finish within about PATIENCE_SECONDS seconds, and the
    comparisons that the headlines show. Failures are left for the build itself to report.
    """
    start, cache = time.perf_counter(), BuildCache()
    with closing(study_in_workers(claim_studies(suite.claims, quick=True), cache)) as finished:
        for _ in finished:
            if time.perf_counter() - start > PATIENCE_SECONDS:
                break
    checked = check([claim for claim in suite.claims if claim.id in cache.entries], True, cache)
    problems_of_headlines = {name for headline in HEADLINES for name in headline.options["panels"]}
    tables = []
    for problem in problems_of_headlines.intersection(suite.problems(True)):
        with suppress(Exception):
            tables.append(suite.work_precision(True, lambda sentence: None, problem=problem))
    runs = pd.concat(tables, ignore_index=True) if tables else None
    return checked, Comparison(runs, None)


def remembering(map_figures: Callable[..., Iterable[Any]]) -> Callable[..., list[Any]]:
    """Wrap `map_figures` so that it draws each (figure, table) once."""
    table_and_picture: dict[
        tuple[str, int], tuple[Any, Any]
    ] = {}  # keeps the table, or its id could be reused

    def draw(function: Callable[[Any], Any], jobs: Sequence[Any]) -> list[Any]:
        keys = [(figure.name, id(table)) for figure, table in jobs]
        new = [
            key_job
            for key_job in zip(keys, jobs, strict=True)
            if key_job[0] not in table_and_picture
        ]
        pictures = map_figures(function, [job for _, job in new])
        for (key, (_, table)), picture in zip(new, pictures, strict=True):
            table_and_picture[key] = table, picture
        return [table_and_picture[key][1] for key in keys]

    return draw
