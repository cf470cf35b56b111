"""`verify` for CI: what a forge reads, engines that must be there, rows that stay, what changed."""

import json
from dataclasses import replace
from xml.etree import ElementTree as tree

import pandas as pd
import pytest
import typer

from benchmarks.claims import CLAIMS
from benchmarks.claims.statements import claims_by_place, places, statements
from references import EngineMissing
from reports.build.kept import kept_claims
from reports.build.verify import moved
from reports.cli.commands import run
from reports.cli.options import choose_claims
from reports.results.rows import merged, read_rows

ABSENT = "No module named 'rebound'. Install rebound 5 or newer."


@pytest.fixture
def cases(tmp_path):
    """Test cases of the verify.xml that was written, by class and name."""

    def read():
        (suite,) = tree.parse(tmp_path / "verify.xml").getroot()
        for kind in ("failures", "errors", "skipped"):
            tag = {"failures": "failure", "errors": "error"}.get(kind, kind)
            assert int(suite.get(kind)) == len(list(suite.iter(tag)))
        return {(case.get("classname"), case.get("name")): case for case in suite}

    return read


def test_every_row_is_a_test_case_with_its_bound_and_measured_value(
    make_suite, make_claim, make_row, tmp_path, cases
):
    rows = (
        make_row(quantity="good"),
        make_row(quantity="wrong [<&\x00], again", verdict="contradicted", measured=0.75),
        make_row(quantity="absent", verdict="not run", measured=None, reason="No numbers."),
    )
    suite = make_suite(make_claim("V1", rows), make_claim("V2", raises=RuntimeError("it broke")))
    assert run(lambda: suite, ["verify", "--out", str(tmp_path)]) == 1
    found = cases()
    good = found["claim.V1", "good"]
    assert [child.tag for child in good] == ["properties"]
    properties = {one.get("name"): one.get("value") for one in good[0]}
    assert (properties["measured"], properties["bound"]) == ("0.25 -+ 0.01", "at most 0.5")
    failure = found["claim.V1", "wrong [<&?], again"].find("failure")
    assert "contradicted, expected was holds: measured 0.75, bound at most 0.5" in failure.get(
        "message"
    )
    assert "reason: " in failure.text and "\n" not in failure.get("message")
    assert "No numbers." in found["claim.V1", "absent"].find("error").get("message")
    assert "it broke" in found["claim.V2", "base of the error"].find("error").get("message")


def test_the_summary_says_what_failed_and_is_handed_to_the_forge(
    make_suite, make_claim, make_row, tmp_path, monkeypatch
):
    shown = tmp_path / "summary"
    shown.write_text("before\n")
    monkeypatch.setenv("GITHUB_STEP_SUMMARY", str(shown))
    wrong = make_claim("V1", (make_row(verdict="contradicted", quantity="a|b<c>"),))
    assert run(lambda: make_suite(wrong, make_claim("V2")), ["verify", "--out", str(tmp_path)]) == 1
    text = (tmp_path / "verify.md").read_text()
    assert text.startswith("## verify: failed\n\n2 claims in 2 checks: 1 holds, 1 contradicted; ")
    before, folded = text.split("<details>")
    assert "| V1" in before and "a\\|b&lt;c>" in before and "| V2" not in before
    assert "| V2" in folded and "at most 0.5" in folded
    assert shown.read_text() == "before\n" + text


def test_a_summary_that_cannot_be_appended_is_told_and_no_failure(
    make_suite, tmp_path, monkeypatch, capsys
):
    monkeypatch.setenv("GITHUB_STEP_SUMMARY", str(tmp_path))
    assert run(make_suite, ["verify", "--out", str(tmp_path)]) == 0
    assert "not appended to $GITHUB_STEP_SUMMARY" in capsys.readouterr().err


@pytest.fixture
def without_rebound(make_suite, make_claim):
    raises = EngineMissing(f"REBOUND IAS15 cannot run: {ABSENT}", name="rebound")
    claims = (make_claim("V1"), make_claim("V2", raises=raises))
    engines = {"rebound": ABSENT, "mujoco": ""}
    return make_suite(*claims, engines=lambda: engines)


def test_an_absent_engine_is_listed_and_its_rows_are_skipped(
    without_rebound, tmp_path, capsys, cases
):
    assert run(lambda: without_rebound, ["verify", "--out", str(tmp_path)]) == 0
    printed = capsys.readouterr().out
    assert "2 claims in 2 checks: 1 holds, 1 not run; every verdict" in printed
    assert f"rebound is absent: {ABSENT}" in printed
    found = cases()
    assert ABSENT in found["claim.V2", "base of the error"].find("skipped").get("message")
    assert ABSENT in found["engines", "rebound"].find("skipped").get("message")
    assert len(found["engines", "mujoco"]) == 0
    assert f"- rebound is absent: {ABSENT}" in (tmp_path / "verify.md").read_text()
    rows = read_rows(tmp_path / "claims.csv")
    assert list(rows["absent"]) == ["", "rebound"]
    (kept,) = kept_claims(tmp_path, without_rebound.claims)[1].rows
    assert (kept.absent, kept.expected) == ("rebound", "not run")


