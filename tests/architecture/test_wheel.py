"""The wheel holds one package, with the suite inside; it works beside a user's own folders."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SHIPPED = {".py", ".typed", ".csv", ".bib", ".css", ".js", ".j2", ".mplstyle", ".png"}
SUITE = ("references", "benchmarks", "reports")


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wheel, built from a copy so that nothing is left in the checkout, and unpacked."""
    folder = tmp_path_factory.mktemp("wheel")

    def leave_out(place: str, names: list[str]) -> set[str]:
        built = {"build", "dist"} if Path(place) == ROOT else set()
        ignored = shutil.ignore_patterns(".*", "__pycache__", "*.egg-info", "out")(place, names)
        return built & set(names) | ignored

    shutil.copytree(ROOT, folder / "source", ignore=leave_out)
    build = "from setuptools.build_meta import build_wheel; build_wheel('..')"
    result = subprocess.run(
        [sys.executable, "-c", build], cwd=folder / "source", capture_output=True, text=True
    )
    assert result.returncode == 0, result.stdout + result.stderr
    (built,) = folder.glob("*.whl")
    zipfile.ZipFile(built).extractall(folder / "unpacked")
    return folder / "unpacked"


def shipped(folder: Path) -> set[str]:
    """What of a folder of the checkout belongs to the wheel."""
    names = contents(folder)
    return {name for name in names if Path(name).suffix in SHIPPED and not name.startswith("out/")}


def contents(folder: Path) -> set[str]:
    return {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}


def test_the_wheel_holds_one_package(wheel: Path) -> None:
    top = {path.name for path in wheel.iterdir() if not path.name.endswith(".dist-info")}
    assert top == {"galvi"}


def test_the_wheel_holds_every_module_the_type_marker_and_the_data(wheel: Path) -> None:
    packed = contents(wheel / "galvi")
    expected = shipped(ROOT / "galvi")
    for folder in SUITE:
        expected |= {f"_suite/{folder}/{name}" for name in shipped(ROOT / folder)}
    assert packed == expected
    assert "py.typed" in packed
    assert any(name.startswith("problems/data/") and name.endswith(".csv") for name in packed)


def test_galvi_imports_from_the_wheel_without_the_packages_of_the_suite(wheel: Path) -> None:
    absent = ["pandas", "matplotlib", "sympy", "rebound", "jplephem", "jinja2", "typer", "pytest"]
    code = (
        "import sys\n"
        f"sys.modules.update(dict.fromkeys({absent}))\n"  # None there makes an import fail
        f"sys.path.insert(0, {str(wheel)!r})\n"
        "import galvi\n"
        "print(galvi.__file__)\n"
    )
    result = subprocess.run([sys.executable, "-I", "-c", code], capture_output=True, text=True)
    assert result.returncode == 0, result.stderr
    assert Path(result.stdout.strip()).is_relative_to(wheel)


@pytest.fixture(scope="module")
def folder_of_a_user(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with packages of the names of the suite's."""
    place = tmp_path_factory.mktemp("user")
    for name in SUITE:
        (place / name).mkdir()
        (place / name / "__init__.py").write_text(f"raise SystemExit('{name} of the user')\n")
    return place


def from_wheel(wheel: Path, place: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """The command of the wheel, with the kernels of this checkout, whose sources are the same."""
    for kernels in (ROOT / "galvi").rglob("__pycache__/galvi-kernels"):
        target = wheel / kernels.relative_to(ROOT)
        if not target.exists():
            shutil.copytree(kernels, target)
    return subprocess.run(
        [sys.executable, "-m", "galvi", *arguments], cwd=place, capture_output=True, text=True,
        env={**os.environ, "PYTHONPATH": str(wheel)},
    )  # fmt: skip


def test_the_command_of_the_wheel_judges_beside_a_users_own_folders(
    wheel: Path, folder_of_a_user: Path
) -> None:
    rebound = pytest.importorskip("rebound")
    sim = rebound.Simulation()
    sim.add(m=1.0)
    sim.add(m=1e-3, a=1.0, e=0.1)
    sim.integrator, sim.dt = "whfast", 0.1
    sim.save_to_file(str(folder_of_a_user / "two.bin"))
    done = from_wheel(wheel, folder_of_a_user, "judge", "two.bin", "--duration", "20")
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("Your run (REBOUND WHFast, dt = 0.1)")
    assert (folder_of_a_user / "galvi-out" / "judge" / "judge.html").is_file()


def test_the_wheel_refuses_to_track_where_there_is_no_checkout_of_galvi(
    wheel: Path, folder_of_a_user: Path
) -> None:
    done = from_wheel(wheel, folder_of_a_user, "track", "--against", "HEAD")
    assert done.returncode == 2 and "needs a git checkout of galvi" in done.stderr


@pytest.mark.slow
def test_the_wheel_verifies(wheel: Path, folder_of_a_user: Path) -> None:
    done = from_wheel(wheel, folder_of_a_user, "verify", "--quick")
    assert done.returncode == 0, done.stdout + done.stderr
    assert "every verdict is the expected one" in done.stdout


def test_every_requirement_has_a_pinned_version() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    groups = [project["dependencies"], *project["optional-dependencies"].values()]
    needed = {normal(requirement) for group in groups for requirement in group}
    lines = (ROOT / "constraints.txt").read_text().splitlines()
    pins = [line for line in lines if line and not line.startswith("#")]
    assert all(re.fullmatch(r"[\w.-]+==[\w.!+]+", pin) for pin in pins)
    assert needed - {normal(pin) for pin in pins} == set()


def test_the_version_is_the_same_wherever_it_is_written() -> None:
    version = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["version"]
    assert f"\nversion: {version}\n" in (ROOT / "CITATION.cff").read_text()
    assert f"\n## {version}" in (ROOT / "CHANGELOG.md").read_text()


def normal(requirement: str) -> str:
    """The name in a requirement, as the package index compares names."""
    return re.sub(r"[-_.]+", "-", re.match(r"[\w.-]+", requirement)[0]).lower()
