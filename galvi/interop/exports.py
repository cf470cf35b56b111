"""A run as a plot, as a solution of SciPy, and as an xarray dataset."""

from __future__ import annotations

from typing import Any

import numpy as np

from galvi.arrays import Array
from galvi.diagnostics.invariants import energy
from galvi.run.energies import conserves_energy
from galvi.systems.canonical import Canonical
from galvi.systems.multibody import Multibody
from galvi.systems.nbody import NBody
from galvi.trajectory import Trajectory

MAX_LABELS = 10  # largest number of bodies or coordinates with a label
POINTS_PER_STEP = 16  # of a plotted curve
MAX_POINTS = 20_000  # largest number of intervals of a plotted curve
AXIS_NAMES = ("x", "y", "z")


def plot(run: Trajectory) -> Any:
    """A matplotlib figure of a run.

    The left panel shows orbits in the plane of x and y, the path of one body in the plane, the axes
    of a rotating body on the sphere, the position of a rigid body in space against time, or each
    coordinate against time; along the curves where the run has them. The right panel shows the
    change of the energy, or the momenta where the energy is not conserved.

    Raises
    ------
    ModuleNotFoundError
        Without matplotlib.
    """
    try:
        from matplotlib import pyplot
    except ModuleNotFoundError as error:
        raise ModuleNotFoundError(
            "matplotlib is not installed. Install it: pip install matplotlib.", name="matplotlib"
        ) from error
    shape = run.problem.q0.shape
    on_sphere = shape == (3, 3) and not isinstance(run.problem.system, NBody)
    figure = pyplot.figure(figsize=(10.0, 4.2), layout="constrained")
    motion = figure.add_subplot(1, 2, 1, **({"projection": "3d"} if on_sphere else {}))
    t, q = _motion(run)
    if on_sphere:
        _sphere(motion, q)
    elif isinstance(run.problem.system, NBody):
        _orbits(motion, run, q)
    elif shape == (2,) and isinstance(run.problem.system, Canonical):
        motion.plot(q[:, 0], q[:, 1])
        motion.set(xlabel="$q_0$", ylabel="$q_1$", aspect="equal")
    else:
        coordinates = q[:, :3, 3] if shape == (4, 4) else q.reshape(len(t), -1)
        names = "xyz" if shape == (4, 4) else [f"$q_{{{k}}}$" for k in range(coordinates.shape[1])]
        _against_time(motion, t, coordinates, names)
    _invariant(figure.add_subplot(1, 2, 2), run)
    figure.suptitle(run.problem.name or type(run.problem.system).__name__)
    return figure


def _motion(run: Trajectory) -> tuple[Array, Array]:
    """Times and configurations: of points on the curves if the run has them, else of the saved
    states."""
    if run.curves is None or len(run.t) < 2:
        return run.t, run.q
    points = min(POINTS_PER_STEP * (len(run.t) - 1), MAX_POINTS) + 1
    times = np.linspace(run.t[0], run.t[-1], points)
    return times, run(times)


def _orbits(axes: Any, run: Trajectory, q: Array) -> None:
    for k, name in enumerate(run.problem.body_names()):
        label = str(name) if k < MAX_LABELS else None
        (line,) = axes.plot(q[:, k, 0], q[:, k, 1], linewidth=0.8)
        axes.plot(*run.q[-1, k, :2], "o", color=line.get_color(), markersize=4, label=label)
    axes.set(xlabel="$x$", ylabel="$y$")
    axes.set_aspect("equal", adjustable="datalim")
    axes.legend(fontsize=8)


def _sphere(axes: Any, rotations: Array) -> None:
    for k in range(3):
        axes.plot(*rotations[:, :, k].T, linewidth=0.8, label=f"$e_{k + 1}$")
    turn, height = np.linspace(0.0, 2 * np.pi, 25), np.linspace(0.0, np.pi, 13)
    axes.plot_wireframe(
        np.outer(np.cos(turn), np.sin(height)),
        np.outer(np.sin(turn), np.sin(height)),
        np.outer(np.ones(25), np.cos(height)),
        color="0.8",
        linewidth=0.3,
    )
    axes.set(xlabel="$x$", ylabel="$y$", zlabel="$z$")
    axes.set_box_aspect((1, 1, 1))
    axes.legend(fontsize=8, title="body axes", loc="upper left", bbox_to_anchor=(-0.1, 1.0))