def test_rows_written_before_they_named_the_absent_engine_are_read_without(
    without_rebound, tmp_path
):
    assert run(lambda: without_rebound, ["verify", "--out", str(tmp_path)]) == 0
    path = tmp_path / "claims.csv"
    pd.read_csv(path).drop(columns="absent").to_csv(path, index=False)
    (kept,) = kept_claims(tmp_path, without_rebound.claims)[1].rows
    assert kept.absent == ""


def test_an_absent_engine_that_is_required_is_a_failure(without_rebound, tmp_path, capsys, cases):
    words = ["verify", "--require", "mujoco,rebound", "--out", str(tmp_path)]
    assert run(lambda: without_rebound, words) == 1
    assert "rebound is absent, and was required" in capsys.readouterr().out
    assert cases()["engines", "rebound"].find("failure") is not None
    assert (tmp_path / "verify.md").read_text().startswith("## verify: failed")
    assert run(lambda: without_rebound, [*words, "-k", "V1"]) == 1
    assert cases()["engines", "rebound"].find("failure") is not None
    assert run(lambda: without_rebound, ["verify", "--require", "mujoco", *words[-2:]]) == 0


def test_nothing_measured_is_not_green_even_for_want_of_an_engine(without_rebound, tmp_path):
    words = ["verify", "--claims", "V2", "--out", str(tmp_path)]
    assert run(lambda: without_rebound, words) == 1


@pytest.mark.parametrize(
    "error",
    [
        ModuleNotFoundError("No module named 'benchmarks.flts'", name="benchmarks.flts"),
        RuntimeError(f"it broke, though not for want of REBOUND: {ABSENT}"),
    ],
)
def test_an_error_that_only_mentions_an_absent_engine_is_no_excuse(
    make_suite, make_claim, tmp_path, error
):
    engines = {"rebound": ABSENT}
    suite = make_suite(make_claim("V1"), make_claim("V2", raises=error), engines=lambda: engines)
    assert run(lambda: suite, ["verify", "--out", str(tmp_path)]) == 1


def test_a_row_whose_reason_only_mentions_an_absent_engine_is_no_excuse(
    make_suite, make_claim, make_row, tmp_path
):
    row = make_row(id="V2", verdict="not run", measured=None, reason=f"Not by REBOUND. {ABSENT}")
    claims = (make_claim("V1"), make_claim("V2", (row,)))
    suite = make_suite(*claims, engines=lambda: {"rebound": ABSENT})
    assert run(lambda: suite, ["verify", "--out", str(tmp_path)]) == 1


def test_a_claim_whose_judge_gives_no_row_is_not_green(make_suite, make_claim, tmp_path, capsys):
    suite = make_suite(make_claim("V1"), make_claim("V2", ()))
    assert run(lambda: suite, ["verify", "--out", str(tmp_path)]) == 1
    assert "V2 title of V2 was not run: ValueError: its judge gave no row" in (
        " ".join(capsys.readouterr().out.split())
    )


@pytest.mark.parametrize(
    ("word", "said"),
    [
        ("", "'--require': Expected words"),
        ("rebuond", "There is no engine 'rebuond' among rebound, mujoco; did you mean 'rebound'?"),
        (",", "'--require': Expected words"),
    ],
)
def test_a_mistyped_engine_is_refused_in_a_sentence(without_rebound, tmp_path, capsys, word, said):
    words = ["verify", "--require", word, "--out", str(tmp_path)]
    assert run(lambda: without_rebound, words) == 2
    told = capsys.readouterr().err
    assert said in told and len(told.splitlines()) == 1
    assert list(tmp_path.iterdir()) == []


def test_checking_one_claim_keeps_the_rows_of_the_others_and_says_of_when_they_are(
    make_suite, make_claim, make_row, tmp_path
):
    first = make_suite(*(make_claim(name) for name in ("V1", "V2", "V3")))
    third = make_claim("V3", (make_row(measured=1.0 / 3.0),))
    dated = replace(
        make_suite(*first.claims[:2], third),
        provenance=lambda command: {"date": "2026-02-03", "commit": "fedc"},
    )
    assert run(lambda: dated, ["verify", "--out", str(tmp_path)]) == 0
    later = replace(
        make_suite(*first.claims, make_claim("V4")), provenance=lambda command: {"date": "now"}
    )
    words = ["verify", "--claims", "V2,V4", "--quick", "--out", str(tmp_path)]
    assert run(lambda: later, words) == 0
    rows = pd.read_csv(tmp_path / "claims.csv", dtype={"date": str})
    assert list(rows["id"]) == ["V1", "V2", "V3", "V4"]
    assert list(rows["date"]) == ["2026-02-03", "now", "2026-02-03", "now"]
    assert list(rows["setting"]) == ["default", "quick", "default", "quick"]
    assert rows["measured"][2] == 1.0 / 3.0
    assert (tmp_path / "tables" / "claims.md").read_text().count("| V") == 4
    assert {path.stem for path in (tmp_path / "frames").iterdir()} == {"V1", "V2", "V3", "V4"}


