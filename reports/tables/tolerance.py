"""The bounds that a regression test of a user's own run should have: sentences, tables, files."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import pandas as pd

from benchmarks.applications.releases.behaviour import CHANGE_FLOORS, ULPS
from benchmarks.applications.releases.bounds import FEWEST_FLOORS, MOST_FLOORS
from benchmarks.applications.releases.own_run import SAMPLES, OwnRun
from benchmarks.applications.releases.tolerance import (
    MOVED_RUNS,
    QUANTITIES,
    STATES,
    Tolerance,
    Variant,
)
from galvi.arrays import Array
from reports.tables.number_format import plain
from reports.tables.versions import label
from reports.tables.writing import write_table

EXPRESSIONS = {  # engine -> quantity -> the Python expression that a test compares
    "mujoco": {"positions": "data.qpos", "velocities": "data.qvel"},
    "rebound": {
        "positions": "[p.xyz for p in sim.particles]",
        "velocities": "[p.vxyz for p in sim.particles]",
    },
}
BIT_IDENTICAL_VARIANTS = ("repeated", "two threads")
IMPORTS = ("import json", "from pathlib import Path", "", "import numpy", "")


def sentences(tolerance: Tolerance) -> Iterator[str]:
    """Sentences on the bounds at the end, the latest time to compare at, and the runs behind
    them."""
    for name in QUANTITIES:
        yield _at_end(tolerance, name)
    latest = tolerance.latest
    if latest < 0:
        yield (
            "Positions and velocities have no bound at any of the ten times: ask for a shorter "
            "--duration, or start where bodies are clearly in contact or clearly apart."
        )
    elif latest < SAMPLES - 1:
        bounds = " and ".join(f"{atol(tolerance, name, latest)} for {name}" for name in STATES)
        yield (
            f"Compare at t = {times(tolerance)[latest]:g} instead, with a bound of {bounds}: no "
            f"later time has one for both."
        )
    yield (
        f"A floor is the largest difference between your run and {tolerance.runs - 1} that differ "
        f"from it by rounding alone. A bound is at least {FEWEST_FLOORS:g} floors, since another "
        f"machine may round worse, and at most {MOST_FLOORS:g}, so that it catches every error of "
        f"{CHANGE_FLOORS:g}."
    )
    for variant in tolerance.variants:
        yield _variant_sentence(variant, tolerance)


def _at_end(tolerance: Tolerance, name: str) -> str:
    bound, end = tolerance.bounds[name][-1], f"{name} at t = {times(tolerance)[-1]:g}"
    if not math.isfinite(bound.floor):
        return f"{end}: no bound, since {bound.reason}."
    moved = f"rounding moves {'it' if name == 'energy' else 'them'} by {plain(bound.floor, 2)}"
    if bound.reason:
        return f"{end}: no bound, since {bound.reason} ({moved})."
    unequal = (
        f"; more than {FEWEST_FLOORS:g} floors, since the runs are unequal: half of them differ by "
        f"less than {plain(bound.median, 2)}"
    )
    return (
        f"{end}: a bound of {atol(tolerance, name, -1)}, {plain(bound.factor, 2)} floors ({moved}"
        f"{unequal if bound.factor > FEWEST_FLOORS else ''})."
    )


def _variant_sentence(variant: Variant, tolerance: Tolerance) -> str:
    """A sentence on how far the runs of a variant differ from the user's run."""
    name = variant.name
    if variant.failure:
        return f"{name}: {variant.failure.rstrip('.')}."
    if name in BIT_IDENTICAL_VARIANTS:
        if variant.is_identical:
            return f"{name}: bit-identical."
        return (
            f"{name}: not bit-identical, by up to {_floors(variant)}; the engine is not "
            f"deterministic."
        )
    differs = f"{name}: your run differs by {_floors(variant)}"
    if not variant.is_rounding:
        advice = (
            "the bounds do not hold for this release, and `galvi versions` says what changed"
            if variant.is_release
            else "the bounds do not hold for it"
        )
        return f"{differs}, which is more than rounding; {advice}."
    runs = len(variant.differences) - 1
    if name == MOVED_RUNS:
        return (
            f"{name}: {runs} runs err by an ulp of each number in each step, up or down, and start "
            f"off by {ULPS:g} ulp of the largest number."
        )
    return f"{differs}{f', and {runs} more runs err as above' if runs else ''}."


def _floors(variant: Variant) -> str:
    return f"{plain(variant.floors, 2)} floors"


def times(tolerance: Tolerance) -> list[float]:
    """The times of the bounds, as the engine counts them."""
    start = tolerance.run.job.get("t", 0.0)
    return [start + float(t) for t in tolerance.run.times]


