"""Update tables and pictures of README.md and docs/ from the output of `build`."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd

from benchmarks.claims import CLAIMS
from benchmarks.claims.statements import statements, status_counts
from benchmarks.statistics.paired import TIE
from benchmarks.store.atomic import write
from benchmarks.store.cells import read_csv
from benchmarks.work_precision.asked import code_of
from benchmarks.work_precision.fronts import ratios
from benchmarks.work_precision.labels import label_of
from references.stored.provenance import truths
from reports.results.machines import Machine, machines
from reports.results.origins import read_origins
from reports.tables.comparison_tables import (
    ALL,
    GALVI,
    NOBODY,
    NOISE_LABEL,
    fastest_per_error,
    heading,
    is_galvi,
    matched,
)
from reports.tables.number_format import is_finite, plain, seconds, with_uncertainty

SPEED, BODIES, STATEMENTS = "speed", "bodies", "statements"
RESULTS, EVIDENCE, CHOICES = "results", "evidence", "choices"
PAGES = {
    "README.md": {SPEED, BODIES, STATEMENTS},
    "docs/trust.md": {RESULTS, EVIDENCE, STATEMENTS},
    "docs/which.md": {CHOICES},
}
WIDTH = 101  # columns of the README
ROW_FILES = ("work_precision.csv", "claims.csv")  # files of a report from which tables are made
PICTURES = {  # path in the repository -> name of a figure of the report
    "reports/inner_planets.png": "fig-2-14",
    "docs/headline_rebound.png": "headline-rebound",
    "docs/headline_mujoco.png": "headline-mujoco",
    "docs/headline_clock.png": "headline-clock",
}
HEADLINES = (
    ("V3", "base of the one-step error"),
    ("V7", "what the order of the angular momentum error along the curve gains with n, 100 steps"),
    ("V9", "largest distance to IAS15 on the curve of the inner planets [mean distance], n = 25"),
    ("V23", "order, N = 3, w away from 0"),
    ("L3", "least order over n - 1, n, n + 1, 2 n Gauss points, n = 4"),
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


TIMES = {
    SPEED: ("position error", CODES, SYSTEMS),
    BODIES: ("attitude error", BODY_CODES, BODY_SYSTEMS),
}


def headline_table(claims: pd.DataFrame) -> str:
    """The headline rows of claims.csv as a Markdown table.

    Raises
    ------
    KeyError
        For a headline that is not among the rows.
    """
    rows = claims.set_index(["id", "quantity"]).loc[list(HEADLINES)].reset_index()
    slack = [f", slack x{plain(number, 2)}" if number > 1.0 else "" for number in rows["slack"]]
    return markdown(
        pd.DataFrame(
            {
                "claim": rows["id"] + ", " + rows["source"],
                "quantity": rows["quantity"],
                "the paper": rows["claimed"],
                "measured": map(with_uncertainty, rows["measured"], rows["uncertainty"]),
                "verdict": rows["verdict"] + slack,
            }
        )
    )


def markdown(table: pd.DataFrame) -> str:
    """The table as Markdown without padding, so that a changed cell changes only its own line."""
    lines = [f"| {' | '.join(line)} |" for line in (table.columns, *table.fillna("").to_numpy())]
    return "\n".join([lines[0], "|---" * len(table.columns) + "|", *lines[1:]])


def times_table(ratios: pd.DataFrame, quantity: str, codes: Sequence[str], systems: Systems) -> str:
    """A Markdown table from ratios.csv: times relative to galvi's best at equal error.

    A cell is a code's smallest ratio, with its interval; "-" if the code took no part.
    """
    titles = {
        (system, error): f"{title}, {error:.0e}"
        for system, (title, errors) in systems.items()
        for error in errors
    }
    rows = ratios.assign(
        code=ratios["contender"].map(code_of),
        ratio=pd.to_numeric(ratios["ratio"], errors="coerce"),
    )
    best_ratios = rows.sort_values("ratio").drop_duplicates(["problem", "error", "code"])
    best_ratios["cell"] = best_ratios.apply(_ratio_cell, axis="columns")
    cells = best_ratios.pivot(index="code", columns=["problem", "error"], values="cell")
    noise = rows.groupby(["problem", "error"]).agg({"noise_low": "min", "noise_high": "max"})
    cells.loc[NOISE_LABEL] = noise.dropna().apply(
        "{noise_low:.2f}-{noise_high:.2f}".format_map, axis=1
    )
    table = cells.reindex(index=[*codes, NOISE_LABEL], columns=list(titles)).astype(object)
    table = table.fillna("-").set_axis(list(titles.values()), axis="columns")
    return markdown(table.rename_axis(quantity).reset_index())


def _ratio_cell(row: pd.Series) -> str:
    if not is_finite(row["ratio"]):
        return NOBODY
    tie = "tie, " if row["outcome"] == TIE else ""
    bounds = [plain(row[name], 2) for name in ("low", "high") if is_finite(row[name])]
    return f"{tie}{plain(row['ratio'], 2)}" + (f" ({'-'.join(bounds)})" if bounds else "")


def by_machine(report: Sequence[Machine], *columns: Any) -> str:
    """A block for each kind of processor: a line on the machine, and its table of `times_table`.

    Of several machines of a kind, the first in `report` is shown.
    """
    blocks = {
        machine.vector_set: f"On {machine.title}:\n\n{times_table(matched(machine.runs), *columns)}"
        for machine in reversed(report)
    }
    return "\n\n".join(blocks[kind] for kind in sorted(blocks))


ASKED_ERRORS = (1e-4, 1e-6, 1e-8)
CHOICE_PROBLEMS = (
    "outer solar system",
    "solar system without Pluto",
    "two bodies, e = 0.99",
    "Burrau's problem",
    "free rigid body",
    "3D pendulum, m g = 9.81",
    "heavy top",
    "double pendulum",
)


def choices(runs: pd.DataFrame) -> str:
    """A Markdown table from work_precision.csv: for each problem the fastest code at each error,
    and galvi's fastest method if that is another one."""
    table = fastest_per_error(ratios(runs, ASKED_ERRORS), runs)
    fastest = table.set_index(["problem", "asked", "of"]).sort_index()
    lines = [
        {"problem": label_of(problem).title}
        | {
            f"error {heading(error)}": _choice(fastest.loc[problem, error])
            for error in ASKED_ERRORS
        }
        for problem in CHOICE_PROBLEMS
        if problem in fastest.index
    ]
    return markdown(pd.DataFrame(lines))


