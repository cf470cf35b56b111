"""Refusals of commands: exit status 2, one sentence on stderr, and no new file."""

from __future__ import annotations

import pickle
import shlex
from hashlib import sha256
from pathlib import Path

import pandas as pd
import pytest

from galvi.interop.judge import JudgeRequest
from galvi.interop.suite_process import HANDED_OVER
from reports.cli.commands import run
from tests.suite.reports.small_reports import claim, suite_of

OUTSIDE = """
import galvi
number = 3
RK4 = galvi.Galerkin(galvi.Polynomials(1), galvi.gauss(1))
class Leapfrog: pass
def raises(): raise RuntimeError("no, thanks")
def alone(): return galvi.problems.kepler(0.3)
def whole(): return galvi.problems.kepler(0.3), 1.0
def backwards(): return galvi.problems.kepler(0.3), -1.0
def text(): return galvi.problems.kepler(0.3), "long"
def local(): return galvi.Problem(galvi.Canonical(1.0, lambda q: q[0] ** 4), [1.0], [0.0]), 1.0
"""
TABLE, FIGURE = "export work_precision --out out", "export --all --format svg --out out"
OWN, ORDERS = "compare --problem outside", "convergence --problem outside"
JUDGE = "judge model.bin"
# The messages are those of typer, pydantic or argparse; only that they are one line is tested.
MISUSED = "verify --out", "verify x", "export", "verify --quick=yes", "--out x y", "track --only"
REFUSED = (
    *((command, "") for command in MISUSED),
    ("vrify", "No such command 'vrify'. Did you mean 'verify'?"),
    ("zzz", "No such command 'zzz'."),
    ("verify --qick", "No such option: --qick (Possible options: --quick)."),
    ("--qick", "No such option: --qick (Possible options: --quick)."),
    ("verify --xyz", "No such option: --xyz."),
    ("--quick verify", "Options follow the command, as in: python -m reports verify --q"),
    ("verify --claims V333", "There is no claim or place 'V333'; did you mean 'V33'?"),
    ("build --claims W1,V3", "There is no claim or place 'W1'; did you mean '"),
    ("verify --claims ,", "Invalid value for '--claims': Expected words, separated by"),
    ("verify --claims contenders", "add it with --contender package.module:Class, or as conten"),
    ("verify --claims A-mine", "There is no claim 'A-mine'; such claims belong to an external"),
    ("verify --claims 'H fig 3.5'", "There is no claim or place 'H fig 3.5'; did you mean 'H"),
    ("verify --claims 'V1,h fig. 3.5'", "did you mean 'H fig. 3.5'?"),
    ("verify --claims 'H (2.4)'", "No claim checks what is printed at 'H (2.4)' (false as"),
    ("verify -k top", "-k top leaves no check"),
    ("verify -k ((", "-k (( is no expression"),
    *(
        (f"verify {option} {value}", f"Invalid value for '{option}': Input should be ")
        for option in ("--timeout", "--fail-under")
        for value in ("nan", "inf", "-1", "x")
    ),
    ("verify --timeout 0", "Invalid value for '--timeout': Input should be greater"),
    ("verify --require reboun", "There is no engine 'reboun' among rebound; did you mean"),
    ("verify --require ''", "'--require': Expected words"),
    ("verify --out outside.py", "--out expects a folder to write in; received outside.py: "),
    ("verify --out link", "--out expects a folder to write in; received link: File exists."),
    ("compare --only topp", "there is no problem 'topp' to compare on; did you mean 'top'"),
    ("compare --contender outside:Leepfrog", "has no 'Leepfrog'; did you mean 'Leapfrog'"),
    ("merge empty --out new", "merge: expected folders of reports"),
    ("track --against ''", "--against expects a commit, a branch or a tag; received nothing"),
    ("track --isolate", "--only, --isolate and --contender require --against REV."),
    (f"{OWN}:raises", "it raised RuntimeError: no, thanks"),
    (f"{OWN}:alone", "must return a galvi.Problem and its duration; received Problem"),
    (f"{OWN}:backwards", "its duration must be"),
    (f"{OWN}:text", "its duration must be"),
    (f"{OWN}:number", "must be a function; received a int"),
    (f"{OWN}:raise", "did you mean 'raises'?"),
    (f"{OWN}.raises", "did you mean 'outside:raises'?"),
    ("compare --problem nowhere:raises", "there is no module 'nowhere'"),
    (f"{OWN}:local --contender a:B", "must be at the top level of their module"),
    ("convergence", "--problem package.module:function"),
    (f"{ORDERS}:alone", "duration"),
    (f"{ORDERS}:number", "must be a function"),
    (f"{ORDERS}:whole --steps 2,x", "'--steps': Expected numbers"),
    (f"{ORDERS}:whole --method gauss:x", "gauss:DEGREE"),
    (f"{ORDERS}:whole --method outside:number", "Galerkin"),
    (f"{ORDERS}:whole --method mujoco.rk4", "mujoco.rk4"),
    (f"{ORDERS}:whole --contender outside:Absent", "Absent"),
    (f"{ORDERS}:whole --method textbook.rk4 --method outside:RK4", "wo methods are called 'RK4'"),
    (f"{ORDERS}:whole --duration -1", "duration must be positive"),
    ("judge", "Missing argument 'FILE'."),
    ("judge absent.bin", "There is no file absent.bin"),
    ("judge outside.py", "must be a file of REBOUND's"),
    (f"{JUDGE} --own whfast", "'--own': Expected name=value, not 'whfast'"),
    (f"{JUDGE} --own integrator=saba,dt=0", "Own dt must not be 0"),
    (f"{JUDGE} --own dt=1e9", "Own dt must be at most the duration"),
    (f"{JUDGE} --qpos 1", "--key, --ignore, --qpos, --qvel and --ctrl are for MuJoCo"),
    (f"{JUDGE} --qpos 1,x", "'--qpos': Expected numbers, separated by commas; received"),
    (f"{JUDGE} --key 0", "are for MuJoCo models"),
    (f"{JUDGE} --out outside.py", "--out expects a folder to write in; received "),
    ("export work_precison --out out", "did you mean 'work_precision'"),
    ("export fig-2-3 --format pdf --out out", "did you mean 'fig-2-03'"),
    ("export fig-3-02 --format pdf --out out", "The rows of 'fig-3-02' are not kept in out"),
    (f"{TABLE} --format pdf", "'work_precision' is a table: add --format csv, latex"),
    (f"{TABLE} --format tex", "'--format': 'tex' is not one of 'csv', 'parquet', 'latex'"),
    (f"{TABLE} --sort eror", "did you mean 'error'"),
    (f"{TABLE} --to .", "--to expects a file; received the folder '.'."),
    (f"{TABLE} --to circle", "The command could not be carried out: "),
    (f"{TABLE} --to outside.py/c", "The command could not be carried out: "),
    (f"{TABLE} --where problem=keppler", "There is no problem 'keppler' among kepler e=0.6; did y"),
    (f"{TABLE} --where problme=a", "did you mean 'problem'"),
    (f"{TABLE} --where problem", "--where expects column=value; received 'problem'."),
    (f"{TABLE} --columns problem,eror", "did you mean 'error'"),
    (f"{TABLE} --all", "Expected exactly one of NAME, --list and --all."),
    (f"{TABLE} --list", "Expected exactly one of NAME"),
    ("export --out out", "Expected exactly one of NAME"),
    ("export --all --to x --out out", "--all does not take --to"),
    ("export --all --where a=b --out out", "are for one table"),
    ("export fig-3-02 --format pdf --columns a --out out", "are for one table"),
    (f"{FIGURE} --width colum", "'colum' is not one of 'column', 'page'"),
    (f"{FIGURE} --out damaged", "The rows of the figures are not kept in damaged; run build first"),
    ("export ratios --out empty", "holds no table yet; run compare or build first."),
    ("export torn --out damaged", "torn.csv cannot be read: No columns"),
    ("export none --where who=b --out damaged", "There is no who 'b'; there are none here."),
    ("export gaps --where who=b --out damaged", "There is no who 'b' among a"),
)


