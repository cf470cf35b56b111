"""JUnit XML: what CI services read of a command."""

from xml.etree import ElementTree as tree

from reports.cli.commands import run
from reports.results.junit import JUnitCase, github_annotations, junit_xml

HOSTILE = "<b>&]]>\"'\x00\x1b[31m\ud800\ufffe\n::error::=1+1"


def test_a_file_is_well_formed_whatever_the_texts_are():
    case = JUnitCase(HOSTILE, HOSTILE, 0.5, "failure", HOSTILE, HOSTILE)
    root = tree.fromstring(junit_xml(HOSTILE, {HOSTILE: [case]}).encode())
    (found,) = root.iter("testcase")
    assert found.find("failure").text == found.find("system-out").text
    assert found.find("failure").text == "<b>&]]>\"'??[31m??\n::error::=1+1"


def test_totals_are_of_all_suites_and_details_of_a_passed_case_stay():
    outcomes = ("passed", "failure", "error", "skipped", "error")
    cases = [
        JUnitCase("class", str(n), 0.25, kind, "why", "more") for n, kind in enumerate(outcomes)
    ]
    root = tree.fromstring(junit_xml("galvi track", {"a": cases, "b": cases[:2], "c": []}).encode())
    counts = ("name", "tests", "failures", "errors", "skipped", "time")
    assert [root.get(name) for name in counts] == ["galvi track", "7", "2", "2", "1", "1.750"]
    assert [suite.get("tests") for suite in root] == ["5", "2", "0"]
    passed, failed = root[1]
    assert [child.tag for child in passed] == ["system-out"] and passed[0].text == "more"
    assert failed[0].get("message") == "why" and failed[0].text == "more"


def test_the_file_is_called_as_the_command_was(make_suite, tmp_path):
    assert run(make_suite, ["verify", "--out", str(tmp_path)], called=["galvi"]) == 0
    (suite,) = tree.parse(tmp_path / "verify.xml").getroot()
    assert suite.get("name") == "galvi verify"


def test_a_job_on_github_shows_ten_failures_each_on_a_line(monkeypatch):
    name = "a: b, 50 %\n::error::"
    failed = [JUnitCase("claim.V1", name, 0.0, "failure", "5 % off: no,\r\nyes")] * 12
    cases = [JUnitCase("claim.V1", "right"), *failed]
    monkeypatch.delenv("GITHUB_ACTIONS", raising=False)
    assert github_annotations(cases) == []
    monkeypatch.setenv("GITHUB_ACTIONS", "true")
    title = "claim.V1%3A a%3A b%2C 50 %25%0A%3A%3Aerror%3A%3A"
    assert github_annotations(cases) == [f"::error title={title}::5 %25 off: no,%0D%0Ayes"] * 10


def test_verify_shows_its_failures_there_and_nothing_of_a_success(
    make_suite, make_claim, make_row, tmp_path, monkeypatch, capsys
):
    monkeypatch.setenv("GITHUB_ACTIONS", "true")
    wrong = make_claim(
        "V1", (make_row(verdict="contradicted"), make_row(quantity="2"), make_row(quantity="3"))
    )
    assert run(lambda: make_suite(wrong), ["verify", "--out", str(tmp_path)]) == 1
    (line,) = [one for one in capsys.readouterr().out.splitlines() if one.startswith("::")]
    assert line.startswith("::error title=claim.V1%3A base of the error::contradicted, expected")
    words = ["verify", "--fail-under", "60", "--out", str(tmp_path)]
    assert run(lambda: make_suite(wrong), words) == 0
    assert "::error" not in capsys.readouterr().out
