"""The command that judges a model, and the same from Python."""

from __future__ import annotations

import json
import re
import shlex
from pathlib import Path
from types import SimpleNamespace
from xml.etree import ElementTree as tree

import numpy as np
import pytest

import galvi
from galvi.interop.judge import JudgeRequest
from references.heyoka.taylor import HEYOKA
from references.pinocchio.tree import PINOCCHIO_ACCELERATIONS
from reports.cli.assess import parse_setting
from reports.cli.commands import run
from reports.judge.files import junit_suites

rebound = pytest.importorskip("rebound")
ROOT = Path(__file__).parents[3]


@pytest.fixture(scope="module")
def model(tmp_path_factory):
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


@pytest.mark.parametrize(
    ("error", "own_error", "agreement", "until", "expected"),
    [
        (None, 1.0, 1e-9, np.inf, ["skipped", "passed"]),
        (1e-3, np.nan, np.nan, np.inf, ["failure", "skipped"]),
        (1e-3, 1e-4, 1e-2, np.inf, ["passed", "skipped"]),
        (1e-3, 1e-4, 1e-4, 3.0, ["passed", "skipped"]),
    ],
)
def test_only_an_error_that_was_asked_for_is_a_failure_and_an_unconfirmed_truth_is_none(
    error, own_error, agreement, until, expected, monkeypatch
):
    monkeypatch.setattr("reports.judge.files.own_run", lambda judgement: ["It is off."])
    monkeypatch.setattr("reports.judge.files.truth", lambda judgement: "The truth is another's.")
    judgement = SimpleNamespace(
        kind=SimpleNamespace(unit=lambda problem, quantity: " au"),
        problem=None,
        error=error or 1.0,
        own={"error": own_error, "seconds": np.nan, "integrator": "WHFast"},
        passed=own_error <= (error or 1.0),
        truth_agreement=agreement,
        trusted_until=until,
        source=SimpleNamespace(label="IAS15"),
        engines=("IAS15",),
    )
    ((name, cases),) = junit_suites(judgement, Path("model.bin"), error).items()
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
    judgement = galvi.judge(sim, duration=5.0, error=1e-6, own={"integrator": "ias15"})
    assert judgement.own["error"] < 1e-6 and judgement.own["integrator"].startswith("REBOUND IAS15")
    assert judgement.recommended is not None and judgement.table.iloc[0]["reached"]
    assert judgement.truth_agreement < 1e-9 and "<svg" in judgement._repr_html_()
    assert repr(judgement).startswith("Your run (REBOUND IAS15")


def test_what_the_command_refuses_is_a_value_error(model, suite_in_this_process):
    with pytest.raises(ValueError, match=r"Own integrator must be one of .*Choose one to judge"):
        galvi.judge(model, own={"integrator": "none"})


ARM = """<mujoco model="arm"><option timestep="0.01" integrator="RK4"/><worldbody>
<body name="upper"><joint name="a" type="hinge" axis="0 1 0"/>
<geom type="capsule" fromto="0 0 0 0.5 0 0" size="0.03" mass="1" contype="0" conaffinity="0"/>
</body></worldbody><keyframe><key qpos="0.5"/></keyframe></mujoco>"""


BEYOND = """<mujoco><worldbody><body><joint name="a" axis="0 1 0" limited="true" range="-2 2"/>
<geom size="0.1" pos="0 0 -1" mass="1"/></body><geom type="plane" size="1 1 1" pos="0 0 -5"/>
</worldbody><actuator><general joint="a" dyntype="filter"/></actuator>
<keyframe><key qpos="0"/><key name="up" qpos="0.5"/></keyframe></mujoco>"""


@pytest.mark.slow(beside="test_sources_of_every_kind_are_judged")
def test_what_is_beyond_a_tree_is_refused_in_the_words_of_the_command(tmp_path, capsys):
    pytest.importorskip("mujoco")
    (tmp_path / "arm.xml").write_text(BEYOND)
    command = ["judge", str(tmp_path / "arm.xml"), "--out", str(tmp_path), "--quick"]
    assert run(None, command) == 2
    errors = capsys.readouterr().err.splitlines()
    assert errors[-1] == 'Leave them out with --ignore "contacts,limits,actuators".'
    command += ["--ignore", "contacts,limits,actuators", "--duration", "1", "--key", "up"]
    assert run(None, command) == 0
    out, err = capsys.readouterr()
    assert out.startswith("Left out, as asked for: ") and "contacts, " in out
    assert "judge: truth: DOP853 on MuJoCo's accelerations" in err  # no terminal here
    page = (tmp_path / "judge.html").read_text()
    assert page.index("Left out, as asked for") < page.index("Your run (MuJoCo Euler")


