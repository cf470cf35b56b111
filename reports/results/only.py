"""Narrow a suite to some problems."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

from references.setting import nearest
from reports.results.suite import Suite


def narrowed(suite: Suite, text: str, quick: bool) -> Suite:
    """The suite with the comparisons, costs and targets of some problems, and no studies.

    text  parts of their names, in any case, separated by commas

    Raises ValueError without a part, or where one is in no name.
    """
    known = suite.problems(quick)
    asked = [word.strip() for word in text.split(",") if word.strip()]
    if not asked:
        raise ValueError(f"give a part of a problem's name; received {text!r}.")
    for word in asked:
        if not any(word.casefold() in name.casefold() for name in known):
            raise ValueError(
                f"there is no problem {word!r} to compare on; did you mean "
                f"{nearest(word, known)!r} (known: {', '.join(known)})?"
            )
    chosen = [name for name in known if any(word.casefold() in name.casefold() for word in asked)]
    return replace(
        suite,
        problems=lambda quick: chosen,
        cost=partial(suite.cost, only=chosen),
        targets=tuple(target for target in suite.targets if target.problem in chosen),
        sections=(),
    )
