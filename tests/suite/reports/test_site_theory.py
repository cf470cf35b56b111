"""The theory pages: each statement of the ledger once, claims and code that exist, and formulas
that agree with galvi and with each other."""

from __future__ import annotations

import ast
import re
from collections import Counter
from pathlib import Path
from runpy import run_path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

import galvi
from benchmarks.claims import CLAIMS
from benchmarks.claims.statements import statements
from references.textbook.galerkin import Rotations
from reports.site import ledger

FOLDER = Path(__file__).parents[3] / "docs" / "theory"
STEPS = run_path(str(FOLDER / "steps_written_out.py"))
cayley, collocation, hat, tangent = (
    STEPS[name] for name in ("cayley", "collocation", "hat", "tangent")
)
vector_step, weak_step, group_step = (
    STEPS[name] for name in ("vector_step", "weak_step", "group_step")
)
frame_step, kepler_frame = STEPS["frame_step"], STEPS["kepler_frame"]
PAGES = {path.name: path.read_text(encoding="utf-8") for path in sorted(FOLDER.glob("*.md"))}
INCLUDE = re.compile(r"^```\{literalinclude\} (\S+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
FENCE = re.compile(r"^```\{ledger\} (.+)$", re.MULTILINE)
ROLE = re.compile(r"\{claim\}`(\w+)`")
ROUND_OFF = 1e-14  # of a step, whose numbers have size 1; 4e-16 was measured


def tables_of(page):
    """The statements of each ledger directive of a page."""
    shown: list[Any] = []
    for argument in FENCE.findall(page):
        lines = ledger.select_statements(argument, shown)
        shown += lines
        yield lines


def test_every_statement_is_on_exactly_one_page():
    shown = Counter(line for page in PAGES.values() for lines in tables_of(page) for line in lines)
    assert [line for line in statements() if shown[line] != 1] == []


def test_a_place_takes_whole_words_and_the_lines_of_its_claims_and_one_without_a_line_is_told() -> (
    None
):
    assert {line.where for line in ledger.select_statements("H thm. 2.3.1")} == {"H thm. 2.3.1"}
    assert {line.where for line in ledger.select_statements("M thm. 1")} == {
        "M thm. 1",
        "M thm. 1, (5)",
    }
    named, none = (ledger.select_statements(f"H 4.2 [{name}]") for name in ("V33", "-"))
    assert all("V33" in line.claims for line in named) and not any(line.claims for line in none)
    for argument in ("H 9.9", "H 4.2 [V1]"):
        with pytest.raises(ValueError, match="no line"):
            ledger.select_statements(argument)
    with pytest.raises(ValueError, match="looks like"):
        ledger.select_statements("H 4.2 [V33")
    page = "```{ledger} H 4.2 [V33]\n```\n```{ledger} H 4.2\n```\n"
    assert list(tables_of(page)) == [named, ledger.select_statements("H 4.2", named)]


def test_a_table_names_the_status_the_claims_and_subscripts():
    html = ledger.table(ledger.select_statements("H thm. 2.3.8"), "../")
    assert 'class="reproduced">reproduced</strong>' in html
    assert '<a href="../results/claims.html#V13">V13</a>' in html and "C<sub>f</sub>" in html
    assert "D C<sub>r</sub>" in html and "π" in html and "Pi" not in html
    assert "false as printed, other result" in ledger.table(ledger.select_statements("H (2.4)"), "")


def test_every_claim_named_on_a_page_exists():
    named = {name for page in PAGES.values() for name in ROLE.findall(page)}
    assert len(named) > 9 and named <= {claim.id for claim in CLAIMS}


@pytest.mark.parametrize("page", PAGES)
def test_every_included_line_of_code_exists(page):
    for target, options in INCLUDE.findall(PAGES[page]):
        text = (FOLDER / target).read_text(encoding="utf-8")
        fields = dict(re.findall(r"^:([\w-]+): ?(.*)$", options, re.MULTILINE))
        if "pyobject" in fields:
            assert fields["pyobject"] in _defined(text), fields
            continue
        start, end = (fields[key].strip('"') for key in ("start-at", "end-at"))
        assert text.count(start) == text.count(end) == 1, fields
        assert text.index(start) < text.index(end), fields


def _defined(text):
    """Names of functions and classes, and of methods as Class.method."""
    definition_types = (ast.FunctionDef, ast.ClassDef)
    top = [
        definition
        for definition in ast.parse(text).body
        if isinstance(definition, definition_types)
    ]
    inner = {
        f"{definition.name}.{part.name}"
        for definition in top
        for part in definition.body
        if isinstance(part, definition_types)
    }
    return {definition.name for definition in top} | inner


def assert_step(run, q, p):
    """Assert that the first step of a run ends at q and p."""
    assert np.max(np.abs(q - run.q[1])) < ROUND_OFF and np.max(np.abs(p - run.p[1])) < ROUND_OFF


def rule_of(points, make=galvi.gauss):
    """Nodes and weights of a rule."""
    rule = make(points)
    return np.asarray(rule.nodes), np.asarray(rule.weights)


def powers(c, degree):
    """t, .., t^degree at nodes, their derivatives, and their values at 1."""
    p = np.arange(1, degree + 1)
    return c[:, None] ** p, p * c[:, None] ** (p - 1), np.ones(degree)


@pytest.mark.parametrize(
    ("degree", "points", "make"),
    [
        (4, 5, galvi.gauss),
        (3, 3, galvi.gauss),
        (3, 4, galvi.lobatto),
        (4, 4, galvi.lobatto),
    ],
)
def test_the_step_on_a_vector_space_is_galvis(degree, points, make):
    problem, rule = galvi.problems.kepler(0.3), rule_of(points, make)
    method = galvi.Galerkin(galvi.Polynomials(degree), make(points))
    run = galvi.integrate(problem, method, 0.2, 1)
    q, v, x = vector_step(
        rule[1], powers(rule[0], degree), _attraction, problem.q0, problem.v0, 0.2
    )
    assert_step(run, q, v)
    position = problem.q0 + powers(np.array([0.37]), degree)[0] @ x
    assert np.max(np.abs(position - run(0.37 * 0.2))) < ROUND_OFF


def _attraction(q):
    return -q / np.sum(q * q, axis=1)[:, None] ** 1.5


def test_the_weak_form_with_a_force_that_depends_on_velocity_is_galvis_step():
    def drag(q, v):
        return -0.4 * np.sqrt(v @ v) * v

    def F(u, rate):
        return 1.5 * u - np.stack([drag(None, v) for v in rate])

    system = galvi.Canonical(2.0, galvi.LinearSpring(1.5), force=drag)
    problem, h = galvi.Problem(system, [1.0, 0.2], [0.1, 0.7]), 0.3
    (c, b), n = rule_of(4), np.arange(4)
    run = galvi.integrate(problem, galvi.Galerkin(galvi.Polynomials(3), galvi.gauss(4)), h, 1)
    space = c[:, None] ** n, n * c[:, None] ** np.maximum(n - 1, 0), 1.0 * (n == 0), np.ones(4)
    x, p_h = weak_step(b, space, 2.0, F, problem.q0, run.p[0], h)
    assert_step(run, np.sum(x, axis=0), p_h)


def test_the_step_of_a_body_is_galvis():
    problem, rule = galvi.problems.pendulum_3d(), rule_of(5)
    method = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(5))
    run, J = galvi.integrate(problem, method, 0.3, 1), np.diag([4.8, 3.0, 3.8])

    def torque(R):
        return 9.81 * np.cross([0.0, 0.0, 1.0], R[2])

    R, mu, x = group_step(rule[1], powers(rule[0], 4), J, torque, problem.q0, J @ problem.v0, 0.3)
    assert_step(run, R, mu)
    position = problem.q0 @ cayley(powers(np.array([0.6]), 4)[0][0] @ x)
    assert np.max(np.abs(position - run(0.6 * 0.3))) < ROUND_OFF


