"""How much of an engine's time is generality, and whom to choose among its integrators."""

from __future__ import annotations

import numpy as np
import pandas as pd

from benchmarks.work_precision.problem import ATTITUDE, POSITION
from benchmarks.work_precision.problems.rigid_bodies import TEXTBOOK_RK4
from references.mujoco.steps import DEFAULT_STEP
from reports.figures.drawing import comparison_figure
from reports.figures.picture import picture
from reports.page.chooser import default_step
from reports.tables.comparison_tables import (
    ERRORS,
    OF_ATTITUDES,
    OF_RK4,
    errors_of,
    fastest_per_error,
    matched,
    mujoco_overhead,
    of_mujoco,
    readable_fastest,
)

GALVI = "galvi degree 8, Gauss 8, exponential"


def runs(
    slower: float = 70.0, better: float = 20.0, fails: bool = False, quantity: str = ATTITUDE
) -> pd.DataFrame:
    """MuJoCo's RK4 some times as slow and as good as the textbook's, its Euler, and galvi."""
    points = [
        *((TEXTBOOK_RK4, f"step={h}", 10.0 * h**4, 1e-4 / h) for h in (0.1, 0.01, 0.001)),
        *((OF_RK4, f"step={h}", 10.0 * h**4 / better, slower * 1e-4 / h) for h in (0.1, 0.01)),
        (OF_RK4, "step=0.001", np.nan if fails else 1e-11 / better, slower * 0.1),
        ("MuJoCo Euler", "step=0.01", 5e-3, 1e-5 if slower > 100.0 else 1.0),
        (GALVI, "step=0.5", 1e-14, 4e-5),
    ]
    frame = pd.DataFrame(points, columns=["contender", "settings", "error", "seconds"])
    return frame.assign(
        problem="body", quantity=quantity, status="", reference="closed form",
        seconds_low=frame["seconds"], seconds_high=frame["seconds"],
    )  # fmt: skip


def test_steps_of_the_two_codes_are_compared_at_equal_steps() -> None:
    said = mujoco_overhead(runs())
    assert "takes 70 times as long" in said and "20 times smaller (medians over 3" in said
    assert "over 2 step sizes" in mujoco_overhead(runs(fails=True))
    assert "an error as large" in mujoco_overhead(runs(better=1.05))
    assert "2.0 times larger" in mujoco_overhead(runs(better=0.5))


def test_without_both_codes_nothing_is_said() -> None:
    frame = runs()
    for name in (OF_RK4, TEXTBOOK_RK4):
        assert mujoco_overhead(frame[frame["contender"] != name]) == ""
        absent = frame.assign(seconds=frame["seconds"].mask(frame["contender"] == name))
        assert mujoco_overhead(absent) == ""


def test_attitudes_are_compared_at_errors_of_their_own() -> None:
    assert errors_of(runs()) == OF_ATTITUDES and errors_of(runs(quantity=POSITION)) == ERRORS
    both = pd.concat([runs(), runs(quantity=POSITION).assign(problem="planets")])
    table = matched(both)
    for problem, errors in (("body", OF_ATTITUDES), ("planets", ERRORS)):
        assert set(table.loc[table["problem"] == problem, "error"]) == set(errors)
    assert matched(both.head(0)).empty


def test_the_best_of_mujoco_has_lines_of_its_own_and_a_sentence() -> None:
    table = fastest_per_error(runs())
    chosen = table[table["of"] == "MuJoCo"].set_index("asked")["contender"]
    assert chosen[1e-4] == OF_RK4 and chosen[1e-13] == "not reached"
    assert of_mujoco(table, "body").endswith("10⁻¹²; none reaches 10⁻¹³.")
    other = of_mujoco(fastest_per_error(runs(slower=7e4)), "body")
    assert "MuJoCo Euler for 0.01; MuJoCo RK4 for 10⁻⁴" in other
    lines = readable_fastest(table, "body")
    assert list(lines[lines["error asked"] == "10⁻¹²"]["among"]) == ["all, galvi's", "MuJoCo's"]
    without = fastest_per_error(runs()[~runs()["contender"].str.startswith("MuJoCo")])
    assert set(without["of"]) == {"all", "galvi"} and of_mujoco(without, "body") == ""


def test_mujoco_s_default_step_is_answered_from_runs_on_both_sides_of_it_or_at_it() -> None:
    assert default_step(None) is None and default_step(runs(fails=True)) is None
    found = default_step(runs())
    error, quantity = (cell for cell, _ in found.rows.lines[0][1:3])
    assert (error, quantity) == ("8.0·10⁻¹²", ATTITUDE)
    assert "at a step of 0.002. Below 10⁻⁹: Body (8.0·10⁻¹²). Errors" in found.text
    assert found.text.endswith("interpolated between the neighbouring measured steps.")
    exact = runs().replace("step=0.001", f"step={DEFAULT_STEP:g}")
    exact.loc[exact["contender"] == OF_RK4, "error"] = 1e-3
    said = default_step(exact).text
    assert "Above 10⁻⁶: Body (0.0010)." in said
    assert said.endswith("run, measured.")


def test_the_picture_is_of_attitudes_and_says_what_the_lines_are() -> None:
    figure = comparison_figure("body", runs())
    assert figure.options["ylabel"].startswith("error of the attitude at the end")
    assert "exponential" not in figure.caption and "R_true" in figure.caption
    other = runs()[-1:].assign(contender="galvi degree 8, Gauss 8, Cayley")
    two = pd.concat([runs(), other], ignore_index=True)
    assert "exponential" in comparison_figure("body", two).caption
    assert picture(figure, runs()).png.startswith(b"\x89PNG")
    assert "true position" in comparison_figure("kepler", runs(quantity=POSITION)).caption
