"""The participants of the round-off study (Brouwer's law) and the samples of their runs.

The low part of a state is the second term of its sum of two float64 numbers.
"""

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

HUNDREDTHS = 100
# Hundredths of a run, 1 to 100, after which a sample is taken: evenly spaced in their logarithm.
SAMPLED_HUNDREDTHS = tuple(sorted({round(10 ** (k / 10)) for k in range(21)}))
DAYS_PER_YEAR = 365.25  # Julian; the problems' unit of time is the day


@dataclass(frozen=True)
class Bodies:
    """A planetary system, and the planet by whose period steps are chosen.

    Attributes
    ----------
    label_suffix
        text that follows a label
    pacing_planet
        the index of that planet among the bodies, and its name
    """

    make: Callable[[], Problem]
    label_suffix: str
    pacing_planet: tuple[int, str]


OUTER = Bodies(galvi.problems.outer_solar_system, "", (1, "Jupiter"))
EIGHT = Bodies(
    partial(galvi.problems.solar_system, pluto=False), ", Sun + 8 planets", (1, "Mercury")
)


@dataclass(frozen=True)
class Sample:
    """Signed relative energy errors, (E - E0) / |E0|, after ``number`` hundredths of a run.

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
        self, problem: Problem, years: float, saved_path: Path | None, report: Callable[[str], None]
    ) -> Iterator[Sample]:
        """The samples after SAMPLED_HUNDREDTHS, in order.

        Parameters
        ----------
        saved_path
            file to save the run to and to resume it from; the first sample is then the one already
            reached
        report
            called with a sentence on a saved file that cannot be used

        Raises
        ------
        KeyboardInterrupt
            When the run was interrupted.
        """


@dataclass(frozen=True)
class GalerkinParticipant:
    """A galvi method with about ``steps_per_orbit`` steps in a revolution of the pacing planet."""

    method: galvi.Galerkin
    steps_per_orbit: float
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
        return f"step = about {self.bodies.pacing_planet[1]}'s period / {self.steps_per_orbit}"

    def samples(
        self, problem: Problem, years: float, saved_path: Path | None, report: Callable[[str], None]
    ) -> Iterator[Sample]:
        """See `RoundOffParticipant`; the state's low parts are those of `galvi.checkpoint`."""
        length = years * DAYS_PER_YEAR / HUNDREDTHS
        steps_per_hundredth = max(
            1, round(length * self.steps_per_orbit / period(problem, self.bodies.pacing_planet[0]))
        )
        step, completed = length / steps_per_hundredth, 0
        run = self._saved_run(problem, step, steps_per_hundredth, saved_path, report)
        if run is not None:
            completed = run.checkpoint.first // steps_per_hundredth
            yield _sample(completed, run)
        for number in SAMPLED_HUNDREDTHS[
            SAMPLED_HUNDREDTHS.index(completed) + 1 if completed else 0 :
        ]:
            steps = (number - completed) * steps_per_hundredth
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
            if saved_path is not None and number != SAMPLED_HUNDREDTHS[-1]:
                galvi.save(run, saved_path)

    def _saved_run(
        self,
        problem: Problem,
        step: float,
        steps_per_hundredth: int,
        path: Path | None,
        report: Callable[[str], None],
    ) -> Any:
        """The saved run if it has this step and method and ends at a sample; otherwise None, with a
        report."""
        if path is None or not path.exists():
            return None
        try:
            run: Any = galvi.load(path, problem)
        except ValueError as error:
            report(f"{error} The run starts anew.")
            return None
        number, remainder = divmod(run.checkpoint.first, steps_per_hundredth)
        same = run.step == step and run.method == self.method
        if same and run.success and not remainder and number in SAMPLED_HUNDREDTHS:
            return run
        report(f"{path.name} holds another run, or part of a sample; this one starts anew.")
        return None


@dataclass(frozen=True)
class ReferenceParticipant:
    """A contender with adaptive steps, run without interruption.

    It does not expose low parts, so a resumed run would differ and be less accurate.
    """

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
        self, problem: Problem, years: float, saved_path: Path | None, report: Callable[[str], None]
    ) -> Iterator[Sample]:
        """See `RoundOffParticipant`; an interrupted run is restarted."""
        yield from samples_of_rounded_run(
            self.contender.run(problem, years * DAYS_PER_YEAR, {"samples": HUNDREDTHS})
        )


def samples_of_rounded_run(run: Any) -> Iterator[Sample]:
    """The samples of a run with rounded states at 0, 1, ... 100 hundredths of its duration."""
    rows, masses = list(SAMPLED_HUNDREDTHS), run.problem.system.masses
    v = exactly(run.p[rows]) / exactly(masses[:, None])
    errors = relative_energy_error(run.problem, exactly(run.q[rows]), v)
    for number, error in zip(SAMPLED_HUNDREDTHS, errors.tolist(), strict=True):
        yield Sample(number, error, error, "" if np.isfinite(error) else run.status)


def _sample(number: int, run: Any) -> Sample:
    """The sample at the end of a run of galvi; NaN with the status for a run that failed.

    The rows of the state are q, its low part, v and its low part, as in `galvi.checkpoint`.
    """
    if not run.success:
        return Sample(number, float("nan"), float("nan"), run.status)
    problem = run.problem
    rows = run.checkpoint.state[:4, : problem.q0.size]
    q, q_low, v, v_low = rows.reshape(4, *problem.q0.shape)
    error = relative_energy_error(problem, DoubleDouble(q, q_low), DoubleDouble(v, v_low))
    masses = problem.system.masses[:, None]
    v_rounded = exactly(run.p[-1]) / exactly(masses)
    error_of_rounded = relative_energy_error(problem, exactly(run.q[-1]), v_rounded)
    return Sample(number, float(error), float(error_of_rounded))
