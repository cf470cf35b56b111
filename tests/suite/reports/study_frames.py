"""Small tables as each study measures them, for the tests of reports."""

from __future__ import annotations

import numpy as np
import pandas as pd

from benchmarks.studies.engine_versions import COLUMNS as VERSIONS
from benchmarks.studies.free_body_drift import COLUMNS as SPIN
from benchmarks.studies.free_body_drift import marks
from benchmarks.studies.round_off import COLUMNS
from benchmarks.studies.round_off_participants import SAMPLED_HUNDREDTHS
from benchmarks.studies.scaling import COLUMNS as SCALING
from benchmarks.studies.taxonomy import COLUMNS as TAXONOMY


def walks(years=1e4, commit="", drift=0.0, runs=16):
    """Random walks of two contenders, one of which returns rounded states."""
    rng = np.random.default_rng(1)
    rows = []
    for contender, low in (("galvi degree 8, Gauss 8", 1e-18), ("REBOUND IAS15", 0.0)):
        for k in range(runs):
            path = np.cumsum(1e-16 * (rng.standard_normal(100) + drift))
            rows += [
                {
                    "contender": contender,
                    "settings": "as usual",
                    "years": years,
                    "member": k,
                    "sample": n,
                    "t": years * n / 100,
                    "error": path[n - 1],
                    "error_of_rounded": path[n - 1] + low,
                    "status": "",
                    "commit": commit,
                    "date": "2026-01-01" if commit else "",
                }
                for n in SAMPLED_HUNDREDTHS
            ]
    return rows


def brouwer(quick, report):
    return pd.DataFrame(walks(), columns=list(COLUMNS))


def scaling(quick, report):
    """galvi and a peer that does not reach the error with three bodies; one is not installed."""
    blank = dict.fromkeys(SCALING, np.nan)
    rows = [
        {
            **blank,
            "contender": contender,
            "settings": "P/6",
            "bodies": bodies,
            "orbits": 30,
            "seconds_per_orbit": time * bodies,
            "seconds_low": 0.9 * time * bodies,
            "seconds_high": 1.1 * time * bodies,
            "error": 1e-9,
            "matched": time < 1e-4 or bodies > 3,
            "pairs_per_second": 1e9,
            "limit_pairs_per_second": 2e9,
            "share": 0.5 if contender.startswith("galvi") else np.nan,
            "status": "",
        }
        for bodies in (3, 10, 100)
        for contender, time in (("galvi degree 8, Gauss 8", 1e-5), ("REBOUND IAS15", 1e-3))
    ]
    absent = {**blank, "contender": "Other", "bodies": 3, "matched": False, "status": "Install it."}
    return pd.DataFrame([*rows, absent], columns=list(SCALING))


def versions(quick, report):
    """RK4 of order 2 in an old version and 4 in a new one; a third cannot be installed."""
    rows = [
        {
            "engine": f"mujoco {name}",
            "joint": joint,
            "integrator": "RK4",
            "step": 0.1 / 2**k,
            "attitude_error": size * 2.0 ** (-k * order),
            "energy_error": 1e-12,
            "status": "",
            "commit": "",
            "date": "",
        }
        for name, order, size in (("3.10.0", 2, 1e-3), ("3.6.0", 2, 1e-3), ("4.0.1", 4, 1e-6))
        for joint in ("ball", "free")
        for k in range(9)
    ]
    blank = dict.fromkeys(("step", "attitude_error", "energy_error"), np.nan)
    absent = {"engine": "mujoco 9.9.9", "joint": "", "integrator": "", "status": "No such version."}
    return pd.DataFrame([*rows, {**blank, **absent}], columns=list(VERSIONS))


def spins(quick, report):
    """galvi at round-off, a peer that drifts, one that fails and one that is absent."""
    blank = dict.fromkeys(SPIN, np.nan) | {
        "problem": "free rigid body",
        "step": 0.01,
        "turns": 1000.0,
        "commit": "",
        "date": "",
    }
    rows = [
        {
            **blank,
            "contender": contender,
            "engine": engine,
            "turn": float(turn),
            "energy_error": size * turn if turn < fails else np.nan,
            "momentum_error": 1e-16 if turn < fails else np.nan,
            "attitude_error": 1e-9 if turn == 1000 and turn < fails else np.nan,
            "status": "" if turn < fails else "It burst.",
        }
        for contender, engine, size, fails in (
            ("galvi degree 4, Gauss 4, Cayley", "galvi", 1e-17, 9e9),
            ("MuJoCo RK4, free joint", "mujoco 4.0.1", -1e-12, 9e9),
            ("MuJoCo Euler, free joint", "mujoco 4.0.1", 1e-3, 300),
        )
        for turn in marks(1000)
    ]
    absent = {**blank, "contender": "MuJoCo implicit", "engine": "", "status": "Install it."}
    return pd.DataFrame([*rows, absent], columns=list(SPIN))


def pairs_of_spaces_and_rules(quick, report):
    """Two methods, one of them known, and two pairs that make none."""
    blank = dict.fromkeys(TAXONOMY, np.nan) | {
        "kind": "Polynomials",
        "number": 1,
        "space": "Polynomials(degree=1)",
        "family": "Gauss",
        "name": "",
        "status": "",
        "predicted": 2,
    }
    well_posed = {"verdict": "method", "C_N": 0.97, "symplecticity": 1e-16, "symmetry": 3e-16}
    rows = [
        {**blank, **well_posed, "points": 1, "measured": 2.0, "name": "implicit midpoint"},
        {**blank, **well_posed, "points": 2, "measured": 2.01},
        {**blank, "points": 1, "space": "Fourier(harmonics=1)", "verdict": "ill-posed"},
        {**blank, "points": 2, "space": "Fourier(harmonics=1)", "verdict": "inconsistent"},
    ]
    return pd.DataFrame(rows, columns=list(TAXONOMY))


FRAMES = {
    "brouwer": brouwer,
    "scaling": scaling,
    "free-spin": spins,
    "engine-versions": versions,
    "taxonomy": pairs_of_spaces_and_rules,
}
