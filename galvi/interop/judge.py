"""`judge`: the command ``galvi judge``, run from Python in a process of its own."""

from __future__ import annotations

import json
import os
import pickle
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from galvi.input_checks import shown
from galvi.interop import from_mujoco as mujoco_reader
from galvi.interop import rebound as rebound_reader
from galvi.interop import suite_process
from galvi.interop.rebound_contents import copied
from galvi.problem import Problem
from galvi.systems.multibody import Multibody

if TYPE_CHECKING:
    import pandas

MODEL_SUFFIXES = (".xml", ".mjb", ".urdf", ".mjz")  # of files of MuJoCo
PROBLEM, MODEL, SIMULATION = "problem", "model", "simulation"


@dataclass(frozen=True)
class JudgeRequest:
    """The arguments of `judge`, which are passed to the command as JSON.

    Attributes
    ----------
    is_problem
        whether the file is a pickled `galvi.Problem`; a process loads it only if its environment
        has the digest of the file, which `judge` sets
    extras
        path of a file of REBOUNDx with the simulation's forces; "" for none
    """

    duration: float | None = None
    error: float | None = None
    own: Mapping[str, Any] = field(default_factory=dict)
    snapshot: int = -1
    ignore: Sequence[str] = ()
    key: int | str | None = None
    qpos: Sequence[float] | None = None
    qvel: Sequence[float] | None = None
    ctrl: Sequence[float] | None = None
    quick: bool = False
    is_problem: bool = False
    extras: str = ""

    def to_json(self) -> str:
        """The request as JSON, with numbers and arrays of NumPy as plain numbers and lists."""
        return json.dumps(asdict(self), default=lambda value: np.asarray(value).tolist())

    @classmethod
    def from_json(cls, text: str) -> JudgeRequest:
        """The request that `to_json` wrote."""
        return cls(**json.loads(text))


@dataclass(frozen=True)
class Judged:
    """The error of a model's own run, and the cheapest setting that reaches a given error.

    Attributes
    ----------
    data
        the contents of ``judge.json``; `summary` has the findings in sentences
    page
        the page as HTML, which notebooks show

    Examples
    --------
    >>> import rebound
    >>> sim = rebound.Simulation()
    >>> sim.integrator, sim.dt = "whfast", 0.1
    >>> sim.add(m=1.0)
    >>> sim.add(m=1e-3, a=1.0, e=0.05)
    >>> verdict = galvi.judge(sim, duration=60.0, error=1e-3, quick=True)
    >>> verdict.passed, verdict.own["error"] < 1e-3, verdict.recommended["reached"]
    (True, True, True)
    """

    data: Mapping[str, Any]
    page: str

    @property
    def summary(self) -> list[str]:
        """The findings in sentences."""
        return list(self.data["summary"])

    @property
    def notes(self) -> list[str]:
        """Sentences on the parts of the model that were left out, and on how it was read and
        run."""
        return list(self.data["notes"])

    @property
    def duration(self) -> float:
        """Duration of the run in the model's unit of time; negative for a run backwards."""
        return float(self.data["duration"])

    @property
    def passed(self) -> bool:
        """Whether the user's own run reaches the error."""
        return bool(self.data["passed"])

    @property
    def own(self) -> Mapping[str, Any]:
        """The user's own setting and run: integrator, error, energy and momentum (their largest
        relative changes), seconds, status; None for an unknown number."""
        return self.data["own"]

    @property
    def truth_agreement(self) -> float:
        """The largest distance between two sources of the truth; NaN where there is only one."""
        agreement = self.data["truth_agreement"]
        return float("nan") if agreement is None else float(agreement)

    @property
    def recommended(self) -> Mapping[str, Any] | None:
        """The cheapest integrator and setting that reach the error, with error, energy and seconds;
        None where none does."""
        return self.data["recommended"]

    @property
    def table(self) -> pandas.DataFrame:
        """The settings that were tried, a row each: first those that reach the error, fastest
        first."""
        import pandas

        return pandas.DataFrame(self.data["table"])

    def __repr__(self) -> str:
        return " ".join([*self.notes, *self.summary])

    def _repr_html_(self) -> str:
        return self.page


