"""A user's own run by its engine, in this environment or in that of another release."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.applications.judging import bodies, trees
from benchmarks.applications.judging.candidate import Model
from benchmarks.store.isolated_environment import output_of
from galvi import input_checks
from galvi.arrays import Array
from galvi.interop import from_mujoco, rebound
from galvi.interop.judge import MODEL_SUFFIXES, JudgeRequest
from galvi.interop.rebound_contents import ALL_ACTIVE, OPTIONS
from references.mujoco import own_model
from references.rebound import own_simulation
from references.rebound.users import defaults

SAMPLES = 10  # times at which a run is compared
RUN_KEYS = ("integrator", "dt")  # keys of a user's run that are not options of the integrator
OPTIONS_OF = {name: OPTIONS[name] for name in bodies.INTEGRATORS}


@dataclass(frozen=True, eq=False)
class Motion:
    """A run.

    Attributes
    ----------
    positions, velocities : array, shape (saved, n)
        states after the start; rows past a failure are NaN
    energy, kinetic : array, shape (saved,)
        total and kinetic energy
    failure
        a sentence on a failure; "" where the run reached its end
    steps_taken
        number of steps that REBOUND counted; 0 for MuJoCo
    """

    positions: Array
    velocities: Array
    energy: Array
    kinetic: Array
    failure: str
    steps_taken: int = 0

    @property
    def quantities(self) -> dict[str, Array]:
        """The quantities that a test would compare, by name, (saved, values)."""
        states = {"positions": self.positions, "velocities": self.velocities}
        return {**states, "energy": self.energy[:, None]}


@dataclass(frozen=True, eq=False)
class Answer:
    """The answer of an engine: its release, a motion for each requested run, and the accelerations
    (n,) and the energy at each requested state."""

    release: str
    motions: tuple[Motion, ...]
    accelerations: tuple[Array, ...]
    energies: tuple[float, ...]


@dataclass(frozen=True, eq=False)
class OwnRun:
    """A user's run as data, without the engine.

    Attributes
    ----------
    package
        the engine's name on the package index
    program, job
        program that runs in an environment, and its input, see the program
    positions, velocities : array, shape (n,)
        the start, in the engine's coordinates
    integrator, step
        the user's integrator, and its step; None where the integrator chooses its steps
    duration
        duration, of a multiple of SAMPLES steps where these are equal
    model, unread
        the model as `judge` reads it and ""; None and the reason where it cannot be read
    """

    package: str
    program: Path
    job: Mapping[str, Any]
    positions: Array
    velocities: Array
    integrator: str
    step: float | None
    duration: float
    model: Model | None
    unread: str

    @property
    def times(self) -> Array:
        """The times after the start at which the run is compared, (SAMPLES,)."""
        return self.duration * np.arange(1, SAMPLES + 1) / SAMPLES

    @property
    def steps(self) -> int:
        """The number of steps of the run; the integrator must take equal steps."""
        assert self.step is not None
        return round(self.duration / self.step)

    def request(
        self, positions: Array | None = None, velocities: Array | None = None, steps: int = 0
    ) -> dict[str, Any]:
        """The request of a run, as in the program; positions, velocities and the number of steps (a
        multiple of SAMPLES), where passed, replace the user's."""
        start = self._start(
            self.positions if positions is None else positions,
            self.velocities if velocities is None else velocities,
        )
        if self.package == "mujoco":
            start["integrator"] = self.integrator
        if self.step is None:
            return {**start, "times": (self.job.get("t", 0.0) + self.times).tolist()}
        count = steps or self.steps
        step = self.step if count == self.steps else self.duration / count
        return {**start, "step": step, "steps": count, "every": count // SAMPLES}

    def _start(self, positions: Array, velocities: Array) -> dict[str, Any]:
        if self.package == "mujoco":
            return {"qpos": positions.tolist(), "qvel": velocities.tolist()}
        masses = np.array([row[0] for row in self.job["particles"]])[:, None]
        rows = (masses, positions.reshape(-1, 3), velocities.reshape(-1, 3))
        return {"particles": np.hstack(rows).tolist()}

    def answer(
        self,
        runs: Sequence[Mapping[str, Any]],
        states: Sequence[Mapping[str, Any]] = (),
        python: str | Path = sys.executable,
        environment: Mapping[str, str] | None = None,
        threads: int = 1,
    ) -> Answer:
        """Run the program in a process of its own and return the engine's answer.

        Parameters
        ----------
        runs, states
            requests, see `request`
        python
            the interpreter of the environment with the release
        environment
            further environment variables
        threads
            number of threads that share MuJoCo's runs

        Raises
        ------
        EnvironmentUnavailable
            Where the program fails.
        """
        job = {**self.job, "runs": list(runs), "threads": threads}
        starts = [state if self.package == "mujoco" else state["particles"] for state in states]
        command = [str(python), "-I", str(self.program)]
        reply = json.loads(output_of(command, json.dumps({**job, "states": starts}), environment))
        return Answer(
            f"{self.package} {reply['release']}",
            tuple(self._motion(run) for run in reply["runs"]),
            tuple(np.ravel(accelerations) for accelerations in reply["accelerations"]),
            tuple(reply["energies"]),
        )

    def _motion(self, rows: Mapping[str, Any]) -> Motion:
        if self.package == "mujoco":
            states = rows["qpos"], rows["qvel"]
        else:
            particles = [np.array(state) for state in rows["particles"]]
            states = [x[:, 1:4].ravel() for x in particles], [x[:, 4:].ravel() for x in particles]
        positions, velocities = (
            _filled(saved, SAMPLES, start.size)
            for saved, start in zip(states, (self.positions, self.velocities), strict=True)
        )
        energy, kinetic = (
            _filled([[number] for number in rows[name]], SAMPLES, 1)[:, 0]
            for name in ("energy", "kinetic")
        )
        steps_taken = rows.get("taken", 0)
        return Motion(positions, velocities, energy, kinetic, rows["failure"], steps_taken)


def _filled(rows: Sequence[Any], count: int, size: int) -> Array:
    """The rows, padded with rows of NaN to the shape (count, size)."""
    values = np.full((count, size), np.nan)
    if len(rows):
        values[: len(rows)] = rows
    return values


def read_own_run(file: Path, request: JudgeRequest) -> OwnRun:
    """A user's run: a MuJoCo model, whatever is in it, or a REBOUND simulation.

    Parameters
    ----------
    request
        duration, integrator and step of the user, and the start, as for `judge`

    Raises
    ------
    ValueError, FileNotFoundError, ImportError, RuntimeError
        With a sentence, where the run cannot be read or repeated.
    """
    return (
        _of_mujoco(file, request) if file.suffix in MODEL_SUFFIXES else _of_rebound(file, request)
    )


def _of_mujoco(file: Path, request: JudgeRequest) -> OwnRun:
    if request.snapshot != -1 or request.extras:
        raise ValueError(f"--snapshot and --extras are for REBOUND files; received {file}.")
    model = from_mujoco.model_of(file)
    job: dict[str, Any] = {"file": str(file.resolve())}
    if request.key is not None:
        job["key"] = from_mujoco.keyframe_number(model, request.key)
    for name, size in (("qpos", model.nq), ("qvel", model.nv), ("ctrl", model.nu)):
        entries = getattr(request, name)
        if entries is not None:
            job[name] = input_checks.array(name, entries, (size,)).tolist()
    name = from_mujoco.integrator_name(model)
    options_of = dict.fromkeys(trees.INTEGRATORS, ())
    integrator, step = _integrator_and_step(request, name, model.opt.timestep, options_of)
    if step is not None and step < 0.0:
        raise ValueError(f"own dt of a MuJoCo model must be positive; received {step:g}.")
    job["integrator"] = integrator
    span = trees.DEFAULT_DURATION if request.duration is None else request.duration
    duration, step = _in_full_steps(trees.span(span, 0.0), step)
    start = own_model.at_start(model, job)
    try:
        start_options = request.key, request.qpos, request.qvel, request.ctrl
        model_read, unread = Model(*from_mujoco.read(model, (), *start_options)), ""
    except ValueError as error:
        lines = str(error).partition("\nLeave them out")[0].splitlines()
        model_read, unread = None, f"{lines[0]} {'; '.join(line.strip() for line in lines[1:])}"
    return OwnRun(
        "mujoco",
        Path(own_model.__file__),
        job,
        start.qpos.copy(),
        start.qvel.copy(),
        integrator,
        step,
        duration,
        model_read,
        unread,
    )


def _of_rebound(file: Path, request: JudgeRequest) -> OwnRun:
    start_options = (request.key, request.qpos, request.qvel, request.ctrl)
    if any(value is not None for value in start_options):
        raise ValueError(
            f"--key, --qpos, --qvel and --ctrl are for MuJoCo models; received {file}."
        )
    if request.extras:
        raise ValueError("forces of REBOUNDx cannot be run in other releases; leave --extras out.")
    problem, sim = rebound.read(file, request.snapshot)
    if problem.q0.shape[1] != 3:
        raise ValueError(
            f"a simulation must have three dimensions; received {problem.q0.shape[1]}."
        )
    parameters = problem.parameters
    integrator, step = _integrator_and_step(
        request, parameters["integrator"], parameters.get("dt"), OPTIONS_OF
    )
    integrator = integrator.lower()
    options = {**parameters.get("options", {})} if integrator == parameters["integrator"] else {}
    usual = defaults(integrator)  # of the installed release; those of other releases may differ
    options = {name: value for name, value in options.items() if usual.get(name) != value}
    options |= {name: value for name, value in request.own.items() if name not in RUN_KEYS}
    span = bodies.default_duration(problem) if request.duration is None else request.duration
    input_checks.positive("duration", abs(span))
    duration, step = (span, None) if integrator in bodies.ADAPTIVE else _in_full_steps(span, step)
    masses = np.array([particle.m for particle in sim.particles])
    particles = np.hstack([masses[:, None], problem.q0, problem.v0])
    job = {
        "G": problem.system.G,
        "t": problem.t0,
        "integrator": integrator,
        "step": step or parameters.get("dt"),
        "settings": _settings(sim),
        "options": {
            name: value.lower() if isinstance(value, str) else value
            for name, value in options.items()
        },
        "particles": particles.tolist(),
    }
    return OwnRun(
        "rebound",
        Path(own_simulation.__file__),
        job,
        problem.q0.ravel(),
        problem.v0.ravel(),
        integrator,
        step,
        duration,
        Model(problem, sim),
        "",
    )


def _settings(sim: Any) -> dict[str, Any]:
    """Settings of a simulation, besides integrator, step and particles, that change its run.

    ValueError for gravity by a tree; `read` refuses all other settings.
    """
    if sim.gravity == "tree":
        raise ValueError(
            "gravity by a tree cannot be run from its particles alone; set sim.gravity = 'basic'."
        )
    active = {} if sim.N_active in ALL_ACTIVE else {"N_active": sim.N_active}
    return active | ({"gravity": sim.gravity} if sim.gravity == "compensated" else {})


def _integrator_and_step(
    request: JudgeRequest,
    integrator: str,
    step: float | None,
    options_of: Mapping[str, Sequence[str]],
) -> tuple[str, float | None]:
    """The user's integrator and step: as requested, or else as in the file.

    Parameters
    ----------
    options_of
        names of the options of each integrator

    Raises
    ------
    ValueError
        For an integrator that is not in `options_of`, and for an option that it does not have.
    """
    name = str(request.own.get("integrator", integrator))
    if name.lower() not in options_of:
        raise ValueError(
            f"own integrator must be one of {', '.join(options_of)}; received {name!r}."
        )
    options = options_of[name.lower()]
    wrong = [option for option in request.own if option not in (*RUN_KEYS, *options)]
    if wrong:
        raise ValueError(
            f"options of your run must be among {', '.join((*RUN_KEYS, *options))} with {name}; "
            f"received {wrong[0]!r}."
        )
    dt = request.own.get("dt", step)
    return name, None if dt is None else input_checks.real("own dt", dt)


def _in_full_steps(duration: float, step: float | None) -> tuple[float, float]:
    """The duration, lengthened to a multiple of SAMPLES steps, and the step; both are negative
    where one of them is. ValueError for a step that is missing or 0, and for a duration of 0."""
    if not step:
        raise ValueError(f"the step must not be 0 or missing; received {step}. Give --own dt=STEP.")
    steps = input_checks.positive("duration", abs(duration)) / abs(step)
    count = SAMPLES * max(1, math.ceil(round(steps, 9) / SAMPLES))
    step = -abs(step) if duration < 0.0 else step
    return count * step, step
