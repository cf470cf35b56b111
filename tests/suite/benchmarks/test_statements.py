"""Printed statements, and the misprints among them."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from benchmarks.checks.bounds import EXCEEDS, HOLDS, NOT_REPRODUCED
from benchmarks.checks.claim import Row
from benchmarks.checks.coverage import coverage
from benchmarks.claims import CLAIMS
from benchmarks.claims.documents import Part
from benchmarks.claims.statements import (
    EFFECTS,
    FALSE,
    STATUSES,
    Statement,
    places,
    statements,
    statements_of,
    status_counts,
    unfounded,
)
from references.textbook.galerkin import Rotations, hat
from tests.suite.benchmarks.quick_studies import quick

MEASURED = {"V2", "V8", "V17", "V18", "V27", "L3", "L4", "L5", "L10", "L13"}
SECTIONS = {
    "M fig. 1": "M 6.1, fig. 1",
    "M fig. 2": "M 6.2, fig. 2",
    "M fig. 3": "M 6.2, fig. 3",
}


@pytest.fixture(scope="module")
def rows() -> list[Row]:
    """Rows of the claims whose quick studies other tests need anyway; `make report` has all rows,
    and fails where they do not support the statements."""
    return [row for claim in CLAIMS if claim.id in MEASURED for row in claim.check(quick(claim))]


def measured_statements() -> list[Statement]:
    """The statements that rest on claims in MEASURED only."""
    return [
        statement
        for statement in statements()
        if statement.claims and set(statement.claims) <= MEASURED
    ]


def test_every_status_is_what_the_rows_say_and_every_accusation_has_its_statement(
    rows: list[Row],
) -> None:
    complaints = [
        complaint
        for complaint in unfounded(measured_statements(), rows)
        if "no statement of it" not in complaint
    ]
    assert len(measured_statements()) > 20 and complaints == []


def test_lines_are_complete() -> None:
    ids = {claim.id for claim in CLAIMS}
    printed = set()
    for statement in statements():
        assert statement.status in STATUSES and statement.where[:2] in ("H ", "M ")
        assert (statement.effect in EFFECTS) == (statement.status == FALSE)
        assert set(statement.claims) <= ids and 0 < len(statement.statement) <= 200
        assert statement.status in ("reproduced", "future work done") or statement.why
        assert (statement.where, statement.statement) not in printed
        printed.add((statement.where, statement.statement))
    assert {statement.where[0] for statement in statements()} == {"H", "M"}


def test_every_figure_of_a_claim_is_a_statement() -> None:
    sources = {statement.where for statement in statements()}
    for claim in CLAIMS:
        for figure in claim.figures:
            if figure[2:5] == "fig":
                name = SECTIONS.get(figure[:8], figure)
                assert any(source.startswith(name) for source in sources), figure


def test_a_status_that_no_row_supports_and_a_verdict_that_praises_are_told(
    rows: list[Row],
) -> None:
    """Planted: a figure that is not reproduced is called so; and its rows exceed it."""
    measured = measured_statements()
    wrong = [
        replace(statement, status="reproduced", why="")
        if statement.status == NOT_REPRODUCED and "L3" in statement.claims
        else statement
        for statement in measured
    ]
    assert any(
        "L3 has a row that is not reproduced" in complaint for complaint in unfounded(wrong, rows)
    )
    praised = [
        replace(row, verdict=EXCEEDS) if row.verdict == NOT_REPRODUCED else row for row in rows
    ]
    complaints = unfounded(measured, praised)
    assert any(complaint.startswith("H fig. 3.2 ") for complaint in complaints)
    assert any("H fig. 3.2 exceeds what was measured" in complaint for complaint in complaints)


def test_a_row_founds_only_the_statements_of_its_place() -> None:
    """Planted: one row that holds, and statements of other places that name its claim."""
    row = Row("V1", "one-step error", "H fig. 2.3, thm. 2.3.4", verdict=HOLDS)
    wheres = ("H fig. 2.3", "H thm. 2.3.4", "H fig. 2.4", "H fig. 2.30", "H 2.3", "M fig. 2.3")
    first, second, *unrelated = (
        Statement(where, "figure", "It is so.", "reproduced", "", ("V1",), "", "")
        for where in wheres
    )
    complaints = unfounded([first, second, *unrelated], [row])
    assert len(complaints) == len(unrelated)
    assert not any(
        complaint.startswith(("H fig. 2.3 ", "H thm. 2.3.4 ")) for complaint in complaints
    )
    supported = replace(unrelated[0], rows="H fig. 2.3: one-step")
    elsewhere = replace(supported, rows="H fig. 2.3: curve")
    other_claim = replace(supported, claims=("V2",))
    assert unfounded([supported], [row]) == []
    assert all(unfounded([unsupported], [row]) for unsupported in (elsewhere, other_claim))


@pytest.mark.parametrize(
    ("source", "expected"),
    [
        ("H thm. 2.1.1, 3.1.1, M thm. 4", ["H thm. 2.1.1", "H thm. 3.1.1", "M thm. 4"]),
        ("H fig. 2.11, sec. 2.4", ["H fig. 2.11"]),
        ("M (12), section 5", ["M (12)"]),
        ("M sec. 5, thm. 3", ["M thm. 3"]),
        ("H (3.9), H 3.4.3", ["H (3.9)"]),
        ("H 3.2.2, 3.4.3", ["H 3.2.2", "H 3.4.3"]),
        ("M sec. 5", ["M sec. 5"]),
    ],
)
def test_the_places_of_a_source_are_read(source: str, expected: list[str]) -> None:
    assert places(source) == expected


def test_a_row_that_is_named_and_not_there_is_told(rows: list[Row]) -> None:
    statement = next(x for x in measured_statements() if x.rows)
    (complaint,) = unfounded([replace(statement, rows=f"{statement.rows}; H fig. 9.9")], rows)[:1]
    assert complaint.endswith("names rows that are not there: H fig. 9.9.")


def test_statements_are_counted_in_words() -> None:
    reproduced = Statement("H fig. 1", "figure", "It is so.", "reproduced", "", (), "", "")
    slip = replace(reproduced, status=FALSE, effect="harmless")
    sentence = status_counts([reproduced, reproduced, slip])
    assert sentence.startswith("Of 3 printed statements of the two papers, 2 are reproduced, ")
    assert "1 is false as printed (1 of them harmless misprints)" in sentence


def test_the_stated_errors_of_the_suites_orders_cover(rows: list[Row]) -> None:
    of_rows = coverage(rows)
    assert of_rows.orders > 10 and of_rows.is_plausible, str(of_rows)
    small = [replace(row, misses=5.0 * row.misses) if row.misses else row for row in rows]
    assert not coverage(small).is_plausible  # planted: errors a fifth of what they are


H_STEP = 0.3
J_D = np.diag([1.3, 2.1, 1.2])
J = np.trace(J_D) * np.eye(3) - J_D
W = np.array([2.0, -1.9, 1.0])
CHECKS: dict[tuple[str, str], Callable[[], tuple[float, float]]] = {}


def misprint(where: str, begins: str) -> Callable[..., Callable[[], tuple[float, float]]]:
    """A decorator for a function that returns (misfit of the print, misfit of its correction)."""

    def register(check: Callable[[], tuple[float, float]]) -> Callable[[], tuple[float, float]]:
        CHECKS[where, begins] = check
        return check

    return register


@misprint("H (2.4)", "Momentum condition")
def _() -> tuple[float, float]:
    """A free particle, n = 2: phi_1' = -1 / h, so that the left side is -v."""
    q0, p = 0.2, 0.7
    ends = [q0 - H_STEP * sign * p for sign in (1.0, -1.0)]  # -(q1 - q0) / h = sign p
    true = q0 + H_STEP * p
    return abs(ends[0] - true), abs(ends[1] - true)


