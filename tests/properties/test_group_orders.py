"""Orders of runs on groups from both sides, the two kernels, and faults that orders catch."""

import numpy as np
import pytest

import galvi
from galvi.charts import CHARTS
from galvi.run.in_lanes import lagrangian as law_stepper
from references.closed_forms.top_motion import FREE_TOP
from tests.properties.group_motions import (
    CAYLEY,
    EXPONENTIAL,
    FREE,
    PENDULUM,
    RODRIGUES,
    WINDOWS,
    collocation,
    each_chart,
    error,
    hall,
    slope,
    spoiled,
    swung,
    turned,
)


@each_chart
@pytest.mark.parametrize("degree", WINDOWS)
def test_the_order_is_twice_the_degree_no_less_and_no_more(degree, chart):
    """n = degree + 1 of H is 3 to 6; packed and with one point more; against scipy."""
    more = (degree + CHARTS.index(chart)) % 2
    method = galvi.Galerkin(galvi.Polynomials(degree), galvi.gauss(degree + more), chart)
    assert method.order == 2 * degree
    measured = slope(PENDULUM, swung(), method, *WINDOWS[degree])
    assert 2 * degree - 0.5 < measured < 2 * degree + 0.5, measured  # off by 0.4 at most, at 10


@pytest.mark.parametrize(
    ("degree", "chart", "window"),
    [(2, RODRIGUES, (48, 200)), (3, CAYLEY, (24, 64)), (4, EXPONENTIAL, (18, 26)),
     (5, CAYLEY, (20, 28))],
)  # fmt: skip
def test_the_order_is_so_too_against_the_closed_form_of_the_free_body(degree, chart, window):
    measured = slope(FREE, turned(), collocation(degree, chart), *window)
    assert 2 * degree - 0.5 < measured < 2 * degree + 0.5, measured


@pytest.mark.slow(beside="test_the_order_is_so_too_against_the_closed_form_of_the_free_body")
def test_halls_method_at_half_a_unit_reaches_1e_12():
    """n = 12, h = 0.5, T = 5 (H fig. 3.1; claim L2)."""
    truth = FREE_TOP.run(FREE, 5.0, {"samples": 1})
    found = {n: error(galvi.integrate(FREE, hall(n), 0.5, 10), (truth.q[-1], truth.p[-1]))
             for n in (6, 8, 10, 12)}  # fmt: skip
    assert found[12] < 1e-12  # 6e-14
    assert found[10] < 1e-10 and found[8] < 1e-7 and found[6] > 1e-6  # 3e-11, 2e-8, 2e-5


def test_a_spoiled_table_is_caught_by_the_order():
    good, bent = hall(4), spoiled(hall(4), integral=1.0 + 1e-6 * np.arange(16).reshape(4, 4))
    assert slope(PENDULUM, swung(), good, *WINDOWS[3]) > 5.5
    assert slope(PENDULUM, swung(), bent, *WINDOWS[3]) < 5.0
    square = spoiled(collocation(3), integral=1.0 + 1e-6 * np.arange(9).reshape(3, 3))
    assert slope(PENDULUM, swung(), square, *WINDOWS[3]) < 5.0


def test_forces_that_do_not_belong_to_the_moves_are_caught_by_symplecticity(monkeypatch):
    """Any table makes a variational method; one without B_jk = b_k - A_kj b_k / b_j does not."""
    sound = law_stepper.tables_on_group

    def mismatched(table, form):
        made, tables = sound(table, form), sound(table, form).tables.copy()
        P = tables.shape[1]
        tables[2 * P : 3 * P] *= 1.0 + 1e-5 * np.arange(P)
        return made._replace(tables=tables)

    assert galvi.symplecticity_defect(PENDULUM, collocation(3), 0.2) < 2e-12  # 4e-15
    monkeypatch.setattr(law_stepper, "tables_on_group", mismatched)
    assert galvi.symplecticity_defect(PENDULUM, collocation(3), 0.2) > 1e-9


def test_a_wrong_torque_is_caught_by_the_truth_and_by_the_energy():
    weight = -PENDULUM.system.potential.numbers[2]
    gradient = np.zeros((3, 3))
    gradient[2, 2] = weight
    for factor in (1.0, 1.0 + 1e-6):
        system = galvi.RigidBody(
            PENDULUM.system.inertia, PENDULUM.system.potential, lambda R, f=factor: f * gradient
        )
        problem = galvi.Problem(system, PENDULUM.q0, PENDULUM.v0)
        run = galvi.integrate(problem, collocation(8), 0.2, 20)
        sound = factor == 1.0
        assert (error(run, swung()) < 1e-12) == sound
        assert (np.ptp(galvi.energy(run)) < 1e-11) == sound
