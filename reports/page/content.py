"""What the pages of a report hold."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import pandas as pd

from benchmarks.checks.bounds import NOT_RUN, VERDICTS
from benchmarks.checks.claim import Row
from benchmarks.work_precision.labels import label_of
from benchmarks.work_precision.problem import STOPS
from references.stored.provenance import HEADINGS, truths
from reports.figures.drawing import Gallery
from reports.figures.headlines import HEADLINES
from reports.figures.picture import Picture, slug
from reports.figures.profiles import PROFILES
from reports.page.chooser import chooser, default_step, filters
from reports.page.claim_groups import claim_groups
from reports.page.claim_section import claim_section
from reports.page.motion import motions
from reports.page.site import Explained, Grid, grid, ledger
from reports.page.sources import commands, files, sources, statements, without_folder
from reports.results.claim_results import ClaimResult
from reports.results.comparison import Comparison
from reports.results.machines import Machine, machines
from reports.results.options import Options
from reports.results.origins import read_origins
from reports.results.section import long_form_only
from reports.results.section_result import SectionResult
from reports.results.suite import Suite
from reports.results.summary import many, summary
from reports.tables.comparison_tables import (
    ComparisonTables,
    built,
    elsewhere,
    energies,
    fastest_cells,
    mujoco_overhead,
    of_mujoco,
    readable_ratios,
)
from reports.tables.number_format import known as number_known
from reports.tables.profiles import profile_table
from reports.tables.study_table import readable_cost, without_common
from reports.tables.summary_sentences import chances, summary_sentences
from reports.tables.targets_table import TEXT, readable_targets
from reports.tables.targets_table import summary as targets_summary

ENGINES = {
    "rebound": "REBOUND",
    "mujoco-core": "MuJoCo",
    "scipy": "SciPy",
    "heyoka": "heyoka",
}
NOT_INSTALLED = "not installed"


@dataclass(frozen=True)
class Absent:
    """An engine that was not installed.

    text  a sentence on what is missing
    why   how it was told, with the remedy; empty where nobody asked for it
    """

    name: str
    text: str
    why: str


def peers(origin: Mapping[str, str]) -> str:
    """Those of ENGINES that were installed, e.g. "REBOUND, MuJoCo and SciPy"."""
    *most, last = [name for key, name in ENGINES.items() if origin.get(key) != NOT_INSTALLED]
    return f"{', '.join(most)} and {last}" if most else last


def absent(
    origin: Mapping[str, str],
    runs: pd.DataFrame | None,
    targets: pd.DataFrame,
    rows: Sequence[Row],
) -> tuple[Absent, ...]:
    """Those of ENGINES that were not installed, by the versions in the comparisons' origin."""
    return tuple(
        _absent(engine, name, runs, targets, rows)
        for engine, name in ENGINES.items()
        if origin.get(engine) == NOT_INSTALLED
    )


def is_of(name: str, contender: str) -> bool:
    """Whether a contender is run by this engine."""
    return contender.split(",")[0].split(" ")[0] == name


def _absent(
    engine: str, name: str, runs: pd.DataFrame | None, targets: pd.DataFrame, rows: Sequence[Row]
) -> Absent:
    asked = [is_of(name, one) for one in targets["against"]] if len(targets) else []
    unmet = int((targets[asked]["verdict"] == NOT_RUN).sum()) if any(asked) else 0
    ids = dict.fromkeys(row.id for row in rows if row.verdict == NOT_RUN and row.absent == engine)
    why = "" if runs is None else next(
        (status for who, status in zip(runs["contender"], runs["status"], strict=True)
         if is_of(name, who) and status), "",
    )  # fmt: skip
    missing = ["its times", *([many(unmet, "target")] if unmet else [])]
    missing += [f"rows of {', '.join(ids)}"] if ids else []
    listed = " and ".join(filter(None, (", ".join(missing[:-1]), missing[-1])))
    text = (
        f"{name} was not installed for this build: {listed} are missing, and "
        f"rankings exclude {name}."
    )
    return Absent(name, text, why)


