"""The timed runs of galvi: a step and a trajectory of every problem, and round-off runs.

A new problem needs its cases here. Truths are closed forms and stored files where available.
Trajectories are long enough for the kernel to dominate; the time of a step is mostly call overhead.
"""

from __future__ import annotations

import math

from benchmarks.timings.case import ROUND_OFF, ROUNDING_TOLERANCE, STEP, TRAJECTORY, Case

KEPLER, PENDULUM = "Kepler, closed form", "pendulum, closed form"
OSCILLATOR, STORED, IAS15 = "oscillator, closed form", "stored truth", "REBOUND IAS15"
TOP, STORED_BODY = "free rigid body, closed form", "stored truth, rigid bodies"
DOP853, BODY = "SciPy DOP853", "DOP853 on quaternions, compiled"
CHAINS, LAGRANGIANS = "SciPy DOP853, chains", "SciPy DOP853, Lagrangians"
THROWN, STORED_LAW = "thrown body, closed form", "stored truth, Lagrangians"
TREES = "SciPy DOP853 on MuJoCo's accelerations"
TIGHT = 1e-13  # for DOP853
NEAR_CIRCLE, BELT = {"eccentricity": 0.2}, {"particles": 100}
FLOATING = {"floating": True}

STEPS = (
    Case("oscillator, a step", STEP, "harmonic_oscillator", 8, 8, 2.0, 1, OSCILLATOR),
    Case("Kepler, degree 4, a step", STEP, "kepler", 4, 4, 0.1, 1, KEPLER),
    Case("Kepler, degree 8, a step", STEP, "kepler", 8, 8, 0.25, 1, KEPLER, quick=True),
    Case("Kepler, degree 16, a step", STEP, "kepler", 16, 16, 0.75, 1, KEPLER),
    Case("pendulum, a step", STEP, "planar_pendulum", 6, 6, 0.5, 1, PENDULUM),
    Case("driven oscillator, a step", STEP, "driven_oscillator", 8, 8, 0.5, 1, DOP853,
         truth_tolerance=TIGHT),
    Case("solar system, degree 4, a step", STEP, "solar_system", 4, 4, 4.0, 1, IAS15),
    Case("solar system, degree 8, a step", STEP, "solar_system", 8, 8, 8.0, 1, IAS15),
    Case("solar system, degree 16, a step", STEP, "solar_system", 16, 16, 32.0, 1, IAS15),
    Case("outer planets, degree 6, a step", STEP, "outer_solar_system", 6, 6, 270.0, 1, IAS15),
    Case("outer planets, degree 12, a step", STEP, "outer_solar_system", 12, 12, 1080.0, 1, IAS15),
    Case("outer planets and 100 massless bodies, a step", STEP, "outer_solar_system", 8, 8, 487.0,
         1, IAS15, arguments=BELT),
    Case("Applegate, a step", STEP, "applegate", 8, 8, 1.5, 1, IAS15),
    Case("Henon-Heiles, a step", STEP, "henon_heiles", 4, 4, 0.5, 1, DOP853,
         truth_tolerance=TIGHT),
    Case("FPUT chain, a step", STEP, "fermi_pasta_ulam_tsingou", 4, 4, 0.5, 1, DOP853,
         truth_tolerance=TIGHT),
    Case("free body, a step", STEP, "free_rigid_body", 6, 6, 0.25, 1, TOP, quick=True),
    Case("free box, a step", STEP, "free_box", 6, 6, 0.25, 1, TOP),
    Case("3D pendulum, a step", STEP, "pendulum_3d", 6, 6, 0.5, 1, STORED_BODY),
    Case("elastic pendulum, a step", STEP, "elastic_pendulum", 8, 8, 0.1, 1, LAGRANGIANS,
         truth_tolerance=TIGHT),
    Case("polar Kepler, a step", STEP, "kepler_polar", 8, 8, 0.5, 1, LAGRANGIANS,
         truth_tolerance=TIGHT),
    Case("heavy top, a step", STEP, "heavy_top", 5, 5, 0.1, 1, BODY, truth_tolerance=TIGHT),
    Case("spherical pendulum, a step", STEP, "spherical_pendulum", 5, 5, 0.2, 1, BODY,
         truth_tolerance=TIGHT),
    Case("body on SE(3), a step", STEP, "free_body_se3", 5, 5, 0.1, 1, THROWN),
    Case("double pendulum, a step", STEP, "double_pendulum", 4, 4, 0.1, 1, CHAINS,
         truth_tolerance=TIGHT),
    Case("planar chain, a step", STEP, "planar_chain", 4, 4, 0.1, 1, CHAINS,
         truth_tolerance=TIGHT),
    Case("skew arm, a step", STEP, "skew_arm", 6, 6, 0.02, 1, TREES, truth_tolerance=TIGHT),
    Case("floating arm, a step", STEP, "skew_arm", 6, 6, 0.1, 1, TREES, arguments=FLOATING,
         truth_tolerance=TIGHT),
    Case("brownout, a step", STEP, "brownout", 4, 4, 0.02, 1, DOP853, truth_tolerance=TIGHT),
)  # fmt: skip

