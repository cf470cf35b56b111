"""Files that are no saved run, or one whose parts do not fit, are refused in one sentence."""

import json

import numpy as np
import pytest

import galvi

FOUR = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4))
RUNS = {
    "point mass": lambda: galvi.integrate(galvi.problems.kepler(0.3), FOUR, 0.1, 20),
    "body": lambda: galvi.integrate(galvi.problems.pendulum_3d(), FOUR, -0.02, 20),
    "without curves": lambda: galvi.integrate(
        galvi.problems.kepler(0.3), FOUR, 0.1, 20, save_every=5
    ),
}
REFUSED = "must be a run written by galvi.save; some of it is missing or does not fit"


def of_facts(change):
    def changed(arrays):
        facts = json.loads(str(arrays["facts"]))
        change(facts)
        return {**arrays, "facts": np.array(json.dumps(facts))}

    return changed


ODD = {
    "times in falling order": lambda arrays: {**arrays, "t": arrays["t"][::-1]},
    "fewer configurations than times": lambda arrays: {**arrays, "q": arrays["q"][:3]},
    "a state of another shape": lambda arrays: {**arrays, "state": arrays["state"][:, :1]},
    "stages of another shape": lambda arrays: {**arrays, "stages": arrays["stages"][:1]},
    "a state of whole numbers": lambda arrays: {**arrays, "state": arrays["state"].astype(int)},
    "no solver state": lambda arrays: {k: v for k, v in arrays.items() if k != "solver_state"},
    "a step of 0": of_facts(lambda facts: facts.update(step=0.0)),
    "no counts": of_facts(lambda facts: facts.pop("counts")),
}


@pytest.mark.parametrize("odd", ODD)
@pytest.mark.parametrize("name", RUNS)
def test_a_file_whose_parts_do_not_fit_is_refused(name, odd, tmp_path):
    path = tmp_path / "run.npz"
    galvi.save(RUNS[name](), path)
    with np.load(path) as file:
        arrays = {key: file[key] for key in file.files}
    np.savez(path, **ODD[odd](arrays))
    with pytest.raises(ValueError, match=REFUSED):
        galvi.load(path)
    np.savez(path, **arrays)
    assert galvi.load(path).success


@pytest.mark.parametrize("part", ["bases", "coefficients"])
def test_curves_of_another_shape_are_refused(part, tmp_path):
    path = tmp_path / "run.npz"
    galvi.save(RUNS["point mass"](), path)
    with np.load(path) as file:
        arrays = {key: file[key] for key in file.files}
    np.savez(path, **{**arrays, part: arrays[part][:, :1][:7]})
    with pytest.raises(ValueError, match=REFUSED):
        galvi.load(path)


def test_masked_entries_are_refused():
    masked = np.ma.array([1.0, 0.0], mask=[False, True])
    system = galvi.problems.kepler(0.3).system
    with pytest.raises(ValueError, match=r"^q0 must have no masked entries; received 1 of them"):
        galvi.Problem(system, masked, [0.0, 1.0])
    assert galvi.Problem(system, np.ma.array([1.0, 0.0]), [0.0, 1.0]).q0.tolist() == [1.0, 0.0]


def test_a_file_of_another_format_is_refused_with_the_remedy(tmp_path):
    path = tmp_path / "run.npz"
    galvi.save(RUNS["point mass"](), path)
    with np.load(path) as file:
        arrays = {key: file[key] for key in file.files}
    np.savez(path, **of_facts(lambda facts: facts.update(version=3))(arrays))
    with pytest.raises(ValueError, match=r"run.npz must have format \d+; received format 3. Run "):
        galvi.load(path)
