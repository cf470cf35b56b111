"""Truths, integrators, errors and encounters for a judgement of point masses."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd

import galvi
from benchmarks.applications.judging.candidate import Candidate, Model, Source, UserSetting
from benchmarks.applications.judging.truth import time_text
from benchmarks.work_precision.galvi_methods import gauss_collocation, in_clock
from benchmarks.work_precision.problem import galvi_label
from benchmarks.work_precision.problems.encounters import clock_label
from galvi import Problem, Trajectory
from galvi.arrays import Array
from galvi.interop.rebound import check_reading, simulation_of
from galvi.interop.rebound_forces import Forced, inexact
from references import Contender
from references.heyoka.taylor import HEYOKA
from references.rebound import bulirsch_stoer, ias15, leapfrog, saba, whfast, whfast512
from references.rebound.mercurius import MERCURIUS
from references.rebound.trace import TRACE
from references.rebound.users import defaults, of_user
from references.scipy.ivp import DOP853, TIGHT

DEFAULT_REVOLUTIONS = 100  # of the fastest body, where no duration is given
ENCOUNTER_HILL_RADII = 3.0  # mutual Hill radii within which a passage is an encounter
STATES_PER_REVOLUTION = (
    48  # states of the truth a revolution of the fastest body, to find encounters
)
MOST_STATES = 20_000
INTEGRATORS = {  # by their names in REBOUND
    "ias15": ias15.IAS15,
    "bs": bulirsch_stoer.BULIRSCH_STOER,
    "whfast": whfast.WHFAST,
    "whfast512": whfast512.WHFAST512,
    "saba": saba.SABA,
    "leapfrog": leapfrog.LEAPFROG,
    "eos": replace(
        leapfrog.LEAPFROG,
        name="REBOUND EOS",
        integrator="eos",
        options=("phi0", "phi1", "n", "safe_mode"),
    ),
    "janus": replace(
        leapfrog.LEAPFROG,
        name="REBOUND JANUS",
        integrator="janus",
        options=("order", "scale_pos", "scale_vel"),
    ),
    "mercurius": MERCURIUS,
    "trace": TRACE,
}
ADAPTIVE = ("ias15", "bs")
CENTRED = ("whfast", "whfast512", "saba", "mercurius", "trace")  # their first particle is the star
LIGHT_PAIR_FRACTION = (
    0.1  # of the heaviest mass: largest sum of two masses with a mutual Hill radius
)
PART, ENGINE, ANOTHER = "body", "rebound", ""
ENGINE_HINT = "install the extra peers (pip install heyoka) for heyoka as a second"
COARSEST = 6.0 + 1.0 / 3.0  # steps to a revolution of the fastest body; a whole number resonates
GALVI_COARSEST, IN_FRAME = {8: 3.3, 12: 1.7, 16: 1.3}, {8: 1.7, 16: 1.1}  # degree: the same
IN_CLOCK = {8: (1.0, 0.7, 0.5, 0.35, 0.2), 16: (1.6, 1.2, 0.9, 0.6)}  # degree: steps in tau


def model(problem: Problem) -> Model:
    """The model of a problem, with a simulation of REBOUND made from the problem."""
    return Model(problem, simulation_of(problem))


def shortest_period(problem: Problem) -> float:
    """The shortest period of two bodies that are bound to each other.

    Where none are bound, the shortest period of a circle with the distance of two bodies.
    """
    system = problem.system
    bound, circles = [], []
    for i in np.flatnonzero(system.masses):
        gm = system.G * np.delete(system.masses[i] + system.masses, i)
        gap, speed = (np.delete(x - x[i], i, axis=0) for x in (problem.q0, problem.v0))
        r = np.linalg.norm(gap, axis=1)
        inverse = 2.0 / r - np.sum(speed**2, axis=1) / gm  # of the semi-major axis
        for axes, periods in ((r, circles), (1.0 / inverse[inverse > 0.0], bound)):
            pair_gm = gm if periods is circles else gm[inverse > 0.0]
            periods += (2.0 * math.pi * np.sqrt(axes**3 / pair_gm)).tolist()
    return float(min(bound or circles))


def default_duration(problem: Problem) -> float:
    """``DEFAULT_REVOLUTIONS`` revolutions of the fastest body."""
    return DEFAULT_REVOLUTIONS * shortest_period(problem)


def span(duration: float, step: float) -> float:
    """The duration, negative where it or the user's step is negative."""
    return -abs(duration) if step < 0.0 or duration < 0.0 else duration


def own_contender(model: Model, name: str) -> Contender:
    """The integrator of this name on the user's own simulation, with its options."""
    contender = INTEGRATORS[name]
    return contender if model.native is None else of_user(contender, model.native, model.problem)


