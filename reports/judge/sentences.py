"""The findings of a judgement in sentences."""

from __future__ import annotations

import math

from benchmarks.judging.bodies import MOST_STATES, unit
from benchmarks.judging.judgement import Judgement
from reports.tables.number_format import readable, seconds

TRUSTED = 0.1  # share of an error that the truth may be wrong by


def sentences(found: Judgement) -> list[str]:
    """What a reader wants to know first, the user's own run before all."""
    own, worst = found.own, found.parts.iloc[found.parts["largest_error"].argmax()]
    length, time = (unit(found.problem, kind) for kind in ("length", "time"))
    asked = f"an error of {readable(found.error)}{length}"
    if math.isnan(own["error"]):
        result = [f"Your run ({own['integrator']}) does not reach the end. {own['status']}"]
    else:
        changed = f"the energy changes by {readable(own['energy_error'])} of itself"
        if math.isnan(own["energy_error"]):
            changed = "its energy is not conserved, as it is damped"
        result = [
            f"Your run ({own['integrator']}) is wrong by up to {readable(own['error'])}{length} "
            f"over a time of {readable(found.duration)}{time}, most for {worst.iloc[0]}; "
            f"{changed}. It takes {seconds(own['seconds'])}."
        ]
        result += [] if own["status"] == "Completed." else [f"Its status: {own['status']}"]
    result.append(_truth(found))
    best = found.recommended
    if best is None:
        result.append(f"Nothing that was tried reaches {asked}.")
    else:
        faster = own["seconds"] / best["seconds"]
        whole = faster > 1.0 and not math.isnan(own["error"])
        compared = f", {float(f'{faster:.2g}'):g} times as fast as your run" if whole else ""
        result.append(
            f"The cheapest that reaches {asked} is {best['integrator']}, "
            f"{best['setting']}: {readable(best['error'])} in {seconds(best['seconds'])}{compared}."
        )
    if len(found.truth.t) > MOST_STATES and len(found.encounters.columns):
        result.append(
            "This is too long a time to look for all close encounters: some may be missing."
        )
    if len(found.encounters):
        nearest, count = found.encounters.iloc[0], len(found.encounters)
        many = f"{count} close encounters were" if count > 1 else "A close encounter was"
        result.append(
            f"{many} found, which no fixed step resolves; "
            f"the closest is of {nearest['bodies']} at t = {nearest['time']:.6g}, at "
            f"{readable(nearest['hill_radii'])} Hill radii."
        )
    result.append(_horizon(found))
    return result


def _truth(found: Judgement) -> str:
    text = f"The truth is {found.source.label}."
    others = [f"{one.source.label}, to {readable(one.largest)}" for one in found.agreements]
    text += f" With it agree {'; '.join(others)}." if others else ""
    if len(found.engines) == 1:
        more = f": {found.kind.MORE} adds another" if found.kind.MORE else ""
        text += f" All but galvi's are of one engine only, {found.engines[0]}{more}."
    if math.isfinite(found.trusted_until):
        elapsed = found.trusted_until - found.problem.t0
        text += (
            f" After t = {found.trusted_until:.6g} these part, and nothing can be judged: take "
            f"--duration {elapsed:.6g}."
            if elapsed > 0.0
            else " These part at once: nothing can be judged."
        )
    elif found.truth_agreement > TRUSTED * found.error:
        text += " That is not far below the error asked for: errors near it are bounds."
    return text


def _horizon(found: Judgement) -> str:
    ends = [row for row in found.horizons.itertuples() if not math.isnan(row.until)]
    later = [row for row in ends if row.until > found.truth.problem.t0]
    if not ends:
        return "Neighbouring starts stay together: starts known to 1e-6 predict all of this time."
    if not later:
        return (
            f"A start known to {ends[-1].start_known_to:g} is already wrong by more than the error "
            f"asked for."
        )
    known = later[-1]
    return (
        f"Neighbouring starts part: one known to {known.start_known_to:g} predicts the motion to "
        f"that error until t = {known.until:.6g}, whichever integrator is used."
    )
