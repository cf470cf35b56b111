"""The claims have the verdicts expected of them, on the quick studies."""

from __future__ import annotations

import builtins
import dis
import sys
from collections.abc import Iterator
from dataclasses import fields
from pathlib import Path
from types import CodeType

import pandas as pd
import pytest

from benchmarks.checks.bounds import HOLDS, NOT_RUN, VERDICTS, AtMost
from benchmarks.checks.claim import Claim, Row, check, scalars
from benchmarks.claims import CLAIMS, kit
from benchmarks.store.frames import COLUMNS
from tests.benchmarks.quick_studies import quick

MADE_UP = Claim("V0", "title", lambda *given: pd.DataFrame(), lambda table: [], ("H fig. 1",),
                setup="any", claimed="O(h)", reference="closed form")  # fmt: skip
BY_ID = pytest.mark.parametrize("claim", CLAIMS, ids=lambda claim: claim.id)


def test_the_claims_are_numbered_without_a_gap() -> None:
    names = [claim.id for claim in CLAIMS]
    for letter, least in (("V", 25), ("L", 16)):
        own = [name for name in names if name[0] == letter]
        assert own == [f"{letter}{k}" for k in range(1, max(least, len(own)) + 1)]
    assert {name[0] for name in names} == {"V", "L"}


def test_every_claim_begins_with_what_its_source_says() -> None:
    without = [one.id for one in CLAIMS if not one.statement.startswith(("H ", "M ", "Ours"))]
    assert without == []


def test_a_row_has_the_texts_of_its_claim_but_for_its_own() -> None:
    row = MADE_UP.row("an error", AtMost(1.0), 0.5, claimed="O(h^2)", reason="none")
    shared = (row.id, row.source, row.setup, row.reference, row.expected)
    assert shared == ("V0", "H fig. 1", "any", "closed form", HOLDS)
    assert (row.claimed, row.reason, row.bound) == ("O(h^2)", "none", "at most 1")
    assert (row.measured, row.uncertainty, row.verdict) == (0.5, None, HOLDS)
    missing = MADE_UP.row("an error", AtMost(1.0), float("nan"))
    assert (missing.measured, missing.uncertainty, missing.verdict) == (None, None, NOT_RUN)
    with pytest.raises(TypeError, match="colour"):
        MADE_UP.row("an error", AtMost(1.0), 0.5, colour="blue")


@pytest.mark.slow_cases(
    but=[
        "V2",
        "V8",
        "V10",
        "V12",
        "V13",
        "V17",
        "V18",
        "V21",
        "V24",
        "V27",
        "V32",
        "V36",
        "L2",
        "L3",
        "L4",
        "L5",
        "L6",
        "L7",
        "L10",
        "L12",
        "L13",
        "L15",
    ]
)
@BY_ID
def test_every_row_has_the_verdict_expected_of_it(claim: Claim) -> None:
    frame = quick(claim)
    assert tuple(frame.columns) == tuple(COLUMNS)
    rows = claim.judge(frame)
    different = [row for row in rows if row.verdict != row.expected]
    assert different == []
    assert rows == claim.judge(frame.sample(frac=1.0, random_state=1)), "judge depends on the order"
    for row in rows:
        assert row.id == claim.id
        assert row.expected in VERDICTS
        assert isinstance(row.measured, float)
        assert row.uncertainty is None or row.uncertainty > 0.0
        empty = {f.name for f in fields(Row) if getattr(row, f.name) == ""}
        assert {"absent"} <= empty <= {"absent", "slopes"}


@BY_ID
def test_nothing_measured_is_never_a_success(claim: Claim) -> None:
    rows = claim.judge(pd.DataFrame())
    assert rows and all(row.verdict == NOT_RUN for row in rows)


@BY_ID
def test_rows_of_a_claim_are_told_apart_by_their_quantity(claim: Claim) -> None:
    quantities = [row.quantity for row in claim.judge(pd.DataFrame())]
    assert len(set(quantities)) == len(quantities)


def globals_of(code: CodeType) -> Iterator[str]:
    """Names that its functions look up in the module."""
    yield from (one.argval for one in dis.get_instructions(code) if one.opname == "LOAD_GLOBAL")
    for inner in code.co_consts:
        if isinstance(inner, CodeType):
            yield from globals_of(inner)


def test_claims_use_no_name_that_neither_they_nor_the_kit_define() -> None:
    """ruff cannot tell, since they import all of the kit."""
    of_claims = [one for name, one in sys.modules.items() if name.startswith(kit.__package__)]
    assert len(of_claims) > len(CLAIMS)
    for module in of_claims:
        code = compile(Path(module.__file__ or "").read_text(), module.__name__, "exec")
        assert {*globals_of(code)} <= {*vars(builtins), *vars(module)}, module


def test_a_check_of_what_is_not_measured_is_an_error() -> None:
    claim = scalars("V0", "title", lambda *given: {"one": 0.5}, [check("two", AtMost(1.0))])
    with pytest.raises(KeyError, match="V0 measures no two"):
        claim.study(kit.galvi.Galerkin, True, print)
    both = [check("one", AtMost(1.0)), check("twice", AtMost(1.0), lambda of: 2.0 * of["one"])]
    claim = scalars("V0", "title", lambda *given: {"one": 0.5}, both)
    found = claim.judge(claim.study(kit.galvi.Galerkin, True, print))
    assert [row.measured for row in found] == [0.5, 1.0]
    assert {row.verdict for row in claim.judge(pd.DataFrame())} == {NOT_RUN}
