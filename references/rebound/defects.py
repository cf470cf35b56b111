"""Defects of REBOUND, each reproduced within a second."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Mapping
from typing import Any

from references.rebound import simulation as rebound_simulation
from references.rebound import whfast512


@rebound_simulation.arithmetic_kept()  # WHFast512 leaves subnormal numbers to be 0
def corrector_taken_for_17() -> str:
    """A clause that shows that WHFast512 uses order 17 for a corrector of order 3; '' if it does
    not."""
    if whfast512.missing():
        return ""
    ends = {}
    for integrator, order in (("whfast", 3), ("whfast", 17), ("whfast512", 3), ("whfast512", 17)):
        sim = _planets(integrator)
        sim.integrator.corrector = order
        if integrator == "whfast":
            sim.steps(200)
        else:
            whfast512.advance(sim, 200)
        sim.synchronize()
        ends[integrator, order] = sim.particles[1].x
    gap = abs(ends["whfast", 3] - ends["whfast", 17])
    are_equal = ends["whfast512", 3] == ends["whfast512", 17]
    return (
        f"correctors 3 and 17 end at the same place, to the bit; WHFast's part by {gap:.0e}"
        if are_equal and gap > 0.0
        else ""
    )


def step_repeated_for_ever() -> str:
    """A clause that shows that BS repeats its least step where two bodies meet; '' if its time
    advances."""
    sim = _two_at_rest()
    sim.integrator, sim.dt = "bs", 1e-2
    sim.integrator.min_dt = 1e-3
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        sim.steps(500)
        time, steps_done = sim.t, sim.steps_done
        sim.steps(2000)
    stuck = sim.t == time and sim.steps_done - steps_done == 2000
    return f"the time stays at {time:.6g} in 2,000 further steps of 0.001" if stuck else ""


def integers_wrap_around() -> str:
    """A clause that shows how JANUS changes a position above 2^63 of its units; '' if it warns or
    does not change it."""
    sim = _planets("janus")
    sim.integrator.scale_pos = sim.integrator.scale_vel = 1e-20
    before = sim.particles[2].x
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        sim.steps(1)
    after = sim.particles[2].x
    has_changed = not math.isclose(before, after, rel_tol=0.5)
    return (
        f"in one step of 0.1 x goes from {before:.3g} to {after:.3g}"
        if has_changed and not caught
        else ""
    )


def _planets(integrator: str) -> Any:
    """A star and two planets of a thousandth of it, with periods of 2 pi and 15."""
    import rebound

    sim = rebound.Simulation()
    sim.add(m=1.0)
    sim.add(m=1e-3, a=1.0, e=0.05)
    sim.add(m=1e-3, a=1.8, e=0.02)
    sim.move_to_com()
    sim.integrator, sim.dt, sim.exact_finish_time = integrator, 0.1, 0
    return sim


def _two_at_rest() -> Any:
    """Two masses of 1 at rest at distance 1, which meet at t = 0.785."""
    import rebound

    sim = rebound.Simulation()
    sim.add(m=1.0, x=-0.5)
    sim.add(m=1.0, x=0.5)
    return sim


DEFECTS: Mapping[str, Callable[[], str]] = {
    "WHFast512 takes any corrector but 0 for the one of order 17, without a word": (
        corrector_taken_for_17
    ),
    "BS with a least step (min_dt) repeats it for ever where bodies meet": step_repeated_for_ever,
    "JANUS wraps around where a position is above 2^63 of its units, without a word": (
        integers_wrap_around
    ),
}


def observations() -> dict[str, str]:
    """Defect -> what the installed version does; '' for a defect that it does not have.

    Raises
    ------
    ModuleNotFoundError
        When REBOUND is missing.
    """
    if why := rebound_simulation.missing():
        raise ModuleNotFoundError(why)
    return {name: observe() for name, observe in DEFECTS.items()}


if __name__ == "__main__":
    for defect, observation in observations().items():
        print(f"{defect}: {observation or 'not in this version'}")
