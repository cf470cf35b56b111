"""The wheel holds galvi, with the suite inside, and pytest's plugin; it works beside a user's own
folders."""

from __future__ import annotations

import os
import re
import runpy
import shutil
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path
from typing import Any

import pytest

import galvi
from benchmarks.store.provenance import provenance
from galvi.interop.release import RELEASE, version_in_git
from galvi.kernels.compile.cache import KERNELS_FOLDER
from reports.tables.macros import bibliography
from tests.suite.architecture.composite_job import ACTION, Job, checked_out
from tests.suite.reports import services
from tests.suite.reports.test_track_against import git

ROOT = Path(__file__).parents[3]
SHIPPED_SUFFIXES = {
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
TEST_VARIABLES = {  # variables of these tests that a user's environment lacks
    "PYTEST_DISABLE_PLUGIN_AUTOLOAD",
    "PYTEST_ADDOPTS",
    "PYTHONPATH",
    "PYTHONDONTWRITEBYTECODE",
}
SUITE = ("references", "benchmarks", "reports")
GENERATED = "/docs/(generated|theory/__pycache__)/"
# a package of its own in the wheel: pytest imports it, and must not import galvi
PLUGIN = "reports/pytest_galvi/"


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wheel, built from a copy so that nothing is left in the checkout, and unpacked."""
    folder = tmp_path_factory.mktemp("wheel")

    def leave_out(directory: str, names: list[str]) -> set[str]:
        outputs = {"build", "dist"} if Path(directory) == ROOT else set()
        ignored = shutil.ignore_patterns(".*", "__pycache__", "*.egg-info", "out")(directory, names)
        return outputs & set(names) | ignored

    shutil.copytree(ROOT, folder / "source", ignore=leave_out)
    build(folder / "source", "build_wheel", folder)
    (path,) = folder.glob("*.whl")
    zipfile.ZipFile(path).extractall(folder / "unpacked")
    return folder / "unpacked"


def shipped(folder: Path) -> set[str]:
    """Relative paths of the files of a folder that belong in the wheel."""
    names = contents(folder)
    return {
        name
        for name in names
        if Path(name).suffix in SHIPPED_SUFFIXES and not name.startswith("out/")
    }


def contents(folder: Path) -> set[str]:
    return {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}


def test_the_wheel_holds_every_module_the_data_and_the_plugin_of_pytest(wheel: Path) -> None:
    packages = {name for name in contents(wheel) if ".dist-info/" not in name}
    suite = {f"galvi/_suite/{x}/{name}" for x in SUITE for name in shipped(ROOT / x)}
    documented = {f"galvi/_suite/docs/{name}" for name in contents(ROOT / "docs")}
    plugin = {f"pytest_galvi/{name}" for name in shipped(ROOT / PLUGIN)}
    modules = {f"galvi/{name}" for name in shipped(ROOT / "galvi")}
    expected = {name for name in modules | suite | documented if PLUGIN not in name} | plugin
    assert packages == {name for name in expected if not re.search(GENERATED, name)}
    assert "galvi/py.typed" in packages
    (entry_points,) = wheel.glob("*.dist-info/entry_points.txt")
    assert "[pytest11]\ngalvi = pytest_galvi\n" in entry_points.read_text()


@pytest.fixture(scope="module")
def folder_of_a_user(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Another project's repository of two commits: packages of the names of the suite's, a
    simulation, and an integrator and a problem of docs/examples."""
    repository = tmp_path_factory.mktemp("user")
    for name in SUITE:
        (repository / name).mkdir()
        (repository / name / "__init__.py").write_text(f"raise SystemExit('{name} of the user')\n")
    for name in ("mine.py", "my_problem.py"):
        shutil.copyfile(ROOT / "docs" / "examples" / name, repository / name)
    git(repository, "init", "--quiet")
    for name in ("first", "second"):
        git(repository, "add", ".")
        git(repository, "commit", "--quiet", "--allow-empty", "-m", name)
    rebound = pytest.importorskip("rebound")
    sim = rebound.Simulation()
    sim.add(m=1.0)
    sim.add(m=1e-3, a=1.0, e=0.1)
    sim.integrator, sim.dt = "whfast", 0.1
    sim.save_to_file(str(repository / "simulation.bin"))
    return repository


def with_kernels(target_root: Path) -> None:
    """Copy this checkout's compiled kernels to a copy of galvi with the same sources."""
    for kernels in (ROOT / "galvi").rglob(f"__pycache__/{KERNELS_FOLDER}"):
        target = target_root / kernels.relative_to(ROOT)
        if not target.exists():
            shutil.copytree(kernels, target)


def output_of(folder: Path, *command: Any, **variables: str) -> str:
    """The output of a command, asserted to end with status 0."""
    clean = {name: value for name, value in os.environ.items() if name not in TEST_VARIABLES}
    completed = subprocess.run(
        command, cwd=folder, capture_output=True, text=True, env=clean | variables
    )
    assert completed.returncode == 0, completed.stdout + completed.stderr
    return completed.stdout


def test_pytest_loads_the_plugin_of_the_wheel_and_leaves_galvis_modules_as_they_are(
    wheel: Path, tmp_path: Path
) -> None:
    """pytest would rewrite the asserts of all modules beside the plugin, which takes seconds."""
    (tmp_path / "test_ours.py").write_text(
        "import importlib.util, sys\n"
        "def test_ours(pytestconfig):\n"
        "    assert pytestconfig.pluginmanager.hasplugin('galvi')\n"
        "    assert not {'galvi', 'numpy'} & set(sys.modules)\n"
        "    assert 'rewrite' not in type(importlib.util.find_spec('galvi').loader).__module__\n"
    )
    without_plugins = ("-p", "no:benchmark", "-p", "no:hypothesispytest", "-p", "no:cacheprovider")
    output_of(
        tmp_path, sys.executable, "-P", "-m", "pytest", *without_plugins, PYTHONPATH=str(wheel)
    )


@pytest.mark.slow(
    beside="test_pytest_loads_the_plugin_of_the_wheel_and_leaves_galvis_modules_as_they_are"
)
def test_the_plugin_of_the_wheel_measures_beside_a_users_folders_of_the_suites_names(
    wheel: Path, folder_of_a_user: Path
) -> None:
    with_kernels(wheel)
    options = ("--galvi", "mine:Leapfrog", "--galvi-problem", "my_problem:spring", "-k", "accuracy")
    pytest_of_the_user = (sys.executable, "-m", "pytest", *options)
    assert "1 passed" in output_of(folder_of_a_user, *pytest_of_the_user, PYTHONPATH=str(wheel))


@pytest.fixture(scope="module")
def script(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Path of the command `galvi` in a new environment with the wheel and compiled kernels."""
    environment = tmp_path_factory.mktemp("environment")
    (wheel_file,) = wheel.parent.glob("*.whl")
    pip = [environment / "bin" / "python", "-I", "-m", "pip", "install", "--quiet", "--no-compile"]
    requirements = [f"{wheel_file}[suite]", "-c", ROOT / "constraints.txt"]
    for command in ([sys.executable, "-I", "-m", "venv", environment], [*pip, *requirements]):
        completed = subprocess.run(command, capture_output=True, text=True)
        if completed.returncode and not os.environ.get("CI"):
            pytest.skip(f"the wheel cannot be installed here: {completed.stderr.strip()[-200:]}")
        assert completed.returncode == 0, completed.stderr
    (packages,) = environment.glob("lib/python*/site-packages")
    with_kernels(packages)
    return environment / "bin" / "galvi"


@pytest.mark.slow(
    beside="tests/suite/reports/test_verify.py::"
    "test_the_status_is_0_where_every_verdict_is_the_expected_one"
)
def test_an_installed_wheel_verifies_claims_of_each_kind(
    script: Path, folder_of_a_user: Path
) -> None:
    """Claims with engines and stored data among them; tests of the claims cover the others."""
    options = "--require", "rebound,mujoco,jplephem", "--claims", "V8,V10,L7,A3,A4,A8"
    printed = output_of(folder_of_a_user, script, "verify", "--quick", *options)
    assert "every verdict is the expected one" in " ".join(printed.split())
    output_of(folder_of_a_user, script, "build", "--kept")
    site = folder_of_a_user / "galvi-out"
    assert 'id="V10"' in (site / "results" / "claims.html").read_text()
    assert (site / "index.html").is_file() and (site / "theory" / "frames.html").is_file()


@pytest.mark.slow(beside="test_the_wheel_holds_every_module_the_data_and_the_plugin_of_pytest")
@pytest.mark.parametrize(
    "command",
    [
        ("judge", "simulation.bin", "--error", "1e-3"),
        ("compare", "--quick", "--contender", "mine:Leapfrog", "--problem", "my_problem:spring"),
    ],
    ids=lambda command: command[0],
)
def test_a_command_for_a_users_own_simulation_or_problem_runs_in_another_project(
    script: Path, folder_of_a_user: Path, command: tuple[str, ...]
) -> None:
    printed = output_of(folder_of_a_user, script, *command)
    assert (folder_of_a_user / "galvi-out").is_dir()
    if command[0] == "judge":
        verdict = "Your run (REBOUND WHFast, coordinates jacobi, dt = 0.1) is off by up to "
        assert any(line.startswith(verdict) for line in printed.splitlines()), printed
        assert (folder_of_a_user / "galvi-out" / "judge" / "judge.html").is_file()


@pytest.fixture
def project(tmp_path: Path) -> Path:
    """A repository with an integrator of docs/examples in src/, of two commits, tagged between."""
    repository = tmp_path / "project"
    (repository / "src").mkdir(parents=True)
    example = (ROOT / "docs" / "examples" / "mine.py").read_text(encoding="utf-8")
    shorter = example.replace("(1000, 4000, 16000)", "(1000, 4000)")
    (repository / "src" / "mine.py").write_text(shorter)
    git(repository, "init", "--quiet")
    commit(repository, "first")
    git(repository, "tag", "v1")
    commit(repository, "second")
    return repository


def commit(repository: Path, message: str) -> None:
    git(repository, "add", ".")
    git(repository, "commit", "--quiet", "--allow-empty", "-m", message)


def job(project: Path, source: Path, python: Path, event: str, **inputs: str) -> Job:
    """A job on a checkout of the project's last commit, with a Python that comes first on PATH."""
    clean = {name: value for name, value in os.environ.items() if name not in TEST_VARIABLES}
    clean["PATH"] = f"{python}{os.pathsep}{clean['PATH']}"
    checkout = checked_out(project, project.parent / "checkout")
    return Job(checkout, project.parent / "runner", source, event, clean, inputs)


@pytest.mark.parametrize(
    ("event", "base", "expected"),
    [("pull_request", "", "HEAD^1"), ("push", "", "v1"), ("push", "HEAD^1", "HEAD^1")],
)
def test_the_action_compares_with_the_base_of_a_pull_request_and_with_the_last_tag(
    project: Path, event: str, base: str, expected: str
) -> None:
    run = job(project, ROOT, Path(sys.executable).parent, event, base=base)
    run.run("machine", "base")
    assert run.passed and run.outputs["base.outputs.base"] == expected, run.printed
    assert re.fullmatch("[0-9a-f]{40}", run.outputs["machine.outputs.key"])
    git(run.project, "rev-parse", "--verify", expected)  # the checkout alone has no other commit


def test_the_action_compares_the_first_commit_of_a_repository_with_nothing(project: Path) -> None:
    git(project, "reset", "--quiet", "--hard", "v1")
    run = job(project, ROOT, Path(sys.executable).parent, "push")
    run.run("base", "track")
    assert run.passed and run.skipped == {"track"} and "::notice::" in run.printed["base"]


@pytest.mark.parametrize(
    ("contender", "contenders"),
    [
        (" ", []),
        ("mine:Leapfrog other:Its\n", ["mine:Leapfrog", "other:Its"]),
        ("m*:L;touch x $(touch x)", ["m*:L;touch", "x", "$(touch", "x)"]),
    ],
)
def test_the_action_hands_its_inputs_over_as_they_are_and_compares_what_was_not_verified(
    project: Path, tmp_path: Path, contender: str, contenders: list[str]
) -> None:
    """In the requested folder. Stand-ins for `galvi` and `python` print their folder and arguments;
    that for `galvi` fails."""
    for name, status in (("galvi", 1), ("python", 0)):
        stand_in = tmp_path / "bin" / name
        stand_in.parent.mkdir(exist_ok=True)
        stand_in.write_text(f'#!/bin/sh\nprintf "%s\\n" "$PWD" "$@"\nexit {status}\n')
        stand_in.chmod(0o755)
    (project / "src" / "m1:L;touch").touch()
    commit(project, "third")
    inputs = {"requirements": "-e .[all] 'x>1'", "timeout": "5 s", "base": "v1"}
    inputs |= {"contender": contender, "working-directory": "src"}
    run = job(project, ROOT, tmp_path / "bin", "pull_request", **inputs)
    run.run("install", "verify", "base", "track")
    options = [word for name in contenders for word in ("--contender", name)]
    for step, expected in {
        "install": [f"{ACTION.parent}/../../..[suite]", "-e", ".[all]", "'x>1'"],
        "verify": ["--claims", "contenders", "--timeout", "5 s", *options],
        "track": ["--against", "v1", "--timeout", "5 s", *options],
    }.items():
        folder, *received = run.printed[step].splitlines()
        assert Path(folder) == run.project / "src" and received[3:] == expected
    assert run.status == {"install": 0, "verify": 1, "base": 0, "track": 1}


@pytest.mark.slow(
    beside="test_the_action_compares_with_the_base_of_a_pull_request_and_with_the_last_tag"
)
@pytest.mark.parametrize("planted", [False, True], ids=["harmless", "wrong coefficient"])
def test_the_action_is_red_where_a_coefficient_is_wrong_and_green_otherwise(
    script: Path, wheel: Path, project: Path, planted: bool
) -> None:
    """Only the harmless case runs the install step, which builds from the repository's files."""
    source = project / "src" / "mine.py"
    text = source.read_text(encoding="utf-8")
    place_of_class = ("src/mine.py", str(text.splitlines().index("class Leapfrog:") + 1))
    wrong = "q = q + 0.499 * h * v" if planted else "q = q + 0.5 * h * v  # half a step"
    source.write_text(text.replace("q = q + 0.5 * h * v", wrong, 1))
    commit(project, "third")
    steps = ("base", "verify", "track") if planted else ()
    source_tree = wheel.parent / "source"
    run = job(project, source_tree, script.parent, "pull_request", contender="mine:Leapfrog")
    run.run(*steps)
    out = run.project / "galvi-out"
    assert run.passed != planted and "## verify: " in run.summary, run.printed
    verdict = "is worse than" if planted else "is not worse than"
    assert verdict in run.summary and "What the columns mean" in run.summary
    cases = services.junit_cases(out / "verify.xml") | services.junit_cases(out / "track.xml")
    cases_of_mine = [case for case in cases.values() if case["at"] == place_of_class]
    assert len(cases_of_mine) > 20
    assert services.bencher_metrics(out / "track-bencher.json").keys() >= {
        "my leapfrog, kepler e=0.3"
    }
    for step in ("verify", "track"):
        annotations = services.annotations(run.printed[step])
        assert bool(annotations) == bool(run.status[step]) == planted, run.printed[step]
        assert {(annotation["file"], annotation["line"]) for annotation in annotations} <= {
            place_of_class
        }


def test_every_requirement_has_a_pinned_version() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    groups = [project["dependencies"], *project["optional-dependencies"].values()]
    required = {normal(requirement) for group in groups for requirement in group}
    lines = (ROOT / "constraints.txt").read_text().splitlines()
    pins = [line for line in lines if line and not line.startswith("#")]
    assert all(re.fullmatch(r"[\w.-]+==[\w.!+]+", pin) for pin in pins)
    assert required - {normal(pin) for pin in pins} == set()


def test_the_version_is_the_same_wherever_it_is_written() -> None:
    assert f"\nversion: {RELEASE}\n" in (ROOT / "CITATION.cff").read_text()
    assert f"\n## {RELEASE}" in (ROOT / "CHANGELOG.md").read_text()
    version_now = galvi.__version__
    assert version_now.startswith(RELEASE) and provenance()["galvi"] == version_now
    run = galvi.integrate(
        galvi.problems.kepler(), galvi.Galerkin(galvi.Polynomials(2), galvi.gauss(2)), 0.1, 1
    )
    assert (
        f"galvi {version_now} " in galvi.cite(run).sentence
        and f"{{{version_now}}}" in bibliography()
    )


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
    commit = output_of(tmp_path, "git", "rev-parse", "HEAD")[:12]
    assert version_in_git(tmp_path) == version.format(release=RELEASE, commit=commit)
    assert version_in_git(tmp_path / "file") == ""


@pytest.mark.parametrize(
    ("commands", "version"),
    [
        ([], "{release}.dev0+g{commit}"),
        (["tag v2.3.4rc1"], "2.3.4rc1"),
        (["tag v2.3.4", "commit --allow-empty -m more"], "{release}.dev0+g{commit}"),
        (["tag other"], "{release}.dev0+g{commit}"),
    ],
)
def test_an_archive_of_git_has_the_version_of_its_commit(
    commands: list[str], version: str, tmp_path: Path
) -> None:
    """GitHub distributes actions as such archives; setup.py takes the version from release.py."""
    clone, archive = tmp_path / "clone", tmp_path / "archive"
    for name in (".gitattributes", "galvi/interop/release.py"):
        (clone / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(ROOT / name, clone / name)
    git(clone, "init", "-q")
    git(clone, "add", ".")
    git(clone, "commit", "-q", "-m", "first")
    for command in commands:
        git(clone, *command.split())
    git(clone, "archive", "--output", str(tmp_path / "archive.tar"), "HEAD")
    archive.mkdir()
    output_of(tmp_path, "tar", "-xf", "archive.tar", "-C", archive)
    release = runpy.run_path(str(archive / "galvi" / "interop" / "release.py"))
    commit = output_of(clone, "git", "rev-parse", "HEAD")[:12]
    assert release["version_in_git"](archive) == version.format(release=RELEASE, commit=commit)


@pytest.mark.slow(beside="test_the_wheel_holds_every_module_the_data_and_the_plugin_of_pytest")
def test_an_sdist_builds_the_same_wheel(tmp_path: Path, wheel: Path) -> None:
    """Its version is that of the commit, though it has no git; both wheels hold the same files."""
    clone = tmp_path / "clone"
    git(ROOT, "clone", "-q", "--no-hardlinks", str(ROOT), str(clone))
    expected = version_in_git(clone)
    assert "+g" in expected and "dirty" not in expected
    build(clone, "build_sdist", tmp_path)
    (archive,) = tmp_path.glob("*.tar.gz")
    (tmp_path / "sdist").mkdir()
    output_of(tmp_path, "tar", "-xf", archive, "-C", "sdist")
    (source,) = (tmp_path / "sdist").iterdir()
    build(source, "build_wheel", tmp_path)
    (path,) = tmp_path.glob("*.whl")
    assert expected.replace("+", "-") in path.name.replace("+", "-")
    build(clone, "build_wheel", tmp_path / "other")
    (rebuilt,) = (tmp_path / "other").glob("*.whl")
    assert zipfile.ZipFile(path).namelist() == zipfile.ZipFile(rebuilt).namelist()
    assert rebuilt.name == path.name


def build(source: Path, hook: str, folder: Path) -> None:
    """Build an sdist or a wheel of a source tree into a folder."""
    folder.mkdir(exist_ok=True)
    program = f"from setuptools.build_meta import {hook}; {hook}({str(folder)!r})"
    output_of(source, sys.executable, "-c", program)


def normal(requirement: str) -> str:
    """The package's name in a requirement, normalised as the package index does."""
    return re.sub(r"[-_.]+", "-", re.match(r"[\w.-]+", requirement)[0]).lower()
