"""The commands that measure: verify, compare, build, studies and warm."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from typing import Annotated

import typer

from reports.cli.endings import as_usage_error
from reports.cli.options import (
    Claims,
    Contenders,
    Out,
    Quick,
    Require,
    Timeout,
    is_typed,
    options_of,
)
from reports.results.options import OUT


def verify_claims(
    context: typer.Context,
    quick: Quick = False,
    claims: Claims = None,
    require: Require = None,
    contender: Contenders = None,
    timeout: Timeout = None,
    fail_under: Annotated[
        float,
        typer.Option(
            metavar="PERCENT",
            min=0,
            max=100,
            help="Exit 1 when a smaller share of the checks is as expected.",
        ),
    ] = 100.0,
    matching: Annotated[
        str,
        typer.Option(
            "-k",
            metavar="EXPRESSION",
            help='Only claims with a check whose name matches, as "pendulum and not V7".',
        ),
    ] = "",
    failed: Annotated[
        bool,
        typer.Option(
            "--last-failed",
            help="Only claims that failed last time in this folder, or all if none did.",
        ),
    ] = False,
    out: Out = OUT,
) -> int:
    """Check the claims. Exit 1 when a verdict is not as expected."""
    from reports.build.verify import selected, verify
    from reports.results.own_problems import with_contenders

    with with_contenders(context.obj.load(), contender or (), timeout) as suite:
        options = options_of(
            context, suite, out, claims, require, quick=quick, fail_under=fail_under
        )
        passed = verify(suite, selected(suite, options, matching, failed)).holds
        has_faults = _print_failures(suite.faults())
    return int(not passed or (has_faults and fail_under == 100.0))


def compare_methods(
    context: typer.Context,
    quick: Quick = False,
    only: Annotated[
        str,
        typer.Option(
            metavar="top,kepler", help="Only problems with one of these texts in their names."
        ),
    ] = "",
    contender: Contenders = None,
    problem: Annotated[
        list[str] | None,
        typer.Option(
            metavar="package.module:function",
            help="A problem of yours, in place of the suite's; may be repeated.",
        ),
    ] = None,
    timeout: Timeout = None,
    out: Out = OUT,
) -> int:
    """Time galvi and other codes at matched error."""
    from reports.build.compare import compare
    from reports.build.sections import study
    from reports.results.own_problems import with_contenders, with_problems, with_selected_problems
    from reports.results.section_result import runnable

    full_suite = context.obj.load()
    if problem:
        full_suite = with_problems(full_suite, problem, bool(contender))
    if only:
        with as_usage_error(ValueError, prefix="--only: "):
            full_suite = with_selected_problems(full_suite, only, quick)
    if not is_typed(context, "out"):
        out /= "only" if only else "own" if problem else ""  # full results stay
    with with_contenders(full_suite, contender or (), timeout) as suite:
        options = options_of(context, suite, out, quick=quick)
        studies = runnable([section for section in suite.sections if section.compared])
        failures = [
            *compare(suite, options).failures,
            *(section.failure for section in study(suite, options, studies)),
            *suite.faults(),
        ]
    print(f"Tables are in {options.out / 'tables'}.")
    return int(_print_failures(failures))


def build_all(
    context: typer.Context,
    quick: Quick = False,
    claims: Claims = None,
    require: Require = None,
    contender: Contenders = None,
    timeout: Timeout = None,
    anew: Annotated[
        bool, typer.Option("--anew", help="Start over instead of resuming an interrupted build.")
    ] = False,
    from_rows: Annotated[
        bool,
        typer.Option(
            "--kept", help="Measure nothing: draw and write pages from rows of earlier runs."
        ),
    ] = False,
    single: Annotated[
        bool, typer.Option("--single-file", help="Also write all pages into one file.")
    ] = False,
    tutorials: Annotated[
        bool,
        typer.Option(
            "--tutorials",
            help="With --kept: also run the tutorials' code, and exit 1 when Sphinx warns.",
        ),
    ] = False,
    out: Out = OUT,
) -> int:
    """Measure everything and write the pages. Resumes an interrupted build."""
    from reports.build.build import build, build_kept
    from reports.results.own_problems import with_contenders

    full_suite = context.obj.load()
    if from_rows:
        with as_usage_error(ValueError, prefix="--kept: "):
            warnings = build_kept(
                full_suite, options_of(context, full_suite, out), single, tutorials
            )
        return int(tutorials and bool(warnings))
    if tutorials:
        raise typer.BadParameter("--tutorials requires --kept.")
    with with_contenders(full_suite, contender or (), timeout) as suite:
        options = options_of(
            context,
            suite,
            out,
            claims,
            require,
            quick=quick,
            contenders=tuple(contender or ()),
            anew=anew,
        )
        verified, comparison, sections = build(suite, options, single)
        section_failures = [section.failure for section in sections]
        failures = [*comparison.failures, *section_failures, *suite.faults()]
    return int(_print_failures(failures) or not verified.holds)


def long_studies(
    context: typer.Context,
    only: Annotated[str, typer.Option(metavar="trees,free-spin", help="Only these studies.")] = "",
    out: Out = OUT,
) -> int:
    """Run the long studies (hours). Resumes after an interruption."""
    from reports.build.sections import run_long_forms

    suite = context.obj.load()
    with as_usage_error(ValueError, prefix="--only: "):
        failures = run_long_forms(suite, options_of(context, suite, out), only)
    return int(_print_failures(failures))


def warm_kernels() -> int:
    """Compile the kernels of galvi.problems. Takes about two minutes, once."""
    from reports.build.warm import warm

    warm()
    return 0


def _print_failures(failures: Iterable[str]) -> bool:
    """Print each distinct sentence on stderr, omitting ""; returns whether any was printed."""
    sentences = dict.fromkeys(filter(None, failures))
    for sentence in sentences:
        print(sentence, file=sys.stderr)
    return bool(sentences)
