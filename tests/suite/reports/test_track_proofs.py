"""Proofs, in minutes: planted faults go red at the right gate, and equal code under load does not.

`python -m pytest tests/suite/reports/test_track_proofs.py -m slow -s` prints the tables.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest

from benchmarks.store.provenance import ROOT
from benchmarks.timings.catalogue import CASES
from reports.results.progress import Studies
from reports.tracking.against import compare
from reports.tracking.checkouts import Checkout, copy_kernels, copy_working_tree

COMPARISONS = int(os.environ.get("COMPARISONS", "20"))


@dataclass(frozen=True)
class Fault:
    """Edits (file of galvi, text, other text), the cases that show it, and their gates."""

    name: str
    edits: tuple[tuple[str, str, str], ...]
    cases: tuple[str, ...]
    gates: tuple[str, ...]


def slowed(times):
    """Edits that add `times` roots of squares to Kepler's force, which change no bit of it.

    One took 18 % of the run on an Intel Xeon, two 36 %, six 100 %.
    """
    line = "        out[i] = pull * q[i]\n"
    extra_loop = f"    for _ in range({times}):\n        pull = sqrt(pull * pull)\n"
    loop = "    for i in range(len(q)):\n"
    names = "from galvi.kernels.lie.elementary import over_cube, "
    file = "kernels/forces/potentials.py"
    return ((file, loop + line, extra_loop + loop + line), (file, names, f"{names}sqrt, "))


KEPLER, BODIES = ("Kepler, degree 8",), ("3D pendulum, degree 4", "heavy top, degree 5")
FAULTS = (
    Fault("a kernel slowed by 15 % or more", slowed(1), KEPLER, ("time",)),
    Fault("a kernel slowed by 25 % or more", slowed(2), KEPLER, ("time",)),
    Fault("a kernel slowed to half", slowed(6), KEPLER, ("time",)),
    Fault(
        "one more solver iteration",
        (
            (
                "kernels/nystrom/solve.py",
                "(change <= tolerance) | (change * slower <= tolerance * (1.0 - slower))",
                "(last <= tolerance) | (last * slower <= tolerance * (1.0 - slower))",
            ),
        ),
        KEPLER,
        ("counts",),
    ),
    Fault(
        "a coefficient off by 1e-12",
        (
            (
                "tableau.py",
                "        A = psi @ C\n",
                "        A = psi @ C\n        b[0] *= 1 + decimals([1e-12])[0]\n",
            ),
        ),
        ("outer planets, rounding", "Kepler, rounding"),
        ("error",),
    ),
    Fault(
        "a lost compensated sum",
        (
            (
                "lanes/collocation.py",
                'end_rows += [(name, i, high), (f"{name}_low", i, low)]',
                'end_rows += [(name, i, high), (f"{name}_low", i, 0.0)]',
            ),
        ),
        ("Kepler, rounding",),
        ("error",),
    ),
    Fault(
        "a wrong sign in a torque",
        (
            (
                "kernels/forces/lagrangian_derivatives.py",
                "cross((c[12], c[13], c[14]), weight)",
                "cross(weight, (c[12], c[13], c[14]))",
            ),
        ),
        BODIES,
        ("error",),
    ),
    Fault(
        "a wrong sign in a problem's force",
        (
            (
                "problems/pendulums.py",
                "q[1] + q[0] ** 2 - q[1] ** 2])",
                "q[1] + q[0] ** 2 + q[1] ** 2])",
            ),
        ),
        ("Henon-Heiles, degree 4",),
        ("problem",),
    ),
)


def chosen(names):
    """Cases by their full names."""
    cases = tuple(case for case in CASES if case.name in names)
    assert len(cases) == len(names)
    return cases


def compared(base, head, cases):
    with Studies(3) as studies:
        return compare(Checkout(base, "base"), Checkout(head, "head"), cases, studies)


@pytest.fixture(scope="module")
def tree(tmp_path_factory: pytest.TempPathFactory):
    """A copy of the working tree, so that edits of the checkout do not reach a comparison."""
    folder = tmp_path_factory.mktemp("tree")
    copy_working_tree(ROOT, folder)
    copy_kernels(ROOT, folder)
    return folder


def plant(fault, folder):
    for name, text, replacement in fault.edits:
        path = folder / "galvi" / name
        source = path.read_text()
        assert source.count(text) == 1, f"{name} has changed; it should hold once: {text!r}"
        path.write_text(source.replace(text, replacement))


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.name)
def test_a_planted_fault_finds_its_place(tmp_path, fault):
    for name in {edit[0] for edit in fault.edits}:
        (tmp_path / "galvi" / name).parent.mkdir(parents=True)
        shutil.copyfile(ROOT / "galvi" / name, tmp_path / "galvi" / name)
    plant(fault, tmp_path)


@pytest.mark.slow(beside="test_track_gates.py::test_a_change_is_red_at_its_gate_alone")
@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.name)
def test_a_planted_fault_goes_red_at_its_gate(tree, tmp_path, fault):
    head = Path(shutil.copytree(tree, tmp_path / "head"))
    plant(fault, head)
    outcome = compared(tree, head, chosen(fault.cases))
    print()
    for finding in outcome.findings:
        print(
            f"{fault.name} | {finding.name} | {'; '.join(finding.alarms.values()) or '-'} | "
            f"time {100 * finding.growth:+.1f} %, p = {finding.p:.1e} | "
            f"{' '.join(finding.notes)}"
        )
    assert outcome.alarming, str(outcome)
    for gate in fault.gates:
        assert any(gate in finding.alarms for finding in outcome.alarming), str(outcome)
    if fault.gates != ("time",):
        return
    assert all(set(finding.alarms) == {"time"} for finding in outcome.alarming), str(outcome)


@pytest.fixture
def busy():
    """Another process that keeps a processor busy."""
    process = subprocess.Popen([sys.executable, "-c", "while True: sum(range(100000))"])
    yield
    process.kill()
    process.wait()


@pytest.mark.slow(beside="test_track_gates.py::test_equal_sides_are_green_in_one_sentence")
@pytest.mark.usefixtures("busy")
def test_equal_code_under_load_is_never_red(tree, tmp_path):
    copy = Path(shutil.copytree(tree, tmp_path / "other"))
    cases = tuple(case for case in CASES if case.quick)
    for k in range(COMPARISONS):
        outcome = compared(tree, copy, cases)
        print(f"\n{k + 1} of {COMPARISONS}: {outcome}")
        assert not outcome.has_alarms
