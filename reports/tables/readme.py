"""Update the tables and the pictures of README.md and of docs/ from the output of `build`."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from benchmarks.applications.mutation.study import equivalents
from benchmarks.applications.mutation.trial import KILLED
from benchmarks.claims import CLAIMS
from benchmarks.claims.statements import counted, statements
from benchmarks.statistics.paired import TIE
from benchmarks.store.atomic import write
from benchmarks.store.cells import read_csv
from benchmarks.work_precision.asked import code_of
from benchmarks.work_precision.dependable import dependable
from benchmarks.work_precision.labels import label_of
from references.stored.provenance import truths
from reports.results.machines import Machine, machines
from reports.results.origins import read_origins
from reports.tables.comparison_tables import (
    ALL,
    GALVI,
    NOBODY,
    NOISE,
    fastest_per_error,
    heading,
    is_ours,
    matched,
)
from reports.tables.number_format import known, plain, seconds, with_uncertainty

SPEED, BODIES, STATEMENTS = "speed", "bodies", "statements"  # of README.md
RESULTS, EVIDENCE = "results", "evidence"  # of docs/trust.md
CHOICES = "choices"  # of docs/which.md
WIDTH = 101  # columns of the README
MEASURED = ("work_precision.csv", "claims.csv")  # of a report
PICTURES = {  # of the repository: of a report
    "reports/inner_planets.png": "fig-2-14",
    "docs/headline_rebound.png": "headline-rebound",
    "docs/headline_mujoco.png": "headline-mujoco",
    "docs/headline_clock.png": "headline-clock",
}
HEADLINES = (
    ("V3", "base of the one-step error"),
    ("V4", "base of the curve error"),
    ("V7", "what the order of the angular momentum error along the curve gains with n, 100 steps"),
    ("V9", "largest distance to IAS15 on the curve of the inner planets [mean distance], n = 25"),
    ("V23", "order, N = 3, w away from 0"),
    ("L3", "least order over n - 1, n, n + 1, 2 n Gauss points, n = 4"),
    ("L9", "largest energy error, m g = 22, Cayley chart"),
)
CODES = (
    "REBOUND IAS15",
    "REBOUND WHFast",
    "REBOUND WHFast512",
    "REBOUND SABA",
    "REBOUND BS",
    "heyoka",
)
Systems = Mapping[str, tuple[str, tuple[float, ...]]]  # name -> (title, errors)
SYSTEMS: Systems = {
    "outer solar system": ("outer", (1e-4, 1e-8)),
    "solar system without Pluto": ("Sun + 8", (1e-4, 1e-8)),
    "two bodies, e = 0.99": ("e = 0.99", (1e-6,)),
    "Burrau's problem": ("Burrau", (1e-6,)),
}
BODY_CODES = (
    "MuJoCo RK4",
    "RK4 on quaternions",
    "DOP853 on quaternions",
    "heyoka",
)
BODY_SYSTEMS: Systems = {
    "free rigid body": ("free body", (1e-2, 1e-4, 1e-6)),
    "3D pendulum, m g = 9.81": ("3D pendulum", (1e-2, 1e-4, 1e-6)),
}


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
        measured = with_uncertainty(row["measured"], row["uncertainty"])
        slack = f", slack x{float(plain(row['slack'], 2)):g}" if row["slack"] > 1.0 else ""
        lines.append(
            f"| {name}, {row['source']} | {quantity} | {row['claimed']} | {measured} "
            f"| {row['verdict']}{slack} |"
        )
    return "\n".join(lines)


def speed(ratios: pd.DataFrame) -> str:
    """Markdown table from ratios.csv: times relative to galvi's best at equal error."""
    return _times(ratios, "position error", CODES, SYSTEMS)


def bodies(ratios: pd.DataFrame) -> str:
    """The same table for rigid bodies."""
    return _times(ratios, "attitude error", BODY_CODES, BODY_SYSTEMS)


