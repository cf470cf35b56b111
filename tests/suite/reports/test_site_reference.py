"""The reference: every public name once, with members that have docstrings and a short example."""

from __future__ import annotations

import doctest
import inspect
import re
from collections import Counter
from operator import attrgetter
from pathlib import Path

import numpy as np
import pytest

import galvi

PAGES = Path(__file__).parents[3] / "docs" / "reference"
NAMES = [*galvi.__all__, *(f"problems.{name}" for name in galvi.problems.__all__)]
DIRECTIVE = re.compile(
    r"^\.\. (auto\w+):: galvi\.([\w.]+)(?:\((.*)\))?\n(?:   :members: ([\w, ]+)\n)?", re.MULTILINE
)
ENTRIES = [
    entry
    for page in sorted(PAGES.glob("*.md"))
    for entry in DIRECTIVE.findall(page.read_text(encoding="utf-8"))
]


def test_every_public_name_is_on_exactly_one_page_of_the_reference():
    assert Counter(name for _, name, _, _ in ENTRIES) == Counter(NAMES)


def test_the_table_of_the_reference_has_every_public_name_once():
    index = (PAGES / "index.md").read_text(encoding="utf-8")
    assert Counter(re.findall(r"^   (\w[\w.]*)$", index, re.MULTILINE)) == Counter(NAMES)


def test_each_name_has_the_directive_of_its_kind_and_members_with_docstrings():
    for directive, name, _, members in ENTRIES:
        public = attrgetter(name)(galvi)
        module, is_class = inspect.ismodule(public), inspect.isclass(public)
        kind = "automodule" if module else "autoclass" if is_class else "autofunction"
        assert directive == kind, name
        for member in filter(None, members.split(", ")):
            assert inspect.getdoc(getattr(public, member)), (name, member)


def test_signatures_that_are_written_out_name_the_parameters():
    for _, name, arguments, _ in ENTRIES:
        if arguments:
            written = re.findall(r"(?:^|, )(\w+)", arguments)
            assert written == list(inspect.signature(attrgetter(name)(galvi)).parameters), name


LONGEST_EXAMPLE = 12  # lines
PARSER = doctest.DocTestParser()


def example_of(name):
    """The example at the end of a docstring: lines of an interpreter and their output."""
    text = inspect.getdoc(attrgetter(name)(galvi)) or ""
    return text[text.find("\n>>> ") + 1 :] if "\n>>> " in text else ""


def run(text, name="example"):
    """(a report of output that differs from the text, else ""; the names that it defines)."""
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
    name, suite_in_this_process
):
    text = example_of(name)
    assert 1 < len(text.splitlines()) <= LONGEST_EXAMPLE
    differs, namespace = run(text, name)
    assert differs == ""
    kind = getattr(galvi, name, None)
    is_made = isinstance(kind, type) and any(
        isinstance(value, kind) for value in namespace.values()
    )
    assert f"galvi.{name}" in text or is_made


def test_an_example_that_prints_something_else_would_be_found():
    assert "Expected" in run(">>> 1 + 1\n3\n")[0]
