"""The participants of the Brouwer study and the samples of their runs."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Protocol

import numpy as np

import galvi
from benchmarks.measures.independent_invariants import exactly, relative_energy_error
from benchmarks.measures.orbit_shape import period
from benchmarks.work_precision.problem import frame_label
from galvi import Problem
from references import Contender
from references.closed_forms.double_double import DoubleDouble

SAMPLES = 100
KEPT = tuple(sorted({round(10 ** (k / 10)) for k in range(21)}))  # log-spaced, in two decades
YEAR = 365.25


@dataclass(frozen=True)
class Bodies:
    """A planetary system, and the planet by whose period steps are chosen.

    Attributes
    ----------
    label_suffix
        text that follows a label
    clock
        the place of that planet among the bodies, and its name
    """

    make: Callable[[], Problem]
    label_suffix: str
    clock: tuple[int, str]


OUTER = Bodies(galvi.problems.outer_solar_system, "", (1, "Jupiter"))
EIGHT = Bodies(
    partial(galvi.problems.solar_system, pluto=False), ", Sun + 8 planets", (1, "Mercury")
)


@dataclass(frozen=True)
class Sample:
    """Relative energy errors at ``number`` hundredths of a run.

    Attributes
    ----------
    error
        error of the state with its low parts, where these are known
    error_of_rounded
        error of the state rounded to float64
    status
        empty, or why the run ended
    """

    number: int
    error: float
    error_of_rounded: float
    status: str = ""


class RoundOffParticipant(Protocol):
    """A participant of the study."""

    @property
    def label(self) -> str:
        """The label in tables and figures."""

    @property
    def settings(self) -> str:
        """The settings in words."""

    @property
    def bodies(self) -> Bodies:
        """Whose motion it follows."""

    def samples(
        self, problem: Problem, years: float, resume: Path | None, report: Callable[[str], None]
    ) -> Iterator[Sample]:
        """The samples at KEPT, in order.

        Parameters
        ----------
        resume
            file to save the run to and to resume it from; the first sample is then the one already
            reached
        report
            called with a sentence on a saved file that cannot be used
        """


@dataclass(frozen=True)
class GalerkinParticipant:
    """A galvi method with about ``per_orbit`` steps in a revolution of the clock's planet."""

    method: galvi.Galerkin
    per_orbit: float
    bodies: Bodies = OUTER

    @property
    def label(self) -> str:
        """See `RoundOffParticipant`."""
        stages = self.method.stages
        plain = f"galvi degree {self.method.space.degree}, Gauss {stages}"
        label = frame_label(stages, None) if self.method.in_frame else plain
        return f"{label}{self.bodies.label_suffix}"

    @property
    def settings(self) -> str:
        """See `RoundOffParticipant`."""
        return f"step = {self.bodies.clock[1]}'s period / {self.per_orbit}"

    def samples(
        self, problem: Problem, years: float, resume: Path | None, report: Callable[[str], None]
    ) -> Iterator[Sample]:
        """See `RoundOffParticipant`; the state's low parts are those of `galvi.checkpoint`."""
        length = years * YEAR / SAMPLES
        steps_per_sample = max(
            1, round(length * self.per_orbit / period(problem, self.bodies.clock[0]))
        )
        step, completed = length / steps_per_sample, 0
        run = self._saved_run(problem, step, steps_per_sample, resume, report)
        if run is not None:
            completed = run.checkpoint.first // steps_per_sample
            yield _sample(completed, run)
        for number in KEPT[KEPT.index(completed) + 1 if completed else 0 :]:
            steps = (number - completed) * steps_per_sample
            if run is None:
                run = galvi.integrate(problem, self.method, step, steps, save_every=steps)
            else:
                run = galvi.resume(run, steps, save_every=steps)
            if run.interrupted:
                raise KeyboardInterrupt
            completed = number
            yield _sample(number, run)
            if not run.success:
                return
            if resume is not None and number != KEPT[-1]:
                galvi.save(run, resume)

    def _saved_run(
        self,
        problem: Problem,
        step: float,
        steps_per_sample: int,
        path: Path | None,
        report: Callable[[str], None],
    ) -> Any:
        """The saved run, if it is this one and ends at a sample."""
        if path is None or not path.exists():
            return None
        try:
            run: Any = galvi.load(path, problem)
        except ValueError as error:
            report(f"{error} The run starts anew.")
            return None
        number, remainder = divmod(run.checkpoint.first, steps_per_sample)
        same = run.step == step and run.method == self.method
        if same and run.success and not remainder and number in KEPT:
            return run
        report(f"{path.name} holds another run; this one starts anew.")
        return None


@dataclass(frozen=True)
class ReferenceParticipant:
    """A contender with adaptive steps, in one run: it does not expose low parts, so that a resumed
    run would differ from an uninterrupted one and be less accurate."""

    contender: Contender
    bodies: Bodies = OUTER

    @property
    def label(self) -> str:
        """See `RoundOffParticipant`."""
        return f"{self.contender.name}{self.bodies.label_suffix}"

    @property
    def settings(self) -> str:
        """See `RoundOffParticipant`."""
        return "default"

    def samples(
        self, problem: Problem, years: float, resume: Path | None, report: Callable[[str], None]
    ) -> Iterator[Sample]:
        """See `RoundOffParticipant`; an interrupted run is restarted."""
        yield from rounded(self.contender.run(problem, years * YEAR, {"samples": SAMPLES}))


def rounded(run: Any) -> Iterator[Sample]:
    """The samples at KEPT of a run with rounded states at hundredths of its duration."""
    rows, masses = list(KEPT), run.problem.system.masses
    v = exactly(run.p[rows]) / exactly(masses[:, None])
    errors = relative_energy_error(run.problem, exactly(run.q[rows]), v)
    for number, error in zip(KEPT, errors.tolist(), strict=True):
        yield Sample(number, error, error, "" if np.isfinite(error) else run.status)


def _sample(number: int, run: Any) -> Sample:
    """The sample at the end of a run of galvi."""
    if not run.success:
        return Sample(number, float("nan"), float("nan"), run.status)
    problem = run.problem
    rows = run.checkpoint.state[:4, : problem.q0.size]
    q, q_low, v, v_low = rows.reshape(4, *problem.q0.shape)
    exact = relative_energy_error(problem, DoubleDouble(q, q_low), DoubleDouble(v, v_low))
    masses = problem.system.masses[:, None]
    handed_out = exactly(run.p[-1]) / exactly(masses)
    rounded = relative_energy_error(problem, exactly(run.q[-1]), handed_out)
    return Sample(number, float(exact), float(rounded))
