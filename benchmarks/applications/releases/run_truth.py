"""The truth of a user's own run, where galvi reads the model: from two sources of `judge`."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from benchmarks.applications.judging.candidate import Kind, Model
from benchmarks.applications.judging.judgement import LOST_FRACTION, kind_of, own_setting
from benchmarks.applications.judging.truth import states_of
from benchmarks.applications.releases.own_run import SAMPLES, Motion, OwnRun
from galvi import Trajectory
from galvi.systems.lagrangian import momentum_at


@dataclass(frozen=True, eq=False)
class RunTruth:
    """The true states at the times at which a run is compared.

    Attributes
    ----------
    trajectory
        states of the best source, after the start
    source, confirmed_by
        labels of the best source and of the second one; "" where no second one reaches the end
    disagreement
        largest distance of a part of the model between the two at any time; NaN without a second
        one
    """

    kind: Kind
    trajectory: Trajectory
    source: str
    confirmed_by: str
    disagreement: float

    def error(self, motion: Motion) -> float:
        """The largest distance of a part of the model from its true position, at any sample."""
        truth, system = self.trajectory, self.trajectory.problem.system
        if hasattr(system, "from_mujoco"):
            q, v = system.from_mujoco(motion.positions, motion.velocities)
        else:
            q, v = (x.reshape(truth.q.shape) for x in (motion.positions, motion.velocities))
        run = Trajectory(
            truth.problem, truth.t, q, momentum_at(system, q, v, truth.t), velocities=v
        )
        return float(np.max(self.kind.errors(run, truth)))


def truth_of(run: OwnRun) -> tuple[RunTruth | None, str]:
    """The truth and ""; None and the reason, as a sentence, where there is none."""
    if run.model is None:
        return None, f"There is no truth to compare with: {run.unread}"
    try:
        return _truth(run, run.model), ""
    except (ValueError, RuntimeError) as error:
        return None, f"There is no truth to compare with: {error}"


def _truth(run: OwnRun, model: Model) -> RunTruth:
    """Raises ValueError for a model that cannot be judged and where sources disagree, RuntimeError
    where none reaches the end."""
    kind = kind_of(model.problem)
    setting = {"integrator": run.integrator, **({} if run.step is None else {"dt": run.step})}
    user_setting = own_setting(kind, model, setting)
    sources = [
        candidate
        for candidate in kind.sources(model, run.duration, user_setting)
        if not candidate.is_galvi
    ]
    reached = []
    for source in sources:
        trajectory = source.run(model.problem, run.duration, SAMPLES)
        if trajectory.success:
            reached.append((source.label, states_of(trajectory, slice(1, None))))
        if len(reached) == 2:
            break
    if not reached:
        raise RuntimeError("no source of it reaches the end of the run.")
    kind.check(model, reached[0][1])
    (label, truth), (confirmed_by, confirming) = reached[0], reached[-1]
    if len(reached) == 1:
        return RunTruth(kind, truth, label, "", float("nan"))
    disagreement = float(np.max(kind.errors(confirming, truth)))
    if not disagreement < LOST_FRACTION * kind.size(truth):
        raise ValueError(
            f"its sources, {label} and {confirmed_by}, part by {disagreement:.3g}. Take a shorter "
            "--duration."
        )
    return RunTruth(kind, truth, label, confirmed_by, disagreement)
