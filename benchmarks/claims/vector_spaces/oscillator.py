"""The harmonic oscillator of M 6.1, shared by V17 and V18."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import galvi
from benchmarks.claims.kit import Case, MakeMethod, Problem, Report, refine
from references.closed_forms.oscillator import OSCILLATOR

DURATION, LARGEST = 8.0, 0.8
FLOOR = 4e-15  # of positions of size 1; 2e-15 was measured at T = 8, in one step and in 2560
QUANTITY = "one-step error"


def problem() -> Problem:
    """The oscillator with m = k = 1, from u = 1 at rest."""
    return galvi.problems.harmonic_oscillator()


def method_of(make_method: MakeMethod, n: int) -> Any:
    """The method of degree N = n - 1 with N + 1 Gauss points."""
    return make_method(galvi.Polynomials(n - 1), galvi.gauss(n))


def refinement(
    study: str, cases: Iterable[Case], make_method: MakeMethod, report: Report
) -> list[dict[str, Any]]:
    """Rows of the one-step error of these cases."""
    return refine(study, problem(), OSCILLATOR, cases, (QUANTITY,), make_method, report, method_of)
