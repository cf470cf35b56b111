"""A method of galvi answers the same questions as a reference."""

from __future__ import annotations

import numpy as np
import pytest

import galvi
from benchmarks.work_precision.galvi_methods import Variational, gauss_collocation
from references import Contender
from references.closed_forms.kepler import KEPLER


def test_a_method_is_a_contender() -> None:
    contender = gauss_collocation(6)
    assert isinstance(contender, Contender)
    assert contender.name.startswith("galvi")
    assert contender.missing == "" and contender.exact is False
    assert contender.supports(galvi.problems.kepler()) and contender.supports(
        galvi.problems.solar_system()
    )


def test_it_runs_like_any_other_and_agrees_with_the_truth() -> None:
    problem = galvi.problems.kepler(0.3)
    run = gauss_collocation(10).run(problem, 10.0, {"step": 0.25, "save_every": 20})
    truth = KEPLER.run(problem, 10.0, {"samples": 2})
    assert run.t == pytest.approx(truth.t, abs=1e-14)
    assert np.max(np.abs(run.q - truth.q)) < 1e-11  # 3e-13 when this was written
    assert run.curves is None


def test_settings_reach_the_integrator_and_wrong_ones_are_refused() -> None:
    problem, contender = galvi.problems.kepler(0.3), gauss_collocation(4)
    newton = contender.run(problem, 1.0, {"step": 0.5, "solver": "newton"})
    assert newton.counts["hessian_evaluations"] > 0
    backwards = contender.run(problem, -1.0, {"step": -0.5})
    assert backwards.t.tolist() == [0.0, -0.5, -1.0]
    with pytest.raises(ValueError, match="Did you mean 'step'"):
        contender.run(problem, 1.0, {"stp": 0.5})
    with pytest.raises(ValueError, match="whole number of steps"):
        contender.run(problem, 1.0, {"step": 0.3})


def test_any_method_can_be_wrapped() -> None:
    verlet = Variational(galvi.Galerkin(galvi.Polynomials(1), galvi.lobatto(2)))
    assert verlet.name == f"galvi {verlet.method.name}"
