"""A free body over many turns: errors of energy, momentum and attitude, and their long form."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

import galvi
from benchmarks.applications.external.integrator import ExternalIntegrator
from benchmarks.checks.claim import Report
from benchmarks.measures import independent_invariants
from benchmarks.store.provenance import today, version
from benchmarks.store.row_files import RowFiles, stored_rows
from benchmarks.work_precision.galvi_methods import gauss_collocation
from benchmarks.work_precision.participants import finest, label_beside
from benchmarks.work_precision.problem import largest_difference
from benchmarks.work_precision.problems.rigid_bodies import MUJOCO_CONTENDERS
from galvi import Problem
from galvi.arrays import Array
from galvi.charts import CHARTS
from references import Contender
from references.closed_forms.top_motion import FREE_TOP
from references.mujoco import engine as mujoco_engine

# Drift of energy and angular momentum in long rotations of a free body.
#
# H's free body by galvi in every chart and by each of MuJoCo's integrators, and the free box of
# MuJoCo's own tests. A turn is one rotation at the initial angular speed. MuJoCo's `implicitfast`
# and `discrete` integrate rotation differently on ball and free joints: the long runs are on free
# joints, those of the box on both.

COLUMNS: Mapping[str, type] = {
    "problem": str,
    "contender": str,
    "engine": str,
    "step": float,
    "turns": float,
    "turn": float,
    "energy_error": float,
    "momentum_error": float,
    "attitude_error": float,
    "status": str,
    "commit": str,
    "date": str,
}
TURNS, QUICK_TURNS = 1000, 100
STEP_UNIT = 2.0**-20  # steps are multiples of it, so that their ends are exactly representable
BOX_STEP, BOX_STEPS = 0.01, 500  # as in MuJoCo's test
MUJOCO_STEP = 0.01
STEPS_A_TURN = 5  # fewest steps per turn of an external integrator without settings


@dataclass(frozen=True)
class DriftParticipant:
    """A contender at one step.

    Attributes
    ----------
    label
        label in tables
    step
        nominal step, rounded to a multiple of STEP_UNIT for the body; the box has its own step
    joint
        "free" for a body that could also translate, although it does not
    origin
        path of an external integrator; "" for others
    """

    label: str
    contender: Contender
    step: float
    joint: str = ""
    origin: str = ""

    @property
    def engine(self) -> str:
        """The engine: "galvi", MuJoCo's name and version, or the path of an external integrator."""
        if self.origin:
            return self.origin
        mujoco = self.contender in MUJOCO_CONTENDERS and not self.contender.missing
        return mujoco_engine.version() if mujoco else "galvi"


def _galvi(degree: int, step: float) -> list[DriftParticipant]:
    return [
        DriftParticipant(
            f"galvi degree {degree}, Gauss {degree}, {chart.name}",
            gauss_collocation(degree, chart),
            step,
        )
        for chart in CHARTS
    ]


def _mujoco(joint: str, step: float) -> list[DriftParticipant]:
    return [
        DriftParticipant(f"{contender.name}, {joint} joint", contender, step, joint)
        for contender in MUJOCO_CONTENDERS
    ]


PARTICIPANTS = (*_galvi(4, 0.125), *_galvi(8, 0.4), *_mujoco("free", MUJOCO_STEP))
ON_BOX = (*_galvi(4, BOX_STEP), *_mujoco("free", BOX_STEP), *_mujoco("ball", BOX_STEP))


def free_spin(
    quick: bool = False,
    report: Report = lambda sentence: None,
    participants: Sequence[DriftParticipant] = PARTICIPANTS,
    on_box: Sequence[DriftParticipant] = ON_BOX,
    externals: Sequence[ExternalIntegrator] = (),
) -> pd.DataFrame:
    """Rows of each contender at the marks of its run; external integrators take part where they
    can. See COLUMNS.

    engine          galvi, name and version of another, or the path of an external integrator
    step            NaN for a contender that chooses its own
    turns           length of the run; `turn` is the mark of the row
    energy_error    E / E0 - 1 of largest magnitude since the previous row, signed
    momentum_error  |L - L0| / |L0|, likewise, in space
    attitude_error  largest entry of R - R_true against the closed form; at the end only
    status          empty, or why there is no number
    """
    turns = QUICK_TURNS if quick else TURNS
    rows = []
    for participant in on_box:
        rows += box_rows(participant)
    for participant in participants:
        report(f"{participant.label}, {turns} turns")
        rows += body_rows(participant, turns)
    labels = [participant.label for participant in (*participants, *on_box)]
    for external in externals:
        report(f"{external.name}, {turns} turns")
        rows += external_rows(external, label_beside(external, labels), turns)
    return pd.DataFrame(rows, columns=list(COLUMNS))


def body_rows(participant: DriftParticipant, turns: int) -> list[dict[str, Any]]:
    """Rows of H's free body, at turns 1, 2, 5, 10, ... and the last."""
    problem = galvi.problems.free_rigid_body()
    step = max(1, round(participant.step / STEP_UNIT)) * STEP_UNIT
    per_turn = max(1, round(period(problem) / step))
    setting = {"step": step, "save_every": per_turn}
    return _rows(participant, problem, setting, per_turn * turns * step, marks(turns))


def box_rows(participant: DriftParticipant) -> list[dict[str, Any]]:
    """The row of MuJoCo's free box, after the steps of MuJoCo's test."""
    problem = galvi.problems.free_box()
    setting = {"step": BOX_STEP, "save_every": BOX_STEPS}
    return _rows(participant, problem, setting, BOX_STEPS * BOX_STEP, [1])


