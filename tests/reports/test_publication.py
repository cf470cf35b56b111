"""What an author takes along: LaTeX that parses, numbers as they were, figures of a given width."""

from __future__ import annotations

import math
import re
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib.font_manager import get_font

from reports.cli.commands import run
from reports.figures.catalogue.all import FIGURES
from reports.figures.picture import WIDTHS, sized
from reports.tables.latex import as_latex, caption_of, escape, number
from reports.tables.macros import bibliography, macro, numbers

FINITE = st.floats(allow_nan=False, allow_infinity=False, width=64)
SIZES = st.floats(1e-300, 1e300) | st.floats(-1e300, -1e-300)


def value_of(text: str) -> tuple[float, float | None]:
    """(number, uncertainty) of a number as siunitx reads it."""
    found = re.fullmatch(r"(-?\d+(?:\.(\d+))?)(?:\((\d+)\))?(?:e(-?\d+))?", text)
    assert found, text
    power = 10.0 ** int(found[4] or 0)
    error = None if found[3] is None else int(found[3]) * 10.0 ** -len(found[2] or "") * power
    return float(found[1]) * power, error


@given(SIZES)
def test_a_number_keeps_three_digits(x):
    assert value_of(number(x))[0] == pytest.approx(x, rel=5.1e-3)


@given(st.floats(1e-12, 1e12), st.floats(1e-6, 1.0))
def test_an_uncertainty_keeps_two_digits_and_its_number_as_many(x, share):
    text = number(x, share * x)
    got, error = value_of(text)
    if error is not None:
        assert error == pytest.approx(share * x, rel=0.051)
        assert abs(got - x) <= 0.51 * error
        assert 10 <= int(re.search(r"\((\d+)\)", text)[1]) <= 99


def parsed(text: str) -> object:
    """The nodes of LaTeX; fails where braces or environments do not match."""
    walker = pytest.importorskip("pylatexenc.latexwalker", reason="pylatexenc is not installed")
    return walker.LatexWalker(text, tolerant_parsing=False).get_latex_nodes()[0]


def cells(latex: str) -> list[int]:
    """Cells of each line of a table."""
    body = latex.split("\\midrule")[-1].replace("\\endfirsthead", "").split("\\endhead")[-1]
    lines = [line for line in body.split("\\\\\n") if "&" in line]
    return [len(re.findall(r"(?<!\\)&", line)) + 1 for line in lines]


@given(st.lists(st.tuples(st.text(max_size=12), FINITE | st.none()), min_size=1, max_size=4))
def test_any_table_parses_and_has_as_many_cells_as_columns(rows):
    frame = pd.DataFrame(rows, columns=["what _is_ 50 %", "x"])
    latex = as_latex(frame, "A & B", "tab:x")
    parsed(latex)
    for line in cells(latex):
        assert line == 2


def test_a_long_table_repeats_its_head_and_pairs_its_uncertainty():
    frame = pd.DataFrame(
        {"q": ["a"] * 60, "measured": [0.55341] * 60, "uncertainty": [0.00123] * 60}
    )
    latex = as_latex(frame, "What", "tab:q")
    parsed(latex)
    assert "0.5534(12)" in latex and "uncertainty" not in latex
    assert latex.count("{measured}") == 2 and "S[table-format=1.4(2)]" in latex


FONT = get_font(Path(mpl.get_data_path()) / "fonts" / "ttf" / "cmr10.ttf")  # TeX's own
BLOCK, BETWEEN = 345.0, 6.0  # points: a line of `article`, and the space between two columns


def points(text: str) -> float:
    """Width of a text in \\footnotesize."""
    FONT.set_size(8.0, 72.0)
    FONT.set_text(text)
    return FONT.get_width_height()[0] / 64.0


def widths(latex: str) -> list[float]:
    """Width in points of each table of a text."""
    found = []
    for table in latex.split("\\begingroup")[1:]:
        kinds = COLUMN.findall(KINDS.search(table)[1])
        body = re.split(r"\\endlastfoot\n|\\midrule\n", table)[-1]
        body = re.split(r"\\bottomrule|\\end\{longtable", body)[0]
        lines = [re.split(r"(?<!\\)&", one) for one in body.split("\\\\\n")[:-1]]
        total = BETWEEN * len(kinds)
        for (part, numeric), *cells in zip(kinds, *lines, strict=True):
            plain = [re.sub(r"\\allowbreak\{\}|[{}\\]", "", one).strip() for one in cells]
            if numeric:
                plain = [one.replace("e", " x 10") for one in plain]
            total += BLOCK * float(part) if part else max(map(points, plain))
            if part:
                words = [w for one in cells for w in re.split(r" |\\allowbreak\{\}", one.strip())]
                assert max(map(points, words)) <= BLOCK * float(part) + 1.0
        found.append(total)
    return found


COLUMN = re.compile(r">\{.*?\}p\{([\d.]+)\\linewidth\}|(S)\[[^]]*\]|l")
KINDS = re.compile(r"\\begin\{(?:tabular|longtable)\}\{(.*)\}\n")
WORDS = st.text("abcdefghij MWX_m0123456789", max_size=90)


@pytest.mark.slow(beside="test_a_table_that_is_too_wide_is_seen")
@settings(max_examples=60)
@given(st.lists(st.lists(WORDS, min_size=2, max_size=2) | st.lists(SIZES, min_size=2, max_size=2),
                min_size=1, max_size=14))  # fmt: skip
