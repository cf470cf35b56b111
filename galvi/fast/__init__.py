"""What makes the core quick, and may decline: vector code, tracing and its code, moving frames.

The core, which never imports it, tries what is registered here before its general kernels. With
GALVI_FAST=0 it is not imported.
"""

from galvi.diagnostics import symplecticity
from galvi.fast import law_stepper, nystrom_stepper
from galvi.fast.in_frame.derivative import frame_step_derivative
from galvi.fast.in_frame.engine import frame_engine
from galvi.fast.lanes import elementary
from galvi.fast.symbolic import kinks
from galvi.fast.symbolic.from_sympy import symbolic
from galvi.fast.symbolic.symbolic_lagrangian import SymbolicLagrangian
from galvi.kernels.trees.sparse import OF_LANES
from galvi.run import engine_choice, group_steppers, nystrom_steppers
from galvi.systems.lagrangian import Lagrangian

nystrom_steppers.FAST.append(nystrom_stepper.lane_stepper)
group_steppers.FAST += [
    (law_stepper.has_law, law_stepper.law_stepper),
    (law_stepper.has_law_on_group, law_stepper.group_law_stepper),
]
engine_choice.FOR_FRAMES.append(frame_engine)
symplecticity.IN_FRAME.append(frame_step_derivative)
OF_LANES.update({name: getattr(elementary, name) for name in ("sine_cosine", "sqrt", "atan2")})
Lagrangian.read_sympy = staticmethod(symbolic)
SymbolicLagrangian.check_start = kinks.check_start