def _choice(rows: pd.DataFrame) -> str:
    """The fastest contender of all, in bold type if it is galvi's; else followed by galvi's."""
    texts = {
        of: f"{row['contender']}, {row['settings']}, {seconds(row['seconds'])}"
        for of, row in rows.iterrows()
        if row["contender"] != NOBODY
    }
    if ALL not in texts:
        return NOBODY
    if is_galvi(texts[ALL]):
        return f"**{texts[ALL]}**"
    return "; ".join(texts[of] for of in (ALL, GALVI) if of in texts)


def evidence(out: Path) -> str:
    """A Markdown table with the numbers of claims, checks, truths and planted faults."""
    claims = read_csv(out / "claims.csv")
    differing = int((claims["verdict"] != claims["expected"]).sum())
    faults = sum(len(claim.caught) for claim in CLAIMS)
    lines = [
        ("claims", f"{claims['id'].nunique()}, in {len(claims)} checks", "`galvi verify`"),
        ("checks with another verdict than expected", f"{differing}", "`galvi verify`"),
        ("stored truths, with script, engine, version and hash", f"{len(truths())}", "report"),
        ("planted faults that a claim must catch", f"{faults}", "`make test`, `make slow`"),
    ]
    return markdown(pd.DataFrame(lines, columns=["evidence", "number", "from"]))


def marks(name: str) -> tuple[str, str]:
    """The comments that enclose a generated table."""
    return f"<!-- {name}: python -m reports readme -->", f"<!-- end of {name} -->"


def with_table(page: str, name: str, table: str) -> str:
    """The page with `table` as its text between the marks of `name`.

    Raises
    ------
    ValueError
        When a mark is missing.
    """
    begin, end = marks(name)
    before, _, after = page.partition(begin)
    _, closed, after = after.partition(end)
    if not closed:
        raise ValueError(f"The page must hold the marks {begin} and {end}.")
    return f"{before}{begin}\n{table}\n{end}{after}"


def renew(root: Path, out: Path) -> list[str]:
    """Write the tables of the report in ``out`` into README.md and docs/ of the checkout ``root``,
    and update their pictures.

    Tables whose rows ``out`` does not hold are left unchanged. The text STATEMENTS is always
    written. Returns the names of the other texts that were written.

    Raises
    ------
    ValueError
        For rows of the quick setting, whose runs are shorter than the pages say, and for a page
        without the marks of one of its tables.
    """
    origins = read_origins(out)
    quick = [name for name in ROW_FILES if origins.get(name, {}).get("setting") == "quick"]
    if quick:
        raise ValueError(
            f"{out} holds {' and '.join(quick)} of the quick setting; run build without --quick "
            "first."
        )
    report = machines(out)
    problems = set(report[0].runs["problem"]) if report else set()
    tables = {STATEMENTS: textwrap.fill(status_counts(statements()), WIDTH)}
    for name, columns in TIMES.items():
        if problems >= columns[-1].keys():
            tables[name] = by_machine(report, *columns)
    if problems >= set(CHOICE_PROBLEMS):
        tables[CHOICES] = choices(report[0].runs)
    if (out / "claims.csv").is_file():
        tables |= {RESULTS: headline_table(read_csv(out / "claims.csv")), EVIDENCE: evidence(out)}
    for name, page_tables in PAGES.items():
        page = (root / name).read_text(encoding="utf-8")
        for table in page_tables & tables.keys():
            page = with_table(page, table, tables[table])
        write(root / name, page)
    for picture, figure in PICTURES.items():
        picture_path = out / "figures" / f"{figure}.png"
        if picture_path.is_file():
            write(root / picture, picture_path.read_bytes())
    return [name for name in tables if name != STATEMENTS]
