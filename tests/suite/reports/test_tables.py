"""Tables of targets, of spaces and rules, of what each code takes."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from markupsafe import Markup

from benchmarks.statistics.paired import TIE
from benchmarks.studies.taxonomy import COLUMNS
from benchmarks.work_precision.asked import ERRORS, errors_of
from benchmarks.work_precision.dependable import dependable
from benchmarks.work_precision.fronts import fastest, ratios
from benchmarks.work_precision.problem import ATTITUDE, POSITION
from benchmarks.work_precision.problems.rigid_bodies import TEXTBOOK_RK4
from benchmarks.work_precision.targets import ORBITS, TARGETS, TURNS, Target
from benchmarks.work_precision.targets_met import targets_met
from references.mujoco.steps import DEFAULT_STEP
from reports.build.terminal import show_targets
from reports.cli.commands import run
from reports.contents import load
from reports.figures.drawing import comparison_figure
from reports.figures.picture import picture
from reports.site.comparisons import default_step
from reports.studies.taxonomy import CODES, code, space_label, taxonomy_table
from reports.tables.comparison_tables import (
    OF_RK4,
    SMALLEST,
    _cell,
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
from reports.tables.targets_table import ALONE, readable_targets, summary

KEPLER = "kepler e=0.6"
PLANTED = (
    Target(KEPLER, ("SciPy DOP853",), 1e-4, 5.0),  # a peer that is faster: missed
    Target(KEPLER, ("SciPy DOP853",), 1e-8, 5.0),  # a peer that does not get there
    Target(KEPLER, ("SciPy DOP853",), None, None),  # its own error, which galvi reaches
    Target(KEPLER, ("Leapfrog",), 1e-4, 5.0),  # failed
    Target(KEPLER, ("Taylor",), 1e-4, 5.0),  # the truth: nothing to compare with
)


@pytest.fixture
def met(make_suite) -> pd.DataFrame:
    return targets_met(make_suite().work_precision(True, print), PLANTED)


def test_each_verdict_stands_beside_what_was_measured(met):
    text, kinds = readable_targets(met)
    assert list(text["verdict"]) == ["missed", "not reached", "met", "not run", "not run"]
    assert list(text["measured"])[1:] == [
        ALONE, f"0.100{TIMES}", "not run", "not run",
    ]  # fmt: skip
    assert list(text["target"])[1:3] == [f"at least 5.0{TIMES}", "reached"]
    assert set(kinds) <= set(text.columns) and "remark" not in text
    noted = readable_targets(met.assign(remark="A bound.", note="It changed.", target=1.25))[0]
    alone = readable_targets(met.assign(ratio="not reached", verdict="met"))[0]
    assert set(alone["measured"]) == {ALONE}
    assert set(noted["remark"]) == {"A bound. It changed."}
    assert set(noted["target"]) == {f"at least 1.25{TIMES}"}
    assert summary(met).startswith("5 targets: 2 not run, 1 missed, 1 not reached, 1 met. Source:")
    assert summary(met.assign(source=["a", "b", "b", "a", "a"])).endswith("Sources: a; b.")


def test_the_terminal_shows_them_and_nothing_when_there_are_none(met, capsys):
    show_targets(met.assign(remark=["", "", "A bound.", "", ""]))
    printed = capsys.readouterr().out
    assert printed.count("missed") == 2 and printed.count("not reached") == 2
    assert "SciPy DOP853, own error: A bound." in printed
    show_targets(met.head(0))
    assert capsys.readouterr().out == ""


def test_one_command_prints_and_writes_them(make_suite, tmp_path, capsys):
    suite = make_suite(targets=PLANTED)
    assert run(lambda: suite, ["compare", "--out", str(tmp_path)]) == 0
    printed = capsys.readouterr().out
    assert "5 targets: 2 not run, 1 missed, 1 not reached, 1 met." in printed
    table = pd.read_csv(tmp_path / "tables" / "targets.csv")
    assert list(table["verdict"]) == ["missed", "not reached", "met", "not run", "not run"]
    assert len(pd.read_csv(tmp_path / "tables" / "smallest.csv")) == 3


def test_runs_of_the_quick_setting_are_shown_and_judged_by_no_target(make_suite, tmp_path, capsys):
    suite = make_suite(targets=PLANTED)
    assert run(lambda: suite, ["compare", "--quick", "--out", str(tmp_path)]) == 0
    printed = capsys.readouterr().out
    assert "5 targets" not in printed and "times at matched error" in printed
    assert not (tmp_path / "tables" / "targets.csv").exists()


@pytest.mark.slow(beside="test_one_command_prints_and_writes_them")
@pytest.mark.usefixtures("undrawn")
def test_the_page_has_a_section_of_them_when_there_are_any(make_suite, tmp_path):
    suite = make_suite(targets=PLANTED)
    run(lambda: suite, ["build", "--out", str(tmp_path)])
    page = (tmp_path / "results" / "comparisons.html").read_text(encoding="utf-8")
    place = page[page.index('<h2 id="targets">Targets</h2>') : page.index('<h2 id="cost">')]
    assert "<td>missed</td>" in place and '<td class="absent">not run</td>' in place
    assert '<a href="#targets">' in page
    assert "1.0·10⁻⁵" in place
    run(lambda: suite, ["build", "--quick", "--out", str(tmp_path)])
    assert "targets" not in (tmp_path / "results" / "comparisons.html").read_text(encoding="utf-8")


def test_each_contender_s_own_smallest_error_is_the_last_column(make_suite):
    runs = make_suite().work_precision(True, print)
    table = readable_ratios(matched(runs), smallest(runs), KEPLER).set_index("contender")
    assert table.columns[-1] == SMALLEST
    assert table.loc["SciPy DOP853", SMALLEST].startswith("1.0·10⁻⁵: 0.10")
    assert table.loc["galvi, best", SMALLEST].startswith("1.0·10⁻⁹: 20.0")
    assert table.loc["Taylor", SMALLEST] == ""
    ends = smallest(runs.assign(truth_error=2e-6))
    bound = readable_ratios(matched(runs), ends, KEPLER).set_index("contender")[SMALLEST]
    assert bound["SciPy DOP853"].startswith("≤ 1.0·10⁻⁵: ")
    assert table.loc["Taylor", "10⁻⁶"].startswith("reference: ")
    assert "reference" not in "".join(table.drop(index="Taylor").to_numpy().ravel())


def test_a_ratio_to_a_run_that_is_far_too_accurate_says_so(make_suite):
    runs = make_suite().work_precision(True, print)
    tables = matched(runs), smallest(runs)
    cells = readable_ratios(*tables, KEPLER).set_index("contender").loc["SciPy DOP853"]
    assert f"1000{TIMES} closer (" in cells["0.01"] and "closer" not in cells["10⁻⁴"]


def test_the_report_has_its_own_targets():
    assert load().targets == TARGETS
    for source in (ORBITS, TURNS):
        assert len({target.error for target in TARGETS if target.source == source}) > 1


LINE = {
    "kind": "Polynomials", "number": 2, "space": "Polynomials(degree=2)", "family": "Gauss",
    "points": 2, "rule": "Gauss 2", "verdict": "method", "C_N": 0.99, "predicted": 4,
    "measured": 3.98, "uncertainty": 0.01, "symplecticity": 1e-16, "symmetric": True,
    "symmetry": 2e-16, "name": "Gauss collocation, 2 stages", "status": "",
}  # fmt: skip
REFUSED = {"measured": np.nan, "C_N": np.nan, "symplecticity": np.nan, "symmetry": np.nan,
           "name": "", "predicted": 0}  # fmt: skip


def table(*changes: dict[str, object]) -> tuple[pd.DataFrame, dict[str, str]]:
    lines = [{**LINE, **change} for change in changes]
    return taxonomy_table(pd.DataFrame(lines, columns=list(COLUMNS)))


def test_a_line_has_what_a_space_makes_with_a_family_of_rules() -> None:
    read, kinds = table(
        {}, {"points": 1, "verdict": "ill-posed", **REFUSED}, {"points": 3, "name": "", "C_N": 1.01}
    )
    assert len(read) == 1 and set(kinds) <= set(read.columns)
    line = read.iloc[0]
    assert line["1 point"] == "ill-posed"
    assert line["2 points"] == "4.0 Gauss collocation"
    assert line["3 points"] == "4.0"
    assert line["C_N"] == "0.990 to 1.01" and line["there and back"] == "2.0·10⁻¹⁶"


def test_an_order_that_is_not_the_predicted_one_is_told_beside_it() -> None:
    read, _ = table({"measured": 3.4}, {"points": 3, "measured": np.nan})
    assert read.iloc[0]["2 points"] == "3.4, predicted 4 Gauss collocation"
    assert read.iloc[0]["3 points"] == "not measured, predicted 4 Gauss collocation"


def test_spaces_other_than_polynomials_have_one_line() -> None:
    waves = {"kind": "Fourier", "space": "Fourier(harmonics=1)"}
    read, _ = table({}, {"family": "Radau"}, waves, {**waves, "family": "Radau"})
    assert list(zip(read["space"], read["rule"], strict=True)) == [
        ("Polynomials(2)", "Gauss"),
        ("Polynomials(2)", "Radau"),
        ("Fourier(harmonics=1)", "Gauss"),
    ]


def test_a_rule_that_does_not_exist_is_not_called_ill_posed() -> None:
    read, _ = table({"points": 1}, {"family": "Lobatto"})
    assert list(read["1 point"]) == ["4.0 Gauss collocation", "-"]


@pytest.mark.parametrize(
    ("space", "label"),
    [
        ("Polynomials(degree=10)", "Polynomials(10)"),
        ("Fourier(harmonics=1, frequency=6.283185307179586)", "Fourier(harmonics=1, ω=2π)"),
        ("PolynomialFourier(degree=1, harmonics=1, frequency=20.0)",
         "PolynomialFourier(1, harmonics=1, ω=20)"),
    ],
)  # fmt: skip
def test_spaces_have_short_labels(space: str, label: str) -> None:
    assert space_label(space) == label


def test_names_have_short_codes() -> None:
    assert code("3 steps of Gauss collocation, 2 stages") == "3G"
    assert code("symplectic Euler, position first") == "SE"
    assert code("Something New") == "SN"
    assert len(set(CODES.values())) == len(CODES)


GALVI = "galvi degree 8, Gauss 8, exponential"


def runs(
    slower: float = 70.0, better: float = 20.0, fails: bool = False, quantity: str = ATTITUDE
) -> pd.DataFrame:
    """MuJoCo's RK4 some times as slow and as good as the textbook's, its Euler, and galvi."""
    points = [
        *((TEXTBOOK_RK4, f"step={h}", 10.0 * h**4, 1e-4 / h) for h in (0.1, 0.01, 0.001)),
        *((OF_RK4, f"step={h}", 10.0 * h**4 / better, slower * 1e-4 / h) for h in (0.1, 0.01)),
        (OF_RK4, "step=0.001", np.nan if fails else 1e-11 / better, slower * 0.1),
        ("MuJoCo Euler", "step=0.01", 5e-3, 1e-5 if slower > 100.0 else 1.0),
        (GALVI, "step=0.5", 1e-14, 4e-5),
    ]
    frame = pd.DataFrame(points, columns=["contender", "settings", "error", "seconds"])
    frame = frame.assign(
        problem="body", quantity=quantity, is_truth=False, stops_early=False, status="",
        reference="closed form",
        seconds_low=frame["seconds"], seconds_high=frame["seconds"],
    )  # fmt: skip
    return dependable(frame)


def test_steps_of_the_two_codes_are_compared_at_equal_steps() -> None:
    said = mujoco_overhead(runs())
    assert "takes 70 times as long" in said and "20 times smaller (medians over 3" in said
    assert "over 2 step sizes" in mujoco_overhead(runs(fails=True))
    assert "an error as large" in mujoco_overhead(runs(better=1.05))
    assert "2.0 times larger" in mujoco_overhead(runs(better=0.5))


def test_without_both_codes_nothing_is_said() -> None:
    frame = runs()
    for name in (OF_RK4, TEXTBOOK_RK4):
        assert mujoco_overhead(frame[frame["contender"] != name]) == ""
        absent = frame.assign(seconds=frame["seconds"].mask(frame["contender"] == name))
        assert mujoco_overhead(absent) == ""


def test_all_are_compared_at_the_same_errors_that_their_truth_can_tell() -> None:
    assert errors_of(runs()) == ERRORS
    assert errors_of(runs().assign(truth_error=2e-13)) == ERRORS[:-1]
    both = pd.concat([runs(), runs(quantity=POSITION).assign(problem="planets")])
    table = matched(both.reset_index(drop=True))
    assert set(table["problem"]) == {"body", "planets"} and set(table["error"]) == set(ERRORS)
    assert matched(both.head(0)).empty


def choices(rows: pd.DataFrame) -> pd.DataFrame:
    return fastest_per_error(matched(rows), rows)


def test_the_best_of_mujoco_has_lines_of_its_own_and_a_sentence() -> None:
    table = choices(runs())
    chosen = table[table["of"] == "MuJoCo"].set_index("asked")["contender"]
    assert chosen[1e-4] == OF_RK4 and chosen[1e-12] == OF_RK4
    none = fastest_per_error(ratios(runs(), (1e-12, 1e-13)), runs())
    assert of_mujoco(none, "body").endswith("10⁻¹²; none reaches 10⁻¹³.")
    other = of_mujoco(choices(runs(slower=7e4)), "body")
    assert "MuJoCo Euler for 0.01; MuJoCo RK4 for 10⁻⁴" in other
    lines = fastest_lines(table)
    assert list(lines[lines["error asked"] == "10⁻¹²"]["among"]) == ["all, galvi's", "MuJoCo's"]
    without = choices(runs()[~runs()["contender"].str.startswith("MuJoCo")])
    assert set(without["of"]) == {"all", "galvi"} and of_mujoco(without, "body") == ""


def test_mujoco_s_default_step_is_answered_from_runs_at_it_and_from_none_beside_it() -> None:
    assert default_step(None) is None and default_step(runs()) is None
    exact = runs().replace("step=0.001", f"step={DEFAULT_STEP:g}")
    found = default_step(exact)
    line = found.table.iloc[0]
    assert (line["error"], line["quantity"]) == ("5.0·10⁻¹³", ATTITUDE)
    assert "at a step of 0.002. Below 10⁻⁹: Body (5.0·10⁻¹³). Errors" in found.text
    exact.loc[exact["contender"] == OF_RK4, "error"] = 1e-3
    assert "Above 10⁻⁶: Body (0.0010)." in default_step(exact).text


@pytest.mark.slow(beside="test_figures.py::test_comparisons_draw_without_warnings")
def test_the_picture_is_of_attitudes_and_says_what_the_lines_are() -> None:
    figure = comparison_figure("body", runs())
    assert figure.options["ylabel"].startswith("error of the attitude at the end")
    assert "contacts" in figure.caption and "R_true" in figure.caption
    assert figure.title == "Body: galvi is fastest from 0.01 to 10⁻¹²"
    assert picture(figure, runs()).png.startswith(b"\x89PNG")
    assert "true position" in comparison_figure("kepler", runs(quantity=POSITION)).caption


def test_energy_stands_beside_the_error_of_position_of_the_run_that_is_the_fastest() -> None:
    rows = runs(quantity=POSITION)
    assert energies(rows).empty
    rows["energy"] = [10.0 ** -(k + 3) for k in range(len(rows))]
    table = energies(rows).set_index("contender")
    assert set(table.index) >= {"galvi, best", OF_RK4}
    best = fastest(rows[rows["contender"] == OF_RK4], 1e-4)
    assert table.loc[OF_RK4, "10⁻⁴"] == readable(best["energy"], 2)
    assert "not reached" in set(table.to_numpy().ravel())


def test_a_table_of_a_page_has_scopes_and_classes_and_no_foreign_tags() -> None:
    frame = pd.DataFrame(
        {"code": ["a<{b}", "same", "same"], "time": ["1 s", "not reached", np.nan], "x": "<i>"}
    )
    frame["link"] = pd.Series([Markup("<a href='#q'>q</a>")] * 3, dtype=object)
    html = html_table(frame, 'Times "1" < 2', ["time"], [(0, "time")], id="times")
    assert html.startswith(
        '<div class="wide" tabindex="0" role="region" aria-label="Times &#34;1&#34; &lt; 2">'
        '<table id="times">'
    )
    assert (
        '<th scope="col">code</th>' in html and '<th scope="col" class="number">time</th>' in html
    )
    assert '<th scope="row">a&lt;{b}</th>' in html and html.count('<th scope="row">same</th>') == 2
    assert '<td class="number best">1 s</td>' in html
    assert '<td class="absent number">not reached</td>' in html
    assert '<td class="number"></td>' in html and "<i>" not in html
    assert html.count("<td><a href='#q'>q</a></td>") == 3
    assert html_table(frame.head(0), "empty").count("<tr>") == 1


@pytest.mark.parametrize(
    ("low", "high", "said", "sentence"),
    [(0.8, 1.3, "tie, ", "galvi and B tie"), (5.2, 33.1, "within noise, ", "are within noise")],
)
def test_a_tie_is_one_only_where_its_own_interval_holds_1(low, high, said, sentence) -> None:
    """Noise as large as a difference leaves it open who is faster, and by how much."""
    row = {
        "problem": "body", "error": 1e-4, "contender": "B", "settings": "", "seconds": 1.0,
        "ratio": 0.5 * (low + high), "low": low, "high": high, "outcome": TIE, "closer": np.nan,
    }  # fmt: skip
    assert _cell(row).startswith(said)
    assert sentence in _outcome(1.0, pd.Series(row))[0]
