"""What the commands run, as one value: tests hand in small ones."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import pandas as pd

from benchmarks.claim import Claim, Report

Measure = Callable[[bool, Report], pd.DataFrame]


@dataclass(frozen=True)
class Suite:
    """The claims, and what else is measured.

    make_method     what claims build their methods with, `galvi.Galerkin`
    work_precision  (quick, report) -> errors and times of contenders
    cost            (quick, report) -> what a step costs
    provenance      command -> versions, commit, machine, date
    """

    claims: tuple[Claim, ...]
    make_method: Any
    work_precision: Measure
    cost: Measure
    provenance: Callable[[str], Mapping[str, str]]


def load() -> Suite:
    """The real one; imported when called, so that a mistyped word is answered at once."""
    import galvi
    from benchmarks.claims import CLAIMS
    from benchmarks.cost import cost_table
    from benchmarks.provenance import provenance
    from benchmarks.work_precision import work_precision

    return Suite(CLAIMS, galvi.Galerkin, work_precision, cost_table, provenance)
