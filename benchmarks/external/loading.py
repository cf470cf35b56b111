"""Somebody else's contender at the place that was named, and what it says of itself."""

from __future__ import annotations

import difflib
import importlib
from collections.abc import Mapping
from typing import Any

import numpy as np

PARTS = ("name", "supports", "run")
CONSERVED = ("energy", "angular momentum")
OURS = "galvi"
LONGEST, MARKUP = 60, "<>$|`"  # letters of a name, and those that pages and figures would read


class Fault(Exception):
    """What is wrong, in a sentence."""


def opened(path: str) -> Any:
    """The contender at "package.module:Class". Fault when there is none, or it is none."""
    module_name, _, name = path.partition(":")
    if not all(part.isidentifier() for part in (*module_name.split("."), name)):
        raise Fault(f"a contender is named package.module:Class; received {path!r}{_meant(path)}")
    try:
        module = importlib.import_module(module_name)
    except ModuleNotFoundError as error:
        if error.name and (module_name + ".").startswith(error.name + "."):
            raise Fault(
                f"there is no module {error.name!r} to take {name} from; name one that Python can "
                f"import from this folder"
            ) from None
        raise Fault(f"importing {module_name} raised {told(error)}") from None
    except BaseException as error:
        raise Fault(f"importing {module_name} raised {told(error)}") from None
    if not hasattr(module, name):
        known = [word for word in vars(module) if not word.startswith("_")]
        near = difflib.get_close_matches(name, known, n=1)
        raise Fault(
            f"module {module_name} has no {name!r}{f'; did you mean {near[0]!r}?' if near else ''}"
        )
    made = getattr(module, name)
    if isinstance(made, type):
        try:
            made = made()
        except BaseException as error:
            raise Fault(f"{name}() raised {told(error)}") from None
    lacking = [part for part in PARTS if not hasattr(made, part)]
    lacking += [
        part for part in PARTS[1:] if hasattr(made, part) and not callable(getattr(made, part))
    ]
    if lacking:
        raise Fault(
            f"{path} lacks {' and '.join(map(repr, lacking))}; a contender has name, "
            "supports(problem) and run(problem, duration, setting)"
        )
    if not (isinstance(made.name, str) and _is_name(made.name)):
        raise Fault(
            f"the name of {path} must be words in one line, of {LONGEST} letters at most, none of "
            f"{MARKUP}, that do not begin with {OURS!r}, which are galvi's own methods; received "
            f"{made.name!r}"
        )
    return made


def _meant(path: str) -> str:
    """What a file's path, or a class behind a dot, may stand for."""
    file, _, name = path.removeprefix("./").rpartition(":")
    module = file.removesuffix(".py").replace("/", ".")
    if not file:
        module, _, name = path.rpartition(".")
    if all(part.isidentifier() for part in (*module.split("."), name)):
        return f"; did you mean {f'{module}:{name}'!r}?"
    return ""


def _is_name(name: str) -> bool:
    one_line = name.strip() and name.isprintable() and len(name) <= LONGEST
    return bool(one_line) and not set(name) & set(MARKUP) and not name.startswith(OURS)


def introduced(contender: Any) -> tuple[str, float | None, dict[str, float]]:
    """Its name, order and what it conserves; None and nothing where it does not say. Fault when
    they are no such things."""
    order, conserves = getattr(contender, "order", None), getattr(contender, "conserves", {})
    if order is not None and not is_positive(order):
        raise Fault(f"its order must be a positive number; received {order!r}")
    if not isinstance(conserves, Mapping) or not all(
        name in CONSERVED and is_positive(most) for name, most in conserves.items()
    ):
        raise Fault(
            "what it conserves must be a mapping of "
            f"{' or '.join(map(repr, CONSERVED))} to the largest relative change, a positive "
            f"number; received {conserves!r}"
        )
    kept = {str(name): float(most) for name, most in conserves.items()}
    return contender.name, None if order is None else float(order), kept


def is_positive(value: Any) -> bool:
    """Whether it is a finite number above 0."""
    return (
        isinstance(value, (int, float, np.number))
        and not isinstance(value, bool)
        and 0.0 < float(value) < float("inf")
    )


def told(error: BaseException) -> str:
    """Its kind and its words, without a full stop."""
    words = " ".join(str(error).split()).rstrip(".")
    return f"{type(error).__name__}: {words}" if words else type(error).__name__
