"""Agreement of galvi with the references, as rows of `verify`.

An agreement is not a claim of a paper: both codes solve one problem, and the bound is the rounding
error, or the reference's own error at its setting.
"""

from __future__ import annotations

from dataclasses import field
from functools import cached_property
from typing import Protocol

from benchmarks.checks.claim import AGREEMENT as SOURCE
from benchmarks.claims.kit import *
from benchmarks.store.foreign_texts import visible
from benchmarks.work_precision.galvi_methods import Variational
from references import Contender, missing_engine

DEGREE = 12


@dataclass(frozen=True, eq=False)
class AgreementCase:
    """A problem that galvi and a reference both solve.

    contender  the reference
    given      the problem, or what makes it, over `duration` in its unit of time
    limit      bound on the largest component of the difference of the final configurations
    steps      number of galvi's steps, by polynomials of degree 12 with 12 Gauss points
    setting    setting of the reference
    note       the reason for the limit
    """

    contender: Contender
    given: Problem | Callable[[], Problem]
    duration: float
    limit: float
    steps: int = 20
    setting: Mapping[str, Any] = field(default_factory=dict)
    note: str = "Both are at round-off."

    @cached_property
    def problem(self) -> Problem:
        """The problem."""
        return self.given if isinstance(self.given, Problem) else self.given()

    @property
    def quantity(self) -> str:
        """The `quantity` of the row."""
        return f"difference from {self.contender.name}, {self.problem.name}"

    def measured(self, make_method: MakeMethod) -> dict[str, Any]:
        """A tidy row; its status gives the reason for a missing number."""
        found = row(study=SOURCE, quantity=self.quantity, t=self.duration)
        if self.contender.missing:
            engine = missing_engine(self.contender)
            return {**found, "label": self.contender.missing, "absent": engine}
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

    def judged(self, name: str, table: DataFrame) -> Row:
        """The row of the agreement `name`; without its engine it is expected not to run."""
        absent, label = absence(table, self.quantity)
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
            reason=label if absent else self.note,
            reference=self.contender.name if absent or not label else label,
            absent=absent,
        )


def absence(table: DataFrame, quantity: str) -> tuple[str, str]:
    """The package for want of which this was not measured, or ""; and the label of its row."""
    for found in pick(table, quantity=quantity).to_dict("records"):
        return found["absent"], found["label"]
    return "", ""


class Compared(Protocol):
    """A case of an agreement: one row."""

    @property
    def quantity(self) -> str:
        """The `quantity` of the row."""

    def measured(self, make_method: MakeMethod) -> dict[str, Any]:
        """A tidy row."""

    def judged(self, name: str, table: DataFrame) -> Row:
        """The row of the agreement `name`."""


def agreement(name: str, title: str, cases: Sequence[Compared]) -> Claim:
    """Comparisons with one family of references, in the form of a claim for `verify`."""
    return Claim(name, title, partial(_study, cases), partial(_judge, name, cases))


def _study(
    cases: Sequence[Compared], make_method: MakeMethod, quick: bool, report: Report
) -> DataFrame:
    """One row for each case; an exception affects only its own row."""
    rows = []
    for case in cases:
        report(case.quantity)
        try:
            rows.append(case.measured(make_method))
        except Exception as error:
            why = visible(f"{type(error).__name__}: {error}")
            rows.append(row(study=SOURCE, quantity=case.quantity, status=why))
    return frame(rows)


def _judge(name: str, cases: Sequence[Compared], table: DataFrame) -> list[Row]:
    return [case.judged(name, table) for case in cases]
