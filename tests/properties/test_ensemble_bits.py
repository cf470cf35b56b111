"""A member has the same bits in every ensemble, lane, batch, thread, process and order."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import galvi
from galvi.ensembles import chunk as schedule
from galvi.ensembles.chunk import Chunk, run_chunk
from galvi.ensembles.keep import FinalStates, TimeGrid
from galvi.ensembles.member_laws import law_of
from galvi.lanes import layouts
from tests.properties.ensemble_cases import CASES, starts

SIX = galvi.Galerkin(galvi.Polynomials(6), galvi.gauss(6))
MEMBERS = 21


def final(name, members, mark=""):
    """The final states of some members, whose steps differ and so need different passes, which end
    long before round-off.

    mark  added to the law's lines, so that code with a fault is compiled and kept apart
    """
    problem, step = CASES[name]
    q, v = (x[members] for x in starts(problem, MEMBERS, 0.05))
    plan = TimeGrid(
        8, step * np.linspace(0.1, 1.0, MEMBERS)[members], problem.t0, problem.q0.shape,
        problem.v0.shape,
    )  # fmt: skip
    law, numbers = law_of(problem.system, problem.v0.size)
    law = replace(law, lines=law.lines + mark)
    kept = run_chunk(Chunk(law, numbers, SIX, plan, 1e-9, FinalStates(), 0, q, v))
    assert not kept.failed.any()
    assert len(members) < MEMBERS or len(set(kept.passes)) > 1
    return np.concatenate([x.reshape(len(members), -1) for x in kept.values], axis=1)


def check_members_do_not_mix(name, parts, mark=""):
    """AssertionError unless members have the same bits together and in these parts."""
    together = final(name, np.arange(MEMBERS), mark)
    for part in parts:
        assert np.array_equal(final(name, np.array(part), mark), together[part])


@pytest.mark.slow(beside="test_for_any_number_of_threads_and_size_of_chunks")
@given(
    order=st.permutations(range(MEMBERS)), size=st.integers(3, MEMBERS),
    name=st.sampled_from(["henon_heiles", "double_pendulum", "brownout", "pendulum_3d"]),
)  # fmt: skip
@settings(max_examples=15)
def test_in_any_order_and_company(order, size, name):
    check_members_do_not_mix(name, [order, order[:size]])


PARTS = [list(range(MEMBERS))[::-1], [4, 11, 20]]


def test_a_pass_that_does_not_spare_solved_members_is_caught(monkeypatch):
    def unmasked(self, lanes, lane, row):
        lanes.store(lane.value, self.work, self.row(row))

    monkeypatch.setattr(layouts.Members, "store_row", unmasked)
    with pytest.raises(AssertionError):
        check_members_do_not_mix("henon_heiles", PARTS, "\n# every pass for all\n")


def test_a_state_written_to_the_neighbour_is_caught(monkeypatch):
    keep = layouts.Members.keep

    def leaking(self, name, lane, i=0):
        turned = layouts.ir.Constant(
            layouts.ir.VectorType(layouts.ir.IntType(32), 8), [*range(1, 8), 0]
        )
        moved = self.builder.shuffle_vector(lane.value, lane.value, turned)
        keep(self, name, layouts.Lane(self.builder, moved), i)

    monkeypatch.setattr(layouts.Members, "keep", leaking)
    with pytest.raises(AssertionError):
        check_members_do_not_mix("henon_heiles", PARTS, "\n# to the neighbour\n")


def test_a_member_whose_first_step_fails_changes_no_bit_of_the_others():
    problem, method = galvi.problems.kepler(0.6), galvi.Galerkin(
        galvi.Polynomials(12), galvi.gauss(12)
    )  # fmt: skip
    q, v = (x.copy() for x in starts(problem, 8, 0.01))
    sound = galvi.integrate_ensemble(problem, q, v, method, 0.3, 40)
    q[3] = [1e-9, 0.0]
    beside = galvi.integrate_ensemble(problem, q, v, method, 0.3, 40)
    others = np.arange(8) != 3
    assert sound.success.all() and not beside.success[3]
    for one, other in zip(sound.kept, beside.kept, strict=True):
        np.testing.assert_array_equal(one[others], other[others])


def test_members_take_as_few_passes_as_single_runs():
    """A number of terms that is kept for some steps suits one run, and not the worst of eight."""
    problem, method = galvi.problems.kepler(0.5), galvi.Galerkin(
        galvi.Polynomials(16), galvi.gauss(16)
    )  # fmt: skip
    q, v = starts(problem, 16, 0.01)
    together = galvi.integrate_ensemble(problem, q, v, method, 0.4, 100)
    alone = [
        galvi.integrate(galvi.Problem(problem.system, *start), method, 0.4, 100).counts
        for start in zip(q, v, strict=True)
    ]
    passes = sum(counts["iterations"] for counts in alone)
    assert np.sum(together.iterations) < 1.05 * passes


def test_for_any_number_of_threads_and_size_of_chunks(monkeypatch):
    problem, step = CASES["henon_heiles"]
    q, v = starts(problem, 300)

    def run(executor=None):
        return galvi.integrate_ensemble(
            problem, q, v, SIX, step, 20, keep=galvi.Extrema(), executor=executor
        )

    one = run()
    assert one.success.all()
    for threads, probe in ((1, 8), (2, 16), (2, 8)):
        monkeypatch.setattr(schedule, "PROBE", probe)
        monkeypatch.setattr("galvi.ensembles.integrate_ensemble.PROBE", probe)
        with ThreadPoolExecutor(threads) as pool:
            other = run(pool)
        assert all(map(np.array_equal, one.kept, other.kept))
