r"""numbers.tex: the numbers of README and pages as LaTeX macros.

``\ratioREBOUNDIASOneFiveOuterSolarSystemOneeMinusEight``: the time of IAS15 over galvi's at 1e-8.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pandas as pd

from benchmarks.store.cells import read_csv
from benchmarks.store.provenance import commit, today
from galvi.interop.citations import entries
from galvi.interop.release import galvi_version
from reports.results.origins import read_origins
from reports.tables.latex import escape
from reports.tables.number_format import is_finite, siunitx

DIGITS = ("Zero", "One", "Two", "Three", "Four", "Five", "Six", "Seven", "Eight", "Nine")
CLAIMS = "claims.csv"


def macro(*texts: str) -> str:
    """The name of a macro, of letters only: digits are spelt out, other characters start a word."""
    parts = re.split(r"[^A-Za-z0-9]+", re.sub(r"-(?=\d)", " minus ", " ".join(texts)))
    spelt = (re.sub(r"\d", lambda digit: DIGITS[int(digit[0])], part) for part in parts if part)
    joined = "".join(part[:1].upper() + part[1:] for part in spelt)
    return joined[:1].lower() + joined[1:]


def numbers(out: Path) -> str:
    """The text of numbers.tex for the report in a folder; a comment explains each number.

    Raises
    ------
    FileNotFoundError
        If the folder has no claims.csv.
    """
    claims, ratios = read_csv(out / CLAIMS), out / "tables" / "ratios.csv"
    lines = [*_of_origin(out), *_of_claims(claims)]
    lines += _of_ratios(read_csv(ratios)) if ratios.is_file() else []
    macros = {name: (value, meaning) for name, value, meaning in reversed(lines)}
    return "% requires siunitx\n" + "".join(
        f"\\newcommand{{\\{name}}}{{{value}}} % {' '.join(meaning.split())}\n"
        for name, (value, meaning) in reversed(macros.items())
    )


def bibliography() -> str:
    """The text of cite.bib, for any style of BibTeX: galvi, the papers, and the compared codes."""
    texts = "\n\n".join(entries().values()).replace("VERSION", galvi_version())
    entry = f"@misc{{galvi,\n  date = {{{today()}}},\n  note = {{commit {commit()[:12]}}},"
    return texts.replace("@software{galvi,", entry).replace("@software{", "@misc{") + "\n"


Line = tuple[str, str, str]  # name, value and meaning of a macro


def _of_origin(out: Path) -> Iterator[Line]:
    origin = read_origins(out).get(CLAIMS, {})
    for name in ("date", "commit", "cpu", "python", "numpy", "numba", "rebound", "mujoco-core"):
        if origin.get(name):
            text = origin[name][:12] if name == "commit" else origin[name]
            yield macro("galvi", name), escape(text), f"{name} of the claims"


def _of_claims(claims: pd.DataFrame) -> Iterator[Line]:
    yield "galviChecks", f"{len(claims)}", "checks"
    yield "galviClaims", f"{claims['id'].nunique()}", "claims and agreements"
    for verdict, count in claims["verdict"].value_counts().items():
        yield macro("galvi", str(verdict)), f"{count}", f"checks: {verdict}"
    for row in claims.itertuples():
        if is_finite(row.measured):
            yield (
                macro("claim", str(row.id), str(row.quantity)),
                f"\\num{{{siunitx(row.measured, row.uncertainty)}}}",
                f"{row.id}, {row.quantity}: {row.verdict}",
            )


def _of_ratios(ratios: pd.DataFrame) -> Iterator[Line]:
    times = ratios.assign(ratio=pd.to_numeric(ratios["ratio"], errors="coerce"))
    for row in times[times["ratio"].notna()].itertuples():
        error = f"{row.error:.0e}".replace("e-0", "e-")
        yield (
            macro("ratio", row.contender, row.problem, error),
            f"\\num{{{float(f'{row.ratio:.2g}'):g}}}",
            f"time of {row.contender} over galvi's, {row.problem}, at {error}",
        )