def atol(tolerance: Tolerance, name: str, sample: int) -> str:
    """The bound of a quantity at a sample, rounded up to two digits; "" if there is none."""
    value = tolerance.bounds[name][sample].value
    if not math.isfinite(value):
        return ""
    power = 10.0 ** (math.floor(math.log10(value)) - 1)
    return f"{math.ceil(value / power * (1.0 - 1e-9)) * power:.1e}"


def lines_to_paste(tolerance: Tolerance) -> list[str]:
    """Lines of Python for the user's own test, which reads tolerance.json from its own folder; []
    if there is no bound."""
    if tolerance.latest < 0:
        return []
    t = times(tolerance)[tolerance.latest]
    return [
        *IMPORTS,
        f"# From the start {_advancing_call(tolerance.run, t, tolerance.latest + 1)}, at t = "
        f"{t!r}:",
        'tolerance = json.loads(Path(__file__).with_name("tolerance.json").read_text())',
        *(
            f'numpy.testing.assert_allclose({expression}, tolerance["expected"]["{name}"], rtol=0, '
            f"atol={atol(tolerance, name, tolerance.latest)})"
            for name, expression in EXPRESSIONS[tolerance.run.package].items()
        ),
    ]


def _advancing_call(run: OwnRun, t: float, samples: int) -> str:
    """The call that takes a user's run to the last of `samples` of its SAMPLES times, t."""
    if run.step is None:
        return f"after sim.integrate({t!r})"
    count = run.steps * samples // SAMPLES
    if run.package == "mujoco":
        return f"after mujoco.mj_step(model, data, nstep={count}) with steps of {run.step!r}"
    return f"after sim.steps({count}) with steps of {run.step!r} and sim.synchronize()"


def rows(tolerance: Tolerance) -> pd.DataFrame:
    """A line for each time: floors and bounds, and the reasons for missing bounds."""
    lines = []
    for k, t in enumerate(times(tolerance)):
        line: dict[str, Any] = {"t": t}
        for name in QUANTITIES:
            bound = tolerance.bounds[name][k]
            line |= {
                f"{name}_floor": bound.floor,
                f"{name}_factor": bound.factor,
                f"{name}_bound": bound.value,
            }
        reasons = {name: tolerance.bounds[name][k].reason for name in QUANTITIES}
        line["without"] = "; ".join(f"{name}: {why}" for name, why in reasons.items() if why)
        lines.append(line)
    return pd.DataFrame(lines)


def contents(tolerance: Tolerance) -> dict[str, Any]:
    """The contents of tolerance.json: the start and the expected states in full, floors and bounds,
    and the variants that were compared."""
    run = tolerance.run
    states = [{"t": t, **_state(tolerance, k)} for k, t in enumerate(times(tolerance))]
    return {
        "engine": run.package,
        "integrator": label(run),
        "step": run.step,
        "duration": run.duration,
        "seed": tolerance.seed,
        "start": _rows(run, run.positions, run.velocities),
        "expected": states[tolerance.latest] if tolerance.latest >= 0 else None,
        "states": states,
        "bounds": rows(tolerance),
        "compared": [
            {
                "name": variant.name,
                "runs": len(variant.differences),
                "floors": variant.floors,
                "failure": variant.failure,
                "in_bound": variant.is_rounding,
            }
            for variant in tolerance.variants
        ],
        "paste": lines_to_paste(tolerance),
    }


def _state(tolerance: Tolerance, sample: int) -> dict[str, Any]:
    motion = tolerance.motion
    state = _rows(tolerance.run, motion.positions[sample], motion.velocities[sample])
    return {**state, "energy": float(motion.energy[sample])}


def _rows(run: OwnRun, positions: Array, velocities: Array) -> dict[str, Any]:
    """A state in the shape of the engine's own: for REBOUND a row for each particle."""
    shape = (-1, 3) if run.package == "rebound" else (-1,)
    return {
        "positions": positions.reshape(shape).tolist(),
        "velocities": velocities.reshape(shape).tolist(),
    }


def write_tolerance(tolerance: Tolerance, folder: Path, origin: Mapping[str, str]) -> list[Path]:
    """Write tolerance.csv with all columns, and the bounds as Markdown and LaTeX; returns the
    paths."""
    return write_table(folder, "tolerance", rows(tolerance), bounds_table(tolerance), origin)


def bounds_table(tolerance: Tolerance) -> pd.DataFrame:
    """The bound of each quantity at each time."""
    table = rows(tolerance)
    return table[["t", *(f"{name}_bound" for name in QUANTITIES)]]
