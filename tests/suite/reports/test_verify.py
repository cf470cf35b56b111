"""`galvi verify`: exit status, output for people and CI, rows that are kept, and changes."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree as tree

import pandas as pd
import pytest

from benchmarks.checks.claim import AGREEMENT
from benchmarks.claims import CLAIMS
from benchmarks.claims.statements import Statement, claims_by_place, places, statements
from references import EngineMissing
from reports.build.kept import kept_claims
from reports.build.verify import differs
from reports.results import summary as summary_module
from reports.results.junit import JUnitCase, github_annotations, junit_xml
from reports.results.rows import merge_rows, read_rows
from reports.results.summary import Summary
from tests.suite.reports.small_reports import ROW, claim, suite_of

ABSENT = "No module named 'rebound'. Install rebound 5 or newer."
WITHOUT = EngineMissing(f"REBOUND IAS15 cannot run: {ABSENT}", name="rebound")
CONTRADICTED = replace(ROW, verdict="contradicted")
NOT_RUN_ROW = replace(ROW, verdict="not run", measured=None, reason=f"Not by REBOUND. {ABSENT}")
# Orders that miss their true values by five of their stated errors.
MISSED_ORDERS = [
    replace(ROW, quantity=f"order {k}", bound="order 2", measured=2.0 + k, misses=5.0)
    for k in range(20)
]
HOSTILE = "<b>&]]>\"'\x00\x1b[31m\ud800\ufffe\n::error::=1+1"


@pytest.fixture
def without_rebound():
    engines = {"rebound": ABSENT, "mujoco": ""}
    return suite_of(claim(), claim("V2", raises=WITHOUT), engines=lambda: engines)


def cases():
    """Test cases of the verify.xml that was written, by class and name."""
    (suite,) = tree.parse("out/verify.xml").getroot()
    assert suite.get("name") == "galvi verify"
    for kind, tag in (("failures", "failure"), ("errors", "error"), ("skipped", "skipped")):
        assert int(suite.get(kind)) == len(list(suite.iter(tag)))
    return {(case.get("classname"), case.get("name")): case for case in suite}


def rows():
    return pd.read_csv("out/claims.csv", keep_default_na=False)


@pytest.mark.parametrize(
    ("claims", "status", "sentence"),
    [
        ([claim()], 0, "1 claim in 1 check: 1 holds; every verdict is the expected one."),
        ([claim("V1", (CONTRADICTED, ROW))], 1, "1 differs from what was expected (V1)."),
        ([claim("V1", (replace(CONTRADICTED, expected="contradicted"),))], 0, "1 contradicted;"),
        ([claim(), claim("V2", ())], 1, "V2 title of V2 was not run: ValueError: its judge"),
        (
            [claim(), claim("V2", (NOT_RUN_ROW,))],
            1,
            "V2 base of the error was not run: There are too few numbers to judge by. Expected was "
            f"holds: Not by REBOUND. {ABSENT}",
        ),
        (
            [claim(), claim("V2", raises=RuntimeError(f"not for want of REBOUND: {ABSENT}"))],
            1,
            "V2 base of the error was not run: RuntimeError: not for want",
        ),
        ([claim(), claim("V2", raises=ModuleNotFoundError("no flts", name="flts"))], 1, "no flts"),
        ([claim("V1", raises=WITHOUT)], 1, "nothing was measured"),
        (
            [claim("V1", tuple(MISSED_ORDERS))],
            1,
            "are too small: of 20 fitted orders whose true value is",
        ),
    ],
)
def test_the_status_is_0_where_every_verdict_is_the_expected_one(ask, claims, status, sentence):
    """An error that only mentions an engine that is absent is no excuse."""
    completed = ask("verify", suite_of(*claims, engines=lambda: {"rebound": ABSENT}))
    assert completed.status == status and sentence in " ".join(completed.out.split())
    assert "nan" not in completed.out


def test_a_study_that_raises_spoils_its_own_claim_only(ask):
    ask("verify", claim("V1", raises=RuntimeError("no engine here")), claim("V2"))
    first, second = rows().to_dict("records")
    assert (first["verdict"], first["measured"], first["expected"]) == ("not run", "", "holds")
    assert first["reason"] == "RuntimeError: no engine here"
    assert (second["verdict"], second["measured"]) == ("holds", "0.25")


@pytest.mark.parametrize(
    ("options", "chosen"),
    [
        ("--claims V3,V1", ["V1", "V3"]),
        ("--claims 'H thm. 3.1.1,V1'", ["V1", "V2"]),
        ("--claims 'M 6.2, fig. 3 right'", ["V24"]),
        ("--claims 'M fig. 3 right,V1'", ["V1", "V24"]),
        ("-k 'V1 and pendulum'", ["V1"]),
        ("-k orbit", ["V2", "V3", "V24"]),
    ],
)
def test_claims_are_chosen_by_names_by_places_of_a_paper_and_by_words(ask, options, chosen):
    sources = {"V1": "H fig. 2.3", "V2": "H thm. 2.1.1, 3.1.1", "V3": "H 3.1.1", "V24": ""}
    claims = (
        claim(id, (replace(ROW, source=at, quantity="pendulum" if id == "V1" else "orbit"),))
        for id, at in sources.items()
    )
    assert ask(f"verify {options}", *claims).status == 0
    assert list(rows()["id"]) == chosen


def test_a_place_is_checked_by_the_claims_that_its_statements_name():
    by_place = claims_by_place(CLAIMS)
    assert {"V13", "L11"} <= by_place["H lemma 3.3.1"] and "V23" in by_place["M fig. 3 left"]
    assert all(
        by_place[source] >= {*statement.claims}
        for statement in statements()
        for source in places(statement.where)
    )


def test_checks_that_failed_last_time_are_repeated_alone(ask):
    wrong = claim("V1", (CONTRADICTED,))
    for first, status, measured in (
        (wrong, 1, ["V1", "V2"]),
        (wrong, 1, ["V1"]),
        (claim(), 0, ["V1"]),
    ):
        completed = ask("verify --last-failed", first, claim("V2"))
        studied = [line for line in completed.err.splitlines() if line.startswith("[")]
        assert completed.status == status
        assert [line.split()[1] for line in studied] == measured


@pytest.mark.parametrize("options", ["-k V2", "--last-failed"])
def test_a_claim_whose_rows_only_a_measurement_shows_is_chosen_as_a_whole(ask, options):
    both = [replace(CONTRADICTED, id="V2", quantity=name) for name in ("one", "two")]
    of_a_user = replace(claim("V2"), check=lambda table: both if len(table) else table["id"])
    assert ask("verify", claim(), of_a_user).status == 1
    assert ask(f"verify {options}", claim(), of_a_user).status == 1
    assert [name for _, name in cases()] == ["one", "two"]


def test_every_row_is_a_test_case_with_its_bound_and_measured_value(ask):
    claim_rows = (
        replace(ROW, quantity="good"),
        replace(CONTRADICTED, quantity="wrong [<&\x00], again", measured=0.75),
        replace(NOT_RUN_ROW, quantity="absent", reason="No numbers."),
    )
    assert ask(
        "verify", claim("V1", claim_rows), claim("V2", raises=RuntimeError("it broke"))
    ).status
    test_cases = cases()
    (properties,) = test_cases["claim.V1", "good"]
    values = {entry.get("name"): entry.get("value") for entry in properties}
    assert (values["measured"], values["bound"]) == ("0.25 -+ 0.01", "at most 0.5")
    failure = test_cases["claim.V1", "wrong [<&?], again"].find("failure")
    message = "contradicted, expected was holds: measured 0.75, bound at most 0.5"
    assert message in failure.get("message") and "reason: " in failure.text
    assert "No numbers." in test_cases["claim.V1", "absent"].find("error").get("message")
    assert "it broke" in test_cases["claim.V2", "base of the error"].find("error").get("message")


@pytest.mark.parametrize(
    ("claims", "case"),
    [
        ([claim("V1", (CONTRADICTED,))], ("claim.V1", "base of the error")),
        ([claim("V1", raises=WITHOUT)], ("statements", "measured rows")),
        ([claim("V1", tuple(MISSED_ORDERS))], ("statements", "stated errors of orders")),
    ],
)
def test_what_makes_the_command_fail_is_red_in_the_file(ask, claims, case):
    ask("verify", suite_of(*claims, engines=lambda: {"rebound": ABSENT}))
    assert cases()[case].find("failure") is not None


def test_the_summary_says_what_failed_and_is_handed_to_the_forge(ask, tmp_path, monkeypatch):
    shown = tmp_path / "summary"
    shown.write_text("before\n")
    monkeypatch.setenv("GITHUB_STEP_SUMMARY", str(shown))
    wrong = claim("V1", (replace(CONTRADICTED, quantity="a|b<c>"),))
    assert ask("verify", wrong, claim("V2")).status == 1
    text = Path("out/verify.md").read_text()
    assert text.startswith("## verify: failed\n\n2 claims in 2 checks: 1 holds, 1 contradicted; ")
    before, folded = text.split("<details>")
    assert "a\\|b&lt;c>" in before and "| V2" not in before
    assert "| V2" in folded and "at most 0.5" in folded
    assert shown.read_text() == f"before\n{text}\n" and text.endswith("</details>\n")
    monkeypatch.setenv("GITHUB_STEP_SUMMARY", str(tmp_path))
    completed = ask("verify")
    assert completed.status == 0 and "not appended to $GITHUB_STEP_SUMMARY" in completed.err


def test_an_absent_engine_is_listed_and_its_rows_are_skipped(ask, without_rebound):
    completed = ask("verify", without_rebound)
    assert completed.status == 0 and "1 holds, 1 not run; every verdict" in completed.out
    assert f"rebound is absent: {ABSENT}" in completed.out
    test_cases = cases()
    for case in (("claim.V2", "base of the error"), ("engines", "rebound")):
        assert ABSENT in test_cases[case].find("skipped").get("message")
    assert len(test_cases["engines", "mujoco"]) == 0
    assert f"- rebound is absent: {ABSENT}" in Path("out/verify.md").read_text()
    assert list(read_rows(Path("out/claims.csv"))["absent"]) == ["", "rebound"]
    (row,) = kept_claims(Path("out"), without_rebound.claims)[1].rows
    assert (row.absent, row.expected) == ("rebound", "not run")
    rows().drop(columns="absent").to_csv("out/claims.csv", index=False)  # as an earlier version did
    (row,) = kept_claims(Path("out"), without_rebound.claims)[1].rows
    assert row.absent == ""


@pytest.mark.parametrize(
    ("engines", "status"), [("mujoco,rebound", 1), ("mujoco,rebound -k V1", 1), ("mujoco", 0)]
)
def test_an_absent_engine_that_is_required_is_a_failure(ask, without_rebound, engines, status):
    completed = ask(f"verify --require {engines}", without_rebound)
    assert completed.status == status
    assert ("rebound is absent, and was required" in completed.out) == status
    assert (cases()["engines", "rebound"].find("failure") is not None) == status
    assert ("## verify: failed" in Path("out/verify.md").read_text()) == status


def test_checking_one_claim_keeps_the_rows_of_the_others_and_says_of_when_they_are(ask):
    def at(date, *claims):
        return replace(suite_of(*claims), provenance=lambda command: {"date": date, "commit": "c"})

    third = claim("V3", (replace(ROW, measured=1.0 / 3.0),))
    assert ask("verify", at("2026-02-03", claim("V1"), claim("V2"), third)).status == 0
    all_four = map(claim, ("V1", "V2", "V3", "V4"))
    assert ask("verify --claims V2,V4 --quick", at("now", *all_four)).status == 0
    table = rows()
    assert list(table["id"]) == ["V1", "V2", "V3", "V4"]
    assert list(table["date"]) == ["2026-02-03", "now", "2026-02-03", "now"]
    assert list(table["setting"]) == ["default", "quick", "default", "quick"]
    assert float(table["measured"][2]) == 1.0 / 3.0
    assert Path("out/tables/claims.md").read_text().count("| V") == 4
    assert {path.stem for path in Path("out/frames").iterdir()} == {"V1", "V2", "V3", "V4"}
    assert json.loads(Path("out/provenance.json").read_text())["claims.csv"]["setting"] == "quick"


def test_rows_of_a_file_without_marks_get_those_of_the_file(ask):
    both = claim("V1"), claim("V2")
    ask("verify", *both)
    rows().drop(columns=["date", "commit", "setting"]).to_csv("out/claims.csv", index=False)
    ask("verify --claims V2", *both)
    assert set(rows()["commit"]) == {"0123456789abcdef+dirty"}


@pytest.mark.parametrize("text", ["", "a,b\n1,2\n", "id,b\n1,2\n1,2,3\n"])
def test_rows_that_cannot_be_read_are_told_and_replaced(ask, tmp_path, text):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "claims.csv").write_text(text)
    completed = ask("verify")
    assert (
        completed.status == 0 and "claims.csv is left out, since it cannot be read" in completed.err
    )
    assert list(rows()["id"]) == ["V1"]


def test_a_claim_that_is_gone_leaves_the_table():
    before = pd.DataFrame({"id": ["V1", "W9"], "x": [1, 2]})
    now = pd.DataFrame({"id": ["V2"], "x": [3]})
    table = merge_rows(before, now, "id", ["V2"], ["V1", "V2"])
    assert table.to_dict("list") == {"id": ["V1", "V2"], "x": [1, 3]}


def test_what_changed_is_printed_and_written(ask):
    def check(options="", **rows):
        claim_rows = tuple(replace(ROW, quantity=name, **fields) for name, fields in rows.items())
        return ask(f"verify {options}", claim("V1", claim_rows)).out

    still = {"measured": 2.0, "uncertainty": 0.1}
    assert "Changed" not in check(verdict={}, number={}, still=still, old={})
    exceeds = {"verdict": "exceeds"}
    printed = check(
        verdict=exceeds, number={"measured": 0.3}, still=still | {"measured": 2.2}, fresh={}
    )
    for where in (printed, Path("out/verify.md").read_text()):
        changed = where[where.index("Changed since the rows before") :].split("<details>")[0]
        for phrase in ("verdict", "number", "0.25 -+ 0.01", "0.3 -+ 0.01", "fresh", "gone", "old"):
            assert phrase in changed
        assert "still" not in changed
    assert " more, in verify.md." in check(**{f"fresh {k}": {} for k in range(20)})
    assert "Changed" not in check("--quick", number={"measured": 99.0})  # another measurement


def test_a_number_moves_beyond_its_uncertainty_or_a_tenth():
    assert not differs(1.0, 0.1, 1.28, 0.1) and differs(1.0, 0.1, 1.29, 0.1)
    assert not differs(1.0, None, 1.1, float("nan")) and differs(1.0, None, 1.12, None)
    assert differs(1.0, 0.1, float("nan"), 0.1) and not differs(None, None, float("nan"), None)


def test_an_interrupt_has_a_status_and_leaves_the_file_of_the_last_run(ask):
    ask("verify")
    before = Path("out/verify.xml").read_bytes()
    completed = ask("verify", claim("V1", raises=KeyboardInterrupt()))
    assert completed.status == 130
    assert "Interrupted; the files that were written are whole." in completed.err
    assert Path("out/verify.xml").read_bytes() == before


def test_claims_are_counted_apart_from_their_checks():
    claim_rows = [
        ROW,
        replace(ROW, id="V2"),
        replace(CONTRADICTED, id="V2", expected="contradicted"),
        *[replace(ROW, id="V3", verdict="finding", expected="finding")] * 2,
        replace(ROW, id="V4", verdict="not run", expected="not run"),
        replace(ROW, id="V5", verdict="exceeds", expected="exceeds"),
        replace(ROW, id="A1", source=AGREEMENT),
    ]
    counts = str(Summary(tuple(claim_rows)))
    assert "3 holds, 1 exceeded, 1 contradicted, 2 findings, 1 not run" in counts


def test_orders_whose_stated_errors_are_too_small_are_no_success():
    """Planted: ten orders off by one of their stated errors, and ten by three."""
    within, off = (
        [
            replace(ROW, id=f"V{k}", measured=4.0 + k, misses=misses)
            for k in range(first, first + 10)
        ]
        for first, misses in ((0, 1.0), (10, 3.0))
    )
    summary = Summary((*within, off[0]))
    assert summary.holds() and "The stated errors cover: of 11 fitted orders" in str(summary)
    summary = Summary((*within, *off))
    assert not summary.holds() and not summary.differing


UNFOUNDED = Statement("H fig. 2.4", "figure", "It is so.", "reproduced", "", ("V1",), "", "")


@pytest.mark.parametrize(
    ("statement", "claim_rows", "passes"),
    [
        (replace(UNFOUNDED, where="H fig. 2.3"), (ROW,), True),
        (UNFOUNDED, (ROW,), False),
        (replace(UNFOUNDED, claims=("V2",)), (ROW,), True),
        (UNFOUNDED, (ROW, replace(ROW, verdict="not run", expected="not run")), True),
        (UNFOUNDED, (*[ROW] * 99, CONTRADICTED), True),
    ],
)
def test_a_statement_that_its_rows_do_not_found_is_no_success(
    monkeypatch, statement, claim_rows, passes
):
    """Only where every claim that statements name has rows, and all are as expected."""
    monkeypatch.setattr(summary_module, "statements", lambda: (statement,))
    summary = Summary(claim_rows)
    assert summary.holds(fail_under=90.0) == passes
    sentence = "1 printed statement unfounded: H fig. 2.4 (It is so.) is called reproduced; no row"
    assert (sentence in str(summary)) != passes


def test_a_junit_file_is_well_formed_whatever_the_texts_are():
    case = JUnitCase(HOSTILE, HOSTILE, 0.5, "failure", HOSTILE, HOSTILE)
    root = tree.fromstring(junit_xml(HOSTILE, {HOSTILE: [case]}).encode())
    (parsed,) = root.iter("testcase")
    assert parsed.find("failure").text == parsed.find("system-out").text
    assert parsed.find("failure").text == "<b>&]]>\"'??[31m??\n::error::=1+1"


def test_totals_of_a_junit_file_are_of_all_suites_and_details_of_a_passed_case_stay():
    kinds = ("passed", "failure", "error", "skipped", "error")
    junit_cases = [JUnitCase("class", kind, 0.25, kind, "why", "more") for kind in kinds]
    root = tree.fromstring(
        junit_xml("galvi track", {"a": junit_cases, "b": junit_cases[:2], "c": []}).encode()
    )
    counts = ("tests", "failures", "errors", "skipped", "time")
    assert [root.get(name) for name in counts] == ["7", "2", "2", "1", "1.750"]
    assert [suite.get("tests") for suite in root] == ["5", "2", "0"]
    (output,), failed = root[1]
    assert (output.tag, output.text) == ("system-out", "more")
    assert (failed[0].get("message"), failed[0].text) == ("why", "more")


def test_a_job_on_github_shows_ten_failures_each_on_a_line(monkeypatch):
    name = "a: b, 50 %\n::error::"
    failed = [JUnitCase("claim.V1", name, 0.0, "failure", "5 % off: no,\r\nyes")] * 12
    junit_cases = [JUnitCase("claim.V1", "right"), *failed]
    monkeypatch.delenv("GITHUB_ACTIONS", raising=False)
    assert github_annotations(junit_cases) == []
    monkeypatch.setenv("GITHUB_ACTIONS", "true")
    title = "claim.V1%3A a%3A b%2C 50 %25%0A%3A%3Aerror%3A%3A"
    assert (
        github_annotations(junit_cases) == [f"::error title={title}::5 %25 off: no,%0D%0Ayes"] * 10
    )


def test_verify_shows_its_failures_there_and_nothing_of_a_success(ask, monkeypatch):
    monkeypatch.setenv("GITHUB_ACTIONS", "true")
    wrong = claim("V1", (CONTRADICTED, *(replace(ROW, quantity=name) for name in "23")))
    for options, status, shown in (("", 1, 1), ("--fail-under 60", 0, 0)):
        completed = ask(f"verify {options}", wrong)
        title = "::error title=claim.V1%3A base of the error::contradicted, expected"
        assert (
            completed.status == status
            and completed.out.count(title) == completed.out.count("::error") == shown
        )