def test_sources_of_every_kind_are_judged(suite_in_this_process):
    mujoco = pytest.importorskip("mujoco")
    exact = {"duration": 0.5, "error": 1e-3, "quick": True}
    start = galvi.judge(mujoco.MjSpec.from_string(ARM), qpos=[0.5], qvel=[0.0], **exact)
    assert start.passed and start.duration == pytest.approx(0.5) and start.notes == []
    assert {"error", "energy", "seconds"} <= set(start.own)
    assert {"integrator", "setting", "error", "energy", "seconds"} <= set(start.recommended)
    of_problem = galvi.judge(galvi.from_mujoco(ARM, key=0), **exact)
    assert of_problem.own["error"] == pytest.approx(start.own["error"], rel=1e-6)
    assert "was made from the problem" in of_problem.notes[0]
    sim = rebound.Simulation()
    sim.add(m=1.0)
    sim.add(m=1e-3, a=1.0, e=0.1)
    sim.integrator, sim.dt = "leapfrog", -0.05
    sim.heartbeat = lambda pointer: None
    orbits = galvi.judge(sim, duration=2.0, error=1e-3, quick=True)
    assert orbits.duration == pytest.approx(-2.0)
    from_problem = galvi.judge(galvi.from_rebound(sim), duration=2.0, error=1e-3, quick=True)
    assert from_problem.own["error"] == pytest.approx(orbits.own["error"], rel=1e-9)
    with pytest.raises(ValueError, match=r"there is no file no/such\.xml"):
        galvi.judge("no/such.xml")
    with pytest.raises(TypeError, match=r"a rebound\.Simulation, a mujoco\.MjModel, a galvi\.Prob"):
        galvi.judge(3)


def test_a_problem_that_judge_hands_over_is_loaded_in_its_process():
    body = galvi.Problem(galvi.RigidBody((1, 2, 2)), np.eye(3), [0.1, 0.2, 0.3])
    with pytest.raises(ValueError, match="RigidBody") as refused:
        galvi.judge(body, 1.0)
    assert "for galvi.judge" not in str(refused.value)


def test_the_own_setting_is_read():
    read = {"integrator": "saba", "dt": 0.1, "corrector": 17, "safe_mode": False, "keep": True}
    text = "integrator=saba, dt=0.1,corrector=17,safe_mode=false,keep=True"
    assert parse_setting(text) == read and type(parse_setting(text)["corrector"]) is int


def test_a_request_keeps_its_types_on_the_way_to_the_command():
    request = JudgeRequest(
        1.0,
        None,
        {"safe_mode": False, "dt": np.float64(0.1), "corrector": 17},
        key="3",
        qpos=np.array([0.5]),
    )
    received = JudgeRequest.from_json(request.to_json())
    assert received.own == {"safe_mode": False, "dt": 0.1, "corrector": 17} and received.key == "3"
    assert type(received.own["safe_mode"]) is bool and received.qpos == [0.5]


def test_a_problem_that_no_other_process_can_judge_is_refused_in_a_sentence():
    hinge = galvi.Joint("hinge", axis=(0, 1, 0))
    link = galvi.Link(hinge, 1.0, (0, 0, -1), 0.01)
    driven = galvi.Multibody([link], force=lambda q, v: -0.1 * v)
    with pytest.raises(ValueError, match="Give judge the model that it was read from"):
        galvi.judge(galvi.Problem(driven, [1.0], [0.0]), 1.0)
    pair = galvi.NBody([1.0, 1e-3], forces=(galvi.Force(lambda q: 0.0 * q),))
    with pytest.raises(ValueError, match="Define them by name in a module"):
        galvi.judge(galvi.Problem(pair, [[0, 0], [1, 0]], [[0, 0], [0, 1]]), 1.0)


# docs/judge.md: its commands print the text below them, but for times and what depends on them.

