"""Usage errors in one sentence that suggests the nearest known word."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import typer

from references.setting import nearest

OF_CONTENDERS = "A-"  # prefix of the ids of `benchmarks.applications.external.checks`
# Public under this name alone; typer has carried its own copy of click since 0.2x.
UsageError: Any = typer.BadParameter.__bases__[0]


def choose_claims(text: str, known: Iterable[str]) -> tuple[str, ...]:
    """Parse claim ids such as "V3,V5"; returned in the order of `known`, all of them for "".

    Raises typer.BadParameter for an unknown id.
    """
    known = tuple(known)
    asked = [word.strip() for word in text.split(",") if word.strip()]
    if text and not asked:
        raise typer.BadParameter(
            f"--claims expects ids like {known[0]}, separated by commas; received {text!r}."
        )
    for word in asked:
        joined = any(claim.startswith(OF_CONTENDERS) for claim in known)
        if word.startswith(OF_CONTENDERS) and not joined:
            raise typer.BadParameter(
                f"there is no claim {word!r}; claims that begin with {OF_CONTENDERS} belong to an "
                "external integrator: add it with --contender package.module:Class."
            )
        if word not in known:
            raise typer.BadParameter(
                f"there is no claim {word!r}; did you mean {nearest(word, known)!r} "
                f"(known: {', '.join(known)})?"
            )
    return tuple(claim for claim in known if not asked or claim in asked)


def choose_engines(text: str, known: Iterable[str]) -> tuple[str, ...]:
    """Parse engines such as "rebound,mujoco". Raises typer.BadParameter for none or unknown."""
    known = tuple(known)
    asked = [word.strip() for word in text.split(",") if word.strip()]
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
        known = [name for param in error.ctx.command.params for name in param.opts]
        known = [name for name in (*known, "--help") if name.startswith("--")]
        word = error.option_name
        return f"There is no option {word!r}; did you mean {nearest(word, known)!r}?"
    if message.startswith("No such command"):
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
