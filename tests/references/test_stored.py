"""Stored truths: bodies, planets, provenance."""

from __future__ import annotations

import hashlib
import importlib
from importlib import resources
from pathlib import Path

import numpy as np
import pytest

import galvi
from references.heyoka.rigid import HEYOKA_RIGID_QUADRUPLE
from references.jpl import states as jpl
from references.scipy.rigid_ivp import RIGID_DOP853
from references.stored import provenance
from references.stored.attitude import STORED_ATTITUDE
from references.stored.planets import FOLDER
from references.textbook.quaternions import QUATERNION_DOP853

PENDULUM, HORIZON = STORED_ATTITUDE.cases["pendulum_3d"]


def test_it_is_kept_for_its_problem_and_no_other():
    assert STORED_ATTITUDE.supports(PENDULUM)
    others = (
        galvi.problems.pendulum_3d(weight=np.nextafter(9.81, 10.0)),
        galvi.problems.pendulum_3d(inverted=True),
        galvi.problems.heavy_top(spin=np.nextafter(8.0, 9.0)),
        galvi.problems.free_rigid_body(),
        PENDULUM.with_initial_state(PENDULUM.q0, np.nextafter(PENDULUM.v0, 9.0)),
    )
    assert not any(STORED_ATTITUDE.supports(other) for other in others)


def test_times_that_are_not_kept_are_refused():
    for duration, setting in ((HORIZON, {"samples": 3}), (-1.0, {}), (2 * HORIZON, {})):
        with pytest.raises(ValueError, match=r"is kept every 0\.5 up to 20 .* received a sample"):
            STORED_ATTITUDE.run(PENDULUM, duration, setting)


@pytest.mark.parametrize(
    ("peer", "tolerance", "bound"),
    [(QUATERNION_DOP853, 1e-15, 1e-12), (RIGID_DOP853, 1e-12, 2e-10)],  # 1.7e-13, 2.5e-11: the top
    ids=lambda value: getattr(value, "name", None),
)
@pytest.mark.parametrize("case", STORED_ATTITUDE.cases)
def test_other_methods_on_other_coordinates_come_to_it(peer, tolerance, bound, case):
    problem, horizon = STORED_ATTITUDE.cases[case]
    bound *= 1.0 if case == "heavy_top" else 0.1  # the pendulum: 2.0e-14, 2.6e-12
    samples = 40
    truth = STORED_ATTITUDE.run(problem, horizon, {"samples": samples})
    run = peer.run(problem, horizon, {"samples": samples, "tolerance": tolerance})
    assert np.max(np.abs(run.q - truth.q)) < bound
    assert np.max(np.abs(run.p - truth.p)) < 10.0 * bound


def test_it_conserves_energy_and_vertical_momentum_and_is_a_rotation():
    run = STORED_ATTITUDE.run(PENDULUM, HORIZON, {"samples": 40})
    energy = galvi.energy(run)
    assert np.max(np.abs(energy / energy[0] - 1.0)) < 2e-15  # 7e-16: the states are rounded
    assert np.max(galvi.orthogonality_defect(run)) < 1e-15
    vertical = np.einsum("ti,ti->t", run.q[:, 2], run.p)
    assert np.max(np.abs(vertical - vertical[0])) < 2e-15


@pytest.mark.skipif(
    bool(HEYOKA_RIGID_QUADRUPLE.missing), reason=HEYOKA_RIGID_QUADRUPLE.missing or "present"
)
@pytest.mark.parametrize("case", STORED_ATTITUDE.cases)
def test_it_can_be_made_again(case):
    kept = (FOLDER / f"{case}.csv").read_text("ascii").splitlines()
    made = STORED_ATTITUDE.table(case).splitlines()
    rows = [i for i, line in enumerate(kept) if not line.startswith("# source")]
    assert [made[i] for i in rows] == [kept[i] for i in rows]


def test_every_file_has_its_engine_command_and_hash() -> None:
    found = {one["file"]: one for one in provenance.truths()}
    assert set(found) == {path.name for path in FOLDER.iterdir()}
    for name, one in found.items():
        assert list(one) == list(provenance.HEADINGS)
        assert one["engine"].startswith("heyoka ") and "real128" in one["engine"]
        assert one["SHA-256"] == hashlib.sha256((FOLDER / name).read_bytes()).hexdigest()
        module, case = one["made by"].removeprefix("python -m ").split()[:2]
        assert f"{case}.csv" == name and importlib.util.find_spec(module) is not None


