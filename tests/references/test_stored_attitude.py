"""The stored truths of heavy bodies: whose they are, and that others come to the same."""

from __future__ import annotations

import numpy as np
import pytest

import galvi
from references.heyoka.rigid import HEYOKA_RIGID_QUADRUPLE
from references.scipy.rigid_ivp import RIGID_DOP853
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
