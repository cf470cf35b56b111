"""A run as a data set of xarray."""

from __future__ import annotations

from typing import Any

from galvi.diagnostics.invariants import energy
from galvi.systems.multibody import Multibody
from galvi.systems.nbody import NBody
from galvi.trajectory import Trajectory

AXES = ("x", "y", "z")


def to_xarray(run: Trajectory) -> Any:
    """An `xarray.Dataset` of the saved states: q, p and v, and the energy.

    Dimensions: t; body and axis of point masses, by their names where they have some; row and
    column of matrices; coordinate of vectors; of trees entry of q, and velocity, each by its joint.
    Attributes: problem, units, method, step, success, status, and each count.

    Raises ModuleNotFoundError without xarray.
    """
    try:
        import xarray
    except ModuleNotFoundError as error:
        raise ModuleNotFoundError(
            "xarray is not installed. Install it: pip install xarray.", name="xarray"
        ) from error
    places, rates = _dimensions(run)
    coordinates: dict[str, Any] = {"t": run.t}
    if isinstance(run.problem.system, NBody):
        axes = run.problem.q0.shape[1]
        coordinates |= {"body": run.problem.body_names(), "axis": list(AXES[:axes])}
    elif isinstance(run.problem.system, Multibody):
        system = run.problem.system
        joints = [(link.name or str(k), one) for k, link in enumerate(system.links)
                  for one in link.joints]  # fmt: skip
        coordinates["velocity"] = [
            f"{one.type} of {name}" + (f", {k}" if one.dimension > 1 else "")
            for name, one in joints for k in range(one.dimension)
        ]  # fmt: skip
    steps = {} if run.step is None else {"step": run.step}
    return xarray.Dataset(
        {"q": (("t", *places), run.q), "p": (("t", *rates), run.p), "v": (("t", *rates), run.v),
         "energy": ("t", energy(run))},
        coordinates,
        {"problem": run.problem.name, "units": run.problem.units, "method": str(run.method),
         "success": int(run.success), "status": run.status, **steps, **run.counts},
    )  # fmt: skip


def _dimensions(run: Trajectory) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Names of the dimensions of a configuration, and of its velocity."""
    shape, moving = run.problem.q0.shape, run.problem.v0.shape
    if isinstance(run.problem.system, NBody):
        return ("body", "axis"), ("body", "axis")
    if len(shape) == 2:
        return ("row", "column"), ("velocity",)
    if shape == moving and not isinstance(run.problem.system, Multibody):
        return ("coordinate",), ("coordinate",)
    return ("entry",), ("velocity",)
