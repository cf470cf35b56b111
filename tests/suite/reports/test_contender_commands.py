"""Users' integrators and problems in the commands: the page's examples, settings, truths and
failures."""

from __future__ import annotations

import re
from dataclasses import replace
from functools import partial
from pathlib import Path
from xml.etree import ElementTree as tree

import numpy as np
import pandas as pd
import pytest

import galvi
from benchmarks.applications.external.check_problems import CHECK_PROBLEMS
from benchmarks.applications.external.checks import contender_checks
from benchmarks.applications.external.integrator import ExternalIntegrator
from benchmarks.applications.external.loading import ContenderError
from benchmarks.studies import ephemeris
from benchmarks.work_precision import own_problem as own
from benchmarks.work_precision import run as work_precision
from benchmarks.work_precision import truths
from benchmarks.work_precision.problems.planets import kepler
from references.jpl import states as jpl
from reports.contents import load
from reports.studies.engines import EPHEMERIS
from reports.tables.claims_table import ROW_COLUMNS
from tests.suite.benchmarks.contenders_at_hand import BROKEN, Gauss, Inside
from tests.suite.reports.small_reports import suite_of

FEW = ("galvi degree 8, Gauss 8", "Stormer-Verlet")
EXAMPLES = Path(__file__).parents[3] / "docs" / "examples"
TROUBLE = """
import numpy as np
import galvi

class Trouble:
    name = "trouble"

    def supports(self, problem):
        return isinstance(problem.system, galvi.Canonical)

    def run(self, problem, duration, setting):
        what = setting.get("samples", 1)
        if what == 2:
            raise RuntimeError("no, thanks")
        if what == 5:
            print("a line that is no part of any table")
            return {"q": 1.0}
        t = problem.t0 + duration * np.arange(what + 1) / what
        q = np.array([problem.q0] * (what + 1))
        p = np.array([problem.p0] * (what + 1))
        return galvi.Trajectory(problem, t, q, p, counts={"steps": what})
"""


def example(name):
    """A module that docs/suite.md shows."""
    return (EXAMPLES / f"{name}.py").read_text(encoding="utf-8")


def definitions(name):
    """The names that an example of the page defines, and their values."""
    names: dict[str, type] = {}
    exec(compile(example(name), f"{name}.py", "exec"), names)
    return names


@pytest.fixture(scope="module", autouse=True)
def outside(tmp_path_factory):
    """A folder on Python's path with the page's examples and a contender that fails."""
    folder = tmp_path_factory.mktemp("outside")
    for name in ("mine", "my_problem"):
        (folder / f"{name}.py").write_text(example(name))
    (folder / "trouble.py").write_text(TROUBLE)
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(folder))
        yield


@pytest.fixture
def kepler_suite(monkeypatch):
    """A suite that compares few of the participants on Kepler's problem."""
    case = kepler(1, quick=True)
    participants = tuple(
        participant for participant in case.participants if participant.label in FEW
    )
    monkeypatch.setattr(
        work_precision,
        "work_precision_problems",
        lambda quick: (replace(case, participants=participants),),
    )
    return suite_of(work_precision=work_precision.work_precision)


def compared():
    return pd.read_csv("out/work_precision.csv", keep_default_na=False)


@pytest.mark.slow(beside="test_what_goes_wrong_is_a_sentence_in_the_table_and_on_the_terminal")
def test_the_example_of_the_page_stands_beside_ours_everywhere(ask, kepler_suite, monkeypatch):
    if jpl.missing():
        pytest.skip(jpl.missing())
    monkeypatch.setattr(ephemeris, "displacement", lambda gm, q, v, times: 0.0 * times)
    monkeypatch.setattr("reports.results.own_problems.contender_checks", lambda externals: ())
    suite = replace(kepler_suite, sections=(*kepler_suite.sections, EPHEMERIS))
    completed = ask("build --quick --contender mine:Leapfrog", suite)
    assert completed.status == 0, completed.err
    leapfrog_rows = compared().query("contender == 'my leapfrog'")
    assert len(leapfrog_rows) == 3 and (leapfrog_rows["status"] == "").all()
    files = [f"tables/{table}.csv" for table in ("ratios", "smallest", "ephemeris")]
    for file in (*files, "figures/work-precision-kepler-e-0-6.svg", "results/comparisons.html"):
        assert "my leapfrog" in (Path("out") / file).read_text()


