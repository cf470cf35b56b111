"""Load the class of an external integrator, and read its declarations."""

from __future__ import annotations

import difflib
import importlib
import inspect
from collections.abc import Mapping
from typing import Any

import numpy as np

from benchmarks.store.foreign_texts import FORMULA_STARTS, visible
from references import REFERENCES

METHODS = ("supports", "run")
CONSERVED = ("energy", "angular momentum")
RESERVED_NAME = "galvi"
PACKAGES = (RESERVED_NAME, "benchmarks", "references", "reports")
LONGEST = 60  # characters of a name
MARKUP = "<>$|`"  # characters with a meaning in pages and figures


class ContenderError(Exception):
    """An error of an external integrator; the message is one sentence."""


class NotAsked(ContenderError):
    """A request that was not made, since earlier answers were late."""


def load_class(path: str) -> Any:
    """An instance of the class at "package.module:Class"; an object that is no class as it is.

    Raises
    ------
    ContenderError
        When it cannot be imported or constructed, lacks a required member, or has a name that may
        not be used.
    """
    contender = object_at(path, "contender", "Class")
    name = path.partition(":")[2]
    if isinstance(contender, type):
        try:
            contender = contender()
        except BaseException as error:
            raise ContenderError(f"{name}() raised {describe_error(error)}") from None
    lacking = [name for name in METHODS if not callable(getattr(contender, name, None))]
    lacking += [] if hasattr(contender, "name") else ["name"]
    if lacking:
        raise ContenderError(
            f"{path} lacks {' and '.join(map(repr, lacking))}; a contender has name, "
            "supports(problem) and run(problem, duration, setting)"
        )
    if not (isinstance(contender.name, str) and _is_name(plain_text(contender.name))):
        raise ContenderError(
            f"the name of {path} must be words in one line, of {LONGEST} letters at most, none of "
            f"{MARKUP}, that do not begin with {RESERVED_NAME!r}, which are galvi's own methods, "
            f"nor with a formula's {' '.join(FORMULA_STARTS[:4])}, "
            "and that no other code of the suite "
            f"has; received {contender.name!r}"
        )
    return contender


def object_at(path: str, kind: str, noun: str) -> Any:
    """Import the object at "package.module:name".

    Parameters
    ----------
    kind, noun
        words of messages: "contender", "Class"

    Raises
    ------
    ContenderError
        When the path has another form, or there is no such module or object.
    """
    module_name, _, name = path.partition(":")
    if not all(part.isidentifier() for part in (*module_name.split("."), name)):
        raise ContenderError(
            f"a {kind} is named package.module:{noun}; received {path!r}"
            f"{_suggested_path(path, noun)}"
        )
    try:
        module = importlib.import_module(module_name)
    except BaseException as error:
        missing = getattr(error, "name", None) if isinstance(error, ModuleNotFoundError) else None
        if missing and (module_name + ".").startswith(missing + "."):
            package = missing.partition(".")[0]
            if package in PACKAGES:
                inner = module_name.partition(".")[2]
                raise ContenderError(
                    f"there is no module {missing!r} to take {name} from: {package!r} is here a "
                    f"package of galvi's own, which comes before a folder of that name; move the "
                    f"file to another folder, or put this one on PYTHONPATH and name {inner}:{name}"
                ) from None
            raise ContenderError(
                f"there is no module {missing!r} to take {name} from; name one that Python can "
                f"import from this folder"
            ) from None
        raise ContenderError(f"importing {module_name} raised {describe_error(error)}") from None
    if not hasattr(module, name):
        public_names = [word for word in vars(module) if not word.startswith("_")]
        similar = difflib.get_close_matches(name, public_names, n=1)
        raise ContenderError(
            f"module {module_name} has no {name!r}"
            f"{f'; did you mean {similar[0]!r}?' if similar else ''}"
        )
    return getattr(module, name)


def _suggested_path(path: str, noun: str) -> str:
    """The end of a message that suggests a path for a file or for a class after a dot, or ""."""
    path = f"{path}:{noun}" if path.endswith(".py") else path
    file, _, name = path.removeprefix("./").rpartition(":")
    module = file.removesuffix(".py").replace("/", ".")
    if not file:
        module, _, name = path.rpartition(".")
    if all(part.isidentifier() for part in (*module.split("."), name)):
        return f"; did you mean {f'{module}:{name}'!r}?"
    return ""


def _is_name(name: str) -> bool:
    one_line = name.strip() and name.isprintable() and len(name) <= LONGEST
    word = " ".join(name.casefold().split())
    is_reserved = word.startswith((RESERVED_NAME, *FORMULA_STARTS))
    same_names = {code.name.casefold() for code in REFERENCES} & {
        word,
        word.partition(",")[0].rstrip(),
    }
    return bool(one_line) and not set(name) & set(MARKUP) and not is_reserved and not same_names


def metadata(contender: Any) -> tuple[str, float | None, dict[str, float], bool]:
    """Its name, its order (None when not declared), its declared conserved quantities, and whether
    it declares that it is symmetric.

    Raises
    ------
    ContenderError
        When the order, the conserved quantities or the symmetry has the wrong type or value.
    """
    order, conserves = getattr(contender, "order", None), getattr(contender, "conserves", {})
    symmetric = getattr(contender, "symmetric", False)
    if order is not None and not is_positive(order):
        raise ContenderError(f"its order must be a positive number; received {order!r}")
    if not isinstance(conserves, Mapping) or not all(
        name in CONSERVED and is_positive(limit) for name, limit in conserves.items()
    ):
        raise ContenderError(
            "what it conserves must be a mapping of "
            f"{' or '.join(map(repr, CONSERVED))} to the largest relative change, a positive "
            f"number; received {conserves!r}"
        )
    if not isinstance(symmetric, bool):
        raise ContenderError(
            "whether it is symmetric, that is, returns to its start in a run back, must be True or "
            f"False; received {symmetric!r}"
        )
    limits = {plain_text(name): float(limit) for name, limit in conserves.items()}
    return plain_text(contender.name), None if order is None else float(order), limits, symmetric


def definition(contender: Any) -> tuple[str, int]:
    """The file of its class and the line where the class begins; "" and 0 where they are unknown,
    as for a class without a ``class`` statement."""
    cls = type(contender)
    try:
        return plain_text(inspect.getsourcefile(cls) or ""), inspect.findsource(cls)[1] + 1
    except Exception:  # inspect runs code of the contender's module
        return "", 0


def is_positive(value: Any) -> bool:
    """Whether this is a finite number above 0."""
    return (
        isinstance(value, (int, float, np.number))
        and not isinstance(value, bool)
        and 0.0 < float(value) < float("inf")
    )


def plain_text(value: Any) -> str:
    """The value as a plain str, which is unpickled without the contender's code; "" where it has no
    text."""
    try:
        return str.__str__(value if isinstance(value, str) else str(value))
    except Exception:
        return ""


def describe_error(error: BaseException) -> str:
    """Type and message of an exception, on one line, without control characters and full stop."""
    message = " ".join(plain_text(error).split()).rstrip(".")
    return visible(f"{type(error).__name__}: {message}" if message else type(error).__name__)
