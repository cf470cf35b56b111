"""What an author takes along: LaTeX that parses, numbers as they were, figures of a given width."""

from __future__ import annotations

import math
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from reports.cli.commands import run
from reports.figures.catalogue.all import FIGURES
from reports.figures.picture import WIDTHS, sized
from reports.tables.latex import as_latex, caption_of, escape
from reports.tables.macros import bibliography, macro, numbers
from reports.tables.number_format import concise, in_full, plain, siunitx

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
    assert value_of(siunitx(x))[0] == pytest.approx(x, rel=5.1e-3)


@given(st.floats(1e-12, 1e12), st.floats(1e-6, 1.0))
def test_an_uncertainty_keeps_two_digits_and_its_number_as_many(x, share):
    text = siunitx(x, share * x)
    got, error = value_of(text)
    assert error == pytest.approx(share * x, rel=0.051)
    assert abs(got - x) <= 0.51 * error
    assert 10 <= int(re.search(r"\((\d+)\)", text)[1]) <= 100


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
    assert latex.count("{measured}") == 2 and "\\begin{longtable}{lS}" in latex


def test_a_table_floats_breaks_across_pages_or_stands_sideways():
    words = "words that go on in the next line"
    few, many = (pd.DataFrame({"x": [words] * rows, "y": 1.5}) for rows in (5, 26))
    assert "\\begin{tabularx}{\\linewidth}{" in as_latex(few) and "\\begin{table}" in as_latex(few)
    assert "\\begin{xltabular}{\\linewidth}{" in as_latex(many)
    wide = as_latex(pd.DataFrame({f"column {k}": [words] * 2 for k in range(8)}))
    assert "\\begin{landscape}\\scriptsize" in wide and "\\begin{xltabular}{\\linewidth}{" in wide
    longest = as_latex(pd.DataFrame({"x": [words] * 501, "y": 1.5}), "Times.", "tab:x")
    assert longest.count("\\end{xltabular}") == 3 and "Continued from row 501." in longest
    for latex in (as_latex(few), as_latex(many), wide, longest):
        parsed(latex)
        assert latex.startswith("% needs \\usepackage{booktabs,siunitx,tabularx,xltabular,")


def overfull(folder: Path, table: str) -> list[float]:
    """Points by which boxes of a document with this table are too wide; fails where TeX does."""
    packages = re.search(r"\\usepackage\{.*?\}", table)[0]
    document = (
        f"\\documentclass{{article}}{packages}\\begin{{document}}\n{table}\\end{{document}}\n"
    )
    (folder / "table.tex").write_text(document, encoding="utf-8")
    subprocess.run(
        ["pdflatex", "-halt-on-error", "-interaction=nonstopmode", "table.tex"],
        cwd=folder, check=True, capture_output=True,
    )  # fmt: skip
    log = (folder / "table.log").read_text(encoding="utf-8", errors="replace")
    return [float(width) for width in re.findall(r"Overfull \\hbox \(([\d.]+)pt", log)]


@pytest.mark.skipif(shutil.which("pdflatex") is None, reason="pdflatex is not installed")
@pytest.mark.parametrize("columns", [1, 4, 14])
def test_tex_fits_a_table_into_the_text(tmp_path, columns):
    texts = {
        f"text {k}": ["[3pt] a_sentence/of many words_%&$#^~ 50 µm ≤ 10⁻⁸ \\x{y", "*", None] * 10
        for k in range(columns)
    }
    frame = pd.DataFrame({**texts, "ratio": [1.25e-7, "not reached", -3] * 10})
    assert max(overfull(tmp_path, as_latex(frame, "A & B", "tab:x")), default=0.0) < 5.0
    unbroken = as_latex(frame).replace("not reached", "not~reached" * 40)
    assert max(overfull(tmp_path, unbroken)) > 100.0


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
    assert [concise(3.973, e) for e in (0.02, 0.0961, 1e-9, np.nan)] == [
        "3.97(2)", "3.97(10)", "3.973(1)", "3.97",
    ]  # fmt: skip


def test_numbers_are_as_short_as_their_kind_allows():
    assert [siunitx(x) for x in (12, 0.55342, 1e-7, 1234.5, np.nan)] == [
        "12", "0.553", "1.00e-7", "1230", "",
    ]  # fmt: skip
    assert siunitx(1e-7, 2e-9) == "1.000(20)e-7" and siunitx(12000.0, 150.0) == "12000(150)"
    assert [in_full(x) for x in (40234.0, 0.1, 0.9999, 0.123456789, -2.0)] == [
        "40234", "0.1", "0.9999", "0.123", "\u22122",
    ]  # fmt: skip
    assert [plain(x) for x in (4.0, 1234.5, 3.14159e-10)] == ["4", "1230", "3.14e-10"]