@misprint("H 1.2.1", "Hamilton's vector field")
def _() -> tuple[float, float]:
    """The oscillator, (q, p)' = (p, -q)."""
    omega, z = np.array([[0.0, 1.0], [-1.0, 0.0]]), np.array([0.4, 0.9])
    true = np.array([z[1], -z[0]])
    return (
        float(np.max(np.abs(np.linalg.inv(omega) @ z - true))),
        float(np.max(np.abs(omega @ z - true))),
    )


@misprint("H thm. 1.2.2", "Discrete Noether")
def _() -> tuple[float, float]:
    """<p, q> and <p, a>, a a translation, of a free particle after one second."""
    q, p, a = np.array([1.0, 2.0]), np.array([0.5, -0.3]), np.array([1.0, 0.0])
    return abs(p @ (q + p) - p @ q), abs(p @ a - p @ a)


@misprint("H 1.2.3", "Frechet derivative")
def _() -> tuple[float, float]:
    """F(x) = x^2 at 1: the limits from either side differ; the remainder's does not."""
    slopes, remainders = [], []
    for dx in (1e-6, -1e-6):
        change = (1.0 + dx) ** 2 - 1.0
        slopes.append(change / abs(dx))
        remainders.append((change - 2.0 * dx) / abs(dx))
    return abs(slopes[0] - slopes[1]), abs(remainders[0] - remainders[1])