PAGE = (ROOT / "docs" / "judge.md").read_text()
OF_AN_ARM = (
    "judge docs/models/damped_arm.xml --key 0 --duration 2 --error 1e-4 --quick",
    """\
Your run (MuJoCo implicitfast, dt = 0.002) is off by up to 0.0177 rad or m over 2.00 s, and by \
0.0177 at the end (measured at 1000 times, not between them; the worst joint is hinge of link 0). \
Its forces do work, so its energy is not conserved. It takes 2.34 ms (quartiles 2.28 ms and \
2.37 ms).
The truth is DOP853 on MuJoCo's accelerations, tolerance 1e-13; runs of galvi are never the truth. \
It agrees with DOP853 on MuJoCo's accelerations, tolerance 1e-11, to 1.28·10⁻¹²; with MuJoCo RK4, \
small steps, to 1.11·10⁻¹³. galvi degree 8 agrees too, to 1.12·10⁻¹³. All of it rests on one \
engine, MuJoCo: install the extra trees (pip install pin) for Pinocchio as a second.
The cheapest that reaches an error of 1.00·10⁻⁴ rad or m is galvi degree 4, Gauss 4, dt = 0.08: \
error 5.77·10⁻⁵, in 249 µs (quartiles 234 µs and 291 µs), 7.9 to 10 times as fast as your run. As \
fast, within quartiles: galvi degree 8, Gauss 8.
See galvi-out/judge/judge.html.
""",
)
SHOWN = [
    *re.findall(r"```sh\ngalvi (judge [^\n]*)\n```\n```text\n(.*?)```", PAGE, re.DOTALL),
    OF_AN_ARM,
]
NUMBER = re.compile(r"(?<![\w])\d+(?:\.\d+)?(?:e-?\d+|·10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)?")
POWERS = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")
# Times, and phrases that may differ on a slower machine.
LOOSE = (
    r" It takes .*?\.(?= |$)",
    r" until t = [^,;.]*(?:\.\d+)?",
    r" up to t = [^;]*?slow",
    r" galvi degree \d+ agrees too, to [^ ]*\.(?= |$)",
    r"(?<=rad or m is ).*",
    r"(?<= au is ).*",
)


def without_numbers(text):
    text = text.replace("\N{NARROW NO-BREAK SPACE}", " ")
    for pattern in LOOSE:
        text = re.sub(pattern, "", text)
    return NUMBER.sub("#", text)


def numbers(sentence):
    """Numbers in the sentence on the own run, without times; any machine has the same."""
    figures = NUMBER.findall(re.sub(LOOSE[0], "", sentence))
    return [float(figure.translate(POWERS).replace("·10", "e")) for figure in figures]


TEXT_TAGS = ("properties", "system-out")


def test_the_words_of_a_summary_are_compared_and_its_errors():
    """A changed word would be noticed."""
    assert f"galvi {OF_AN_ARM[0]}\n" in PAGE
    sentence = SHOWN[0][1].splitlines()[0]
    assert without_numbers(sentence) != without_numbers(
        sentence.replace("off", "of")
    ) and "WHFast" in without_numbers(sentence)
    assert len(numbers(sentence)) >= 6 and numbers("up to 2.51·10⁻⁴ au") == [2.51e-4]


@pytest.mark.slow_cases("archive")
@pytest.mark.parametrize(("command", "shown"), SHOWN, ids=["archive", "arm"])
def test_a_command_of_the_page_says_what_the_page_shows(
    command,
    shown,
    tmp_path,
    monkeypatch,
    capsys,
):
    (tmp_path / "docs").symlink_to(ROOT / "docs")
    monkeypatch.chdir(tmp_path)
    script = re.search(r"```python\n(.*?)```", PAGE, re.DOTALL)
    assert script is not None
    exec(script.group(1), {})
    arguments = [*shlex.split(command), "--out", "galvi-out/judge"]
    status = run(None, arguments)  # type: ignore[arg-type]
    printed = capsys.readouterr().out
    if HEYOKA.missing and PINOCCHIO_ACCELERATIONS.missing:  # as on the page
        assert without_numbers(printed) == without_numbers(shown), printed
    assert numbers(printed.splitlines()[0]) == pytest.approx(
        numbers(shown.splitlines()[0]), rel=0.02
    )
    reached = "damped_arm" not in command  # as the page says
    assert status == (not reached)
    cases = tree.parse("galvi-out/judge/judge.xml").getroot().iter("testcase")
    tags = [[child.tag for child in case if child.tag not in TEXT_TAGS] for case in cases]
    assert tags == [[] if reached else ["failure"], []]  # cases: the own run, the truth
    assert json.loads(Path("galvi-out/judge/judge.json").read_text())["passed"] is reached
    page = Path("galvi-out/judge/judge.html").read_text()
    assert "<svg" in page and "What reaches the error" in page and ">nan<" not in page.lower()
