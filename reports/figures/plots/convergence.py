"""Convergence plots: error against n, h or 1 / N, with fitted and claimed rates."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator, NullLocator

from benchmarks.statistics import convergence_fits
from benchmarks.statistics.convergence_fits import Fit
from benchmarks.store.frames import pick
from reports.figures.style.decades import decades, readable
from reports.figures.style.identities import COLOURS, GUIDE, MARKERS
from reports.figures.style.layout import Label, NoData, label_ends, legend
from reports.tables.number_format import concise, known


@dataclass(frozen=True)
class Rate:
    """A series of errors under refinement.

    study, quantity  which rows of the claim's frame
    label            text beside the line
    floor            level of round-off, as the claim states it
    claimed          base of n or power of h; None where the paper gives no number
    n                the n whose h-refinement this is; None for an n-refinement
    start            first n of the fit, where the claim concerns large n only
    until            largest h of the fit, where the claim concerns small h only
    since            h above which it is fitted, where one range serves all n
    algebraic        of an n-refinement: errors fall like a power of the degree N = n - 1
    power            exponent of a known factor n^-power, and its error
    """

    study: str
    quantity: str
    label: str
    floor: float
    claimed: float | None = None
    n: int | None = None
    start: int = 0
    until: float = np.inf
    since: float = 0.0
    algebraic: bool = False
    power: tuple[float, float] = (0.0, 0.0)

    def measured(self, frame: pd.DataFrame) -> tuple[np.ndarray, np.ndarray]:
        """(n, h or 1 / N, error), coarse to fine; runs that failed have the error NaN."""
        rows = pick(frame, study=self.study, quantity=self.quantity)
        if self.n is None:
            rows = rows.sort_values("n")
            n, error = rows["n"].to_numpy(float), rows["value"].to_numpy(float)
            return (1.0 / (n - 1.0) if self.algebraic else n), error
        rows = pick(rows, n=self.n).sort_values("step", ascending=False)
        return rows["step"].to_numpy(float), rows["value"].to_numpy(float)

    def fit(self, frame: pd.DataFrame) -> Fit:
        """The fit that the claim's verdict rests on."""
        x, error = self.measured(frame)
        if self.n is None and not self.algebraic:
            late = x >= self.start
            return convergence_fits.geometric(
                x[late], error[late], floor=self.floor, power=self.power
            )
        used = (self.since < x) & (x <= self.until)
        return convergence_fits.algebraic(x[used], error[used], floor=self.floor)


def inside(fit: Fit, x: np.ndarray) -> np.ndarray:
    """Mask of the n or h inside the window of a fit; all False when there is no window."""
    low, high = min(fit.window), max(fit.window)
    return (x >= low * (1 - 1e-9)) & (x <= high * (1 + 1e-9))


DASHES = (0, (4, 2))
ABOVE = 0.03  # least offset of a claimed rate from the points, relative to the height of the axes


def convergence_in_n(
    axes: Axes, frame: pd.DataFrame, *, rates: Sequence[Rate], ylabel: str, top: float = np.inf
) -> None:
    """Errors on a logarithmic axis against the number of basis functions n.

    top  larger errors, of unstable runs, are shown as an arrow and a number at the edge
    """
    axes.set_yscale("log")
    axes.set(xlabel="number of basis functions $n$", ylabel=ylabel)
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    _lines(axes, frame, rates, "{}^{{\\,n}}", "{:.2f}^{{\\,n}}", top)


def convergence_in_h(
    axes: Axes, frame: pd.DataFrame, *, rates: Sequence[Rate], ylabel: str, top: float = np.inf,
    unit: str = "unit of time",
) -> None:  # fmt: skip
    """Errors against the step size h, both logarithmic; the slope of a line is its order."""
    axes.set(xscale="log", yscale="log", xlabel=f"step size $h$ [{unit}]", ylabel=ylabel)
    _lines(axes, frame, rates, "h^{{{}}}", "h^{{{:g}}}", top)
    readable(axes.xaxis)


