"""Paths that lead to a contender, and to none."""

from __future__ import annotations

import sys
from types import ModuleType

import pytest

from benchmarks.applications.external.loading import ContenderError, load_class


class Whole:
    name = "whole"

    def supports(self, problem):
        return True

    def run(self, problem, duration, setting):
        raise NotImplementedError


class Nameless(Whole):
    name = ""


class Ours(Whole):
    name = "galvi, improved"


class Lines(Whole):
    name = "two\nlines"


class Marked(Whole):
    name = "a <b>bold</b> one"


class Lacking:
    name, supports = "lacking", True


class Stubborn(Whole):
    def __init__(self):
        raise OSError("no licence")


@pytest.fixture
def module(monkeypatch):
    """Contenders, and none, in a module of their own."""
    made = ModuleType("outside_module")
    for thing in (Whole, Nameless, Ours, Lines, Marked, Lacking, Stubborn):
        setattr(made, thing.__name__, thing)
    monkeypatch.setitem(sys.modules, made.__name__, made)


@pytest.mark.parametrize(
    ("path", "said"),
    [
        ("Whole", "named package.module:Class; received 'Whole'"),
        ("outside_module:", "named package.module:Class"),
        ("outside modul:Whole", "named package.module:Class"),
        ("outside_module.Whole", "did you mean 'outside_module:Whole'?"),
        ("./outside_module.py:Whole", "did you mean 'outside_module:Whole'?"),
        ("outside_module:Zebra", "has no 'Zebra'$"),
        ("outside_module:Lines", r"words in one line, .* received 'two\\nlines'"),
        ("outsid_module:Whole", "no module 'outsid_module' to take Whole from"),
        ("outside_module:Hole", "has no 'Hole'; did you mean 'Whole'"),
        ("outside_module:Lacking", "lacks 'supports' and 'run'; a contender has name"),
        ("outside_module:Nameless", "do not begin with 'galvi'.* received ''"),
        ("outside_module:Marked", "none of <>.*received 'a <b>bold</b> one'"),
        ("outside_module:Ours", "received 'galvi, improved'"),
        ("outside_module:Stubborn", r"Stubborn\(\) raised OSError: no licence"),
    ],
)
def test_a_path_that_leads_to_no_contender_is_answered_in_a_sentence(module, path, said):
    assert load_class("outside_module:Whole").name == "whole"
    with pytest.raises(ContenderError, match=said):
        load_class(path)
