"""Claims as documents: what a section says becomes rows, and what it does not say is refused."""

from __future__ import annotations

import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

import galvi
from benchmarks.checks import bounds, series_bounds
from benchmarks.checks.bounds import CONTRADICTED, HOLDS, NOT_RUN
from benchmarks.checks.claim import Claim
from benchmarks.checks.faults import Fault
from benchmarks.claims.documents import (
    DOCUMENT_NAMES,
    Number,
    all_documents,
    bound_of,
    claims_in,
    read_document,
)

HEAD = """# A paper

What it is.

## 1.1 A heading

| where | kind | statement | status | checks | why |
| --- | --- | --- | --- | --- | --- |
| H 1.1 | sentence | It is so. | reproduced | V1 at H 1.1: error | |

### V1: A claim

What the paper says.
It says it at length.

- measured by: made_up
- source: H 1.1
- setup: a pendulum
- reason: So it
  is.

"""


@pytest.fixture
def claim(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    """A function that makes the claim of a table whose module measures the given numbers."""

    def claim_of(table: str, numbers: dict[str, Any], **attributes: Any) -> Claim:
        module = ModuleType("benchmarks.claims.made_up")
        vars(module)["measure"] = lambda make_method, quick, report: numbers
        vars(module).update(attributes)
        monkeypatch.setitem(sys.modules, module.__name__, module)
        path = tmp_path / f"{len(list(tmp_path.iterdir()))}.md"
        path.write_text(HEAD + table)
        (parsed,) = claims_in(read_document(path))
        return parsed

    return claim_of


def judged(claim: Claim) -> list[Any]:
    return claim.check(claim.study(galvi.Galerkin, True, print))


def test_a_line_is_repeated_for_its_lists_and_has_the_defaults(claim: Any) -> None:
    table = """| quantity | bound | setup | reason | expected |
| --- | --- | --- | --- | --- |
| error, n = {2; 4}, {a; b; c} | at most {1; 2} | + n = {2; 4} | | |
| other \\|error\\| | at least 1 | | Otherwise. | contradicted |
"""
    numbers = {f"error, n = {n}, {name}": 0.5 * n for n in (2, 4) for name in "abc"}
    parsed = claim(table, {**numbers, "other |error|": 0.5})
    rows = judged(parsed)
    assert [row.quantity for row in rows][:4] == [*list(numbers)[:3], "error, n = 4, a"]
    assert rows[0].setup == "a pendulum; n = 2" and rows[0].bound == "at most 1"
    assert rows[0].reason == "So it is." and rows[-1].reason == "Otherwise."
    assert {row.source for row in rows} == {"H 1.1"} and parsed.statement.endswith("at length.")
    assert [row.verdict for row in rows] == [HOLDS] * 6 + [CONTRADICTED]
    assert rows[-1].expected == CONTRADICTED
    assert {row.verdict for row in parsed.check(pd.DataFrame())} == {NOT_RUN}


def test_a_table_may_have_defaults_of_its_own_and_a_mark_repeats_the_cell_above(claim: Any) -> None:
    table = """| quantity | bound | claimed |
| --- | --- | --- |
| one | at most 1 | O(h) |
| two | " | " |

- setup: + at the end
- source: M (3)

The limit is
measured, too.

| quantity | bound |
| --- | --- |
| three | at most {limit} |
"""
    parsed = claim(table, {"one": 0, "two": 1, "three": 2, "limit": 2.5})
    assert parsed.notes == "The limit is measured, too."
    first, second, third = judged(claim(table, {"one": 0, "two": 1, "three": 2, "limit": 2.5}))
    assert second.claimed == "O(h)" and second.bound == "at most 1" and third.bound == "at most 2.5"
    assert (
        third.setup.endswith("; at the end") and third.source == "M (3)" and first.source == "H 1.1"
    )


LINE = "| quantity | bound |\n| --- | --- |\n| one | at most 1 |\n"


@pytest.mark.parametrize(
    ("numbers", "message"),
    [
        ({"two": 2.0}, "without a line: ['two']; without a number: ['one']"),
        ({"one": 1.0, "two": 2.0}, "without a line: ['two']"),
    ],
)
def test_a_number_without_a_line_and_a_line_without_a_number_are_errors(
    claim: Any, numbers: dict[str, float], message: str
) -> None:
    with pytest.raises(ValueError) as refused:
        judged(claim(LINE, numbers))
    assert "V1: every number that is measured needs a line" in str(refused.value)
    assert message in str(refused.value)


@pytest.mark.parametrize(
    ("table", "message"),
    [
        (LINE.replace("| --- | --- |\n", ""), "V1: a table has a head"),
        ("| bound | bound |\n| --- | --- |\n| at most 1 | at most 2 |\n", "of different names"),
        (LINE + "| two | at most 1 | 3 |\n", "a cell for each of"),
        (LINE.replace("at most 1", '"'), "repeats the one above"),
        (LINE.replace("bound", "bnd"), "received ['bnd']"),
        (LINE.replace("at most 1", ""), "a line needs a quantity and a bound"),
        (LINE.replace("at most 1", "at mots 1"), "V1, one: a bound, and each of its terms"),
        ("- expcted: contradicted\n\n" + LINE, "received '- expcted: contradicted'"),
        ("- expected: contradcited\n\n" + LINE, "received 'contradcited'"),
        ("- reason: Twice.\n\n" + LINE, "a default is said once"),
        ("- claimed: so\n it is\n\n" + LINE, "received ' it is'"),
        (LINE + "\n- claimed: so\n", "no table after it has the default ['claimed']"),
        (LINE + "\n- alone: yes\n\n" + LINE.replace("one", "two"), "has the default ['alone']"),
        (LINE + "\n### V2 Without a colon\n", "received '### V2 Without a colon'"),
    ],
)
def test_what_a_document_does_not_know_is_refused(claim: Any, table: str, message: str) -> None:
    with pytest.raises(ValueError) as refused:
        claim(table, {"one": 1.0})
    assert "V1" in str(refused.value) and message in str(refused.value)


@pytest.mark.parametrize("module_name", ["mad_up", "made_up:nothing", "kit", "vctor.v01_x"])
def test_what_measures_is_there(
    claim: Any, monkeypatch: pytest.MonkeyPatch, module_name: str
) -> None:
    monkeypatch.setattr(f"{__name__}.HEAD", HEAD.replace("made_up", module_name))
    with pytest.raises(ValueError, match="V1: 'measured by' names a module"):
        claim(LINE, {"one": 1.0})


def test_a_name_in_braces_is_measured(claim: Any) -> None:
    parsed = claim(LINE.replace("at most 1", "at most {least}"), {"one": 1.0})
    with pytest.raises(ValueError, match=r"without a number: \['least'\]"):
        judged(parsed)


@pytest.mark.parametrize("number", [None, [1.0], 1j])
def test_what_is_no_number_is_refused_by_the_name_of_its_quantity(claim: Any, number: Any) -> None:
    with pytest.raises(TypeError, match="V1, one: measure gives numbers"):
        judged(claim(LINE, {"one": number}))


def test_two_lines_of_one_quantity_are_refused(claim: Any) -> None:
    with pytest.raises(ValueError, match="V1: each quantity needs a line of its own"):
        claim(LINE + "| one | at least {1; 2} |\n", {"one": 1.0})


def test_why_there_is_no_number_is_kept(claim: Any) -> None:
    parsed = claim(LINE, {"one": "The run stopped."})
    table = parsed.study(galvi.Galerkin, True, print)
    assert list(table["status"]) == ["The run stopped."]
    assert {row.verdict for row in parsed.check(table)} == {NOT_RUN}
    absent = Number(reference="a code", absent="engine", why="No module named 'engine'.")
    (row,) = judged(claim(LINE, {"one": absent}))
    assert (row.expected, row.absent, row.reason) == (NOT_RUN, "engine", absent.why)
    assert row.reference == "a code"


def test_planted_faults_are_arrays_of_the_table_or_names_of_the_module(claim: Any) -> None:
    table = """| quantity | bound | caught |
| --- | --- | --- |
| one | at most 1 | b 1e-6 beta 1e-6; a wrong sign |
| two | at most 1 | a wrong sign |
"""
    faults = {"a wrong sign": Fault()}
    numbers = {"one": 1.0, "two": 1.0}
    arrays, sign = claim(table, numbers, FAULTS=faults).caught
    assert arrays.name == "b 1e-6 beta 1e-6" and arrays.contradicted == {"one"}
    assert sign.name == "a wrong sign" and sign.contradicted == {"one", "two"}
    method = arrays.make(galvi.Polynomials(2), galvi.gauss(2))
    correct = galvi.Galerkin(galvi.Polynomials(2), galvi.gauss(2))
    assert method.table.b == pytest.approx(correct.table.b * (1.0 + 1e-6), rel=1e-15)
    with pytest.raises(ValueError, match=r"V1: .* FAULTS, \['another'\]; received 'a wrong sign'"):
        claim(table, numbers, FAULTS={"another": Fault()})


@pytest.mark.parametrize(
    ("text", "bound"),
    [
        ("at most 1e-3; rounding 1e-9", bounds.AtMost(1e-3, round_off=1e-9)),
        ("at least 1/3; errors", bounds.AtLeast(1.0 / 3.0, uncertainty=0.0)),
        ("above 0", bounds.Above(0.0)),
        ("below 1; errors 0.5", bounds.Below(1.0, uncertainty=0.5)),
        ("exactly 3", bounds.Exactly(3.0)),
        ("0.5 to 2", bounds.Within(0.5, 2.0)),
        ("2 within 0.1; in words: about", bounds.Near(2.0, 0.1, noun="about")),
        ("order 4", bounds.Order(4.0)),
        ("order 4 within 0.1; either side", bounds.Order(4.0, 0.1, better=0)),
        ("base 0.56 within 0.01", bounds.Base(0.56, 0.01)),
        ("converges", bounds.Converges()),
        ("geometric", series_bounds.Geometric()),
        ("each n at most 0.5", series_bounds.FactorPerN(0.5)),
        ("no growth at most 1e-3; even if short", series_bounds.NoGrowth(1e-3, conclusive=False)),
        ("finding", bounds.Finding()),
        ("finding: order 3", bounds.Finding(bounds.Order(3.0))),
        (
            "order 2 or at least 4; errors up to 1",
            bounds.Reported(
                bounds.Order(2.0), bounds.AtLeast(4.0, uncertainty=0.0, largest_tolerance=1.0)
            ),
        ),
    ],
)
def test_a_bound_is_what_its_words_say(text: str, bound: bounds.Bound) -> None:
    assert bound_of(text) == bound


@given(st.floats(allow_nan=False, allow_infinity=False), st.sampled_from(["at most", "above"]))
def test_a_limit_is_read_to_the_last_bit(limit: float, word: str) -> None:
    read: Any = bound_of(f"{word} {limit!r}")
    assert read.limit == limit and read.side == word


@pytest.mark.parametrize(
    "text",
    [
        *("about 3", "at most", "at most 1; roughly", "order", "", "1 to", "1", "at most 1/0"),
        *("converges; rounding 1", "at most 1; in words: about", "at most inf"),
    ],
)
def test_what_is_no_bound_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match="one of those of bound_of"):
        bound_of(text)


def test_every_section_of_a_document_has_a_heading_and_every_table_its_columns() -> None:
    assert len(all_documents()) == len(DOCUMENT_NAMES)
    ids = [s.id for document in all_documents() for part in document.parts for s in part.sections]
    assert len(set(ids)) == len(ids) >= 64
