"""How far rounding moves a user's own run, and the bound of a regression test of it."""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.applications.releases.behaviour import EPS, FLOORS, ULPS
from benchmarks.applications.releases.bounds import FAILED, Bound, bound_of
from benchmarks.applications.releases.own_run import SAMPLES, Motion, OwnRun
from benchmarks.applications.releases.requirements import interpreter
from benchmarks.store.isolated_environment import SECONDS, NotHere, finished
from galvi.arrays import Array

QUANTITIES = ("positions", "velocities", "energy")
STARTS = 64  # that are moved, shared by the ways to round
LONG = 60.0  # seconds of the plain run, above which it is said how long all takes
PART = SECONDS / 3.0  # seconds of runs in one process
# glibc's functions without fused products and wide vectors; nothing elsewhere.
UNFUSED = {"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-FMA,-FMA4,-AVX2,-AVX512F"}
LIBM = """import math
print([f(0.3 + 0.001 * k) for k in range(1000) for f in (math.sin, math.exp)])"""
Report = Callable[[str], None]


@dataclass(frozen=True, eq=False)
class Variant:
    """The run done in another way.

    Attributes
    ----------
    name
        such as "other starts"
    differences : array, shape (runs, 3, SAMPLES)
        of QUANTITIES at each time: the largest of an entry from the plain run
    failure
        why there are none, in a sentence
    floors
        the largest of the unmoved run (the first), in floors of the other starts
    """

    name: str
    differences: Array
    failure: str = ""
    floors: float = 0.0

    @property
    def is_rounding(self) -> bool:
        """Whether it differs by no more than FLOORS floors; what does is not in the bound."""
        return not self.failure and self.floors <= FLOORS

    @property
    def is_identical(self) -> bool:
        """Whether all of it has the same bits."""
        return not self.failure and not self.differences.any()


@dataclass(frozen=True, eq=False)
class Tolerance:
    """What a regression test may allow.

    Attributes
    ----------
    motion
        the plain run
    bounds
        of QUANTITIES, at each of SAMPLES times
    variants
        the ways in which the run was done
    """

    run: OwnRun
    motion: Motion
    bounds: Mapping[str, Sequence[Bound]]
    variants: Sequence[Variant]

    @property
    def latest(self) -> int:
        """The last time, from 0, at which all quantities have a bound; -1 for none."""
        whole = [all(not self.bounds[name][k].reason for name in QUANTITIES)
                 for k in range(SAMPLES)]  # fmt: skip
        return max((k for k in range(SAMPLES) if whole[k]), default=-1)


def measure(
    run: OwnRun, releases: Sequence[str], folder: Path, report: Report, seed: int = 0
) -> Tolerance:
    """The floors of a user's run, and bounds.

    Parameters
    ----------
    releases
        of the engine, such as "3.17.0"
    folder
        in which their environments are made, and removed
    report
        is told what is being done
    seed
        of the starts

    Raises
    ------
    ValueError
        For a model in which nothing can move.
    NotHere
        Where the plain run fails.
    """
    if not run.velocities.size:
        raise ValueError("nothing can move in your model: it has no joints.")
    report("your run")
    begin = time.perf_counter()
    (motion,) = run.answer([run.asked()]).motions
    seconds = time.perf_counter() - begin
    if motion.failure or not np.isfinite(differences(motion, [motion])).all():
        why = motion.failure or "its states are not finite."
        raise NotHere(f"your run fails, so that there is nothing to compare: {why}")
    if seconds > LONG:
        whole = seconds * (STARTS + 5 + len(releases)) / 60.0
        report(f"your run takes {seconds:.0f} s, all of it about {whole:.0f} minutes")
    at_once = max(1, int(PART / seconds))
    variants = [*_here(run, motion, at_once, seed, report)]
    measured = [variant.differences for variant in variants[:1]]
    floors = np.array([[each.floor for each in bounds]
                       for bounds in bounds_of(run, motion, measured).values()])  # fmt: skip
    variants += _others(run, motion, releases, folder, report)
    variants = [_in_floors(variant, floors) for variant in variants]
    measured = [each.differences for each in variants if each.is_rounding]
    return Tolerance(run, motion, bounds_of(run, motion, measured), variants)


def _here(
    run: OwnRun, motion: Motion, at_once: int, seed: int, report: Report
) -> Iterator[Variant]:
    """Starts that are moved, with fused products and without, where this machine has both."""
    unfused = has_unfused()
    starts = moved_starts(run, motion, STARTS, seed)
    share = STARTS // 2 if unfused else STARTS
    report(f"{share} other starts")
    yield moved_variant("other starts", run, motion, starts[:share], at_once)
    if not unfused:
        why = "not tried: it needs glibc on x86, and a processor with fused products"
        yield Variant("no fused products", np.empty((0, 3, SAMPLES)), why)
        return
    report(f"{STARTS - share} other starts without fused products")
    yield moved_variant("no fused products", run, motion, starts[share:], at_once, UNFUSED)


