"""The reference: every public name once, docstrings as Sphinx reads them."""

from __future__ import annotations

from collections import Counter

import galvi
from reports.site.reference import (
    GROUPS,
    KNOWN,
    MADE,
    MEMBERS,
    pages,
    public,
    restructured,
    tutorials,
)

NAMES = [*galvi.__all__, *(f"problems.{name}" for name in galvi.problems.__all__)]


def test_every_public_name_is_in_the_reference_exactly_once() -> None:
    assert Counter(name for group in GROUPS for name in group.names) == Counter(NAMES)
    text = "\n".join(text for _, text in pages())
    for name in NAMES:
        assert text.count(f":: galvi.{name}\n") == 1, name


def test_members_and_made_values_are_those_of_public_classes() -> None:
    for name in KNOWN:
        assert public(name).__doc__, name
    assert {*MADE, *MEMBERS} <= {*NAMES}
    assert all(isinstance(public(name), type) for name in {*MADE, *MEMBERS})


def test_most_public_names_are_used_by_a_tutorial_or_made_by_what_one_uses() -> None:
    used = tutorials()
    assert len({*used} & {*NAMES}) > 0.6 * len(NAMES)
    assert used["Found"] == used["find_events"] and "first_run" in used["Trajectory"]
    assert all(tutorials().get(maker) for maker in MADE.values())


def test_nothing_private_stands_beside_the_api() -> None:
    for file, text in pages():
        for inner in ("galvi.kernels", "galvi.input_checks", "galvi.arrays", "galvi.lanes"):
            assert inner not in text, file


def test_a_legend_becomes_a_definition_list_and_signs_stay_signs() -> None:
    text = "L(q, v) = |v|^2 * m_ / 2.\n\nmass  of it, in kg,\n      positive\nq0, v0  start\n"
    assert restructured(text, ()) == [
        r"L(q, v) = \|v\|^2 \* m\_ / 2.",
        "",
        "``mass``",
        "    of it, in kg, positive",
        "``q0``, ``v0``",
        "    start",
        "",
    ]


def test_a_formula_a_list_and_links_are_recognised() -> None:
    known = {"integrate", "Polynomials"}
    text = "E = m v^2 / 2 + V(q)\n\n- one\n- two\n\nSee `galvi.integrate` and ``Polynomials(8)``s."
    assert restructured(text, known, "resume") == [
        ".. code-block:: text",
        "",
        "    E = m v^2 / 2 + V(q)",
        "",
        "* one",
        "* two",
        "",
        "See :py:obj:`galvi.integrate <galvi.integrate>` and "
        r":py:obj:`Polynomials(8) <galvi.Polynomials>`\ s.",
        "",
    ]
    assert "``integrate``" in restructured("``integrate``, `integrate`.", known, "integrate")[0]


def test_what_would_begin_a_list_is_text() -> None:
    assert restructured("A. Einstein.", ())[0] == r"\A. Einstein."
    assert restructured("-x is one.", ())[0] == r"\-x is one."
