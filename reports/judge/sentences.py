"""The findings of a judgement in sentences."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from benchmarks.applications.judging.bodies import MOST_STATES
from benchmarks.applications.judging.judgement import YOURS, Judgement
from benchmarks.applications.judging.truth import Agreement, time_text
from galvi import End
from reports.tables.number_format import readable, seconds

TRUSTED = 0.1  # share of an error that the truth may be wrong by
MOST_NAMED = 3  # integrators as fast as the cheapest
ENCOUNTERS = (
    "galvi's clock and IAS15, whose steps follow them, and TRACE and MERCURIUS, which switch "
    "methods, are made for them. Codes of fixed step (WHFast, SABA, leapfrog, galvi without a "
    "clock) are not: one that reaches the error here may miss it in a closer encounter."
)


def sentences(found: Judgement) -> list[str]:
    """What a reader wants to know first, the user's own run before all."""
    length = found.kind.unit(found.problem, "length")
    result = [*own_run(found), truth(found)]
    asked, best = f"an error of {readable(found.error)}{length}", found.recommended
    if best is not None:
        result.append(_cheapest(found, best, asked))
    elif found.truth_agreement <= found.error or math.isnan(found.truth_agreement):
        result.append(f"Nothing that was tried reaches {asked}.")
    return result + _encounters(found) + _horizon(found)


def own_run(found: Judgement) -> list[str]:
    """What is found of the user's own run."""
    own, worst = found.own, found.parts.iloc[found.parts["largest_error"].argmax()]
    length, time = (found.kind.unit(found.problem, one) for one in ("length", "time"))
    if math.isnan(own["error"]):
        return [f"Your run ({own['integrator']}) does not reach the end. {own['status']}"]
    energy = f"Its relative energy error is {readable(own['energy'])}."
    if math.isnan(own["energy"]):
        energy = "Its forces do work, so its energy is not conserved."
    backwards = ", backwards" if found.duration < 0.0 else ""
    result = [
        f"Your run ({own['integrator']}) is off by up to {readable(own['error'])}{length} over "
        f"{readable(abs(found.duration))}{time}{backwards}, and by "
        f"{readable(own['last_error'])} at the end (measured at {len(found.own_errors) - 1} times, "
        f"not between them; the worst {found.kind.PART} is {worst.iloc[0]}). {energy} It takes "
        f"{timing(own)}."
    ]
    if math.isinf(own["unstopped_error"]):
        result.append("Run without stops at these times, which shorten its steps, it fails.")
    elif not math.isnan(own["unstopped_error"]):
        result.append(
            f"Run to the end without stops at these times, which shorten its steps, it is off by "
            f"{readable(own['unstopped_error'])}{length} there."
        )
    if own["end"] != End.COMPLETED.value or own["remarks"]:
        result.append(f"Its status: {own['status']}")
    return result


def timing(row: Mapping[str, Any]) -> str:
    """The seconds of a run with their spread."""
    if math.isnan(row["seconds_low"]):
        return f"{seconds(row['seconds'])} (timed once)"
    low, high = (seconds(row[f"seconds_{one}"]) for one in ("low", "high"))
    return f"{seconds(row['seconds'])} (quartiles {low} and {high})"


def _cheapest(found: Judgement, best: Mapping[str, Any], asked: str) -> str:
    own, others = found.own, found.table[found.table["reached"]].iloc[1:]
    ties = others[others["seconds_low"] <= best["seconds_high"]]
    mine = (ties["setting"] == own["setting"]) & ties["integrator"].str.endswith(YOURS)
    names = ties[~mine & (ties["integrator"] != best["integrator"])]["integrator"].unique()
    if best["integrator"].endswith(YOURS) and best["setting"] == own["setting"]:
        text = f"Of all that was tried, your own run reaches {asked} at the lowest cost"
    else:
        text = (
            f"The cheapest that reaches {asked} is {best['integrator']}, {best['setting']}: error "
            f"{readable(best['error'])}, in {timing(best)}"
        )
        if own["seconds"] > best["seconds"] and not math.isnan(own["error"]):
            alike = own["seconds_low"] <= best["seconds_high"]
            text += ", within quartiles no faster than your run" if alike else (
                f", {_times(own, best)} times as fast as your run"
            )  # fmt: skip
    if not names.size:
        return f"{text}."
    listed = "; ".join(names) if names.size <= MOST_NAMED else f"{names.size} others"
    return f"{text}. As fast, within quartiles: {listed}."


def _times(own: Mapping[str, Any], best: Mapping[str, Any]) -> str:
    """How often the best run fits into the own one, from quartile to quartile."""
    ratios = [own["seconds_low"] / best["seconds_high"], own["seconds_high"] / best["seconds_low"]]
    if any(math.isnan(one) for one in ratios):
        ratios = [own["seconds"] / best["seconds"]]
    return " to ".join(dict.fromkeys(f"{float(f'{one:.2g}'):g}" for one in ratios))


