"""The taxonomy: methods of spaces and rules have the measured properties that theory predicts."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

import galvi
from benchmarks.checks.faults import faulty
from benchmarks.measures.space_rule_pairs import (
    ONE_DEGREE_SPACES,
    SUFFICIENT_POINTS,
    kind_of,
    kinds,
    pairs,
)
from benchmarks.studies.taxonomy import COLUMNS, ILL_POSED, INCONSISTENT, METHOD, taxonomy
from galvi.rules import RULES

ORDER_TOLERANCE = 0.3  # 0.15 was measured, over all methods of the full form


def silent(sentence: str) -> None:
    return None


@pytest.fixture(scope="module")
def table() -> pd.DataFrame:
    return taxonomy(True, silent)


def methods_of(rows: pd.DataFrame) -> pd.DataFrame:
    return rows[rows["verdict"] == METHOD]


def test_every_kind_of_space_meets_every_family_of_rules(table: pd.DataFrame) -> None:
    assert tuple(table.columns) == tuple(COLUMNS)
    cells = set(zip(table["kind"], table["family"], strict=True))
    assert len(cells) == len(ONE_DEGREE_SPACES) * len(RULES)
    assert not table.duplicated(["kind", "number", "family", "points"]).any()
    assert set(methods_of(table)["kind"]) == set(kinds())
    names = methods_of(table).set_index(["kind", "family", "points"])["name"]
    assert names["Polynomials", "Lobatto", 2] == "Stormer-Verlet"
    assert names["Polynomials", "Gauss", SUFFICIENT_POINTS] == ""


def test_measured_orders_are_the_predicted_ones(table: pd.DataFrame) -> None:
    methods = methods_of(table)
    assert len(methods) > 20
    assert np.all(np.abs(methods["measured"] - methods["predicted"]) < ORDER_TOLERANCE)
    assert (methods["status"] == "").all()


def test_every_method_is_symplectic_and_the_symmetric_ones_come_back(table: pd.DataFrame) -> None:
    methods = methods_of(table)
    assert np.all(methods["symplecticity"] < 1e-14)  # 2e-16 was measured
    symmetric = methods["symmetric"].astype(bool)
    assert np.all(methods["symmetry"][symmetric] < 1e-14)  # 9e-16 was measured
    asymmetric = ~symmetric & (methods["points"] < 3) & (methods["kind"] == "Polynomials")
    assert asymmetric.any() and np.all(methods["symmetry"][asymmetric] > 1e-4)


def test_refused_pairs_say_why_and_have_no_numbers(table: pd.DataFrame) -> None:
    for verdict in (ILL_POSED, INCONSISTENT):
        refused = table[table["verdict"] == verdict]
        assert len(refused) > 3
        assert refused["status"].str.contains(f"is {verdict}").all()
        assert refused["measured"].isna().all() and (refused["predicted"] == 0).all()
    assert (table[table["kind"].str.startswith("Fourier")]["verdict"] != METHOD).all()


def test_a_table_that_is_slightly_wrong_is_seen() -> None:
    """Stages a little too large: the method loses its order and is not symplectic."""

    cubic = [next(pairs((3,), (3,)))]
    assert (cubic[0].kind, cubic[0].family) == ("Polynomials", "Gauss")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("benchmarks.studies.taxonomy.pairs", lambda *_: iter(cubic))
        patch.setattr("benchmarks.studies.taxonomy.QUICK_ARGUMENT", 3)
        wrong, correct = (
            methods_of(taxonomy(True, silent, m)).iloc[0] for m in (faulty(A=1.01), galvi.Galerkin)
        )
    assert (
        abs(correct["measured"] - 6.0)
        < ORDER_TOLERANCE
        < abs(wrong["measured"] - wrong["predicted"])
    )
    assert correct["symplecticity"] < 1e-14 < wrong["symplecticity"]


def test_kinds_have_names_of_their_own() -> None:
    names = [kind_of(make) for make in ONE_DEGREE_SPACES]
    assert len(set(names)) == len(names) and not any("lambda" in name for name in names)
