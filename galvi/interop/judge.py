"""Judge a model from Python: the command ``galvi judge`` in a process of its own."""

from __future__ import annotations

import json
import os
import pickle
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from galvi.input_checks import shown
from galvi.interop import from_mujoco as mujoco_reader
from galvi.interop import rebound as rebound_reader
from galvi.problem import Problem

if TYPE_CHECKING:
    import pandas

MODELS = (".xml", ".mjb", ".urdf", ".mjz")  # MuJoCo's
SILENT, PROGRESS = 10.0, "judge: "  # seconds before lines of progress are shown; how they begin


@dataclass(frozen=True)
class Judged:
    """How wrong a model's own run is, and what reaches an error cheapest.

    data  what ``judge.json`` holds; `summary` says it in sentences
    page  the page as HTML, which notebooks show
    """

    data: Mapping[str, Any]
    page: str

    @property
    def found(self) -> Mapping[str, Any]:
        """Another name of ``data``."""
        return self.data

    @property
    def summary(self) -> list[str]:
        """The findings in sentences."""
        return list(self.data["summary"])

    @property
    def notes(self) -> list[str]:
        """What of the model was left out, and how it was read and run, in sentences."""
        return list(self.data["notes"])

    @property
    def duration(self) -> float:
        """In the model's time, negative where the run goes backwards."""
        return float(self.data["duration"])

    @property
    def passed(self) -> bool:
        """Whether the own run reaches the error."""
        return bool(self.data["passed"])

    @property
    def own(self) -> Mapping[str, Any]:
        """Of the user's own setting: integrator, error, energy and momentum (their largest relative
        changes), seconds, status; None where a number is not known."""
        return self.data["own"]

    @property
    def truth_agreement(self) -> float:
        """The largest distance between two sources of the truth; NaN with one only."""
        agreement = self.data["truth_agreement"]
        return float("nan") if agreement is None else float(agreement)

    @property
    def recommended(self) -> Mapping[str, Any] | None:
        """The cheapest integrator and setting that reach the error, with error, energy and seconds;
        None where none does."""
        return self.data["recommended"]

    @property
    def table(self) -> pandas.DataFrame:
        """Everything that was tried: what reaches the error first, by its time."""
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
    quick: bool = False,
) -> Judged:
    """Judge a simulation of REBOUND, a model of MuJoCo, a file of one, or a problem.

    source       as of `galvi.from_rebound`, with ``snapshot``, or of `galvi.from_mujoco`, with
                 ``ignore`` and ``key``; or a `galvi.Problem` of point masses or of a tree
    duration     in its time, backwards where it or the own dt is negative; None: 100 revolutions of
                 the fastest body, or 10 for a model
    error        largest error of a body or of a joint at any time; None: that of the own run
    own          {"integrator": "whfast", "dt": 0.1, ...}; what is not given is as in the source
    qpos, qvel   (nq,) and (nv,): a start of a model in MuJoCo's coordinates
    quick        with shorter looks at other sources of the truth and other integrators

    The own run is that of the engine on the user's own simulation or model. Runs of more than ten
    seconds say on stderr what is being done. Raises what these raise, ValueError for what the
    command refuses, and ModuleNotFoundError without the suite's packages.
    """
    ignore = (ignore,) if isinstance(ignore, str) else tuple(ignore)
    kind = type(source).__module__.partition(".")[0]
    is_file = isinstance(source, os.PathLike) or (isinstance(source, str) and "<" not in source)
    if not (is_file or isinstance(source, str | Problem) or kind in ("mujoco", "rebound")):
        raise TypeError(
            f"source must be a rebound.Simulation, a mujoco.MjModel, a galvi.Problem, the text of "
            f"a model or the path of a file; received {shown(source)}."
        )
    arguments = ["--snapshot", str(snapshot)]
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "model"
        if isinstance(source, Problem):
            file.write_bytes(pickle.dumps(source))
            arguments += ["--pickled"]
        elif kind == "mujoco" or (isinstance(source, str) and not is_file) or (
            is_file and Path(source).suffix in MODELS
        ):  # fmt: skip
            mujoco_reader.read(source, ignore, key, qpos, qvel)  # what it refuses is said here
            if is_file:
                file = Path(source)
            else:
                import mujoco

                file = file.with_suffix(".mjb")
                mujoco.mj_saveModel(mujoco_reader.model_of(source), str(file), None)
            arguments += ["--ignore", ",".join(ignore)] if ignore else []
            arguments += [] if key is None else ["--key", str(key)]
            for name, given in (("--qpos", qpos), ("--qvel", qvel)):
                arguments += [] if given is None else [name, _numbers(given)]
        else:
            _, simulation = rebound_reader.read(source, snapshot)
            if is_file:
                file = Path(source)
            else:
                simulation.save_to_file(str(file))
        for name, value in (("--duration", duration), ("--error", error)):
            arguments += [] if value is None else [name, repr(float(value))]
        if own:
            arguments += ["--own", ",".join(f"{key}={value}" for key, value in own.items())]
        arguments += ["--quick"] if quick else []
        refusal = _run([str(file), *arguments, "--out", folder])
        result = Path(folder) / "judge.json"
        if not result.is_file():
            raise (ModuleNotFoundError if "not installed" in refusal else ValueError)(refusal)
        page = (Path(folder) / "judge.html").read_text(encoding="utf-8")
        return Judged(json.loads(result.read_text()), page)


def _run(arguments: Sequence[str]) -> str:
    """Run the command; returns what it said on stderr beside its progress."""
    process = subprocess.Popen(
        [sys.executable, "-m", "galvi", "judge", *arguments],
        stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    begun, said = time.monotonic(), list[str]()
    with process:
        assert process.stderr is not None
        for line in process.stderr:
            if not line.startswith(PROGRESS):
                said.append(line.rstrip())
            elif time.monotonic() - begun > SILENT:
                print(line, end="", file=sys.stderr, flush=True)
    return "\n".join(said) or f"the command ended with {process.returncode}."


def _numbers(values: Any) -> str:
    return ",".join(repr(float(value)) for value in values)
