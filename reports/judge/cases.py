"""The test cases of a judgement, for CI."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from benchmarks.applications.judging.judgement import Judgement
from reports.judge.sentences import own_run, truth
from reports.results.junit import JUnitCase, Outcome
from reports.tables.number_format import readable


def junit_suites(
    found: Judgement, file: str, error: float | None
) -> Mapping[str, Sequence[JUnitCase]]:
    """One suite, of the file, with the case of the user's own run and that of the truth.

    Parameters
    ----------
    error
        that was asked for; None for none, and then nothing is a failure, as nothing is for the
        status of the command

    Notes
    -----
    A truth that no second source confirms to within the error is "skipped".
    """
    return {file: [_own_run(found, file, error), _truth(found, file)]}


def _own_run(found: Judgement, file: str, error: float | None) -> JUnitCase:
    length = found.kind.unit(found.problem, "length")
    seconds = found.own["seconds"] if math.isfinite(found.own["seconds"]) else 0.0
    said = " ".join(own_run(found))
    outcome: Outcome = "passed" if found.passed else "failure"
    message = "" if found.passed else said
    if error is None:
        outcome, message = "skipped", "No --error was asked for."
    asked = "its error" if error is None else f"an error of at most {readable(error)}{length}"
    name = f"{found.own['integrator']}: {asked}"
    return JUnitCase(file, name, seconds, outcome, message, said)


def _truth(found: Judgement, file: str) -> JUnitCase:
    said = truth(found)
    confirmed = found.truth_agreement <= found.error and math.isinf(found.trusted_until)
    outcome: Outcome = "passed" if confirmed else "skipped"
    name = "the truth is confirmed by a second source"
    return JUnitCase(file, name, 0.0, outcome, "" if confirmed else said, said)
