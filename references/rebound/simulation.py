"""Converts a problem to a REBOUND 5 simulation, and its states back.

The only place that knows REBOUND's order of bodies (the heaviest first, which Jacobi and
heliocentric coordinates need), its constant G, its three dimensions and its messages.
"""

from __future__ import annotations

import ctypes
import signal
import threading
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from galvi import Canonical, CentralForce, NBody, Problem
from galvi.arrays import Array
from references.newton import is_forced, replaces_force


def missing() -> str:
    """One sentence saying why REBOUND cannot be used here; empty when it can."""
    try:
        import rebound
    except ImportError as error:
        return f"{error}. Install rebound 5 or newer."
    if int(rebound.__version__.split(".")[0]) < 5:
        return f"rebound {rebound.__version__} is too old. Install rebound 5 or newer."
    return ""


def version() -> str:
    """Name and version of the engine."""
    import rebound

    return f"rebound {rebound.__version__}"


def supports(problem: Problem) -> bool:
    """N bodies, or one scalar mass about a fixed centre in 2 or 3 dimensions."""
    system = problem.system
    if isinstance(system, Canonical):
        return (
            isinstance(system.potential, CentralForce)
            and not is_forced(problem)
            and not replaces_force(problem)
            and not system.explicit_time
            and system.mass.ndim == 0
            and problem.q0.size in (2, 3)
        )
    return isinstance(system, NBody) and not system.forces


@dataclass(frozen=True, eq=False)
class Simulation:
    """A REBOUND simulation, and the indices of the problem's bodies among its particles.

    Attributes
    ----------
    engine
        the rebound.Simulation
    indices : array, shape (bodies,)
        index of each of the problem's bodies among the particles
    dimension
        of the problem, 2 or 3
    """

    engine: Any
    indices: Any
    dimension: int

    def states(self) -> tuple[Array, Array]:
        """q and v of the problem's bodies now, (bodies, dimension) each."""
        read = {"xyz": np.zeros((self.engine.N, 3)), "vxvyvz": np.zeros((self.engine.N, 3))}
        self.engine.serialize_particle_data(**read)
        arrays = [x[self.indices, : self.dimension] for x in read.values()]
        return arrays[0], arrays[1]


Builder = Callable[[Problem, str, Mapping[str, Any]], Simulation]


def simulation(problem: Problem, integrator: str, options: Mapping[str, Any]) -> Simulation:
    """The problem at REBOUND's time 0, with options set on REBOUND's integrator.

    REBOUND's masses are G m and its G is 1, because WHFast512 requires that. A fixed centre is a
    particle of mass mu / m at rest, the body a massless particle.

    Raises
    ------
    ValueError
        For an option or a value that REBOUND refuses.
    """
    import rebound

    sim = rebound.Simulation()
    sim.integrator = integrator
    for key, value in options.items():
        try:
            setattr(sim.integrator, key, value)
        except (AttributeError, TypeError) as error:
            raise ValueError(f"{key} cannot be {value!r} in {version()}: {error}") from None
    system: Any = problem.system
    q, v = np.atleast_2d(problem.q0), np.atleast_2d(problem.v0)
    if isinstance(system, NBody):
        masses = system.G * system.masses
        rank = np.where(masses == 0.0, 2, 1)  # massless bodies last
        rank[np.argmax(masses)] = 0
        order = np.argsort(rank, kind="stable").tolist()
        indices = np.argsort(order)
        if system.has_massless:
            sim.N_active = int(np.count_nonzero(masses))
    else:
        masses, order, indices = np.zeros(1), [0], np.array([1])
        sim.add(m=system.potential.mu / float(system.mass))
        sim.N_active = 1
    for i in order:
        x, y, z = np.pad(q[i], (0, 3 - q.shape[1]))
        vx, vy, vz = np.pad(v[i], (0, 3 - q.shape[1]))
        sim.add(m=masses[i], x=x, y=y, z=z, vx=vx, vy=vy, vz=vz)
    return Simulation(engine=sim, indices=indices, dimension=q.shape[1])


@contextmanager
def arithmetic_kept() -> Iterator[None]:
    """Restore this thread's floating-point modes afterwards.

    WHFast512 (5.2.2) sets flush-to-zero and leaves it set: from then on the whole process would
    round subnormal numbers to zero.
    """
    library, modes = _c_library(), ctypes.create_string_buffer(256)  # fenv_t is smaller
    library.fegetenv(modes)
    try:
        yield
    finally:
        library.fesetenv(modes)


@contextmanager
def interrupts_kept() -> Iterator[None]:
    """Restore Python's handler of Ctrl-C afterwards.

    REBOUND's integrate (5.2.2) installs a handler of its own and leaves it there: from then on no
    Ctrl-C would reach the rest of the program.
    """
    try:
        yield
    finally:
        handler = signal.getsignal(signal.SIGINT)
        if handler is not None and threading.current_thread() is threading.main_thread():
            signal.signal(signal.SIGINT, handler)


@lru_cache(maxsize=1)
def _c_library() -> Any:
    return ctypes.CDLL(None)


@contextmanager
def messages() -> Iterator[Callable[[], list[str]]]:
    """Capture REBOUND's warnings; yields a function that returns a sentence for each."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        yield lambda: [f"REBOUND warned: {m}" for m in {str(w.message): 0 for w in caught}]
