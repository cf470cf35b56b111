"""`verify`: check the claims and agreements; write and print the verdicts, for people and for CI.

claims.csv    every row; rows of claims that were not selected are kept, with their dates
durations.csv seconds that the study of each claim took
verify.xml    JUnit XML for CI services
verify.md     the same in Markdown; also appended to the CI job summary
verify-*.json measured errors, for services that plot them over time
frames/       the studies' tables
tables/       claims and convergence
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, field, replace

import pandas as pd
import typer
from _pytest.mark.expression import Expression

from benchmarks.checks.claim import AGREEMENT, Claim, Row
from benchmarks.checks.coverage import coverage
from benchmarks.store.atomic import write
from benchmarks.store.cells import as_csv
from reports.build.kept import CLAIMS_FILE, DURATIONS_FILE, durations
from reports.build.terminal import show, show_changes
from reports.build.workers import study_in_workers
from reports.figures.catalogue.all import FIGURES
from reports.results.cache import BuildCache, Study
from reports.results.claim_results import NOT_RUN, ClaimResult, check, claim_studies
from reports.results.junit import JUnitCase, Outcome, github_annotations, junit_xml
from reports.results.metrics import row_metrics, write_metrics
from reports.results.options import Options
from reports.results.origins import note_origin, read_origins
from reports.results.own_problems import Engines
from reports.results.progress import Studies
from reports.results.rows import merge_rows, read_rows, read_with_origin, with_origin
from reports.results.suite import Suite
from reports.results.summary import Summary, summary, write_job_summary
from reports.tables.claims_table import READABLE_COLUMNS, claims_frame, convergence_frame
from reports.tables.number_format import is_finite, plain
from reports.tables.writing import as_markdown, write_table

SUMMARY_COLUMNS = ["id", "quantity", "bound", "measured", "uncertainty", "verdict", "expected"]
PROPERTY_FIELDS = ("source", "claimed", "setup", "reference", "reason")  # of a row, in verify.xml
CHANGE_COLUMNS = ["claim", "quantity", "what", "before", "now"]
MAX_STANDARD_ERRORS = 2.0  # standard errors of a difference, up to which two numbers count as equal
# Relative tolerance of values without uncertainty: round-off differs by machine:
RELATIVE_TOLERANCE = 0.1


@dataclass(frozen=True, eq=False)
class Verified:
    """The result of `verify`.

    Attributes
    ----------
    changed
        differences from the previous rows
    fail_under
        percent of the checks that must come out as expected
    definitions
        id of the claim of an external integrator -> file and line of its class
    """

    checked: tuple[ClaimResult, ...]
    engines: Engines
    changed: pd.DataFrame
    fail_under: float = 100.0
    definitions: Mapping[str, tuple[str, int]] = field(default_factory=dict)

    @property
    def summary(self) -> Summary:
        """The summary of all rows."""
        return summary(self.checked)

    @property
    def holds(self) -> bool:
        """Whether enough verdicts are the expected ones, and every required engine is there."""
        return self.summary.holds(self.fail_under) and not self.engines.missing

    @property
    def share_sentence(self) -> str:
        """A sentence on the percentage of expected verdicts; "" where `fail_under` is 100."""
        if self.fail_under == 100.0:
            return ""
        return (
            f"{self.summary.percent_expected:.4g} % of the checks came out as expected; "
            "--fail-under asks for "
            f"{self.fail_under:.4g} %."
        )

    def cases(self) -> list[JUnitCase]:
        """The test cases: one for each row and engine, and a failure for each unfounded statement,
        for stated errors of orders that do not cover, and where nothing was measured.

        An engine that is required and absent is a failure too.
        """
        rows = self.summary.rows
        cases = [
            _row_case(
                row,
                claim_result.seconds / len(claim_result.rows),
                self.definitions.get(row.id, ("", 0)),
            )
            for claim_result in self.checked
            for row in claim_result.rows
        ]
        cases += [_engine_case(name, self.engines) for name in self.engines.absence]
        failures = [("printed statement", sentence) for sentence in self.summary.unfounded]
        if not coverage(rows).is_plausible:
            failures.append(("stated errors of orders", str(coverage(rows))))
        if all(row.verdict == NOT_RUN for row in rows):
            failures.append(("measured rows", "nothing was measured"))
        return cases + [
            JUnitCase("statements", name, 0.0, "failure", why) for name, why in failures
        ]

    def markdown(self) -> str:
        """Passed or failed, unexpected verdicts, changes, and all rows in a collapsed section."""
        rows, differing = self.summary.rows, self.summary.differing
        blocks = [f"## verify: {'passed' if self.holds else 'failed'}", str(self.summary)]
        blocks += filter(None, [self.share_sentence])
        blocks += [f"- {sentence}" for sentence in self.engines.sentences()]
        if differing:
            table = claims_frame(differing)[[*SUMMARY_COLUMNS, "reason"]]
            blocks += ["### Not as expected", as_markdown(table)]
        if len(self.changed):
            blocks += ["### Changed since the rows before", as_markdown(self.changed)]
        all_rows = as_markdown(claims_frame(rows)[SUMMARY_COLUMNS])
        blocks += [f"<details><summary>All {len(rows)} checks</summary>\n\n{all_rows}\n</details>"]
        return "\n\n".join(part.rstrip("\n") for part in blocks) + "\n"


def selected(suite: Suite, options: Options, expression: str, only_failed: bool) -> Options:
    """The options with fewer claims.

    Parameters
    ----------
    expression
        words of a check's name, source or claim, with `and`, `or`, `not`; "" for any
    last_failed
        only claims that have failed in this folder; all, where none of them has

    Notes
    -----
    Raises typer.BadParameter where no check matches.
    """
    claims = [claim for claim in suite.claims if not options.claims or claim.id in options.claims]
    if expression:
        claims = _matching(claims, expression)
    rows = read_rows(options.out / CLAIMS_FILE, "id") if only_failed else None
    if rows is not None:
        failed = set(rows["id"][rows["verdict"] != rows["expected"]])
        claims = [claim for claim in claims if claim.id in failed] or claims
    return replace(options, claims=tuple(claim.id for claim in claims))


def _matching(claims: Sequence[Claim], expression: str) -> list[Claim]:
    """The claims with a check that matches a pytest expression.

    Raises typer.BadParameter for an invalid expression, and where no check matches.
    """
    try:
        compiled = Expression.compile(expression)
    except Exception as error:  # of a class that depends on the version of pytest
        raise typer.BadParameter(f"-k {expression} is no expression of pytest: {error}.") from None
    matching = [
        claim
        for claim in claims
        if any(
            compiled.evaluate(lambda word, text=text: word.lower() in text)
            for text in _texts(claim)
        )
    ]
    if not matching:
        raise typer.BadParameter(
            f"-k {expression} leaves no check; it takes words of names, ids and sources."
        )
    return matching


def _texts(claim: Claim) -> list[str]:
    """A text for each check of a claim, lower case, to match against: id, quantity and source.

    A claim whose checks depend on its measurement has a single text, with its title.
    """
    try:
        rows = claim.check(pd.DataFrame())
    except Exception:  # reported when the claim is measured
        rows = []
    names = [(row.quantity, row.source) for row in rows] or [(claim.title,)]
    return [" ".join((claim.id, *texts)).lower() for texts in names]


def verify(
    suite: Suite,
    options: Options,
    cache: BuildCache | None = None,
    other_studies: Sequence[Study] = (),
) -> Verified:
    """Check the selected claims, or all; write, print and return the results.

    Parameters
    ----------
    cache
        the build's result cache; None stores nothing
    beside
        other studies of the build; those without timings are measured in the same worker processes
        as the claims, and their tables are left in `cache`
    """
    cache = cache or BuildCache()
    claims = [claim for claim in suite.claims if not options.claims or claim.id in options.claims]
    engines = Engines(suite.engines(), options.require)
    progress = Studies(len(claims) + len(other_studies))
    in_workers = study_in_workers([*claim_studies(claims, options.quick), *other_studies], cache)
    with progress, closing(in_workers) as finished:
        for study, seconds in finished:
            progress.finished(study.label, study.title, seconds)
    checked = check(claims, options.quick, cache)
    changed = _write(checked, suite, options)
    verified = Verified(tuple(checked), engines, changed, options.fail_under, suite.definitions)
    text, cases, title = verified.markdown(), verified.cases(), f"{options.called} verify"
    write(options.out / "verify.xml", junit_xml(title, {title: cases}))
    write(options.out / "verify.md", text)
    write_metrics(options.out, "verify", row_metrics(verified.summary.rows))
    write_job_summary(text)
    show(verified.summary)
    show_changes(changed)
    annotations = [] if verified.holds else github_annotations(cases)
    for line in filter(None, [*engines.sentences(), verified.share_sentence, *annotations]):
        print(line)
    return verified


def _write(checked: Sequence[ClaimResult], suite: Suite, options: Options) -> pd.DataFrame:
    """Write the tables; returns the changes."""
    provenance, tables = suite.provenance(options.command), options.out / "tables"
    origin = {**provenance, "setting": "quick" if options.quick else "default"}
    origin_before = read_origins(options.out).get(CLAIMS_FILE, {})
    dates = {
        claim_result.claim.id: claim_result.run or origin.get("date", "")
        for claim_result in checked
    }
    ids = [claim.id for claim in suite.claims]

    def mark_rows(table: pd.DataFrame, key: str) -> pd.DataFrame:
        return with_origin(table.assign(date=[dates[name] for name in table[key]]), origin)

    new_rows = mark_rows(
        claims_frame(row for claim_result in checked for row in claim_result.rows), "id"
    )
    old_rows = read_with_origin(options.out / CLAIMS_FILE, "id", origin_before)
    merged_rows = merge_rows(old_rows, new_rows, "id", dates, ids)
    write(options.out / CLAIMS_FILE, as_csv(merged_rows))
    note_origin(options.out, CLAIMS_FILE, provenance, options.quick)
    write_table(tables, "claims", merged_rows, merged_rows[list(READABLE_COLUMNS)], origin)
    fits = mark_rows(convergence_frame(checked, FIGURES), "claim")
    fits_before = read_with_origin(tables / "convergence.csv", "claim", origin_before)
    write_table(
        tables, "convergence", merge_rows(fits_before, fits, "claim", dates, ids), origin=origin
    )
    for claim_result in checked:
        path = options.out / "frames" / f"{claim_result.claim.id}.csv"
        if claim_result.table is None:
            path.unlink(missing_ok=True)
        else:
            write(path, as_csv(claim_result.table))
    if not options.quick:  # whose shorter runs do not replace the times of full ones
        seconds = {
            claim_result.claim.id: claim_result.seconds
            for claim_result in checked
            if claim_result.table is not None
        }
        lines = (durations(options.out) | seconds).items()
        write(
            options.out / DURATIONS_FILE, as_csv(pd.DataFrame(lines, columns=["claim", "seconds"]))
        )
    return changes(old_rows, new_rows)


def changes(before: pd.DataFrame | None, now: pd.DataFrame) -> pd.DataFrame:
    """The changes since earlier rows of the same claims and setting, as texts in columns
    CHANGE_COLUMNS.

    A changed number is listed where `differs` is true. Empty where `before` is None.
    """
    if before is None:
        return pd.DataFrame(columns=CHANGE_COLUMNS)
    is_comparable = before["id"].isin(now["id"]) & before["setting"].isin(now["setting"])
    old_rows, new_rows, lines = _by_check(before[is_comparable]), _by_check(now), []
    for key, new in new_rows.items():
        old = old_rows.get(key)
        if old is None:
            lines += [(*key, "new", "", f"{new['verdict']}, {_number(new)}")] * bool(old_rows)
            continue
        if old["verdict"] != new["verdict"]:
            lines.append((*key, "verdict", old["verdict"], new["verdict"]))
        if differs(old["measured"], old["uncertainty"], new["measured"], new["uncertainty"]):
            lines.append((*key, "measured", _number(old), _number(new)))
    removed = [key for key in old_rows if key not in new_rows]
    lines += [(*key, "gone", old_rows[key]["verdict"], "") for key in removed]
    return pd.DataFrame(lines, columns=CHANGE_COLUMNS)


def _by_check(rows: pd.DataFrame) -> dict[tuple[str, str], pd.Series]:
    return {(row["id"], row["quantity"]): row for _, row in rows.iterrows()}


def differs(old: float, old_error: float, new: float, new_error: float) -> bool:
    """Whether two measured numbers differ significantly.

    They do if they differ by more than MAX_STANDARD_ERRORS standard errors of the difference, or by
    more than RELATIVE_TOLERANCE of the larger one if neither has an uncertainty; also if just one
    number is finite. An uncertainty that is NaN or None is unknown.
    """
    if not (is_finite(old) and is_finite(new)):
        return is_finite(old) != is_finite(new)
    errors = [error for error in (old_error, new_error) if is_finite(error)]
    tolerance = (
        MAX_STANDARD_ERRORS * math.hypot(*errors)
        if errors
        else RELATIVE_TOLERANCE * max(abs(old), abs(new))
    )
    return abs(new - old) > tolerance


def _number(row: pd.Series) -> str:
    measured, error = plain(row["measured"], 4), plain(row["uncertainty"], 2)
    return f"{measured} -+ {error}" if measured and error else measured or "no number"


def _row_case(row: Row, seconds: float, defined_at: tuple[str, int]) -> JUnitCase:
    """A row's case: "failure" for a verdict other than the expected one, "error" for a row that
    should have been measured but was not, "skipped" for one that was expected not to run."""
    measured, error = plain(row.measured, 6) or "nothing", plain(row.uncertainty, 2)
    outcome: Outcome = "passed"
    message = ""
    if row.verdict == NOT_RUN:
        outcome = "skipped" if row.expected == NOT_RUN else "error"
        message = f"not run: {row.reason}"
    elif row.verdict != row.expected:
        outcome = "failure"
        message = (
            f"{row.verdict}, expected was {row.expected}: measured {measured}, bound {row.bound}"
        )
    properties = (
        ("measured", f"{measured}{f' -+ {error}' if error else ''}"),
        ("bound", row.bound or "none"),
        ("verdict", row.verdict),
        ("expected", row.expected or "a verdict"),
        *((name, getattr(row, name)) for name in PROPERTY_FIELDS),
    )
    group = f"{row.source if row.source == AGREEMENT else 'claim'}.{row.id}"
    return JUnitCase(
        group, row.quantity, seconds, outcome, message, properties=properties, defined_at=defined_at
    )


def _engine_case(name: str, engines: Engines) -> JUnitCase:
    why = engines.absence[name]
    if not why:
        return JUnitCase("engines", name)
    outcome: Outcome = "failure" if name in engines.required else "skipped"
    return JUnitCase("engines", name, 0.0, outcome, f"{name} is absent: {why}")
