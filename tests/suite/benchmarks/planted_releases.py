"""Invented releases of an engine: the installed one with a planted fault."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from benchmarks.applications.releases.requirements import installed
from benchmarks.store.isolated_environment import EnvironmentUnavailable

PROGRAM = """import json, runpy, sys

program = runpy.run_path(sys.argv[2])
job = json.load(sys.stdin)
{before}
answer = program["answer"](job)
answer["release"] = {version!r}
{after}
json.dump(answer, sys.stdout)
"""
# Code of each fault: what it does to a job, and to an answer.
EULER = ("for each in job['runs']: each['integrator'] = 'Euler'", "")
EULER_AT_OTHER_STEPS = ("for each in job['runs'][5:]: each['integrator'] = 'Euler'", "")
GRAVITY = ("job['G'] *= 1.0 + 2e-12", "")
STEP = ("for each in job['runs']: each['step'] *= 1.0 + 1e-10", "")
SHORT = ("for each in job['runs']: each['step'] = 1e-5", "")
ACCELERATIONS = (
    "",
    "answer['accelerations'] = [[x * (1.0 + 1e-9) for x in each]"
    " for each in answer['accelerations']]",
)
ENERGY = (
    "",
    "for each in answer['runs']: each['energy'] = [x * (1.0 + 1e-9) for x in each['energy']]",
)
BLOWS_UP = (
    "",
    "for each in answer['runs']: each['particles'] = [[[float('nan')] * 7] * 4] * 10",
)
FAILS = ("sys.exit('ValueError: XML Error: unrecognized attribute')", "")
SAME = ("", "")
# Every start is off by a rounding error, as if a release added in another order.
ROUNDS_MODEL = (
    "for each in job['runs']:\n"
    "    for name in ('qpos', 'qvel'):\n"
    "        each[name] = [x * (1.0 + 2.2e-16) + 1e-16 for x in each[name]]",
    "",
)
ROUNDS_PLANETS = (
    "for each in job['runs']:\n"
    "    each['particles'] = [[m, *(x * (1.0 + 2.2e-16) for x in row)]\n"
    "                         for m, *row in each['particles']]",
    "",
)
# Every state is off by a rounding error after each step, upwards by twice as much as downwards.
ROUNDS_EACH_STEP = (
    """
import random

signs, names = random.Random(0), program["run"].__globals__
build, alive = names["build"], []

def rounding(job, particles):
    sim = build(job, particles)

    def move(pointer):
        for particle in sim.particles:
            for name in ("x", "y", "z", "vx", "vy", "vz"):
                ulp = signs.choice((-1.1e-16, 0.0, 2.2e-16))
                setattr(particle, name, getattr(particle, name) * (1.0 + ulp))

    sim.post_timestep_modifications = move
    alive.append((move, sim))
    return sim

names["build"] = rounding
""",
    "",
)


def planted(folder: Path, faults: Mapping[str, tuple[str, str]]):
    """A stand-in for `interpreter` that has the installed release and those with faults; all others
    cannot be installed."""

    @contextmanager
    def interpreter(package: str, version: str, environment: Path) -> Iterator[Path]:
        if version == installed(package):
            yield Path(sys.executable)
            return
        if version not in faults:
            raise EnvironmentUnavailable(f"No matching distribution found for {package}=={version}")
        before, after = faults[version]
        program = folder / f"{version}.py"
        program.write_text(PROGRAM.format(before=before, after=after, version=version))
        python = folder / f"python-{version}"
        python.write_text(f'#!/bin/sh\nexec "{sys.executable}" "{program}" "$@"\n')
        python.chmod(0o755)
        yield python

    return interpreter
