"""Help and refusals load no engine, so that they are said at once."""

from __future__ import annotations

import subprocess
import sys

import pytest

ENGINES = {"mujoco", "sympy", "dask", "distributed", "jplephem", "xarray", "heyoka"}
SHOWN = {"pandas", "matplotlib", "jinja2", "rebound", "scipy.optimize"}
CODE = """
import sys
from galvi import command
sys.argv = ["galvi", *sys.argv[1:]]
try:
    status = command.main()
except SystemExit as ended:
    status = ended.code
print("status", status, *sys.modules)
"""


@pytest.mark.slow_cases(but=["verify --clams V1-2-without1"])
@pytest.mark.parametrize(
    ("words", "status", "without"),
    [
        ("--help", 0, ENGINES | SHOWN),
        ("verify --clams V1", 2, ENGINES | SHOWN),
        ("track --against nosuch", 2, ENGINES | {"rebound"}),
        ("export nosuch", 2, ENGINES | {"rebound"}),
        ("verify --claims X9", 2, ENGINES | {"rebound"}),
        ("judge /nosuch.bin", 2, ENGINES),
    ],
)
def test_what_is_refused_is_refused_before_engines_are_loaded(
    words: str, status: int, without: set[str]
) -> None:
    done = subprocess.run(
        [sys.executable, "-c", CODE, *words.split()], capture_output=True, text=True
    )
    last = done.stdout.splitlines()[-1].split()
    assert last[:2] == ["status", str(status)], done.stderr
    assert not without & set(last[2:])
    assert "Traceback" not in done.stderr
