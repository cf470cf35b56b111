"""The findings of a judgement in sentences."""

from __future__ import annotations

import math

from benchmarks.judging.bodies import unit
from benchmarks.judging.judgement import Judgement
from reports.tables.number_format import readable, seconds

TRUSTED = 0.1  # share of an error that the truth may be wrong by


def sentences(found: Judgement) -> list[str]:
    """What a reader wants to know first, the user's own run before all."""
    own, worst = found.own, found.parts.iloc[found.parts["largest_error"].argmax()]
    length, time = (unit(found.problem, kind) for kind in ("length", "time"))
    asked = f"an error of {readable(found.error)}{length}"
    result = [
        f"Your run ({own['integrator']}) is wrong by up to {readable(own['error'])}{length} over a "
        f"time of {readable(found.duration)}{time}, most for {worst.iloc[0]}; the energy changes "
        f"by {readable(own['energy_error'])} of itself. It takes {seconds(own['seconds'])}."
    ]
    if own["status"] != "Completed.":
        result.append(f"Its status: {own['status']}")
    result.append(_truth(found))
    best = found.recommended
    if best is None:
        result.append(f"Nothing that was tried reaches {asked}.")
    else:
        faster = own["seconds"] / best["seconds"]
        compared = f", {faster:.2g} times as fast as your run" if faster > 1.0 else ""
        result.append(
            f"The cheapest that reaches {asked} is {best['integrator']}, "
            f"{best['setting']}: {readable(best['error'])} in {seconds(best['seconds'])}{compared}."
        )
    if len(found.encounters):
        nearest = found.encounters.iloc[0]
        result.append(
            f"{len(found.encounters)} close encounters were found, which no fixed step resolves; "
            f"the closest is of {nearest['bodies']} at t = {nearest['time']:.6g}, at "
            f"{readable(nearest['hill_radii'])} Hill radii."
        )
    result.append(_horizon(found))
    return result


def _truth(found: Judgement) -> str:
    if not found.agreements:
        return "The truth is of one engine only: no second one is installed."
    first = found.agreements[0].between[0]
    others = " and ".join(
        f"{one.between[1]} to {readable(one.largest)}" for one in found.agreements
    )
    text = f"The truth is {first}, with which agree {others}."
    if found.truth_agreement > TRUSTED * found.error:
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
