"""Every public name has one short example, which prints what the reference shows."""

from __future__ import annotations

import doctest

import numpy as np
import pytest

import galvi
from reports.site.reference import examples

LINES = 12  # of an example, at most
NAMES = {*galvi.__all__, *(f"problems.{name}" for name in galvi.problems.__all__)}


def run(text: str, name: str = "example") -> tuple[str, dict[str, object]]:
    """What the text shows otherwise than it should, "" for nothing, and the names that it makes."""
    said: list[str] = []
    case = doctest.DocTestParser().get_doctest(text, {"np": np, "galvi": galvi}, name, None, 0)
    doctest.DocTestRunner(verbose=False).run(case, out=said.append, clear_globs=False)
    return "".join(said), case.globs


def test_every_public_name_has_an_example_and_nothing_else_has_one() -> None:
    assert set(examples()) == NAMES


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
@pytest.mark.parametrize("name", examples())
def test_an_example_is_short_and_prints_what_it_shows(
    name: str, suite_in_this_process: None
) -> None:
    text = examples()[name]
    assert 1 < len(text.splitlines()) <= LINES
    differs, made = run(text, name)
    assert differs == ""
    kind = getattr(galvi, name, None)
    is_made = isinstance(kind, type) and any(isinstance(one, kind) for one in made.values())
    assert f"galvi.{name}" in text or is_made


def test_an_example_that_prints_something_else_would_be_found() -> None:
    assert "Expected" in run(">>> 1 + 1\n3\n")[0]
