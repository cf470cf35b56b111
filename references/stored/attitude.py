"""Stored truths for rigid bodies under their weight, written by `python -m
references.stored.attitude`.

A file identifies its problem by inertia, mass, centre of mass, weight and start, to the last bit.
"""

from __future__ import annotations

import sys

import numpy as np

from galvi import Problem, RigidBody, problems
from references.closed_forms.top_motion import is_known_body
from references.heyoka.rigid import HEYOKA_RIGID_QUADRUPLE
from references.stored.states import Identity, StoredStates


def _is_heavy(problem: Problem) -> bool:
    heavy = isinstance(problem.system, RigidBody) and problem.system.potential is not None
    return heavy and is_known_body(problem)


def _identity(problem: Problem) -> Identity:
    weight = problem.system.potential
    return {
        "inertia": problem.system.inertia.ravel().tolist(),
        "mass": [float(weight.mass)],
        "centre": np.asarray(weight.centre, dtype=np.float64).tolist(),
        "g": np.asarray(weight.g, dtype=np.float64).tolist(),
        "q0": problem.q0.ravel().tolist(),
        "v0": problem.v0.tolist(),
    }


STORED_ATTITUDE = StoredStates(
    name="stored truth, rigid bodies",
    module="references.stored.attitude",
    makers={
        "pendulum_3d": (problems.pendulum_3d, 20.0),
        "heavy_top": (problems.heavy_top, 20.0),
    },
    engine=HEYOKA_RIGID_QUADRUPLE,
    knows=_is_heavy,
    identity=_identity,
    columns=lambda problem: [*(f"R{i}{j}" for i in "xyz" for j in "xyz"), "px", "py", "pz"],
)

if __name__ == "__main__":
    STORED_ATTITUDE.write(sys.argv[1:])