TIMES = "work_precision.csv"


@dataclass(frozen=True)
class StudySection:
    """The section of a study with rows: anchor, heading, text, pictures and table.

    file   its rows, beside the page
    summary  sentences on what the rows show
    notes  sentences on what is missing
    """

    anchor: str
    file: str
    title: str
    text: str
    summary: str
    pictures: tuple[Picture, ...]
    rows: Grid
    notes: tuple[str, ...]


@dataclass(frozen=True)
class ComparisonSection:
    """The comparison of contenders on one problem; notes and advice are derived from the times, and
    elsewhere has the table of each other machine, energies that of energy beside position."""

    anchor: str
    title: str
    text: str
    picture: Picture | None
    reference: str
    ratios: Grid
    advice: str
    notes: tuple[str, ...]
    is_truth: tuple[str, ...]
    elsewhere: tuple[tuple[str, Grid], ...]
    energies: Grid | None
    remarks: tuple[str, ...]


@dataclass(frozen=True)
class Profiles:
    """All problems together: figures, and a line for each code and error."""

    pictures: tuple[Picture, ...]
    rows: Grid


@dataclass(frozen=True, eq=False)
class Contents:
    """What a report is made of, at the end of a build or on its way.

    provenance  of the pages
    kept        the pages show kept rows; nothing was measured for them
    left        what is still being measured
    """

    suite: Suite
    options: Options
    checked: Sequence[ClaimResult]
    comparison: Comparison
    tables: ComparisonTables
    sections: Sequence[SectionResult]
    provenance: Mapping[str, str]
    kept: bool = False
    left: Sequence[str] = ()


def content(report: Contents, gallery: Gallery, history: object = None) -> dict[str, Any]:
    """The variables of the templates, by name.

    history  the kept benches, as `reports.tracking` shows them; None without any
    """
    checked, comparison, tables = report.checked, report.comparison, report.tables
    out, provenance = report.options.out, report.provenance
    origins = read_origins(out)
    seen, measured = summary(checked), sources(out, checked, comparison, report.sections)
    origin = origins.get(TIMES, provenance)
    runs = comparison.work_precision
    lacking = absent(origin, runs, tables.targets, seen.rows)
    run = {one.claim.id for one in checked}
    claims = [claim_section(one, gallery) for one in checked]
    return {
        "summary": str(seen),
        "statements": ledger(),
        "peers": peers(origin),
        "absent": lacking,
        "differing": seen.differing,
        "left_out": [claim.id for claim in report.suite.claims if claim.id not in run],
        "kept": report.kept,
        "left": report.left,
        "summary_sentences": summary_sentences(tables.ratios) if len(tables.ratios) else [],
        "measured": statements(measured),
        "verdicts": VERDICTS,
        "claims": claims,
        "timed": any(number_known(one.seconds) for one in claims),
        "claim_groups": claim_groups(claims),
        "claim_ids": sorted((one.claim.id for one in claims), key=_by_number),
        "motions": motions(checked),
        "headlines": [
            gallery.pictures[one.name] for one in HEADLINES if one.name in gallery.pictures
        ],
        "default_step": default_step(runs),
        "chooser": chooser(tables.fastest),
        "chooser_filters": filters(tables.fastest),
        "comparisons": _comparisons(comparison, tables, gallery, lacking, machines(out)[1:]),
        "profiles": _profiles(runs, gallery),
        "processor": origin.get("cpu", ""),
        "compiled": origin.get("compiled for", ""),
        "built": grid(built()),
        "stops": [f"{stop:.0e}" for stop in STOPS],
        "targets": _targets(tables.targets),
        "quick": report.options.quick,
        "cost": None if comparison.cost is None else grid(*readable_cost(comparison.cost)),
        "studies": [
            _study(one, one.frame, gallery) for one in report.sections if one.frame is not None
        ],
        "studies_left_out": [_left_out(one) for one in report.sections if one.frame is None],
        "failures": comparison.failures,
        "history": history,
        "provenance": [
            (name, without_folder(text) if name == "command" else text)
            for name, text in provenance.items()
        ],
        "origins": files(origins, provenance),
        "truths": grid(pd.DataFrame(truths(), columns=list(HEADINGS)), {"SHA-256": "hash"}),
        "reproduce": commands(measured),
    }