def test_a_table_fits_into_the_text_and_what_is_wider_is_several(columns):
    frame = pd.DataFrame({f"a_column_{k}": one for k, one in enumerate(columns)})
    latex = as_latex(frame, "What", "tab:q")
    parsed(latex)
    found = widths(latex)
    assert max(found) <= BLOCK + 1.0, found
    shown = re.sub(r"\\allowbreak\{\}|[{}]", "", latex)
    for k, column in enumerate(columns):
        assert re.search(rf"column(?:\\\\|\\_| ){k}\b", latex)
        for cell in column:
            text = number(cell) if isinstance(cell, float) else " ".join(cell.split())
            assert escape(text) in shown


def test_a_table_that_is_too_wide_is_seen():
    table = pd.DataFrame({"x": ["M" * 40], "y": ["W" * 20]})
    assert max(widths(as_latex(table))) <= BLOCK
    assert max(widths(as_latex(table).replace("p{0", "p{1"))) > BLOCK


def test_each_part_of_a_wide_table_tells_its_rows_apart():
    same = pd.DataFrame({f"c{k}": ["the same unbreakable words"] * 3 for k in range(14)})
    other = same.assign(c0=["one", "two", "three"])
    assert as_latex(same).count("{row}") == len(widths(as_latex(same))) > 1
    assert "{row}" not in as_latex(other) and as_latex(other).count("three &") > 1
    assert as_latex(pd.DataFrame({"a": ["[3pt] z"]})).count("{}[3pt] z") == 1


def test_a_brace_that_is_not_closed_would_be_found():
    with pytest.raises(Exception, match=r"(?i)unexpected|expected"):
        parsed(as_latex(pd.DataFrame({"x": ["a"]})).replace("\\end{tabular}", ""))


def test_signs_of_tex_and_of_mathematics_are_text():
    assert escape("50 % of a_b & {c} \\") == r"50 \% of a\_b \& \{c\} \textbackslash{}"
    assert escape("10⁻⁴ \u00d7 2") == r"10\textsuperscript{-4} \ensuremath{\times} 2"


def test_a_caption_names_machine_versions_and_commit():
    origin = {"date": "today", "cpu": "a CPU", "numpy": "2.4", "heyoka": "not installed",
              "commit": "0123456789abcdef"}  # fmt: skip
    assert caption_of("cost", origin) == (
        "Cost. Measured today; a CPU; numpy 2.4; commit 0123456789ab."
    )


@given(st.text(max_size=30))
def test_the_name_of_a_macro_has_letters_only(text):
    assert re.fullmatch("[A-Za-z]*", macro("claim", text))


@pytest.mark.slow(beside="test_the_name_of_a_macro_has_letters_only")
def test_the_numbers_of_a_report_are_macros_that_parse(make_suite, make_claim, tmp_path):
    suite = make_suite(make_claim("V1"))
    run(lambda: suite, ["build", "--out", str(tmp_path)])
    text = numbers(tmp_path)
    assert text == (tmp_path / "tables" / "numbers.tex").read_text()
    parsed("\n".join(line.partition(" % ")[0] for line in text.splitlines()))
    names = re.findall(r"\\newcommand\{\\([A-Za-z]+)\}", text)
    assert len(names) == len(set(names)) == len(text.splitlines()) - 1
    assert r"\newcommand{\claimVOneBaseOfTheError}{\num{0.250(10)}}" in text
    assert "galviCommit" in names and any(name.startswith("ratio") for name in names)
    assert "@phdthesis{Hall2013" in (tmp_path / "cite.bib").read_text()
    assert "@software" not in bibliography() and "VERSION" not in bibliography()


@pytest.mark.slow_cases(but=["fig-3-02-page"])
@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize("name", ["fig-3-02", "fig-2-06"])
def test_a_figure_is_as_wide_as_asked_and_has_its_fonts(drawn_frames, name, width):
    figure = next(one for one in FIGURES if one.name == name)
    pdf = sized(figure, drawn_frames[name], "pdf", WIDTHS[width])
    box = re.search(rb"/MediaBox \[ ?0 0 ([\d.]+) ([\d.]+)", pdf)
    assert abs(float(box[1]) / 72.0 - WIDTHS[width]) < 0.05
    assert b"/FontFile2" in pdf and b"/Type3" not in pdf
    assert math.isfinite(float(box[2])) and float(box[2]) < 72.0 * 8.0


@pytest.mark.slow(beside="test_a_figure_is_as_wide_as_asked_and_has_its_fonts")
def test_a_figure_is_exported_from_kept_rows(make_suite, make_claim, tmp_path, capsys):
    suite = make_suite(make_claim("V1"))
    run(lambda: suite, ["build", "--out", str(tmp_path)])
    capsys.readouterr()
    words = ["export", "fig-2-03", "--format", "svg", "--width", "column", "--out", str(tmp_path)]
    assert run(lambda: suite, words) == 0
    assert (tmp_path / "figures" / "fig-2-03-column.svg").read_bytes().startswith(b"<?xml")
    for wrong, said in (
        (["fig-2-3", "--format", "pdf"], "did you mean 'fig-2-03'"),
        (["fig-2-03", "--format", "pdf", "--width", "wide"], "column or page"),
        (["fig-3-02", "--format", "pdf"], "are not kept"),
    ):
        assert run(lambda: suite, ["export", *wrong, "--out", str(tmp_path)]) == 2
        assert said in capsys.readouterr().err


def test_concise_uncertainties_round_upwards_to_one_digit():
    from reports.tables.number_format import concise

    assert [concise(3.973, e) for e in (0.02, 0.0961, 1e-9, np.nan)] == [
        "3.97(2)", "3.97(10)", "3.973(1)", "3.97",
    ]  # fmt: skip
