"""What a judgement of point masses needs: truths, integrators, errors, encounters."""

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

ORBITS = 100  # revolutions of the fastest body, where no duration is given
NEAR = 3.0  # mutual Hill radii within which a passage is an encounter
PER_ORBIT = 48  # states of the truth a revolution of the fastest body, to find encounters
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
LIGHT = 0.1  # share of the heaviest body's mass up to which two bodies have a mutual Hill radius
PART, ENGINE, ANOTHER = "body", "rebound", ""
ENGINE_HINT = "install the extra peers (pip install heyoka) for heyoka as a second"
COARSEST = 6.0 + 1.0 / 3.0  # steps to a revolution of the fastest body; a whole number resonates
GALVI_COARSEST, IN_FRAME = {8: 3.3, 12: 1.7, 16: 1.3}, {8: 1.7, 16: 1.1}  # degree: the same
IN_CLOCK = {8: (1.0, 0.7, 0.5, 0.35, 0.2), 16: (1.6, 1.2, 0.9, 0.6)}  # degree: steps in tau


def model(problem: Problem) -> Model:
    """The model of a problem alone, with the simulation that it came from or that is made of it."""
    return Model(problem, simulation_of(problem))


def shortest_period(problem: Problem) -> float:
    """The shortest period of two bodies that are bound to each other; of none, that of circles."""
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
    """``ORBITS`` revolutions of the fastest body."""
    return ORBITS * shortest_period(problem)


def span(duration: float, step: float) -> float:
    """The duration, negative where it or the own step is."""
    return -abs(duration) if step < 0.0 or duration < 0.0 else duration


def own_contender(model: Model, name: str) -> Contender:
    """The integrator of this name on the user's own simulation, with its options."""
    contender = INTEGRATORS[name]
    return contender if model.native is None else of_user(contender, model.native, model.problem)


def label(contender: Contender, options: Mapping[str, Any]) -> str:
    """The integrator with those of its options that are not REBOUND's defaults; coordinates always,
    where it has a choice."""
    usual = defaults(contender.integrator)
    option_texts = [
        f"{name} {value}".lower()
        for name, value in options.items()
        if name == "coordinates" or usual.get(name) != value
    ]
    return ", ".join([contender.name, *option_texts])


def states(problem: Problem, duration: float) -> int:
    """The number of states of the truth that are needed to find encounters."""
    if not meeting(problem.system.masses):
        return 1
    return min(math.ceil(PER_ORBIT * abs(duration) / shortest_period(problem)), MOST_STATES)


