"""`galvi.convergence`: orders, invariants and cost of methods on a problem of one's own."""

import warnings

import numpy as np
import pandas as pd
import pytest

import galvi

pytestmark = pytest.mark.usefixtures("suite_in_this_process")

KEPLER = galvi.problems.kepler(0.3)
COUNTS = [20, 40, 80, 160]
FOREST_RUTH_CONSTANT = 2.0 ** (1 / 3)


def potential(q):
    return 0.5 * np.log(0.1 + q[0] ** 2 + (q[1] / 0.9) ** 2)


def gradient(q):
    return np.array([q[0], q[1] / 0.81]) / (0.1 + q[0] ** 2 + (q[1] / 0.9) ** 2)


GALAXY = galvi.Problem(
    galvi.Canonical(1.0, potential, gradient), [0.9, 0.0], [0.0, 0.8], name="galaxy"
)


class ForestRuth:
    """Drifts and kicks, which each sum to a step; of order 4 for this constant alone."""

    name, order, constant = "my Forest-Ruth", 4, FOREST_RUTH_CONSTANT

    @property
    def parts(self):
        a, b = np.array([1.0, -self.constant]) / (2.0 - self.constant)
        return (a / 2, a), ((a + b) / 2, b), ((a + b) / 2, a), (a / 2, 0.0)

    def supports(self, problem):
        return isinstance(problem.system, (galvi.Canonical, galvi.NBody))

    def run(self, problem, duration, setting):
        h, save_every, q, v = setting["step"], setting["save_every"], problem.q0, problem.v0
        t, saved = problem.t0, [(q, v)]
        for k in range(round(duration / h)):
            for drift, kick in self.parts:
                q, t = q + h * drift * v, t + h * drift
                v = v + h * kick * problem.system.acceleration(q, t)
            saved += [(q, v)] if (k + 1) % save_every == 0 else []
        q, v = np.swapaxes(saved, 0, 1)
        times = problem.t0 + h * save_every * np.arange(len(q))
        return galvi.Trajectory(problem, times, q, problem.system.momentum(v), counts={"steps": k})


class WrongConstant(ForestRuth):
    constant = 1.2


class NotSymmetric(ForestRuth):
    """Symplectic Euler."""

    order, parts = 1, ((0.0, 1.0), (1.0, 0.0))


class Raises(ForestRuth):
    def run(self, problem, duration, setting):
        raise RuntimeError("no luck")


def gauss(points, **options):
    return galvi.Galerkin(galvi.Polynomials(points), galvi.gauss(points), **options)


def table(methods, steps=COUNTS, problem=KEPLER, duration=5.0, **options):
    return galvi.convergence(problem, methods, steps, duration, quick=True, **options)


def fitted_orders(rows):
    """A dict from each method to its fitted order and the standard error."""
    return {
        name: tuple(rows[["fitted", "fitted_se"]].iloc[0])
        for name, rows in rows.groupby("method", sort=False)
    }


@pytest.fixture(scope="module")
def kepler_rows():
    """The table of galvi, a reference, a user's integrator and an adaptive code."""
    methods = {
        "degree 2": gauss(2),
        "Verlet": "textbook.stormer_verlet",
        "mine": ForestRuth,
        "DOP853": "scipy.dop853",
    }
    return table(methods, [40, 80, 160, 320])


@pytest.mark.parametrize(("name", "order"), [("degree 2", 4.0), ("Verlet", 2.0), ("mine", 4.0)])
def test_orders_of_galvi_and_of_others_in_one_table(kepler_rows, name, order):
    value, error = fitted_orders(kepler_rows)[name]
    assert abs(value - order) < max(0.1, 3.0 * error) and error < 0.3


def test_each_run_of_the_table_has_what_it_kept_and_how_it_ended(kepler_rows):
    rows = kepler_rows
    equal, adaptive = rows[rows["h"].notna()], rows[rows["h"].isna()]
    assert set(equal["h"]) == {5.0 / n for n in (40, 80, 160, 320)}
    assert (
        set(adaptive["method"]) == {"DOP853"}
        and adaptive["order"].isna().all()
        and len(adaptive) >= 4
    )
    assert (rows["outcome"] == "completed").all() and (rows["seconds"] > 0.0).all()
    assert equal["momentum"].max() < 1e-12 and equal["symplecticity"].max() < 1e-10
    assert equal["symmetry"].max() < 1e-11
    assert rows.attrs["truth"].startswith("Kepler, closed form") and not rows.attrs["faults"]
    energies = rows[rows["method"] == "Verlet"]["energy"].to_numpy()
    assert np.all(np.diff(energies) < 0.0)