def _times(
    ratios: pd.DataFrame, quantity: str, codes: Sequence[str], systems: Systems
) -> str:  # fmt: skip
    columns = [(system, error) for system, (_, errors) in systems.items() for error in errors]
    titles = [f"{systems[system][0]}, {error:.0e}" for system, error in columns]
    lines = [f"| {quantity} | {' | '.join(titles)} |", "|---" * (len(columns) + 1) + "|"]
    for code in codes:
        cells = [_ratio(_at(ratios, system, error), code) for system, error in columns]
        lines.append(f"| {code} | {' | '.join(cells)} |")
    noise = [_noise(_at(ratios, system, error)) for system, error in columns]
    lines.append(f"| {NOISE} | {' | '.join(noise)} |")
    return "\n".join(lines)


def _at(ratios: pd.DataFrame, system: str, error: float) -> pd.DataFrame:
    near = np.isclose(ratios["error"].astype(float), error, rtol=1e-6, atol=0.0)
    return ratios[(ratios["problem"] == system) & near]


def _ratio(here: pd.DataFrame, code: str) -> str:
    """The least ratio of a code with its interval, as text; '-' when it took no part."""
    found = here[here["contender"].map(code_of).eq(code)]
    if found.empty:
        return "-"
    numbers = pd.to_numeric(found["ratio"], errors="coerce").dropna()
    if numbers.empty:
        return "not reached"
    row = found.loc[numbers.idxmin()]
    text = _two(numbers.min())
    bounds = [_two(row[name]) for name in ("low", "high") if known(row[name])]
    tie = "tie, " if row["outcome"] == TIE else ""
    return f"{tie}{text} ({'-'.join(bounds)})" if bounds else text


def _noise(here: pd.DataFrame) -> str:
    low, high = here["noise_low"].min(), here["noise_high"].max()
    return f"{low:.2f}-{high:.2f}" if known(float(low)) else "-"


def _two(number: float) -> str:
    return f"{float(f'{number:.2g}'):g}"


def by_machine(before: str, table: Callable[[pd.DataFrame], str], found: Sequence[Machine]) -> str:
    """A block for each kind of processor, by its widest vectors: a line on the machine, and the
    table; those of kinds without rows stay as they were, with their date and commit."""
    blocks = {kind: f"{line}\n\n{rest.strip()}" for line, kind, rest in BLOCK.findall(before)}
    for one in reversed(found):  # the report's own machine last: it counts for its kind
        counted = dependable(one.runs)
        blocks[one.kind] = f"On {one.title}:\n\n{table(matched(counted))}"
    return "\n\n".join(blocks[kind] for kind in sorted(blocks))


BLOCK = re.compile(r"(?m)^(On .* \([^()]*?, ([^,()]*)\), .*:)$\s*((?:^\|.*$\n?)*)")
ASKED = (1e-4, 1e-6, 1e-8)
PROBLEMS = (
    "outer solar system",
    "solar system without Pluto",
    "kepler e=0.6",
    "two bodies, e = 0.99",
    "HD 80606 and a companion",
    "Kozai-Lidov cycles",
    "a binary meets a star",
    "Burrau's problem",
    "free rigid body",
    "3D pendulum, m g = 9.81",
    "heavy top",
    "double pendulum",
    "chain of 5 rods",
    "skew arm",
    "floating arm",
    "henon-heiles",
    "fermi-pasta-ulam-tsingou",
)


def choices(runs: pd.DataFrame) -> str:
    """Markdown table from work_precision.csv: for each problem the fastest code at each error,
    and galvi's fastest method where it is another."""
    fastest = fastest_per_error(runs, ASKED)
    headings = " | ".join(f"error {heading(error)}" for error in ASKED)
    lines = [f"| problem | {headings} |", "|---" * (len(ASKED) + 1) + "|"]
    for problem in PROBLEMS:
        rows = fastest[fastest["problem"] == problem].set_index(["asked", "of"])
        if rows.empty:
            continue
        cells = []
        for error in ASKED:
            best, ours = rows.loc[(error, ALL)], rows.loc[(error, GALVI)]
            cell = _choice(best)
            if is_ours(str(best["contender"])):
                cell = f"**{cell}**"
            elif ours["contender"] != NOBODY:
                cell += f"; {_choice(ours)}"
            cells.append(cell)
        lines.append(f"| {label_of(problem).title} | {' | '.join(cells)} |")
    return "\n".join(lines)


def _choice(row: pd.Series) -> str:
    if row["contender"] == NOBODY:
        return "not reached"
    return f"{row['contender']}, {row['settings']}, {seconds(row['seconds'])}"