@pytest.fixture(scope="module")
def folder_and_suite(tmp_path_factory):
    """(a folder on Python's path with a compared report, a model and damaged files; the suite)."""
    rebound = pytest.importorskip("rebound")
    folder = tmp_path_factory.mktemp("place")
    (folder / "outside.py").write_text(OUTSIDE)
    for name, target in (("link", "nothing"), ("circle", "circle")):
        (folder / name).symlink_to(target)
    for name in ("empty", "damaged"):
        (folder / name).mkdir()
    tables = {"gaps": {"who": ["a", None], "x": [1.0, None]}, "none": {"who": []}, "torn": {}}
    for name, columns in tables.items():
        pd.DataFrame(columns).to_csv(folder / "damaged" / f"{name}.csv", index=False)
    sim = rebound.Simulation()
    sim.add(m=1.0)
    sim.add(m=1e-3, a=1.0)
    sim.integrator, sim.dt = "whfast", 0.05
    sim.save_to_file(str(folder / "model.bin"))
    suite = suite_of(
        *(claim(f"V{n}") for n in range(1, 100)),
        engines=lambda: {"rebound": ""},
        problems=lambda quick: ("top", "kepler e=0.6"),
    )
    assert run(suite_of, ["compare", "--out", str(folder / "out")]) == 0
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(folder))
        yield folder, suite


