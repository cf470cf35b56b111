"""The job summary of GitHub Actions."""

from __future__ import annotations

import os
import sys

VARIABLE = "GITHUB_STEP_SUMMARY"  # the path of the summary file


def write_job_summary(text: str) -> None:
    """Append to the summary file, if there is one; print a warning when that fails."""
    path = os.environ.get(VARIABLE)
    if not path:
        return
    try:
        with open(path, "a", encoding="utf-8") as file:
            file.write(text)
    except OSError as error:
        print(f"The summary was not appended to ${VARIABLE}: {error}.", file=sys.stderr)
