"""Errors under refinement, with fitted and claimed rates; errors of methods, with their orders."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.ticker import LogLocator
from matplotlib.transforms import offset_copy

from benchmarks.statistics.convergence_fits import Fit, algebraic, geometric
from benchmarks.statistics.orders import BOUND, ROUND_OFF
from benchmarks.store.tables import series
from reports.figures.style.identities import COLOURS, GUIDE, MARKERS
from reports.figures.style.layout import legend, split
from reports.tables.number_format import concise, is_finite


@dataclass(frozen=True)
class Refinement:
    """The axis and the rates of a kind of refinement.

    Attributes
    ----------
    xlabel, xscale
        label and scale of the horizontal axis
    rate
        format string of a rate
    """

    xlabel: str
    xscale: str
    rate: str


IN_N = Refinement("number of basis functions $n$", "linear", "{}^{{\\,n}}")
IN_H = Refinement("step size $h$ [{unit}]", "log", "h^{{{}}}")
IN_DEGREE = Refinement("degree $N$", "log", "N^{{-{}}}")


@dataclass(frozen=True)
class Rate:
    """A series of errors under refinement.

    Attributes
    ----------
    study, quantity
        select the rows of the claim's table
    label
        text in the legend
    floor
        level of round-off, as the claim states it
    claimed
        base of n or power of h; None where the paper gives no number
    n
        the n whose h-refinement this is; None for an n-refinement
    start
        smallest n or h of the fit
    until
        largest h of the fit, where the claim concerns small h only
    algebraic
        whether errors of an n-refinement fall like a power of the degree N = n - 1
    power
        exponent p of a known factor n^-p of the errors, and its uncertainty
    """

    study: str
    quantity: str
    label: str
    floor: float
    claimed: float | None = None
    n: int | None = None
    start: float = 0.0
    until: float = np.inf
    algebraic: bool = False
    power: tuple[float, float] = (0.0, 0.0)

    @property
    def refinement(self) -> Refinement:
        """IN_H if `n` is given; else IN_DEGREE, drawn over 1 / N, if `algebraic`, or IN_N."""
        return IN_H if self.n is not None else IN_DEGREE if self.algebraic else IN_N

    def measured(self, table: pd.DataFrame) -> tuple[np.ndarray, np.ndarray]:
        """(n, h or 1 / N; errors), from coarse to fine; the error of a failed run is NaN."""
        where = {"study": self.study, "quantity": self.quantity}
        if self.n is not None:
            return series(table, "step", n=self.n, **where)
        n, error = series(table, "n", **where)
        return (1.0 / (n - 1.0) if self.algebraic else n), error

    def fit(self, table: pd.DataFrame) -> Fit:
        """The fit that the claim's verdict rests on."""
        x, error = self.measured(table)
        used = (self.start <= x) & (x <= self.until)
        if self.refinement is IN_N:
            return geometric(x[used], error[used], floor=self.floor, power=self.power)
        return algebraic(x[used], error[used], floor=self.floor)

    def text(self, fit: Fit) -> str:
        """The label, with the fitted rate if it is finite, and with the claimed one, if any."""
        text = self.label
        if is_finite(fit.rate):
            factor = f"n^{{-{fit.power:g}}}" if fit.power else ""
            rate = self.refinement.rate.format(concise(fit.rate, fit.uncertainty))
            text += f"  ${rate}{factor}$"
        if self.claimed is not None:
            text += f"  (claimed ${self.refinement.rate.format(f'{self.claimed:g}')}$)"
        return text


def in_h(
    study: str,
    quantity: str,
    ns: Iterable[int],
    floor: float,
    claimed: Callable[[int], float | None] = lambda n: None,
    *,
    start: float = 0.0,
    degrees: bool = False,
) -> tuple[Rate, ...]:
    """The h-refinement of each n; with `degrees`, labels show N = n - 1 in place of n."""
    return tuple(
        Rate(
            study, quantity, f"$N={n - 1}$" if degrees else f"$n={n}$", floor, claimed(n), n, start
        )
        for n in ns
    )


# Typographic points between the errors of a fit and the line of the claimed rate:
CLAIM_OFFSET = 6.0
HOLLOW_STYLE = {"color": GUIDE, "marker": "o", "markerfacecolor": "white", "linestyle": "none"}
CLAIMED_STYLE = {"color": GUIDE, "linestyle": (0, (4, 2)), "linewidth": 1.1}
UNUSED_LABEL = "not in the fit, or not resolved"
DASHES = ("-", (0, (4, 2)), (0, (1, 1.4)))


