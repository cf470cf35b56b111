"""The command that judges a model, and the same from Python."""

from __future__ import annotations

import hashlib
import json
import pickle
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from xml.etree import ElementTree as tree

import numpy as np
import pytest

import galvi
from galvi.interop.judge import JudgeRequest
from galvi.interop.suite_process import HANDED_OVER
from reports.cli.assess import setting
from reports.cli.commands import run
from reports.judge.files import junit_suites

OWN = "Your run (REBOUND WHFast, coordinates jacobi, dt = 0.05) "
rebound = pytest.importorskip("rebound")
ROOT = Path(__file__).parents[3]


@pytest.fixture(scope="module")
def model(tmp_path_factory) -> Path:
    """A star with two planets, integrated with WHFast at 1/20 of a year."""
    sim = rebound.Simulation()
    sim.units = ("AU", "yr", "Msun")
    sim.add(m=1.0, name="Star")
    sim.add(m=1e-4, a=1.0, e=0.05, name="Inner")
    sim.add(m=1e-4, a=1.7, e=0.02, f=2.0, name="Outer")
    sim.move_to_com()
    sim.integrator = "whfast"
    sim.dt = 0.05
    path = tmp_path_factory.mktemp("model") / "model.bin"
    sim.save_to_file(str(path))
    return path


@pytest.mark.slow(beside="test_sources_of_every_kind_are_judged")
def test_the_command_answers_and_its_status_says_whether_the_error_is_reached(
    model, tmp_path, capsys
):
    asked = ["--error", "1e-6", "--duration", "20", "--out", str(tmp_path / "out")]
    assert run(None, ["judge", str(model), *asked]) == 1
    said = capsys.readouterr().out
    assert said.startswith(OWN + "is off by up to ")
    for words in (" au over 20.0 yr", "(measured at 400 times, not", "The cheapest that reaches"):
        assert words in said
    found = json.loads((tmp_path / "out" / "judge.json").read_text())
    assert found["passed"] is False and found["recommended"]["error"] <= 1e-6
    assert found["truth_agreement"] < 1e-9 < 1e-6 < found["own"]["error"]
    page = (tmp_path / "out" / "judge.html").read_text()
    for word in ("Inner", "<svg", "What reaches the error", "REBOUND SABA", "rebound"):
        assert word in page
    assert ">nan<" not in page.lower()
    assert outcomes(tmp_path / "out") == ["failure", "passed"]
    enough = [str(model), "--error", "1.0", "--duration", "5", "--out", str(tmp_path)]
    assert run(None, ["judge", *enough]) == 0, capsys.readouterr().err
    assert outcomes(tmp_path) == ["passed", "passed"]


def outcomes(folder: Path) -> list[str]:
    """In judge.xml, of the own run and of the truth."""
    cases = tree.parse(folder / "judge.xml").getroot().iter("testcase")
    tags = [[child.tag for child in case if child.tag != "system-out"] for case in cases]
    return [(tag or ["passed"])[0] for tag in tags]


@pytest.mark.parametrize(
    ("error", "own", "agreement", "until", "expected"),
    [
        (None, 1.0, 1e-9, np.inf, ["skipped", "passed"]),
        (1e-3, np.nan, np.nan, np.inf, ["failure", "skipped"]),
        (1e-3, 1e-4, 1e-2, np.inf, ["passed", "skipped"]),
        (1e-3, 1e-4, 1e-4, 3.0, ["passed", "skipped"]),
    ],
)
def test_only_an_error_that_was_asked_for_is_a_failure_and_an_unconfirmed_truth_is_none(
    error, own, agreement, until, expected, monkeypatch
):
    monkeypatch.setattr("reports.judge.files.own_run", lambda found: ["It is off."])
    monkeypatch.setattr("reports.judge.files.truth", lambda found: "The truth is another's.")
    found = SimpleNamespace(
        kind=SimpleNamespace(unit=lambda problem, what: " au"), problem=None, error=error or 1.0,
        own={"error": own, "seconds": np.nan, "integrator": "WHFast"}, passed=own <= (error or 1.0),
        truth_agreement=agreement, trusted_until=until,
    )  # fmt: skip
    ((name, cases),) = junit_suites(found, "model.bin", error).items()
    assert name == "model.bin" and [case.outcome for case in cases] == expected


