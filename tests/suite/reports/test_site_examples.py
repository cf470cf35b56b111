"""Every public name has a short example in its docstring, which prints what it shows."""

from __future__ import annotations

import doctest
import inspect
from operator import attrgetter

import numpy as np
import pytest

import galvi

LINES = 12  # of an example, at most
NAMES = (*galvi.__all__, *(f"problems.{name}" for name in galvi.problems.__all__))
PARSER = doctest.DocTestParser()


def example_of(name: str) -> str:
    """The lines of an interpreter and what they print, at the end of a docstring."""
    text = inspect.getdoc(attrgetter(name)(galvi)) or ""
    return text[text.find("\n>>> ") + 1 :] if "\n>>> " in text else ""


def run(text: str, name: str = "example") -> tuple[str, dict[str, object]]:
    """What the text prints otherwise than it shows, "" for nothing, and the names that it makes."""
    output: list[str] = []
    case = PARSER.get_doctest(text, {"np": np, "galvi": galvi}, name, None, 0)
    doctest.DocTestRunner(verbose=False).run(case, out=output.append, clear_globs=False)
    return "".join(output), case.globs


@pytest.mark.slow_cases(
    "find_events",
    "Found",
    "Exponential",
    "ModifiedRodrigues",
    "HarmonicFrame",
    "Clock",
    "convergence",
    "Oblateness",
    "Drag",
    "integrate_ensemble",
    "judge",
    "Judged",
    "recommend",
)
@pytest.mark.parametrize("name", NAMES)
def test_every_public_name_has_a_short_example_that_prints_what_it_shows(
    name: str, suite_in_this_process: None
) -> None:
    text = example_of(name)
    assert 1 < len(text.splitlines()) <= LINES
    differs, made = run(text, name)
    assert differs == ""
    kind = getattr(galvi, name, None)
    is_made = isinstance(kind, type) and any(isinstance(value, kind) for value in made.values())
    assert f"galvi.{name}" in text or is_made


def test_an_example_that_prints_something_else_would_be_found() -> None:
    assert "Expected" in run(">>> 1 + 1\n3\n")[0]