def label(contender: Contender, options: Mapping[str, Any]) -> str:
    """The integrator's name and those options that differ from REBOUND's defaults; the option
    `coordinates` is always named."""
    usual = defaults(contender.integrator)
    option_texts = [
        f"{name} {value}".lower()
        for name, value in options.items()
        if name == "coordinates" or usual.get(name) != value
    ]
    return ", ".join([contender.name, *option_texts])


def states(problem: Problem, duration: float) -> int:
    """The number of states of the truth that are needed to find encounters."""
    if not pairs_with_hill_radius(problem.system.masses):
        return 1
    return min(
        math.ceil(STATES_PER_REVOLUTION * abs(duration) / shortest_period(problem)), MOST_STATES
    )


def sources(model: Model, duration: float, user_setting: UserSetting) -> list[Source]:
    """Possible sources of the truth, the best first.

    IAS15 on the user's own simulation at two epsilons, the smaller one first where the user runs
    IAS15; other engines, unless the forces are not read to rounding; and galvi, which is no source
    of its own.
    """
    problem = model.problem
    radau: Any = ias15.IAS15
    if model.native is not None:
        radau = of_user(radau, model.native, problem, keep_settings=False)
    forces_are_exact = not _inexact(model)
    tight = {**ias15.DEFAULT, "epsilon": 1e-10}
    all_sources = [
        Source("REBOUND IAS15", "REBOUND", radau, dict(ias15.DEFAULT)),
        Source("REBOUND IAS15, epsilon 1e-10", "REBOUND", radau, tight),
        Source("SciPy DOP853, rtol 3e-14", "SciPy", DOP853, dict(TIGHT)),
        Source("heyoka", "heyoka", HEYOKA, {}),
        Source("galvi degree 16", "", gauss_collocation(16), {}, 0.125 * shortest_period(problem)),
    ]
    if getattr(user_setting.contender, "integrator", "") == "ias15":
        all_sources[:2] = all_sources[1::-1]
    return [
        source
        for source in all_sources
        if (forces_are_exact or source.engine in ("REBOUND", ""))
        and not source.contender.missing
        and source.contender.supports(problem)
    ]


def engine_hint(model: Model) -> str:
    """How to install a second engine; "" where forces are not read to rounding, as other engines
    would run them as read."""
    return "" if _inexact(model) else ENGINE_HINT


def _inexact(model: Model) -> str:
    return inexact(model.native, model.problem) if isinstance(model.native, Forced) else ""


def check(model: Model, truth: Trajectory) -> None:
    """Raise ValueError where REBOUND's accelerations at states of the truth are not the
    problem's."""
    if model.native is not None:
        for k in np.linspace(0, len(truth.t) - 1, 4).astype(int):
            check_reading(model.native, model.problem, truth.q[k], truth.v[k])


def notes(model: Model, user_setting: UserSetting, truth: Trajectory) -> list[str]:
    """Sentences on units that are not set, on forces that are not read to rounding, on the order of
    the particles, and on the distances at which the user's run ends."""
    problem, remarks = model.problem, []
    if not _named(problem, "length"):
        remarks.append(
            f"Lengths and times are in the units of the simulation, in which G = "
            f"{problem.system.G:g}: sim.units is not set."
        )
    if difference := _inexact(model):
        remarks.append(
            f"{difference}: runs of galvi are of the motion as read, and no other engine is a "
            f"source of the truth."
        )
    masses, labels = problem.system.masses, names(problem)
    star = int(np.argmax(masses))
    integrator = getattr(user_setting.contender, "integrator", "")
    comparison_order = "what it is compared with has it first"
    if star and integrator in CENTRED:
        remarks.append(
            f"The heaviest body, {labels[star]}, is particle {star}, but "
            f"{user_setting.contender.name} expects it first. Your run keeps your order; "
            f"{'all of REBOUND does' if isinstance(model.native, Forced) else comparison_order}."
        )
    for name, sizes, beyond in (
        ("exit_max_distance", np.linalg.norm(truth.q, axis=2).max(axis=1), np.greater),
        ("exit_min_distance", _nearest(truth.q), np.less),
    ):
        distance = problem.parameters.get(name, 0.0)
        if not distance:
            continue
        rows_beyond = np.flatnonzero(beyond(sizes, distance))
        ends = (
            f"ends there at about t = {time_text(truth, truth.t[rows_beyond[0]])}"
            if rows_beyond.size
            else ("never reaches it")
        )
        remarks.append(f"{name} = {distance:g} is ignored here: your own run {ends}.")
    return remarks