@pytest.mark.slow(beside="test_sources_of_every_kind_are_judged")
def test_the_same_from_python(model, tmp_path, monkeypatch):
    """In a process of its own, which must not import a user's own folder of the same name."""
    (tmp_path / "benchmarks").mkdir()
    (tmp_path / "benchmarks" / "__init__.py").write_text("raise SystemExit('the wrong one')\n")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    monkeypatch.setenv("PATH", "")
    sim = rebound.Simulation(str(model))
    found = galvi.judge(sim, duration=5.0, error=1e-6, own={"integrator": "ias15"})
    assert found.own["error"] < 1e-6 and found.own["integrator"].startswith("REBOUND IAS15")
    assert found.recommended is not None and found.table.iloc[0]["reached"]
    assert found.truth_agreement < 1e-9 and "<svg" in found._repr_html_()
    assert repr(found).startswith("Your run (REBOUND IAS15")
    sim.softening = 0.1
    with pytest.raises(ValueError, match="softening"):
        galvi.judge(sim)
    with pytest.raises(
        TypeError, match=r"a rebound\.Simulation, a mujoco\.MjModel, a galvi\.Problem, the text"
    ):
        galvi.judge(3)


def test_what_the_command_refuses_is_a_value_error(model, suite_in_this_process):
    with pytest.raises(ValueError, match=r"Own integrator must be one of .*Choose one to judge"):
        galvi.judge(model, own={"integrator": "none"})


@pytest.mark.slow_cases("arguments7-Did you mean")
@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["absent.bin"], "There is no file absent.bin"),
        ([__file__], "must be a file of REBOUND's"),
        ([], "FILE"),
        (["FILE", "--own", "whfast"], "'--own': Expected name=value, not 'whfast'"),
        (["FILE", "--own", "integrator=saba,dt=0"], "Own dt must not be 0"),
        (["FILE", "--qpos", "1"], "--key, --ignore, --qpos, --qvel and --ctrl are for MuJoCo"),
        (["FILE", "--qpos", "1,x"], "'--qpos': Expected numbers, separated by commas; received"),
        (["FILE", "--own", "integrator=saba,dt=0.1,kind=3"], "Did you mean"),
        (["FILE", "--own", "dt=1e9"], "Own dt must be at most the duration"),
        (["FILE", "--key", "0"], "are for MuJoCo models"),
        (["FILE", "--out", __file__], "--out expects a folder to write in; received "),
    ],
)
def test_what_cannot_be_judged_is_refused_in_a_sentence(
    arguments, sentence, model, tmp_path, capsys
):
    given = [str(model) if one == "FILE" else one for one in arguments]
    given += [] if "--out" in given else ["--out", str(tmp_path)]
    assert run(None, ["judge", *given]) == 2
    assert sentence in capsys.readouterr().err


ARM = """<mujoco model="arm"><option timestep="0.01" integrator="RK4"/><worldbody>
<body name="upper"><joint name="a" type="hinge" axis="0 1 0"/>
<geom type="capsule" fromto="0 0 0 0.5 0 0" size="0.03" mass="1" contype="0" conaffinity="0"/>
</body></worldbody><keyframe><key qpos="0.5"/></keyframe></mujoco>"""


