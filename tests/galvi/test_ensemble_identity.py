"""Files of an ensemble are read again only for the same work, told apart by values."""

from __future__ import annotations

import functools
import json
import math
import os
import subprocess
import sys
import threading
from pathlib import Path

import numba
import numpy as np
import pytest

import galvi
from galvi.run.ensembles.identity import identity

FOUR = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4))
K, TABLE = 2.0, np.arange(3.0)


def stiffness():
    return K


def scaled(x, *, factor=1.0):
    return factor * stiffness() * x + TABLE[0]


def even(n):
    return n == 0 or odd(n - 1)


def odd(n):
    return n != 0 and even(n - 1)


class Weight:
    """What a caller may define."""

    def __init__(self, value):
        self.value = value

    def times(self, x):
        return self.value * x


@numba.njit
def compiled(x):
    return K * x


SAMPLES = {
    "function": scaled, "recursion": even, "method": Weight(1.0).times, "object": Weight(2.0),
    "partial": functools.partial(scaled, factor=2.0), "compiled": compiled, "ufunc": np.sin,
    "numpy": np.mean, "builtin": math.sin, "class": Weight, "set": {"a", "b", "c"},
    "method of galvi": FOUR, "lambda": lambda run: [scaled(x) for x in run.q],
    "system": galvi.problems.double_pendulum().system,
}  # fmt: skip


def test_samples_are_told_apart_and_are_the_same_in_another_process():
    found = {name: repr(identity(value)) for name, value in SAMPLES.items()}
    assert len(set(found.values())) == len(SAMPLES)
    code = (
        "import json; from tests.galvi import test_ensemble_identity as t; "
        "print(json.dumps({k: repr(t.identity(v)) for k, v in t.SAMPLES.items()}))"
    )
    root = Path(__file__).parents[2]
    environment = os.environ | {"PYTHONHASHSEED": "7", "PYTHONPATH": str(root)}
    output = subprocess.run(
        [sys.executable, "-c", code], env=environment, cwd=root, capture_output=True, check=True
    )
    assert json.loads(output.stdout.splitlines()[-1]) == found


def changed_keyword(monkeypatch):
    monkeypatch.setitem(scaled.__kwdefaults__, "factor", 3.0)


@pytest.mark.parametrize(
    ("name", "change"),
    [
        ("function", lambda patch: patch.setitem(globals(), "K", 3.0)),  # of a function it calls
        ("lambda", lambda patch: patch.setitem(globals(), "K", 3.0)),
        ("compiled", lambda patch: patch.setitem(globals(), "K", 3.0)),
        ("function", lambda patch: patch.setitem(globals(), "TABLE", np.ones(3))),
        ("function", lambda patch: patch.setitem(globals(), "stiffness", lambda: 2.0)),
        ("function", changed_keyword),
        ("recursion", lambda patch: patch.setitem(globals(), "odd", lambda n: False)),
        ("method", lambda patch: patch.setattr(SAMPLES["method"].__self__, "value", 5.0)),
        ("object", lambda patch: patch.setattr(SAMPLES["object"], "value", 5.0)),
        ("object", lambda patch: patch.setattr(Weight, "times", lambda self, x: x)),
        ("function", lambda patch: patch.setattr(scaled, "mark", 1, raising=False)),
    ],
)
def test_what_a_result_depends_on_is_seen(name, change, monkeypatch):
    before = identity(SAMPLES[name])
    change(monkeypatch)
    assert identity(SAMPLES[name]) != before
    monkeypatch.undo()
    assert identity(SAMPLES[name]) == before


def test_objects_at_reused_addresses_are_told_apart():
    assert len({repr(identity(Weight(float(k)).times)) for k in range(40)}) == 40


def test_what_cannot_be_told_apart_is_refused():
    with pytest.raises(ValueError, match=r"must be told from other work.*lock"):
        identity([threading.Lock()])


def traced(force):
    system = galvi.Canonical(1.0, lambda q: 0.5 * K * (q @ q), force=force)
    return galvi.Problem(system, [1.0, 0.5], [0.0, 0.2])


def ensemble(folder, **options):
    problem = traced(None)
    return galvi.integrate_ensemble(
        problem, problem.q0, problem.v0, FOUR, 0.1, 3, folder=folder, **options
    )


def test_a_number_of_a_traced_law_is_part_of_its_work(tmp_path, monkeypatch):
    first = np.array(ensemble(tmp_path)[0])
    monkeypatch.setitem(globals(), "K", 3.0)
    assert np.array_equal(ensemble(tmp_path)[0], ensemble(None)[0])
    assert not np.array_equal(ensemble(tmp_path)[0], first)


def test_parameters_with_the_names_of_starts_hide_none(tmp_path):
    import sympy

    x, vx, q = sympy.symbols("x vx q", real=True)
    system = galvi.Lagrangian.from_sympy(vx**2 / 2 - q * x**2 / 2, [x], [vx], parameters={q: 1.0})
    problem = galvi.Problem(system, [1.0], [0.0])

    def end(start):
        found = galvi.integrate_ensemble(
            problem, [[start]], problem.v0, FOUR, 0.1, 2, {"q": [2.0]}, folder=tmp_path
        )
        return found[0][0, 0]

    assert end(1.0) == pytest.approx(0.5 * end(2.0), rel=1e-12)


def test_a_damaged_note_of_the_ensemble_is_written_again(tmp_path):
    first = ensemble(tmp_path)
    (note,) = tmp_path.glob("*.json")
    for damage in ("", "{", "[]", '{"members": "x"}', '{"members": 0}'):
        note.write_text(damage)
        assert np.array_equal(ensemble(tmp_path)[0], first[0])
        assert json.loads(note.read_text())["members"] > 0


@pytest.mark.parametrize("keep", [galvi.StatesAt([]), lambda run: np.zeros(0)])
def test_values_without_entries_are_kept_too(keep, tmp_path):
    shapes = {ensemble(tmp_path, keep=keep).kept[0].shape for _ in range(2)}
    assert shapes == {ensemble(None, keep=keep).kept[0].shape}
