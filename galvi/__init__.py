"""High-order Galerkin variational integrators for Lagrangian mechanics."""

from galvi import problems
from galvi.ensemble import integrate_many
from galvi.integrate import integrate, resume
from galvi.invariants import energy, linear_momentum, momentum_map
from galvi.method import Galerkin
from galvi.orbits import OrbitalElements, heliocentric, orbital_elements
from galvi.potentials.central_force import CentralForce
from galvi.potentials.linear_spring import LinearSpring
from galvi.potentials.spring_chain import SpringChain
from galvi.problem import Problem
from galvi.recommend import recommend
from galvi.recommendation import Recommendation
from galvi.round_trip import round_trip_error
from galvi.rules.clenshaw_curtis import clenshaw_curtis
from galvi.rules.gauss import gauss
from galvi.rules.lobatto import lobatto
from galvi.rules.rule import Rule
from galvi.spaces.polynomials import Polynomials
from galvi.storage import load, save
from galvi.symplecticity import step_derivative, symplecticity_defect
from galvi.systems.canonical import Canonical
from galvi.systems.nbody import NBody
from galvi.trajectory import Trajectory

__all__ = [
    "Canonical",
    "CentralForce",
    "Galerkin",
    "LinearSpring",
    "NBody",
    "OrbitalElements",
    "Polynomials",
    "Problem",
    "Recommendation",
    "Rule",
    "SpringChain",
    "Trajectory",
    "clenshaw_curtis",
    "energy",
    "gauss",
    "heliocentric",
    "integrate",
    "integrate_many",
    "linear_momentum",
    "load",
    "lobatto",
    "momentum_map",
    "orbital_elements",
    "problems",
    "recommend",
    "resume",
    "round_trip_error",
    "save",
    "step_derivative",
    "symplecticity_defect",
]