@pytest.mark.slow(beside="test_sources_of_every_kind_are_judged")
def test_a_model_of_mujoco(tmp_path, capsys, suite_in_this_process):
    mujoco = pytest.importorskip("mujoco")
    (tmp_path / "arm.xml").write_text(ARM)
    given = [str(tmp_path / "arm.xml"), "--duration", "1", "--error", "1e-12", "--key", "0"]
    assert run(None, ["judge", *given, "--out", str(tmp_path)]) == 1
    said = capsys.readouterr().out
    assert "Your run (MuJoCo RK4, dt = 0.01) is off by up to" in said
    assert " rad or m over 1.00 s, and by " in said and "the worst joint is a)" in said
    page = (tmp_path / "judge.html").read_text()
    assert "Close encounters" not in page and "joint by joint" in page
    found = galvi.judge(mujoco.MjModel.from_xml_string(ARM), duration=1.0, error=1e-3)
    assert found.own["error"] < 1e-3 and found.recommended is not None
    assert run(None, ["judge", *given[:-1], "3", "--out", str(tmp_path)]) == 2
    assert "ey must be a whole number from 0 to 0" in capsys.readouterr().err


BEYOND = """<mujoco><worldbody><body><joint name="a" axis="0 1 0" limited="true" range="-2 2"/>
<geom size="0.1" pos="0 0 -1" mass="1"/></body><geom type="plane" size="1 1 1" pos="0 0 -5"/>
</worldbody><actuator><general joint="a" dyntype="filter"/></actuator>
<keyframe><key qpos="0"/><key name="up" qpos="0.5"/></keyframe></mujoco>"""


@pytest.mark.slow(beside="test_what_cannot_be_judged_is_refused_in_a_sentence")
def test_what_is_beyond_a_tree_is_refused_in_the_words_of_the_command(tmp_path, capsys):
    pytest.importorskip("mujoco")
    (tmp_path / "arm.xml").write_text(BEYOND)
    given = ["judge", str(tmp_path / "arm.xml"), "--out", str(tmp_path), "--quick"]
    assert run(None, given) == 2
    said = capsys.readouterr().err.splitlines()
    assert [line.partition(":")[0] for line in said[1:-1]] == [
        "  contacts",
        "  limits",
        "  actuators",
    ]
    assert said[-1] == 'Leave them out with --ignore "contacts,limits,actuators".'
    given += ["--ignore", "contacts,limits,actuators", "--duration", "1", "--key", "up"]
    assert run(None, given) == 0
    out, err = capsys.readouterr()
    assert out.startswith("Left out, as asked for: ") and "contacts, " in out
    assert "judge: truth: DOP853 on MuJoCo's accelerations" in err  # no terminal here
    page = (tmp_path / "judge.html").read_text()
    assert page.index("Left out, as asked for") < page.index("Your run (MuJoCo Euler")
    with pytest.raises(ValueError, match=r"Leave them out with ignore=\('contacts', 'limits'"):
        galvi.judge(BEYOND)


def test_sources_of_every_kind_are_judged(tmp_path, suite_in_this_process):
    mujoco = pytest.importorskip("mujoco")
    exact = {"duration": 0.5, "error": 1e-3, "quick": True}
    by_text = galvi.judge(ARM, key=0, **exact)
    assert by_text.passed and by_text.duration == pytest.approx(0.5) and by_text.notes == []
    assert {"error", "energy", "seconds"} <= set(by_text.own)
    assert {"integrator", "setting", "error", "energy", "seconds"} <= set(by_text.recommended)
    start = galvi.judge(mujoco.MjSpec.from_string(ARM), qpos=[0.5], qvel=[0.0], **exact)
    assert start.own["error"] == by_text.own["error"]
    problem = galvi.from_mujoco(ARM, key=0)
    alone = galvi.judge(problem, **exact)
    assert alone.own["error"] == pytest.approx(by_text.own["error"], rel=1e-6)
    assert "was made from the problem" in alone.notes[0]
    sim = rebound.Simulation()
    sim.add(m=1.0)
    sim.add(m=1e-3, a=1.0, e=0.1)
    sim.integrator, sim.dt = "leapfrog", -0.05
    sim.heartbeat = lambda pointer: None
    orbits = galvi.judge(sim, duration=5.0, error=1e-3, quick=True)
    assert orbits.duration == pytest.approx(-5.0)
    again = galvi.judge(galvi.from_rebound(sim), duration=5.0, error=1e-3, quick=True)
    assert again.own["error"] == pytest.approx(orbits.own["error"], rel=1e-9)
    with pytest.raises(ValueError, match=r"there is no file no/such\.xml"):
        galvi.judge("no/such.xml")


