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

SECONDS = 900.0  # time limit of an installation or a program


class NotHere(Exception):
    """An environment cannot be created, or its program failed; the message is one sentence."""


@contextmanager
def environment(requirement: str, folder: Path) -> Iterator[Path]:
    """The interpreter of a new virtual environment in the folder, removed afterwards.

    Parameters
    ----------
    requirement
        requirement to install with its dependencies, e.g. "mujoco==3.6.0"

    Notes
    -----
    Raises NotHere when it cannot be created.
    """
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix=f".{requirement}-", dir=folder.absolute()) as path:
        finished([sys.executable, "-I", "-m", "venv", path])
        interpreter = interpreter_in(Path(path))
        pip = [str(interpreter), "-I", "-m", "pip", "install", "--quiet", "--only-binary=:all:"]
        finished([*pip, "--disable-pip-version-check", requirement])
        yield interpreter


def interpreter_in(environment: Path) -> Path:
    """The Python of a virtual environment."""
    return environment / ("Scripts" if os.name == "nt" else "bin") / "python"


def finished(
    command: Sequence[str], text: str = "", variables: Mapping[str, str] | None = None
) -> str:
    """The output of a command, with `text` as its input and `variables` added to the environment.
    Raises NotHere when it fails."""
    try:
        completed = subprocess.run(
            command,
            input=text,
            capture_output=True,
            text=True,
            timeout=SECONDS,
            check=False,
            env={**os.environ, **(variables or {})},
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        raise NotHere(f"{type(error).__name__}: {_readable(str(error))}") from None
    if completed.returncode:
        lines = [line for line in completed.stderr.splitlines() if line.strip()]
        errors = [line for line in lines if "error" in line.lower()]  # pip gives text alone
        raise NotHere(_readable((errors or lines or [f"exit status {completed.returncode}"])[-1]))
    return completed.stdout


def _readable(text: str) -> str:
    """The text without addresses and folders, which mean nothing to the reader of a page."""
    readable = re.sub(r"\S*(?:://|[\\/])\S*", "...", text.strip())
    return readable.removeprefix("ERROR: ")[:200]