def external_rows(external: ExternalIntegrator, label: str, turns: int) -> list[dict[str, Any]]:
    """The box and the body by an external integrator, each at its finest setting."""
    body, box = galvi.problems.free_rigid_body(), galvi.problems.free_box()
    turn = round(period(body) / STEP_UNIT) * STEP_UNIT
    rows = []
    for problem, duration, parts, fewest, indices in (
        (box, BOX_STEPS * BOX_STEP, 1, BOX_STEPS, [1]),
        (body, turns * turn, turns, turns * STEPS_A_TURN, marks(turns)),
    ):
        setting = finest(external, problem, duration, parts, fewest)
        if setting is not None:
            participant = DriftParticipant(label, external, float("nan"), origin=external.path)
            rows += _rows(participant, problem, setting, duration, indices)
    return rows


def period(problem: Problem) -> float:
    """The duration of one turn, at the initial angular speed."""
    return float(math.tau / np.linalg.norm(problem.v0))


def marks(turns: int) -> list[int]:
    """1, 2, 5, 10, 20, 50, ... below the number of turns, and that number."""
    decades = range(math.ceil(math.log10(turns)) + 1)
    return [n for k in decades for j in (1, 2, 5) if (n := j * 10**k) < turns] + [turns]


def _rows(
    participant: DriftParticipant,
    problem: Problem,
    setting: Mapping[str, Any],
    duration: float,
    indices: Sequence[int],
) -> list[dict[str, Any]]:
    """The rows of a run at this setting, at the saved states with these indices."""
    turn, nan = period(problem), float("nan")
    shared = {
        "problem": problem.name,
        "contender": participant.label,
        "engine": participant.engine,
        "step": setting.get("step", nan),
        "turns": duration / turn,
        "turn": nan,
        "energy_error": nan,
        "momentum_error": nan,
        "attitude_error": nan,
        "status": participant.contender.missing,
        "commit": "",
        "date": "",
    }
    if participant.contender.missing:
        return [shared]
    moving = _unbound(problem) if participant.joint == "free" else problem
    run = participant.contender.run(moving, duration, setting)
    R, w = run.q[:, :3, :3], run.problem.system.velocity(run.p)[:, :3]
    energy, momentum = _energy_errors(problem, R, w), _momentum_errors(problem, R, w)
    rows = []
    for first, last in zip([0, *indices[:-1]], indices, strict=True):
        rows.append(
            {
                **shared,
                "turn": float(run.t[last] - run.t[0]) / turn,
                "energy_error": _largest(energy[first + 1 : last + 1]),
                "momentum_error": _largest(momentum[first + 1 : last + 1]),
                "status": "" if np.all(np.isfinite(R[last])) else run.status,
            }
        )
    truth = FREE_TOP.run(problem, duration, {"samples": 1})
    rows[-1]["attitude_error"] = largest_difference(R[-1], truth.q[-1])
    return rows


def _unbound(problem: Problem) -> Problem:
    """The problem of the same body on SE(3), which may translate too."""
    body = galvi.FreeBody(1.0, problem.system.inertia)
    start = np.eye(4)
    start[:3, :3] = problem.q0
    return galvi.Problem(body, start, np.concatenate([problem.v0, np.zeros(3)]))


def _energy_errors(problem: Problem, R: Array, w: Array) -> Array:
    """E / E0 - 1 of attitudes (k, 3, 3) and angular velocities in the body's frame (k, 3), (k,)."""
    exact = independent_invariants.energy(problem, problem.q0[None], problem.v0[None])
    return independent_invariants.energy(problem, R, w) / exact - 1.0


def _momentum_errors(problem: Problem, R: Array, w: Array) -> Array:
    """|L - L0| / |L0| of attitudes (k, 3, 3) and body angular velocities (k, 3), (k,)."""
    exact = independent_invariants.angular_momentum(problem, problem.q0[None], problem.v0[None])
    change = np.linalg.norm(independent_invariants.angular_momentum(problem, R, w) - exact, axis=-1)
    return change / np.linalg.norm(exact)


def _largest(errors: Array) -> float:
    """The error of largest magnitude; NaN when one is NaN."""
    return float(errors[np.argmax(np.abs(errors))])


MANY_TURNS = 100_000
FOLDER = "free_spin"  # subfolder of the studies


@dataclass(frozen=True)
class Part:
    """One contender's long run.

    Attributes
    ----------
    files
        the files of its rows
    code
        version of the code
    """

    participant: DriftParticipant
    turns: int
    files: RowFiles
    code: str

    @property
    def title(self) -> str:
        """The title for progress output."""
        return f"{self.participant.label}, {self.turns} turns"

    @property
    def name(self) -> str:
        """The name of its file: contender, turns, engine and version."""
        text = f"{self.title} {self.participant.engine}"
        return f"{re.sub(r'[^a-z0-9.]+', '-', text.lower()).strip('-')}_{self.code}"

    def is_complete(self) -> bool:
        """Whether its rows exist."""
        return self.files.read(self.name) is not None

    def run(self, report: Report) -> None:
        """Make the run and store its rows."""
        report(self.title)
        rows = pd.DataFrame(body_rows(self.participant, self.turns), columns=list(COLUMNS))
        self.files.write(self.name, rows.assign(commit=self.code, date=today()))


def parts(
    studies: Path,
    report: Report,
    turns: int = MANY_TURNS,
    participants: Sequence[DriftParticipant] = PARTICIPANTS,
    code: str | None = None,
) -> list[Part]:
    """A part for each available contender."""
    files, code = RowFiles(studies / FOLDER, COLUMNS, report), code or version()
    for participant in participants:
        if participant.contender.missing:
            report(f"{participant.label}: {participant.contender.missing}")
    return [
        Part(participant, turns, files, code)
        for participant in participants
        if not participant.contender.missing
    ]


stored = stored_rows(FOLDER, COLUMNS)
