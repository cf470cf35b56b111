"""The README's results table and picture, from what `build` wrote."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from reports.atomic import write
from reports.numerals import plain

BEGIN, END = "<!-- results: python -m reports readme -->", "<!-- end of results -->"
PICTURE = "reports/inner_planets.png"
HEADLINES = (
    ("V1", "smallest curve error"),
    ("V2", "energy error, n = 14"),
    ("V3", "base of the one-step error"),
    ("V4", "base of the curve error"),
    ("V5", "base of the angular momentum error along the curve"),
    ("V6", "order of the one-step error, n = 6, fixed T"),
    ("V7", "order of the angular momentum error along the curve, n = 4, fixed T"),
    ("V8", "angular momentum error, n = 8"),
    ("V9", "Mercury, distance to IAS15 at the end [au], n = 25"),
    ("V9", "energy error, n = 25"),
)


def results(claims: pd.DataFrame) -> str:
    """The headline rows of claims.csv as a Markdown table.

    Raises KeyError, naming it, when a headline is not among the rows.
    """
    lines = ["| claim | quantity | the paper | measured | verdict |", "|---|---|---|---|---|"]
    for name, quantity in HEADLINES:
        found = claims[(claims["id"] == name) & (claims["quantity"] == quantity)]
        if found.empty:
            raise KeyError(f"claims.csv has no row {name}, {quantity}.")
        row = found.iloc[0]
        measured = plain(row["measured"])
        lines.append(
            f"| {name}, {row['source']} | {quantity} | {row['claimed']} | {measured} "
            f"| {row['verdict']} |"
        )
    return "\n".join(lines)


def table_of(page: str) -> str:
    """What stands between the marks of a page. Raises ValueError when a mark is missing."""
    _, begin, rest = page.partition(BEGIN)
    table, end, _ = rest.partition(END)
    if not begin or not end:
        raise ValueError(f"README.md must hold the marks {BEGIN} and {END}.")
    return table.strip()


def renew(readme: Path, out: Path) -> None:
    """Write the table of ``out/claims.csv`` into ``readme``, and renew its picture."""
    page = readme.read_text()
    table_of(page)
    before, _, rest = page.partition(BEGIN)
    _, _, after = rest.partition(END)
    table = results(pd.read_csv(out / "claims.csv"))
    write(readme, f"{before}{BEGIN}\n{table}\n{END}{after}")
    write(readme.parent / PICTURE, (out / "figures" / "fig-2-14.png").read_bytes())