def convergence(
    axes: Axes,
    table: pd.DataFrame,
    *,
    rates: Sequence[Rate],
    ylabel: str,
    top: float = np.inf,
    unit: str = "unit of time",
) -> None:
    """Draw errors under refinement of n, h, or the degree N, over n, h or 1 / N.

    Points that are not in the fit are hollow.

    Parameters
    ----------
    top
        larger errors, of unstable runs, are shown as a triangle and a power of ten at this height
    unit
        of the step size
    """
    refinement = rates[0].refinement
    axes.set(
        xscale=refinement.xscale,
        yscale="log",
        xlabel=refinement.xlabel.format(unit=unit),
        ylabel=ylabel,
    )
    if refinement is IN_N:
        axes.locator_params("x", integer=True)
    elif refinement is IN_DEGREE:  # at 1 / N for N = 2^k and 3 2^k
        axes.xaxis.set_major_locator(LogLocator(2.0, subs=(1.0, 4.0 / 3.0), numticks=20))
        axes.xaxis.set_major_formatter(lambda x, _: f"{1.0 / x:.0f}")
        axes.minorticks_off()
    clipped: dict[tuple[float, str], None] = {}
    for k, rate in enumerate(rates):
        x, error = rate.measured(table)
        if not np.any(error > 0.0):
            continue
        fit = rate.fit(table)
        style = {"color": COLOURS[k % len(COLOURS)], "marker": MARKERS[k], "linestyle": "-"}
        low, high = min(fit.window), max(fit.window)
        used = (x >= low * (1.0 - 1e-9)) & (x <= high * (1.0 + 1e-9)) & (error > 0.0)
        shown = np.where((error > 0.0) & (error <= top), error, np.nan)
        points(axes, x, shown, used, style, "not in the fit")
        axes.plot([], [], label=rate.text(fit), **style)
        for index in np.flatnonzero(error > top):
            axes.plot(x[index], top, "^", color=style["color"], mfc="white", clip_on=False)
            clipped[x[index], f"{np.log10(error[index]):.0f}"] = None
        if is_finite(fit.rate):
            x_fit = np.linspace(*fit.window, 50)
            axes.plot(x_fit, fit.evaluate(x_fit), color=style["color"])
            if rate.claimed is not None:
                _claimed(axes, fit, rate.claimed, x[used], error[used])
    for x_clipped, exponent in clipped:
        axes.annotate(
            f"$10^{{{exponent}}}$",
            (x_clipped, top),
            xytext=(5, -2),
            color=GUIDE,
            fontsize=8,
            textcoords="offset points",
        )


def _claimed(axes: Axes, fit: Fit, claimed: float, x: np.ndarray, error: np.ndarray) -> None:
    """Draw the claimed rate, dashed, a little above all points (x, error) of the fit."""
    claim = replace(fit, rate=claimed, coefficient=1.0, power=0.0, bend=0.0)
    level = np.max(error / claim.evaluate(x)) * claim.evaluate(fit.window)
    above = offset_copy(axes.transData, axes.figure, y=CLAIM_OFFSET, units="points")
    legend(axes, axes.plot(fit.window, level, transform=above, **CLAIMED_STYLE), ["claimed rate"])


def points(axes: Axes, x: Any, y: Any, filled: Any, style: Mapping[str, Any], hollow: str) -> None:
    """Draw a thin line through all points, and their marks, hollow where `filled` is false.

    Parameters
    ----------
    x, y, filled
        arrays, or columns of one table
    hollow
        label of hollow marks in the legend
    """
    axes.plot(x, y, **{**style, "marker": ""}, linewidth=0.6, alpha=0.5)
    mark_style = {**style, "linestyle": "none"}
    axes.plot(x[filled], y[filled], **mark_style)
    axes.plot(x[~filled], y[~filled], **mark_style, markerfacecolor="white")
    if np.any(np.isfinite(y[~filled])):
        legend(axes, [Line2D([], [], **HOLLOW_STYLE)], [hollow])


def orders(axes: Axes, table: pd.DataFrame, *, ylabel: str, unit: str = "unit of time") -> None:
    """Two panels with a common axis of errors: against the step, with the fitted slopes in the
    legend, and against the time of a run. Hollow points are not in the fit, or not resolved.

    Parameters
    ----------
    table
        rows of `benchmarks.applications.convergence.table`
    """
    measured = table[table["error"] > 0.0]
    by_step, by_cost = split(axes, 2, ylabel=ylabel, min_width=2.9, xscale="log", yscale="log")
    by_cost.sharey(by_step)
    by_step.set_xlabel(f"step size $h$ [{unit}]")
    by_cost.set_xlabel("time of a run [s]")
    for k, (method, rows) in enumerate(measured.groupby("method", sort=False)):
        style = {
            "color": COLOURS[k % len(COLOURS)],
            "marker": MARKERS[k % len(MARKERS)],
            "linestyle": DASHES[k // len(COLOURS) % len(DASHES)],
        }
        steps = rows[rows["h"].notna()].sort_values("h")
        timed = rows[rows["seconds"] > 0.0].sort_values("error")
        used, resolved = steps["fit"].astype(bool), ~timed["note"].isin((BOUND, ROUND_OFF))
        points(by_step, steps["h"], steps["error"], used, style, UNUSED_LABEL)
        points(by_cost, timed["seconds"], timed["error"], resolved, style, UNUSED_LABEL)
        order, text = rows["fitted"].iloc[0], str(method).replace("$", r"\$")
        if is_finite(order):
            text += f", order {concise(order, rows['fitted_se'].iloc[0])}"
            h, errors = steps.loc[used, "h"], steps.loc[used, "error"]
            coefficient = np.exp(np.mean(np.log(errors / h**order)))
            by_step.plot(h, coefficient * h**order, **{**style, "marker": ""}, linewidth=1.6)
        by_step.plot([], [], label=text, **style)