def _nearest(q: Array) -> Array:
    """The least distance of two bodies at each state, (saved,)."""
    pairs = [
        np.linalg.norm(q[:, i + 1 :] - q[:, i : i + 1], axis=2).min(axis=1)
        for i in range(q.shape[1] - 1)
    ]
    return np.min(pairs, axis=0)


def candidates(
    model: Model, duration: float, user_setting: UserSetting
) -> Iterator[list[Candidate]]:
    """Yield for each integrator its settings from coarse to fine, or the steps to begin with.

    REBOUND's run on a new simulation with the heaviest body first, or on the user's own where it
    has forces of REBOUNDx.
    """
    problem, forced = model.problem, isinstance(model.native, Forced)

    def on_simulation(contender: Any) -> Any:
        if forced:
            return of_user(contender, model.native, problem, keep_settings=False)
        return contender

    revolutions = abs(duration) / shortest_period(problem)
    frame = galvi.KeplerFrame()
    charts = [("", None, GALVI_COARSEST)]
    charts += [] if frame.refusal(problem) else [(", Kepler frame", frame, IN_FRAME)]
    for suffix, chart, degrees in charts:
        for degree, coarsest in degrees.items():
            steps = round(revolutions * coarsest) or 1
            method = gauss_collocation(degree, chart)
            yield [Candidate(galvi_label(degree) + suffix, method, {}, steps)]
    for degree, sizes in IN_CLOCK.items():
        clocked = in_clock(degree, galvi.DynamicalTime())
        if clocked.supports(problem):
            yield [Candidate(clock_label(degree), clocked, {"step": h}, None) for h in sizes]
    peers: list[tuple[str, Any, Mapping[str, Any]]] = [
        ("REBOUND WHFast512, corrector 17", whfast512.WHFAST512, whfast512.BEST),
        ("REBOUND WHFast, corrector 17, LAZY", whfast.WHFAST, whfast.BEST),
        ("REBOUND WHFast, default", whfast.WHFAST, whfast.DEFAULT),
        ("REBOUND SABA(10,6,4)", saba.SABA, saba.BEST),
        ("REBOUND MERCURIUS", MERCURIUS, {}),
        ("REBOUND TRACE", TRACE, {}),
        ("REBOUND leapfrog", leapfrog.LEAPFROG, {}),
    ]
    for label, contender_type, options in peers:
        contender = on_simulation(contender_type)
        if not contender.missing and contender.supports(problem):
            yield [Candidate(label, contender, {**options}, round(revolutions * COARSEST) or 1)]
    extrapolated, radau = on_simulation(bulirsch_stoer.BULIRSCH_STOER), on_simulation(ias15.IAS15)
    yield [
        Candidate("REBOUND BS", extrapolated, {"eps_abs": eps, "eps_rel": eps}, None)
        for eps in (1e-6, 1e-8, 1e-10, 1e-12, 1e-13)
    ]
    yield [
        Candidate("REBOUND IAS15", radau, {**ias15.GLOBAL, "epsilon": epsilon}, None)
        for epsilon in (1e-2, 1e-3, 1e-5, 1e-7)
    ] + [Candidate("REBOUND IAS15", radau, dict(ias15.DEFAULT), None)]


def shifted(problem: Problem, amount: float, signs: Any) -> Problem:
    """The problem from positions whose entries differ by `amount` relative to themselves."""
    signs = signs[: problem.q0.size].reshape(problem.q0.shape)
    return problem.with_initial_state(problem.q0 * (1.0 + amount * signs), problem.v0)


def errors(run: Trajectory, truth: Trajectory) -> Array:
    """The distance of each body from its true position, (saved, bodies)."""
    return np.linalg.norm(run.q - truth.q, axis=-1)


def size(truth: Trajectory) -> float:
    """The largest distance of a body from the heaviest one, at any state."""
    centre = int(np.argmax(truth.problem.system.masses))
    return float(np.max(np.linalg.norm(truth.q - truth.q[:, centre : centre + 1], axis=-1)))


def unit(problem: Problem, dimension: str) -> str:
    """The unit of length or time with a space before it, or " units of length" without a name."""
    return f" {_named(problem, dimension) or f'units of {dimension}'}"


def _named(problem: Problem, dimension: str) -> str:
    units = [part.split(" ") for part in problem.units.split(", ")]
    return next((word[1] for word in units if len(word) == 2 and word[0] == dimension), "")


def names(problem: Problem) -> list[str]:
    """The names of the bodies, or their numbers where they have none."""
    body_names = problem.parameters.get("bodies", ())
    count = problem.q0.shape[0]
    return [str(body_names[k]) if k < len(body_names) else str(k) for k in range(count)]


