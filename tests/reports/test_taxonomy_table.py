"""The taxonomy as a table and as a picture."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from benchmarks.studies.taxonomy import COLUMNS
from reports.studies.taxonomy import CODES, code, space_label, taxonomy_table

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
