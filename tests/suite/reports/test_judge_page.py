"""docs/judge.md: its commands say what stands below them, but for times and what rests on them."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest

from references.heyoka.taylor import HEYOKA
from references.pinocchio.tree import PINOCCHIO_ACCELERATIONS
from reports.cli.commands import run

pytest.importorskip("mujoco")
pytest.importorskip("rebound")

ROOT = Path(__file__).parents[3]
PAGE = (ROOT / "docs" / "judge.md").read_text()
SHOWN = re.findall(r"```sh\ngalvi (judge [^\n]*)\n```\n```text\n(.*?)```", PAGE, re.DOTALL)
NUMBER = re.compile(r"(?<![\w])\d+(?:\.\d+)?(?:e-?\d+|·10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)?")
POWERS = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")
# What a slower machine may have given up or found otherwise, and times.
LOOSE = (
    r" It takes .*?\.(?= |$)", r" until t = [^,;.]*(?:\.\d+)?", r" up to t = [^;]*?slow",
    r" galvi degree \d+ agrees too, to [^ ]*\.(?= |$)",
    r"(?<=rad or m is ).*", r"(?<= au is ).*",
)  # fmt: skip


def words(text: str) -> str:
    for pattern in LOOSE:
        text = re.sub(pattern, "", text)
    return NUMBER.sub("#", text)


def numbers(sentence: str) -> list[float]:
    """Those of what is said of the own run, whose truth any machine agrees on, without times."""
    found = NUMBER.findall(re.sub(LOOSE[0], "", sentence))
    return [float(one.translate(POWERS).replace("·10", "e")) for one in found]


def test_the_words_of_a_summary_are_compared_and_its_errors() -> None:
    """What would have to be noticed is."""
    said = SHOWN[0][1].splitlines()[0]
    assert words(said) != words(said.replace("off", "of")) and "WHFast" in words(said)
    assert len(numbers(said)) >= 6 and numbers("up to 2.51·10⁻⁴ au") == [2.51e-4]


@pytest.mark.slow_cases("archive")
@pytest.mark.parametrize(("command", "shown"), SHOWN, ids=["archive", "arm"])
def test_a_command_of_the_page_says_what_the_page_shows(
    command: str, shown: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    if not (HEYOKA.missing and PINOCCHIO_ACCELERATIONS.missing):
        pytest.skip("the page shows what is said without heyoka and Pinocchio")
    (tmp_path / "docs").symlink_to(ROOT / "docs")
    monkeypatch.chdir(tmp_path)
    script = re.search(r"```python\n(.*?)```", PAGE, re.DOTALL)
    assert script is not None
    exec(script.group(1), {})
    asked = [*shlex.split(command), "--out", "galvi-out/judge"]
    status = run(None, asked)  # type: ignore[arg-type]
    said = capsys.readouterr().out
    assert words(said) == words(shown), said
    assert numbers(said.splitlines()[0]) == pytest.approx(numbers(shown.splitlines()[0]), rel=0.02)
    assert status == ("damped_arm" in command)  # as the page says