def test_what_goes_wrong_is_a_sentence_in_the_table_and_on_the_terminal(
    ask, kepler_suite, monkeypatch
):
    settings = [{"samples": samples} for samples in (2, 5, 1, 2)]
    monkeypatch.setattr(ExternalIntegrator, "settings", lambda *of: settings)
    completed = ask("compare --quick --contender trouble:Trouble", kepler_suite)
    sentence = "samples=2 and 1 more: It raised RuntimeError: no, thanks.\n"
    assert (
        completed.status == 1 and f"trouble, kepler e=0.6, T = 6.28319, {sentence}" in completed.err
    )
    assert "no part of any table" not in completed.out
    rows = compared()
    assert set(rows["contender"]) == {*FEW, "trouble"}
    reference_rows, trouble_rows = (
        rows[(rows["contender"] == "trouble") == is_trouble] for is_trouble in (False, True)
    )
    first, second, *_ = trouble_rows["status"]
    assert first == "It raised RuntimeError: no, thanks."
    assert second.startswith("Its run must return a galvi.Trajectory; received d")
    assert list(trouble_rows["error"] != "") == [False, False, True, False]
    assert (reference_rows["seconds"] != "").all()


class Hanging(Inside):
    """Each of its runs ends as if its process were stopped."""

    def _ask(self, question, *arguments, is_trial=False):
        if question == "timed run":
            raise ContenderError("It did not answer within 60 s, and was stopped.")
        return super()._ask(question, *arguments, is_trial=is_trial)


@pytest.fixture
def verify(monkeypatch, ask):
    """A function that runs `verify --contender` on an orbit, with a contender in this process, and
    returns the outcome of the command and claims.csv."""
    chosen = [
        check_problem
        for check_problem in CHECK_PROBLEMS
        if check_problem.problem.name.startswith("kepler")
    ]
    few_checks = partial(
        contender_checks,
        check_problems=[replace(check_problem, long=20.3) for check_problem in chosen],
    )
    monkeypatch.setattr("reports.results.own_problems.contender_checks", few_checks)

    def verify(external, options=""):
        monkeypatch.setattr(ExternalIntegrator, "open", lambda path, limit: external)
        completed = ask(f"verify --contender mine:It {options}")
        return completed, pd.read_csv("out/claims.csv", keep_default_na=False)

    return verify


def test_the_example_of_the_page_passes_and_its_rows_are_those_of_a_claim(verify, ask):
    completed, rows = verify(Inside.of(definitions("mine")["Leapfrog"]()))
    assert completed.status == 0, completed
    assert "1 claim and 1 agreement in " in completed.out and "finding" in completed.out
    assert list(rows.columns)[: len(ROW_COLUMNS)] == list(ROW_COLUMNS)
    leapfrog_rows = rows[rows["id"] == "A-my-leapfrog"].set_index("quantity")
    order = leapfrog_rows.loc["order in the step, kepler e=0.3"]
    assert order["verdict"] == "attained"
    assert float(order["measured"]) == pytest.approx(2.0, abs=0.1)
    assert leapfrog_rows.loc["relative change of energy, kepler e=0.3"]["verdict"] == "holds"
    assert Path("out/verify.xml").read_text().count("agreement.A-my-leapfrog") == len(leapfrog_rows)
    assert ask("verify").status == 0
    assert "leapfrog" not in Path("out/claims.csv").read_text()


def test_the_adaptive_example_of_the_page_passes(verify):
    options = "--claims A-my-adaptive-method"
    completed, rows = verify(Inside.of(definitions("adaptive")["Adaptive"]()), options)
    assert completed.status == 0, completed
    assert rows["quantity"].str.contains("error at .*1e-12").any(), rows["quantity"].tolist()


@pytest.mark.parametrize("broken", BROKEN, ids=lambda kind: kind.__name__)
def test_a_broken_one_is_red_and_named_and_the_claims_go_on(verify, broken):
    completed, rows = verify(Inside.of(broken()))
    assert completed.status == 1 and (rows[rows["id"] == "V1"]["verdict"] == "holds").all()
    assert BROKEN[broken] in completed.err and BROKEN[broken] in Path("out/verify.md").read_text()
    assert int(tree.parse("out/verify.xml").getroot()[0].get("failures")) >= 2


def test_one_that_hangs_is_given_up_and_red(verify):
    completed, rows = verify(Hanging.of(Gauss()), "--claims A-a-gauss")
    assert completed.status == 1 and set(rows["id"]) == {"A-a-gauss"}
    assert "It did not answer within 60 s, and was stopped." in completed.err
    errors = rows[rows["quantity"].str.startswith("error at step")]
    assert set(errors["verdict"]) == {"contradicted"}