def truth(found: Judgement) -> str:
    """What the truth is, and how well it is known."""
    text = f"The truth is {found.source.label}; runs of galvi are never the truth."
    compared = [one for one in found.agreements if one.t.size > 1]
    agreeing = [one for one in compared if one.largest <= found.error]
    theirs = [one for one in agreeing if not one.source.opinion]
    if theirs:
        text += f" It agrees with {'; with '.join(_until(found, one) for one in theirs)}."
    for one in found.agreements:
        if one.source.opinion or one in agreeing:
            continue
        text += (
            f" {one.source.label} differs from it by up to {_extent(found, one)}."
            if one.t.size > 1
            else f" {one.source.label} ends too early to be compared."
        )
    for one in agreeing:
        if one.source.opinion and not one.stopped:
            text += f" {one.source.label} agrees too, to {_extent(found, one)}."
    if len(found.engines) == 1:
        how = f": {found.more}" if found.more else ""
        text += f" All of it rests on one engine, {found.engines[0]}{how}."
    if math.isfinite(found.trusted_until):
        elapsed = abs(found.trusted_until - found.problem.t0)
        text += (
            f" After t = {time_text(found.truth, found.trusted_until)} the sources part, and "
            f"nothing can be judged: give --duration {elapsed:.6g}, in galvi.judge "
            f"duration={elapsed:.6g}."
            if elapsed > 0.0
            else f" The sources part before t = {_first_compared(found)}, when they are first "
            f"compared: nothing can be judged. Ask for a shorter duration."
        )
    elif found.truth_agreement > found.error:
        text += " Smaller errors cannot be measured: ask for a larger one or a shorter duration."
    elif found.truth_agreement > TRUSTED * found.error:
        text += " That is close to the error asked for: errors near it are uncertain."
    return text


def _first_compared(found: Judgement) -> str:
    times = [float(one.t[1]) for one in found.agreements if one.t.size > 1]
    return time_text(found.truth, min(times, key=lambda t: abs(t - found.problem.t0)))


def _until(found: Judgement, one: Agreement) -> str:
    return f"{one.source.label}, to {_extent(found, one)}"


def _extent(found: Judgement, one: Agreement) -> str:
    words = readable(one.largest)
    if one.stopped:
        words += f" up to t = {time_text(found.truth, one.t[-1])}, where {one.stopped}"
    return words


def _encounters(found: Judgement) -> list[str]:
    result, count = [], len(found.encounters)
    if len(found.truth.t) > MOST_STATES and len(found.encounters.columns):
        result.append("The run is too long for a search of all of it: encounters may be missing.")
    if count:
        nearest = found.encounters.iloc[0]
        many = f"There are {count} close encounters; the closest" if count > 1 else (
            "There is a close encounter; it"
        )  # fmt: skip
        fixed = found.table["reached"] & found.table["setting"].str.startswith("dt")
        unresolved = f", and no fixed step that was tried resolves {'them' if count > 1 else 'it'}"
        when = time_text(found.truth, nearest["time"])
        result.append(
            f"{many} is that of {nearest['bodies']} at t = {when}, at "
            f"{readable(nearest['hill_radii'])} mutual Hill radii"
            f"{'' if fixed.any() else unresolved}. {ENCOUNTERS}"
        )
    if count and "outputs" in found.encounters:
        every = readable(found.problem.parameters["output_every"])
        missed = int((found.encounters["outputs"] == 0).sum())
        result.append(
            f"Your output every {every}{found.kind.unit(found.problem, 'time')} misses {missed} of "
            f"{count} encounters: no state of it falls into them. galvi.find_events sees each."
        )
    return result


def _horizon(found: Judgement) -> list[str]:
    if found.horizons.empty:
        return []
    t0, rows = found.problem.t0, list(found.horizons.itertuples())
    whole = [row.start_known_to for row in rows if math.isnan(row.until)]
    later = [row for row in rows if not math.isnan(row.until) and row.until != t0]
    ends = [(row.start_known_to, f"until t = {time_text(found.truth, row.until)}")
            for row in later[-1:]]  # fmt: skip
    ends += [(max(whole), "until the end")] if whole else []
    if not ends:
        return [
            "Even from a start known to a relative 1e-15 the motion is soon unpredictable to "
            "within that error, whatever the integrator."
        ]
    (known, until), *longer = ends
    text = (
        f"From a start known to a relative {known:g} the motion is predictable to within that "
        f"error {until}, whatever the integrator"
    )
    return [text + "".join(f"; from one known to {one:g}, {end}" for one, end in longer) + "."]
