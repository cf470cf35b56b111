"""The pages of the reference: every public name once, with members that have docstrings."""

from __future__ import annotations

import inspect
import re
from collections import Counter
from operator import attrgetter
from pathlib import Path

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


def test_every_public_name_is_on_exactly_one_page_of_the_reference() -> None:
    assert Counter(name for _, name, _, _ in ENTRIES) == Counter(NAMES)


def test_the_table_of_the_reference_has_every_public_name_once() -> None:
    index = (PAGES / "index.md").read_text(encoding="utf-8")
    assert Counter(re.findall(r"^   (\w[\w.]*)$", index, re.MULTILINE)) == Counter(NAMES)


def test_each_name_has_the_directive_of_its_kind_and_members_with_docstrings() -> None:
    for directive, name, _, members in ENTRIES:
        public = attrgetter(name)(galvi)
        module, is_class = inspect.ismodule(public), inspect.isclass(public)
        kind = "automodule" if module else "autoclass" if is_class else "autofunction"
        assert directive == kind, name
        for member in filter(None, members.split(", ")):
            assert inspect.getdoc(getattr(public, member)), (name, member)


def test_signatures_that_are_written_out_name_the_parameters() -> None:
    for _, name, arguments, _ in ENTRIES:
        if arguments:
            written = re.findall(r"(?:^|, )(\w+)", arguments)
            assert written == list(inspect.signature(attrgetter(name)(galvi)).parameters), name


def test_nothing_private_stands_beside_the_api() -> None:
    for page in PAGES.glob("*.md"):
        text = page.read_text(encoding="utf-8")
        for inner in ("galvi.kernels", "galvi.input_checks", "galvi.arrays", "galvi.lanes"):
            assert inner not in text, page.name
