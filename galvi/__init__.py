"""High-order Galerkin variational integrators for Lagrangian mechanics."""

from galvi import problems
from galvi.integrate import integrate, resume
from galvi.method import Galerkin
from galvi.potentials.central_force import CentralForce
from galvi.potentials.linear_spring import LinearSpring
from galvi.potentials.spring_chain import SpringChain
from galvi.problem import Problem
from galvi.rules.clenshaw_curtis import clenshaw_curtis
from galvi.rules.gauss import gauss
from galvi.rules.lobatto import lobatto
from galvi.rules.rule import Rule
from galvi.spaces.polynomials import Polynomials
from galvi.systems.canonical import Canonical
from galvi.systems.nbody import NBody
from galvi.trajectory import Trajectory

__all__ = [
    "Canonical",
    "CentralForce",
    "Galerkin",
    "LinearSpring",
    "NBody",
    "Polynomials",
    "Problem",
    "Rule",
    "SpringChain",
    "Trajectory",
    "clenshaw_curtis",
    "gauss",
    "integrate",
    "lobatto",
    "problems",
    "resume",
]
