"""The findings of a judgement in sentences."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from benchmarks.applications.judging.bodies import MOST_STATES
from benchmarks.applications.judging.judgement import OWN_SUFFIX, Judgement
from benchmarks.applications.judging.truth import Agreement, time_text
from galvi import End
from reports.tables.number_format import plain, readable, seconds

NEGLIGIBLE_FRACTION = 0.1  # fraction of an error up to which the truth's own error is negligible
MAX_NAMED = 3  # largest number of equally fast integrators that are named
ADVICE_ON_ENCOUNTERS = (
    "galvi's clock and IAS15, whose steps follow them, and TRACE and MERCURIUS, which switch "
    "methods, are made for them. Codes of fixed step (WHFast, SABA, leapfrog, galvi without a "
    "clock) are not: one that reaches the error here may miss it in a closer encounter."
)


def sentences(judgement: Judgement) -> list[str]:
    """All sentences of a judgement; those on the user's own run come first."""
    return [
        *own_run(judgement),
        truth(judgement),
        *cheapest(judgement),
        *encounters(judgement),
        *horizon(judgement),
    ]


def unit(judgement: Judgement, dimension: str) -> str:
    """The unit of a length or a time, after a space."""
    return judgement.kind.unit(judgement.problem, dimension)


def own_run(judgement: Judgement) -> list[str]:
    """Sentences on the user's own run: its errors, energy, time and status."""
    run, length = judgement.own, unit(judgement, "length")
    if math.isnan(run["error"]):
        return [f"Your run ({run['integrator']}) does not reach the end. {run['status']}"]
    worst = judgement.parts.iloc[judgement.parts["largest_error"].argmax()]
    energy = f"Its relative energy error is {readable(run['energy'])}."
    if math.isnan(run["energy"]):
        energy = "Its forces do work, so its energy is not conserved."
    backwards = ", backwards" if judgement.duration < 0.0 else ""
    lines = [
        f"Your run ({run['integrator']}) is off by up to {readable(run['error'])}{length} over "
        f"{readable(abs(judgement.duration))}{unit(judgement, 'time')}{backwards}, and by "
        f"{readable(run['last_error'])} at the end (measured at {len(judgement.own_errors) - 1} "
        f"times, not between them; the worst {judgement.kind.PART} is {worst.iloc[0]}). {energy} "
        f"It takes {timing(run)}."
    ]
    unstopped = run["unstopped_error"]
    if not math.isnan(unstopped):
        error_clause = f"it is off by {readable(unstopped)}{length} there"
        lines.append(
            "Run without stops at these times, which shorten its steps, it fails."
            if math.isinf(unstopped)
            else "Run to the end without stops at these times, which shorten its steps, "
            f"{error_clause}."
        )
    if run["end"] != End.COMPLETED.value or run["remarks"]:
        lines.append(f"Its status: {run['status']}")
    return lines


def timing(row: Mapping[str, Any]) -> str:
    """The seconds of a run with their spread."""
    median, low, high = (seconds(row[name]) for name in ("seconds", "seconds_low", "seconds_high"))
    return f"{median} (quartiles {low} and {high})" if low else f"{median} (timed once)"


def truth(judgement: Judgement) -> str:
    """Sentences on the source of the truth, its agreement with other sources, and its limits."""
    comparable = [agreement for agreement in judgement.agreements if agreement.t.size > 1]
    agreeing = [agreement for agreement in comparable if agreement.largest <= judgement.error]
    lines = [f"The truth is {judgement.source.label}; runs of galvi are never the truth."]
    sources = "; with ".join(
        f"{agreement.source.label}, to {_extent(judgement, agreement)}"
        for agreement in agreeing
        if not agreement.source.is_galvi
    )
    lines += [f"It agrees with {sources}."] if sources else []
    for agreement in judgement.agreements:
        if agreement.source.is_galvi or agreement in agreeing:
            continue
        lines.append(
            f"{agreement.source.label} differs from it by up to {_extent(judgement, agreement)}."
            if agreement in comparable
            else f"{agreement.source.label} ends too early to be compared."
        )
    lines += [
        f"{agreement.source.label} agrees too, to {_extent(judgement, agreement)}."
        for agreement in agreeing
        if agreement.source.is_galvi and not agreement.stopped
    ]
    if len(judgement.engines) == 1:
        hint = f": {judgement.engine_hint}" if judgement.engine_hint else ""
        lines.append(f"All of it rests on one engine, {judgement.engines[0]}{hint}.")
    return " ".join(filter(None, (*lines, _doubts(judgement, comparable))))


def _extent(judgement: Judgement, agreement: Agreement) -> str:
    """The largest distance of two sources as text; if one of them stopped, also when and why."""
    size = readable(agreement.largest)
    if not agreement.stopped:
        return size
    return (
        f"{size} up to t = {time_text(judgement.truth, agreement.t[-1])}, where {agreement.stopped}"
    )


