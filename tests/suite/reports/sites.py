"""Builders of sites for tests: the pages' text without Sphinx, or the pages of results alone."""

from __future__ import annotations

from contextlib import contextmanager

import pytest

from benchmarks.store.atomic import write
from reports.site import pages
from reports.site.build import SiteBuilder
from reports.site.report import Report

BUILDER = "reports.build.build.SiteBuilder"


class TextSite(SiteBuilder):
    """Writes the source that Sphinx would read in place of the first page and pages of results."""

    def __enter__(self):
        return self

    def __exit__(self, *error):
        pass

    def __call__(self, report: Report):
        for name in ("index", *(f"{pages.RESULTS}/{page}" for page in pages.PAGES)):
            write(report.out / f"{name}.html", pages.page(name, report))
        return []


class SiteOfResults(SiteBuilder):
    """Builds the pages of results alone, in seconds."""

    def settings(self):
        return super().settings() | {
            "root_doc": f"{pages.RESULTS}/index",
            "include_patterns": [f"{pages.RESULTS}/**"],
            "suppress_warnings": ["toc.not_included"],
        }


@contextmanager
def pages_of_results():
    """A context in which builds make real pages of results."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(BUILDER, SiteOfResults)
        yield