def _by_number(id: str) -> tuple[int, int]:
    """V before L before A, each by number."""
    return "VLA".find(id[:1]), int("".join(filter(str.isdigit, id)) or 0)


def _study(one: SectionResult, frame: pd.DataFrame, gallery: Gallery) -> StudySection:
    section = one.section
    names = [figure.name for figure in section.figures]
    undrawn = (gallery.missing[name] for name in names if name in gallery.missing)
    table, kinds = section.table(frame)
    table, common = without_common(table)
    return StudySection(
        anchor=section.name.replace("_", "-"),
        file=f"{section.name}.csv",
        title=section.title,
        text=section.text,
        summary=section.summary(frame),
        pictures=tuple(gallery.pictures[name] for name in names if name in gallery.pictures),
        rows=grid(table, kinds),
        notes=(*filter(None, (common, one.failure, one.note)), *undrawn),
    )


def _profiles(runs: pd.DataFrame | None, gallery: Gallery) -> Profiles | None:
    table = pd.DataFrame() if runs is None else profile_table(runs)
    if table.empty:
        return None
    drawn = tuple(gallery.pictures[f.name] for f in PROFILES if f.name in gallery.pictures)
    return Profiles(drawn, _numbers(table, 2))


def _numbers(table: pd.DataFrame, texts: int = 1) -> Grid:
    """A grid whose columns are numbers, after the first ones."""
    return grid(table, dict.fromkeys(table.columns[texts:], "number"))


def _left_out(one: SectionResult) -> tuple[str, str, str]:
    """The title of a study without rows, the command that runs it, and why it did not, or ""."""
    long = one.section.measure is long_form_only
    command = f"galvi studies --only {one.section.name}" if long else "galvi build"
    return one.section.title, command, one.failure or one.note


def _targets(frame: pd.DataFrame) -> Explained | None:
    if frame.empty:
        return None
    text = f"{TEXT} {targets_summary(frame)}"
    return Explained(text, grid(*readable_targets(frame)))


def _comparisons(
    comparison: Comparison,
    tables: ComparisonTables,
    gallery: Gallery,
    lacking: Sequence[Absent],
    others: Sequence[Machine],
) -> list[ComparisonSection]:
    if comparison.work_precision is None:
        return []
    sections = []
    for problem, runs in comparison.work_precision.groupby("problem", sort=False):
        name = str(problem)
        ratios = readable_ratios(tables.ratios, tables.smallest, name)
        noted = runs[runs["status"] != ""]
        sections.append(
            ComparisonSection(
                anchor=slug(name),
                title=label_of(name).title,
                text=label_of(name).text,
                picture=gallery.pictures.get(slug(name)),
                reference="; ".join(dict.fromkeys(runs.get("reference", []))),
                ratios=grid(
                    ratios,
                    dict.fromkeys(ratios.columns[1:], "number"),
                    best=fastest_cells(tables.ratios, name),
                ),
                advice=of_mujoco(tables.fastest, name),
                notes=tuple(filter(None, (mujoco_overhead(runs), *chances(runs)))),
                is_truth=tuple(runs[runs["is_truth"]]["contender"].drop_duplicates()),
                elsewhere=tuple(
                    (one.title, grid(elsewhere(one.runs, name)))
                    for one in others
                    if (one.runs["problem"] == name).any()
                ),
                energies=None if (kept := energies(runs)).empty else _numbers(kept),
                remarks=tuple(
                    f"{row['contender']}, {row['settings']}: {row['status']}"
                    for _, row in noted.iterrows()
                    if not any(is_of(one.name, row["contender"]) for one in lacking)
                ),
            )
        )
    return sections
