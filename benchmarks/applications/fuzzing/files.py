"""Files with bits changed or cut short: saved runs, models of MuJoCo's, archives of REBOUND's."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

from hypothesis import strategies as st

import galvi
from benchmarks.applications.fuzzing.arguments import COUNTS, METHODS, RUNS, SMALL, STEPS, a_run
from benchmarks.applications.fuzzing.judgement import Call

SHOWN = 600  # characters of a model


def bits_changed(data: Any, whole: bytes) -> bytes:
    """A file cut short, or with some bytes changed, taken out or put in."""
    changed = bytearray(whole)
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, max(len(changed) - 1, 0)))
        kind = data.draw(st.sampled_from(["bit", "byte", "cut", "out", "in"]))
        if kind == "cut":
            del changed[at:]
        elif kind == "out":
            del changed[at : at + data.draw(st.integers(1, 64))]
        elif kind == "in":
            changed[at:at] = data.draw(st.binary(max_size=16))
        elif changed:
            changed[at] = (
                changed[at] ^ (1 << data.draw(st.integers(0, 7)))
                if kind == "bit"
                else data.draw(st.integers(0, 255))
            )
    return bytes(changed)


def saved_run(data: Any) -> Call:
    """A saved run, damaged: refused, or the run that was saved."""
    run = data.draw(RUNS)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "run.npz"
        galvi.save(run, path)
        whole = path.read_bytes()
    damaged = bits_changed(data, whole)

    def call() -> Any:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "run.npz"
            path.write_bytes(damaged)
            loaded = galvi.load(path)
        for name in ("t", "q", "p"):
            if getattr(loaded, name).tobytes() != getattr(run, name).tobytes():
                raise AssertionError(f"{name} is not what was saved")
        return loaded

    return call, f"load of {run.problem.name}, {len(whole)} bytes changed to {len(damaged)}"


MODEL = b"""<mujoco><compiler angle="radian"/><option gravity="0 0 -9.81"/><worldbody>
<body name="a" pos="0 0 1"><joint name="j" type="hinge" axis="0 1 0" damping="0.1"/>
<geom type="capsule" size="0.05 0.3" mass="1.5"/><body name="b" pos="0 0 -0.6">
<joint type="ball" armature="0.01"/><geom type="box" size="0.1 0.2 0.05" mass="0.7"/></body></body>
</worldbody><keyframe><key qpos="0.3 1 0 0 0"/></keyframe></mujoco>"""


def mujoco_model(data: Any) -> Call:
    """A model of MuJoCo's, damaged, from a file."""
    damaged = bits_changed(data, MODEL)

    def call() -> Any:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "model.xml"
            path.write_bytes(damaged)
            return galvi.from_mujoco(path)

    return call, damaged.decode("utf-8", "replace")[:SHOWN]


def rebound_file(data: Any) -> Call:
    """A simulation archive of REBOUND's, damaged."""
    planets = st.just(SMALL["outer_solar_system"])
    run = data.draw(st.builds(a_run, planets, METHODS, STEPS, COUNTS))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "sim.bin"
        run.to_rebound().save_to_file(str(path))
        damaged = bits_changed(data, path.read_bytes())

    def call() -> Any:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "sim.bin"
            path.write_bytes(damaged)
            return galvi.from_rebound(path)

    return call, f"an archive of {len(damaged)} bytes"
