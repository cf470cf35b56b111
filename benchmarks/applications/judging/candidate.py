"""Parts of a judgement: models and their kinds, sources of truth, user settings, candidates."""

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
TOLERANCES = ("epsilon", "eps_rel", "step")  # options shown in a setting's text; step: in a clock


@dataclass(frozen=True, eq=False)
class Model:
    """A model to be judged.

    Attributes
    ----------
    problem
        the model as galvi reads it
    native
        the user's model in its engine: a `rebound.Simulation`, or the model that
        `galvi.interop.from_mujoco.read` returns; None where it is rebuilt from the problem
    notes
        sentences on parts of the model that were left out or are read differently
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
        name of the code that computes the forces; "" for galvi, which is not counted as a source
    step
        largest step; None where the contender chooses its steps
    """

    label: str
    engine: str
    contender: Contender
    setting: Mapping[str, Any]
    step: float | None = None

    @property
    def is_galvi(self) -> bool:
        """Whether it is a run of galvi."""
        return not self.engine

    def run(self, problem: Problem, duration: float, samples: int) -> Trajectory:
        """Run with `samples` states after the start."""
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
    """The user's integrator; ``step`` is negative backwards, and None where the integrator chooses
    its steps."""

    name: str
    contender: Contender
    options: Mapping[str, Any]
    step: float | None

    @property
    def label(self) -> str:
        """The integrator's name with its step, or with "as it is" where it chooses its steps."""
        return f"{self.name}, as it is" if self.step is None else f"{self.name}, dt = {self.step:g}"


@dataclass(frozen=True)
class Candidate:
    """A setting of an integrator; ``steps`` is the number for the whole duration, None where the
    integrator chooses them."""

    label: str
    contender: Contender
    options: Mapping[str, Any]
    steps: int | None

    def states(self, samples: int) -> int:
        """The number of saved states: `samples`, or, with fewer steps, its largest divisor from
        FEWEST_STATES to the number of steps, if there is one."""
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
        """The step as text; tolerances for an integrator that chooses its steps."""
        if self.steps is not None:
            return f"dt = {duration / self.count(samples):.4g}"
        tolerances = [f"{k} = {v:g}" for k, v in self.options.items() if k in TOLERANCES]
        return ", ".join(["in tau" if "step" in self.options else "adaptive", *tolerances])

    def run(self, problem: Problem, duration: float, samples: int) -> Trajectory:
        """Run with `states(samples)` states after the start."""
        return self.contender.run(problem, duration, self.setting(duration, samples))


class Kind(Protocol):
    """The interface of a module for a kind of model."""

    INTEGRATORS: Mapping[str, Contender]  # by their names in the user's engine
    ADAPTIVE: Sequence[str]  # those that choose their steps
    PART: str  # the word for a part of the model
    ENGINE: str  # package to install where no source of the truth can be run
    ANOTHER: str  # end of a sentence "choose another": how to choose another start

    def model(self, problem: Problem) -> Model:
        """The model of a problem, whose parameters name the integrator and step."""

    def default_duration(self, problem: Problem) -> float:
        """The duration of a judgement that names none."""

    def span(self, duration: float, step: float) -> float:
        """The duration, negative where it or the user's step is negative; ValueError where the
        model cannot run backwards."""

    def own_contender(self, model: Model, name: str) -> Contender:
        """The integrator of this name on the user's own model, with its options."""

    def label(self, contender: Contender, options: Mapping[str, Any]) -> str:
        """The integrator's name and those options that differ from the engine's defaults."""

    def states(self, problem: Problem, duration: float) -> int:
        """The number of states of the truth that are needed to find encounters; 1 without them."""

    def sources(self, model: Model, duration: float, user_setting: UserSetting) -> list[Source]:
        """Solvers that may be the truth, the best first; galvi last."""

    def engine_hint(self, model: Model) -> str:
        """A hint how to install a second engine; "" where no other engine runs the model."""

    def check(self, model: Model, truth: Trajectory) -> None:
        """Raise ValueError where, at states of the truth, the engine's accelerations of the user's
        model differ from those of the problem."""

    def unit(self, problem: Problem, dimension: str) -> str:
        """The unit of errors ("length") or of times ("time"), with a space before it."""

    def notes(self, model: Model, user_setting: UserSetting, truth: Trajectory) -> list[str]:
        """Sentences for the user on the model and on the run."""

    def candidates(
        self, model: Model, duration: float, user_setting: UserSetting
    ) -> Iterator[list[Candidate]]:
        """Yield for each integrator its settings from coarse to fine, or the steps to begin
        with."""

    def shifted(self, problem: Problem, amount: float, signs: Any) -> Problem:
        """The problem from a start whose coordinates differ by this relative amount.

        Parameters
        ----------
        signs : array, shape (m,)
            random signs, at least as many as coordinates
        """

    def errors(self, run: Trajectory, truth: Trajectory) -> Array:
        """The distance of each part from the truth, (saved, parts)."""

    def size(self, truth: Trajectory) -> float:
        """The size of the motion, to which errors are compared."""

    def by_part(self, run: Trajectory, truth: Trajectory) -> pd.DataFrame:
        """The largest and the last error of each part, and other columns."""

    def encounters(self, truth: Trajectory) -> pd.DataFrame:
        """The close passages; an empty table without columns for models without passages."""
