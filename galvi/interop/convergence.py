"""Order and cost tables from Python: the command ``galvi convergence`` in a process of its own."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from galvi import input_checks
from galvi.input_checks import shown
from galvi.interop import suite_process
from galvi.method import Galerkin
from galvi.problem import Problem

if TYPE_CHECKING:
    import pandas

TRUTHS = "None, the name of a reference, a function of t, or the configuration at the end"


@dataclass(frozen=True)
class ConvergenceRequest:
    """The checked arguments of `convergence`.

    Attributes
    ----------
    methods
        pairs of name and method, as `convergence` takes them; "" stands for the name of the code or
        class
    counts
        numbers of equal steps; () where sizes are set or steps are chosen automatically
    sizes
        sizes of steps in the unit of time, or of a method's clock
    with_all
        whether galvi and every other installed code that takes the problem are added
    """

    problem: Problem
    methods: tuple[tuple[str, Any], ...]
    duration: float
    counts: tuple[int, ...] = ()
    sizes: tuple[float, ...] = ()
    truth: Any = None
    quick: bool = False
    with_all: bool = False


def convergence(
    problem: Problem,
    methods: Mapping[str, Any] | None,
    steps: Sequence[int] | Sequence[float] | None,
    duration: float,
    truth: Any = None,
    *,
    quick: bool = False,
) -> pandas.DataFrame:
    """Errors, orders, invariants and cost of methods on a problem, at decreasing steps.

    Parameters
    ----------
    methods
        name -> a `galvi.Galerkin`; the name of another code, such as "rebound.whfast",
        "mujoco.rk4", "scipy.dop853", "heyoka" or "textbook.rk4"; or an integrator of yours: a class
        or an instance, or "module:Class", which then runs in a process of its own. None: galvi and
        every other installed code that takes the problem
    steps
        numbers of equal steps, if all are of type int, else their sizes, each of which divides the
        duration a whole number of times; with a clock, sizes are in its unit, and numbers
        approximate. Codes that choose their own steps run at four tolerances instead. None: chosen
        automatically for each method
    duration
        from the problem's t0, positive, in its unit of time
    truth
        None: a closed form or an exact engine, else the two finest runs of galvi; or the name of a
        code, a function of the time that returns the configuration, or the configuration at the
        end, of q0's shape
    quick
        shorter timings

    Returns
    -------
    pandas.DataFrame
        A tidy table, a row for each method and step, coarse to fine: ``method, h, error, order,
        fitted, fitted_se, energy, momentum, symmetry, symplecticity, seconds, evaluations, outcome,
        setting, steps, fit, theory, note``. ``error`` is that of the state at the end: the largest
        difference of a coordinate from the truth (for point masses the largest distance of a body),
        or of a momentum in units that make both equally large, whichever is larger. ``order`` is
        computed from a row and the row before it, ``fitted`` from the rows where ``fit`` is true;
        ``theory`` is the known or declared order; ``note`` says why a row is left out of the fit,
        such as round-off. ``energy`` and ``momentum`` are the largest relative changes of what the
        motion conserves, ``symmetry`` the distance from the start after a run forward and back,
        ``symplecticity`` the defect of one step, ``evaluations`` those of the force. ``seconds``
        are those of a run; where the motion conserves its energy they are measured on longer runs.
        Numbers that do not apply are NaN. ``attrs`` has ``truth``, ``truth_error``, ``rule`` (of
        the fit), ``remarks`` (orders that differ from theory) and ``faults`` of the methods.

    Raises
    ------
    ValueError
        For an invalid value, and where the command refuses the problem or a method.
    TypeError
        For an argument of a wrong type.
    ModuleNotFoundError
        Without the suite's packages.

    Notes
    -----
    The command runs in another process, which needs the suite's packages.

    Examples
    --------
    >>> kepler = galvi.problems.kepler(eccentricity=0.3)
    >>> gauss = galvi.Galerkin(galvi.Polynomials(2), galvi.gauss(2))
    >>> methods = {"Gauss 2": gauss, "Verlet": "textbook.stormer_verlet"}  # in a process of its own
    >>> table = galvi.convergence(kepler, methods, [50, 100, 200, 400], duration=5.0, quick=True)
    >>> table.groupby("method")["fitted"].first().round(1).to_dict()
    {'Gauss 2': 4.0, 'Verlet': 2.0}
    >>> print(table.attrs["truth"])
    Kepler, closed form, to rounding
    """
    request = _checked(problem, methods, steps, duration, truth, quick)
    try:
        import cloudpickle
        import pandas
    except ModuleNotFoundError as error:
        raise ModuleNotFoundError(
            f"convergence needs the packages of the suite; {error.name} is not installed. Install "
            "them: pip install 'galvi[suite]'."
        ) from None
    try:
        pickled = cloudpickle.dumps(request)
    except Exception as error:  # a user's object may raise anything
        raise ValueError(
            f"the problem, methods and truth go to another process; they cannot be pickled: "
            f"{error}."
        ) from None
    with tempfile.TemporaryDirectory() as folder:
        request_path, table_path = Path(folder) / "request", Path(folder) / "convergence.json"
        request_path.write_bytes(pickled)
        refusal = suite_process.run_command(
            "convergence", ["--request", str(request_path), "--out", folder], pickled
        )
        if not table_path.is_file():
            raise refusal
        attributes = json.loads(table_path.read_text(encoding="utf-8"))
    table = pandas.DataFrame(attributes.pop("table"))
    table.attrs.update(attributes)
    return table


def _checked(
    problem: Any, methods: Any, steps: Any, duration: Any, truth: Any, quick: Any
) -> ConvergenceRequest:
    """The request with these arguments; TypeError or ValueError as `convergence`."""
    if not isinstance(problem, Problem):
        raise TypeError(f"problem must be a galvi.Problem; received {shown(problem)}.")
    if methods is not None and not (isinstance(methods, Mapping) and methods):
        raise TypeError(
            f"methods must be a mapping of names to methods, at least one, or None for all; "
            f"received {shown(methods)}."
        )
    for name, method in (methods or {}).items():
        is_method = isinstance(method, Galerkin | str) or hasattr(method, "run")
        if not isinstance(name, str) or not name.strip() or not is_method:
            raise TypeError(
                f"methods must map a name to a galvi.Galerkin, the name of another code, or an "
                f"integrator with name, supports and run; received {name!r}: {shown(method)}."
            )
    duration = input_checks.positive("duration", duration)
    counts, sizes = counts_and_sizes(steps)
    if not (truth is None or isinstance(truth, str) or callable(truth)):
        truth = input_checks.array("truth", truth, problem.q0.shape, f"It is {TRUTHS}.")
    return ConvergenceRequest(
        problem,
        tuple((methods or {}).items()),
        duration,
        counts,
        sizes,
        truth,
        input_checks.flag("quick", quick),
        with_all=methods is None,
    )


def counts_and_sizes(steps: Any) -> tuple[tuple[int, ...], tuple[float, ...]]:
    """Numbers of equal steps, increasing, and sizes of steps, decreasing; one of the two is (), for
    None both.

    Raises
    ------
    TypeError
        For steps that are no sequence.
    ValueError
        For an empty sequence and for a number or size that is not positive.
    """
    if steps is None:
        return (), ()
    if isinstance(steps, str) or not input_checks.has_items(steps):
        raise TypeError(
            f"steps must be a sequence of numbers of steps, or of their sizes; received "
            f"{shown(steps)}."
        )
    values = list(steps)
    if not values:
        raise ValueError("steps must hold at least one number of steps or size; received none.")
    if all(isinstance(value, int | np.integer) and not isinstance(value, bool) for value in values):
        counts = sorted({input_checks.whole("a number of steps", int(count)) for count in values})
        return tuple(counts), ()
    sizes = {input_checks.positive("a step", size) for size in values}
    return (), tuple(sorted(sizes, reverse=True))
