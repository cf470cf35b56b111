"""verify.md: the Markdown summary of `verify`, shown on a pull request."""

from __future__ import annotations

from collections.abc import Sequence

import pandas as pd

from benchmarks.checks.claim import Row
from reports.build.changes import Change
from reports.results.engines import Engines
from reports.results.summary import Summary
from reports.tables.number_format import plain

HEADINGS = ("claim", "quantity", "bound", "measured", "uncertainty", "verdict", "expected")


def markdown(seen: Summary, changed: Sequence[Change], engines: Engines) -> str:
    """Passed or failed, unexpected verdicts, changes, and all rows in a collapsed section."""
    passed = seen.as_expected and not engines.wanting
    parts = [f"## verify: {'passed' if passed else 'failed'}", str(seen)]
    parts += [f"- {sentence}" for sentence in engines.sentences()]
    if seen.differing:
        parts += ["### Not as expected", _table(_lines(seen.differing, reason=True))]
    if changed:
        moved = [
            {"claim": c.id, "quantity": c.quantity, "what": c.what, "before": c.before,
             "now": c.now}
            for c in changed
        ]  # fmt: skip
        parts += ["### Changed since the rows before", _table(moved)]
    folded = _table(_lines(seen.rows))
    parts += [f"<details><summary>All {len(seen.rows)} checks</summary>\n\n{folded}\n\n</details>"]
    return "\n\n".join(parts) + "\n"


def _lines(rows: Sequence[Row], reason: bool = False) -> list[dict[str, str]]:
    lines = []
    for row in rows:
        cells = (row.id, row.quantity, row.bound, plain(row.measured) or "-",
                 plain(row.uncertainty, 2), row.verdict, row.expected)  # fmt: skip
        line = dict(zip(HEADINGS, cells, strict=True))
        lines.append({**line, "reason": row.reason} if reason else line)
    return lines


def _table(lines: Sequence[dict[str, str]]) -> str:
    """GitHub Markdown; characters that would end a cell or start a tag are escaped."""
    escaped = pd.DataFrame(lines).map(_cell)
    return str(escaped.to_markdown(index=False, disable_numparse=True))


def _cell(text: str) -> str:
    plain_text = " ".join(str(text).split())
    return plain_text.replace("\\", "\\\\").replace("|", "\\|").replace("<", "&lt;")
