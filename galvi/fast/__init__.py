"""What makes the core quick, and may decline: vector code, tracing and its code, moving frames.

The core, which never imports it, tries what `register` gives it before its general kernels. With
GALVI_FAST=0 it is not imported.
"""

from galvi.diagnostics import symplecticity
from galvi.fast import clock_stepper, law_stepper, nystrom_stepper
from galvi.fast.in_frame.engine import frame_engine, frame_step_derivative
from galvi.fast.lanes import elementary
from galvi.fast.laws import finders_of
from galvi.fast.symbolic import kinks
from galvi.fast.symbolic.from_sympy import symbolic
from galvi.fast.symbolic.symbolic_lagrangian import SymbolicLagrangian
from galvi.kernels.trees.sparse import OF_LANES
from galvi.run import engine_choice, group_engine, nystrom_engine
from galvi.run.clocked import plan as clocked_plan
from galvi.systems.lagrangian import Lagrangian
from galvi.systems.traces import TRACERS


def register() -> None:
    """Let the core try what is fast; called by galvi/__init__, once."""
    nystrom_engine.FAST[:] = [nystrom_stepper.lane_stepper]
    group_engine.FAST[:] = [law_stepper.lane_stepper]
    group_engine.ITERATES[:] = [law_stepper.iterates]
    clocked_plan.FAST[:] = [clock_stepper.motion_in_lanes]
    engine_choice.FOR_FRAMES[:] = [frame_engine]
    symplecticity.IN_FRAME[:] = [frame_step_derivative]
    TRACERS[:] = [finders_of]
    OF_LANES.update({name: getattr(elementary, name) for name in ("sine_cosine", "sqrt", "atan2")})
    Lagrangian.read_sympy = staticmethod(symbolic)
    SymbolicLagrangian.check_start = kinks.check_start
