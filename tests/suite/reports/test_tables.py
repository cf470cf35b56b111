"""Tables of comparisons, targets, studies, and of spaces and rules, and those of the README."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from markupsafe import Markup

from benchmarks.claims import CLAIMS
from benchmarks.statistics.paired import TIE
from benchmarks.studies.taxonomy import COLUMNS
from benchmarks.work_precision.asked import ERRORS, errors_of
from benchmarks.work_precision.dependable import dependable
from benchmarks.work_precision.fronts import fastest, ratios
from benchmarks.work_precision.problem import ATTITUDE, POSITION
from benchmarks.work_precision.problems.rigid_bodies import TEXTBOOK_RK4
from benchmarks.work_precision.targets import TARGETS, Target
from benchmarks.work_precision.targets_met import targets_met
from references.mujoco.steps import DEFAULT_STEP
from reports.build.terminal import show_targets
from reports.cli.commands import run
from reports.contents import load
from reports.figures.drawing import comparison_figure
from reports.figures.picture import picture
from reports.results.origins import note_origin
from reports.site.comparisons import absent_engines, default_step, installed_engines
from reports.studies.taxonomy import ABBREVIATIONS, space_label, taxonomy_table
from reports.tables import readme
from reports.tables.comparison_tables import (
    RK4_NAME,
    SMALLEST_HEADING,
    _time_cell,
    energies,
    fastest_lines,
    fastest_per_error,
    matched,
    mujoco_overhead,
    of_mujoco,
    readable_ratios,
    smallest,
)
from reports.tables.html import html_table
from reports.tables.number_format import TIMES, readable
from reports.tables.summary_sentences import _outcome
from reports.tables.targets_table import GALVI_ALONE, readable_targets, summary
from tests.suite.reports.small_reports import ROW, suite_of, work_precision

ROOT = Path(__file__).parents[3]
KEPLER = "kepler e=0.6"
PLANTED = (
    Target(KEPLER, ("SciPy DOP853",), 1e-4, 5.0),  # a peer that is faster: missed
    Target(KEPLER, ("SciPy DOP853",), 1e-8, 5.0),  # a peer that does not get there
    Target(KEPLER, ("SciPy DOP853",), None, None),  # its own error, which galvi reaches
    Target(KEPLER, ("Leapfrog",), 1e-4, 5.0),  # failed
    Target(KEPLER, ("Taylor",), 1e-4, 5.0),  # the truth: nothing to compare with
)
VERDICTS = ["missed", "not reached", "met", "not run", "not run"]
SMALL = work_precision(True, print)


def choices(runs, *errors):
    return fastest_per_error(ratios(runs, errors) if errors else matched(runs), runs)


@pytest.fixture
def met():
    return targets_met(SMALL, PLANTED)


def test_each_verdict_stands_beside_what_was_measured(met):
    text, kinds = readable_targets(met)
    assert list(text["verdict"]) == VERDICTS
    assert list(text["measured"])[1:] == [GALVI_ALONE, f"0.100{TIMES}", "not run", "not run"]
    assert list(text["target"])[1:3] == [f"at least 5.0{TIMES}", "reached"]
    assert set(kinds) <= set(text.columns) and "remark" not in text
    noted = readable_targets(met.assign(remark="A bound.", note="It changed."))[0]
    assert set(noted["remark"]) == {"A bound. It changed."}
    assert summary(met).startswith("5 targets: 2 not run, 1 missed, 1 not reached, 1 met. Source:")
    assert summary(met.assign(source=["a", "b", "b", "a", "a"])).endswith("Sources: a; b.")


def test_the_terminal_shows_them_and_nothing_when_there_are_none(met, capsys):
    show_targets(met.assign(remark=["", "", "A bound.", "", ""]))
    printed = capsys.readouterr().out
    assert printed.count("missed") == 2 and printed.count("not reached") == 2
    assert "SciPy DOP853, own error: A bound." in printed
    show_targets(met.head(0))
    assert capsys.readouterr().out == ""


def test_runs_are_judged_by_targets_but_those_of_the_quick_setting(ask):
    suite, written = suite_of(targets=PLANTED), Path("out/tables/targets.csv")
    completed = ask("compare --quick", suite)
    assert "times at matched error" in completed.out and not written.exists()
    completed = ask("compare", suite)
    assert "5 targets: 2 not run, 1 missed, 1 not reached, 1 met." in completed.out
    assert list(pd.read_csv(written)["verdict"]) == VERDICTS
    assert len(pd.read_csv("out/tables/smallest.csv")) == 3


@pytest.mark.slow(beside="test_runs_are_judged_by_targets_but_those_of_the_quick_setting")
@pytest.mark.usefixtures("undrawn")
def test_the_page_has_a_section_of_them_when_there_are_any(ask):
    page = Path("out/results/comparisons.html")
    ask("build", suite := suite_of(targets=PLANTED))
    text = page.read_text(encoding="utf-8")
    assert "<td>missed</td>" in text and '<td class="absent">not run</td>' in text
    ask("build --quick", suite)
    assert "<td>missed</td>" not in page.read_text(encoding="utf-8")


def test_each_contender_s_own_smallest_error_is_the_last_column():
    table = readable_ratios(matched(SMALL), smallest(SMALL), KEPLER).set_index("contender")
    assert table.columns[-1] == SMALLEST_HEADING
    assert table.loc["SciPy DOP853", SMALLEST_HEADING].startswith("1.0·10⁻⁵: 0.10")
    assert table.loc["galvi, best", SMALLEST_HEADING].startswith("1.0·10⁻⁹: 20.0")
    assert table.loc["Taylor", SMALLEST_HEADING] == ""
    ends = smallest(SMALL.assign(truth_error=2e-6))
    bound = readable_ratios(matched(SMALL), ends, KEPLER).set_index("contender")[SMALLEST_HEADING]
    assert bound["SciPy DOP853"].startswith("≤ 1.0·10⁻⁵: ")
    assert table.loc["Taylor", "10⁻⁶"].startswith("reference: ")
    assert "reference" not in "".join(table.drop(index="Taylor").to_numpy().ravel())
    cells = table.loc["SciPy DOP853"]  # a run that is far too accurate says so
    assert f"1000{TIMES} closer (" in cells["0.01"] and "closer" not in cells["10⁻⁴"]


def test_the_report_has_its_own_targets():
    assert load().targets == TARGETS


def test_an_error_that_the_truth_cannot_tell_is_a_bound():
    runs = SMALL.assign(truth_error=1e-10, error=SMALL["error"].clip(1e-9))
    assert list(fastest_lines(choices(runs, 1e-8))["its error"]) == ["1.0·10⁻⁹ (bound)"]


def test_a_setting_is_called_stopped_early_by_its_row_and_not_by_its_words():
    runs = SMALL.replace({"settings": {"step=1": "tolerance=1e-9"}})
    for early, suffix in ((False, ""), (True, " (stopped early)")):
        lines = fastest_lines(choices(runs.assign(stops_early=early), 1e-8))
        assert list(lines["setting"]) == [f"tolerance=1e-9{suffix}"]


def test_a_choice_is_a_run_that_was_made_and_reached_the_error():
    table = choices(SMALL, 1e-4, 1e-8, 1e-12)
    best, of_galvi = (table[table["of"] == group] for group in ("all", "galvi"))
    assert list(best["contender"]) == ["SciPy DOP853", "galvi degree 8, Gauss 8", "Taylor"]
    assert list(of_galvi["settings"]) == ["step=1", "step=1", ""]
    text = fastest_lines(table)
    assert list(text["its error"]) == ["1.0·10⁻⁵", "1.0·10⁻⁹", "1.0·10⁻⁹", "truth", ""]
    assert text["contender"].iloc[-1] == "not reached"


def test_an_engine_that_was_not_installed_is_named_with_what_is_missing():
    origin = {"scipy": "1", "heyoka": "not installed"}
    reason = "Install heyoka."
    runs = pd.DataFrame({"contender": ["heyoka, chains", "peer"], "status": [reason, "heyoka"]})
    targets = pd.DataFrame({"against": ["heyoka", "heyoka, chains", "peer"], "verdict": "not run"})
    rows = (
        replace(ROW, id="A5", verdict="not run", reason=reason, absent="heyoka"),
        replace(ROW, id="V3", verdict="not run", reason="It broke, though heyoka was not asked."),
        ROW,
    )
    (engine,) = absent_engines(origin, runs, targets, rows)
    prefix = (
        "heyoka was not installed for this build: its times, 2 targets and rows of A5 are missing"
    )
    assert engine.text.startswith(prefix) and engine.reason == reason
    assert absent_engines({}, runs, targets, rows) == ()
    assert installed_engines(origin) == "REBOUND, MuJoCo and SciPy"
    assert installed_engines({}).endswith("SciPy and heyoka")


LINE = {
    "kind": "Polynomials", "number": 2, "space": "Polynomials(degree=2)", "family": "Gauss",
    "points": 2, "rule": "Gauss 2", "verdict": "method", "C_N": 0.99, "predicted": 4,
    "measured": 3.98, "uncertainty": 0.01, "symplecticity": 1e-16, "symmetric": True,
    "symmetry": 2e-16, "name": "Gauss collocation, 2 stages", "status": "",
}  # fmt: skip
REFUSED = dict.fromkeys(("measured", "C_N", "symplecticity", "symmetry"), np.nan) | {
    "name": "",
    "predicted": 0,
    "verdict": "ill-posed",
}
WAVES = {"kind": "Fourier", "space": "Fourier(harmonics=1)"}


@pytest.mark.parametrize(
    ("changes", "cells"),
    [
        (
            [{}, {"points": 1, **REFUSED}, {"points": 3, "name": "", "C_N": 1.01}],
            [{"1 point": "ill-posed", "2 points": "4.0 Gauss collocation", "3 points": "4.0",
              "C_N": "0.990 to 1.01", "there and back": "2.0·10⁻¹⁶"}],
        ),
        (
            [{"measured": 3.4}, {"points": 3, "measured": np.nan}],
            [{"2 points": "3.4, predicted 4 Gauss collocation",
              "3 points": "not measured, predicted 4 Gauss collocation"}],
        ),
        (  # spaces other than polynomials have one line
            [{}, {"family": "Radau"}, WAVES, {**WAVES, "family": "Radau"}],
            [{"space": "Polynomials(2)", "rule": "Gauss"},
             {"space": "Polynomials(2)", "rule": "Radau"},
             {"space": "Fourier(harmonics=1)", "rule": "Gauss"}],
        ),
        (  # a rule that does not exist is not called ill-posed
            [{"points": 1}, {"family": "Lobatto"}],
            [{"1 point": "4.0 Gauss collocation"}, {"1 point": "-"}],
        ),
    ],
)  # fmt: skip
def test_a_line_has_what_a_space_makes_with_a_family_of_rules(changes, cells):
    rows = pd.DataFrame([{**LINE, **change} for change in changes], columns=list(COLUMNS))
    read, kinds = taxonomy_table(rows)
    lines = zip(read.to_dict("records"), cells, strict=True)
    assert all(line.items() >= expected.items() for line, expected in lines)
    assert set(kinds) <= set(read.columns) and len(set(ABBREVIATIONS.values())) == len(
        ABBREVIATIONS
    )


@pytest.mark.parametrize(
    ("space", "label"),
    [
        ("Polynomials(degree=10)", "Polynomials(10)"),
        ("Fourier(harmonics=1, frequency=6.283185307179586)", "Fourier(harmonics=1, ω=2π)"),
    ],
)
def test_spaces_have_short_labels(space, label):
    assert space_label(space) == label


GALVI = "galvi degree 8, Gauss 8, exponential"


def runs(slower=70.0, better=20.0, fails=False, quantity=ATTITUDE):
    """MuJoCo's RK4 some times as slow and as good as the textbook's, its Euler, and galvi."""
    points = [
        *((TEXTBOOK_RK4, f"step={h}", 10.0 * h**4, 1e-4 / h) for h in (0.1, 0.01, 0.001)),
        *((RK4_NAME, f"step={h}", 10.0 * h**4 / better, slower * 1e-4 / h) for h in (0.1, 0.01)),
        (RK4_NAME, "step=0.001", np.nan if fails else 1e-11 / better, slower * 0.1),
        ("MuJoCo Euler", "step=0.01", 5e-3, 1e-5 if slower > 100.0 else 1.0),
        (GALVI, "step=0.5", 1e-14, 4e-5),
    ]
    points_table = pd.DataFrame(points, columns=["contender", "settings", "error", "seconds"])
    points_table = points_table.assign(
        problem="body",
        quantity=quantity,
        is_truth=False,
        stops_early=False,
        status="",
        reference="closed form",
        seconds_low=points_table["seconds"],
        seconds_high=points_table["seconds"],
    )
    return dependable(points_table)


@pytest.mark.parametrize(
    ("overrides", "pattern"),
    [
        ({}, "takes 70 times as long as one of .* 20 times smaller .medians over 3"),
        ({"fails": True}, "over 2 step sizes"),
        ({"better": 1.05}, "an error as large"),
        ({"better": 0.5}, "2.0 times larger"),
    ],
)
def test_steps_of_the_two_codes_are_compared_at_equal_steps(overrides, pattern):
    assert re.search(pattern, mujoco_overhead(runs(**overrides)))


@pytest.mark.parametrize("name", [RK4_NAME, TEXTBOOK_RK4])
def test_without_both_codes_nothing_is_said(name):
    rows = runs()
    assert mujoco_overhead(rows[rows["contender"] != name]) == ""
    absent = rows["seconds"].mask(rows["contender"] == name)
    assert mujoco_overhead(rows.assign(seconds=absent)) == ""


def test_all_are_compared_at_the_same_errors_that_their_truth_can_tell():
    assert errors_of(runs()) == ERRORS
    assert errors_of(runs().assign(truth_error=2e-13)) == ERRORS[:-1]
    two_problems = pd.concat([runs(), runs(quantity=POSITION).assign(problem="planets")])
    table = matched(two_problems.reset_index(drop=True))
    assert set(table["problem"]) == {"body", "planets"} and set(table["error"]) == set(ERRORS)
    assert matched(two_problems.head(0)).empty


def test_the_best_of_mujoco_has_lines_of_its_own_and_a_sentence():
    table = choices(runs())
    chosen = table[table["of"] == "MuJoCo"].set_index("asked")["contender"]
    assert chosen[1e-4] == RK4_NAME and chosen[1e-12] == RK4_NAME
    assert of_mujoco(choices(runs(), 1e-12, 1e-13), "body").endswith("10⁻¹²; none reaches 10⁻¹³.")
    sentence = of_mujoco(choices(runs(slower=7e4)), "body")
    assert "MuJoCo Euler for 0.01; MuJoCo RK4 for 10⁻⁴" in sentence
    lines = fastest_lines(table)
    assert list(lines[lines["error asked"] == "10⁻¹²"]["among"]) == ["all, galvi's", "MuJoCo's"]
    without = choices(runs()[~runs()["contender"].str.startswith("MuJoCo")])
    assert set(without["of"]) == {"all", "galvi"} and of_mujoco(without, "body") == ""


def test_mujoco_s_default_step_is_answered_from_runs_at_it_and_from_none_beside_it():
    assert default_step(None) is None and default_step(runs()) is None
    exact = runs().replace("step=0.001", f"step={DEFAULT_STEP:g}")
    answer = default_step(exact)
    line = answer.table.iloc[0]
    assert (line["error"], line["quantity"]) == ("5.0·10⁻¹³", ATTITUDE)
    assert "at a step of 0.002. Below 10⁻⁹: Body (5.0·10⁻¹³). Errors" in answer.text
    exact.loc[exact["contender"] == RK4_NAME, "error"] = 1e-3
    assert "Above 10⁻⁶: Body (0.0010)." in default_step(exact).text


@pytest.mark.slow(beside="test_figures.py::test_comparisons_draw_without_warnings")
def test_the_picture_is_of_attitudes_and_says_what_the_lines_are():
    figure = comparison_figure("body", runs())
    assert figure.options["ylabel"].startswith("error of the attitude at the end")
    assert "contacts" in figure.caption and "R_true" in figure.caption
    assert figure.title.startswith("Body: galvi is fastest at 0.01, at 10⁻⁴ (RK4 on quaternions, ")
    assert picture(figure, runs()).png.startswith(b"\x89PNG")
    assert "true position" in comparison_figure("kepler", runs(quantity=POSITION)).caption


def test_energy_stands_beside_the_error_of_position_of_the_run_that_is_the_fastest():
    rows = runs(quantity=POSITION)
    assert energies(rows).empty
    rows["energy"] = [10.0 ** -(k + 3) for k in range(len(rows))]
    table = energies(rows).set_index("contender")
    assert set(table.index) >= {"galvi, best", RK4_NAME}
    best = fastest(rows[rows["contender"] == RK4_NAME], 1e-4)
    assert table.loc[RK4_NAME, "10⁻⁴"] == readable(best["energy"], 2)
    assert "not reached" in set(table.to_numpy().ravel())


def test_a_table_of_a_page_has_scopes_and_classes_and_no_foreign_tags():
    table = pd.DataFrame(
        {"code": ["a<{b}", "same", "same"], "time": ["1 s", "not reached", np.nan], "x": "<i>"}
    )
    table["link"] = pd.Series([Markup("<a href='#q'>q</a>")] * 3, dtype=object)
    html = html_table(table, 'Times "1" < 2', ["time"], [(0, "time")], id="times")
    counts = {
        'aria-label="Times &#34;1&#34; &lt; 2"><table id="times">': 1,
        '<th scope="col">code</th>': 1,
        '<th scope="col" class="number">time</th>': 1,
        '<th scope="row">a&lt;{b}</th>': 1,
        '<th scope="row">same</th>': 2,
        "<i>": 0,
        '<td class="number best">1 s</td>': 1,
        '<td class="absent number">not reached</td>': 1,
        '<td class="number"></td>': 1,
        "<td><a href='#q'>q</a></td>": 3,
    }
    assert {part: html.count(part) for part in counts} == counts
    assert html_table(table.head(0), "empty").count("<tr>") == 1


@pytest.mark.parametrize(
    ("low", "high", "prefix", "sentence"),
    [(0.8, 1.3, "tie, ", "galvi and B tie"), (5.2, 33.1, "within noise, ", "are within noise")],
)
def test_a_tie_is_one_only_where_its_own_interval_holds_1(low, high, prefix, sentence):
    """Noise as large as a difference leaves it open who is faster, and by how much."""
    row = {
        "problem": "body",
        "error": 1e-4,
        "contender": "B",
        "settings": "",
        "seconds": 1.0,
        "ratio": 0.5 * (low + high),
        "low": low,
        "high": high,
        "outcome": TIE,
        "closer": np.nan,
    }
    assert _time_cell(row).startswith(prefix)
    assert sentence in _outcome(1.0, pd.Series(row))[0]


# The generated tables of README.md and docs/: what they say is what the suite says.


def table_of(page, name):
    """The text between the marks of a generated table."""
    begin, end = readme.marks(name)
    return (ROOT / page).read_text().partition(begin)[2].partition(end)[0].strip()


def cells_of(line):
    return [cell.strip() for cell in line.strip("|").split("|")]


@pytest.mark.slow(beside="test_a_headline_that_is_gone_is_named")
def test_every_headline_is_a_row_of_the_claims_and_has_its_verdict():
    claim_rows = [row for claim in CLAIMS for row in claim.check(pd.DataFrame())]
    rows = {(row.id, row.quantity): row for row in claim_rows}
    lines = table_of("docs/trust.md", readme.RESULTS).splitlines()[2:]
    for line, headline in zip(lines, readme.HEADLINES, strict=True):
        claim, quantity, claimed, measured, verdict = cells_of(line)
        row = rows[headline]
        assert (claim, quantity, claimed) == (f"{row.id}, {row.source}", row.quantity, row.claimed)
        assert verdict.partition(",")[0] == row.expected and measured


def test_a_headline_that_is_gone_is_named():
    with pytest.raises(KeyError, match="base of the one-step error"):
        readme.headline_table(pd.DataFrame({"id": ["V1"], "quantity": ["something else"]}))


@pytest.mark.parametrize("page", ["no marks", f"before {readme.marks(readme.RESULTS)[0]} old"])
def test_a_page_without_marks_is_refused(page):
    with pytest.raises(ValueError, match=f"must hold the marks {readme.marks(readme.RESULTS)[0]}"):
        readme.with_table(page, readme.RESULTS, "a table")


@pytest.mark.parametrize(
    ("name", "problem", "rows", "lines"),
    [
        (
            readme.SPEED,
            "outer solar system",
            [
                ("REBOUND IAS15", "27.1", 25.2, 28.3, "faster"),
                ("heyoka", "not reached", np.nan, np.nan, ""),
            ],
            ["| REBOUND IAS15 | 27 (25-28) | - |", "| heyoka | not reached | - |"],
        ),
        (
            readme.BODIES,
            "free rigid body",
            [("MuJoCo RK4", 1.04, 0.9, 1.2, "tie")],
            ["| MuJoCo RK4 | - | tie, 1 (0.9-1.2) | - |"],
        ),
    ],
)
def test_ratios_are_shown_with_what_was_not_reached_and_who_took_no_part(
    name, problem, rows, lines
):
    columns = ["contender", "ratio", "low", "high", "outcome"]
    ratios = pd.DataFrame(rows, columns=columns).assign(
        problem=problem, error=1e-4, noise_low=0.97, noise_high=1.04
    )
    shown = readme.times_table(ratios, *readme.TIMES[name]).splitlines()
    for beginning in (*lines, "| galvi against itself | "):
        assert any(line.startswith(beginning) for line in shown)
    blocks = table_of("README.md", name).split("\n\n")
    assert blocks[::2] and all(line.startswith("On ") for line in blocks[::2])
    assert {block.splitlines()[0] for block in blocks[1::2]} == {shown[0]}


def test_the_page_counts_the_statements_of_the_papers(tmp_path):
    (tmp_path / "docs").mkdir()
    pages = {page: (ROOT / page).read_text() for page in readme.PAGES}
    for page, text in pages.items():
        (tmp_path / page).write_text(text)
    assert readme.renew(tmp_path, tmp_path / "nothing") == []
    assert {page: (tmp_path / page).read_text() for page in pages} == pages


def test_the_fastest_code_at_each_error_is_named_with_galvis_beside_it():
    rows = [
        ("heyoka", "tolerance=1e-5", 1e-5, 2.0),
        ("heyoka", "tolerance=1e-9", 1e-9, 4.0),
        ("galvi degree 8", "step=0.2", 2e-5, 1.0),
        ("galvi degree 8", "step=0.1", 1e-7, 8.0),
    ]
    table = pd.DataFrame(rows, columns=["contender", "settings", "error", "seconds"])
    table = table.assign(
        problem="two bodies, e = 0.99",
        quantity=POSITION,
        smallest=table["error"],
        largest=table["error"],
        is_truth=False,
        stops_early=False,
        status="",
    )
    (line,) = readme.choices(table).splitlines()[2:]
    cells = cells_of(line)
    assert cells[0] == "Two bodies, e = 0.99" and cells[1].startswith("**galvi degree 8, step=0.2")
    assert cells[2].startswith("heyoka, tolerance=1e-9") and "; galvi degree 8" in cells[2]
    assert cells[3].startswith("heyoka") and "galvi" not in cells[3]
    page = table_of("docs/which.md", readme.CHOICES).splitlines()
    assert len(page) == 2 + len(readme.CHOICE_PROBLEMS) and page[0].count("error") == len(
        readme.ASKED_ERRORS
    )


def test_the_evidence_is_counted(tmp_path):
    columns = {"id": ["V1", "V1", "L1"], "verdict": ["holds"] * 3, "expected": ["holds"] * 3}
    pd.DataFrame(columns).to_csv(tmp_path / "claims.csv")
    lines = readme.evidence(tmp_path).splitlines()
    assert "| claims | 2, in 3 checks | `galvi verify` |" in lines
    assert len(lines) <= len(table_of("docs/trust.md", readme.EVIDENCE).splitlines())


def test_the_pages_take_no_rows_of_the_quick_setting(tmp_path, monkeypatch, capsys):
    note_origin(tmp_path, "work_precision.csv", {"date": "2026-01-02"}, quick=True)
    monkeypatch.chdir(ROOT)
    assert run(None, ["readme", "--out", str(tmp_path)]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.endswith(
        "work_precision.csv of the quick setting; run build without --quick first."
    )