def test_a_changed_digit_has_another_hash(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    name = "henon_heiles.csv"
    text = (FOLDER / name).read_text()
    (tmp_path / name).write_text(text[:-2] + str((int(text[-2]) + 1) % 10) + "\n")
    (before,) = [one for one in provenance.truths() if one["file"] == name]
    monkeypatch.setattr(provenance, "FOLDER", tmp_path)
    (after,) = provenance.truths()
    assert after["SHA-256"] != before["SHA-256"]


BODIES = (
    *("Sun", "Mercury", "Venus", "Earth", "Mars"),
    *("Jupiter", "Saturn", "Uranus", "Neptune", "Pluto"),
)
DATA = resources.files("galvi") / "problems" / "data" / "solar_system.csv"


def test_the_stored_file_is_what_its_command_writes():
    if jpl.missing():
        pytest.skip(jpl.missing())
    stored, made = DATA.read_text("ascii").splitlines(), jpl.table(jpl.ephemeris()).splitlines()
    assert len(stored) == len(made)
    for old, new in zip(stored, made, strict=True):
        if "," not in old or old.startswith(("#", "body")):
            assert old == new
            continue
        assert old.split(",")[0] == new.split(",")[0]
        numbers = [np.array([float(x) for x in line.split(",")[1:]]) for line in (old, new)]
        np.testing.assert_allclose(*numbers, rtol=1e-14)  # sums may be ordered otherwise elsewhere


def test_the_problem_holds_the_file_to_the_last_digit():
    problem = galvi.problems.solar_system()
    rows = np.genfromtxt(DATA.read_text("ascii").splitlines()[6:], delimiter=",", skip_header=1)
    assert np.array_equal(problem.system.masses, rows[:, 1])
    assert np.array_equal(problem.q0, rows[:, 2:5]) and np.array_equal(problem.v0, rows[:, 5:])
    assert problem.parameters["bodies"] == BODIES
    assert problem.system.G == 1.0 and "au^3/day^2" in problem.units


def test_without_pluto_there_are_nine_bodies():
    problem = galvi.problems.solar_system(pluto=False)
    assert problem.q0.shape == (9, 3) and problem.parameters["bodies"] == BODIES[:-1]


def test_the_planets_are_where_almanacs_have_them():
    problem = galvi.problems.solar_system()
    masses, q, v = problem.system.masses, problem.q0, problem.v0
    distance = np.linalg.norm(q[1:] - q[0], axis=1)
    known = [0.466, 0.720, 0.983, 1.391, 4.965, 9.184, 19.924, 30.121, 30.223]  # au, 2000-01-01
    np.testing.assert_allclose(distance, known, atol=1e-3)
    semi_axis = 1.0 / (
        2.0 / distance - np.sum((v[1:] - v[0]) ** 2, axis=1) / (masses[0] + masses[1:])
    )
    mean = [0.3871, 0.7233, 1.0000, 1.5237, 5.203, 9.54, 19.19, 30.07, 39.5]  # Standish, J2000
    np.testing.assert_allclose(semi_axis, mean, rtol=0.01)
    ratio = masses[0] / masses[1:]  # IAU 1976-2009
    inverse = [6.0236e6, 408523.7, 328900.56, 3098708, 1047.3486, 3497.9, 22903, 19412.2, 1.36e8]
    np.testing.assert_allclose(ratio, inverse, rtol=2e-3)
    gauss = 0.01720209895**2
    np.testing.assert_allclose(masses[0], gauss, rtol=1e-9)


def test_the_barycentre_is_at_rest_at_the_origin_but_for_what_is_left_out():
    problem = galvi.problems.solar_system()
    total = np.sum(problem.system.masses)
    centre = problem.system.masses @ problem.q0 / total
    drift = np.sum(problem.p0, axis=0) / total
    assert np.linalg.norm(centre) < 1e-8  # au; 2e-9: asteroids and relativity
    assert np.linalg.norm(drift) < 1e-10  # au / day; 7e-12