def test_what_it_printed_is_said_on_standard_error_and_its_first_lines_are_a_row(verify):
    external = Inside.of(Gauss())
    external.printed.lines, external.printed.first = 48_260, ["step 1", "step 2"]
    completed, rows = verify(external, "--claims A-a-gauss")
    assert completed.status == 0
    assert 'a gauss printed 48,260 lines, the first of them "step 1".\n' in completed.err
    row = rows.set_index("quantity").loc["lines that it printed"]
    assert row["verdict"] == row["expected"] == "finding" and "step 1 / step 2" in row["reason"]


# A problem of one's own.


@pytest.fixture
def quick_own_problems(monkeypatch):
    """Fewer participants and less patience."""
    monkeypatch.setattr(own, "FIXED", {"Stormer-Verlet": {}})
    monkeypatch.setattr(own, "GALVI_DEGREES", (8,))
    monkeypatch.setattr(own, "LADDER_SECONDS", 0.2)


def test_the_pages_problem_is_compared_with_the_codes_that_take_it(quick_own_problems, ask):
    completed = ask("compare --quick --problem my_problem:spring", load())
    assert completed.status == 0, completed.err
    assert "spring: times at matched error" in completed.out and "SciPy DOP853" in completed.out
    assert completed.out.endswith("Tables are in out/tables.\n")
    rows = compared()
    assert set(rows["problem"]) == {"spring"}
    assert set(rows["contender"]) - {"heyoka, Lagrangians"} == {*FEW, "SciPy DOP853"}
    errors = rows["error"].astype(float)
    assert (errors > 0.0).all() and errors.min() < 1e-9 and (rows["seconds"] > 0.0).all()
    assert not rows["status"].str.contains("differenced").any()


@pytest.mark.slow(beside="test_the_pages_problem_is_compared_with_the_codes_that_take_it")
def test_a_force_without_a_gradient_or_a_formula_is_said_to_be_differenced(quick_own_problems):
    gradient, potential = (definitions("my_problem")[name] for name in ("gradient", "potential"))
    for function, slope in ((potential, gradient), (lambda q: float(potential(q)), None)):
        spring = galvi.Canonical(1.0, function, slope)
        case = own.own_problem(galvi.Problem(spring, [1.0, 0.3], [0.0, 0.2]), 5.0, quick=True)
        rows = work_precision.work_precision(quick=True, cases=(case,))
        differenced = rows["status"].str.contains(own.DIFFERENCED_NOTE, regex=False)
        of_newton = rows["contender"].isin(own.NEWTON_FORCE_CODES)
        assert of_newton.any() and not of_newton.all()
        assert (differenced == (of_newton & (slope is None))).all()


@pytest.mark.slow(beside="test_the_pages_problem_is_compared_with_the_codes_that_take_it")
def test_steps_are_found_between_a_tenth_of_the_motion_and_the_truth(quick_own_problems):
    pytest.importorskip("rebound")
    case = own.own_problem(galvi.problems.kepler(0.3), 20.0)
    truth = case.truth()
    second = "heyoka, quadruple precision|REBOUND IAS15"
    assert re.match(f"Kepler, closed form; by its difference from ({second})$", truth.description)
    assert truth.error < 1e-12 and truth.source == ("Kepler, closed form", "")
    table = work_precision.work_precision(quick=True, cases=(case,))
    settings = table["settings"].str
    for _, rows in table[settings.startswith("step=") & ~settings.contains("tol")].groupby(
        "contender"
    ):
        assert rows["error"].is_monotonic_decreasing and len(rows) > 2
        assert rows["error"].iloc[0] < 0.2
    assert set(table["contender"]) >= {"REBOUND IAS15", "SciPy DOP853", "Stormer-Verlet"}


@pytest.mark.slow(beside="test_without_another_code_there_is_no_truth")
def test_a_truth_with_one_source_is_measured_against_itself(quick_own_problems, monkeypatch):
    only = {"SciPy DOP853": truths.TRUTHS["SciPy DOP853"]}
    monkeypatch.setattr(truths, "TRUTHS", only)
    truth = own.own_problem(galvi.problems.henon_heiles(), 5.0, quick=True).truth()
    assert "by its difference from itself at 30 times" in truth.description
    assert 1e-16 < truth.error < 1e-11


def test_without_another_code_there_is_no_truth():
    def height(q, v):
        return 0.5 * v @ v - 0.1 * q[2, 2]

    group = galvi.Lagrangian(height, galvi.SO3())
    problem = galvi.Problem(group, np.eye(3), [1.0, 0.2, 0.3], name="mine")
    with pytest.raises(ValueError, match=r"mine needs a truth that is not galvi's; received a Lag"):
        own.own_problem(problem, 1.0)
