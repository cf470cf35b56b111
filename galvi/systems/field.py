"""How a system enters the kernels: functions on flat arrays and the numbers they need."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from galvi.arrays import Array
from galvi.kernels import laws


@dataclass(frozen=True, eq=False)
class Field:
    """The acceleration of a system, a(q, t), in the form a kernel evaluates.

    Exactly one of law, gradient and timed_gradient is the user's; the rest are stand-ins.

    kind          laws.BUILT_IN, laws.GRADIENT or laws.TIMED_GRADIENT
    law           (Q (d, s), t (s,), constants, out (d, s)): force-like term for all stages at once
    law_jacobian  (Q (d, s), t (s,), constants, out (d, w, s)): its derivative, rows of own block
    gradient      dV/dq of one configuration, (q (d,)) -> (d,), or with t: timed_gradient
    hessian       d2V/dq2, (q (d,)) -> (d, d), or with t: timed_hessian; used when has_hessian
    constants     (c,) numbers for law
    inverse_mass  (d, 1) diagonal or (d, d) full; applied to -gradient. (0, 0): law already
                  returns accelerations
    width         components that a Newton block couples; d must be a multiple of it
    compiled      whether every function can run inside a compiled kernel
    """

    inverse_mass: Array
    width: int
    kind: int = laws.BUILT_IN
    law: Callable[..., Any] = laws.no_law
    law_jacobian: Callable[..., Any] = laws.no_law_jacobian
    gradient: Callable[..., Any] = laws.no_gradient
    timed_gradient: Callable[..., Any] = laws.no_timed_gradient
    hessian: Callable[..., Any] = laws.no_hessian
    timed_hessian: Callable[..., Any] = laws.no_timed_hessian
    has_hessian: bool = False
    constants: Array = field(default_factory=laws.no_constants)
    compiled: bool = True