def _against_time(axes: Any, t: Array, values: Array, names: Any) -> None:
    for k, name in enumerate(names):
        axes.plot(t, values[:, k], linewidth=0.9, label=name if k < MAX_LABELS else None)
    axes.set(xlabel="$t$")
    axes.legend(fontsize=8)


def _invariant(axes: Any, run: Trajectory) -> None:
    if not conserves_energy(run.problem.system):
        p = run.p.reshape(len(run.t), -1)
        _against_time(axes, run.t, p, [f"$p_{{{k}}}$" for k in range(p.shape[1])])
        return
    energies = energy(run)
    scale = abs(energies[0]) or 1.0
    axes.plot(run.t, (energies - energies[0]) / scale, ".-", markersize=2, linewidth=0.6)
    relative = "relative change" if energies[0] else "change"
    axes.set(xlabel="$t$", ylabel=f"{relative} of the energy")


def to_scipy(run: Trajectory) -> Any:
    """A `scipy.optimize.OptimizeResult` with the fields of `scipy.integrate.solve_ivp`'s result.

    Its fields are ``t`` (saved,); ``y`` (n, saved), the entries of q, then those of v; ``sol``, a
    function t -> y on the curves, (n,) or (n, k), None for a run without curves; ``status``, 0 for
    a success, else -1, with ``message`` and ``success``; ``nfev``, ``njev`` and ``nlu``, the
    numbers of evaluations of the force, of evaluations of its derivative, and of linear systems
    solved.
    """
    from scipy.optimize import OptimizeResult  # would lengthen galvi's import by a fifth

    def rows(q: Array, v: Array) -> Array:
        return np.hstack([x.reshape(len(q), -1) for x in (q, v)]).T

    def sol(t: Any) -> Array:
        times = np.atleast_1d(t)
        y = rows(run(times), run.velocity(times))
        return y if np.ndim(t) else y[:, 0]

    counts = run.counts
    return OptimizeResult(
        t=run.t,
        y=rows(run.q, run.v),
        sol=None if run.curves is None and run.again is None else sol,
        t_events=None,
        y_events=None,
        nfev=counts.get("force_evaluations", 0),
        njev=counts.get("hessian_evaluations", 0),
        nlu=counts.get("linear_solves", 0),
        status=0 if run.success else -1,
        message=run.status,
        success=run.success,
    )


def to_xarray(run: Trajectory) -> Any:
    """An `xarray.Dataset` of the saved states: q, p and v, and the energy.

    Dimensions: t; for point masses body, by name, and axis; for matrices row and column; for
    vectors coordinate; for trees entry, of q, and velocity, by the joint's type and link; velocity
    too where q has another shape than v. Attributes: problem, units, method, step, success, status,
    and each count.

    Raises
    ------
    ModuleNotFoundError
        Without xarray.
    """
    try:
        import xarray
    except ModuleNotFoundError as error:
        raise ModuleNotFoundError(
            "xarray is not installed. Install it: pip install xarray.", name="xarray"
        ) from error
    system, coordinates = run.problem.system, dict[str, Any](t=run.t)
    same_shape = run.q.shape == run.p.shape and not isinstance(system, Multibody)
    dimensions = (
        ("coordinate",) if same_shape else ("entry",) if run.q.ndim == 2 else ("row", "column")
    )
    if isinstance(system, NBody):
        dimensions = ("body", "axis")
        coordinates |= {
            "body": run.problem.body_names(),
            "axis": list(AXIS_NAMES[: run.q.shape[2]]),
        }
    elif isinstance(system, Multibody):
        joints = [
            (link.name or str(k), joint)
            for k, link in enumerate(system.links)
            for joint in link.joints
        ]
        coordinates["velocity"] = [
            f"{joint.type} of {name}" + (f", {k}" if joint.dimension > 1 else "")
            for name, joint in joints
            for k in range(joint.dimension)
        ]
    velocity_dimensions = dimensions if same_shape else ("velocity",)
    steps = {} if run.step is None else {"step": run.step}
    return xarray.Dataset(
        {"q": (("t", *dimensions), run.q), "p": (("t", *velocity_dimensions), run.p),
         "v": (("t", *velocity_dimensions), run.v),
         "energy": ("t", energy(run))},
        coordinates,
        {"problem": run.problem.name, "units": run.problem.units, "method": str(run.method),
         "success": int(run.success), "status": run.status, **steps, **run.counts},
    )  # fmt: skip
