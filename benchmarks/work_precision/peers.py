"""The documented options at which each peer takes part: closed, its defaults, and open, its best.

Maintainers of a peer edit this file. An entry of `open` is a named set of options, which is run at
steps or tolerances from coarse to fine; `benchmarks.work_precision.grid` adds settings where these
leave a gap. The fastest of all at an error counts.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from references.heyoka import taylor
from references.rebound import ias15, native, saba, whfast, whfast512

OptionValues = Mapping[str, Any]


class Options(NamedTuple):
    """The options of one code.

    Attributes
    ----------
    closed
        default options
    open
        name -> options, the best first: a quick form runs that alone
    built
        description of how the build that is run here was compiled
    source
        address or file that documents the options
    """

    closed: OptionValues
    open: Mapping[str, OptionValues]
    built: str
    source: str


WHEEL = "wheel of the package index, for any x86-64: no AVX but where it chooses at run time"
BOTH = f"{WHEEL}; IAS15, WHFast and SABA also {native.BUILT}, after `make native`"
COMPILED_HERE = "compiled at run time for this processor by LLVM"
REBOUND = "https://rebound.readthedocs.io/en/latest/integrators/"
MUJOCO = "https://mujoco.readthedocs.io/en/stable/computation/index.html"
SCIPY = "https://docs.scipy.org/doc/scipy/reference/generated/scipy.integrate.DOP853.html"
PEERS: Mapping[str, Options] = {
    "REBOUND IAS15": Options(
        ias15.DEFAULT, {"PRS23": ias15.DEFAULT, "GLOBAL": ias15.GLOBAL}, BOTH, REBOUND
    ),
    "REBOUND WHFast": Options(
        whfast.DEFAULT,
        {
            "corrector 17, lazy kernel": whfast.BEST,
            "corrector 17, default kernel": {**whfast.BEST, "kernel": "DEFAULT"},
        },
        BOTH,
        REBOUND,
    ),
    "REBOUND WHFast512": Options(
        whfast512.DEFAULT, {"corrector 17": whfast512.BEST}, WHEEL, REBOUND
    ),
    "REBOUND SABA": Options(
        saba.DEFAULT,
        {
            f"type {name}": {**saba.BEST, "type": name}
            for name in ("10_6_4", "8_6_4", "10_4", "CL_4")
        },
        BOTH,
        REBOUND,
    ),
    "REBOUND BS": Options({"tolerance": 1e-8}, {"tolerances": {}}, WHEEL, REBOUND),
    "REBOUND TRACE": Options({}, {"steps": {}}, WHEEL, REBOUND),
    "REBOUND MERCURIUS": Options({}, {"steps": {}}, WHEEL, REBOUND),
    "heyoka": Options(
        taylor.DOUBLE,
        {"tolerances": taylor.DOUBLE, "below machine precision": taylor.BEST},
        COMPILED_HERE,
        "https://bluescarni.github.io/heyoka.py/",
    ),
    "MuJoCo": Options(
        {"integrator": "Euler", "step": 0.002},
        {name: {"integrator": name} for name in ("RK4", "implicit", "implicitfast", "discrete")},
        WHEEL,
        MUJOCO,
    ),
    "SciPy DOP853": Options(
        {"rtol": 1e-3, "atol": 1e-6}, {"equal tolerances": {}}, "Python over NumPy", SCIPY
    ),
    "RK4 and DOP853 on quaternions": Options(
        {}, {"steps, tolerances": {}}, COMPILED_HERE, "references/textbook/quaternions.py"
    ),
}
