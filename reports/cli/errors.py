"""Usage errors in one sentence that suggests the nearest known word."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from functools import partial
from typing import Any

import typer

from references.setting import nearest
from reports.cli.project import CONTENDERS_CLAIMS, TABLE
from reports.results.options import OF_CONTENDERS

# Public under this name alone; typer has carried its own copy of click since 0.2x.
UsageError: Any = typer.BadParameter.__bases__[0]
PLACES = ("H ", "M ")  # the beginnings of places of the papers


def words(text: str) -> tuple[str, ...]:
    """The words of a list with commas."""
    return tuple(" ".join(word.split()) for word in text.split(",") if word.strip())


def choose_claims(
    text: str,
    known: Iterable[str],
    by_place: Callable[[], Mapping[str, Collection[str]]] = dict,
    why_unchecked: Callable[[str], str] = str,
) -> tuple[str, ...]:
    """Parse claim ids such as "V3,V5", or places of the papers such as "H fig. 3.5"; returned in
    the order of `known`, all of them for "". One place may have a comma: "M 6.2, fig. 3 right".

    by_place       the ids of the claims that check what is printed at each place
    why_unchecked  what became of a place that no claim checks

    The word CONTENDERS_CLAIMS stands for all that belong to external integrators. Raises
    typer.BadParameter for an unknown id or place, one that no claim checks, and for that word where
    there are none.
    """
    known = tuple(known)
    at = partial(_at, by_place=by_place, why_unchecked=why_unchecked)
    asked = tuple(name for word in _listed(text, by_place) for name in at(word) or [word])
    if text and not asked:
        raise typer.BadParameter(
            f"--claims expects ids like {known[0]}, separated by commas; received {text!r}."
        )
    theirs = tuple(claim for claim in known if claim.startswith(OF_CONTENDERS))
    for word in asked:
        if (word == CONTENDERS_CLAIMS or word.startswith(OF_CONTENDERS)) and not theirs:
            raise typer.BadParameter(
                f"there is no claim {word!r}; such claims belong to an external integrator: add it "
                f"with --contender package.module:Class, or as contenders of {TABLE}."
            )
        if word != CONTENDERS_CLAIMS and word not in known:
            near = nearest(word, (*known, CONTENDERS_CLAIMS) if theirs else known)
            raise typer.BadParameter(f"there is no claim {word!r}; did you mean {near!r}?")
    chosen = {*asked, *(theirs if CONTENDERS_CLAIMS in asked else ())}
    return tuple(claim for claim in known if not asked or claim in chosen)


def _listed(text: str, by_place: Callable[[], Mapping[str, Collection[str]]]) -> tuple[str, ...]:
    """The words of a list with commas, or one place that has a comma."""
    place = text.strip()
    is_place = place[:2].upper() in PLACES and "," in place and place in by_place()
    return (place,) if is_place else words(text)


def _at(
    word: str,
    by_place: Callable[[], Mapping[str, Collection[str]]],
    why_unchecked: Callable[[str], str],
) -> Collection[str]:
    """The ids of the claims at a place of a paper; none for a word that is no place."""
    if word[:2].upper() not in PLACES:
        return ()
    known = by_place()
    if word not in known:
        near = nearest(word, [*known])
        raise typer.BadParameter(f"there is no place {word!r}; did you mean {near!r}?")
    if not known[word]:
        raise typer.BadParameter(
            f"no claim checks what is printed at {word!r} ({why_unchecked(word)})."
        )
    return known[word]


def choose_engines(text: str, known: Iterable[str]) -> tuple[str, ...]:
    """Parse engines such as "rebound,mujoco". Raises typer.BadParameter for none or unknown."""
    known = tuple(known)
    asked = words(text)
    if not asked:
        raise typer.BadParameter(
            f"--require expects engines of {', '.join(known)}, separated by commas; "
            f"received {text!r}."
        )
    for word in asked:
        if word not in known:
            near = f"did you mean {nearest(word, known)!r} " if known else ""
            raise typer.BadParameter(
                f"--require knows no engine {word!r}; {near}(known: {', '.join(known) or 'none'})?"
            )
    return tuple(dict.fromkeys(asked))


def sentence(error: Any, commands: Iterable[str]) -> str:
    """One sentence for a usage error that typer raised."""
    message = (error.message or error.format_message()).rstrip().rstrip(".")
    if "\n  " not in message:  # else it has one line an item
        message = " ".join(message.split())
    if hasattr(error, "possibilities"):
        options = [name for param in error.ctx.command.params for name in param.opts]
        options = [name for name in (*options, "--help") if name.startswith("--")]
        word = error.option_name
        return f"There is no option {word!r}; did you mean {nearest(word, options)!r}?"
    if message.startswith("No such command"):  # the text is all that click gives
        word = message.split("'")[1]
        known = tuple(commands)
        return (
            f"There is no command {word!r}; did you mean {nearest(word, known)!r} "
            f"(known: {', '.join(known)})?"
        )
    option = next(iter(getattr(getattr(error, "param", None), "opts", ())), "")
    if option.startswith("--") and option not in message:
        message = f"{option}: {message[0].lower()}{message[1:]}"
    if message.split()[0].isalpha():  # an option or a path stays as it is
        message = message[0].upper() + message[1:]
    return message + ("" if message.endswith("?") else ".")
