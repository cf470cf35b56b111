"""Stored truths for chains of links, written by `python -m references.stored.chain`.

A file identifies its problem by links, gravity and start, to the last bit.
"""

from __future__ import annotations

import sys

from galvi import Problem, problems
from references.heyoka.lagrangian import HEYOKA_CHAIN_QUADRUPLE
from references.stored.states import Identity, StoredStates
from references.textbook.chain_equations import is_chain


def _identity(problem: Problem) -> Identity:
    chain = problem.system.function
    return {
        "masses": chain.masses.tolist(),
        "lengths": chain.lengths.tolist(),
        "gravity": [float(chain.gravity)],
        "rods": [float(chain.rods)],
        "q0": problem.q0.tolist(),
        "v0": problem.v0.tolist(),
    }


STORED_CHAIN = StoredStates(
    name="stored truth, chains",
    module="references.stored.chain",
    makers={
        "double_pendulum": (problems.double_pendulum, 10.0),
        "planar_chain": (problems.planar_chain, 10.0),
    },
    engine=HEYOKA_CHAIN_QUADRUPLE,
    knows=is_chain,
    identity=_identity,
    columns=lambda problem: [f"{x}{i}" for x in "qp" for i in range(problem.q0.size)],
)

if __name__ == "__main__":
    STORED_CHAIN.write(sys.argv[1:])
