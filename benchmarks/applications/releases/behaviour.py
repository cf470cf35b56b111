"""A user's run in one release of an engine, and the differences that rounding may cause."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.applications.releases.own_run import SAMPLES, Motion, OwnRun
from benchmarks.statistics.orders import orders
from benchmarks.store.isolated_environment import EnvironmentUnavailable
from galvi.arrays import Array
from galvi.kernels.constants import EPSILON
from references.mujoco.own_model import WARNED

ULPS = 2.0  # each entry of a start is moved by so many ulp of the largest entry
MOVED_STARTS = 4
CHANGE_FLOORS = 20.0  # floors above which a difference is a change
COARSER_LEVELS, STEP_LEVELS = 3, 7  # halvings of the step: from eight times the user's to an eighth
LARGEST_ORDER_ERROR = 0.1  # largest standard error of an order that is reported
COMPARED_SAMPLES = (2, 5, 9)  # samples at which accelerations are compared, beside the start


@dataclass(frozen=True, eq=False)
class Quantity:
    """Values (rows, n), and the floor of each row, (rows,): the largest change by rounding."""

    values: Array
    floors: Array


@dataclass(frozen=True, eq=False)
class Behaviour:
    """A user's run in one release.

    Attributes
    ----------
    version
        such as "4.0.1"
    missing
        reason why the release cannot be installed or cannot do the run; "" where it can
    failure
        a sentence on how the run diverges; "" where it reaches its end
    motion
        the user's run
    quantities
        positions, velocities and energy at SAMPLES times, accelerations at the start and
        COMPARED_SAMPLES
    order, order_error
        order of the user's integrator over the first of SAMPLES parts of the run, and its standard
        error; NaN where none is found
    energy_change
        range of the energy along the run, relative to its largest magnitude
    """

    version: str
    missing: str = ""
    failure: str = ""
    motion: Motion | None = None
    quantities: Mapping[str, Quantity] | None = None
    order: float = math.nan
    order_error: float = math.nan
    energy_change: float = math.nan


@dataclass(frozen=True, eq=False)
class ReleaseQuestions:
    """The runs and states that each release computes.

    Attributes
    ----------
    states
        states (positions, velocities) at which accelerations are compared
    sizes
        largest magnitude of a position and of a velocity in the run
    """

    run: OwnRun
    states: Sequence[tuple[Array, Array]]
    sizes: tuple[float, float]

    @classmethod
    def of(cls, run: OwnRun) -> ReleaseQuestions:
        """The questions of a run, from a run by the installed release; where that diverges, they
        are at the start only.

        Raises
        ------
        EnvironmentUnavailable
            Where the installed release cannot do the run.
        ValueError
            Where nothing moves.
        """
        (motion,) = run.answer([run.request()]).motions
        start = run.positions, run.velocities
        if _divergence(motion):
            return cls(run, [start], (_size(start[0]) or 1.0, _size(start[1]) or 1.0))
        if np.all(motion.positions == run.positions):
            raise ValueError(
                "nothing moves in your run, so that nothing can change: start elsewhere, with "
                "--key, or --qpos and --qvel."
            )
        states = [start]
        states += [(motion.positions[k], motion.velocities[k]) for k in COMPARED_SAMPLES]
        q, v = np.stack([q for q, _ in states]), np.stack([v for _, v in states])
        return cls(run, states, (_size(q), _size(v)))

    @property
    def step_counts(self) -> list[int]:
        """Numbers of steps in the first part of the run, coarse to fine; empty where the integrator
        chooses its steps."""
        if self.run.step is None:
            return []
        coarsest = max(1, round(self.run.steps / SAMPLES / 2**COARSER_LEVELS))
        return [coarsest * 2**k for k in range(STEP_LEVELS)]

    def behaviour_of(self, version: str, python: Path) -> Behaviour:
        """The behaviour of a release, run by this interpreter.

        Raises EnvironmentUnavailable where the release cannot do the run.
        """
        run, signs = self.run, np.random.default_rng(0)
        own_start = run.positions, run.velocities
        starts = [displaced(own_start, self.sizes, signs) for _ in range(MOVED_STARTS)]
        moved_states = [
            [displaced(state, self.sizes, signs) for _ in range(MOVED_STARTS)]
            for state in self.states
        ]
        states = [
            state
            for state_itself, nearby in zip(self.states, moved_states, strict=True)
            for state in (state_itself, *nearby)
        ]
        part = run.duration / SAMPLES
        levels: list[dict[str, Any]] = [
            {**run.request(), "step": part / count, "steps": count, "every": count}
            for count in self.step_counts
        ]
        runs = [run.request(), *(run.request(*start) for start in starts), *levels]
        answer = run.answer(runs, [run.request(*state) for state in states], python)
        own_motion, neighbours = answer.motions[0], answer.motions[1 : 1 + MOVED_STARTS]
        failure = _divergence(own_motion)
        if failure:
            return Behaviour(version, failure=failure)
        spreads = {
            name: [neighbour.quantities[name] for neighbour in neighbours]
            for name in own_motion.quantities
        }
        motion = {
            name: self._with_floors(values, spreads[name], own_motion.steps_taken)
            for name, values in own_motion.quantities.items()
        }
        order, order_error = self._order(answer.motions[1 + MOVED_STARTS :], motion)
        energies = np.array([answer.energies[0], *own_motion.energy])
        return Behaviour(
            version,
            "",
            "",
            own_motion,
            {**motion, "accelerations": _accelerations(answer.accelerations)},
            order,
            order_error,
            _ratio(float(np.ptp(energies)), _size(energies)),
        )

    def _with_floors(
        self, values: Array, neighbours: Sequence[Array], steps_taken: int
    ) -> Quantity:
        """The values of a run, with a floor at each sample.

        The floor is the largest spread of the moved runs, and of ULPS ulp, until then; infinite
        where a moved run diverges. A release that rounds otherwise makes a new error in each step.
        Each of them grows to the spread at most, and together they grow as the root of the number
        of steps, so that CHANGE_FLOORS floors are at least that root times the spread. Random
        errors of an ulp in each of 4e4 steps of WHFast came to 0.05 floors; errors that are more
        often positive than negative, to 6, and without the root to 60.
        """
        size = np.abs(values).max(axis=1)
        spread = np.max(
            [np.abs(neighbour - values).max(axis=1) for neighbour in neighbours], axis=0
        )
        spread = np.where(np.isfinite(spread), spread, np.inf)
        steps = steps_taken if self.run.step is None else self.run.steps
        growth = max(1.0, math.sqrt(steps) / CHANGE_FLOORS)
        floors = np.maximum.accumulate(np.maximum(spread, ULPS * EPSILON * size))
        return Quantity(values, growth * floors)

    def _order(
        self, levels: Sequence[Motion], motion: Mapping[str, Quantity]
    ) -> tuple[float, float]:
        """The order, from differences between runs at successive steps, and its standard error; NaN
        where there are no such runs or the differences show no order."""
        if not levels:
            return math.nan, math.nan
        names = dict(zip(("positions", "velocities"), self.sizes, strict=True))
        ends = np.stack(
            [
                np.concatenate(
                    [_relative(level.quantities[name][0], size) for name, size in names.items()]
                )
                for level in levels
            ]
        )
        floor = max(_ratio(motion[name].floors[0], size) for name, size in names.items())
        differences = np.abs(np.diff(ends, axis=0)).max(axis=1)
        steps = [1.0 / count for count in self.step_counts[:-1]]
        fit = orders(steps, differences.tolist(), truth_error=floor).fit
        if not fit.points or not fit.uncertainty <= LARGEST_ORDER_ERROR:
            return math.nan, math.nan
        return fit.rate, fit.uncertainty


def _divergence(motion: Motion) -> str:
    """A sentence on how a run diverges; "" where it does not.

    Raises EnvironmentUnavailable where the release cannot do the run.
    """
    if motion.failure.startswith(WARNED):
        return motion.failure
    if motion.failure:
        raise EnvironmentUnavailable(f"it cannot do your run: {motion.failure}")
    is_finite = all(np.isfinite(values).all() for values in motion.quantities.values())
    return "" if is_finite else "its states are not finite."


def displaced(
    state: tuple[Array, Array], sizes: Sequence[float], signs: np.random.Generator
) -> tuple[Array, Array]:
    """Positions and velocities whose entries are moved by ULPS ulp of these sizes, up or down."""
    q, v = (
        x + ULPS * EPSILON * size * signs.choice((-1.0, 1.0), x.size)
        for x, size in zip(state, sizes, strict=True)
    )
    return q, v


def _accelerations(rows: Sequence[Array]) -> Quantity:
    """The accelerations at each state; the floors are the largest differences at moved states."""
    values, floors = [], []
    for k in range(0, len(rows), 1 + MOVED_STARTS):
        state_itself, *neighbours = rows[k : k + 1 + MOVED_STARTS]
        spread = max(float(np.abs(neighbour - state_itself).max()) for neighbour in neighbours)
        values.append(state_itself)
        floors.append(max(spread, ULPS * EPSILON * _size(state_itself)))
    return Quantity(np.stack(values), np.array(floors))


def _size(values: Array) -> float:
    return float(np.abs(values).max(initial=0.0))


def _relative(values: Array, size: float) -> Array:
    return values / size if size else values


def _ratio(value: float, size: float) -> float:
    return float(value) / size if size else float(value)
