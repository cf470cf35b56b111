"""A user's own space and rule: those of the tutorial run, broken promises are refused."""

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
    """The class of the page; splines on one piece are polynomials."""
    names: dict[str, Any] = {"__name__": "own_space"}
    exec(compile(CELL.findall(PAGE.read_text(encoding="utf-8"))[0], PAGE.name, "exec"), names)
    return names["Splines"]


def test_a_space_of_your_own_takes_no_more_lines_than_the_page_says():
    body = re.search(r"class Splines:\n((?:    .*\n|\n)*)", PAGE.read_text(encoding="utf-8")).group(
        1
    )
    assert sum(1 for line in body.splitlines() if line.strip()) <= 20


def test_a_users_space_gives_the_curves_and_the_table_of_polynomials(splines):
    problem = galvi.problems.kepler(eccentricity=0.3)
    mine, ours = (
        galvi.integrate(problem, galvi.Galerkin(space, galvi.gauss(4)), step=0.1, steps=100)
        for space in (splines(3, 1), CUBIC)
    )
    assert np.max(np.abs(mine.method.table.A - ours.method.table.A)) < 1e-15  # 3e-17
    t = np.linspace(0.0, 10.0, 77)
    assert np.max(np.abs(mine(t) - ours(t))) < 1e-13  # 1e-16
    assert np.max(np.abs(mine.velocity(t) - ours.velocity(t))) < 1e-13  # 7e-16
    assert mine.method.symmetric
    with pytest.raises(
        ValueError, match="can be saved when its space, chart and clock are galvi's own"
    ):
        galvi.save(mine, "never.npz")


def test_a_users_space_works_on_a_group(splines):
    body = galvi.problems.free_rigid_body()
    runs = [
        galvi.integrate(body, galvi.Galerkin(space, galvi.gauss(4)), 0.2, 10)
        for space in (splines(3, 1), CUBIC)
    ]
    assert np.max(np.abs(runs[0].q - runs[1].q)) < 1e-13  # 4e-16


@pytest.mark.parametrize(
    "pieces, rule", [(2, galvi.gauss(4)), (4, galvi.composite(galvi.gauss(4), 2))]
)
def test_a_rule_with_other_joints_than_the_space_has_the_order_2_and_says_so(splines, pieces, rule):
    """The bound of the kinetic energy alone would be -2."""
    problem, method = (
        galvi.problems.kepler(eccentricity=0.3),
        galvi.Galerkin(splines(3, pieces), rule),
    )
    assert orders(method.space, rule).on_curve == method.order == 2
    counts, times = [128, 256, 512], np.linspace(0.0, 2 * np.pi, 101)
    curve = galvi.integrate(
        problem, galvi.Galerkin(galvi.Polynomials(12), galvi.gauss(12)), np.pi / 32, 64
    )(times)
    runs = [galvi.integrate(problem, method, 2 * np.pi / n, n) for n in counts]
    at_steps = [np.linalg.norm(run.q[-1] - problem.q0) for run in runs]
    between = [np.abs(run(times) - curve).max() for run in runs]
    for errors in (at_steps, between):
        assert abs(np.polyfit(np.log(counts), np.log(errors), 1)[0] + 2.0) < 0.1


def test_another_users_space_gives_the_same_table():
    mine = galvi.Galerkin(Bernstein(), galvi.gauss(4)).table
    ours = galvi.Galerkin(galvi.Polynomials(3), galvi.gauss(4)).table
    assert np.max(np.abs(mine.A - ours.A)) < 1e-15  # 1.6e-17


def test_exceptions_of_a_users_functions_pass_unchanged():
    class Failing(Bernstein):
        def basis(self, t):
            raise KeyError("my own mistake")

    with pytest.raises(KeyError, match="my own mistake"):
        galvi.Galerkin(Failing(), galvi.gauss(4))
