"""The commands that measure: verify, compare, build, studies and warm."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from reports.cli.invocation import (
    CONTENDER,
    FOLDER,
    QUICK,
    TIMEOUT,
    invocation,
    within,
)
from reports.cli.option_groups import Checking

if TYPE_CHECKING:
    from reports.results.section_result import SectionResult

ANEW = typer.Option(False, "--anew", help="Start over instead of resuming an interrupted build.")


def verify_claims(
    context: typer.Context,
    *,
    quick: bool = QUICK,
    checking: Checking,
    fail_under: float = typer.Option(
        100.0,
        "--fail-under",
        metavar="PERCENT",
        callback=within(0.0, 100.0, "a percentage"),
        help="Exit 1 when fewer of the checks come out as expected.",
    ),
    matching: str = typer.Option(
        "",
        "-k",
        metavar="EXPRESSION",
        help='Only claims with checks whose names match, as "pendulum and not V7".',
    ),
    failed: bool = typer.Option(
        False,
        "--last-failed",
        help="Only claims with checks that failed last time in this folder; all, where none did.",
    ),
    out: Path = FOLDER,
) -> int:
    """Check the claims; exit 1 when a verdict is not as expected."""
    from reports.build.verify import selected, verify
    from reports.results.own_problems import joined

    given = invocation(context)
    with joined(given.load(), checking.contender, checking.timeout) as suite:
        options = given.options(
            suite, quick, out, checking.claims, checking.require, fail_under=fail_under
        )
        passed = verify(suite, selected(suite, options, matching, failed)).passed
        faults = list(suite.faults())
    _tell(faults)
    return int(not passed or (bool(faults) and fail_under == 100.0))


def compare_methods(
    context: typer.Context,
    quick: bool = QUICK,
    only: str = typer.Option(
        "", "--only", metavar="top,kepler", help="Only problems with one of these in their names."
    ),
    contender: list[str] = CONTENDER,
    problem: list[str] = typer.Option(
        [],
        "--problem",
        metavar="package.module:function",
        help="A problem of your own to compare on, in place of the suite's; may be repeated.",
    ),
    timeout: float = TIMEOUT,
    out: Path = FOLDER,
) -> int:
    """Time galvi and other codes at matched error."""
    from reports.build.compare import compare, compare_sections
    from reports.results.own_problems import joined, narrowed, with_problems

    given = invocation(context)
    known = with_problems(given.load(), problem, bool(contender)) if problem else given.load()
    if only:
        try:
            known = narrowed(known, only, quick)
        except ValueError as error:
            raise typer.BadParameter(f"--only: {error}") from None
    below = "only" if only else "own" if problem else ""  # full results stay
    with joined(known, contender, timeout) as suite:
        options = given.options(suite, quick, out, below=below)
        failures = [
            *compare(suite, options).measured.failures,
            *_failures(compare_sections(suite, options)),
            *suite.faults(),
        ]
    _tell(failures)
    print(f"Tables are in {options.out / 'tables'}.")
    return int(bool(failures))


def build_all(
    context: typer.Context,
    *,
    quick: bool = QUICK,
    checking: Checking,
    anew: bool = ANEW,
    kept: bool = typer.Option(
        False, "--kept", help="Only draw and write the pages, from kept rows."
    ),
    single: bool = typer.Option(False, "--single-file", help="Also write all pages as one file."),
    out: Path = FOLDER,
) -> int:
    """Everything, with figures and the page; resumes an interrupted build."""
    from reports.build.build import build, build_kept
    from reports.results.own_problems import joined

    given = invocation(context)
    known = given.load()
    if kept:
        try:
            build_kept(known, given.options(known, quick, out), single)
        except ValueError as error:
            raise typer.BadParameter(f"--kept: {error}") from None
        return 0
    with joined(known, checking.contender, checking.timeout) as suite:
        options = given.options(
            suite, quick, out, checking.claims, checking.require, checking.contender, anew
        )
        verified, compared, sections = build(suite, options, single)
        failures = [*compared.measured.failures, *_failures(sections), *suite.faults()]
    _tell(failures)
    return int(not verified.passed or bool(failures))


def long_studies(
    context: typer.Context,
    only: str = typer.Option("", "--only", metavar="mutants,free-spin", help="Only these studies."),
    out: Path = FOLDER,
) -> int:
    """Run the long studies (hours); resumes after an interruption."""
    from reports.build.sections import run_long_forms

    given = invocation(context)
    suite = given.load()
    try:
        failures = run_long_forms(suite, given.options(suite, False, out), only)
    except ValueError as error:
        raise typer.BadParameter(f"--only: {error}") from None
    _tell(failures)
    return int(bool(failures))


def warm_kernels() -> int:
    """Compile the kernels of galvi.problems: about two minutes, once."""
    from reports.build.warm import warm

    warm()
    return 0


def _failures(sections: Iterable[SectionResult]) -> list[str]:
    return [section.failure for section in sections if section.failure]


def _tell(failures: Iterable[str]) -> None:
    """Each sentence once, on stderr."""
    for failure in dict.fromkeys(failures):
        print(failure, file=sys.stderr)
