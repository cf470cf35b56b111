"""What the page says, gathered from verdicts, comparisons and pictures; no number is made here."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import pandas as pd

from benchmarks.checks.claim import Claim
from reports.build.verify import verdicts
from reports.cli.options import Order
from reports.figures.drawing import COST_FIGURE, Gallery, slug
from reports.figures.figure import Picture
from reports.page.grid import Grid, grid
from reports.page.section import reasons, section
from reports.results.claim_results import ClaimResult
from reports.results.comparison import Compared
from reports.results.study_result import StudyResult
from reports.tables.cost_table import readable_cost
from reports.tables.fastest_per_error import of_mujoco, readable_choices
from reports.tables.matched_error import fastest_cells, readable_ratios
from reports.tables.mujoco_overhead import mujoco_overhead
from reports.tables.number_format import capital
from reports.tables.study_table import readable_table
from reports.tables.summary_sentences import summary_sentences
from reports.tables.targets_table import QUICK, TEXT, readable_targets, summary


@dataclass(frozen=True)
class TableSection:
    """A further study: its heading, its text, its table and the anchor of its place."""

    name: str
    title: str
    text: str
    rows: Grid


@dataclass(frozen=True)
class OwnSection:
    """A study with its pictures; rows None when it was not run.

    notes  sentences on what is missing
    """

    name: str
    title: str
    text: str
    pictures: tuple[Picture, ...]
    rows: Grid | None
    notes: tuple[str, ...]


@dataclass(frozen=True)
class TargetsSection:
    """The targets: what is said of them all, and a line for each."""

    text: str
    rows: Grid


@dataclass(frozen=True)
class ComparisonSection:
    """A problem that contenders were compared on; notes and advice are made from the times."""

    title: str
    picture: Picture | None
    reference: str
    ratios: Grid
    choices: Grid
    advice: str
    notes: tuple[str, ...]
    is_truth: tuple[str, ...]
    remarks: tuple[str, ...]


def content(
    checked: Sequence[ClaimResult],
    compared: Compared,
    studied: Sequence[StudyResult],
    gallery: Gallery,
    known: Sequence[Claim],
    provenance: dict[str, str],
    order: Order,
) -> dict[str, Any]:
    """The names that the template uses."""
    seen = verdicts(checked)
    run = {one.claim.id for one in checked}
    return {
        "summary": str(seen),
        "differing": seen.differing,
        "left_out": [claim.id for claim in known if claim.id not in run],
        "peers": summary_sentences(compared.ratios) if len(compared.ratios) else [],
        "date": provenance.get("date", "at an unknown time"),
        "commit": _short(provenance.get("commit", "unknown")),
        "quick": order.quick,
        "rows": reasons(seen.rows),
        "sections": [section(one, gallery) for one in checked],
        "duels": _duels(compared, gallery),
        "targets": _aims(compared.targets, order.quick),
        "cost": None if compared.cost is None else grid(*readable_cost(compared.cost)),
        "cost_picture": gallery.pictures.get(COST_FIGURE.name),
        "tables": [
            TableSection(table.name.replace("_", "-"), table.title, table.text,
                  grid(*readable_table(frame, table.headings)))
            for table, frame in compared.tables
        ],
        "studies": [_own_section(one, gallery) for one in studied],
        "failures": compared.failures,
        "provenance": list(provenance.items()),
        "reproduce": f"make install\n.venv/bin/{order.command}",
    }  # fmt: skip


def _own_section(one: StudyResult, gallery: Gallery) -> OwnSection:
    names = [figure.name for figure in one.study.figures]
    undrawn = () if one.frame is None else tuple(
        gallery.missing[name] for name in names if name in gallery.missing
    )  # fmt: skip
    return OwnSection(
        one.study.name,
        one.study.title,
        one.study.text,
        tuple(gallery.pictures[name] for name in names if name in gallery.pictures),
        None if one.frame is None else grid(*one.study.table(one.frame)),
        (*filter(None, (one.failure, one.note)), *undrawn),
    )


def _aims(frame: pd.DataFrame, quick: bool) -> TargetsSection | None:
    if frame.empty:
        return None
    text = " ".join(filter(None, (TEXT, summary(frame), QUICK if quick else "")))
    return TargetsSection(text, grid(*readable_targets(frame)))


def _duels(compared: Compared, gallery: Gallery) -> list[ComparisonSection]:
    if compared.work_precision is None:
        return []
    duels = []
    for problem, runs in compared.work_precision.groupby("problem", sort=False):
        name = str(problem)
        ratios = readable_ratios(compared.ratios, compared.smallest, name)
        chosen = readable_choices(compared.choices, name)
        noted = runs[(runs["status"] != "") & (runs["status"] != "truth")]
        duels.append(
            ComparisonSection(
                title=capital(name),
                picture=gallery.pictures.get(slug(name)),
                reference="; ".join(dict.fromkeys(runs.get("reference", []))),
                ratios=grid(
                    ratios,
                    dict.fromkeys(ratios.columns[1:], "number"),
                    best=fastest_cells(compared.ratios, name),
                ),
                choices=grid(chosen, dict.fromkeys(("error", "time"), "number")),
                advice=of_mujoco(compared.choices, name),
                notes=tuple(filter(None, (mujoco_overhead(runs),))),
                is_truth=tuple(runs[runs["status"] == "truth"]["contender"].drop_duplicates()),
                remarks=tuple(
                    f"{row['contender']}, {row['settings']}: {row['status']}"
                    for _, row in noted.iterrows()
                ),
            )
        )
    return duels


def _short(commit: str) -> str:
    """The first digits of a commit's hash, and whether files differed from it."""
    digits, plus, dirty = commit.partition("+")
    return f"{digits[:12]}{' with changes' if plus and dirty else ''}"
