"""The study of planets beside JPL's ephemeris: relativity, and the sky."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd
import pytest

import galvi
from benchmarks.measures.orbit_shape import angle, period
from benchmarks.studies import ephemeris
from benchmarks.studies.ephemeris import LIGHT_SPEED, displacement, path
from references.jpl import states as jpl

# Mercury's orbit: au^3 / day^2, au
GM, SEMI_MAJOR_AXIS, ECCENTRICITY = 2.9591e-4, 0.387098, 0.205630
ARC_SECONDS = 648_000.0 / math.pi  # in a radian
MERCURY_PERIOD = math.tau * math.sqrt(SEMI_MAJOR_AXIS**3 / GM)  # days


def start() -> tuple[np.ndarray, np.ndarray]:
    """Position and velocity at perihelion, on the x axis."""
    speed = math.sqrt(GM / SEMI_MAJOR_AXIS * (1.0 + ECCENTRICITY) / (1.0 - ECCENTRICITY))
    return np.array([SEMI_MAJOR_AXIS * (1.0 - ECCENTRICITY), 0.0, 0.0]), np.array([0.0, speed, 0.0])


def perihelion(light: float, around: float) -> np.ndarray:
    """Position of the body at its perihelion near a time, by a parabola through fine samples."""
    times = around + np.linspace(-0.5, 0.5, 201)
    positions = path(GM, *start(), np.concatenate([[0.0], times]), light)[1:]
    distance = np.linalg.norm(positions, axis=-1)
    curvature, slope, _ = np.polyfit(times - around, distance, 2)
    nearest = -0.5 * slope / curvature
    return np.array([np.interp(nearest, times - around, x) for x in positions.T])


def test_mercury_s_perihelion_advances_by_43_arc_seconds_a_century() -> None:
    revolutions = 20
    relativistic = perihelion(LIGHT_SPEED, revolutions * MERCURY_PERIOD)
    advance = (
        angle(start()[0], relativistic) * ARC_SECONDS / (revolutions * MERCURY_PERIOD / 36_525.0)
    )
    assert advance == pytest.approx(42.98, rel=0.01)
    assert (
        angle(start()[0], perihelion(math.inf, revolutions * MERCURY_PERIOD)) * ARC_SECONDS < 0.01
    )


def test_the_displacement_is_nothing_without_the_term_and_falls_with_the_speed_of_light() -> None:
    times = np.array([100.0, 1000.0])
    usual = displacement(GM, *start(), times)
    assert np.all(usual > 1e-7)
    shift = path(GM, *start(), times, 10.0 * LIGHT_SPEED) - path(GM, *start(), times, math.inf)
    assert np.linalg.norm(shift, axis=-1) == pytest.approx(usual / 100.0, rel=1e-3)


def test_a_light_second_is_a_light_second() -> None:
    seconds = 86_400.0 / LIGHT_SPEED
    assert seconds == pytest.approx(499.004784, abs=1e-5)
    assert period(galvi.problems.solar_system(), 1) == pytest.approx(MERCURY_PERIOD, rel=1e-3)


@pytest.fixture(scope="module")
def table() -> pd.DataFrame:
    if jpl.missing():
        pytest.skip(jpl.missing())
    return ephemeris.ephemeris_table()


def test_every_body_has_a_row_for_every_time_and_the_run_is_converged(table: pd.DataFrame) -> None:
    assert tuple(table.columns) == ephemeris.COLUMNS
    assert len(table) == 2 * 10 * len(ephemeris.DAYS)
    assert not table.duplicated(["contender", "body", "days"]).any()
    planets = table[table["body"] != "Sun"]
    assert planets.notna().all(axis=None)
    assert table["integration_error_au"].max() < 2e-12  # 3e-13 when this was written
    floor = 2e-14  # some ulps of the outer planets' positions
    assert (planets["integration_error_au"] < 1e-4 * planets["difference_au"] + floor).all()


def test_the_differences_and_angles_are_of_the_size_that_relativity_explains(
    table: pd.DataFrame,
) -> None:
    inner = table[table["body"].isin(["Mercury", "Venus", "Earth", "Mars"])]
    assert inner["difference_au"].between(1e-7, 1e-4).all()
    ratio = inner["difference_au"] / inner["relativity_au"]
    assert ratio.between(0.85, 1.15).all()
    outer = table[table["body"].isin(["Saturn", "Uranus", "Neptune", "Pluto"])]
    assert (outer["difference_au"] < 1e-6).all()
    mercury = table[table["body"] == "Mercury"]  # between 0.3 and 0.5 au away
    angles = mercury["difference_arcsec"] * ephemeris.ARC_SECOND
    assert (angles <= mercury["difference_au"] / 0.3).all()


def test_without_the_ephemeris_it_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(jpl, "missing", lambda: "Install jplephem and de421.")
    with pytest.raises(ModuleNotFoundError, match="Install jplephem"):
        ephemeris.ephemeris_table()
