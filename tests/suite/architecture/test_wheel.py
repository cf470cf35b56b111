"""The wheel holds galvi, with the suite inside, and pytest's plugin; it works beside a user's own
folders."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path
from typing import Any

import pytest
import yaml

import galvi
from benchmarks.store.provenance import provenance
from galvi.interop.release import RELEASE, version_in_git
from galvi.kernels.compile.cache import KERNELS_FOLDER
from reports.tables.macros import bibliography
from tests.suite.reports.test_track_against import git

ROOT = Path(__file__).parents[3]
SHIPPED = {
    ".py",
    ".typed",
    ".csv",
    ".md",
    ".bib",
    ".css",
    ".js",
    ".j2",
    ".mplstyle",
    ".png",
    ".xml",
}
OF_THESE_TESTS = {  # what the environment of a user has not
    "PYTEST_DISABLE_PLUGIN_AUTOLOAD", "PYTEST_ADDOPTS", "PYTHONPATH", "PYTHONDONTWRITEBYTECODE",
}  # fmt: skip
SUITE = ("references", "benchmarks", "reports")
GENERATED = "/docs/(generated|theory/__pycache__)/"
PLUGIN = "reports/pytest_galvi/"  # apart in the wheel: pytest imports it, and must not import galvi


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wheel, built from a copy so that nothing is left in the checkout, and unpacked."""
    folder = tmp_path_factory.mktemp("wheel")

    def leave_out(place: str, names: list[str]) -> set[str]:
        built = {"build", "dist"} if Path(place) == ROOT else set()
        ignored = shutil.ignore_patterns(".*", "__pycache__", "*.egg-info", "out")(place, names)
        return built & set(names) | ignored

    shutil.copytree(ROOT, folder / "source", ignore=leave_out)
    built(folder / "source", "build_wheel", folder)
    (path,) = folder.glob("*.whl")
    zipfile.ZipFile(path).extractall(folder / "unpacked")
    return folder / "unpacked"


def shipped(folder: Path) -> set[str]:
    """What of a folder of the checkout belongs to the wheel."""
    names = contents(folder)
    return {name for name in names if Path(name).suffix in SHIPPED and not name.startswith("out/")}


def contents(folder: Path) -> set[str]:
    return {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}


def test_the_wheel_holds_every_module_the_data_and_the_plugin_of_pytest(wheel: Path) -> None:
    packages = {name for name in contents(wheel) if ".dist-info/" not in name}
    suite = {f"galvi/_suite/{x}/{name}" for x in SUITE for name in shipped(ROOT / x)}
    documented = {f"galvi/_suite/docs/{name}" for name in contents(ROOT / "docs")}
    plugin = {f"pytest_galvi/{name}" for name in shipped(ROOT / PLUGIN)}
    own = {f"galvi/{name}" for name in shipped(ROOT / "galvi")}
    expected = {name for name in own | suite | documented if PLUGIN not in name} | plugin
    assert packages == {name for name in expected if not re.search(GENERATED, name)}
    assert "galvi/py.typed" in packages
    (points,) = wheel.glob("*.dist-info/entry_points.txt")
    assert "[pytest11]\ngalvi = pytest_galvi\n" in points.read_text()


