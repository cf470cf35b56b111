"""What the page says, gathered from verdicts, comparisons and pictures; no number is made here."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import pandas as pd

from benchmarks.claim import Claim
from reports.choices import of_mujoco, readable_choices
from reports.compare import Compared
from reports.cost_table import readable_cost
from reports.drawing import COST_FIGURE, Gallery, slug
from reports.figures.figure import Picture
from reports.generality import generality
from reports.matched import fastest_cells, readable_ratios
from reports.numerals import capital
from reports.order import Order
from reports.page.grid import Grid, grid
from reports.page.section import reasons, section
from reports.studied import Studied
from reports.study_table import readable_table
from reports.targets_table import QUICK, TEXT, readable_targets, summary
from reports.verification import Checked
from reports.verify import verdicts
from reports.winners import winners


@dataclass(frozen=True)
class Shown:
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
class Aims:
    """The targets: what is said of them all, and a line for each."""

    text: str
    rows: Grid


@dataclass(frozen=True)
class Duel:
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
    checked: Sequence[Checked],
    compared: Compared,
    studied: Sequence[Studied],
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
        "peers": winners(compared.ratios) if len(compared.ratios) else [],
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
            Shown(table.name.replace("_", "-"), table.title, table.text,
                  grid(*readable_table(frame, table.headings)))
            for table, frame in compared.tables
        ],
        "studies": [_own_section(one, gallery) for one in studied],
        "failures": compared.failures,
        "provenance": list(provenance.items()),
        "reproduce": f"make install\n.venv/bin/{order.command}",
    }  # fmt: skip


def _own_section(one: Studied, gallery: Gallery) -> OwnSection:
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


def _aims(frame: pd.DataFrame, quick: bool) -> Aims | None:
    if frame.empty:
        return None
    text = " ".join(filter(None, (TEXT, summary(frame), QUICK if quick else "")))
    return Aims(text, grid(*readable_targets(frame)))


def _duels(compared: Compared, gallery: Gallery) -> list[Duel]:
    if compared.work_precision is None:
        return []
    duels = []
    for problem, runs in compared.work_precision.groupby("problem", sort=False):
        name = str(problem)
        ratios = readable_ratios(compared.ratios, compared.smallest, name)
        chosen = readable_choices(compared.choices, name)
        noted = runs[(runs["status"] != "") & (runs["status"] != "truth")]
        duels.append(
            Duel(
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
                notes=tuple(filter(None, (generality(runs),))),
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
