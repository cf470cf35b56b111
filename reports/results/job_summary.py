"""The summary that a forge shows beside a job of its CI."""

from __future__ import annotations

import os
import sys

VARIABLE = "GITHUB_STEP_SUMMARY"  # holds the path of a file that the forge shows


def write_job_summary(text: str) -> None:
    """Append to the file that the forge names, if it names one; say what goes wrong."""
    path = os.environ.get(VARIABLE)
    if not path:
        return
    try:
        with open(path, "a", encoding="utf-8") as file:
            file.write(text)
    except OSError as error:
        print(f"The summary was not appended to ${VARIABLE}: {error}.", file=sys.stderr)
