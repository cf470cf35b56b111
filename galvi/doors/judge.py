"""Judge a model from Python: the command ``galvi judge`` in a process of its own."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from galvi.doors.from_mujoco import from_mujoco
from galvi.doors.rebound import from_rebound
from galvi.input_checks import shown

if TYPE_CHECKING:
    import pandas

MODELS = (".xml", ".mjb", ".urdf")  # MuJoCo's


@dataclass(frozen=True)
class Judged:
    """How wrong a model's own run is, and what reaches an error cheapest.

    found  what ``judge.json`` holds; `summary` says it in sentences
    page   the page as HTML, which notebooks show
    """

    found: Mapping[str, Any]
    page: str

    @property
    def summary(self) -> list[str]:
        """The findings in sentences."""
        return list(self.found["summary"])

    @property
    def own(self) -> Mapping[str, Any]:
        """Of the user's own setting: integrator, error, seconds, energy_error, momentum_error."""
        own: Mapping[str, Any] = self.found["own"]
        return own

    @property
    def truth_agreement(self) -> float:
        """The largest distance between two sources of the truth; NaN with one only."""
        agreement = self.found["truth_agreement"]
        return float("nan") if agreement is None else float(agreement)

    @property
    def recommended(self) -> Mapping[str, Any] | None:
        """The cheapest integrator and setting that reach the error; None where none does."""
        best: Mapping[str, Any] | None = self.found["recommended"]
        return best

    @property
    def table(self) -> pandas.DataFrame:
        """Everything that was tried: what reaches the error first, by its time."""
        import pandas

        return pandas.DataFrame(self.found["table"])

    def __repr__(self) -> str:
        return " ".join(self.summary)

    def _repr_html_(self) -> str:
        return self.page


def judge(
    source: Any,
    duration: float | None = None,
    error: float | None = None,
    own: Mapping[str, Any] | None = None,
    snapshot: int = -1,
    ignore: Sequence[str] = (),
    key: int | None = None,
) -> Judged:
    """Judge a simulation of REBOUND or a model of MuJoCo, or a file of one.

    source       as of `galvi.from_rebound`, with ``snapshot``, or of `galvi.from_mujoco`, with
                 ``ignore`` and ``key``: a model itself, or a file .xml, .mjb or .urdf
    duration     in its time; None: 100 revolutions of the fastest body, or 10 for a model
    error        largest error of a body or of a joint at any time; None: that of the own run
    own          {"integrator": "whfast", "dt": 0.1, ...}; what is not given is as in the source

    Raises what these raise, ValueError for what the command refuses, and ModuleNotFoundError
    without the suite's packages.
    """
    ignore = (ignore,) if isinstance(ignore, str) else tuple(ignore)
    is_file = isinstance(source, str | os.PathLike)
    of_mujoco = type(source).__module__.startswith("mujoco")
    if not (is_file or of_mujoco or type(source).__module__.startswith("rebound")):
        raise TypeError(
            f"source must be a rebound.Simulation, a mujoco.MjModel or the path of a file of one; "
            f"received {shown(source)}."
        )
    if of_mujoco or (is_file and Path(source).suffix in MODELS):
        from_mujoco(source, ignore, key)  # what cannot be judged is refused here
    else:
        from_rebound(source, snapshot)
    with tempfile.TemporaryDirectory() as folder:
        if is_file:
            file = Path(source)
        elif of_mujoco:
            import mujoco

            file = Path(folder) / "model.mjb"
            mujoco.mj_saveModel(source, str(file), None)
        else:
            file = Path(folder) / "model.bin"
            source.save_to_file(str(file))
        arguments = [str(file), "--snapshot", str(snapshot), "--out", folder]
        arguments += ["--ignore", ",".join(ignore)] if ignore else []
        for name, value in (("--duration", duration), ("--error", error)):
            arguments += [] if value is None else [name, repr(float(value))]
        arguments += [] if key is None else ["--key", str(int(key))]
        if own:
            arguments += ["--own", ",".join(f"{key}={value}" for key, value in own.items())]
        done = subprocess.run(
            [sys.executable, "-m", "galvi", "judge", *arguments], capture_output=True, text=True,
        )  # fmt: skip
        result = Path(folder) / "judge.json"
        if not result.is_file():
            kind = ModuleNotFoundError if "not installed" in done.stderr else ValueError
            raise kind(done.stderr.strip() or f"the command ended with {done.returncode}.")
        page = (Path(folder) / "judge.html").read_text(encoding="utf-8")
        return Judged(json.loads(result.read_text()), page)