TRAJECTORIES = (
    Case("oscillator, as in H", TRAJECTORY, "harmonic_oscillator", 23, 48, 20.0, 200, OSCILLATOR,
         error_tolerance=ROUNDING_TOLERANCE),
    Case("Kepler, as in H", TRAJECTORY, "kepler", 31, 64, 2.0, 400, KEPLER),
    Case("Kepler, degree 8", TRAJECTORY, "kepler", 8, 8, math.tau / 24.5, 4900, KEPLER,
         quick=True),
    Case("Kepler by Lobatto", TRAJECTORY, "kepler", 6, 7, 0.1, 6000, KEPLER, rule="lobatto"),
    Case("pendulum, degree 6", TRAJECTORY, "planar_pendulum", 6, 6, 0.5, 4000, PENDULUM),
    Case("driven oscillator, degree 4", TRAJECTORY, "driven_oscillator", 4, 4, 0.25, 400, DOP853,
         truth_tolerance=TIGHT),
    Case("solar system, as in H", TRAJECTORY, "solar_system", 24, 50, 100.0, 150, IAS15),
    Case("solar system, degree 8", TRAJECTORY, "solar_system", 8, 8, 12.0, 6000, IAS15,
         quick=True),
    Case("solar system, degree 16", TRAJECTORY, "solar_system", 16, 16, 40.0, 1500, IAS15),
    Case("outer planets, degree 8", TRAJECTORY, "outer_solar_system", 8, 8, 487.0, 7500, STORED,
         quick=True),
    Case("solar system in the Kepler frame, 16 stages", TRAJECTORY, "solar_system", 16, 16, 60.0,
         1000, IAS15, chart="KeplerFrame"),
    Case("outer planets in the Kepler frame, 8 stages", TRAJECTORY, "outer_solar_system", 8, 8,
         487.0, 7500, STORED, chart="KeplerFrame", quick=True, error_tolerance=ROUNDING_TOLERANCE),
    Case("FPUT chain in the harmonic frame", TRAJECTORY, "fermi_pasta_ulam_tsingou", 6, 6, 2.0, 10,
         STORED_LAW, chart="HarmonicFrame"),
    Case("outer planets, degree 12", TRAJECTORY, "outer_solar_system", 12, 12, 974.0, 3750,
         STORED),
    Case("outer planets and 100 massless bodies", TRAJECTORY, "outer_solar_system", 8, 8, 487.0,
         400, IAS15, arguments=BELT),
    Case("Applegate, degree 8", TRAJECTORY, "applegate", 8, 8, 1.25, 8000, STORED),
    Case("Henon-Heiles, degree 4", TRAJECTORY, "henon_heiles", 4, 4, 0.25, 2000, DOP853,
         quick=True, truth_tolerance=TIGHT),
    Case("FPUT chain, degree 4", TRAJECTORY, "fermi_pasta_ulam_tsingou", 4, 4, 0.5, 1000, DOP853,
         truth_tolerance=TIGHT),
    Case("free body, degree 6", TRAJECTORY, "free_rigid_body", 6, 6, 0.25, 20_000, TOP,
         quick=True),
    Case("free body, n points for n functions", TRAJECTORY, "free_rigid_body", 6, 7, 0.5, 400,
         TOP, quick=True),
    Case("free body, exponential chart", TRAJECTORY, "free_rigid_body", 8, 8, 0.5, 20_000, TOP,
         chart="Exponential", error_tolerance=ROUNDING_TOLERANCE),
    Case("free body, modified Rodrigues chart", TRAJECTORY, "free_rigid_body", 8, 8, 0.5, 20_000,
         TOP, chart="ModifiedRodrigues", error_tolerance=ROUNDING_TOLERANCE),
    Case("free box, degree 6", TRAJECTORY, "free_box", 6, 6, 0.2, 20_000, TOP),
    Case("3D pendulum, degree 4", TRAJECTORY, "pendulum_3d", 4, 4, 0.01, 2000, STORED_BODY,
         quick=True),
    Case("Henon-Heiles, degree 8", TRAJECTORY, "henon_heiles", 8, 8, 2.0, 20, STORED_LAW),
    Case("FPUT chain, degree 6", TRAJECTORY, "fermi_pasta_ulam_tsingou", 6, 6, 2.0, 10, STORED_LAW),
    Case("elastic pendulum, degree 8", TRAJECTORY, "elastic_pendulum", 8, 8, 0.1, 100, STORED_LAW,
         quick=True),
    Case("polar Kepler, degree 8", TRAJECTORY, "kepler_polar", 8, 8, 0.5, 400, LAGRANGIANS,
         truth_tolerance=TIGHT),
    Case("double pendulum, degree 8", TRAJECTORY, "double_pendulum", 8, 8, 0.05, 100,
         "stored truth, chains"),
    Case("planar chain, degree 6", TRAJECTORY, "planar_chain", 6, 6, 0.025, 200,
         "stored truth, chains"),
    Case("heavy top, degree 8", TRAJECTORY, "heavy_top", 8, 8, 0.125, 160, STORED_BODY),
    Case("heavy top, degree 5", TRAJECTORY, "heavy_top", 5, 5, 0.1, 100, BODY, quick=True,
         truth_tolerance=TIGHT),
    Case("spherical pendulum, degree 5", TRAJECTORY, "spherical_pendulum", 5, 5, 0.2, 200, BODY,
         truth_tolerance=TIGHT),
    Case("body on SE(3), degree 5", TRAJECTORY, "free_body_se3", 5, 5, 0.1, 50, THROWN),
    Case("body on SE(3), long steps", TRAJECTORY, "free_body_se3", 5, 5, 0.25, 400, THROWN),
    Case("double pendulum, degree 4", TRAJECTORY, "double_pendulum", 4, 4, 0.02, 100, CHAINS,
         quick=True, truth_tolerance=TIGHT),
    Case("planar chain, degree 4", TRAJECTORY, "planar_chain", 4, 4, 0.02, 50, CHAINS,
         truth_tolerance=TIGHT),
    Case("skew arm, degree 4", TRAJECTORY, "skew_arm", 4, 4, 0.01, 100, TREES, quick=True,
         truth_tolerance=TIGHT),
    Case("floating arm, degree 6", TRAJECTORY, "skew_arm", 6, 6, 0.1, 50, TREES,
         arguments=FLOATING, truth_tolerance=TIGHT),
    Case("brownout, degree 3", TRAJECTORY, "brownout", 3, 3, 0.02, 100, DOP853,
         truth_tolerance=TIGHT),
)  # fmt: skip

ROUNDING = (
    Case("Kepler, rounding", ROUND_OFF, "kepler", 6, 6, math.tau / 200.0, 6000, KEPLER,
         arguments=NEAR_CIRCLE, starts=16, quick=True, error_tolerance=1.0, rounding=1e-14),
    Case("outer planets, rounding", ROUND_OFF, "outer_solar_system", 6, 6, 36.525, 10_000, STORED,
         quick=True, error_tolerance=ROUNDING_TOLERANCE, rounding=1e-14),
    Case("free body, rounding", ROUND_OFF, "free_rigid_body", 8, 8, 0.05, 20_000, TOP, quick=True,
         error_tolerance=ROUNDING_TOLERANCE),
)  # fmt: skip

CASES: tuple[Case, ...] = (*STEPS, *TRAJECTORIES, *ROUNDING)
