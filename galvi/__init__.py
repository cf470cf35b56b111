"""High-order Galerkin variational integrators for Lagrangian mechanics."""

from difflib import get_close_matches as _close

from galvi import events, problems
from galvi.analysis.theory import Theory, theory
from galvi.charts.chart import Cayley, Exponential, ModifiedRodrigues
from galvi.clocks.clock import Clock, DynamicalTime, Sundman
from galvi.diagnostics.discrete_lagrangians import (
    action,
    discrete_lagrangian,
    discrete_legendre_transforms,
)
from galvi.diagnostics.invariants import (
    MomentumBalance,
    energy,
    linear_momentum,
    momentum_balance,
    momentum_map,
    orthogonality_defect,
    rotations,
)
from galvi.diagnostics.orbits import OrbitalElements, heliocentric, orbital_elements
from galvi.diagnostics.symplecticity import round_trip_error, step_derivative, symplecticity_defect
from galvi.ensembles.integrate_ensemble import integrate_ensemble
from galvi.ensembles.keep import Events, Extrema, FinalStates, Histogram, StatesAt
from galvi.ensembles.result import Ensemble
from galvi.environment import FAST as FAST
from galvi.events.event import Event
from galvi.events.search import Found, find_events
from galvi.frames.harmonic_frame import HarmonicFrame
from galvi.frames.kepler_frame import KeplerFrame
from galvi.groups.group import SE2, SE3, SO2, SO3, Rn, nearest_rotation
from galvi.groups.product import Product
from galvi.interop.citations import Citation, cite
from galvi.interop.convergence import convergence
from galvi.interop.exports import to_scipy as to_scipy
from galvi.interop.exports import to_xarray as to_xarray
from galvi.interop.from_mujoco import from_mujoco
from galvi.interop.judge import Judged, judge
from galvi.interop.rebound import from_rebound
from galvi.interop.rebound import to_rebound as to_rebound
from galvi.interop.release import galvi_version as _version
from galvi.method import Galerkin
from galvi.outcome import End, Outcome
from galvi.problem import Problem
from galvi.recommend.recommend import recommend
from galvi.recommend.recommendation import Recommendation
from galvi.rules.rule import Rule, clenshaw_curtis, composite, gauss, lobatto, newton_cotes, radau
from galvi.run.ensemble import integrate_many
from galvi.run.integrate import integrate
from galvi.run.resume import resume
from galvi.run.saving.files import load, save
from galvi.run.states import states_at
from galvi.spaces.fourier import Fourier, PolynomialFourier
from galvi.spaces.piecewise import PiecewiseHermite, PiecewisePolynomials
from galvi.spaces.polynomials import ComponentPolynomials, Polynomials
from galvi.systems.canonical import Canonical
from galvi.systems.forces.celestial import (
    Drag,
    Force,
    Oblateness,
    PowerLaw,
    Radiation,
    Relativity,
    Tides,
)
from galvi.systems.forces.drag import QuadraticDrag, RotorDrag, SchillerNaumann
from galvi.systems.free_body import FreeBody
from galvi.systems.lagrangian import Lagrangian
from galvi.systems.multibody import Multibody
from galvi.systems.nbody import NBody
from galvi.systems.planar_chain import PlanarChain
from galvi.systems.potentials.potentials import (
    CentralForce,
    CosinePotential,
    LinearSpring,
    SpringChain,
    UniformField,
    UniformGravity,
)
from galvi.systems.rigid_body import RigidBody
from galvi.systems.trees.joint import Joint, Link
from galvi.trajectory import Trajectory

__all__ = [
    "SE2", "SE3", "SO2", "SO3", "Canonical", "Cayley", "CentralForce", "Citation", "Clock",
    "ComponentPolynomials", "CosinePotential", "Drag", "DynamicalTime", "End", "Ensemble", "Event",
    "Events", "Exponential", "Extrema", "FinalStates", "Force", "Found", "Fourier", "FreeBody",
    "Galerkin", "HarmonicFrame", "Histogram", "Joint", "Judged", "KeplerFrame", "Lagrangian",
    "LinearSpring", "Link", "ModifiedRodrigues", "MomentumBalance", "Multibody", "NBody",
    "Oblateness", "OrbitalElements", "Outcome", "PiecewiseHermite", "PiecewisePolynomials",
    "PlanarChain", "PolynomialFourier", "Polynomials", "PowerLaw", "Problem", "Product",
    "QuadraticDrag", "Radiation", "Recommendation", "Relativity", "RigidBody", "Rn", "RotorDrag",
    "Rule", "SchillerNaumann", "SpringChain", "StatesAt", "Sundman", "Theory", "Tides",
    "Trajectory", "UniformField", "UniformGravity", "action", "cite", "clenshaw_curtis",
    "composite", "convergence", "discrete_lagrangian", "discrete_legendre_transforms", "energy",
    "events", "find_events", "from_mujoco", "from_rebound", "gauss", "heliocentric", "integrate",
    "integrate_ensemble", "integrate_many", "judge", "linear_momentum", "load", "lobatto",
    "momentum_balance", "momentum_map", "nearest_rotation", "newton_cotes", "orbital_elements",
    "orthogonality_defect", "problems", "radau", "recommend", "resume", "rotations",
    "round_trip_error", "save", "states_at", "step_derivative", "symplecticity_defect", "theory",
]  # fmt: skip


def __getattr__(name: str) -> object:
    """AttributeError with the nearest public name; pieces and problems are found in any case."""
    if name == "__version__":
        return _version()
    public = {word.casefold(): word for word in __all__ if word != "problems"}
    public |= {word.casefold(): f"problems.{word}" for word in problems.__all__}
    matches = _close(name.casefold(), public, n=1)
    hint = (
        f". Did you mean galvi.{public[matches[0]]}?"
        if matches and not name.startswith("_")
        else ""
    )
    raise AttributeError(f"module 'galvi' has no attribute {name!r}{hint}", name=name)
