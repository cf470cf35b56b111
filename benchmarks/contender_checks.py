"""Somebody else's contender under `verify`: is its motion the right one, and what it says so?

What it declares (see `benchmarks.outsider`) is held against what is measured: its order from both
sides, the errors that it claims, and what it conserves, as a bound and without a drift. What it
does not declare is measured and told, and nothing depends on it. Whatever it declares, no run may
fail, and a finer setting must be better than the coarsest until both are right to 1e-8.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import pandas as pd

from benchmarks import verdicts
from benchmarks.agreement import SOURCE
from benchmarks.claim import Claim, Row
from benchmarks.contender_study import CLAIMED, ERROR, FAILED, FORMULAS, ORDER, studied
from benchmarks.fits import algebraic
from benchmarks.grounds import GROUNDS, Ground
from benchmarks.outsider import Outsider
from benchmarks.tidy import number, pick

GAIN = 0.7  # of the coarsest setting's error, at most at the finest
RIGHT = 1e-8  # an error that needs no gain
SHARE = 0.05  # of an order, that it may be off by beyond `verdicts.ORDER_RESOLUTION`
ROUND_OFF = 1e-12  # relative changes that may grow
OWN = "It says so itself."
TOLD = "It does not say; its number is told."


def contender_checks(
    outsiders: Sequence[Outsider], grounds: Sequence[Ground] = GROUNDS
) -> tuple[Claim, ...]:
    """One for each, which `verify` runs like a claim, with ids such as A-my-leapfrog."""
    names: list[str] = []
    for outsider in outsiders:
        slug = re.sub(r"[^a-z0-9]+", "-", outsider.name.lower()).strip("-")
        name = f"A-{slug or 'contender'}"
        while name in names:
            name += "-too"
        names.append(name)
    return tuple(
        Claim(
            name,
            f"{outsider.name} and the truth",
            partial(studied, outsider, grounds),
            Judge(name, outsider, tuple(grounds)),
            timed=True,  # its runs have a limit of time
        )
        for name, outsider in zip(names, outsiders, strict=True)
    )


@dataclass(frozen=True, eq=False)
class Judge:
    """From the rows of `benchmarks.contender_study` to those of claims.csv."""

    id: str
    outsider: Outsider
    grounds: tuple[Ground, ...]

    def __call__(self, table: pd.DataFrame) -> list[Row]:
        """Every row; a contender that supports none of the problems has one that says so."""
        rows, orders = [], 0
        for ground in self.grounds:
            seen = pick(table, study=ground.problem.name)
            if seen.empty:
                continue
            rows += [self._failures(ground, seen), *self._errors(ground, seen)]
            ordered = self._order(ground, seen)
            orders += sum(row.verdict != verdicts.NOT_RUN for row in ordered)
            rows += [*ordered, *self._conserved(ground, seen)]
        if not rows:
            known = ", ".join(ground.problem.name for ground in self.grounds)
            return [self._least("problems that it supports", 0, f"Asked were {known}.")]
        if self.outsider.order is not None:
            why = (
                "It says its order: steps from its longest to its shortest must show it somewhere, "
                "above round-off. Let it offer longer ones, too."
            )
            rows.append(self._least("problems where its order is seen", orders, why))
        return rows

    def _row(self, ground: Ground, quantity: str, measured: float, verdict: str,
             **more: str) -> Row:  # fmt: skip
        told = {
            "claimed": "the same motion", "bound": "none", "expected": verdicts.HOLDS,
            "reason": OWN, "reference": ground.truth.name,
            "setup": f"{ground.problem.name}; T = {ground.duration:g}", **more,
        }  # fmt: skip
        return Row(
            id=self.id, quantity=f"{quantity}, {ground.problem.name}", source=SOURCE,
            measured=measured if np.isfinite(measured) else None, uncertainty=None,
            verdict=verdict, **told,
        )  # fmt: skip

    def _least(self, quantity: str, count: int, why: str) -> Row:
        return Row(
            id=self.id, quantity=quantity, source=SOURCE, setup="all problems",
            claimed="", bound="at least 1", measured=count, uncertainty=None,
            expected=verdicts.HOLDS, reason=why, reference="",
            verdict=verdicts.HOLDS if count else verdicts.CONTRADICTED,
        )  # fmt: skip

    def _failures(self, ground: Ground, seen: pd.DataFrame) -> Row:
        count, (why, *_) = number(seen, quantity=FAILED), pick(seen, quantity=FAILED)["status"]
        return self._row(
            ground, "runs and answers that failed", count, verdicts.bound(count, 0.0),
            claimed="runs as they were asked for", bound="at most 0", reference="the protocol",
            reason=why or "Each setting that it offers must run to its end.",
        )  # fmt: skip

    def _errors(self, ground: Ground, seen: pd.DataFrame) -> list[Row]:
        rows, errors = [], pick(seen, quantity=ERROR)
        for _, one in errors.iterrows():
            limit = number(seen, quantity=CLAIMED, label=one["label"])
            measured, claims = float(one["value"]), np.isfinite(limit)
            expected = verdicts.HOLDS if claims else verdicts.INFORMATIVE
            kept = np.isfinite(measured) and not (claims and measured > limit)
            rows.append(
                self._row(
                    ground, f"error at {one['label'] or 'its setting'}", measured,
                    expected if kept else verdicts.CONTRADICTED, expected=expected,
                    bound=f"at most {limit:g}" if claims else "none",
                    reason=one["status"] or (OWN if claims else TOLD),
                )
            )  # fmt: skip
        if len(errors) > 1:
            coarse, fine = float(errors["value"].iloc[0]), float(errors["value"].iloc[-1])
            better = fine <= max(RIGHT, GAIN * coarse)
            rows.append(
                self._row(
                    ground, "error at its finest over that at its coarsest",
                    fine / coarse if coarse > 0.0 else fine,
                    verdicts.HOLDS if better else verdicts.CONTRADICTED,
                    bound=f"at most {GAIN:g}, or an error of at most {RIGHT:g}",
                    reason="What becomes no better solves another problem.",
                )
            )  # fmt: skip
        return rows

    def _order(self, ground: Ground, seen: pd.DataFrame) -> list[Row]:
        runs, order = pick(seen, quantity=ORDER), self.outsider.order
        if runs.empty or order is None:
            return []
        fit = algebraic(list(runs["step"]), list(runs["value"]), floor=ground.floor)
        slack = max(verdicts.ORDER_RESOLUTION, SHARE * order)
        wrong = fit.stays_large or fit.relapse
        if wrong or not 2.0 * fit.uncertainty <= slack:
            verdict = verdicts.CONTRADICTED if wrong else verdicts.NOT_RUN
        else:
            spread = slack + 2.0 * fit.uncertainty
            verdict = verdicts.within(fit.rate, order - spread, order + spread)
        unseen = verdict == verdicts.NOT_RUN
        found = self._row(
            ground, "order in the step", fit.rate, verdict, claimed=f"order {order:g}",
            bound=f"within {slack:g} of {order:g}",
            expected=verdicts.NOT_RUN if unseen else verdicts.HOLDS,
            reason="Its steps are too short, or too few, to see an order here." if unseen else OWN,
        )  # fmt: skip
        return [replace(found, uncertainty=fit.uncertainty) if np.isfinite(fit.rate) else found]

    def _conserved(self, ground: Ground, seen: pd.DataFrame) -> list[Row]:
        rows = []
        for name in FORMULAS:
            series = pick(seen, quantity=name)
            if series.empty:
                continue
            found = verdicts.drift(series["t"].to_numpy(), series["value"].to_numpy())
            limit = self.outsider.conserves.get(name)
            if limit is None:
                expected = verdict = verdicts.INFORMATIVE
            else:
                expected = verdicts.HOLDS
                verdict = verdicts.no_growth(found, limit, ROUND_OFF)
            if not np.isfinite(found.largest):
                verdict = verdicts.CONTRADICTED
            label, why = series["label"].iloc[0], series["status"].iloc[0]
            rows.append(
                self._row(
                    ground, f"relative change of {name}", found.largest, verdict,
                    claimed="none" if limit is None else "it stays", expected=expected,
                    bound="none" if limit is None else f"at most {limit:g}, without a drift",
                    reason=why or (TOLD if limit is None else OWN), reference="its start",
                    setup=f"{ground.problem.name}; T = {ground.long:g}; {label}",
                )
            )  # fmt: skip
        return rows
