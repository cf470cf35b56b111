"""The section on the growth of round-off in the energy of long runs: Brouwer's law."""

from __future__ import annotations

from functools import partial

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from benchmarks.statistics.drift import Growth, rms
from benchmarks.studies import round_off
from benchmarks.studies.round_off import FRAME, brouwer, ensembles, growths, reading_floor
from reports.figures.style.decades import decades
from reports.figures.style.identities import GUIDE, identity, in_order
from reports.figures.style.layout import NoData, legend
from reports.results.section import Figure, LongForm, Section
from reports.tables.number_format import known, readable, with_uncertainty
from reports.tables.study_table import without_empty_status


def energy_growth(axes: Axes, frame: pd.DataFrame) -> None:
    """The RMS of each ensemble with its single runs, a guide that grows as t^1/2, and the error
    made by rounding one state to float64.

    Where several versions of the code were run, the newest is drawn.
    """
    newest = {}
    for ensemble, t, errors in ensembles(frame) if len(frame) else ():
        key = (ensemble["contender"], ensemble["years"])
        if key not in newest or ensemble["date"] >= newest[key][0]["date"]:
            newest[key] = (ensemble, t, errors)
    seen = [one for one in newest.values() if np.any(rms(one[2]) > 0.0)]
    if not seen:
        raise NoData("no ensemble of runs is complete.")
    names = in_order(ensemble["contender"] for ensemble, _, _ in seen)
    styles = {name: identity(name).style for name in names}
    settings: dict[str, dict[str, None]] = {}
    for ensemble, t, errors in seen:
        color = styles[ensemble["contender"]]["color"]
        axes.plot(t, np.abs(errors).T, color=color, linewidth=0.4, alpha=0.13)
        settings.setdefault(ensemble["contender"], {})[ensemble["settings"]] = None
    handles = [
        Line2D([], [], label="\n".join([name, *settings[name]]), **style)
        for name, style in styles.items()
    ]
    for ensemble, t, errors in seen:
        axes.plot(t, rms(errors), markersize=3.5, **styles[ensemble["contender"]])
    handles += _guides(axes, seen, reading_floor(frame))
    axes.set(
        xscale="log", yscale="log", xlabel="time [years]", ylabel="relative energy error, RMS [1]"
    )
    top = max(float(np.nanmax(np.abs(errors))) for _, _, errors in seen)
    bottom = min(float(np.nanmin(rms(errors))) for _, _, errors in seen)
    axes.set_ylim(0.2 * bottom, 2.0 * top)
    decades(axes.xaxis)
    decades(axes.yaxis)
    legend(axes, handles, [str(one.get_label()) for one in handles])


def _guides(axes: Axes, seen: list, floor: float) -> list[Line2D]:
    """Below the data: t^1/2 from the lowest first point, and the rounding error of one state."""
    first = min(t[0] for _, t, _ in seen)
    last = max(t[-1] for _, t, _ in seen)
    low = 0.5 * min(float(np.nanmin(rms(errors) / np.sqrt(t))) for _, t, errors in seen)
    ends = np.array([first, last])
    lines = axes.plot(ends, low * np.sqrt(ends), color=GUIDE, linestyle=(0, (5, 3)), linewidth=1.0,
                      label="$t^{1/2}$")  # fmt: skip
    if floor > 0.0:
        rounding = axes.axhline(floor, color=GUIDE, linestyle=(0, (1, 2)), linewidth=0.9, zorder=1)
        rounding.set_label("rounding of one state")
        lines.append(rounding)
    return lines


NUMBERS = ("years", "runs", "RMS error", "exponent", "drift / its error")
GROWS, SIGMAS = 0.25, 3.0  # exponent, by standard errors, below that of a walk and of a drift


def round_off_table(frame: pd.DataFrame) -> tuple[pd.DataFrame, dict[str, str]]:
    """A line for each ensemble, and the CSS classes of the columns."""
    lines = [
        {
            "contender": ensemble["contender"],
            "setting": ensemble["settings"],
            "years": readable(ensemble["years"], 1),
            "runs": str(seen.runs),
            "RMS error": readable(seen.final),
            "exponent": with_uncertainty(seen.exponent, seen.uncertainty) or "not resolved",
            "drift / its error": readable(seen.sigmas, 2),
            "verdict": _drift_text(seen),
            "status": ensemble["status"],
            "commit": ensemble["commit"],
            "date": ensemble["date"],
        }
        for ensemble, seen in growths(frame)
    ]
    return without_empty_status(pd.DataFrame(lines)), dict.fromkeys(NUMBERS, "number")


def _drift_text(seen: Growth) -> str:
    if not known(seen.sigmas):
        return "not judged"
    if seen.drifts and seen.exponent + SIGMAS * seen.uncertainty < GROWS:
        return "alike in all runs, no growth"  # truncation error, not round-off
    return "drifts" if seen.drifts else "no drift seen"


ROUND_OFF = Section(
    name="brouwer",
    title="Round-off",
    text="The outer solar system from 32 starts that differ by 1e-12. "
    "Unbiased rounding moves the energy at random: its RMS over the runs grows as t^(1/2), and its "
    "mean does not drift. Exponents are fitted over the later two decades of time, with the "
    "bootstrap standard error over the runs; a drift is a mean that the scatter of the runs would "
    "give less than once in 10000 times. Energies are computed with 32 digits, galvi's including "
    "the low parts of its state, which it keeps; REBOUND returns rounded states, and times at "
    "which that rounding hides its error are left out of its fit. The Kepler frame also "
    "returns rounded states; its runs are ten times as long.",
    measure=partial(brouwer, longer=(FRAME,)),
    figures=(
        Figure(
            name="brouwer",
            title="Energy error of long runs",
            draw=energy_growth,
            caption="RMS over the runs; faint, the size of each run's error. Blue: galvi.",
            size=(6.0, 4.4),
        ),
    ),
    table=round_off_table,
    long_form=LongForm(round_off.parts, round_off.stored),
    open=True,
)