def judge(
    source: Any,
    duration: float | None = None,
    error: float | None = None,
    own: Mapping[str, Any] | None = None,
    snapshot: int = -1,
    ignore: Sequence[str] = (),
    key: int | str | None = None,
    *,
    qpos: Any = None,
    qvel: Any = None,
    ctrl: Any = None,
    quick: bool = False,
    extras: Any = None,
) -> Judged:
    """Judge a simulation of REBOUND, a model of MuJoCo, a file of either, or a problem.

    Parameters
    ----------
    source
        as `galvi.from_rebound` takes it, with ``snapshot``, or `galvi.from_mujoco`, with ``ignore``
        and ``key``; or a `galvi.Problem` of point masses or of a tree
    duration
        in the source's unit of time; the run goes backwards if it or the own dt is negative. None:
        100 revolutions of the fastest body, or 10 for a model
    error
        largest error allowed of a body or of a joint at any time; None: that of the own run
    own
        setting of the own run, {"integrator": "whfast", "dt": 0.1, ...}; missing entries are taken
        from the source
    qpos : array, shape (nq,)
        configuration at which a model starts, in MuJoCo's coordinates
    qvel : array, shape (nv,)
        velocity at which a model starts
    ctrl : array, shape (nu,)
        constant controls of a model; None: the keyframe's, or zeros
    quick
        spend less time on other sources of the truth and on other integrators
    extras
        the ``reboundx.Extras`` of a simulation, as `galvi.from_rebound` takes them: REBOUND runs
        with these forces, galvi with the forces that it reads from them

    Raises
    ------
    ValueError
        Where the command refuses the source or an argument, and as `galvi.from_rebound` and
        `galvi.from_mujoco`.
    TypeError
        For a source of another type.
    ModuleNotFoundError
        Without the suite's packages.

    Notes
    -----
    The engine makes the own run with the user's simulation or model itself. After ten seconds
    progress is printed on stderr.

    Examples
    --------
    >>> import rebound
    >>> sim = rebound.Simulation()
    >>> sim.integrator, sim.dt = "whfast", 0.1
    >>> sim.add(m=1.0)
    >>> sim.add(m=1e-3, a=1.0, e=0.05)
    >>> verdict = galvi.judge(sim, duration=60.0, quick=True)  # in a process of its own: seconds
    >>> verdict.own["integrator"]
    'REBOUND WHFast, coordinates jacobi, dt = 0.1'
    """
    ignore = (ignore,) if isinstance(ignore, str) else tuple(ignore)
    kind = _kind_of(source)
    request = JudgeRequest(
        None if duration is None else float(duration),
        None if error is None else float(error),
        dict(own or {}),
        snapshot,
        ignore,
        key,
        qpos,
        qvel,
        ctrl,
        quick,
        kind == PROBLEM,
    )
    if kind == SIMULATION and not _is_file(source):
        _refuse_model_arguments(source, request)
    elif extras is not None:
        raise ValueError(
            f"extras belong to a rebound.Simulation; received them with {shown(source)}. Load the "
            f"simulation first."
        )
    with tempfile.TemporaryDirectory() as folder:
        file, pickled = _file_and_pickle(source, kind, request, extras, Path(folder) / "model")
        if extras is not None:
            request = replace(request, extras=str(file.with_suffix(".rebx")))
            extras.save(request.extras)
        request_path = Path(folder) / "request.json"
        request_path.write_text(request.to_json(), encoding="utf-8")
        arguments = [str(file), "--request", str(request_path), "--out", folder]
        refusal = suite_process.run_command("judge", arguments, pickled)
        report_path = Path(folder) / "judge.json"
        if not report_path.is_file():
            raise refusal
        page = (Path(folder) / "judge.html").read_text(encoding="utf-8")
        return Judged(json.loads(report_path.read_text(encoding="utf-8")), page)


def _kind_of(source: Any) -> str:
    """PROBLEM, MODEL or SIMULATION; TypeError for a source of another type."""
    if isinstance(source, Problem):
        return PROBLEM
    package = type(source).__module__.partition(".")[0]
    if package in ("mujoco", "rebound"):
        return MODEL if package == "mujoco" else SIMULATION
    if not isinstance(source, str | os.PathLike):
        raise TypeError(
            f"source must be a rebound.Simulation, a mujoco.MjModel, a galvi.Problem, the text of "
            f"a model or the path of a file; received {shown(source)}."
        )
    is_model = not _is_file(source) or Path(source).suffix in MODEL_SUFFIXES
    return MODEL if is_model else SIMULATION


def _is_file(source: Any) -> bool:
    """Whether a source is a path: a path object, or a string without "<", not a model's text."""
    return isinstance(source, os.PathLike) or (isinstance(source, str) and "<" not in source)


def _refuse_model_arguments(source: Any, request: JudgeRequest) -> None:
    """ValueError where a request for a simulation has arguments that only models of MuJoCo take."""
    wrong = [x for x in ("key", "qpos", "qvel", "ctrl") if getattr(request, x) is not None]
    wrong += ["ignore"] if request.ignore else []
    if wrong:
        raise ValueError(
            f"judge takes {' and '.join(wrong)} with models of MuJoCo's alone; received "
            f"{shown(source)}. Leave {'it' if len(wrong) == 1 else 'them'} out."
        )


def _file_and_pickle(
    source: Any, kind: str, request: JudgeRequest, extras: Any, file: Path
) -> tuple[Path, bytes]:
    """The path of the source's file, and the pickle of a problem, else b"".

    A source that is no file is written to ``file``, a model to that name with .mjb. Errors of the
    readers pass through.
    """
    if kind == PROBLEM:
        pickled = _pickled(source)
        file.write_bytes(pickled)
        return file, pickled
    if kind == MODEL:
        start = request.ignore, request.key, request.qpos, request.qvel, request.ctrl
        mujoco_reader.read(source, *start)
        if not _is_file(source):
            import mujoco

            file = file.with_suffix(".mjb")
            mujoco.mj_saveModel(mujoco_reader.model_of(source), str(file), None)
    else:
        rebound_reader.from_rebound(source, request.snapshot, extras=extras)
        if not _is_file(source):
            copied(source).save_to_file(str(file))
    return (Path(source) if _is_file(source) else file), b""


def _pickled(problem: Problem) -> bytes:
    """A problem for another process; ValueError for one that cannot be judged there."""
    system = problem.system
    if isinstance(system, Multibody) and system.given_force[0] is not None:
        raise ValueError(
            "a problem of a tree is judged by the model of MuJoCo that is made of it, which has no "
            "forces but gravity, springs and damping of joints; received a problem with other "
            "forces. Give judge the model that it was read from."
        )
    try:
        return pickle.dumps(problem)
    except (pickle.PicklingError, AttributeError, TypeError) as error:
        raise ValueError(
            f"a problem is judged in another process, for which its functions must be pickled: "
            f"{error}. Define them by name in a module."
        ) from None