def evidence(root: Path, out: Path) -> str:
    """What speaks for galvi's numbers, counted: statements, checks, truths, planted faults, and
    the mutants where `make studies` has kept them."""
    claims = read_csv(out / "claims.csv")
    differing = int((claims["verdict"] != claims["expected"]).sum())
    faults = sum(len(claim.caught) for claim in CLAIMS)
    lines = [
        ("claims", f"{claims['id'].nunique()}, in {len(claims)} checks", "`galvi verify`"),
        ("checks with another verdict than expected", f"{differing}", "`galvi verify`"),
        ("stored truths, with script, engine, version and hash", f"{len(truths())}", "report"),
        ("planted faults that a claim must catch", f"{faults}", "`make test`, `make slow`"),
        ("mutants found by the tests", _mutants(out / "mutants.csv"), "`make mutants`"),
    ]
    rows = "\n".join(f"| {' | '.join(line)} |" for line in lines if line[1])
    return f"| evidence | number | from |\n|---|---|---|\n{rows}"


def _mutants(file: Path) -> str:
    if not file.exists():
        return ""
    rows, same = read_csv(file), equivalents()
    changes = rows[["file", "before", "after"]].itertuples(index=False, name=None)
    rows = rows[[change not in same for change in changes]]
    found = int((rows["outcome"] == KILLED).sum())
    return f"{found} of {len(rows)} ({found / len(rows):.1%}), those that compute the same left out"


def marks(name: str) -> tuple[str, str]:
    """The comments that enclose a generated table."""
    return f"<!-- {name}: python -m reports readme -->", f"<!-- end of {name} -->"


def table_of(page: str, name: str) -> str:
    """The text between the marks. Raises ValueError when a mark is missing."""
    begin, end = marks(name)
    _, found, rest = page.partition(begin)
    table, closed, _ = rest.partition(end)
    if not found or not closed:
        raise ValueError(f"The page must hold the marks {begin} and {end}.")
    return table.strip()


def _with(page: str, name: str, table: str) -> str:
    table_of(page, name)
    begin, end = marks(name)
    before, _, rest = page.partition(begin)
    _, _, after = rest.partition(end)
    return f"{before}{begin}\n{table}\n{end}{after}"


def with_statements(page: str) -> str:
    """The page with the count of the papers' statements renewed."""
    return _with(page, STATEMENTS, textwrap.fill(counted(statements()), WIDTH))


def renew(root: Path, out: Path) -> list[str]:
    """Write the tables of the report in ``out`` into README.md and docs/ of the checkout ``root``,
    and update their pictures; tables of rows that ``out`` does not hold stay. The names of those
    that were written.

    Raises ValueError for rows of the quick setting, whose runs are shorter than the pages say."""
    origins = read_origins(out)
    quick = [name for name in MEASURED if origins.get(name, {}).get("setting") == "quick"]
    if quick:
        raise ValueError(
            f"{' and '.join(quick)} in {out} {'is' if len(quick) == 1 else 'are'} of the quick "
            f"setting; run build without --quick first."
        )
    found = machines(out)
    problems = {name for one in found[:1] for name in one.runs["problem"]}
    readme = (root / "README.md").read_text()
    tables: dict[str, dict[str, str]] = {"README.md": {}, "docs/trust.md": {}, "docs/which.md": {}}
    for name, table, systems in ((SPEED, speed, SYSTEMS), (BODIES, bodies, BODY_SYSTEMS)):
        if problems >= systems.keys():
            tables["README.md"][name] = by_machine(table_of(readme, name), table, found)
    if problems >= set(PROBLEMS):
        tables["docs/which.md"][CHOICES] = choices(found[0].runs)
    if (out / "claims.csv").is_file():
        claims = read_csv(out / "claims.csv")
        tables["docs/trust.md"] |= {RESULTS: results(claims), EVIDENCE: evidence(root, out)}
    for name, texts in tables.items():
        page = (root / name).read_text()
        for table, text in texts.items():
            page = _with(page, table, text)
        write(root / name, with_statements(page) if STATEMENTS in page else page)
    for picture, figure in PICTURES.items():
        drawn = out / "figures" / f"{figure}.png"
        if drawn.is_file():
            write(root / picture, drawn.read_bytes())
    return [name for texts in tables.values() for name in texts]
