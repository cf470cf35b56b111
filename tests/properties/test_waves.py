"""Spaces with cosines and sines: their functions, the rules that they need, exact solutions."""

import numpy as np
import pytest

import galvi
from galvi.spaces.fourier import wave_slopes

T = np.linspace(0.0, 1.0, 301)


@pytest.mark.parametrize(
    ("degree", "harmonics", "frequency"),
    [(1, 1, 2 * np.pi), (3, 2, 5.0), (8, 4, 2 * np.pi), (20, 1, 1.0), (1, 1, 0.01), (2, 8, 60.0)],
)
def test_the_space_holds_its_cosines_and_sines(degree, harmonics, frequency):
    basis = galvi.PolynomialFourier(degree, harmonics, frequency).basis(T)
    for k in range(1, harmonics + 1):
        for wave in (np.cos(k * frequency * T), np.sin(k * frequency * T)):
            fitted = basis @ np.linalg.lstsq(basis, wave, rcond=None)[0]
            assert np.allclose(fitted, wave, rtol=0, atol=2e-13)  # 3e-14
    other_wave = np.cos((harmonics + 0.5) * frequency * T)
    fitted = basis @ np.linalg.lstsq(basis, other_wave, rcond=None)[0]
    assert (np.max(np.abs(fitted - other_wave)) > 1e-3) == (frequency > 1.0)


@pytest.mark.parametrize("harmonics", [1, 3])
def test_fourier_is_the_waves_and_the_constant(harmonics):
    space = galvi.Fourier(harmonics, 4.0)
    waves = [f(4.0 * k * T) for k in range(1, harmonics + 1) for f in (np.cos, np.sin)]
    expected = np.stack([np.ones_like(T), *waves], axis=-1)
    assert np.linalg.matrix_rank(np.hstack([space.basis(T), expected])) == space.dimension


@pytest.mark.parametrize("frequency", [0.01, 2 * np.pi, 60.0])
@pytest.mark.parametrize("degree", [1, 6])
def test_slopes_are_orthonormal_to_each_other_and_orthogonal_to_polynomials(degree, frequency):
    space = galvi.PolynomialFourier(degree, 3, frequency)
    slopes = space.derivative(galvi.gauss(150).nodes)[:, 1:]
    K = slopes.T @ (galvi.gauss(150).weights[:, None] * slopes)
    expected = np.append(1.0 / np.arange(1, 2 * degree, 2), np.ones(6))
    assert np.allclose(K, np.diag(expected), rtol=0, atol=1e-14)  # 9e-16


@pytest.mark.parametrize("degree", [1, 2])
def test_slow_waves_tend_to_polynomials(degree):
    """As w -> 0 the space tends to Polynomials(degree + 2 harmonics), the table as w^2."""
    limit = galvi.Galerkin(galvi.Polynomials(degree + 4), galvi.gauss(10)).table.A
    gaps = [
        np.max(
            np.abs(
                galvi.Galerkin(galvi.PolynomialFourier(degree, 2, w), galvi.gauss(10)).table.A
                - limit
            )
        )
        for w in (0.2, 0.1, 0.05)
    ]
    assert np.allclose(np.diff(np.log2(gaps)), -2.0, atol=0.02)  # -1.9993


@pytest.mark.parametrize(("harmonics", "points"), [(1, 10), (2, 13), (3, 15), (4, 18)])
def test_the_gauss_points_that_the_docstring_names_are_enough_and_fewer_are_not(harmonics, points):
    space = galvi.PolynomialFourier(2, harmonics)
    galvi.Galerkin(space, galvi.gauss(points))
    with pytest.raises(ValueError, match=r"is inconsistent.* Use a rule with more points"):
        galvi.Galerkin(space, galvi.gauss(points - 1))


@pytest.mark.parametrize(("radians_per_step", "g"), [(0.5, 2.0), (2 * np.pi, 0.0), (15.0, 2.0)])
def test_an_oscillator_whose_frequency_the_space_holds_is_solved_exactly(radians_per_step, g):
    """15 radians a step are more than two turns."""
    w = radians_per_step / 0.5
    system = galvi.Canonical(
        1.0, lambda q: 0.5 * w**2 * q[0] ** 2 - g * q[0], lambda q: w**2 * q - g
    )
    problem = galvi.Problem(system, [1.0], [0.5])
    method = galvi.Galerkin(galvi.PolynomialFourier(1, 1, radians_per_step), galvi.gauss(26))
    run = galvi.integrate(problem, method, 0.5, 40)
    t = np.linspace(0.0, 20.0, 333)
    exact = g / w**2 + (1.0 - g / w**2) * np.cos(w * t) + 0.5 * np.sin(w * t) / w
    assert run.success, run.status
    assert np.max(np.abs(run(t)[:, 0] - exact)) < 1e-12  # 1.2e-13
    plain = galvi.integrate(problem, galvi.Galerkin(galvi.Polynomials(3), galvi.gauss(26)), 0.5, 40)
    assert np.max(np.abs(plain(t)[:, 0] - exact)) > 1e-5  # 3.6e-5, as many unknowns


def test_a_body_that_spins_keeps_its_momentum_and_agrees_with_polynomials():
    body = galvi.problems.free_rigid_body()
    waves = galvi.Galerkin(galvi.PolynomialFourier(4, 2, 3.0), galvi.gauss(12))
    plain = galvi.Galerkin(galvi.Polynomials(12), galvi.gauss(12))
    runs = [galvi.integrate(body, method, 0.2, 10) for method in (waves, plain)]
    momentum = galvi.momentum_map(runs[0])
    assert np.max(np.abs(momentum - momentum[0])) < 1e-13
    assert np.max(np.abs(runs[0].q - runs[1].q)) < 1e-12  # 2e-14; Polynomials(4) are 2e-8 away


def test_the_highest_frequency_and_many_harmonics_are_still_orthonormal():
    for skip, harmonics, frequency in ((0, 24, 21.0), (64, 1, 512.0)):
        slopes = wave_slopes(skip, harmonics, frequency)[1]
        gram = slopes.T @ (slopes / (2.0 * np.arange(skip, skip + len(slopes))[:, None] + 1.0))
        assert np.allclose(gram, np.eye(2 * harmonics), rtol=0, atol=1e-14)