def _doubts(judgement: Judgement, comparable: list[Agreement]) -> str:
    """A sentence on the errors or times that this truth cannot judge; "" without such a limit."""
    problem, agreement = judgement.problem, judgement.truth_agreement
    if math.isfinite(judgement.trusted_until):
        elapsed = abs(judgement.trusted_until - problem.t0)
        first = min((agreement.t[1] for agreement in comparable), key=lambda t: abs(t - problem.t0))
        return (
            f"After t = {time_text(judgement.truth, judgement.trusted_until)} the sources part, "
            f"and nothing can be judged: give --duration {elapsed:.6g}, in galvi.judge "
            f"duration={elapsed:.6g}."
            if elapsed > 0.0
            else f"The sources part before t = {time_text(judgement.truth, first)}, when they are "
            "first compared: nothing can be judged. Ask for a shorter duration."
        )
    if agreement > judgement.error:
        return "Smaller errors cannot be measured: ask for a larger one or a shorter duration."
    if agreement > NEGLIGIBLE_FRACTION * judgement.error:
        return "That is close to the error asked for: errors near it are uncertain."
    return ""


def cheapest(judgement: Judgement) -> list[str]:
    """A sentence on the cheapest run that reaches the error, and on integrators that are as fast.

    An empty list if nothing reaches the error and the truth is too uncertain to show that.
    """
    run, best = judgement.own, judgement.recommended
    error = f"an error of {readable(judgement.error)}{unit(judgement, 'length')}"
    if best is None:
        measurable = not judgement.truth_agreement > judgement.error
        return [f"Nothing that was tried reaches {error}."] if measurable else []
    reached = judgement.table[judgement.table["reached"]]
    is_own = reached["integrator"].str.endswith(OWN_SUFFIX) & (reached["setting"] == run["setting"])
    if is_own.iloc[0]:
        text = f"Of all that was tried, your own run reaches {error} at the lowest cost"
    else:
        text = (
            f"The cheapest that reaches {error} is {best['integrator']}, {best['setting']}: error "
            f"{readable(best['error'])}, in {timing(best)}{_gain(run, best)}"
        )
    is_as_fast = reached["seconds_low"] <= best["seconds_high"]
    rivals = reached["integrator"][
        is_as_fast & ~is_own & (reached["integrator"] != best["integrator"])
    ]
    names = list(rivals.unique())
    if names:
        listed = "; ".join(names) if len(names) <= MAX_NAMED else f"{len(names)} others"
        text += f". As fast, within quartiles: {listed}"
    return [f"{text}."]


def _gain(run: Mapping[str, Any], best: Mapping[str, Any]) -> str:
    """A clause on how many times as fast as the user's run the best one is, from quartile to
    quartile; "" if it is not faster or the user's run has no error."""
    if not run["seconds"] > best["seconds"] or math.isnan(run["error"]):
        return ""
    if run["seconds_low"] <= best["seconds_high"]:
        return ", within quartiles no faster than your run"
    ratios = [run["seconds_low"] / best["seconds_high"], run["seconds_high"] / best["seconds_low"]]
    if any(math.isnan(ratio) for ratio in ratios):
        ratios = [run["seconds"] / best["seconds"]]
    times = " to ".join(dict.fromkeys(plain(ratio, 2) for ratio in ratios))
    return f", {times} times as fast as your run"


def encounters(judgement: Judgement) -> list[str]:
    """Sentences on close encounters, and on whether fixed steps and the user's output resolve
    them."""
    meetings, lines = judgement.encounters, []
    if len(judgement.truth.t) > MOST_STATES and len(meetings.columns):
        lines.append("The run is too long for a search of all of it: encounters may be missing.")
    if meetings.empty:
        return lines
    count, nearest = len(meetings), meetings.iloc[0]
    beginning, pronoun = "There is a close encounter; it", "it"
    if count > 1:
        beginning, pronoun = f"There are {count} close encounters; the closest", "them"
    has_fixed_step = judgement.table["reached"] & judgement.table["setting"].str.startswith("dt")
    unresolved = (
        "" if has_fixed_step.any() else f", and no fixed step that was tried resolves {pronoun}"
    )
    lines.append(
        f"{beginning} is that of {nearest['bodies']} at "
        f"t = {time_text(judgement.truth, nearest['time'])}, at {readable(nearest['hill_radii'])} "
        f"mutual Hill radii{unresolved}. {ADVICE_ON_ENCOUNTERS}"
    )
    if "outputs" in meetings:
        interval = readable(judgement.problem.parameters["output_every"]) + unit(judgement, "time")
        lines.append(
            f"Your output every {interval} misses {(meetings['outputs'] == 0).sum()} of {count} "
            "encounters: no state of it falls into them. galvi.find_events sees each."
        )
    return lines


def horizon(judgement: Judgement) -> list[str]:
    """A sentence on the time up to which starts of a given accuracy predict the motion; [] where
    that was not examined."""
    table = judgement.horizons
    is_beyond_end = table["until"].isna()
    within = table[~is_beyond_end & (table["until"] != judgement.problem.t0)]
    ends = [
        (row.start_known_to, f"until t = {time_text(judgement.truth, row.until)}")
        for row in within.tail(1).itertuples()
    ]
    if is_beyond_end.any():
        ends.append((table.loc[is_beyond_end, "start_known_to"].max(), "until the end"))
    if table.empty:
        return []
    if not ends:
        return [
            "Even from a start known to a relative 1e-15 the motion is soon unpredictable to "
            "within that error, whatever the integrator."
        ]
    (digits, until), *longer = ends
    return [
        f"From a start known to a relative {digits:g} the motion is predictable to within that "
        f"error {until}, whatever the integrator"
        + "".join(f"; from one known to {digits:g}, {end}" for digits, end in longer)
        + "."
    ]
