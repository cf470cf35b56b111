"""A user's own space and rule: the code of CONTRIBUTING.md runs, broken promises are refused."""

import io
import re
from contextlib import redirect_stdout
from dataclasses import dataclass, replace
from math import comb
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import galvi

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


@dataclass(frozen=True)
class Bernstein:
    """Bernstein polynomials, the first replaced by the constant; each test breaks one promise."""

    degree: Any = 3
    dimension: Any = 4
    exact: Any = False
    broken: str = ""

    def basis(self, t):
        n = self.dimension - 1
        values = [comb(n, i) * t**i * (1 - t) ** (n - i) for i in range(n + 1)]
        if self.broken != "constant":
            values[0] = np.ones_like(t)
        if self.broken == "nan":
            values[2] = np.where(t > 0.5, np.nan, values[2])
        if self.broken == "complex":
            values[2] = values[2] + 0j
        return np.stack(values, axis=0 if self.broken == "turned" else -1)

    def derivative(self, t):
        n = self.dimension - 1
        if self.broken == "flat":
            return np.zeros_like(t)
        lower = [0 * t, *(comb(n - 1, i) * t**i * (1 - t) ** (n - 1 - i) for i in range(n)), 0 * t]
        slopes = [n * (lower[i] - lower[i + 1]) for i in range(n + 1)]
        slopes[0] = 0 * t
        if self.broken == "sign":
            slopes[2] = -slopes[2]
        return np.stack(slopes, axis=-1)


def test_another_users_space_gives_the_same_table():
    mine = galvi.Galerkin(Bernstein(), galvi.gauss(4)).table
    ours = galvi.Galerkin(galvi.Polynomials(3), galvi.gauss(4)).table
    assert np.max(np.abs(mine.A - ours.A)) < 1e-15  # 1.6e-17


@pytest.mark.parametrize(
    ("fields", "sentence"),
    [
        ({"broken": "constant"}, "first basis function of a space must be the constant 1; that of"),
        (
            {"broken": "nan"},
            "basis of Bernstein must be finite .* received nan for function 2",
        ),
        ({"broken": "complex"}, "basis of Bernstein must return real numbers of shape"),
        (
            {"broken": "turned"},
            r"return .*\(1, 4\) for t of shape \(1,\); received .*\(4, 1\)",
        ),
        ({"broken": "flat"}, r"derivative of Bernstein must return .* received shape \(1,\)"),
        ({"broken": "sign"}, "must be that of its basis; function 2 differs from its difference"),
        ({"degree": 4}, "degree of Bernstein must be a whole number from 0 to 3; received 4"),
        ({"degree": 2.5}, "degree of Bernstein must be a whole number"),
        ({"dimension": 1}, "dimension of Bernstein must be a whole number of at least 2"),
        ({"exact": "yes"}, "exact of Bernstein must be True or False; received 'yes'"),
        ({"exact": True}, "exact of Bernstein must be False unless its functions .*decimal"),
    ],
)
def test_a_promise_that_a_space_breaks_is_refused_in_one_sentence(fields, sentence):
    with pytest.raises((ValueError, TypeError), match=sentence):
        galvi.Galerkin(replace(Bernstein(), **fields), galvi.gauss(5))


def test_a_degree_that_the_functions_do_not_reach_is_refused():
    @dataclass(frozen=True)
    class Even(Bernstein):
        def basis(self, t):
            return np.stack([t ** (2 * i) for i in range(4)], axis=-1)

        def derivative(self, t):
            return np.stack([2 * i * t ** max(2 * i - 1, 0) for i in range(4)], axis=-1)

    with pytest.raises(ValueError, match=r"it lacks one of degree 1, by .* Say degree = 0"):
        galvi.Galerkin(Even(), galvi.gauss(5))


def test_a_space_with_another_number_of_functions_than_its_dimension_is_refused():
    class Wrong(Bernstein):
        def basis(self, t):
            return super().basis(t)[:, :-1]

    with pytest.raises(ValueError, match=r"\(1, 4\) for t of .*; received shape \(1, 3\)"):
        galvi.Galerkin(Wrong(), galvi.gauss(5))


def test_a_space_without_an_attribute_or_without_a_hash_is_refused():
    class Nameless:
        dimension, exact = 4, False
        basis, derivative = Bernstein.basis, Bernstein.derivative

    with pytest.raises(TypeError, match=r"a space must have dimension, .* lacks degree"):
        galvi.Galerkin(Nameless(), galvi.gauss(4))

    @dataclass
    class Changeable(Bernstein.__base__):
        degree: int = 3
        dimension: int = 4
        exact: bool = False
        basis, derivative, broken = Bernstein.basis, Bernstein.derivative, ""

    with pytest.raises(TypeError, match=r"a space must be hashable, .* Make it a frozen dataclass"):
        galvi.Galerkin(Changeable(), galvi.gauss(4))


def test_exceptions_of_a_users_functions_pass_unchanged():
    class Failing(Bernstein):
        def basis(self, t):
            raise KeyError("my own mistake")

    with pytest.raises(KeyError, match="my own mistake"):
        galvi.Galerkin(Failing(), galvi.gauss(4))