def convergence_in_degree(
    axes: Axes, frame: pd.DataFrame, *, rates: Sequence[Rate], ylabel: str, top: float = np.inf
) -> None:
    """Errors against the degree N, which falls to the right, both logarithmic, of algebraic rates
    in N: refined to the left, as in plots against a step."""
    axes.set(xscale="log", yscale="log", xlabel="degree $N$", ylabel=ylabel)
    _lines(axes, frame, rates, "N^{{-{}}}", "N^{{-{:g}}}", top)
    low, high = (1.0 / x for x in reversed(axes.get_xlim()))
    shown = [n for k in range(9) for n in (2**k, 3 * 2**k) if low <= n <= high]
    axes.set_xticks([1.0 / n for n in shown], [str(n) for n in shown])
    axes.xaxis.set_minor_locator(NullLocator())


def _lines(
    axes: Axes,
    frame: pd.DataFrame,
    rates: Sequence[Rate],
    power: str,
    claimed_power: str,
    top: float,
) -> None:
    """Draw every series, then claimed rates and labels, which need the limits of the axes."""
    labels, fitted, hollow = [], [], False
    for k, rate in enumerate(rates):
        x, error = rate.measured(frame)
        positive = np.flatnonzero(error > 0)
        if not positive.size:
            continue
        fit = rate.fit(frame)
        color = COLOURS[k % len(COLOURS)]
        _series(axes, x, np.where(error > 0, error, np.nan), fit, color, MARKERS[k], top)
        hollow |= bool(np.any(~inside(fit, x)[positive]))
        text = rate.label
        if known(fit.rate):
            text += f"  ${power.format(concise(fit.rate, fit.uncertainty))}{_factor(fit.power)}$"
        if rate.claimed is not None:
            text += f"  (claimed ${claimed_power.format(rate.claimed)}$)"
            used = inside(fit, x) & (error > 0)
            if known(fit.rate):
                fitted.append((fit, rate.claimed, x[used], error[used]))
        right = positive[np.argmax(x[positive])]
        labels.append(
            Label(float(x[right]), float(min(error[right], top)), text, color, MARKERS[k])
        )
    if not labels:
        raise NoData("no run has a finite error.")
    decades(axes.yaxis)
    axes.autoscale_view()
    axes.autoscale(False)
    for one in fitted:
        _claimed(axes, *one)
    label_ends(axes, labels)
    if hollow:
        point = Line2D([], [], color=GUIDE, marker="o", markerfacecolor="white", linestyle="none")
        legend(axes, [point], ["not in the fit"])
    if fitted:
        legend(axes, [Line2D([], [], color=GUIDE, linestyle=DASHES)], ["claimed rate"])


def _series(
    axes: Axes,
    x: np.ndarray,
    error: np.ndarray,
    fit: Fit,
    color: str,
    marker: str,
    top: float,
) -> None:
    """Draw points (hollow outside the fit's window), the line through them and the fitted line."""
    used = inside(fit, x)
    shown = np.where(error <= top, error, np.nan)
    axes.plot(x, shown, color=color, linewidth=0.6, alpha=0.5)
    axes.plot(x[~used], shown[~used], marker, color=color, markerfacecolor="white")
    axes.plot(x[used], shown[used], marker, color=color)
    for there in np.flatnonzero(error > top):
        axes.plot(x[there], top, "^", color=color, markerfacecolor="white", clip_on=False)
        size = f"$10^{{{np.log10(error[there]):.0f}}}$"
        if any(one.get_text() == size and one.xy == (x[there], top) for one in axes.texts):
            continue  # of another line
        axes.annotate(
            size,
            (x[there], top),
            xytext=(5, -2),
            textcoords="offset points",
            color=color,
            fontsize=8,
        )
    if known(fit.rate):
        along = np.linspace(*fit.window, 50) if fit.power else np.array(fit.window)
        axes.plot(along, fit.evaluate(along), color=color)


def _factor(power: float) -> str:
    """The known factor of a geometric fit, as text."""
    return f"n^{{-{power:g}}}" if power else ""


def _claimed(axes: Axes, fit: Fit, claimed: float, x: np.ndarray, error: np.ndarray) -> None:
    """Draw the claimed rate, dashed, a little above all points (x, error) of the fit."""
    if not known(fit.rate):
        return

    def rate(x: np.ndarray) -> np.ndarray:
        return claimed**x if fit.kind == "geometric" else x**claimed

    ends = np.array(fit.window)
    low, high = axes.get_ylim()
    line = np.max(error / rate(x)) * rate(ends) * (high / low) ** ABOVE
    axes.plot(ends, line, color=GUIDE, linestyle=DASHES, linewidth=1.1)
