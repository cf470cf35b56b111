"""The bound that a regression test of a user's own run should have: sentences, a table, a file."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import pandas as pd

from benchmarks.applications.releases.behaviour import FLOORS
from benchmarks.applications.releases.bounds import DEVIATIONS, LEAST, MOST
from benchmarks.applications.releases.own_run import SAMPLES
from benchmarks.applications.releases.tolerance import QUANTITIES, Tolerance, Variant
from reports.tables.number_format import plain
from reports.tables.versions import label
from reports.tables.writing import write_table

STATES = {  # of each engine, what a test compares
    "mujoco": {"positions": "data.qpos", "velocities": "data.qvel"},
    "rebound": {
        "positions": "[p.xyz for p in sim.particles]",
        "velocities": "[p.vxyz for p in sim.particles]",
    },
}
SAME_BITS = ("the same again", "two threads")


def sentences(tolerance: Tolerance) -> Iterator[str]:
    """The bounds at the end with their reasons, what to paste, and what was tried."""
    for name in QUANTITIES:
        yield _at_end(tolerance, name)
    latest = tolerance.latest
    if latest < 0:
        yield (
            "At none of the ten times do all have a bound: ask for a shorter --duration, or start "
            "where rounding does not decide on a contact."
        )
    elif latest < SAMPLES - 1:
        values = ", ".join(f"{atol(tolerance, name, latest)} for {name}" for name in QUANTITIES)
        yield f"Compare at t = {times(tolerance)[latest]:g}: there a bound of {values} holds."
    yield (
        f"A floor is the largest difference that rounding made, in all runs below. A bound has "
        f"{LEAST:g} floors, or more where the runs are spread so that a log-normal tail at "
        f"{DEVIATIONS:g} standard deviations needs them, and at most {MOST:g}: it sees a fault of "
        f"{FLOORS:g}."
    )
    for variant in tolerance.variants:
        yield _tried(variant, tolerance)


def _at_end(tolerance: Tolerance, name: str) -> str:
    bound, end = tolerance.bounds[name][-1], f"{name} at t = {times(tolerance)[-1]:g}"
    if not math.isfinite(bound.floor):
        return f"{end}: no bound, since {bound.reason}."
    moved = f"rounding moves {'it' if name == 'energy' else 'them'} by {plain(bound.floor, 2)}"
    if bound.reason:
        return f"{end}: no bound, since {bound.reason} ({moved})."
    return (
        f"{end}: a bound of {atol(tolerance, name, -1)}, {plain(bound.factor, 2)} floors ({moved})."
    )


def _tried(variant: Variant, tolerance: Tolerance) -> str:
    """What one way of running does."""
    package, name = tolerance.run.package, variant.name
    if variant.failure:
        return f"{name}: {variant.failure.rstrip('.')}."
    if name in SAME_BITS:
        if variant.is_identical:
            return f"{name}: bit-identical."
        return (
            f"{name}: not bit-identical, by up to {_floors(variant)}; the engine does not repeat."
        )
    if not variant.is_rounding:
        moves = f"{name} moves otherwise, by {_floors(variant)}, which is not rounding"
        if name.startswith(package):
            return f"{moves}; pin the release, `galvi versions` says what changed."
        return f"{moves}, and is not in the bound."
    runs = len(variant.differences) - 1
    if name == "other starts":
        return f"{name}: {runs}, off by 2 ulp of the largest number of the run, up or down."
    moved = f", and there are {runs} other starts" if runs else ""
    return f"{name}: your run differs by {_floors(variant)}{moved}."


def _floors(variant: Variant) -> str:
    return f"{plain(variant.floors, 2)} floors"


def times(tolerance: Tolerance) -> list[float]:
    """In the engine's time."""
    start = tolerance.run.job.get("t", 0.0)
    return [start + float(t) for t in tolerance.run.times]


def atol(tolerance: Tolerance, name: str, sample: int) -> str:
    """The bound with two digits, rounded up; "" for none."""
    value = tolerance.bounds[name][sample].value
    if not math.isfinite(value):
        return ""
    power = 10.0 ** (math.floor(math.log10(value)) - 1)
    return f"{math.ceil(value / power * (1.0 - 1e-9)) * power:.1e}"


def lines_to_paste(tolerance: Tolerance) -> list[str]:
    """Python for the user's own test; none where there is no bound."""
    if tolerance.latest < 0:
        return []
    states = STATES[tolerance.run.package]
    run, count = tolerance.run, tolerance.latest + 1
    when = f"at t = {times(tolerance)[tolerance.latest]!r}"
    if run.step is not None:
        when += f", after {run.steps * count // SAMPLES} steps of {run.step!r}"
    return [
        f'expected = json.loads(Path("tolerance.json").read_text())["expected"]  # {when}',
        *(
            f'numpy.testing.assert_allclose({value}, expected["{name}"], rtol=0, '
            f"atol={atol(tolerance, name, tolerance.latest)})"
            for name, value in states.items()
        ),
    ]


def rows(tolerance: Tolerance) -> pd.DataFrame:
    """A line for each time: floors and bounds, and why there is none."""
    lines = []
    for k, t in enumerate(times(tolerance)):
        line: dict[str, Any] = {"t": t}
        for name in QUANTITIES:
            bound = tolerance.bounds[name][k]
            line |= {f"{name}_floor": bound.floor, f"{name}_factor": bound.factor,
                     f"{name}_bound": bound.value}  # fmt: skip
        reasons = {name: tolerance.bounds[name][k].reason for name in QUANTITIES}
        line["without"] = "; ".join(f"{name}: {why}" for name, why in reasons.items() if why)
        lines.append(line)
    return pd.DataFrame(lines)


def contents(tolerance: Tolerance) -> dict[str, Any]:
    """What tolerance.json holds: the expected states in full, floors, bounds, ways tried."""
    run = tolerance.run
    kept = tolerance.latest if tolerance.latest >= 0 else SAMPLES - 1
    states = [{"t": t, **_state(tolerance, k)} for k, t in enumerate(times(tolerance))]
    return {
        "engine": run.package, "integrator": label(run), "step": run.step,
        "duration": run.duration, "expected": states[kept] if tolerance.latest >= 0 else None,
        "states": states, "bounds": rows(tolerance),
        "tried": [{"name": each.name, "floors": each.floors, "failure": each.failure,
                   "in_bound": each.is_rounding} for each in tolerance.variants],
        "paste": lines_to_paste(tolerance),
    }  # fmt: skip


def _state(tolerance: Tolerance, sample: int) -> dict[str, Any]:
    motion = tolerance.motion
    shape = (-1, 3) if tolerance.run.package == "rebound" else (-1,)
    return {
        "positions": motion.positions[sample].reshape(shape).tolist(),
        "velocities": motion.velocities[sample].reshape(shape).tolist(),
        "energy": float(motion.energy[sample]),
    }


def write_tolerance(tolerance: Tolerance, folder: Path, origin: Mapping[str, str]) -> list[Path]:
    """Write tolerance.csv with every column, bounds as Markdown and LaTeX; returns the paths."""
    return write_table(folder, "tolerance", rows(tolerance), bounds_table(tolerance), origin)


def bounds_table(tolerance: Tolerance) -> pd.DataFrame:
    """The bound of each quantity at each time, to read."""
    frame = rows(tolerance)
    return frame[["t", *(f"{name}_bound" for name in QUANTITIES)]]