def test_formulas_of_cayleys_chart_hold():
    random = np.random.default_rng(4)
    for _ in range(50):
        x = random.normal(size=3)
        assert np.allclose(tangent(x), Rotations().tangent(x), atol=1e-13)
        assert np.isclose(np.linalg.svd(tangent(x))[1][-1], 2.0 / (1.0 + x @ x))
        assert np.allclose(cayley(x), 2.0 * np.linalg.inv(np.eye(3) + hat(x)) - np.eye(3))


def test_a_step_in_the_kepler_frame_is_galvis():
    m, h, (c, b) = np.array([1.0, 0.02, 0.03]), 0.9, rule_of(4)
    q = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.2, 0.1]])
    v = np.array([[0.0, 0.0, 0.0], [0.0, 1.1, 0.05], [-0.6, 0.0, 0.0]])
    chart = galvi.KeplerFrame(passes=40, even=True)
    method = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4), chart=chart)
    run = galvi.integrate(galvi.Problem(galvi.NBody(m), q, v), method, h, 1)
    flow, remaining_force, into = kepler_frame(m)
    Q, V = frame_step((c, b), flow, remaining_force, np.stack([into @ q, into @ v]), h)
    assert_step(run, np.linalg.solve(into, Q), m[:, None] * np.linalg.solve(into, V))


