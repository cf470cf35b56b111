"""High-order Galerkin variational integrators for Lagrangian mechanics."""

from galvi import problems
from galvi.potentials.central_force import CentralForce
from galvi.potentials.linear_spring import LinearSpring
from galvi.potentials.spring_chain import SpringChain
from galvi.problem import Problem
from galvi.systems.canonical import Canonical
from galvi.systems.nbody import NBody
from galvi.trajectory import Trajectory

__all__ = [
    "Canonical",
    "CentralForce",
    "LinearSpring",
    "NBody",
    "Problem",
    "SpringChain",
    "Trajectory",
    "problems",
]
