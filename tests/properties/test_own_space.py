"""A user's space and rule: those of the tutorial run, and joints of rule and space must agree."""

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import galvi
from galvi.properties.properties import orders
from tests.properties.own_spaces import Bernstein

PAGE = Path(__file__).parents[2] / "docs" / "tutorials" / "own_space.md"
CELL = re.compile(r"^```\{code-cell\}\n(.*?)^```$", re.MULTILINE | re.DOTALL)
CUBIC = galvi.Polynomials(3)


@pytest.fixture(scope="module")
def splines():
    """The class Splines of the tutorial; on one piece splines are polynomials."""
    names: dict[str, Any] = {"__name__": "own_space"}
    exec(compile(CELL.findall(PAGE.read_text(encoding="utf-8"))[0], PAGE.name, "exec"), names)
    return names["Splines"]


def test_a_space_of_your_own_takes_no_more_lines_than_the_page_says():
    body = re.search(r"class Splines:\n((?:    .*\n|\n)*)", PAGE.read_text(encoding="utf-8")).group(
        1
    )
    assert sum(1 for line in body.splitlines() if line.strip()) <= 20


@pytest.mark.parametrize("space_name", ["of the page", "Bernstein"])
def test_a_users_space_gives_the_curves_and_the_table_of_polynomials(splines, space_name):
    space = Bernstein() if space_name == "Bernstein" else splines(3, 1)
    methods = [galvi.Galerkin(basis, galvi.gauss(4)) for basis in (space, CUBIC)]
    assert np.max(np.abs(methods[0].table.A - methods[1].table.A)) < 1e-15  # 3e-17
    assert methods[0].symmetric
    t = np.linspace(0.0, 2.0, 77)
    for problem in (galvi.problems.kepler(eccentricity=0.3), galvi.problems.free_rigid_body()):
        by_user_space, by_polynomials = (
            galvi.integrate(problem, method, 0.1, 20) for method in methods
        )
        assert np.max(np.abs(by_user_space(t) - by_polynomials(t))) < 1e-13  # 1e-16
        assert (
            np.max(np.abs(by_user_space.velocity(t) - by_polynomials.velocity(t))) < 1e-13
        )  # 7e-16
        with pytest.raises(ValueError, match="can be saved when its space, chart and clock are ga"):
            galvi.save(by_user_space, "never.npz")


@pytest.mark.parametrize(
    "pieces, rule", [(2, galvi.gauss(4)), (4, galvi.composite(galvi.gauss(4), 2))]
)
def test_a_rule_with_other_joints_than_the_space_has_the_order_2_and_says_so(splines, pieces, rule):
    """The kinetic energy alone would bound the order by -2."""
    problem, method = (
        galvi.problems.kepler(eccentricity=0.3),
        galvi.Galerkin(splines(3, pieces), rule),
    )
    assert orders(method.space, rule).on_curve == method.order == 2
    counts, times = [128, 256, 512], np.linspace(0.0, 2 * np.pi, 101)
    reference_positions = galvi.integrate(
        problem, galvi.Galerkin(galvi.Polynomials(12), galvi.gauss(12)), np.pi / 32, 64
    )(times)
    runs = [galvi.integrate(problem, method, 2 * np.pi / n, n) for n in counts]
    end_errors = [np.linalg.norm(run.q[-1] - problem.q0) for run in runs]
    curve_errors = [np.abs(run(times) - reference_positions).max() for run in runs]
    for errors in (end_errors, curve_errors):
        assert abs(np.polyfit(np.log(counts), np.log(errors), 1)[0] + 2.0) < 0.1


def test_exceptions_of_a_users_functions_pass_unchanged():
    class Failing(Bernstein):
        def basis(self, t):
            raise KeyError("my own mistake")

    with pytest.raises(KeyError, match="my own mistake"):
        galvi.Galerkin(Failing(), galvi.gauss(4))
