"""Every figure of the catalogue draws, from good frames and from bad ones."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.claims import CLAIMS
from benchmarks.store.frames import frame
from reports.figures.catalogue.all import FIGURES
from reports.figures.drawing import COST_FIGURE, comparison_figure
from reports.figures.picture import picture
from reports.figures.style.layout import NoData
from tests.reports.figure_frames import lay_out

NAMES = [figure.name for figure in FIGURES]


@pytest.mark.parametrize("figure", FIGURES, ids=NAMES)
def test_a_figure_of_failed_runs_says_that_there_is_nothing_to_draw(figure, drawn_frames):
    failed = drawn_frames[figure.name].assign(value=np.nan, x=np.nan, y=np.nan)
    for table in (failed, frame([])):
        with pytest.raises(NoData):
            lay_out(figure, table)


def test_the_same_frame_gives_the_same_bytes(drawn_frames):
    first, again = (picture(FIGURES[0], drawn_frames[NAMES[0]]) for _ in range(2))
    assert (first.svg, first.png) == (again.svg, again.png)
    assert first.svg.startswith(b"<?xml") and first.png.startswith(b"\x89PNG")
    assert first.title.startswith(FIGURES[0].source)


def test_every_figure_of_the_claims_is_drawn_once_at_least():
    assert {source for claim in CLAIMS for source in claim.figures} == {f.source for f in FIGURES}
    drawn = {"H fig. 1.1", "H fig. 1.2", *(f"H fig. 2.{k}" for k in range(3, 16))}
    drawn |= {*(f"H fig. 3.{k}" for k in range(1, 10)), "H 3.6.1", "H thm. 3.3.3", "H thm. 3.3.4"}
    drawn |= {"M fig. 3", "M fig. 1 left", "M fig. 1 right", "M sec. 5"}
    drawn |= {"H thm. 2.3.6", "H thm. 2.3.7"}
    assert drawn <= {figure.source for figure in FIGURES}
    assert {name for figure in FIGURES for name in figure.claims} <= {c.id for c in CLAIMS}
    assert len(set(NAMES)) == len(NAMES)


@pytest.mark.parametrize("figure", FIGURES, ids=NAMES)
def test_the_rate_beside_a_line_is_the_one_that_the_claim_states(figure, drawn_frames):
    table = drawn_frames[figure.name]
    judge = next(claim.judge for claim in CLAIMS if claim.id == figure.claims[0])
    stated = [row.measured for row in judge(table) if row.measured is not None]
    for rate in figure.options.get("rates", ()):
        if figure.name == "fig-2-06" and rate.quantity == "one-step error":
            continue  # V3 states it
        assert rate.fit(table).rate in stated


def test_comparisons_and_costs_draw_without_warnings(make_suite):
    suite = make_suite()
    runs = suite.work_precision(True, print)
    lay_out(comparison_figure("kepler e=0.6", runs), runs)
    lay_out(COST_FIGURE, suite.cost(True, print))
    with pytest.raises(NoData):
        lay_out(comparison_figure("kepler", runs), runs[runs["status"] == "truth"])
    with pytest.raises(NoData):
        lay_out(COST_FIGURE, suite.cost(True, print).tail(1))
