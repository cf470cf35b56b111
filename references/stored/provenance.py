"""The provenance of stored truths: engine, version, accuracy, command and hash of each file."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping

from references.stored.planets import FOLDER

HEADINGS = ("file", "problem", "engine", "accuracy", "made by", "SHA-256")
OF_HEADER = {"engine": "source", "accuracy": "accuracy", "made by": "made by"}


def truths() -> list[Mapping[str, str]]:
    """A row for each file, with the keys HEADINGS."""
    rows = []
    for path in sorted(FOLDER.glob("*.csv")):
        content = path.read_bytes()
        lines = [line[2:] for line in content.decode("ascii").splitlines() if line[:2] == "# "]
        header = dict(line.split(": ", 1) for line in lines[1:])
        rows.append(
            {
                "file": path.name,
                "problem": lines[0].removesuffix(", the truth"),
                **{heading: header[key] for heading, key in OF_HEADER.items()},
                "SHA-256": hashlib.sha256(content).hexdigest(),
            }
        )
    return rows