def test_a_step_in_the_harmonic_frame_is_galvis():
    """Two unit masses with springs and cubic ones, K = V''(0)."""
    K, alpha, h, (c, b) = np.array([[2.0, -1.0], [-1.0, 2.0]]), 0.3, 1.7, rule_of(5)

    def potential(q):
        return 0.5 * q @ K @ q + alpha / 3.0 * np.sum(q**3)

    def gradient(q):
        return K @ q + alpha * q**2

    q, v = np.array([0.4, -0.1]), np.array([0.0, 0.3])
    problem = galvi.Problem(galvi.Canonical(1.0, potential, gradient), q, v)
    chart = galvi.HarmonicFrame(stiffness=K, passes=50)
    method = galvi.Galerkin(galvi.Polynomials(5), galvi.gauss(5), chart=chart)
    run = galvi.integrate(problem, method, h, 1)
    squares, F = np.linalg.eigh(K)
    omega = np.sqrt(squares)

    def flow(w, t):
        cos, sin = np.cos(omega * t), np.sin(omega * t)
        return np.stack([cos * w[0] + sin / omega * w[1], cos * w[1] - omega * sin * w[0]])

    def remaining_force(x):
        return squares * x - F.T @ gradient(F @ x)

    x, rate = frame_step((c, b), flow, remaining_force, np.stack([F.T @ q, F.T @ v]), h)
    assert_step(run, F @ x, F @ rate)


def test_the_numbers_on_the_pages_follow():
    """Bases of Kepler's problem, z0 and the tableau of Gauss."""
    singular_time = np.arccosh(1.0 / 0.6) - np.sqrt(1.0 - 0.36)
    K = 1.0 / (singular_time + np.sqrt(1.0 + singular_time**2))  # h = 2: z = i singular_time
    assert f"{singular_time:.4f}, {K:.4f}, {K * K:.4f}" == "0.2986, 0.7450, 0.5551"
    page = PAGES["vector_spaces.md"]
    assert all(number in page for number in ("0.2986", "0.7450", "0.5551"))
    z0 = brentq(lambda z: z * np.tan(z) - 1.0, 0.5, 1.0)
    assert f"z_0 \\approx {z0:.3f}" in PAGES["particles.md"]
    root = np.sqrt(3.0)
    assert np.allclose(
        collocation(rule_of(2)[0]), [[0.25, 0.25 - root / 6], [0.25 + root / 6, 0.25]]
    )


def test_with_the_printed_sign_a_free_particle_jumps_to_and_fro():
    """n = 2, L = v^2 / 2: dS/dq^1 = -(q^2 - q^1) / h, set to +p as H (2.4) prints it."""
    q, p, h, positions = 0.0, 1.0, 0.5, []
    for _ in range(4):
        end = q - h * p
        q, p = end, (end - q) / h
        positions.append(q)
    assert positions == [-0.5, 0.0, -0.5, 0.0]