def test_the_columns_are_those_of_the_documentation(kepler_rows):
    text = galvi.convergence.__doc__.partition("``method, ")[2].partition("``")[0]
    assert list(kepler_rows.columns) == ["method", *(word.strip() for word in text.split(","))]
    assert isinstance(kepler_rows, pd.DataFrame) and kepler_rows["fit"].dtype == bool


def test_a_wrong_constant_has_order_two_and_a_false_symmetry_is_seen():
    methods = {"wrong": WrongConstant(), "not": NotSymmetric(), "right": ForestRuth()}
    rows = table(methods, [100, 200, 400])
    assert fitted_orders(rows)["wrong"][0] == pytest.approx(2.0, abs=0.2)
    assert rows[rows["method"] == "not"]["symmetry"].min() > 1e-4
    assert rows[rows["method"] == "wrong"]["symmetry"].max() < 1e-11
    (remark,) = rows.attrs["remarks"]
    assert remark.startswith("wrong has the order 4 at small steps, by theory, and 2.")


def test_a_potential_of_ones_own_has_a_truth_that_another_code_confirms():
    rows = table({"degree 3": gauss(3), "mine": ForestRuth()}, [50, 100, 200, 400], GALAXY, 20.0)
    assert "agrees" in rows.attrs["truth"] or "quadruple" in rows.attrs["truth"]
    assert rows.attrs["truth_error"] < 1e-11
    for name, order in (("degree 3", 6.0), ("mine", 4.0)):
        value, error = fitted_orders(rows)[name]
        assert abs(value - order) < max(0.2, 3.0 * error)
    assert rows["momentum"].isna().all()  # no rotation leaves this potential as it is


def test_on_groups_frames_and_clocks():
    body = table({"Cayley": gauss(2)}, [20, 40, 80], galvi.problems.free_rigid_body())
    assert fitted_orders(body)["Cayley"][0] == pytest.approx(4.0, abs=0.2)
    assert body["symplecticity"].max() < 1e-10 and body["momentum"].max() < 1e-12
    outer = galvi.problems.outer_solar_system()
    framed = table({"frame": gauss(1, chart=galvi.KeplerFrame())}, [10, 20, 40, 80], outer, 8000.0)
    assert fitted_orders(framed)["frame"][0] == pytest.approx(2.0, abs=0.2)
    clock = table(
        {"clock": gauss(2, clock=galvi.Sundman())}, [10, 20, 40, 80], galvi.problems.kepler(0.8)
    )
    assert fitted_orders(clock)["clock"][0] == pytest.approx(4.0, abs=0.4)
    assert clock["symplecticity"].max() < 1e-9


def test_a_truth_that_is_given():
    methods = {"degree 2": gauss(2)}
    exact = table(methods)["error"].to_numpy()
    end = galvi.integrate(KEPLER, gauss(12), 0.05, 100).q[-1]
    for truth in (lambda t: end, end, "scipy.dop853"):
        assert table(methods, truth=truth)["error"].to_numpy() == pytest.approx(exact, abs=1e-9)
    assert fitted_orders(table(methods, truth=end + 1e-3))["degree 2"][0] != pytest.approx(
        4.0, abs=0.2
    )


def test_a_method_that_raises_is_failed_and_the_others_go_on():
    rows = table({"bad": Raises, "good": gauss(2)})
    bad, good = (rows[rows["method"] == name] for name in ("bad", "good"))
    assert (bad["outcome"] == "failed").all() and bad["note"].str.contains("no luck").all()
    assert bad[["error", "energy", "seconds"]].isna().all(axis=None)
    assert (good["outcome"] == "completed").all()


class OffersNothing(ForestRuth):
    def settings(self, problem, duration):
        return []


def test_steps_are_numbers_or_sizes_and_methods_have_the_names_that_they_are_given():
    names = {"textbook.rk4": "textbook.rk4", "a": gauss(1)}
    by_number, by_size = table(names, [20, 40]), table(names, [0.25, 0.1 + 0.15, 0.125])
    assert list(by_number["method"]) == list(by_size["method"]) and len(by_size) == 4
    assert set(by_size["method"]) == set(names)
    assert list(by_number["h"]) == list(by_size["h"]) == 2 * [0.25, 0.125]
    assert list(by_number["error"]) == list(by_size["error"])


def test_steps_are_found_by_trying():
    rows = table({"degree 4": gauss(4)}, None)
    assert fitted_orders(rows)["degree 4"][0] == pytest.approx(8.0, abs=0.5)


