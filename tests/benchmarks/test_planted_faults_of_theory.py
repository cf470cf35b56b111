"""The claims on theory catch a table, a check or a constant that is slightly wrong."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

import galvi
from benchmarks.checks.bounds import HOLDS, NOT_RUN
from benchmarks.claims import CLAIMS
from tests.benchmarks.planted_tables import contradicted, faulty
from tests.benchmarks.quick_studies import quick

CLAIM = {claim.id: claim for claim in CLAIMS}
TABLE_DEFECT = "largest |alpha - c|, |beta_p - 1| in the tables of accepted pairs"
OFF = "step where the least eigenvalue is 0, over the bound, oscillator"

SAME_STEP = "that step over the one of exact integrals, less 1, oscillator"
SAME_PASS = "contraction of galvi's pass less that of M's linear problem, over h^2 K / m, largest"
FORM = "second variation over H (2.22), least below the coercive bound, oscillator"
OURS = "departure of the largest ratio from sqrt(2 + 1 / (N - 1)), Lobatto N nodes"


@pytest.mark.parametrize(
    ("claim", "scale", "quantity"),
    [
        ("V12", {"C": 1.0 + 1e-7}, "galvi's pass against H's, largest relative difference, all n"),
        ("V13", {"psi": 1.0 + 1e-6}, OFF),
        ("V13", {"psi": 2.5}, "least eigenvalue over all steps below the bound, oscillator"),
        ("V13", {"psi": 1.0 + 1e-6}, FORM),
        ("V13", {"slope": 1.0 + 1e-9}, SAME_STEP),
        ("V19", {"velocity_coefficients": 1.0 + 1e-12}, TABLE_DEFECT),
        ("V20", {"C": 20.0}, "largest contraction of a pass over eta C_N^2, Gauss N"),
        ("V20", {"C": 1.0 + 1e-7}, SAME_PASS),
        ("V20", {"b": 1.0 + 1e-9}, SAME_PASS),
        ("V20", {"slope": 1.0 + 1e-9}, SAME_PASS),
        ("V21", {"b": 1.0 + 1e-9}, "largest departure of the ratio from 1, Gauss N nodes"),
        ("V21", {"b": 1.0 + 1e-9}, OURS),
    ],
)  # fmt: skip
def test_a_table_that_is_slightly_wrong_is_caught(
    claim: str, scale: dict[str, float], quantity: str
) -> None:
    assert quantity in contradicted(CLAIM[claim], faulty(**scale))


def unchecked(space: Any, rule: Any) -> Any:
    """Takes an inconsistent pair for a method."""
    try:
        return galvi.Galerkin(space, rule)
    except ValueError as refusal:
        if "is ill-posed" in str(refusal):
            raise
        return galvi.Galerkin(galvi.Polynomials(1), galvi.gauss(2))


def too_strict(space: Any, rule: Any) -> Any:
    """Refuses what has fewer points than functions: sufficient, as in H, and not necessary."""
    if rule.points < space.dimension:
        raise ValueError(f"{space} with {rule.name} is ill-posed.")
    return galvi.Galerkin(space, rule)


@pytest.mark.parametrize(
    ("make", "quantity"),
    [
        (unchecked, "pairs accepted with a bent free motion, or refused with a straight one"),
        (too_strict, "pairs refused as ill-posed without being so, or not refused"),
    ],
)
def test_a_check_of_pairs_that_is_wrong_is_caught(make: Any, quantity: str) -> None:
    assert quantity in contradicted(CLAIM["V19"], make)


def test_a_wrong_constant_of_theory_is_caught(monkeypatch: pytest.MonkeyPatch) -> None:
    sound = galvi.Galerkin.theory

    def wrong(self: Any, *arguments: Any, **named: Any) -> Any:
        said = sound(self, *arguments, **named)
        stage = said.stage_step and said.stage_step * (1.0 + 1e-6)
        return replace(said, friedrichs=said.friedrichs * (1.0 + 1e-8), stage_step=stage)

    monkeypatch.setattr(galvi.Galerkin, "theory", wrong)
    assert "galvi.theory's C_N over numpy's, largest departure from 1" in contradicted(CLAIM["V20"])
    departure = "galvi.theory's bound over H's formula, largest departure from 1, all n"
    assert departure in contradicted(CLAIM["V12"])


def test_a_theory_that_takes_every_pair_for_consistent_is_caught(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    sound = galvi.theory
    monkeypatch.setattr(galvi, "theory", lambda *pair: replace(sound(*pair), consistent=True))
    assert "pairs that galvi.theory judges otherwise" in contradicted(CLAIM["V19"])


@pytest.mark.parametrize("name", ["oscillator", "quartic potential"])
def test_steps_that_fail_below_a_bound_are_not_left_out(name: str) -> None:
    """The least of eigenvalues of which one is missing is not known."""
    claim = CLAIM["V13"]
    frame = quick(claim)
    frame.loc[(frame["study"] == name) & (frame["step"] < 1.0), "value"] = float("nan")
    lost = {row.quantity for row in claim.judge(frame) if row.verdict == NOT_RUN}
    for quantity in ("least eigenvalue over all steps below the bound",
                     "second variation over H (2.22), least below the coercive bound"):  # fmt: skip
        assert f"{quantity}, {name}" in lost


def test_the_printed_constant_would_hold_if_it_were_so() -> None:
    """With M's own N in the place of N - 1 the judge says holds: the verdict is not built in."""
    claim = CLAIM["V21"]
    frame = quick(claim)
    named = frame["quantity"].str.startswith("largest ratio")
    N = frame.loc[named, "quantity"].str.rsplit(" ", n=1).str[-1].astype(float)
    frame.loc[named, "value"] = (2.0 + 1.0 / N) ** 0.5
    printed = [row for row in claim.judge(frame) if row.quantity.startswith("largest ratio")]
    assert [row.verdict for row in printed] == [HOLDS] * 3