def test_the_own_setting_is_read():
    assert setting("integrator=whfast, dt=0.1,corrector=17") == {
        "integrator": "whfast", "dt": 0.1, "corrector": 17,
    }  # fmt: skip


def test_the_command_without_the_suite_says_what_to_install(tmp_path):
    code = (
        "import sys; sys.modules['typer'] = None\n"
        "from galvi.command import main\n"
        "sys.argv = ['galvi', 'verify']\n"
        "sys.exit(main())\n"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 3
    assert "pip install 'galvi[suite]'" in done.stderr


def test_a_request_keeps_its_types_on_the_way_to_the_command() -> None:
    asked = JudgeRequest(
        1.0, None, {"safe_mode": False, "dt": np.float64(0.1), "corrector": 17}, key="3",
        qpos=np.array([0.5]),
    )  # fmt: skip
    found = JudgeRequest.from_json(asked.to_json())
    assert found.own == {"safe_mode": False, "dt": 0.1, "corrector": 17} and found.key == "3"
    assert type(found.own["safe_mode"]) is bool and found.qpos == [0.5]


def test_true_and_false_are_flags_of_the_own_integrator() -> None:
    assert setting("safe_mode=false,keep=True") == {"safe_mode": False, "keep": True}


def test_a_problem_that_no_other_process_can_judge_is_refused_in_a_sentence() -> None:
    hinge = galvi.Joint("hinge", axis=(0, 1, 0))
    link = galvi.Link(hinge, 1.0, (0, 0, -1), 0.01)
    driven = galvi.Multibody([link], force=lambda q, v: -0.1 * v)
    with pytest.raises(ValueError, match="Give judge the model that it was read from"):
        galvi.judge(galvi.Problem(driven, [1.0], [0.0]), 1.0)
    pair = galvi.NBody([1.0, 1e-3], forces=(galvi.Force(lambda q: 0.0 * q),))
    with pytest.raises(ValueError, match="Define them by name in a module"):
        galvi.judge(galvi.Problem(pair, [[0, 0], [1, 0]], [[0, 0], [0, 1]]), 1.0)


class Opened:
    """A pickle that makes a file where it is loaded."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def __reduce__(self):
        return Path.touch, (self.path,)


@pytest.mark.parametrize("digest", [None, "", "0" * 64, "of another file"])
def test_a_pickle_named_on_the_command_line_is_never_loaded(tmp_path, monkeypatch, capsys, digest):
    trace, file, request = (tmp_path / name for name in ("trace", "model", "request.json"))
    file.write_bytes(pickle.dumps(Opened(trace)))
    request.write_text(JudgeRequest(is_problem=True).to_json())
    monkeypatch.delenv(HANDED_OVER, raising=False)
    if digest is not None:
        other = hashlib.sha256(file.read_bytes() + b".").hexdigest()
        monkeypatch.setenv(HANDED_OVER, digest.replace("of another file", other))
    words = ["judge", str(file), "--request", str(request), "--out", str(tmp_path / "out")]
    assert run(None, words) == 2
    assert "Call galvi.judge(problem) in Python." in capsys.readouterr().err
    assert not trace.exists()


def test_a_problem_that_judge_hands_over_is_loaded_in_its_process():
    body = galvi.Problem(galvi.RigidBody((1, 2, 2)), np.eye(3), [0.1, 0.2, 0.3])
    with pytest.raises(ValueError, match="RigidBody") as refused:
        galvi.judge(body, 1.0)
    assert "for galvi.judge" not in str(refused.value)
