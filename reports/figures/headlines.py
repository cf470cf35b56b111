"""The figures a reader sees first: planets, rigid bodies, encounters, beside other codes."""

from references.mujoco.steps import DEFAULT_STEP, MUJOCO_RK4
from reports.figures.work_precision import headline
from reports.results.section import Figure

REBOUND = {
    "galvi, fastest setting": "galvi",
    "REBOUND WHFast": "REBOUND WHFast, best",
    "REBOUND WHFast512": "REBOUND WHFast512",
    "REBOUND SABA": "REBOUND SABA",
    "REBOUND IAS15": "REBOUND IAS15",
    "heyoka": "heyoka",
}
MUJOCO = {
    "galvi, fastest setting": "galvi",
    "MuJoCo RK4": "MuJoCo RK4",
    "MuJoCo implicit": "MuJoCo implicit",
    "heyoka": "heyoka",
    "DOP853 on quaternions, compiled": "DOP853 on quaternions, compiled",
    "RK4 on quaternions, compiled": "RK4 on quaternions, compiled",
}
CLOCK = {
    "galvi, clock": "galvi",
    "REBOUND IAS15": "REBOUND IAS15",
    "REBOUND BS": "REBOUND BS",
    "REBOUND TRACE": "REBOUND TRACE",
    "heyoka": "heyoka",
}
CAPTION = (
    "Time to solution of the fastest setting for each error, in the same interleaved rounds; "
    "further left and lower is better. An open mark with an arrow is a bound."
)

HEADLINES = (
    Figure(
        name="headline-rebound",
        title="Planets: galvi beside REBOUND",
        draw=headline,
        options={
            "panels": {
                "outer solar system": "Outer solar system, 10,000 years",
                "solar system without Pluto": "Sun and eight planets, 200 years",
            },
            "shown": REBOUND,
        },
        caption=f"{CAPTION} Error: the largest distance of a body from its true place at the end. "
        "WHFast with its best options; WHFast512 is written by hand in AVX-512 instructions for a "
        "star and eight planets.",
        size=(9.0, 4.2),
    ),
    Figure(
        name="headline-mujoco",
        title="Rigid bodies: galvi beside MuJoCo",
        draw=headline,
        options={
            "panels": {
                "free rigid body": "Free rigid body, nine turns",
                "3D pendulum, m g = 9.81": "3D pendulum, m g = 9.81",
            },
            "shown": MUJOCO,
            "marked": (MUJOCO_RK4.name, DEFAULT_STEP, "MuJoCo RK4, default step"),
        },
        caption=f"{CAPTION} Error: the largest entry of R - R_true after 20 units of time. MuJoCo "
        "is a "
        "general engine, and much of its time is the price of that; its implicit integrator is of "
        f"first order. A circle, where it was run: its RK4 at the default step, {DEFAULT_STEP:g}.",
        size=(9.0, 4.2),
    ),
    Figure(
        name="headline-clock",
        title="Eccentric orbits and encounters: galvi's clock beside REBOUND and heyoka",
        draw=headline,
        options={
            "panels": {
                "two bodies, e = 0.99": "Two bodies, e = 0.99",
                "Burrau's problem": "Burrau's three bodies",
            },
            "shown": CLOCK,
        },
        caption=f"{CAPTION} Error: the largest distance of a body from its true place at the end. "
        "A code without a line was not run, did not end its runs, or not within the errors shown.",
        size=(9.0, 4.2),
    ),
)