def test_rows_of_a_file_without_marks_get_those_of_the_file(make_suite, make_claim, tmp_path):
    suite = make_suite(make_claim("V1"), make_claim("V2"))
    assert run(lambda: suite, ["verify", "--out", str(tmp_path)]) == 0
    path = tmp_path / "claims.csv"
    pd.read_csv(path).drop(columns=["date", "commit", "setting"]).to_csv(path, index=False)
    assert run(lambda: suite, ["verify", "--claims", "V2", "--out", str(tmp_path)]) == 0
    assert set(pd.read_csv(path)["commit"]) == {"0123456789abcdef+dirty"}


@pytest.mark.parametrize("text", ["", "a,b\n1,2\n", "id,b\n1,2\n1,2,3\n"])
def test_rows_that_cannot_be_read_are_told_and_replaced(make_suite, tmp_path, capsys, text):
    (tmp_path / "claims.csv").write_text(text)
    assert run(make_suite, ["verify", "--out", str(tmp_path)]) == 0
    assert "claims.csv is left out, since it cannot be read" in capsys.readouterr().err
    assert list(pd.read_csv(tmp_path / "claims.csv")["id"]) == ["V1"]


def test_a_claim_that_is_gone_leaves_the_table():
    before = pd.DataFrame({"id": ["V1", "W9"], "x": [1, 2]})
    now = pd.DataFrame({"id": ["V2"], "x": [3]})
    assert merged(before, now, "id", ["V2"], ["V1", "V2"]).to_dict("list") == {
        "id": ["V1", "V2"],
        "x": [1, 3],
    }


def test_what_changed_is_printed_and_written(make_suite, make_claim, make_row, tmp_path, capsys):
    def check(*rows, setting=()):
        suite = make_suite(make_claim("V1", rows))
        return run(lambda: suite, ["verify", *setting, "--out", str(tmp_path)])

    same = make_row(quantity="still", measured=2.0, uncertainty=0.1)
    check(make_row(quantity="verdict"), make_row(quantity="number"), same, make_row(quantity="old"))
    assert "Changed" not in capsys.readouterr().out
    check(
        make_row(quantity="verdict", verdict="exceeds"),
        make_row(quantity="number", measured=0.3),
        make_row(quantity="still", measured=2.2, uncertainty=0.1),
        make_row(quantity="fresh"),
    )
    printed, text = capsys.readouterr().out, (tmp_path / "verify.md").read_text()
    for where in (printed, text):
        changed = where[where.index("Changed since the rows before") :].split("<details>")[0]
        for words in ("verdict", "number", "0.25 -+ 0.01", "0.3 -+ 0.01", "fresh", "gone", "old"):
            assert words in changed
        assert "still" not in changed
    check(make_row(quantity="number", measured=99.0), setting=["--quick"])
    assert "Changed" not in capsys.readouterr().out, "the quick form is another measurement"


def test_a_number_moves_beyond_its_uncertainty_or_a_tenth():
    assert not moved(1.0, 0.1, 1.28, 0.1) and moved(1.0, 0.1, 1.29, 0.1)
    assert not moved(1.0, None, 1.1, float("nan")) and moved(1.0, None, 1.12, None)
    assert moved(1.0, 0.1, float("nan"), 0.1) and not moved(None, None, float("nan"), None)


def test_provenance_says_how_the_file_was_last_written(make_suite, tmp_path):
    assert run(make_suite, ["verify", "--quick", "--out", str(tmp_path)]) == 0
    origins = json.loads((tmp_path / "provenance.json").read_text())
    assert origins["claims.csv"]["setting"] == "quick"


def test_k_measures_only_claims_with_checks_that_match(
    make_suite, make_claim, make_row, tmp_path, capsys
):
    rows = (make_row(quantity="pendulum"), make_row(quantity="orbit"))
    suite = make_suite(make_claim("V1", rows), make_claim("V2", (make_row(quantity="orbit"),)))
    assert run(lambda: suite, ["verify", "-k", "V1 and pendulum", "--out", str(tmp_path)]) == 0
    assert set(pd.read_csv(tmp_path / "claims.csv")["id"]) == {"V1"}
    cases = tree.parse(tmp_path / "verify.xml").iter("testcase")
    assert [case.get("name") for case in cases] == ["pendulum", "orbit"]  # all of a chosen claim
    for words in ("top", "(("):
        assert run(lambda: suite, ["verify", "-k", words, "--out", str(tmp_path)]) == 2
        assert words in capsys.readouterr().err.splitlines()[-1]


