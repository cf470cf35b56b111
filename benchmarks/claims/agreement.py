"""galvi beside every reference: rows of `verify` that ask whether two codes see the same motion.

An agreement is no claim of a paper: the two solve one problem, and the bound is what rounding, or
the reference's own error at its setting, explains.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np
import pandas as pd

import galvi
from benchmarks.checks.bounds import HOLDS, NOT_RUN, AtMost
from benchmarks.checks.claim import AGREEMENT as SOURCE
from benchmarks.checks.claim import Claim, MakeMethod, Report, Row, judged
from benchmarks.store.frames import frame, number, pick, row
from benchmarks.work_precision.galvi_methods import Variational
from galvi import Problem
from references import Contender

DEGREE = 12


@dataclass(frozen=True, eq=False)
class AgreementCase:
    """A problem that galvi and a reference both solve.

    contender  the reference
    problem    what is solved, of duration `duration` in its unit of time
    limit      on the largest component of the difference of both configurations at the end
    steps      of galvi's, polynomials of degree 12 with 12 Gauss points
    setting    of the reference
    note       why the limit is what it is, where not for rounding
    """

    contender: Contender
    problem: Problem
    duration: float
    limit: float
    steps: int = 20
    setting: Mapping[str, Any] = field(default_factory=dict)
    note: str = "Both are at round-off."

    @property
    def quantity(self) -> str:
        """What is measured, in the words of a row."""
        return f"difference from {self.contender.name}, {self.problem.name}"

    def measured(self, make_method: MakeMethod) -> dict[str, Any]:
        """A tidy row; its status says why there is no number."""
        found = row(study=SOURCE, quantity=self.quantity, t=self.duration)
        if self.contender.missing:
            return {**found, "label": self.contender.missing}
        ours = Variational(make_method(galvi.Polynomials(DEGREE), galvi.gauss(DEGREE)))
        equal = {"step": self.duration / self.steps, "save_every": self.steps}
        runs = (
            ours.run(self.problem, self.duration, equal),
            self.contender.run(self.problem, self.duration, self.setting),
        )
        failed = " ".join(run.status for run in runs if not run.success)
        if failed:
            return {**found, "status": failed}
        away = float(np.max(np.abs(runs[0].q[-1] - runs[1].q[-1])))
        return {**found, "value": away, "label": str(runs[1].method)}

    def judged(self, name: str, table: pd.DataFrame) -> Row:
        """The row of the agreement `name`; one whose engine is absent is expected not to run."""
        labels = [text for text in pick(table, quantity=self.quantity).get("label", ()) if text]
        absent = self.contender.missing if self.contender.missing in labels else ""
        return judged(
            name,
            self.quantity,
            AtMost(self.limit),
            number(table, quantity=self.quantity),
            source=SOURCE,
            setup=f"{self.problem.name or 'problem'}; T = {self.duration:g}; "
            f"Polynomials({DEGREE}), gauss({DEGREE}), {self.steps} steps",
            claimed="the same motion",
            expected=NOT_RUN if absent else HOLDS,
            reason=absent or self.note,
            reference=self.contender.name if absent or not labels else labels[0],
        )


def agreement(name: str, title: str, cases: tuple[AgreementCase, ...]) -> Claim:
    """Comparisons with one family of references as something `verify` runs like a claim."""
    return Claim(name, title, partial(_study, cases), partial(_judge, name, cases))


def _study(
    cases: tuple[AgreementCase, ...], make_method: MakeMethod, quick: bool, report: Report
) -> pd.DataFrame:
    """One row for each case; one that raises says so in its own row alone."""
    rows = []
    for case in cases:
        report(case.quantity)
        try:
            rows.append(case.measured(make_method))
        except Exception as error:
            why = f"{type(error).__name__}: {error}"
            rows.append(row(study=SOURCE, quantity=case.quantity, status=why))
    return frame(rows)


def _judge(name: str, cases: tuple[AgreementCase, ...], table: pd.DataFrame) -> list[Row]:
    return [case.judged(name, table) for case in cases]
