"""Read the rows that earlier commands wrote, and lock the output folder during a build."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import pandas as pd
import typer
from filelock import FileLock, Timeout

from benchmarks.checks.claim import Claim, Row
from benchmarks.work_precision.dependable import dependable
from reports.results.claim_results import ClaimResult
from reports.results.comparison import Comparison
from reports.results.options import CONTENDER_PREFIX
from reports.results.rows import read_rows
from reports.results.section import Section
from reports.results.section_result import SectionResult
from reports.tables.claims_table import NUMBER_COLUMNS, ROW_COLUMNS
from reports.tables.number_format import is_finite

LOCK_FILE = ".build"  # in the output folder
CLAIMS_FILE = "claims.csv"
DURATIONS_FILE = "durations.csv"


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Lock the folder until the context or the process ends.

    Raises typer.BadParameter while another process holds the lock, and when the folder is not
    writable.
    """
    lock = FileLock(folder / LOCK_FILE)
    try:
        lock.acquire(blocking=False)
    except Timeout:
        raise typer.BadParameter(
            f"another build is at work in {folder}; wait until it ends, or choose another folder "
            "with --out."
        ) from None
    except OSError as error:
        raise typer.BadParameter(f"--out expects a folder to write in; {error}.") from None
    try:
        yield
    finally:
        lock.release()


def kept_claims(out: Path, claims: Sequence[Claim]) -> list[ClaimResult]:
    """The results of the claims with rows in claims.csv; verdicts are those of the stored rows.

    First come `claims`, in their order, then the claims of external integrators that are not among
    them. Rows of any other claim are left out, with a warning on stderr.
    """
    rows = read_rows(out / CLAIMS_FILE)
    if rows is None:
        return []
    times = durations(out)
    claim_results = []
    ids = {claim.id for claim in claims}
    unknown = [id for id in rows["id"].unique() if id not in ids]
    contender_ids = [id for id in unknown if id.startswith(CONTENDER_PREFIX)]
    if dropped := [id for id in unknown if id not in contender_ids]:
        print(
            f"{out / CLAIMS_FILE} must hold rows of claims of this version; received some of "
            f"{', '.join(dropped)}, which are left out. `verify` writes a file without them.",
            file=sys.stderr,
        )
    for claim in (*claims, *map(_without_study, contender_ids)):
        claim_rows = rows[rows["id"] == claim.id]
        if len(claim_rows):
            path = out / "frames" / f"{claim.id}.csv"
            table = read_rows(path)
            checked = tuple(_row(line) for line in claim_rows.to_dict("records"))
            date = str(claim_rows["date"].iloc[0])
            claim_results.append(
                ClaimResult(claim, table, checked, times.get(claim.id, float("nan")), date)
            )
    return claim_results


def _without_study(id: str) -> Claim:
    """A claim of an external integrator of which only the stored rows exist; its study is empty."""
    title = "an external integrator and the truth"
    return Claim(id, title, lambda *arguments: pd.DataFrame(), lambda measured: [])


def kept_comparison(out: Path) -> Comparison:
    """The stored tables of the last comparison; None for a table without a readable file."""
    runs = read_rows(out / "work_precision.csv", required_column="is_truth")
    return Comparison(None if runs is None else dependable(runs), read_rows(out / "cost.csv"))


def kept_sections(out: Path, sections: Sequence[Section]) -> list[SectionResult]:
    """A result for each study, with its stored rows; without a file its table is None."""
    section_results = []
    for section in sections:
        table = read_rows(out / f"{section.name}.csv")
        note = "" if table is not None else "No rows of it are kept."
        section_results.append(SectionResult(section, table, note))
    return section_results


def durations(out: Path) -> dict[str, float]:
    """Seconds that the study of each claim took when it was last measured."""
    table = read_rows(out / DURATIONS_FILE)
    return {} if table is None else dict(zip(table["claim"], table["seconds"], strict=True))


def _row(line: dict[str, object]) -> Row:
    """The row of a line of claims.csv; numbers that are not finite become None."""
    numbers = {name: line[name] if is_finite(line.get(name)) else None for name in NUMBER_COLUMNS}
    texts = {name: str(line[name]) for name in ROW_COLUMNS if name in line and name not in numbers}
    return Row(**texts, **numbers)  # type: ignore[arg-type]
