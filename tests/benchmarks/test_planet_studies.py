"""Studies of planets: relativity, published runs, the sky."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import galvi
from benchmarks.measures.orbit_shape import angle, period
from benchmarks.studies import ephemeris
from benchmarks.studies.ephemeris import LIGHT, displacement, path
from benchmarks.studies.moving_frames import published
from benchmarks.test_problems.planets import EPOCH, outer_planets_of_1969, regular_henon_heiles
from benchmarks.work_precision.galvi_methods import gauss_collocation
from references.jpl import states
from references.jpl import states as jpl

GM, AXIS, ECCENTRICITY = 2.9591e-4, 0.387098, 0.205630  # Mercury's
SECONDS = 648_000.0 / math.pi
YEAR = math.tau * math.sqrt(AXIS**3 / GM)


def start() -> tuple[np.ndarray, np.ndarray]:
    """At perihelion, on the x axis."""
    speed = math.sqrt(GM / AXIS * (1.0 + ECCENTRICITY) / (1.0 - ECCENTRICITY))
    return np.array([AXIS * (1.0 - ECCENTRICITY), 0.0, 0.0]), np.array([0.0, speed, 0.0])


def perihelion(light: float, around: float) -> np.ndarray:
    """Where the body is nearest, by a parabola through fine samples near a time."""
    times = around + np.linspace(-0.5, 0.5, 201)
    places = path(GM, *start(), np.concatenate([[0.0], times]), light)[1:]
    distance = np.linalg.norm(places, axis=-1)
    bend, slope, _ = np.polyfit(times - around, distance, 2)
    nearest = -0.5 * slope / bend
    return np.array([np.interp(nearest, times - around, x) for x in places.T])


def test_mercury_s_perihelion_advances_by_43_arc_seconds_a_century() -> None:
    revolutions = 20
    relativistic = perihelion(LIGHT, revolutions * YEAR)
    turned = angle(start()[0], relativistic) * SECONDS / (revolutions * YEAR / 36_525.0)
    assert turned == pytest.approx(42.98, rel=0.01)
    assert angle(start()[0], perihelion(math.inf, revolutions * YEAR)) * SECONDS < 0.01


def test_the_displacement_is_nothing_without_the_term_and_falls_with_the_speed_of_light() -> None:
    times = np.array([100.0, 1000.0])
    usual = displacement(GM, *start(), times)
    assert np.all(usual > 1e-7)
    apart = path(GM, *start(), times, 10.0 * LIGHT) - path(GM, *start(), times, math.inf)
    assert np.linalg.norm(apart, axis=-1) == pytest.approx(usual / 100.0, rel=1e-3)


def test_a_light_second_is_a_light_second() -> None:
    seconds = 86_400.0 / LIGHT
    assert seconds == pytest.approx(499.004784, abs=1e-5)
    assert period(galvi.problems.solar_system(), 1) == pytest.approx(YEAR, rel=1e-3)


def test_the_rows_stand_beside_what_is_printed() -> None:
    """Energies to rounding: a walk of an ulp in the square root of the steps is 1e-13 at most."""
    table = published.published(quick=True)
    assert tuple(table.columns) == tuple(published.COLUMNS)
    printed = table[table["contender"] == published.PRINTED]
    assert printed["energy_error"].tolist() == [3.6e-15, 5.6e-14]
    ours = table[table["contender"] != published.PRINTED]
    assert len(ours) == 5 and not any(ours["status"])
    walk = 2.0**-53 * np.sqrt(ours["steps"])
    assert np.all(ours["energy_error"] < walk)  # 1e-15 to 8e-15 of 5e-14
    assert ours["steps"].iloc[0] == 200_000 and ours["step"].iloc[0] == 50.0


def test_a_method_that_drifts_does_not_reach_what_is_printed() -> None:
    """The planted fault: two passes in the Kepler frame, which are not symplectic."""
    two = gauss_collocation(8, galvi.KeplerFrame(passes=2))
    seen = published._measured(published.CASES[0], "two passes", two, 400.0, 1)
    assert seen["energy_error"] > 100 * published.CASES[0].energy_error


def test_starts_are_as_published() -> None:
    start = regular_henon_heiles()
    energy = start.system.potential_energy(start.q0, 0.0) + 0.5 * start.v0 @ start.v0
    assert abs(energy - 1.0 / 12.0) < 1e-16
    if states.missing():
        pytest.skip(states.missing())
    sky, problem = states.ephemeris(EPOCH), outer_planets_of_1969()
    for k, name in enumerate(problem.parameters["bodies"][1:], start=1):
        own = np.concatenate([[problem.system.masses[k]], problem.q0[k], problem.v0[k]])
        assert np.array_equal(own, sky[name])
    inner = np.array(list(sky.values())[:5])
    for exact, ours in ((inner[:, 1:4], problem.q0), (inner[:, 4:], problem.v0)):
        centre = inner[:, 0] @ exact / np.sum(inner[:, 0])
        assert np.allclose(ours[0], centre, rtol=1e-15, atol=1e-20)


def test_the_long_form_keeps_its_rows(tmp_path: Path) -> None:
    cases = [replace(case, steps=1000, ours=case.ours[:1]) for case in published.CASES]
    parts = published.parts(tmp_path, print, cases, code="0123456789ab")
    assert [part.done() for part in parts] == [False, False]
    parts[0].run(print)
    assert [part.done() for part in parts] == [True, False]
    rows = published.stored(tmp_path, print)
    assert rows["commit"].tolist() == ["0123456789ab"] and rows["steps"].tolist() == [1000.0]


@pytest.fixture(scope="module")
def table() -> pd.DataFrame:
    if jpl.missing():
        pytest.skip(jpl.missing())
    return ephemeris.ephemeris_table()


def test_every_body_has_a_row_for_every_time(table: pd.DataFrame) -> None:
    assert tuple(table.columns) == ephemeris.COLUMNS
    assert len(table) == 2 * 10 * len(ephemeris.DAYS)
    assert not table.duplicated(["contender", "body", "days"]).any()
    assert table[table["body"] != "Sun"].notna().all(axis=None)


def test_the_run_is_converged(table: pd.DataFrame) -> None:
    planets = table[table["body"] != "Sun"]
    assert table["integration_error_au"].max() < 2e-12  # 3e-13 when this was written
    floor = 2e-14  # some ulps of the outer planets' places
    assert (planets["integration_error_au"] < 1e-4 * planets["difference_au"] + floor).all()


def test_the_differences_are_of_the_size_that_relativity_explains(table: pd.DataFrame) -> None:
    inner = table[table["body"].isin(["Mercury", "Venus", "Earth", "Mars"])]
    assert inner["difference_au"].between(1e-7, 1e-4).all()
    ratio = inner["difference_au"] / inner["relativity_au"]
    assert ratio.between(0.85, 1.15).all()
    outer = table[table["body"].isin(["Saturn", "Uranus", "Neptune", "Pluto"])]
    assert (outer["difference_au"] < 1e-6).all()


def test_the_angle_is_the_one_that_the_distance_allows(table: pd.DataFrame) -> None:
    """From the Sun, whose own place differs too: Mercury is between 0.3 and 0.5 au away."""
    mercury = table[table["body"] == "Mercury"]
    seen = mercury["difference_arcsec"] * ephemeris.ARC_SECOND
    assert (seen <= mercury["difference_au"] / 0.3).all()


def test_without_the_ephemeris_it_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(jpl, "missing", lambda: "Install jplephem and de421.")
    with pytest.raises(ModuleNotFoundError, match="Install jplephem"):
        ephemeris.ephemeris_table()
