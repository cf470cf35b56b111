"""The effect of rounding on a user's own run, and the bound of a regression test of it."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from benchmarks.applications.releases.behaviour import CHANGE_FLOORS, displaced
from benchmarks.applications.releases.bounds import FAILED, Bound, bound_of
from benchmarks.applications.releases.own_run import SAMPLES, Motion, OwnRun
from benchmarks.applications.releases.requirements import interpreter
from benchmarks.store.isolated_environment import TIME_LIMIT, EnvironmentUnavailable, output_of
from galvi.arrays import Array
from galvi.kernels.constants import EPSILON

STATES = ("positions", "velocities")  # quantities that must have a bound
QUANTITIES = (*STATES, "energy")
STARTS = (
    64  # of runs that round differently; half are without fused products where the machine has both
)
REST_FRACTION = 1e-6  # of the size: a smaller motion counts as rest
MOVED_RUNS = "rounding at every step"
LONG_SECONDS = 60.0  # of the plain run, above which the time of all runs is reported
PROCESS_SECONDS = TIME_LIMIT / 3.0  # seconds of runs in one process
# glibc's functions without fused products and wide vectors; nothing elsewhere.
UNFUSED = {"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-FMA,-FMA4,-AVX2,-AVX512F"}
LIBM_PROGRAM = """import math
print([f(0.3 + 0.001 * k) for k in range(1000) for f in (math.sin, math.exp)])"""
Report = Callable[[str], None]


@dataclass(frozen=True, eq=False)
class Variant:
    """Runs that differ from the user's by rounding, or that may, as those of another release.

    Attributes
    ----------
    name
        such as "rounding at every step"
    differences : array, shape (runs, 3, SAMPLES)
        largest difference of an entry from the plain run, for each of QUANTITIES at each time
    failure
        reason why there are no runs; "" where there are
    floors
        largest difference of the first run, which is not moved, in floors of the moved runs
    is_release
        whether the runs are by another release, which the user named
    """

    name: str
    differences: Array
    failure: str = ""
    floors: float = 0.0
    is_release: bool = False

    @property
    def is_rounding(self) -> bool:
        """Whether it differs by CHANGE_FLOORS floors at most; only then does it enter the bound."""
        return not self.failure and self.floors <= CHANGE_FLOORS

    @property
    def is_identical(self) -> bool:
        """Whether all runs are equal to the plain run."""
        return not self.failure and not self.differences.any()


@dataclass(frozen=True, eq=False)
class Tolerance:
    """The differences that a regression test may allow.

    Attributes
    ----------
    motion
        the plain run
    bounds
        bounds of QUANTITIES at each of SAMPLES times
    variants
        the variants that were compared
    seed
        seed of the moved runs
    """

    run: OwnRun
    motion: Motion
    bounds: Mapping[str, Sequence[Bound]]
    variants: Sequence[Variant]
    seed: int = 0

    @property
    def latest(self) -> int:
        """The last sample at which positions and velocities have a bound; -1 for none."""
        is_unbounded = [any(self.bounds[name][k].reason for name in STATES) for k in range(SAMPLES)]
        return max((k for k in range(SAMPLES) if not is_unbounded[k]), default=-1)

    @property
    def holds(self) -> bool:
        """Whether there is a bound at the end, and named releases differ by rounding alone."""
        releases = [variant for variant in self.variants if variant.is_release]
        return self.latest == SAMPLES - 1 and all(variant.is_rounding for variant in releases)

    @property
    def runs(self) -> int:
        """The number of runs that the bounds rest on."""
        return sum(len(variant.differences) for variant in self.variants if variant.is_rounding)


def measure(
    run: OwnRun, releases: Sequence[str], folder: Path, report: Report, seed: int = 0
) -> Tolerance:
    """Measure the bounds of a user's run.

    Parameters
    ----------
    releases
        releases of the engine to compare, such as "3.17.0"
    folder
        folder in which their environments are made, and removed
    report
        called with a description of each step of the work
    seed
        seed of the moved starts

    Raises
    ------
    ValueError
        For a model in which nothing can move.
    EnvironmentUnavailable
        Where the plain run fails.
    """
    if not run.velocities.size:
        raise ValueError("nothing can move in your model: it has no joints.")
    report("your run")
    start = perf_counter()
    (motion,) = run.answer([run.request()]).motions
    seconds = perf_counter() - start
    if motion.failure or not np.isfinite(differences(motion, [motion])).all():
        why = motion.failure or "its states are not finite."
        raise EnvironmentUnavailable(f"your run fails, so that there is nothing to compare: {why}")
    if seconds > LONG_SECONDS:
        count = STARTS + 5 + len(releases)
        minutes = seconds * count / 60.0
        report(f"your run takes {seconds:.0f} s, the {count} to come about {minutes:.0f} minutes")
    at_once = max(1, int(PROCESS_SECONDS / seconds))
    variants = [*_moved_variants(run, motion, at_once, seed, report)]
    first = bounds_of(run, motion, [variants[0].differences])
    floors = np.array([[bound.floor for bound in bounds] for bounds in first.values()])
    variants += _unmoved_variants(run, motion, releases, folder, report)
    variants = [_in_floors(variant, floors) for variant in variants]
    measured = [variant.differences for variant in variants if variant.is_rounding]
    return Tolerance(run, motion, bounds_of(run, motion, measured), variants, seed)


def _moved_variants(
    run: OwnRun, motion: Motion, at_once: int, seed: int, report: Report
) -> Iterator[Variant]:
    """Yield the moved runs, with and, where this machine has both, without fused products."""
    unfused = has_unfused()
    runs = moved_runs(run, motion, STARTS, seed)
    fused_count = STARTS // 2 if unfused else STARTS
    yield moved_variant(MOVED_RUNS, run, motion, runs[:fused_count], at_once, report)
    name = "without fused products"
    if not unfused:
        why = "not tried, since the C library rounds alike with and without them here"
        yield Variant(name, np.empty((0, 3, SAMPLES)), why)
        return
    yield moved_variant(name, run, motion, runs[fused_count:], at_once, report, UNFUSED)


def _unmoved_variants(
    run: OwnRun, motion: Motion, releases: Sequence[str], folder: Path, report: Report
) -> Iterator[Variant]:
    """Yield runs from the same start: repeated, in two threads, without stops, and by releases."""
    report("repeated")
    repeated = [run.answer([run.request()]).motions[0] for _ in range(2)]
    yield Variant("repeated", differences(motion, repeated))
    if run.package == "mujoco":
        report("two threads")
        threads = run.answer([run.request()] * 2, threads=2).motions
        yield Variant("two threads", differences(motion, threads))
    if run.step is None:
        report("without stops")
        yield Variant("without stops", differences(motion, [_without_stops(run)]))
    for version in releases:
        report(f"{run.package} {version}")
        yield _of_release(run, motion, version, folder)


def moved_runs(run: OwnRun, motion: Motion, count: int, seed: int) -> list[dict[str, Any]]:
    """Requests of runs whose starts are moved by ULPS ulp of the size, and which round each step at
    random by an ulp."""
    signs = np.random.default_rng(seed)
    sizes = [_sizes(run, motion)[name][0] for name in STATES]
    return [
        {
            **run.request(*displaced((run.positions, run.velocities), sizes, signs)),
            "rounding": int(signs.integers(2**32)),
        }
        for _ in range(count)
    ]


def moved_variant(
    name: str,
    run: OwnRun,
    motion: Motion,
    requests: Sequence[Mapping[str, Any]],
    at_once: int,
    report: Report,
    environment: Mapping[str, str] | None = None,
) -> Variant:
    """The variant of the user's run, which comes first, and of these requests, `at_once` of them in
    a process."""
    runs = [run.request(), *requests]
    motions: list[Motion] = []
    for first in range(0, len(runs), at_once):
        report(f"{name}, {first} of {len(runs)} runs")
        motions += run.answer(runs[first : first + at_once], environment=environment).motions
    return Variant(name, differences(motion, motions))


def has_unfused() -> bool:
    """Whether UNFUSED changes last bits of the mathematical functions on this machine."""
    command = [sys.executable, "-I", "-c", LIBM_PROGRAM]
    return output_of(command) != output_of(command, variables=UNFUSED)


def _without_stops(run: OwnRun) -> Motion:
    """The states of runs from the start to each of the times, without stops at the others."""
    request: dict[str, Any] = run.request()
    parts = run.answer([{**request, "times": [time]} for time in request["times"]]).motions
    failures = [part.failure for part in parts if part.failure]
    rows = {
        name: np.stack([getattr(part, name)[0] for part in parts])
        for name in ("positions", "velocities", "energy", "kinetic")
    }
    return Motion(**rows, failure="".join(failures[:1]))


def _of_release(run: OwnRun, motion: Motion, version: str, folder: Path) -> Variant:
    name = f"{run.package} {version}"
    try:
        with interpreter(run.package, version, folder) as python:
            (release_motion,) = run.answer([run.request()], python=python).motions
        if release_motion.failure:
            raise EnvironmentUnavailable(release_motion.failure)
        return Variant(name, differences(motion, [release_motion]), is_release=True)
    except (EnvironmentUnavailable, ValueError) as error:  # ValueError: other coordinates, no JSON
        why = " ".join(str(error).split())
        return Variant(name, np.empty((0, 3, SAMPLES)), why, is_release=True)


def differences(motion: Motion, motions: Sequence[Motion]) -> Array:
    """The largest difference of an entry of QUANTITIES from `motion`, (runs, 3, SAMPLES); NaN past
    a failure."""
    return np.array(
        [
            [
                np.abs(compared.quantities[name] - motion.quantities[name]).max(axis=1)
                for name in QUANTITIES
            ]
            for compared in motions
        ]
    )


def bounds_of(
    run: OwnRun, motion: Motion, measured: Sequence[Array]
) -> dict[str, tuple[Bound, ...]]:
    """The bounds of each of QUANTITIES at each time, from these differences by rounding."""
    sizes = np.concatenate(measured)
    failed = ~np.isfinite(sizes).all(axis=(1, 2))
    bounds = {}
    for i, (name, (size, extent)) in enumerate(_sizes(run, motion).items()):
        rows = [bound_of(sizes[:, i, k], EPSILON * size, extent) for k in range(SAMPLES)]
        count = f"{int(failed.sum())} of {len(sizes)} {FAILED}"
        bounds[name] = tuple(
            replace(bound, reason=count) if bound.reason == FAILED else bound for bound in rows
        )
    return bounds


def _sizes(run: OwnRun, motion: Motion) -> dict[str, tuple[float, float]]:
    """The size and the extent of motion of each of QUANTITIES; 0 for an energy that is always 0.

    A run at rest has no speed to compare rounding with. Its speed is then that which covers the
    size of the positions in the run, and the extent is REST_FRACTION of this size. The size is 1
    where all positions are 0.
    """
    q = np.vstack([run.positions, motion.positions])
    v = np.vstack([run.velocities, motion.velocities])
    size, extent = float(np.abs(q).max()) or 1.0, float(np.abs(q - q[0]).max())
    speed = float(np.abs(v).max())
    energy = float(max(np.abs(motion.energy).max(), motion.kinetic.max()))
    if extent < REST_FRACTION * size:
        extent, speed = REST_FRACTION * size, max(speed, size / abs(run.duration))
    return {
        "positions": (size, extent),
        "velocities": (speed, speed),
        "energy": (energy, energy),
    }


def _in_floors(variant: Variant, floors: Array) -> Variant:
    """The variant with `floors`, the largest difference of its first run in these floors."""
    if variant.failure:
        return variant
    unmoved = variant.differences[0]
    with np.errstate(over="ignore", invalid="ignore"):
        ratios = np.where(np.isfinite(unmoved), unmoved, math.inf) / floors
    worst = float(np.nan_to_num(ratios, nan=math.inf, posinf=math.inf).max())
    return replace(variant, floors=worst)