@pytest.mark.parametrize(("command", "message"), REFUSED, ids=[command for command, _ in REFUSED])
def test_what_cannot_be_done_is_status_2_and_a_sentence_and_nothing_is_written(
    folder_and_suite, monkeypatch, capsys, command, message
):
    folder, suite = folder_and_suite
    monkeypatch.chdir(folder)
    before = files(folder)
    assert run(lambda: suite, shlex.split(command)) == 2
    printed = capsys.readouterr()
    *progress, line = printed.err.splitlines()
    assert message in line and line[-1] in ".?" and not printed.out
    assert all(text.startswith(f"{command.split()[0]}: ") for text in progress)
    assert files(folder) == before


def files(folder):
    paths = {path for path in folder.rglob("*") if path.is_file() and path.name != ".gitignore"}
    return {path for path in paths if "__pycache__" not in path.parts}


def test_without_pyarrow_parquet_says_what_to_install(folder_and_suite, monkeypatch, capsys):
    def absent(*_, **options):
        raise ImportError("Unable to find a usable engine.")

    monkeypatch.setattr(pd.DataFrame, "to_parquet", absent)
    monkeypatch.chdir(folder_and_suite[0])
    assert run(lambda: folder_and_suite[1], [*shlex.split(TABLE), "--format", "parquet"]) == 2
    assert capsys.readouterr().err.startswith("Parquet needs pyarrow (pip install pyarrow): ")


class Opened:
    """A pickle that makes a file where it is loaded."""

    def __init__(self, path):
        self.path = path

    def __reduce__(self):
        return Path.touch, (self.path,)


@pytest.mark.parametrize(
    ("command", "digest"),
    [
        *(("judge", digest) for digest in (None, "", "0" * 64, "of another file")),
        ("convergence", "of another file"),
    ],
)
def test_a_pickle_named_on_the_command_line_is_never_loaded(
    tmp_path, monkeypatch, capsys, command, digest
):
    trace, file, request = (tmp_path / name for name in ("trace", "model", "request.json"))
    file.write_bytes(pickle.dumps(Opened(trace)))
    request.write_text(JudgeRequest(is_problem=True).to_json())
    monkeypatch.delenv(HANDED_OVER, raising=False)
    if digest is not None:
        foreign = sha256(file.read_bytes() + b".").hexdigest()
        monkeypatch.setenv(HANDED_OVER, digest.replace("of another file", foreign))
    named = {"judge": [file, "--request", request], "convergence": ["--request", file]}[command]
    assert run(None, [command, *map(str, named), "--out", str(tmp_path / "out")]) == 2
    assert f"Call galvi.{command}" in capsys.readouterr().err and not trace.exists()