@pytest.fixture(scope="module")
def folder_of_a_user(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Another project's repository of two commits: packages of the names of the suite's, a
    simulation, and the integrator and the problem of docs/suite.md."""
    place = tmp_path_factory.mktemp("user")
    for name in SUITE:
        (place / name).mkdir()
        (place / name / "__init__.py").write_text(f"raise SystemExit('{name} of the user')\n")
    page = (ROOT / "docs" / "suite.md").read_text()
    for name in ("mine.py", "my_problem.py"):
        (example,) = re.findall(rf"^```python\n# {name}\n(.*?)^```$", page, re.M | re.S)
        (place / name).write_text(example)
    git(place, "init", "--quiet")
    for name in ("first", "second"):
        git(place, "add", ".")
        git(place, "commit", "--quiet", "--allow-empty", "-m", name)
    rebound = pytest.importorskip("rebound")
    sim = rebound.Simulation()
    sim.add(m=1.0)
    sim.add(m=1e-3, a=1.0, e=0.1)
    sim.integrator, sim.dt = "whfast", 0.1
    sim.save_to_file(str(place / "simulation.bin"))
    return place


def with_kernels(place: Path) -> None:
    """Copy those of this checkout, whose sources are the same, to a copy of galvi."""
    for kernels in (ROOT / "galvi").rglob(f"__pycache__/{KERNELS_FOLDER}"):
        target = place / kernels.relative_to(ROOT)
        if not target.exists():
            shutil.copytree(kernels, target)


def ran(at: Path, *words: Any, **more: str) -> str:
    """What a program printed that ended with 0."""
    clean = {name: value for name, value in os.environ.items() if name not in OF_THESE_TESTS}
    done = subprocess.run(words, cwd=at, capture_output=True, text=True, env=clean | more)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_pytest_loads_the_plugin_of_the_wheel_and_leaves_galvis_modules_as_they_are(
    wheel: Path, tmp_path: Path
) -> None:
    """It would rewrite the asserts of all that comes with a plugin, which takes seconds."""
    (tmp_path / "test_ours.py").write_text(
        "import importlib.util, sys\n"
        "def test_ours(pytestconfig):\n"
        "    assert pytestconfig.pluginmanager.hasplugin('galvi')\n"
        "    assert not {'galvi', 'numpy'} & set(sys.modules)\n"
        "    assert 'rewrite' not in type(importlib.util.find_spec('galvi').loader).__module__\n"
    )
    others = ("-p", "no:benchmark", "-p", "no:hypothesispytest", "-p", "no:cacheprovider")
    ran(tmp_path, sys.executable, "-P", "-m", "pytest", *others, PYTHONPATH=str(wheel))


@pytest.mark.slow(
    beside="test_pytest_loads_the_plugin_of_the_wheel_and_leaves_galvis_modules_as_they_are"
)
def test_the_plugin_of_the_wheel_measures_beside_a_users_folders_of_the_suites_names(
    wheel: Path, folder_of_a_user: Path
) -> None:
    with_kernels(wheel)
    words = ("--galvi", "mine:Leapfrog", "--galvi-problem", "my_problem:spring", "-k", "accuracy")
    pytest_of_the_user = (sys.executable, "-m", "pytest", *words)
    assert "1 passed" in ran(folder_of_a_user, *pytest_of_the_user, PYTHONPATH=str(wheel))


@pytest.fixture(scope="module")
def script(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The command of an empty environment in which the wheel was installed, with its kernels."""
    place = tmp_path_factory.mktemp("environment")
    (built,) = wheel.parent.glob("*.whl")
    pip = [place / "bin" / "python", "-I", "-m", "pip", "install", "--quiet", "--no-compile"]
    asked = [f"{built}[suite]", "-c", ROOT / "constraints.txt"]
    for words in ([sys.executable, "-I", "-m", "venv", place], [*pip, *asked]):
        done = subprocess.run(words, capture_output=True, text=True)
        if done.returncode and not os.environ.get("CI"):
            pytest.skip(f"the wheel cannot be installed here: {done.stderr.strip()[-200:]}")
        assert done.returncode == 0, done.stderr
    (packages,) = place.glob("lib/python*/site-packages")
    with_kernels(packages)
    return place / "bin" / "galvi"


@pytest.mark.slow(
    beside="tests/suite/reports/test_verify.py::"
    "test_the_status_is_0_where_every_verdict_is_the_expected_one"
)
def test_an_installed_wheel_verifies_claims_of_each_kind(
    script: Path, folder_of_a_user: Path
) -> None:
    """Those with engines and stored data among them; all are judged by the tests of the claims."""
    asked = "--require", "rebound,mujoco,jplephem", "--claims", "V8,V10,L7,A3,A4,A8"
    done = ran(folder_of_a_user, script, "verify", "--quick", *asked)
    assert "every verdict is the expected one" in " ".join(done.split())
    ran(folder_of_a_user, script, "build", "--kept")
    site = folder_of_a_user / "galvi-out"
    assert 'id="V10"' in (site / "results" / "claims.html").read_text()
    assert (site / "index.html").is_file() and (site / "theory" / "frames.html").is_file()


WORKFLOW = (ROOT / "docs" / "workflow.yml").read_text()


def commands_of_the_workflow() -> list[str]:
    (job,) = yaml.safe_load(WORKFLOW)["jobs"].values()
    return [step["run"] for step in job["steps"] if "run" in step]


def test_the_workflow_to_copy_installs_the_wheel_and_runs_its_command_alone() -> None:
    first, *others = commands_of_the_workflow()
    assert first == 'pip install "./.galvi[suite]" && rm -rf .galvi'
    assert {line.split()[1] for line in others} == {"judge", "verify", "track", "compare"}
    assert all(line.startswith("galvi ") for line in others)


@pytest.mark.slow(beside="test_the_workflow_to_copy_installs_the_wheel_and_runs_its_command_alone")
@pytest.mark.parametrize("line", commands_of_the_workflow()[1:], ids=lambda line: line.split()[1])
def test_each_command_of_the_workflow_to_copy_runs_in_another_project(
    script: Path, folder_of_a_user: Path, line: str
) -> None:
    path = f"{script.parent}{os.pathsep}{os.environ['PATH']}"
    done = ran(folder_of_a_user, "bash", "-c", line, PATH=path)
    assert (folder_of_a_user / "galvi-out").is_dir()
    if line.startswith("galvi judge"):
        own = "Your run (REBOUND WHFast, coordinates jacobi, dt = 0.1) is off by up to "
        assert any(line.startswith(own) for line in done.splitlines()), done
        assert (folder_of_a_user / "galvi-out" / "judge" / "judge.html").is_file()


def test_every_requirement_has_a_pinned_version() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    groups = [project["dependencies"], *project["optional-dependencies"].values()]
    needed = {normal(requirement) for group in groups for requirement in group}
    lines = (ROOT / "constraints.txt").read_text().splitlines()
    pins = [line for line in lines if line and not line.startswith("#")]
    assert all(re.fullmatch(r"[\w.-]+==[\w.!+]+", pin) for pin in pins)
    assert needed - {normal(pin) for pin in pins} == set()


def test_the_version_is_the_same_wherever_it_is_written() -> None:
    assert f"\nversion: {RELEASE}\n" in (ROOT / "CITATION.cff").read_text()
    assert f"\n## {RELEASE}" in (ROOT / "CHANGELOG.md").read_text()
    now = galvi.__version__
    assert now.startswith(RELEASE) and provenance()["galvi"] == now
    run = galvi.integrate(
        galvi.problems.kepler(), galvi.Galerkin(galvi.Polynomials(2), galvi.gauss(2)), 0.1, 1
    )
    assert f"galvi {now} " in galvi.cite(run).sentence and f"{{{now}}}" in bibliography()


@pytest.mark.parametrize(
    ("commands", "version"),
    [
        ([], "{release}.dev0+g{commit}"),
        (["tag v2.3.4", "tag other"], "2.3.4"),
        (["tag v2.3.4", "commit --allow-empty -m more"], "{release}.dev0+g{commit}"),
        (["tag v2.3.4rc1", None], "2.3.4rc1+dirty"),
        (["tag v2.3.4-paper", None], "{release}.dev0+g{commit}.dirty"),
    ],
)
def test_the_version_is_that_of_the_tag_or_the_commit(
    commands: list[str | None], version: str, tmp_path: Path
) -> None:
    git(tmp_path, "init", "-q")
    (tmp_path / "file").write_text("1")
    git(tmp_path, "add", "file")
    git(tmp_path, "commit", "-q", "-m", "first")
    for command in commands:
        if command is None:
            (tmp_path / "file").write_text("2")
        else:
            git(tmp_path, *command.split())
    said = ran(tmp_path, "git", "rev-parse", "HEAD")[:12]
    assert version_in_git(tmp_path) == version.format(release=RELEASE, commit=said)
    assert version_in_git(tmp_path / "file") == ""


@pytest.mark.slow(beside="test_the_wheel_holds_every_module_the_data_and_the_plugin_of_pytest")
def test_an_sdist_builds_the_same_wheel(tmp_path: Path, wheel: Path) -> None:
    """Its version is that of the commit, although no git is there; wheels of both are equal."""
    clone = tmp_path / "clone"
    git(ROOT, "clone", "-q", "--no-hardlinks", str(ROOT), str(clone))
    expected = version_in_git(clone)
    assert "+g" in expected and "dirty" not in expected
    built(clone, "build_sdist", tmp_path)
    (archive,) = tmp_path.glob("*.tar.gz")
    (tmp_path / "sdist").mkdir()
    ran(tmp_path, "tar", "-xf", archive, "-C", "sdist")
    (source,) = (tmp_path / "sdist").iterdir()
    built(source, "build_wheel", tmp_path)
    (path,) = tmp_path.glob("*.whl")
    assert expected.replace("+", "-") in path.name.replace("+", "-")
    built(clone, "build_wheel", tmp_path / "other")
    (other,) = (tmp_path / "other").glob("*.whl")
    assert zipfile.ZipFile(path).namelist() == zipfile.ZipFile(other).namelist()
    assert other.name == path.name


def built(source: Path, what: str, folder: Path) -> None:
    """Build an sdist or a wheel of a source tree into a folder."""
    folder.mkdir(exist_ok=True)
    build = f"from setuptools.build_meta import {what}; {what}({str(folder)!r})"
    ran(source, sys.executable, "-c", build)


def normal(requirement: str) -> str:
    """The name in a requirement, as the package index compares names."""
    return re.sub(r"[-_.]+", "-", re.match(r"[\w.-]+", requirement)[0]).lower()
