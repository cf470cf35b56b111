"""JUnit XML: what CI services read of a command."""

from __future__ import annotations

from xml.etree import ElementTree as tree

from reports.cli.commands import run
from reports.results.junit import JUnitCase, junit_xml

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
    assert tree.parse(tmp_path / "verify.xml").getroot().get("name") == "galvi verify"