def test_checks_that_failed_last_time_are_repeated_alone(
    make_suite, make_claim, make_row, tmp_path, capsys
):
    wrong = make_claim("V1", (make_row(verdict="contradicted"),))
    words = ["verify", "--last-failed", "--out", str(tmp_path)]
    for status, first in ((1, wrong), (1, wrong), (0, make_claim("V1"))):
        assert run(lambda first=first: make_suite(first, make_claim("V2")), words) == status
    studied = [line for line in capsys.readouterr().err.splitlines() if line.startswith("[")]
    assert [line.partition(" title")[0] for line in studied][-2:] == ["[1/1] V1", "[1/1] V1"]


def test_claims_are_chosen_by_the_place_of_a_paper(make_suite, make_claim, make_row, tmp_path):
    rows = {"V1": "H fig. 2.3", "V2": "H thm. 2.1.1, 3.1.1", "V3": "H 3.1.1"}
    suite = make_suite(*(make_claim(id, (make_row(source=at),)) for id, at in rows.items()))
    words = ["verify", "--claims", "H thm. 3.1.1,V1", "--out", str(tmp_path)]
    assert run(lambda: suite, words) == 0
    assert list(pd.read_csv(tmp_path / "claims.csv")["id"]) == ["V1", "V2"]


def test_a_place_is_checked_by_the_claims_that_its_statements_name():
    found = claims_by_place(CLAIMS)
    assert {"V13", "L11"} <= found["H lemma 3.3.1"] and "V23" in found["M fig. 3 left"]
    assert all(found[place] >= {*one.claims} for one in statements() for place in places(one.where))


@pytest.mark.parametrize(
    ("place", "said"),
    [
        ("H fig. 99", "There is no claim or place 'H fig. 99'; did you mean 'H fig. "),
        ("h fig. 3.5", "did you mean 'H fig. 3.5'?"),
        ("H (2.8)", "No claim checks what is printed at 'H (2.8)'"),
    ],
)
def test_a_place_that_nothing_checks_is_refused(place, said):
    with pytest.raises(typer.BadParameter) as refused:
        choose_claims(["V1", place], CLAIMS)
    assert said in str(refused.value)


def test_an_interrupted_study_leaves_the_file_of_the_last_run(make_suite, make_claim, tmp_path):
    assert run(make_suite, words := ["verify", "--out", str(tmp_path)]) == 0
    before = (tmp_path / "verify.xml").read_bytes()
    stopped = make_suite(make_claim("V1", raises=KeyboardInterrupt()))
    assert run(lambda: stopped, words) == 130
    assert (tmp_path / "verify.xml").read_bytes() == before


@pytest.mark.parametrize("options", [["-k", "V2"], ["--last-failed"]])
def test_a_claim_whose_rows_only_a_measurement_shows_is_chosen_as_a_whole(
    make_suite, make_claim, make_row, tmp_path, options
):
    rows = [make_row(id="V2", quantity=name, verdict="contradicted") for name in ("one", "two")]
    of_a_user = replace(make_claim("V2"), judge=lambda table: rows if len(table) else table["id"])
    suite = make_suite(make_claim("V1"), of_a_user)
    words = ["verify", "--out", str(tmp_path)]
    assert run(lambda: suite, words) == 1
    assert run(lambda: suite, [*words, *options]) == 1
    told = [case.get("name") for case in tree.parse(tmp_path / "verify.xml").iter("testcase")]
    assert told == ["one", "two"]


def test_what_makes_the_command_fail_is_red_in_the_file(
    make_suite, make_claim, make_row, tmp_path, without_rebound, cases
):
    rows = (make_row(quantity="pendulum"), make_row(quantity="orbit", verdict="contradicted"))
    suite = make_suite(make_claim("V1", rows))
    assert run(lambda: suite, ["verify", "-k", "pendulum", "--out", str(tmp_path)]) == 1
    assert cases()["claim.V1", "orbit"].find("failure") is not None
    assert run(lambda: without_rebound, ["verify", "--claims", "V2", "--out", str(tmp_path)]) == 1
    assert cases()["statements", "measured rows"].find("failure") is not None
    fit = make_row(bound="order 2", misses=5.0)
    many = [replace(fit, quantity=f"order {k}", measured=2.0 + k) for k in range(20)]
    suite = make_suite(make_claim("V1", tuple(many)))
    assert run(lambda: suite, ["verify", "--out", str(tmp_path)]) == 1
    assert cases()["statements", "stated errors of orders"].find("failure") is not None
