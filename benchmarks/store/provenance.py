"""The provenance of measurements: versions, commit, machine, date, command."""

from __future__ import annotations

import datetime
import hashlib
import json
import os
import platform
import subprocess
import sys
from importlib import metadata
from pathlib import Path

from llvmlite import binding
from numba import config

from galvi.interop.release import commit_in, galvi_version

ENGINES = (
    "numpy",
    "scipy",
    "numba",
    "llvmlite",
    "pandas",
    "rebound",
    "heyoka",
    "mujoco-core",
    "jplephem",
    "de421",
    "pytest-benchmark",
)
SOURCES = ("galvi", "references", "benchmarks")  # folders that rows of studies depend on
SUFFIXES = (".py", ".csv", ".md")  # code, data of initial states and truths, documents of claims
ROOT = Path(__file__).parents[2]


def provenance(command: str | None = None) -> dict[str, str]:
    """Date, command, commit, versions of Python and the engines, and machine, by name.

    Parameters
    ----------
    command
        the command as typed; None for that of this process, without folders
    """
    return {
        "date": datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%d %H:%M UTC"),
        "command": command or _command(),
        "commit": commit(),
        "python": platform.python_version(),
        **versions(),
        "platform": f"{platform.system()} {platform.machine()}",
        "cpu": cpu(),
        "compiled for": compiled_for(),
        "threads": str(os.cpu_count()),
    }


def today() -> str:
    """The date in Greenwich, such as 2026-01-31."""
    return datetime.datetime.now(datetime.UTC).date().isoformat()


def versions() -> dict[str, str]:
    """The installed version of each engine, or 'not installed'."""
    installed = {"galvi": galvi_version()}
    for name in ENGINES:
        try:
            installed[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            installed[name] = "not installed"
    return installed


def commit() -> str:
    """Hash of the checked-out commit, with '+dirty' for changed files.

    For an installed package, the digits of the commit in its version; 'unknown' without them.
    """
    head = _git("rev-parse", "HEAD") if (ROOT / ".git").exists() else None
    if head is None:
        return commit_in(galvi_version()) or "unknown"
    return head + ("+dirty" if _git("status", "--porcelain") else "")


def cpu() -> str:
    """The processor's model, as far as the system reports it."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    models = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return models[0] if models else platform.processor() or platform.machine()


def compiled_for() -> str:
    """LLVM's name of the processor that numba compiles for, with its widest vectors."""
    cpu_name = config.CPU_NAME
    features = {} if cpu_name else binding.get_host_cpu_features()
    vector_sets = {"avx512f": "AVX-512", "avx2": "AVX2", "neon": "NEON"}
    widest = [text for flag, text in vector_sets.items() if features.get(flag)][:1]
    return ", ".join([cpu_name or binding.get_host_cpu_name(), *widest])


def _git(*arguments: str) -> str | None:
    try:
        completed = subprocess.run(
            ["git", *arguments], cwd=ROOT, capture_output=True, text=True, check=True, timeout=30
        )
    except (OSError, subprocess.SubprocessError):
        return None
    return completed.stdout.strip()


def _command() -> str:
    program = Path(sys.argv[0])
    name = f"python -m {program.parent.name}" if program.stem == "__main__" else program.name
    return " ".join([name, *sys.argv[1:]])


def version() -> str:
    """The first digits of the commit; for changed files, or without a commit, followed by '+' and a
    digest."""
    head = commit()
    digits, _, dirty = head.partition("+")
    return f"{digits[:12]}+{_digest()}" if dirty or head == "unknown" else digits[:12]


def _digest() -> str:
    digest = hashlib.sha256()
    for folder in SOURCES:
        for path in sorted((ROOT / folder).rglob("*.py")):
            digest.update(path.read_bytes())
    return digest.hexdigest()[:8]


def digest_of_sources(code: tuple[str, ...] = ()) -> str:
    """A digest of the versions, the processor, and the sources, including the folders `code`."""
    digest = hashlib.sha256(json.dumps([versions(), cpu()]).encode())
    for folder in (*SOURCES, *code):
        for suffix in SUFFIXES if folder in SOURCES else SUFFIXES[:1]:
            for path in sorted((ROOT / folder).rglob(f"*{suffix}")):
                name = path.relative_to(ROOT).as_posix()
                digest.update(name.encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()[:16]