@misprint("H 2.2.2", "Nodes h_i")
def _() -> tuple[float, float]:
    """The last node over h, for i = 1 .. n and for i = 0 .. n."""
    n = 6
    from_one, from_zero = (
        0.5 * np.cos(np.pi * np.arange(start, n + 1) / n) + 0.5 for start in (1, 0)
    )
    return abs(float(from_one.max()) - 1.0), abs(float(from_zero.max()) - 1.0)


@misprint("H 2.4.2", "Kepler with m_1")
def _() -> tuple[float, float]:
    """e = |r v^2 / (G (m_1 + m_2)) - 1| at an apsis, for two unit masses and for one of them."""
    errors = [abs(0.4 * 2.0**2 / mass - 1.0) for mass in (2.0, 1.0)]
    return abs(errors[0] - 0.6), abs(errors[1] - 0.6)


@misprint("H 2.6.1", "A remainder e")
def _() -> tuple[float, float]:
    """K^n sin(q / K^n) over K^n, and its derivative at 0 over K^n less that bound of 1."""
    small = 0.5**20
    return abs(math.cos(0.0) / small - 1.0), max(0.0, abs(math.sin(1.0 / small)) - 1.0)


@misprint("H 3.3.2", "Kinetic energy printed without a trace")
def _() -> tuple[float, float]:
    """w . J w, of R'^T R J_d R^T R' with R' = R hat(w): a matrix, and its trace."""
    matrix = hat(W).T @ J_D @ hat(W)
    energy = W @ J @ W
    return float(np.max(np.abs(matrix - energy))), abs(float(np.trace(matrix)) - energy)


@misprint("H lemma 3.3.1", "Kinetic part at least")
def _() -> tuple[float, float]:
    """A turn by 2 atan(2), 127 degrees: sigma_min is 2 / 5."""
    stretch = np.linalg.svd(Rotations().tangent(np.array([0.0, 2.0, 0.0])), compute_uv=False)
    eigenvalue, sigma = float(stretch[-1] ** 2), 0.4
    return max(0.0, sigma - eigenvalue), abs(sigma**2 - eigenvalue)


@misprint("H (3.19), (3.20)", "Mixed term")
def _() -> tuple[float, float]:
    """The least of C_p a^2 / 2 - 2 C_m a b at b = 1, against what is subtracted."""
    c_p, c_m = 0.7, 0.9
    a = np.linspace(0.0, 10.0, 200_001)
    minimum = float(np.min(c_p * a**2 / 2.0 - 2.0 * c_m * a))
    printed, follows = (-(c_m**2) * factor / c_p for factor in (0.5, 2.0))
    return max(0.0, printed - minimum), max(0.0, follows - minimum)


@misprint("H fig. 3.4", "The curves are on")
def _() -> tuple[float, float]:
    """sum y^2 / I on the unit sphere: its largest against 2, and its range."""
    y = np.random.default_rng(0).normal(size=(1000, 3))
    y /= np.linalg.norm(y, axis=1)[:, None]
    level = (y**2) @ (1.0 / np.diag(J))
    outside = max(0.0, 1.0 / 3.4 - level.min(), level.max() - 1.0 / 2.5)
    return 2.0 - float(level.max()), outside


@misprint("M sec. 5", "Integrals of f p")
def _() -> tuple[float, float]:
    """Lobatto 3, f = t^2, p of degree 2 without mean: 0 on the right side for s = 3."""
    nodes, weights = np.array([-1.0, 0.0, 1.0]), np.array([1.0, 4.0, 1.0]) / 3.0
    gauss_nodes, gauss_weights = np.polynomial.legendre.leggauss(3)
    legendre = np.polynomial.legendre.Legendre([0.0, 0.0, 1.0])
    exact = 4.0 / 15.0
    errors = [
        abs(float(w @ (x**2 * legendre(x))) - exact)
        for x, w in ((nodes, weights), (gauss_nodes, gauss_weights))
    ]
    return errors[0], errors[1]


@pytest.mark.parametrize("where", CHECKS, ids=lambda where: " ".join(where))
def test_what_is_printed_misses_and_what_follows_does_not(where: tuple[str, str]) -> None:
    (line,) = [
        statement
        for statement in statements()
        if statement.where == where[0] and statement.statement.startswith(where[1])
    ]
    assert line.status == FALSE
    printed, follows = CHECKS[where]()
    assert printed > 1e-2 and follows < 1e-9


@pytest.mark.parametrize("status", ["reproducd", "false as printed", "reproduced, harmless"])
def test_a_status_that_is_none_is_refused_where_it_stands(status: str) -> None:
    cells = {
        "where": "H 1.1",
        "kind": "",
        "statement": "",
        "status": status,
        "checks": "",
        "why": "",
    }
    with pytest.raises(ValueError, match=f"H 1.1: .* received '{status}'"):
        list(statements_of(Part("1.1", "", (cells,), ())))