def sources(model: Model, duration: float, user_setting: UserSetting) -> list[Source]:
    """IAS15 on the user's own simulation, with another epsilon first where that is the own setting;
    then other engines, unless they would run forces that are not read to rounding, and galvi's
    opinion."""
    problem = model.problem
    radau: Any = ias15.IAS15
    if model.native is not None:
        radau = of_user(radau, model.native, problem, keep_settings=False)
    read_alike = not _inexact(model)
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
        if (read_alike or source.engine in ("REBOUND", ""))
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
    """ValueError where REBOUND's accelerations at states of the truth are not the problem's."""
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
        over = np.flatnonzero(beyond(sizes, distance))
        ends = (
            f"ends there at about t = {time_text(truth, truth.t[over[0]])}"
            if over.size
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
    """For each integrator its settings from coarse to fine, or the steps to begin with, on a
    new simulation, with the heaviest body first, or on the user's own, where it has
    forces of REBOUNDx."""
    problem, forced = model.problem, isinstance(model.native, Forced)

    def on_it(contender: Any) -> Any:
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
    kinds: list[tuple[str, Any, Mapping[str, Any]]] = [
        ("REBOUND WHFast512, corrector 17", whfast512.WHFAST512, whfast512.BEST),
        ("REBOUND WHFast, corrector 17, LAZY", whfast.WHFAST, whfast.BEST),
        ("REBOUND WHFast, default", whfast.WHFAST, whfast.DEFAULT),
        ("REBOUND SABA(10,6,4)", saba.SABA, saba.BEST),
        ("REBOUND MERCURIUS", MERCURIUS, {}),
        ("REBOUND TRACE", TRACE, {}),
        ("REBOUND leapfrog", leapfrog.LEAPFROG, {}),
    ]
    for label, kind, options in kinds:
        contender = on_it(kind)
        if not contender.missing and contender.supports(problem):
            yield [Candidate(label, contender, {**options}, round(revolutions * COARSEST) or 1)]
    extrapolated, radau = on_it(bulirsch_stoer.BULIRSCH_STOER), on_it(ias15.IAS15)
    yield [
        Candidate("REBOUND BS", extrapolated, {"eps_abs": eps, "eps_rel": eps}, None)
        for eps in (1e-6, 1e-8, 1e-10, 1e-12, 1e-13)
    ]
    yield [
        Candidate("REBOUND IAS15", radau, {**ias15.GLOBAL, "epsilon": epsilon}, None)
        for epsilon in (1e-2, 1e-3, 1e-5, 1e-7)
    ] + [Candidate("REBOUND IAS15", radau, dict(ias15.DEFAULT), None)]


def shifted(problem: Problem, amount: float, signs: Any) -> Problem:
    """The problem from places that differ by this amount of themselves."""
    signs = signs[: problem.q0.size].reshape(problem.q0.shape)
    return problem.with_initial_state(problem.q0 * (1.0 + amount * signs), problem.v0)


def errors(run: Trajectory, truth: Trajectory) -> Array:
    """The distance of each body from its true place, (saved, bodies)."""
    return np.linalg.norm(run.q - truth.q, axis=-1)


def size(truth: Trajectory) -> float:
    """The largest distance from the heaviest body; also where each state is at the same phase."""
    centre = int(np.argmax(truth.problem.system.masses))
    return float(np.max(np.linalg.norm(truth.q - truth.q[:, centre : centre + 1], axis=-1)))


def unit(problem: Problem, dimension: str) -> str:
    """The unit of length or time with a space before it, by name where REBOUND knows it."""
    return f" {_named(problem, dimension) or f'units of {dimension}'}"


def _named(problem: Problem, dimension: str) -> str:
    units = [part.split(" ") for part in problem.units.split(", ")]
    return next((word[1] for word in units if len(word) == 2 and word[0] == dimension), "")


def names(problem: Problem) -> list[str]:
    """The names of the bodies."""
    body_names = problem.parameters.get("bodies", ())
    count = problem.q0.shape[0]
    return [str(body_names[k]) if k < len(body_names) else str(k) for k in range(count)]


def by_part(run: Trajectory, truth: Trajectory) -> pd.DataFrame:
    """The largest and the last error of each body, and the angle by which it is ahead."""
    off = errors(run, truth)
    system = run.problem.system
    centre = int(np.argmax(system.masses))
    lead = np.zeros(off.shape[1])
    turned = [galvi.orbital_elements(trajectory).mean_longitude[-1] for trajectory in (run, truth)]
    lead[np.arange(lead.size) != centre] = np.angle(np.exp(1j * (turned[0] - turned[1])))
    return pd.DataFrame(
        {
            "body": names(run.problem),
            "largest_error": off.max(axis=0),
            "last_error": off[-1],
            "phase_error": lead,
        }
    )


def meeting(masses: Array) -> list[tuple[int, int]]:
    """Pairs that have a mutual Hill radius: without the heaviest body, with at most ``LIGHT`` of
    its mass together, and not both massless."""
    centre = int(np.argmax(masses))
    some = [i for i in np.flatnonzero(masses > 0.0).tolist() if i != centre]
    return [
        (i, j)
        for i in some
        for j in range(masses.size)
        if j not in (i, centre)
        and not (masses[j] > 0.0 and j < i)
        and masses[i] + masses[j] <= LIGHT * masses[centre]
    ]


def encounters(truth: Trajectory) -> pd.DataFrame:
    """Passages of two bodies of `meeting` within ``NEAR`` mutual Hill radii, the closest first;
    without those that stay there.

    time, distance  of the nearest point, from the relative velocity at the nearest state
    hill_radii      that distance over the mutual Hill radius
    outputs         states of the user's archive that fall into it, where output goes on as there
    """
    output_every = truth.problem.parameters.get("output_every")
    system = truth.problem.system
    masses, centre = system.masses, int(np.argmax(system.masses))
    labels, rows = names(truth.problem), []
    reach = np.linalg.norm(truth.q - truth.q[:, centre : centre + 1], axis=2)
    gap_time = min(np.abs(np.diff(truth.t)).max(), shortest_period(truth.problem) / PER_ORBIT)
    for i, j in meeting(masses):
        hill = (
            0.5
            * (reach[:, i] + reach[:, j])
            * np.cbrt((masses[i] + masses[j]) / (3.0 * masses[centre]))
        )
        gap, speed = truth.q[:, j] - truth.q[:, i], truth.v[:, j] - truth.v[:, i]
        moving = np.sum(speed * speed, axis=1)
        after = np.clip(
            -np.sum(gap * speed, axis=1) / np.where(moving > 0.0, moving, 1.0),
            -gap_time,
            gap_time,
        )
        separation = np.linalg.norm(gap + after[:, None] * speed, axis=1) / hill
        inside = separation < NEAR
        if np.all(inside):  # a moon, or a double planet
            continue
        edges = np.flatnonzero(np.diff(np.concatenate([[0], inside.astype(int), [0]])))
        for first, last in zip(edges[::2], edges[1::2], strict=True):
            k = first + int(np.argmin(separation[first:last]))
            time = truth.t[k] + after[k]
            row = [time, f"{labels[i]} and {labels[j]}", separation[k] * hill[k], separation[k]]
            if output_every:
                half = np.sqrt((NEAR**2 - separation[k] ** 2) / moving[k]) * hill[k]
                ends = (*truth.t[[first, last - 1]], time - half, time + half)
                row.append(_outputs(np.array(ends) - truth.t[0], output_every, float(truth.t[-1])))
            rows.append(row)
    columns = ["time", "bodies", "distance", "hill_radii", *(["outputs"] if output_every else [])]
    passages = pd.DataFrame(rows, columns=columns)
    return passages.sort_values("hill_radii", kind="stable").reset_index(drop=True)


def _outputs(ends: Array, output_every: float, last: float) -> int:
    """The number of whole multiples of a time, including 0, that lie between the outermost of some
    times since the start, in a run that ends at ``last``."""
    parts = np.clip(np.sort(np.abs(ends))[[0, -1]], 0.0, abs(last)) / output_every
    return int(np.floor(parts[1]) - np.ceil(parts[0])) + 1
