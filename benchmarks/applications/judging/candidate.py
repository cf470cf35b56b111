"""The parts of a judgement: models and their kinds, sources of truth, own setting, candidates."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import pandas as pd

from galvi import Problem, Trajectory
from galvi.arrays import Array
from references import Contender

FEWEST_STATES = 20  # states at which a run is compared
TOLERANCES = ("epsilon", "eps_rel", "step")  # shown as the text of a setting; the step in a clock


@dataclass(frozen=True, eq=False)
class Model:
    """A model to be judged.

    Attributes
    ----------
    problem
        as galvi reads it
    native
        the user's model in its engine: a `rebound.Simulation`, or what
        `galvi.interop.from_mujoco.read` returns; None where it is rebuilt from the problem
    notes
        sentences on what was left out or is read differently
    """

    problem: Problem
    native: Any = None
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Source:
    """A contender whose runs may be the truth, at this setting.

    Attributes
    ----------
    engine
        what computes the forces; "" for galvi, whose opinion is not counted as a source
    step
        largest step; None where it chooses its own
    """

    label: str
    engine: str
    contender: Contender
    setting: Mapping[str, Any]
    step: float | None = None

    @property
    def opinion(self) -> bool:
        """Whether it is a run of galvi."""
        return not self.engine

    def run(self, problem: Problem, duration: float, samples: int) -> Trajectory:
        """The run with `samples` states after the start."""
        if self.step is None:
            return self.contender.run(problem, duration, {"samples": samples, **self.setting})
        save_every = math.ceil(abs(duration) / (samples * self.step))
        setting = {
            "step": duration / (samples * save_every),
            "save_every": save_every,
            **self.setting,
        }
        return self.contender.run(problem, duration, setting)


@dataclass(frozen=True)
class UserSetting:
    """The user's integrator; ``step``, negative backwards, is None where it chooses its own."""

    name: str
    contender: Contender
    options: Mapping[str, Any]
    step: float | None

    @property
    def label(self) -> str:
        """The integrator with its step."""
        return f"{self.name}, as it is" if self.step is None else f"{self.name}, dt = {self.step:g}"


@dataclass(frozen=True)
class Candidate:
    """A setting of an integrator; ``steps`` of the whole duration, None where it chooses them."""

    label: str
    contender: Contender
    options: Mapping[str, Any]
    steps: int | None

    def states(self, samples: int) -> int:
        """The number of saved states: `samples`, or its largest divisor from FEWEST_STATES to the
        number of steps."""
        if self.steps is None or self.steps >= samples:
            return samples
        return max(
            (k for k in range(FEWEST_STATES, self.steps + 1) if samples % k == 0), default=samples
        )

    def count(self, samples: int) -> int:
        """The number of steps, rounded up to a multiple of `states`; 0 where it chooses them."""
        states = self.states(samples)
        return -(-(self.steps or 0) // states) * states

    def setting(self, duration: float, samples: int) -> dict[str, Any]:
        """The contender's setting that saves `states(samples)` states."""
        states, count = self.states(samples), self.count(samples)
        if not count:
            return {"samples": states, **self.options}
        return {"step": duration / count, "save_every": count // states, **self.options}

    def text(self, duration: float, samples: int) -> str:
        """The step, or what stands for it."""
        if self.steps is not None:
            return f"dt = {duration / self.count(samples):.4g}"
        tolerances = [f"{k} = {v:g}" for k, v in self.options.items() if k in TOLERANCES]
        return ", ".join(["in tau" if "step" in self.options else "adaptive", *tolerances])

    def run(self, problem: Problem, duration: float, samples: int) -> Trajectory:
        """The run with these states."""
        return self.contender.run(problem, duration, self.setting(duration, samples))


class Kind(Protocol):
    """The interface of a module for a kind of model."""

    INTEGRATORS: Mapping[str, Contender]  # by their names in the user's engine
    ADAPTIVE: Sequence[str]  # those that choose their steps
    PART: str  # what a part of the model is called
    ENGINE: str  # to install where no source of the truth can be run
    ANOTHER: str  # how to choose another start, after a sentence that ends with "another"

    def model(self, problem: Problem) -> Model:
        """The model of a problem alone, whose integrator and step are among its parameters."""

    def default_duration(self, problem: Problem) -> float:
        """The duration where none is given."""

    def span(self, duration: float, step: float) -> float:
        """The duration, negative where the own step, or the duration, is; ValueError where a model
        cannot go backwards."""

    def own_contender(self, model: Model, name: str) -> Contender:
        """The integrator of this name on the user's own model, with its options."""

    def label(self, contender: Contender, options: Mapping[str, Any]) -> str:
        """The integrator with those of its options that are not the engine's defaults."""

    def states(self, problem: Problem, duration: float) -> int:
        """The number of states of the truth that are needed."""

    def sources(self, model: Model, duration: float, user_setting: UserSetting) -> list[Source]:
        """Solvers that may be the truth, the best first, without the user's setting; galvi last."""

    def engine_hint(self, model: Model) -> str:
        """How to install a second engine where all sources are of one; "" where no other runs the
        model."""

    def check(self, model: Model, truth: Trajectory) -> None:
        """ValueError, with both numbers, where at states of the truth the engine's accelerations of
        the user's own model are not those of the problem."""

    def unit(self, problem: Problem, dimension: str) -> str:
        """The unit of "length", in which errors are, or of "time", with a space before it."""

    def notes(self, model: Model, user_setting: UserSetting, truth: Trajectory) -> list[str]:
        """Sentences on the run and on the integrators that are compared with it."""

    def candidates(
        self, model: Model, duration: float, user_setting: UserSetting
    ) -> Iterator[list[Candidate]]:
        """For each integrator its settings from coarse to fine, or the steps to begin with; without
        the integrator of the user's setting where all its options are the same."""

    def shifted(self, problem: Problem, amount: float, signs: Any) -> Problem:
        """The problem from a start whose coordinates differ by this amount, relatively.

        Parameters
        ----------
        signs : array, shape (m,)
            random signs, at least as many as coordinates
        """

    def errors(self, run: Trajectory, truth: Trajectory) -> Array:
        """The distance of each part from the truth, (saved, parts)."""

    def size(self, truth: Trajectory) -> float:
        """The size of the motion, with which errors are compared."""

    def by_part(self, run: Trajectory, truth: Trajectory) -> pd.DataFrame:
        """The largest and the last error of each part, and other columns."""

    def encounters(self, truth: Trajectory) -> pd.DataFrame:
        """Close passages; a table without columns for a kind of model without them."""
