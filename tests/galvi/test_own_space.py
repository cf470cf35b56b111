"""A user's own space and rule: the code of CONTRIBUTING.md runs, broken promises are refused."""

import io
import re
from contextlib import redirect_stdout
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import galvi
from tests.galvi.own_spaces import Bernstein

PAGE = Path(__file__).parents[2] / "CONTRIBUTING.md"
EXAMPLE = re.compile(r"^```python\n(.*?)^```\n^```text\n(.*?)^```", re.MULTILINE | re.DOTALL)


@pytest.fixture(scope="module")
def example():
    """The names that the code of the page defines, with what it printed and what the page shows."""
    found = EXAMPLE.findall(PAGE.read_text())
    assert len(found) == 1, "CONTRIBUTING.md must show one example with its output"
    code, shown = found[0]
    names: dict[str, Any] = {"__name__": "contributing"}
    output = io.StringIO()
    with redirect_stdout(output):
        exec(compile(code, "CONTRIBUTING.md", "exec"), names)
    return {**names, "printed": output.getvalue(), "shown": shown, "code": code}


def test_the_example_of_contributing_prints_what_the_page_shows(example):
    assert example["printed"] == example["shown"]
    body = re.search(r"class Chebyshev:\n((?:    .*\n|\n)*)", example["code"]).group(1)
    assert sum(1 for line in body.splitlines() if line.strip()) <= 12


def test_a_users_space_gives_the_curves_and_the_table_of_polynomials(example):
    mine, ours = example["mine"], example["ours"]
    assert np.max(np.abs(mine.method.table.A - ours.method.table.A)) < 1e-15  # 1.4e-17
    t = np.linspace(0.0, 30.0, 77)
    assert np.max(np.abs(mine(t) - ours(t))) < 1e-12  # 3e-14
    assert np.max(np.abs(mine.velocity(t) - ours.velocity(t))) < 1e-12  # 4e-14
    assert mine.method.symmetric
    with pytest.raises(
        ValueError, match="can be saved when its space, chart and clock are galvi's own"
    ):
        galvi.save(mine, "never.npz")


def test_a_users_space_works_on_a_group(example):
    body = galvi.problems.free_rigid_body()
    runs = [
        galvi.integrate(body, galvi.Galerkin(space, galvi.gauss(6)), 0.2, 10)
        for space in (example["Chebyshev"](6), galvi.Polynomials(6))
    ]
    assert np.max(np.abs(runs[0].q - runs[1].q)) < 1e-13  # 4e-16


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
