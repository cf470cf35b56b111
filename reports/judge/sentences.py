"""The findings of a judgement in sentences."""

from __future__ import annotations

import math

from benchmarks.applications.judging.bodies import MOST_STATES, unit
from benchmarks.applications.judging.judgement import Judgement
from benchmarks.applications.judging.truth import Agreement, time_text
from reports.tables.number_format import readable, seconds

TRUSTED = 0.1  # share of an error that the truth may be wrong by


def sentences(found: Judgement) -> list[str]:
    """What a reader wants to know first, the user's own run before all."""
    length = unit(found.problem, "length")
    asked = f"an error of {readable(found.error)}{length}"
    result = [*own_run(found), _truth(found)]
    own, best = found.own, found.recommended
    if best is not None:
        faster = own["seconds"] / best["seconds"]
        whole = faster > 1.0 and not math.isnan(own["error"])
        compared = f", {float(f'{faster:.2g}'):g} times as fast as your run" if whole else ""
        result.append(
            f"The cheapest that reaches {asked} is {best['integrator']}, "
            f"{best['setting']}: {readable(best['error'])} in {seconds(best['seconds'])}{compared}."
        )
    elif found.truth_agreement <= found.error or math.isnan(found.truth_agreement):
        result.append(f"Nothing that was tried reaches {asked}.")
    result += _encounters(found)
    return result + _horizon(found)


def own_run(found: Judgement) -> list[str]:
    """What is found of the user's own run."""
    own, worst = found.own, found.parts.iloc[found.parts["largest_error"].argmax()]
    length, time = (unit(found.problem, kind) for kind in ("length", "time"))
    if math.isnan(own["error"]):
        return [f"Your run ({own['integrator']}) does not reach the end. {own['status']}"]
    changed = f"the energy changes by {readable(own['energy'])} of itself"
    if math.isnan(own["energy"]):
        changed = "its energy is not conserved, as it is damped"
    backwards = ", backwards" if found.duration < 0.0 else ""
    result = [
        f"Your run ({own['integrator']}) is wrong by up to {readable(own['error'])}{length} "
        f"over a time of {readable(abs(found.duration))}{time}{backwards}, most for "
        f"{worst.iloc[0]}; {changed}. It takes {seconds(own['seconds'])}."
    ]
    return result + ([] if own["status"] == "Completed." else [f"Its status: {own['status']}"])


def _truth(found: Judgement) -> str:
    text = f"The truth is {found.source.label}."
    agreeing = [one for one in found.agreements if one.largest <= found.error]
    agreeing = [one for one in agreeing if one.t.size > 1 and not (one.stopped and _opinion(one))]
    parting = [one for one in found.agreements if one not in agreeing and not _opinion(one)]
    if agreeing:
        text += f" With it agree {'; '.join(_until(found, one) for one in agreeing)}."
    for one in parting:
        text += (
            f" It differs from {one.source.label} by up to {_until(found, one, prefix='')}."
            if one.t.size > 1
            else f" {one.source.label} ends too early to be compared."
        )
    if len(found.engines) == 1:
        more = f": {found.kind.MORE} adds another" if found.kind.MORE else ""
        text += f" All but galvi's are of one engine only, {found.engines[0]}{more}."
    if math.isfinite(found.trusted_until):
        elapsed = abs(found.trusted_until - found.problem.t0)
        text += (
            f" After t = {time_text(found.truth, found.trusted_until)} these part, and nothing can "
            f"be judged: take --duration {elapsed:.6g}, in galvi.judge duration={elapsed:.6g}."
            if elapsed > 0.0
            else " These part at once: nothing can be judged."
        )
    elif found.truth_agreement > found.error:
        text += " Errors below that cannot be told: ask for a larger one or a shorter duration."
    elif found.truth_agreement > TRUSTED * found.error:
        text += " That is not far below the error asked for: errors near it are bounds."
    return text


def _opinion(one: Agreement) -> bool:
    return one.source.opinion


def _until(found: Judgement, one: Agreement, prefix: str = "to ") -> str:
    words = f"{prefix}{readable(one.largest)}"
    if prefix:
        words = f"{one.source.label}, {words}"
    if one.stopped:
        words += f" until t = {time_text(found.truth, one.t[-1])}, as {one.stopped}"
    return words


def _encounters(found: Judgement) -> list[str]:
    result, count = [], len(found.encounters)
    if len(found.truth.t) > MOST_STATES and len(found.encounters.columns):
        result.append(
            "This is too long a time to look for all close encounters: some may be missing."
        )
    if count:
        nearest = found.encounters.iloc[0]
        many = f"There are {count} close encounters; the closest" if count > 1 else (
            "There is a close encounter; it"
        )  # fmt: skip
        fixed = found.table["reached"] & found.table["setting"].str.startswith("dt")
        unresolved = ", and no fixed step that was tried resolves them" if count > 1 else (
            ", and no fixed step that was tried resolves it"
        )  # fmt: skip
        when = time_text(found.truth, nearest["time"])
        result.append(
            f"{many} is of {nearest['bodies']} at t = {when}, at "
            f"{readable(nearest['hill_radii'])} Hill radii{'' if fixed.any() else unresolved}."
        )
    return result


def _horizon(found: Judgement) -> list[str]:
    if found.horizons.empty:
        return []
    t0, rows = found.problem.t0, list(found.horizons.itertuples())
    whole = [row.start_known_to for row in rows if math.isnan(row.until)]
    later = [row for row in rows if not math.isnan(row.until) and row.until != t0]
    text = "Neighbouring starts stay together: " if not later else "Neighbouring starts part: "
    ends = []
    if later:
        ends.append(
            f"one known to {later[-1].start_known_to:g} of itself predicts the motion to that "
            f"error until t = {time_text(found.truth, later[-1].until)}, whichever integrator is "
            f"used"
        )
    if whole:
        ends.append(f"starts known to {max(whole):g} of themselves predict all of this time")
    if not ends:
        return ["Even a start known to 1e-15 of itself is soon wrong by more than this error."]
    return [text + "; ".join(ends) + "."]
