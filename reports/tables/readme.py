"""Update the tables and the pictures of README.md from the output of `build`."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from benchmarks.claims.statements import counted, statements
from benchmarks.store.atomic import write
from reports.tables.number_format import plain

RESULTS, SPEED, BODIES, STATEMENTS = "results", "speed", "bodies", "statements"
WIDTH = 101  # columns of the README
PICTURES = {  # of the repository: of a report
    "reports/inner_planets.png": "fig-2-14",
    "docs/headline_rebound.png": "headline-rebound",
    "docs/headline_mujoco.png": "headline-mujoco",
}
HEADLINES = (
    ("V3", "base of the one-step error"),
    ("V4", "base of the curve error"),
    (
        "V7",
        "order of the angular momentum error along the curve, number of points n = 4, 100 steps",
    ),
    ("V9", "largest distance to IAS15 on the curve of the inner planets [mean distance], n = 25"),
    ("V23", "order, N = 3, w away from 0"),
    ("L3", "least order over n - 1, n, n + 1, 2 n Gauss points, n = 4"),
    ("L9", "largest energy error, m g = 22, Cayley chart"),
)
CODES = (
    "REBOUND IAS15",
    "REBOUND WHFast, best",
    "REBOUND WHFast512",
    "REBOUND SABA",
    "heyoka",
    "SciPy DOP853",
)
SYSTEMS = {"outer solar system": "outer", "solar system without Pluto": "Sun + 8"}
ERRORS = (1e-4, 1e-6, 1e-8, 1e-10)
BODY_CODES = (
    "MuJoCo RK4",
    "RK4 on quaternions, compiled",
    "DOP853 on quaternions, compiled",
    "heyoka",
    "SciPy DOP853",
)
BODY_SYSTEMS = {"free rigid body": "free body", "3D pendulum, m g = 9.81": "3D pendulum"}
BODY_ERRORS = (7e-6, 1e-8, 1e-10, 1e-12)


def results(claims: pd.DataFrame) -> str:
    """The headline rows of claims.csv as a Markdown table.

    Raises KeyError for a headline that is not among the rows.
    """
    lines = ["| claim | quantity | the paper | measured | verdict |", "|---|---|---|---|---|"]
    for name, quantity in HEADLINES:
        found = claims[(claims["id"] == name) & (claims["quantity"] == quantity)]
        if found.empty:
            raise KeyError(f"claims.csv has no row {name}, {quantity}.")
        row = found.iloc[0]
        measured = plain(row["measured"])
        slack = f", slack x{float(plain(row['slack'], 2)):g}" if row["slack"] > 1.0 else ""
        lines.append(
            f"| {name}, {row['source']} | {quantity} | {row['claimed']} | {measured} "
            f"| {row['verdict']}{slack} |"
        )
    return "\n".join(lines)


def speed(ratios: pd.DataFrame) -> str:
    """Markdown table from ratios.csv: times relative to galvi's best at equal error."""
    return _times(ratios, "position error", CODES, SYSTEMS, ERRORS)


def bodies(ratios: pd.DataFrame) -> str:
    """The same table for rigid bodies."""
    return _times(ratios, "attitude error", BODY_CODES, BODY_SYSTEMS, BODY_ERRORS)


def _times(
    ratios: pd.DataFrame, quantity: str, codes: Sequence[str], systems: Mapping[str, str],
    errors: Sequence[float],
) -> str:  # fmt: skip
    columns = [(system, error) for system in systems for error in errors]
    titles = [f"{systems[system]}, {error:.0e}" for system, error in columns]
    lines = [f"| {quantity} | {' | '.join(titles)} |", "|---" * (len(columns) + 1) + "|"]
    for code in codes:
        cells = [_ratio(ratios, code, system, error) for system, error in columns]
        lines.append(f"| {code} | {' | '.join(cells)} |")
    return "\n".join(lines)


def _ratio(ratios: pd.DataFrame, code: str, system: str, error: float) -> str:
    """The least ratio of a code, as text; '-' when it took no part."""
    found = ratios[
        (ratios["problem"] == system)
        & ratios["contender"].str.startswith(code)
        & np.isclose(ratios["error"].astype(float), error, rtol=1e-6, atol=0.0)
    ]["ratio"]
    if found.empty:
        return "-"
    numbers = pd.to_numeric(found, errors="coerce").dropna()
    return "not reached" if numbers.empty else f"{float(f'{numbers.min():.2g}'):g}"


def marks(name: str) -> tuple[str, str]:
    """The comments that enclose a generated table."""
    return f"<!-- {name}: python -m reports readme -->", f"<!-- end of {name} -->"


def table_of(page: str, name: str) -> str:
    """The text between the marks. Raises ValueError when a mark is missing."""
    begin, end = marks(name)
    _, found, rest = page.partition(begin)
    table, closed, _ = rest.partition(end)
    if not found or not closed:
        raise ValueError(f"README.md must hold the marks {begin} and {end}.")
    return table.strip()


def _with(page: str, name: str, table: str) -> str:
    table_of(page, name)
    begin, end = marks(name)
    before, _, rest = page.partition(begin)
    _, _, after = rest.partition(end)
    return f"{before}{begin}\n{table}\n{end}{after}"


def with_statements(page: str) -> str:
    """The page with the count of the papers' statements renewed."""
    lines = textwrap.fill(counted(statements()), WIDTH)
    return _with(page, STATEMENTS, lines)


def renew(readme: Path, out: Path) -> None:
    """Write the tables of the report in ``out`` into ``readme``, and update its pictures."""
    page = _with(readme.read_text(), RESULTS, results(pd.read_csv(out / "claims.csv")))
    ratios = pd.read_csv(out / "tables" / "ratios.csv")
    page = _with(_with(page, SPEED, speed(ratios)), BODIES, bodies(ratios))
    write(readme, with_statements(page))
    for picture, figure in PICTURES.items():
        write(readme.parent / picture, (out / "figures" / f"{figure}.png").read_bytes())
