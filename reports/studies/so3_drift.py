"""The section on drift of rotations, momenta and energies over a million steps on SO(3)."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from benchmarks.statistics.drift import Growth, rms
from benchmarks.studies import so3_drift
from benchmarks.studies.so3_drift import QUANTITIES, ensembles, growths
from reports.figures.style.decades import decades, whole_decades
from reports.figures.style.identities import GUIDE, identity, in_order
from reports.figures.style.layout import (
    NoData,
    contender_legend,
    legend,
    mark_rounding,
    panels,
    share_y_label,
)
from reports.results.section import Figure, LongForm, Section
from reports.tables.number_format import known, readable, with_uncertainty
from reports.tables.study_table import without_empty_status

DASHES = (0, (5, 3))
TITLES = {
    "orthogonality": "off SO(3): $|R^T R - I|$",
    "momentum": r"momentum: $|R\mu - R_0\mu_0| / |\mu_0|$",
    "energy": "energy, relative",
}


def so3_drift_growth(axes: Axes, frame: pd.DataFrame) -> None:
    """A panel for each quantity, with a guide that grows as the square root of the steps."""
    found = [one for one in ensembles(frame) if np.all(np.isfinite(one[3]))]
    if not found:
        raise NoData("no ensemble of runs is complete.")
    names = in_order(ensemble["contender"] for ensemble, _, _, _ in found)
    places = panels(axes, len(QUANTITIES))
    share_y_label(places, "RMS over the runs [1]")
    for one, (name, text) in zip(places, QUANTITIES.items(), strict=True):
        one.set(xscale="log", yscale="log", xlabel="steps", title=TITLES.get(name, text))
        least, first, last = np.inf, np.inf, 0.0
        for ensemble, quantity, done, errors in found:
            if quantity != name:
                continue
            one.plot(done, rms(errors), markersize=3.0, **identity(ensemble["contender"]).style)
            first, last = min(first, done[0]), max(last, done[-1])
            least = min(least, float(rms(errors)[0]))
        one.autoscale_view()
        whole_decades(one.yaxis)
        one.autoscale(False)  # the guide, which begins at the data, widens no axis
        ends = np.array([first, last])
        one.plot(ends, least * np.sqrt(ends / first), color=GUIDE, linestyle=DASHES, linewidth=1.0)
        decades(one.xaxis)
        decades(one.yaxis)
        mark_rounding(one)
    contender_legend(one, names)
    legend(one, [Line2D([], [], color=GUIDE, linestyle=DASHES)], ["square root of the steps"])


SIGMAS = 3.0
NUMBERS = ("steps", "runs", "largest", "RMS at the end", "exponent")


def so3_drift_table(frame: pd.DataFrame) -> tuple[pd.DataFrame, dict[str, str]]:
    """A line for each ensemble and quantity, and the CSS classes of the columns."""
    lines = [
        {
            "contender": ensemble["contender"],
            "setting": ensemble["settings"],
            "quantity": QUANTITIES[name],
            "steps": readable(float(ensemble["steps"]), 1),
            "runs": str(seen.runs),
            "largest": readable(largest),
            "RMS at the end": readable(seen.final),
            "exponent": with_uncertainty(seen.exponent, seen.uncertainty) or "not resolved",
            "verdict": growth_text(seen),
            "status": ensemble["status"],
            "commit": ensemble["commit"],
            "date": ensemble["date"],
        }
        for ensemble, name, seen, largest in growths(frame)
    ]
    return without_empty_status(pd.DataFrame(lines)), dict.fromkeys(NUMBERS, "number")


def growth_text(seen: Growth) -> str:
    """Where the exponent lies beside one half, within three standard errors, as text."""
    if not (known(seen.exponent) and known(seen.uncertainty)):
        return "not judged"
    if seen.exponent <= 0.5:
        return "at most the square root"
    if seen.exponent - SIGMAS * seen.uncertainty > 0.5:
        return "faster than the square root"
    return f"not distinguishable from the square root ({SIGMAS:g} standard errors)"


def drifts(frame: pd.DataFrame) -> str:
    """A sentence for each mean error that drifts."""
    return " ".join(
        f"{ensemble['contender']}: the {QUANTITIES[name]} drifts, by {readable(seen.drift, 2)} "
        f"per step in the mean of the runs ({readable(abs(seen.sigmas), 2)} standard errors), to "
        f"{readable(largest, 2)} at most in {readable(float(ensemble['steps']), 1)} steps: a bias "
        "below the rounding of one step."
        for ensemble, name, seen, largest in growths(frame)
        if seen.drifts
    )


SO3_DRIFT = Section(
    name="turning",
    title="A million steps on SO(3)",
    text="H's free body from several starts that differ by 1e-12. Its exact "
    "motion keeps R a rotation and R mu constant; rounding may move them like the square root "
    "of the steps. The first two methods, with as many stages as their degree, run in the "
    "packed kernel. It carries a quaternion, normalised when converted to R, and the momentum in "
    "space, which is constant for a free body, both with their low parts: R and R mu are kept by "
    "construction, and the energy is the test. The third method runs in the general kernel, which "
    "carries R and the momentum in space without low parts, and after each step projects R by "
    "R <- R (3 I - R^T R) / 2. Exponents "
    "of the RMS over the runs are fitted over the later two decades, and compared with 1/2 by "
    "three standard errors.",
    measure=so3_drift.turning,
    figures=(
        Figure(
            name="turning",
            title="Rotations, momenta and energies of long runs",
            draw=so3_drift_growth,
            caption="RMS over the runs. Dashed: growth like the square root of the steps.",
            size=(9.6, 3.4),
        ),
    ),
    table=so3_drift_table,
    summary=drifts,
    long_form=LongForm(so3_drift.parts, so3_drift.stored),
    open=True,
)
