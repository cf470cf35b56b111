"""The contents of the pages of results, during a build and at its end."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd

from benchmarks.claims.statements import FALSE, PAPERS, STATUSES, Statement
from benchmarks.claims.statements import statements as printed_statements
from reports.figures.drawing import Gallery
from reports.figures.picture import Picture
from reports.results.claim_results import ClaimResult
from reports.results.comparison import Comparison
from reports.results.machines import Machine, other_machines
from reports.results.options import Options
from reports.results.origins import read_origins
from reports.results.section import Figure
from reports.results.section_result import SectionResult
from reports.results.suite import Suite
from reports.results.summary import Summary, summary
from reports.site.claims import ClaimGroup, ClaimSection, claim_groups, claim_section
from reports.site.comparisons import (
    AbsentEngine,
    DefaultStep,
    absent_engines,
    default_step,
    is_run_by,
)
from reports.site.sources import Source, sources
from reports.tables.comparison_tables import ComparisonTables, comparison_tables
from reports.tables.profiles import profile_table
from reports.tables.summary_sentences import summary_sentences

if TYPE_CHECKING:
    from reports.tracking.record import History

TIMES = "work_precision.csv"
NO_PICTURES = Gallery({}, {})


@dataclass(frozen=True, eq=False)
class Report:
    """The results from which the pages are made; derived contents are properties.

    Attributes
    ----------
    provenance
        provenance of the pages
    history
        the stored benches; None if there are none
    from_rows
        whether all rows were stored by earlier commands
    left
        names of the parts that are still to be measured
    """

    suite: Suite
    options: Options
    checked: Sequence[ClaimResult]
    comparison: Comparison
    sections: Sequence[SectionResult]
    provenance: Mapping[str, str]
    gallery: Gallery = NO_PICTURES
    history: History | None = None
    from_rows: bool = False
    pending: Sequence[str] = ()

    @property
    def out(self) -> Path:
        """The folder of the report."""
        return self.options.out

    @cached_property
    def origins(self) -> Mapping[str, Mapping[str, str]]:
        """The origin of each file of rows."""
        return read_origins(self.out)

    @property
    def origin(self) -> Mapping[str, str]:
        """The origin of the comparisons' rows; the pages' provenance if it is not recorded."""
        return self.origins.get(TIMES, self.provenance)

    @cached_property
    def sources(self) -> list[Source]:
        """The origins of the rows of each part."""
        return sources(self.out, self.checked, self.comparison, self.sections)

    @cached_property
    def summary(self) -> Summary:
        """The summary of the rows of all claims."""
        return summary(self.checked)

    @cached_property
    def unchecked(self) -> list[str]:
        """Ids of the suite's claims that have no rows."""
        checked = {claim_result.claim.id for claim_result in self.checked}
        return [claim.id for claim in self.suite.claims if claim.id not in checked]

    @cached_property
    def claims(self) -> list[ClaimSection]:
        """A section for each claim with rows."""
        return [claim_section(claim_result, self.gallery) for claim_result in self.checked]

    @cached_property
    def claim_groups(self) -> list[ClaimGroup]:
        """The claims under the headings of their documents."""
        return claim_groups(self.claims)

    @cached_property
    def claim_ids(self) -> list[str]:
        """The ids of the claims: V before L before A, each by number."""

        def by_number(id: str) -> tuple[int, int]:
            return "VLA".find(id[:1]), int("".join(filter(str.isdigit, id)) or 0)

        return sorted((section.claim.id for section in self.claims), key=by_number)

    @cached_property
    def statements(self) -> Sequence[Statement]:
        """The statements of the papers."""
        return printed_statements()

    @property
    def misprints(self) -> list[Statement]:
        """The statements that are false as printed."""
        return [statement for statement in self.statements if statement.status == FALSE]

    @property
    def statuses(self) -> pd.DataFrame:
        """A row for each status: how many statements of each paper have it."""
        pairs = pd.DataFrame(
            {
                "status": [statement.status for statement in self.statements],
                "paper": [statement.where[0] for statement in self.statements],
            }
        )
        counts = pd.crosstab(pairs["status"], pairs["paper"])
        ordered = [status for status in STATUSES if status in counts.index]
        return counts.reindex(index=ordered, columns=list(PAPERS), fill_value=0).reset_index()

    @cached_property
    def tables(self) -> ComparisonTables:
        """The tables of all comparisons; targets only for full runs."""
        return comparison_tables(self.runs, () if self.options.quick else self.suite.targets)

    @property
    def runs(self) -> pd.DataFrame | None:
        """The rows of all comparisons."""
        return self.comparison.work_precision

    @cached_property
    def absent(self) -> tuple[AbsentEngine, ...]:
        """The engines that were not installed."""
        return absent_engines(self.origin, self.runs, self.tables.targets, self.summary.rows)

    @cached_property
    def default_step(self) -> DefaultStep | None:
        """MuJoCo's RK4 at its default step."""
        return default_step(self.runs)

    @cached_property
    def machines(self) -> list[Machine]:
        """Other machines, whose rows were merged into this report."""
        return other_machines(self.out)

    @cached_property
    def problems(self) -> dict[str, pd.DataFrame]:
        """The rows of each compared problem."""
        if self.runs is None:
            return {}
        return {str(name): rows for name, rows in self.runs.groupby("problem", sort=False)}

    @cached_property
    def profiles(self) -> pd.DataFrame:
        """The profile table of all problems."""
        return pd.DataFrame() if self.runs is None else profile_table(self.runs)

    @property
    def sentences(self) -> list[str]:
        """A sentence for each problem on which code is fastest."""
        return summary_sentences(self.tables.ratios) if len(self.tables.ratios) else []

    def pictures(self, figures: Iterable[Figure]) -> list[Picture]:
        """The pictures of these figures, where they were drawn."""
        drawn = self.gallery.pictures
        return [drawn[figure.name] for figure in figures if figure.name in drawn]

    def picture_named(self, name: str) -> list[Picture]:
        """A list with the picture of this name; [] if it was not drawn."""
        return [picture for picture in self.gallery.pictures.values() if picture.name == name]

    def undrawn(self, figures: Iterable[Figure]) -> list[str]:
        """A sentence for each of these figures that is missing."""
        missing = self.gallery.missing
        return [missing[figure.name] for figure in figures if figure.name in missing]

    def remarks(self, rows: pd.DataFrame) -> list[str]:
        """A sentence for each run that has a status, except those of absent engines."""
        noted = rows[rows["status"] != ""]
        return [
            f"{row['contender']}, {row['settings']}: {row['status']}"
            for _, row in noted.iterrows()
            if not any(is_run_by(engine.name, row["contender"]) for engine in self.absent)
        ]

    @property
    def studies(self) -> list[SectionResult]:
        """The studies with rows."""
        return [
            section_result for section_result in self.sections if section_result.table is not None
        ]

    @property
    def studies_left_out(self) -> list[tuple[str, str]]:
        """The title of each study without rows, and why it did not run, or ""."""
        return [
            (section_result.section.title, section_result.failure or section_result.note)
            for section_result in self.sections
            if section_result.table is None
        ]