def raises(t):
    raise KeyError("oops")


@pytest.mark.parametrize(
    ("arguments", "error", "fragments"),
    [
        ((1, {"a": gauss(1)}, [4], 1.0), TypeError, ["problem", "galvi.Problem"]),
        ((KEPLER, {}, [4], 1.0), TypeError, ["methods", "at least one"]),
        ((KEPLER, {"a": 3}, [4], 1.0), TypeError, ["methods", "'a': 3"]),
        ((KEPLER, {"a": gauss(1)}, [], 1.0), ValueError, ["steps", "none"]),
        ((KEPLER, {"a": gauss(1)}, [0], 1.0), ValueError, ["number of steps", "0"]),
        ((KEPLER, {"a": gauss(1)}, 4, 1.0), TypeError, ["steps", "4"]),
        ((KEPLER, {"a": gauss(1)}, [0.3, 0.1], 1.0), ValueError, ["whole number", "0.3"]),
        ((KEPLER, {"a": gauss(1)}, "20,40", 1.0), TypeError, ["steps"]),
        ((KEPLER, {"a": gauss(1)}, [4], 1.0, raises), ValueError, ["truth(1) raised KeyError"]),
        ((KEPLER, {"a": OffersNothing}, [4], 1.0), ValueError, ["mappings, one at least"]),
        ((KEPLER, {"a": gauss(1)}, [4], -1.0), ValueError, ["duration", "-1.0"]),
        ((KEPLER, {"a": gauss(1)}, [4], 1.0, [1.0]), ValueError, ["truth", "shape"]),
        ((KEPLER, {"a": "mujoco.rk4"}, [4], 1.0), ValueError, ["mujoco.rk4", "Canonical"]),
        ((KEPLER, {"a": "rebound.wfast"}, [4], 1.0), ValueError, ["mean", "rebound.whfast"]),
        ((KEPLER, {"a": "no_such:Class"}, [4], 1.0), ValueError, ["no_such"]),
        ((KEPLER, {"a": gauss(1)}, [4], 1.0, "scipy.dop835"), ValueError, ["scipy.dop853"]),
        (
            (KEPLER, {"a": gauss(1)}, [4], 1.0, "textbook.stormer_verlet"),
            ValueError,
            ["equal steps"],
        ),
    ],
)
def test_what_cannot_be_asked_is_refused_in_a_sentence(arguments, error, fragments):
    with warnings.catch_warnings(), pytest.raises(error) as refused:
        galvi.convergence(*arguments, quick=True)
    text = str(refused.value)
    assert all(word in text for word in fragments), text
    assert text[-1] in ".?" and "Traceback" not in text and "\n" not in text.strip()


def test_the_run_that_is_the_truth_has_no_error():
    outer = galvi.problems.outer_solar_system()
    rows = table({"IAS15": "rebound.ias15", "mine": gauss(2)}, [25, 50, 100], outer, 3652.5)
    assert "IAS15" in rows.attrs["truth"] and rows.attrs["truth_error"] < 1e-13
    itself = rows[rows["note"] == "the truth"]
    assert len(itself) == 1 and itself["error"].isna().all() and (itself["seconds"] > 0.0).all()
    assert fitted_orders(rows)["mine"][0] == pytest.approx(4.0, abs=0.05)
    assert rows["symplecticity"].max() < 1e-9


def test_an_end_at_a_turning_point_does_not_double_the_order():
    spring = galvi.problems.harmonic_oscillator()
    methods = {"Verlet": "textbook.stormer_verlet", "Gauss 2": gauss(2)}
    rows = table(methods, [40, 80, 160, 320], spring, 2.0 * np.pi)
    assert fitted_orders(rows)["Verlet"][0] == pytest.approx(2.0, abs=0.1)
    assert fitted_orders(rows)["Gauss 2"][0] == pytest.approx(4.0, abs=0.1)
    assert not rows.attrs["remarks"]


def damped(q, v):
    return -0.003 * v


def test_what_the_motion_keeps_does_not_depend_on_the_methods_of_the_table():
    system = galvi.Canonical(1.0, potential, gradient, force=damped)
    problem = galvi.Problem(system, [0.9, 0.0], [0.0, 0.8])
    for methods in ({"one": gauss(1)}, {"one": gauss(1), "four": gauss(4)}):
        rows = table(methods, [10, 20], problem, 3.0)
        assert rows[["energy", "momentum"]].isna().all(axis=None)