def by_part(run: Trajectory, truth: Trajectory) -> pd.DataFrame:
    """The largest and the last error of each body, and the angle by which it is ahead at the
    end."""
    body_errors = errors(run, truth)
    system = run.problem.system
    centre = int(np.argmax(system.masses))
    lead = np.zeros(body_errors.shape[1])
    longitudes = [
        galvi.orbital_elements(trajectory).mean_longitude[-1] for trajectory in (run, truth)
    ]
    lead[np.arange(lead.size) != centre] = np.angle(np.exp(1j * (longitudes[0] - longitudes[1])))
    return pd.DataFrame(
        {
            "body": names(run.problem),
            "largest_error": body_errors.max(axis=0),
            "last_error": body_errors[-1],
            "phase_error": lead,
        }
    )


def pairs_with_hill_radius(masses: Array) -> list[tuple[int, int]]:
    """Pairs (i, j) with a mutual Hill radius: neither is the heaviest body, the sum of their masses
    is at most ``LIGHT_PAIR_FRACTION`` of its mass, and one has mass."""
    centre = int(np.argmax(masses))
    massive = [i for i in np.flatnonzero(masses > 0.0).tolist() if i != centre]
    return [
        (i, j)
        for i in massive
        for j in range(masses.size)
        if j not in (i, centre)
        and not (masses[j] > 0.0 and j < i)
        and masses[i] + masses[j] <= LIGHT_PAIR_FRACTION * masses[centre]
    ]


def encounters(truth: Trajectory) -> pd.DataFrame:
    """Passages of two bodies within ``ENCOUNTER_HILL_RADII`` mutual Hill radii, the closest first.

    Pairs are those of `pairs_with_hill_radius`, without pairs that are within at every state.

    time, distance  of the closest approach, from the relative velocity at the nearest state
    hill_radii      that distance over the mutual Hill radius
    outputs         number of states of the user's archive during the passage, for output at equal
                    intervals
    """
    output_every = truth.problem.parameters.get("output_every")
    system = truth.problem.system
    masses, centre = system.masses, int(np.argmax(system.masses))
    labels, rows = names(truth.problem), []
    distances = np.linalg.norm(truth.q - truth.q[:, centre : centre + 1], axis=2)
    gap_time = min(
        np.abs(np.diff(truth.t)).max(), shortest_period(truth.problem) / STATES_PER_REVOLUTION
    )
    for i, j in pairs_with_hill_radius(masses):
        hill = (
            0.5
            * (distances[:, i] + distances[:, j])
            * np.cbrt((masses[i] + masses[j]) / (3.0 * masses[centre]))
        )
        gap, velocity = truth.q[:, j] - truth.q[:, i], truth.v[:, j] - truth.v[:, i]
        speed_squared = np.sum(velocity * velocity, axis=1)
        delay = np.clip(
            -np.sum(gap * velocity, axis=1) / np.where(speed_squared > 0.0, speed_squared, 1.0),
            -gap_time,
            gap_time,
        )
        separation = np.linalg.norm(gap + delay[:, None] * velocity, axis=1) / hill
        inside = separation < ENCOUNTER_HILL_RADII
        if np.all(inside):  # a moon, or a double planet
            continue
        edges = np.flatnonzero(np.diff(np.concatenate([[0], inside.astype(int), [0]])))
        for first, last in zip(edges[::2], edges[1::2], strict=True):
            k = first + int(np.argmin(separation[first:last]))
            time = truth.t[k] + delay[k]
            row = [time, f"{labels[i]} and {labels[j]}", separation[k] * hill[k], separation[k]]
            if output_every:
                half = (
                    np.sqrt((ENCOUNTER_HILL_RADII**2 - separation[k] ** 2) / speed_squared[k])
                    * hill[k]
                )
                ends = (*truth.t[[first, last - 1]], time - half, time + half)
                row.append(_outputs(np.array(ends) - truth.t[0], output_every, float(truth.t[-1])))
            rows.append(row)
    columns = ["time", "bodies", "distance", "hill_radii", *(["outputs"] if output_every else [])]
    passages = pd.DataFrame(rows, columns=columns)
    return passages.sort_values("hill_radii", kind="stable").reset_index(drop=True)


def _outputs(ends: Array, output_every: float, last: float) -> int:
    """The number of multiples of ``output_every``, including 0, between the smallest and the
    largest of ``ends``, times since the start; they are cut off at the end ``last`` of the run."""
    multiples = np.clip(np.sort(np.abs(ends))[[0, -1]], 0.0, abs(last)) / output_every
    return int(np.floor(multiples[1]) - np.ceil(multiples[0])) + 1
