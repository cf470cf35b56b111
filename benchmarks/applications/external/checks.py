"""Checks of the accuracy and the declared properties of an external integrator.

`verify` makes all CHECKS at once (`contender_checks`); the plugin of pytest makes them one by one.

Declared properties (see `external.integrator`) are compared with measurements: the order
from both sides, claimed errors, conserved quantities, as a bound and without drift, and symmetry,
by a run back. Undeclared properties are measured and reported without influence on the verdicts.
No run may fail, and the error at the finest setting must be at most LARGEST_ERROR of the motion's
extent. That error must also be at most LARGEST_RATIO times the one at the coarsest setting, or at
most SMALL_ERROR; of a single setting it must be at most SMALL_ERROR.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
import pandas as pd

from benchmarks.applications.external.check_problems import CHECK_PROBLEMS, CheckProblem
from benchmarks.applications.external.check_runs import (
    CLAIMED,
    ELSEWHERE,
    ERROR,
    FAILED,
    GROWTH,
    RELATIVE_ERRORS,
    REPEAT,
    Runs,
)
from benchmarks.applications.external.integrator import ExternalIntegrator
from benchmarks.applications.external.loading import CONSERVED
from benchmarks.applications.external.long_runs import CUT, LONG, LONGER, LONGEST_RUN_STEPS, NOT_CUT
from benchmarks.applications.external.order_runs import ERRATIC_RISES, ORDER, SINGLE, rises
from benchmarks.applications.external.reversed_runs import NOT_REVERSED, REVERSED, ROUNDING
from benchmarks.checks import bounds
from benchmarks.checks.claim import AGREEMENT as SOURCE
from benchmarks.checks.claim import Claim, MakeMethod, Report, Row
from benchmarks.checks.series_bounds import NoGrowth
from benchmarks.statistics.convergence_fits import FEWEST_POINTS, algebraic, window
from benchmarks.statistics.drift import Drift, drift
from benchmarks.store.tables import number, pick, row, table_of

PRINTED = "printed"  # row of the number of printed lines, for no problem; status: the first ones
LARGEST_RATIO = 0.7  # largest ratio of the errors at the finest and the coarsest setting
SMALL_ERROR = 1e-8  # relative error up to which the ratio is not checked
LARGEST_ERROR = 0.1  # largest relative error at the finest setting
ORDER_TOLERANCE = 0.05  # relative tolerance of an order, in addition to `bounds.ORDER_RESOLUTION`
ROUND_OFF_FACTOR = 4.0  # errors over the integrator's own round-off level that are fitted
ROUND_OFF = 1e-12  # relative change below which growth is no drift; in the longest run the next
MEMORY_LEFT = 4.0  # MB that repeated runs, and those of `track`, may leave in memory
ROUND_OFF_OF_MANY = LONGEST_RUN_STEPS * np.finfo(float).eps
SAME_BITS = (
    "Two runs that were asked for alike, also in another process, must have the same bits; else it "
    "is not deterministic, and no later comparison says what changed."
)
ORDER_SHOWN = "It declares its order: errors above round-off show it somewhere."
ORDER_NOT_SHOWN = (
    "It declares its order, and no steps were found at which errors above round-off show it: let "
    "it run at longer steps than it offers, or declare no order."
)
NO_STEPS = (
    "It declares its order, which is seen in errors at equal steps: offer settings with a `step` "
    "for a nonlinear motion, or declare no order."
)
STEEPER_THAN_DECLARED = "Steeper here than declared, which another motion shows."
SAME_END = "What starts half way, from its state and at its time there, must end at the same place."
RETURNS_TO_START = (
    "It declares that it is symmetric: a run back returns to the start, but for rounding."
)
MEMORY_STAYS = "Of each of three equal rounds of runs something stays in memory."
TOO_SLOW = "A run takes too long to be repeated for this."
DECLARED = "Declared by the contender."
NOT_DECLARED = "Not declared: the number is for information."


@dataclass(frozen=True, eq=False)
class ClaimRows:
    """Turns measured rows of `external.check_runs` into rows of claims.csv.

    A call does so for all checks; each method for one check, on one problem or on all.
    """

    id: str
    external: ExternalIntegrator
    check_problems: tuple[CheckProblem, ...]

    def __call__(self, table: pd.DataFrame) -> list[Row]:
        """Return the rows of all checks; one row if the integrator supports none of the problems,
        besides that of printed lines."""
        rows: list[Row] = []
        for problem in self.check_problems:
            rows_of_it = pick(table, study=problem.problem.name)
            if not rows_of_it.empty:
                row_groups = (
                    check.rows_on_problem(self, problem, rows_of_it)
                    for check in (FAILURES, *CHECKS)
                )
                rows += [row for rows_of_check in row_groups for row in rows_of_check]
        rows += [row for check in CHECKS for row in check.rows_of_all(self, table)]
        return [*rows, *self._printed(table)]

    def _row(
        self, check: CheckProblem, quantity: str, measured: float, verdict: str, **texts: str
    ) -> Row:
        texts = {
            "claimed": "the same motion",
            "bound": "none",
            "expected": bounds.HOLDS,
            "reason": DECLARED,
            "reference": check.truth.name,
            "setup": f"{check.problem.name}; T = {check.duration:g}",
            **texts,
        }
        return Row(
            id=self.id,
            quantity=f"{quantity}, {check.problem.name}",
            source=SOURCE,
            measured=measured if np.isfinite(measured) else None,
            uncertainty=None,
            verdict=verdict,
            **texts,
        )

    def _not_run(
        self, check: CheckProblem, quantity: str, table: pd.DataFrame, instead: str
    ) -> list[Row]:
        """Rows for a quantity that could not be measured, with the reasons of rows `instead`."""
        return [
            self._row(
                check,
                quantity,
                np.nan,
                bounds.NOT_RUN,
                expected=bounds.NOT_RUN,
                reason=why,
                reference="the protocol",
            )
            for why in pick(table, quantity=instead)["status"]
        ]

    def _at_least_one(self, quantity: str, count: int, why: str) -> Row:
        return Row(
            id=self.id,
            quantity=quantity,
            source=SOURCE,
            setup="all problems",
            claimed="",
            bound="at least 1",
            measured=count,
            uncertainty=None,
            expected=bounds.HOLDS,
            reason=why,
            reference="",
            verdict=bounds.HOLDS if count else bounds.CONTRADICTED,
        )

    def declarations(self, table: pd.DataFrame) -> list[Row]:
        """A row for each quantity that it declares to conserve, which a supported problem must
        conserve; where it supports no problem, one row that contradicts this."""
        tested = self._tested(table)
        if not tested:
            names = ", ".join(check.problem.name for check in self.check_problems)
            return [self._at_least_one("problems that it supports", 0, f"Asked were {names}.")]
        why = "It declares that it conserves this: a problem that it supports must have it."
        return [
            self._at_least_one(f"problems where its {quantity} is looked at", count, why)
            for quantity in self.external.conserves
            for count in [sum(quantity in problem.conserved for problem in tested)]
        ]

    def _tested(self, table: pd.DataFrame) -> list[CheckProblem]:
        """The problems that have rows."""
        return [check for check in self.check_problems if check.problem.name in set(table["study"])]

    def orders(self, table: pd.DataFrame) -> list[Row]:
        """The rows of its order on each problem, and a row of the number of problems that show it.

        Where one motion shows the declared order, the errors of others may fall more steeply.
        """
        if self.external.order is None or not self._tested(table):
            return []
        orders = [
            row
            for check in self.check_problems
            for row in self._order(check, pick(table, study=check.problem.name))
        ]
        attained = any(row.verdict == bounds.ATTAINED for row in orders)
        rows = [
            row
            if row.verdict != bounds.EXCEEDS
            else replace(row, expected=bounds.EXCEEDS, reason=STEEPER_THAN_DECLARED)
            if attained
            else replace(row, verdict=bounds.CONTRADICTED)
            for row in orders
        ]
        count = sum(row.verdict != bounds.NOT_RUN for row in rows)
        count_row = self._at_least_one("problems where its order is seen", count, ORDER_SHOWN)
        if not count:
            failures = [text for text in pick(table, quantity=FAILED)["status"] if text]
            why = NO_STEPS if not orders else ORDER_NOT_SHOWN
            measured = table[table["quantity"].isin((ERROR, ORDER, *CONSERVED))]
            completed = measured["value"].notna() & (measured["status"] == "")
            if failures and not completed.any():
                why = f"It declares its order, and no run came to its end: {failures[0]}"
            count_row = replace(
                count_row, verdict=bounds.NOT_RUN, expected=bounds.NOT_RUN, reason=why
            )
        return [*rows, count_row]

    def longest(self, check: CheckProblem, table: pd.DataFrame) -> list[Row]:
        length_rows = [
            self._row(
                check,
                LONG if row["steps"] else "duration of its longest run",
                row["value"],
                bounds.HOLDS if np.isfinite(row["value"]) else bounds.CONTRADICTED,
                claimed="it comes to its end",
                bound=f"{LONGEST_RUN_STEPS:,} where the time limit allows",
                reason=row["status"] or "States at all times are finite.",
                reference="the protocol",
                setup=f"{check.problem.name}; T = {row['t']:g}; {row['label']}",
            )
            for _, row in pick(table, quantity=LONG).iterrows()
        ]
        return [*length_rows, *self.conserved(check, table, LONGER)]

    def restarted(self, check: CheckProblem, table: pd.DataFrame) -> list[Row]:
        not_run = self._not_run(check, CUT, table, NOT_CUT)
        return not_run + [
            self._row(
                check,
                CUT,
                row["value"],
                bounds.HOLDS if row["value"] <= LARGEST_ERROR else bounds.CONTRADICTED,
                claimed="the same end",
                bound=f"at most {LARGEST_ERROR:g} of the way from the start",
                reason=row["status"] or SAME_END,
                reference="the run from the start",
                setup=f"{check.problem.name}; T = {row['t']:g}; {row['label']}",
            )
            for _, row in pick(table, quantity=CUT).iterrows()
        ]

    def _printed(self, table: pd.DataFrame) -> list[Row]:
        return [
            Row(
                id=self.id,
                quantity="lines that it printed",
                source=SOURCE,
                setup="all runs",
                bound="none",
                measured=row["value"],
                expected=bounds.FINDING,
                verdict=bounds.FINDING,
                reason=f"The first lines: {row['status']}",
            )
            for _, row in pick(table, quantity=PRINTED).iterrows()
            if row["value"]
        ]

    def failures(self, check: CheckProblem, table: pd.DataFrame) -> list[Row]:
        count, (why, *_) = number(table, quantity=FAILED), pick(table, quantity=FAILED)["status"]
        return [
            self._row(
                check,
                "runs and answers that failed",
                count,
                bounds.AtMost(0.0).verdict(count),
                claimed="runs as they were asked for",
                bound="at most 0",
                reference="the protocol",
                reason=why or "Each setting that it offers must run to its end.",
            )
        ]

    def reversed(self, check: CheckProblem, table: pd.DataFrame) -> list[Row]:
        rounding = number(table, quantity=ROUNDING)
        not_run = self._not_run(check, REVERSED, table, NOT_REVERSED)
        return not_run + [
            self._row(
                check,
                REVERSED,
                row["value"],
                bounds.HOLDS if row["value"] <= rounding else bounds.CONTRADICTED,
                claimed="the start",
                bound=f"at most {rounding:.2g} of the states' size"
                if rounding > 0.0
                else "rounding",
                reason=row["status"] or RETURNS_TO_START,
                reference="its start",
                setup=f"{check.problem.name}; T = {row['t']:g}; {row['steps']:g} steps and back",
            )
            for _, row in pick(table, quantity=REVERSED).iterrows()
        ]

    def memory(self, check: CheckProblem, table: pd.DataFrame) -> list[Row]:
        rows = []
        for _, reading in pick(table, quantity=GROWTH).iterrows():
            measured = float(reading["value"])
            verdict = bounds.AtMost(MEMORY_LEFT).verdict(measured)
            rows.append(
                self._row(
                    check,
                    f"{GROWTH}, MB",
                    measured,
                    bounds.NOT_RUN if np.isnan(measured) else verdict,
                    expected=bounds.NOT_RUN if np.isnan(measured) else bounds.HOLDS,
                    claimed="no more than before",
                    bound=f"at most {MEMORY_LEFT:g}",
                    reference="its process before",
                    reason=TOO_SLOW
                    if np.isnan(measured)
                    else MEMORY_STAYS
                    if measured > MEMORY_LEFT
                    else "Further runs of a warm process leave nothing.",
                    setup=f"{check.problem.name}; T = {check.duration:g}; {reading['label']}",
                )
            )
        return rows

    def repeated(self, check: CheckProblem, table: pd.DataFrame) -> list[Row]:
        return [
            self._row(
                check,
                quantity,
                row["value"],
                bounds.AtMost(0.0).verdict(row["value"]),
                claimed="the same numbers",
                bound="at most 0",
                reference="the first run",
                reason=row["status"] or SAME_BITS,
            )
            for quantity in (REPEAT, ELSEWHERE)
            for _, row in pick(table, quantity=quantity).iterrows()
        ]

    def errors(self, check: CheckProblem, table: pd.DataFrame) -> list[Row]:
        rows, errors = [], pick(table, quantity=ERROR)
        for _, reading in errors.iterrows():
            limit = number(table, quantity=CLAIMED, label=reading["label"])
            measured, claims = float(reading["value"]), np.isfinite(limit)
            expected = bounds.HOLDS if claims else bounds.FINDING
            is_met = np.isfinite(measured) and not (claims and measured > limit)
            rows.append(
                self._row(
                    check,
                    f"error at {reading['label'] or 'its setting'}",
                    measured,
                    expected if is_met else bounds.CONTRADICTED,
                    expected=expected,
                    bound=f"at most {limit:g}" if claims else "none",
                    reason=reading["status"] or (DECLARED if claims else NOT_DECLARED),
                )
            )
        return [*rows, *self._finest_error_rows(check, table)] if rows else []

    def _finest_error_rows(self, check: CheckProblem, table: pd.DataFrame) -> list[Row]:
        """Rows for the relative error at the finest setting, and its ratio to the coarsest."""
        relative_errors = {
            part: list(pick(table, quantity=name)["value"])
            for part, name in RELATIVE_ERRORS.items()
        }
        failures = list(pick(table, quantity=ERROR)["status"])
        coarse, fine = (
            float(np.max([values[k] for values in relative_errors.values()])) for k in (0, -1)
        )
        worst = max(
            relative_errors, key=lambda part: np.nan_to_num(relative_errors[part][-1], nan=np.inf)
        )
        is_single = len(relative_errors[worst]) == 1
        has_improved = fine <= max(SMALL_ERROR, 0.0 if is_single else LARGEST_RATIO * coarse)
        is_undecided = is_single and not has_improved and np.isfinite(fine)
        furthest = f"Furthest from the truth: its {worst}."
        reason = "What becomes no better solves another problem."
        if failures[-1]:
            furthest = reason = "Its run at the finest setting failed."
        elif is_single:
            reason = "It offers one setting, so that nothing can become better: let it offer two."
        elif failures[0]:
            reason = "Its run at the coarsest setting failed."
        elif fine > coarse:
            reason = "Settings go from coarse to fine; and what becomes worse is no solution."
        bound = f"at most {LARGEST_RATIO:g}, or an error of at most {SMALL_ERROR:g} of the way"
        return [
            self._row(
                check,
                "error at its finest over the way from the start",
                fine,
                bounds.HOLDS if fine <= LARGEST_ERROR else bounds.CONTRADICTED,
                bound=f"at most {LARGEST_ERROR:g}",
                reason=furthest,
            ),
            self._row(
                check,
                "error at its finest over that at its coarsest",
                fine if is_single or not coarse > 0.0 else fine / coarse,
                bounds.NOT_RUN
                if is_undecided
                else bounds.HOLDS
                if has_improved
                else bounds.CONTRADICTED,
                bound=bound,
                reason=reason,
            ),
        ]

    def _order(self, check: CheckProblem, table: pd.DataFrame) -> list[Row]:
        runs, order = pick(table, quantity=ORDER), self.external.order
        if runs.empty or order is None:
            return []
        floor = max(check.floor, _own_floor(runs["value"], check.floor))
        fit = algebraic(list(runs["step"]), list(runs["value"]), floor=floor)
        slack = max(bounds.ORDER_RESOLUTION, ORDER_TOLERANCE * order)
        is_contradicted = fit.stays_large or fit.relapse
        spread, reason = slack + 2.0 * fit.uncertainty, DECLARED
        low, high = (bounds.in_words(order + sign * slack, slack) for sign in (-1.0, 1.0))
        if is_contradicted:
            verdict = bounds.CONTRADICTED
        elif not fit.points:
            failures = [text for text in runs["status"] if text]
            verdict = bounds.NOT_RUN
            reason = failures[0] if failures else "Fewer than three errors are above round-off."
        elif 2.0 * fit.uncertainty <= slack and fit.rate > order + slack:
            verdict = bounds.EXCEEDS
        elif 2.0 * fit.uncertainty <= slack:
            verdict = bounds.Near(order, slack, uncertainty=0.0).verdict(fit)
        elif rises(runs["value"], floor) >= ERRATIC_RISES or fit.rate < order - spread:
            verdict, reason = bounds.CONTRADICTED, "Its errors follow no power of the step."
        else:
            verdict, reason = bounds.NOT_RUN, "Its errors fall, but not yet as a power of the step."
        is_not_shown = verdict == bounds.NOT_RUN
        order_row = self._row(
            check,
            "order in the step",
            fit.rate,
            verdict,
            claimed=f"order {order:g}",
            bound=f"{low}, less two standard errors ({slack:g} at most), to {high}",
            expected=bounds.NOT_RUN if is_not_shown else bounds.ATTAINED,
            reason=reason,
        )
        return [
            replace(order_row, uncertainty=fit.uncertainty) if np.isfinite(fit.rate) else order_row
        ]

    def conserved(self, check: CheckProblem, table: pd.DataFrame, name: str = "{}") -> list[Row]:
        return [
            self._conserved_row(check, quantity, name.format(quantity), series)
            for quantity in CONSERVED
            if not (series := pick(table, quantity=name.format(quantity))).empty
        ]

    def _conserved_row(
        self, check: CheckProblem, quantity: str, name: str, series: pd.DataFrame
    ) -> Row:
        """The row of a conserved quantity in a long run."""
        round_off = ROUND_OFF if name == quantity else ROUND_OFF_OF_MANY
        drifts = [
            drift(rows["t"].to_numpy(), rows["value"].to_numpy()) for _, rows in series.groupby("n")
        ]
        worst, limit = drifts[0], self.external.conserves.get(quantity)
        expected, verdict, why = bounds.FINDING, bounds.FINDING, NOT_DECLARED
        if limit is not None:
            limit = limit if name == quantity else max(limit, round_off)
            expected, verdict, why = bounds.HOLDS, bounds.HOLDS, DECLARED
            faults = [_growth(limit, seed_drift, round_off) for seed_drift in drifts]
            worst = max(drifts, key=lambda seed_drift: seed_drift.largest)
            if all(faults) or worst.largest > limit:  # a drift alone may be a beat
                fault = _growth(limit, worst, round_off) or faults[0]
                verdict, why = bounds.CONTRADICTED, f"{DECLARED} {fault}"
        if not np.isfinite(worst.largest):
            verdict = bounds.CONTRADICTED
        first, last = series.iloc[0], series["t"].iloc[-1]
        return self._row(
            check,
            f"relative change of {name}",
            worst.largest,
            verdict,
            claimed="none" if limit is None else "it stays",
            expected=expected,
            bound="none" if limit is None else f"at most {limit:g}, without a drift",
            reason=first["status"] or why,
            reference="its start",
            setup=f"{check.problem.name}; T = {last:g}; {first['label']}",
        )


def _growth(limit: float, measured: Drift, round_off: float = ROUND_OFF) -> str:
    """A sentence on the test of constancy that a conserved quantity fails; "" if it fails none."""
    no_growth = NoGrowth(limit, round_off, conclusive=False)
    if no_growth.verdict(measured) == bounds.HOLDS:
        return ""
    _, *beyond = no_growth.comparisons(measured)
    if not measured.largest <= limit:
        return f"It changes by {measured.largest:.3g}, more than {limit:g}."
    tests = (
        ("its mean changes", measured.trend, measured.trend_error),
        ("the maxima of its periods change", measured.growth, measured.growth_error),
    )
    description, size, error = tests[int(np.argmax([comparison.number for comparison in beyond]))]
    return (
        f"Over the run {description} by {100.0 * size:+.1f} % of the largest, "
        f"{abs(size) / error if error else np.inf:.1f} standard errors."
    )


def _own_floor(errors: Sequence[float], floor: float) -> float:
    """ROUND_OFF_FACTOR times the level at which its errors stop falling, as in single precision.

    0 where they do not stop, where the level is below SINGLE, and where fewer than FEWEST_POINTS
    errors are above. At round-off errors rise and fall. Those of a method that tends to the
    solution of another problem, |C h^p - d|, fall and then only rise.
    """
    measured = np.asarray(errors, dtype=np.float64)
    measured = measured[window(errors, floor=floor)]
    rising = np.flatnonzero(np.diff(measured) > 0.0)
    if not rising.size:
        return 0.0
    tail = measured[rising[0] :]
    level = ROUND_OFF_FACTOR * float(np.max(tail))
    is_round_off = level > ROUND_OFF_FACTOR * SINGLE and np.any(np.diff(tail[1:]) < 0.0)
    return level if is_round_off and np.sum(measured > level) >= FEWEST_POINTS else 0.0


@dataclass(frozen=True)
class Check:
    """A check of an external integrator, which can be measured on one problem at a time.

    Attributes
    ----------
    name
        name of the item of the plugin of pytest
    measure
        (runs, problem) -> rows of the tidy table
    on_problem
        (claim rows, problem, its rows) -> rows of claims.csv; None where all problems are checked
        together
    jointly
        (claim rows, rows of all problems) -> rows of claims.csv; None for a check of each problem
    applies
        (integrator, supported problem) -> whether the problem is measured
    once
        whether one problem only is measured: the first that conserves something, if one does
    """

    name: str
    measure: Callable[[Runs, CheckProblem], Iterator[dict[str, Any]]]
    on_problem: Callable[[ClaimRows, CheckProblem, pd.DataFrame], list[Row]] | None = None
    jointly: Callable[[ClaimRows, pd.DataFrame], list[Row]] | None = None
    applies: Callable[[ExternalIntegrator, CheckProblem], bool] = lambda external, problem: True
    once: bool = False

    def problems(
        self, external: ExternalIntegrator, supported: Sequence[CheckProblem]
    ) -> list[CheckProblem]:
        """Return the supported problems on which the check is measured."""
        problems = [problem for problem in supported if self.applies(external, problem)]
        first = sorted(problems, key=lambda problem: not problem.conserved)[:1]
        return first if self.once else problems

    def rows_on_problem(
        self, claim_rows: ClaimRows, problem: CheckProblem, rows: pd.DataFrame
    ) -> list[Row]:
        """Rows of claims.csv of this problem."""
        return [] if self.on_problem is None else self.on_problem(claim_rows, problem, rows)

    def rows_of_all(self, claim_rows: ClaimRows, rows: pd.DataFrame) -> list[Row]:
        """Rows of claims.csv of all problems together."""
        return [] if self.jointly is None else self.jointly(claim_rows, rows)


def _no_rows(runs: Runs, problem: CheckProblem) -> Iterator[dict[str, Any]]:
    return iter(())


def _shows_order(external: ExternalIntegrator, problem: CheckProblem) -> bool:
    return external.order is not None and external.order >= problem.ordered


def _depends_on_time(external: ExternalIntegrator, problem: CheckProblem) -> bool:
    return bool(getattr(problem.problem.system, "explicit_time", False))


# Failures of all requests: `verify` measures them last, the plugin of pytest with each check.
FAILURES = Check("runs and answers", Runs.make_coarsest_run, ClaimRows.failures)
# Quick checks first, since after MOST_LATE_ANSWERS late answers no further request is made.
CHECKS = (
    Check("determinism", Runs.repeated, ClaimRows.repeated),
    Check("accuracy", Runs.errors, ClaimRows.errors),
    Check("order", Runs.order, jointly=ClaimRows.orders, applies=_shows_order),
    Check("declarations", _no_rows, jointly=ClaimRows.declarations),
    Check(
        "time reversal",
        Runs.reversed,
        ClaimRows.reversed,
        applies=lambda external, problem: external.symmetric,
    ),
    Check("memory", Runs.memory, ClaimRows.memory),
    Check(
        "conservation",
        Runs.conserved,
        ClaimRows.conserved,
        applies=lambda external, problem: bool(problem.conserved),
    ),
    Check("longest run", Runs.longest, ClaimRows.longest, once=True),
    Check("restart half way", Runs.restarted, ClaimRows.restarted, applies=_depends_on_time),
)


def supported_and_faulty(
    external: ExternalIntegrator, check_problems: Sequence[CheckProblem]
) -> tuple[list[CheckProblem], list[CheckProblem]]:
    """Return the supported problems, and those for which asking about support was a fault."""
    supported = [check for check in check_problems if external.supports(check.problem)]
    unsupported = [check for check in check_problems if check not in supported]
    return supported, [check for check in unsupported if external.faults_on(check.problem)]


def check_runs(
    external: ExternalIntegrator,
    check_problems: Sequence[CheckProblem],
    make_method: MakeMethod,
    quick: bool,
    report: Report,
) -> pd.DataFrame:
    """Measure the rows of every check on the supported problems, and close the integrator."""
    runs = Runs(external)
    supported, faulty = supported_and_faulty(external, check_problems)
    rows: list[dict[str, Any]] = []
    for check in CHECKS:
        for problem in check.problems(external, supported):
            report(f"{problem.problem.name}: {check.name}")
            rows += check.measure(runs, problem)
    external.close()
    printed = external.printed
    rows += [runs.failures(problem) for problem in (*supported, *faulty)]
    rows.append(row(quantity=PRINTED, value=printed.lines, status=" / ".join(printed.first)))
    return table_of(rows)


def contender_checks(
    externals: Sequence[ExternalIntegrator], check_problems: Sequence[CheckProblem] = CHECK_PROBLEMS
) -> tuple[Claim, ...]:
    """A claim for `verify` for each integrator, with ids such as A-my-leapfrog."""
    names: list[str] = []
    for external in externals:
        slug = re.sub(r"[^a-z0-9]+", "-", external.name.lower()).strip("-")
        name = f"A-{slug or 'contender'}"
        while name in names:
            name += "-too"
        names.append(name)
    return tuple(
        Claim(
            name,
            f"{external.name} and the truth",
            partial(check_runs, external, check_problems),
            ClaimRows(name, external, tuple(check_problems)),
            timed=True,  # its runs have a limit of time
        )
        for name, external in zip(names, externals, strict=True)
    )
