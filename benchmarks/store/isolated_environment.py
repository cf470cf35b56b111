"""A temporary virtual environment for another version of an engine."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

TIME_LIMIT = 900.0  # seconds of an installation or a program


class EnvironmentUnavailable(Exception):
    """An environment could not be created, or its program failed; the message is a sentence."""


@contextmanager
def environment(requirement: str, folder: Path) -> Iterator[Path]:
    """The interpreter of a new virtual environment in the folder, removed afterwards.

    Parameters
    ----------
    requirement
        requirement to install with its dependencies, e.g. "mujoco==3.6.0"

    Raises
    ------
    EnvironmentUnavailable
        When it cannot be created.
    """
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix=f".{requirement}-", dir=folder.absolute()) as path:
        output_of([sys.executable, "-I", "-m", "venv", path])
        interpreter = interpreter_in(Path(path))
        pip = [str(interpreter), "-I", "-m", "pip", "install", "--quiet", "--only-binary=:all:"]
        output_of([*pip, "--disable-pip-version-check", requirement])
        yield interpreter


def interpreter_in(environment: Path) -> Path:
    """The Python of a virtual environment."""
    return environment / ("Scripts" if os.name == "nt" else "bin") / "python"


def output_of(
    command: Sequence[str], text: str = "", variables: Mapping[str, str] | None = None
) -> str:
    """The output of a command, with `text` as its input and `variables` added to the environment.

    Raises
    ------
    EnvironmentUnavailable
        When the command fails, or takes longer than TIME_LIMIT.
    """
    try:
        completed = subprocess.run(
            command,
            input=text,
            capture_output=True,
            text=True,
            timeout=TIME_LIMIT,
            check=False,
            env={**os.environ, **(variables or {})},
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        raise EnvironmentUnavailable(f"{type(error).__name__}: {_readable(str(error))}") from None
    if completed.returncode:
        lines = [line for line in completed.stderr.splitlines() if line.strip()]
        errors = [line for line in lines if "error" in line.lower()]  # pip gives text alone
        raise EnvironmentUnavailable(
            _readable((errors or lines or [f"exit status {completed.returncode}"])[-1])
        )
    return completed.stdout


def _readable(text: str) -> str:
    """The first 200 characters of the text, with addresses and paths replaced by "..."."""
    readable = re.sub(r"\S*(?:://|[\\/])\S*", "...", text.strip())
    return readable.removeprefix("ERROR: ")[:200]
