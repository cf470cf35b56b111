"""Import and first run in a new process, memory of long runs, and agreement of two processes."""

import os
import subprocess
import sys

import numpy as np
import pytest

from benchmarks.studies import compile_times, start_up
from benchmarks.studies.start_up import STARTS, started

TRIES = 5  # the first may compile, and other work on the machine may delay a process
# In times that numpy takes to import in the same process, as seconds of a busy machine say little:
# 5.2 to 10.0 and 1.6 to 3.6 in 20 processes each on such a machine when this was written.
LARGEST_IMPORT_RATIO, LARGEST_FIRST_RUN_RATIO = 25.0, 12.0
SLOW_STARTS = STARTS[2:4]  # they load as many files as point masses or a law
DIGESTS = """
import hashlib, galvi
method = galvi.Galerkin(galvi.Polynomials(6), galvi.gauss(7))
problems = galvi.problems
for problem, step, solver in (
    (problems.kepler(0.9), 0.3, "auto"), (problems.kepler(0.6), 1.0, "newton"),
    (problems.henon_heiles(), 0.5, "auto"), (problems.outer_solar_system(), 500.0, "auto"),
):
    run = galvi.integrate(problem, method, step, 40, solver=solver)
    digest = hashlib.sha256(run.q.tobytes() + run.p.tobytes() + run.curves.coefficients.tobytes())
    print(digest.hexdigest(), sorted(run.counts.items()), run.status)
"""


@pytest.fixture(scope="module")
def folder():
    """A folder for the user's functions, which the first process that calls them compiles."""
    with start_up.own_folder() as folder:
        yield folder


@pytest.mark.slow_cases(
    but=["point masses: outer solar system", "spring: harmonic oscillator", "rigid body: free"]
)
@pytest.mark.parametrize(
    "start",
    [
        pytest.param(start, id=start.label, marks=[pytest.mark.slow] * (start in SLOW_STARTS))
        for start in STARTS
    ],
)
def test_import_and_first_run_are_quick_when_all_is_compiled(start, folder):
    imports, firsts = [], []
    for _ in range(TRIES):
        times = started(start, folder)
        imports.append(times.imported / times.numpys)
        firsts.append(times.first / times.numpys)
        if min(imports) < LARGEST_IMPORT_RATIO and min(firsts) < LARGEST_FIRST_RUN_RATIO:
            return
    pytest.fail(f"in imports of numpy: imports {imports}, first runs {firsts}")


@pytest.mark.slow(beside="test_import_and_first_run_are_quick_when_all_is_compiled")
def test_a_first_run_that_compiles_would_be_seen(tmp_path):
    times = started(STARTS[2], tmp_path, cache=str(tmp_path / "cache"))
    assert times.first > 2 * LARGEST_FIRST_RUN_RATIO * times.numpys


@pytest.mark.slow(beside="test_import_and_first_run_are_quick_when_all_is_compiled")
def test_after_warming_nothing_is_left_to_compile(tmp_path):
    settings = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    command = [sys.executable, "-m", "reports", "warm"]
    subprocess.run(command, cwd=start_up.ROOT, env=settings, check=True, capture_output=True)

    def compiled():
        return {path.name for path in (tmp_path / "cache").rglob("galvi-kernels/*.nbc")}

    warmed = compiled()
    with start_up.own_folder() as folder:
        for start in sorted(STARTS, key=lambda start: bool(start.imports)):
            started(start, folder, cache=str(tmp_path / "cache"))
            new = compiled() - warmed
            if not start.imports:
                assert not new, start.label
            assert all(name.startswith("galvi.tracing.code.compiled_") for name in new)  # own laws


def test_a_start_that_fails_says_why(tmp_path):
    (tmp_path / "numpy.py").write_text("raise ImportError('no such thing')")
    with pytest.raises(RuntimeError, match=r"(?s)pendulum could not be started: .*no such thing"):
        started(STARTS[-1], tmp_path)


@pytest.mark.slow(beside="test_integrate.py::test_counts_are_the_same_in_every_run")
def test_two_processes_agree_to_the_last_bit_and_count():
    digests = [
        subprocess.run(
            [sys.executable, "-c", DIGESTS],
            env=os.environ | {"PYTHONHASHSEED": seed},
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for seed in ("1", "2")
    ]
    assert digests[0] == digests[1]
    assert len(set(digests[0].splitlines())) == 4


@pytest.mark.slow(beside="test_many_runs.py::test_the_memory_counted_is_what_a_run_takes")
def test_the_table_has_a_row_for_each_start_and_memory_does_not_grow_with_the_steps(monkeypatch):
    """Peaks of one process, MiB: many steps after few add nothing when only ends are kept."""
    monkeypatch.setattr(start_up, "STARTS", STARTS[1:2])
    monkeypatch.setattr(start_up, "WARM_PROCESSES", 1)
    table = start_up.start_up_table(quick=True)
    assert list(table.columns) == list(start_up.COLUMNS)
    (row,) = table.to_dict("records")
    assert row["cold"] != row["cold"]  # not measured in the quick form
    assert row["import"] > 0.0 and row["warm"] > 0.0 and row["import_in_numpys"] > 1.0
    assert 10.0 < row["few_steps"] <= row["many_steps"] < row["few_steps"] + 1.0  # + 0.0


@pytest.mark.slow(beside="test_import_and_first_run_are_quick_when_all_is_compiled")
def test_most_of_a_first_run_is_compiling_and_each_function_has_its_share():
    imported, total, table = compile_times.compile_times()
    shares = table[list(compile_times.COLUMNS[1:-1])].sum(axis="columns")
    np.testing.assert_allclose(table["seconds"], shares)
    assert imported > 0.0 and 0.5 * total < table["seconds"].sum() < total
    assert "advance_run" in set(table["function"])
