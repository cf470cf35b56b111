"""`verify --contender`: what somebody else's CI sees, with the contender at hand and no process."""

from __future__ import annotations

import re
from dataclasses import replace
from functools import partial
from pathlib import Path
from xml.etree import ElementTree as tree

import pandas as pd
import pytest

from benchmarks.applications.external.check_problems import CHECK_PROBLEMS
from benchmarks.applications.external.checks import contender_checks
from benchmarks.applications.external.loading import ContenderError
from reports.cli.commands import run
from reports.tables.claims_table import COLUMNS
from tests.suite.benchmarks.contenders_at_hand import BROKEN, Gauss, Inside

ROOT = Path(__file__).parents[3]


class Hanging(Inside):
    """Its process is stopped whenever it is to run."""

    def _ask(self, question, *arguments, tried=False):
        if question == "timed run":
            raise ContenderError("It did not answer within 60 s, and was stopped.")
        return super()._ask(question, *arguments, tried=tried)


@pytest.fixture
def verify(monkeypatch, make_suite, tmp_path):
    """`verify --contender` on an orbit; the exit status and claims.csv."""
    chosen = [one for one in CHECK_PROBLEMS if one.problem.name.startswith("kepler")]
    few = partial(contender_checks, check_problems=[replace(one, long=20.3) for one in chosen])
    monkeypatch.setattr("reports.results.own_problems.contender_checks", few)

    def asked(external, *words):
        monkeypatch.setattr(
            "reports.results.own_problems.ExternalIntegrator.open", lambda path, limit: external
        )
        line = ["verify", "--contender", "mine:It", *words, "--out", str(tmp_path)]
        status = run(make_suite, line)
        return status, pd.read_csv(tmp_path / "claims.csv", keep_default_na=False)

    return asked


def test_the_example_of_the_page_passes_and_its_rows_are_those_of_a_claim(
    verify, make_suite, tmp_path, capsys
):
    page = (ROOT / "docs" / "suite.md").read_text()
    (example,) = re.findall(r"^```python\n(# mine\.py\n.*?)^```$", page, re.M | re.S)
    names: dict[str, type] = {}
    exec(compile(example, "mine.py", "exec"), names)
    status, rows = verify(Inside.of(names["Leapfrog"]()))
    told = capsys.readouterr()
    assert status == 0, told
    assert "1 claim and 1 agreement in " in told.out and "finding" in told.out
    assert list(rows.columns)[: len(COLUMNS)] == list(COLUMNS)
    mine = rows[rows["id"] == "A-my-leapfrog"].set_index("quantity")
    order = mine.loc["order in the step, kepler e=0.3"]
    assert order["verdict"] == "attained"
    assert float(order["measured"]) == pytest.approx(2.0, abs=0.1)
    assert mine.loc["relative change of energy, kepler e=0.3"]["verdict"] == "holds"
    assert (tmp_path / "verify.xml").read_text().count("agreement.A-my-leapfrog") == len(mine)
    assert run(make_suite, ["verify", "--out", str(tmp_path)]) == 0
    assert "leapfrog" not in (tmp_path / "claims.csv").read_text()


def test_the_adaptive_example_of_the_page_passes(verify, capsys):
    page = (ROOT / "docs" / "suite.md").read_text()
    (example,) = re.findall(r"^```python\n(# adaptive\.py\n.*?)^```$", page, re.M | re.S)
    names: dict[str, type] = {}
    exec(compile(example, "adaptive.py", "exec"), names)
    status, rows = verify(Inside.of(names["Adaptive"]()), "--claims", "A-my-adaptive-method")
    assert status == 0, capsys.readouterr()
    assert rows["quantity"].str.contains("error at .*1e-12").any(), rows["quantity"].tolist()


@pytest.mark.parametrize("broken", BROKEN, ids=lambda kind: kind.__name__)
def test_a_broken_one_is_red_and_named_and_the_claims_go_on(verify, broken, tmp_path, capsys):
    status, rows = verify(Inside.of(broken()))
    assert status == 1 and (rows[rows["id"] == "V1"]["verdict"] == "holds").all()
    why = BROKEN[broken]
    assert why in capsys.readouterr().err and why in (tmp_path / "verify.md").read_text()
    root = tree.parse(tmp_path / "verify.xml").getroot()
    assert int(root[0].get("failures")) >= 2


def test_one_that_hangs_is_given_up_and_red(verify, capsys):
    status, rows = verify(Hanging.of(Gauss()), "--claims", "A-a-gauss")
    assert status == 1 and set(rows["id"]) == {"A-a-gauss"}
    assert "It did not answer within 60 s, and was stopped." in capsys.readouterr().err
    assert set(rows[rows["quantity"].str.startswith("error at step")]["verdict"]) == {
        "contradicted"
    }


def test_what_it_printed_is_said_on_standard_error_and_its_first_lines_are_a_row(verify, capsys):
    external = Inside.of(Gauss())
    external.printed.lines, external.printed.first = 48_260, ["step 1", "step 2"]
    status, rows = verify(external, "--claims", "A-a-gauss")
    assert status == 0
    assert 'a gauss printed 48,260 lines, the first of them "step 1".\n' in capsys.readouterr().err
    (row,) = (row for _, row in rows.iterrows() if row["quantity"] == "lines that it printed")
    assert row["verdict"] == row["expected"] == "finding" and "step 1 / step 2" in row["reason"]