def _others(
    run: OwnRun, motion: Motion, releases: Sequence[str], folder: Path, report: Report
) -> Iterator[Variant]:
    """What starts from the same bits: the run again, two at once or without stops, releases."""
    report("the same again")
    again = [run.answer([run.asked()]).motions[0] for _ in range(2)]
    yield Variant("the same again", differences(motion, again))
    if run.package == "mujoco":
        report("two threads")
        threads = run.answer([run.asked()] * 2, threads=2).motions
        yield Variant("two threads", differences(motion, threads))
    if run.step is None:
        report("without stops")
        yield Variant("without stops", differences(motion, [_straight(run)]))
    for version in releases:
        report(f"{run.package} {version}")
        yield _of_release(run, motion, version, folder)


def moved_starts(run: OwnRun, motion: Motion, count: int, seed: int) -> list[tuple[Array, Array]]:
    """Starts whose entries are off, up or down, by ULPS of the largest one of the run, so that one
    at rest is moved too."""
    signs = np.random.default_rng(seed)
    steps = [
        ULPS * EPS * max(np.abs(start).max(initial=0.0), np.abs(rows).max(initial=0.0))
        for start, rows in ((run.positions, motion.positions), (run.velocities, motion.velocities))
    ]
    return [
        (run.positions + steps[0] * signs.choice((-1.0, 1.0), run.positions.size),
         run.velocities + steps[1] * signs.choice((-1.0, 1.0), run.velocities.size))
        for _ in range(count)
    ]  # fmt: skip


def moved_variant(
    name: str, run: OwnRun, motion: Motion, starts: Sequence[tuple[Array, Array]], at_once: int,
    environment: Mapping[str, str] | None = None,
) -> Variant:  # fmt: skip
    """The runs from the user's own start, which is the first, and from these, so many in each
    process."""
    runs = [run.asked(), *(run.asked(*start) for start in starts)]
    motions: list[Motion] = []
    for first in range(0, len(runs), at_once):
        part = run.answer(runs[first : first + at_once], environment=environment)
        motions += part.motions
    return Variant(name, differences(motion, motions))


def has_unfused() -> bool:
    """Whether UNFUSED changes last bits of the mathematical functions on this machine."""
    command = [sys.executable, "-I", "-c", LIBM]
    return finished(command) != finished(command, variables=UNFUSED)


def _straight(run: OwnRun) -> Motion:
    """The run from its start to each of its times, without a stop at the others."""
    asked: dict[str, Any] = run.asked()
    parts = run.answer([{**asked, "times": [each]} for each in asked["times"]]).motions
    failures = [part.failure for part in parts if part.failure]
    rows = {name: np.stack([getattr(part, name)[0] for part in parts])
            for name in ("positions", "velocities", "energy", "kinetic")}  # fmt: skip
    return Motion(**rows, failure="".join(failures[:1]))


def _of_release(run: OwnRun, motion: Motion, version: str, folder: Path) -> Variant:
    name = f"{run.package} {version}"
    try:
        with interpreter(run.package, version, folder) as python:
            (other,) = run.answer([run.asked()], python=python).motions
        if other.failure:
            raise NotHere(other.failure)
        return Variant(name, differences(motion, [other]))
    except (NotHere, ValueError) as error:  # ValueError: other coordinates, no JSON
        why = " ".join(str(error).split())
        return Variant(name, np.empty((0, 3, SAMPLES)), why)


def differences(motion: Motion, others: Sequence[Motion]) -> Array:
    """Of other runs: the largest of an entry, (runs, 3, SAMPLES); NaN past a failure."""
    return np.array([
        [np.abs(other.quantities[name] - motion.quantities[name]).max(axis=1)
         for name in QUANTITIES]
        for other in others
    ])  # fmt: skip


def bounds_of(
    run: OwnRun, motion: Motion, measured: Sequence[Array]
) -> dict[str, tuple[Bound, ...]]:
    """The bounds by all differences that are rounding."""
    every = np.concatenate(measured)
    failed = ~np.isfinite(every).all(axis=(1, 2))
    bounds = {}
    for i, (name, (size, extent)) in enumerate(_sizes(run, motion).items()):
        rows = [bound_of(every[:, i, k], EPS * size, extent) for k in range(SAMPLES)]
        count = f"{int(failed.sum())} of {len(every)} {FAILED}"
        bounds[name] = tuple(
            replace(each, reason=count) if each.reason == FAILED else each for each in rows
        )
    return bounds


def _sizes(run: OwnRun, motion: Motion) -> dict[str, tuple[float, float]]:
    """Of each of QUANTITIES its size, and how far it moves."""
    q = np.vstack([run.positions, motion.positions])
    v = np.vstack([run.velocities, motion.velocities])
    speed = float(np.abs(v).max(initial=0.0))
    energy = float(max(np.abs(motion.energy).max(), motion.kinetic.max()))
    extent = float(np.abs(q - q[0]).max(initial=0.0))
    return {
        "positions": (float(np.abs(q).max(initial=0.0)), extent),
        "velocities": (speed, speed),
        "energy": (energy, energy),
    }


def _in_floors(variant: Variant, floors: Array) -> Variant:
    """With how many floors its unmoved run is off."""
    if variant.failure:
        return variant
    own = variant.differences[0]
    with np.errstate(divide="ignore", invalid="ignore"):
        ratios = np.where(own > 0.0, own / floors, 0.0)
    worst = float(np.max(np.where(np.isfinite(own), ratios, math.inf)))
    return replace(variant, floors=worst)
