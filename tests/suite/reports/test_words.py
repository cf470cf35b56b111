"""Numbers, plain-text mathematics and sentences as people and LaTeX read them."""

from __future__ import annotations

import math
import re
import shutil
import subprocess
from pathlib import Path

import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from reports.site.claims import shared_parts, without_repetition
from reports.site.typeset import typeset
from reports.tables.latex import as_latex, caption_of, escape
from reports.tables.macros import bibliography, macro, numbers
from reports.tables.number_format import (
    concise,
    in_full,
    plain,
    readable,
    seconds,
    siunitx,
    with_uncertainty,
)
from reports.tables.summary_sentences import summary_sentences

FINITE = st.floats(allow_nan=False, allow_infinity=False, width=64)
SIZES = st.floats(1e-300, 1e300) | st.floats(-1e300, -1e-300)
ABSENT = (math.nan, math.inf, None)
WRITTEN = {
    readable: {
        0: "0",
        0.55342: "0.553",
        12.44: "12.4",
        -0.5: "\u22120.500",
        99999.0: "1.00·10⁵",
        3.14159e-10: "3.14·10⁻¹⁰",
        **dict.fromkeys(ABSENT, ""),
    },
    plain: {
        4.0: "4",
        1234.5: "1230",
        1.23456e-7: "1.23e-07",
        3.14159e-10: "3.14e-10",
        **dict.fromkeys(ABSENT, ""),
    },
    in_full: {
        40234.0: "40234",
        0.1: "0.1",
        0.9999: "0.9999",
        0.123456789: "0.123",
        1e-4: "1·10⁻⁴",
        0.9643123: "0.964",
        -2.0: "\u22122",
        **dict.fromkeys(ABSENT, ""),
    },
    seconds: {2.0: "2.00\u202fs", 0.0123: "12.3\u202fms", 4.5e-6: "4.50\u202fµs", math.nan: ""},
    siunitx: {
        12: "12",
        0.55342: "0.553",
        1e-7: "1.00e-7",
        1234.5: "1230",
        math.nan: "",
        (1e-7, 2e-9): "1.000(20)e-7",
        (12000.0, 150.0): "12000(150)",
    },
    concise: {
        (3.973, 0.02): "3.97(2)",
        (3.973, 0.0961): "3.97(10)",
        (3.973, 1e-9): "3.973(1)",
        (3.973, math.nan): "3.97",
    },
    with_uncertainty: {
        (0.553421, 0.00123): "0.5534 ± 0.0012",
        (5.0, 0.25): "5.00 ± 0.25",
        (1.5, 7.3e-6): "1.5000000 ± 0.0000073",
        (3.0, None): "3.00",
        (3.0, 0.0): "3.00",
        (1e-12, 2e-14): "1.00·10⁻¹² ± 2.0·10⁻¹⁴",
        (None, 0.1): "",
    },
}


@pytest.mark.parametrize("write", WRITTEN, ids=lambda function: function.__name__)
def test_a_number_has_the_digits_that_its_kind_needs_or_none(write):
    for number, text in WRITTEN[write].items():
        assert write(*(number if isinstance(number, tuple) else (number,))) == text


@pytest.mark.parametrize(
    ("text", "html"),
    [
        ("O(0.56^n) or so", "O(0.56<sup>n</sup>) or so"),
        ("O(h^(n/2 + 2))", "O(h<sup>n/2\u00a0+\u00a02</sup>)"),
        ("N^-(3/2 - b)", "N<sup>\u2212(3/2\u00a0\u2212\u00a0b)</sup>"),
        ("h = 2^(-j/2), j", "h\u00a0=\u00a02<sup>\u2212j/2</sup>, j"),
        ("at most 1e-10", "at most 10<sup>\u221210</sup>"),
        ("2.5e-3 of it", "2.5·10<sup>\u22123</sup> of it"),
        ("0.56 -+ 0.005", "0.56\u00a0±\u00a00.005"),
        ("1e-3 <b>", "10<sup>\u22123</sup> &lt;b&gt;"),
        ("in W^{1,1} and L^infinity", "in W<sup>1,1</sup> and L<sup>\u221e</sup>"),
        ("on 2000-01-01", "on 2000-01-01"),
        ("this - and that", "this - and that"),
    ],
)
def test_plain_mathematics_is_set(text, html):
    assert typeset(text) == html


def test_what_the_row_above_or_all_rows_say_is_not_said_again():
    long = "a long explanation of what is to be seen in this row"
    assert without_repetition(long, long) == "as above" and without_repetition("", "") == ""
    assert without_repetition(f"{long}; n = 4", f"{long}; n = 3") == "as above; n = 4"
    assert without_repetition("short; n = 4", "short; n = 3") == "short; n = 4"
    assert shared_parts(["a; b; n = 3", "a; b; n = 4"]) == ("a; b", ["n = 3", "n = 4"])
    assert shared_parts([]) == ("", [])


@pytest.mark.parametrize(
    ("times", "sentence"),
    [
        ([(1.0, 0.5)], "peer wins at 10⁻⁴ (2.0 times faster)"),
        ([(0.5, 1.0)], "galvi is fastest at 10⁻⁴"),
        ([(1.0, 1.05)], "galvi is within 10 % of peer at 10⁻⁴"),
        ([(1.05, 1.0)], "galvi is within 10 % of peer at 10⁻⁴"),
        ([(math.nan, 1.0)], "peer wins at 10⁻⁴ (not reached by galvi)"),
        ([(1.0, math.nan)], "galvi is fastest at 10⁻⁴"),
        ([(math.nan, math.nan)], "nobody reaches 10⁻⁴"),
        (
            [
                (1.0, 2.0),
                (1.6, 1.0),
                (1.7, 1.0),
                (3.0, 4.0),
                (3.0, 4.0),
                (2.0, 1.0),
                (math.nan, 1.0),
                (math.nan, math.nan),
                (math.nan, math.nan),
            ],
            "peer wins from 10⁻⁵ to 10⁻⁶ (1.6 to 1.7 times faster), at 10⁻⁹ (2.0 times faster), at "
            "10⁻¹⁰ (not reached by galvi); galvi is fastest at 10⁻⁴, from 10⁻⁷ to 10⁻⁸; nobody "
            "reaches 10⁻¹¹ to 10⁻¹²",
        ),
        (
            [(1.0, 9.0, 5e3), (1.0, 9.0, 50.0), (1.0, 9.0)],
            "galvi is fastest from 10⁻⁴ to 10⁻⁵ (peer at its loosest is 50 to 5000 times as "
            "accurate as asked), at 10⁻⁶",
        ),
    ],
)
def test_who_wins_is_said_from_the_times_of_galvi_and_a_peer(times, sentence):
    rows = []
    for k, (galvi_time, peer, *closer) in enumerate(times, 4):
        shared = {"problem": "kepler", "error": 10.0**-k, "outcome": ""}
        for contender, time in (
            ("galvi, best", galvi_time),
            ("galvi degree 8", galvi_time),
            ("peer", peer),
        ):
            beside = {"closer": closer[0] if closer else math.nan}
            rows.append(
                {
                    **shared,
                    **beside,
                    "contender": contender,
                    "seconds": time,
                    "ratio": time / galvi_time,
                }
            )
    assert summary_sentences(pd.DataFrame(rows)) == [f"Kepler: {sentence}."]


def value_of(text):
    """(number, uncertainty) of a number as siunitx reads it."""
    match = re.fullmatch(r"(-?\d+(?:\.(\d+))?)(?:\((\d+)\))?(?:e(-?\d+))?", text)
    assert match, text
    power = 10.0 ** int(match[4] or 0)
    error = None if match[3] is None else int(match[3]) * 10.0 ** -len(match[2] or "") * power
    return float(match[1]) * power, error


@given(SIZES)
def test_a_number_keeps_three_digits(x):
    assert value_of(siunitx(x))[0] == pytest.approx(x, rel=5.1e-3)


@given(st.floats(1e-12, 1e12), st.floats(1e-6, 1.0))
def test_an_uncertainty_keeps_two_digits_and_its_number_as_many(x, relative_error):
    text = siunitx(x, relative_error * x)
    number, error = value_of(text)
    assert error == pytest.approx(relative_error * x, rel=0.051)
    assert abs(number - x) <= 0.51 * error
    assert 10 <= int(re.search(r"\((\d+)\)", text)[1]) <= 100


def parsed(text):
    """The nodes of LaTeX; fails where braces or environments do not match."""
    walker = pytest.importorskip("pylatexenc.latexwalker", reason="pylatexenc is not installed")
    return walker.LatexWalker(text, tolerant_parsing=False).get_latex_nodes()[0]


def cells(latex):
    """Cells of each line of a table."""
    body = latex.split("\\midrule")[-1].replace("\\endfirsthead", "").split("\\endhead")[-1]
    lines = [line for line in body.split("\\\\\n") if "&" in line]
    return [len(re.findall(r"(?<!\\)&", line)) + 1 for line in lines]


@given(st.lists(st.tuples(st.text(max_size=12), FINITE | st.none()), min_size=1, max_size=4))
def test_any_table_parses_and_has_as_many_cells_as_columns(rows):
    latex = as_latex(pd.DataFrame(rows, columns=["what _is_ 50 %", "x"]), "A & B", "tab:x")
    parsed(latex)
    assert set(cells(latex)) <= {2}


WORDS = "words that go on in the next line"


def filled(rows, columns=1):
    return pd.DataFrame({f"column {k}": [WORDS] * rows for k in range(columns)} | {"y": 1.5})


PAIRED = pd.DataFrame({"q": ["a"] * 60, "measured": 0.55341, "uncertainty": 0.00123})


@pytest.mark.parametrize(
    ("table", "parts"),
    [
        (filled(5), {"\\begin{tabularx}{\\linewidth}{": 1, "\\begin{table}": 1}),
        (filled(26), {"\\begin{xltabular}{\\linewidth}{": 1}),
        (
            filled(2, 8),
            {"\\begin{landscape}\\scriptsize": 1, "\\begin{xltabular}{\\linewidth}{": 1},
        ),
        (filled(501), {"\\end{xltabular}": 3, "Continued from row 501.": 2}),
        (
            PAIRED,
            {"0.5534(12)": 60, "uncertainty": 0, "{measured}": 2, "\\begin{longtable}{lS}": 1},
        ),
    ],
)
def test_a_table_floats_breaks_across_pages_stands_sideways_or_pairs_uncertainties(table, parts):
    latex = as_latex(table, "Times.", "tab:x")
    parsed(latex)
    assert latex.startswith("% needs \\usepackage{booktabs,siunitx,tabularx,xltabular,")
    assert {part: latex.count(part) for part in parts} == parts


def overfull(folder, table):
    """Points by which boxes of a document with this table are too wide; fails where TeX does."""
    packages = re.search(r"\\usepackage\{.*?\}", table)[0]
    document = (
        f"\\documentclass{{article}}{packages}\\begin{{document}}\n{table}\\end{{document}}\n"
    )
    (folder / "table.tex").write_text(document, encoding="utf-8")
    subprocess.run(
        ["pdflatex", "-halt-on-error", "-interaction=nonstopmode", "table.tex"],
        cwd=folder,
        check=True,
        capture_output=True,
    )
    log = (folder / "table.log").read_text(encoding="utf-8", errors="replace")
    return [float(width) for width in re.findall(r"Overfull \\hbox \(([\d.]+)pt", log)]


@pytest.mark.skipif(shutil.which("pdflatex") is None, reason="pdflatex is not installed")
@pytest.mark.parametrize("columns", [1, 4, 14])
def test_tex_fits_a_table_into_the_text(tmp_path, columns):
    texts = {
        f"text {k}": ["[3pt] a_sentence/of many words_%&$#^~ 50 µm ≤ 10⁻⁸ \\x{y", "*", None] * 10
        for k in range(columns)
    }
    table = pd.DataFrame({**texts, "ratio": [1.25e-7, "not reached", -3] * 10})
    assert max(overfull(tmp_path, as_latex(table, "A & B", "tab:x")), default=0.0) < 5.0
    unbroken = as_latex(table).replace("not reached", "not~reached" * 40)
    assert max(overfull(tmp_path, unbroken)) > 100.0


def test_a_brace_that_is_not_closed_would_be_found():
    with pytest.raises(Exception, match=r"(?i)unexpected|expected"):
        parsed(as_latex(pd.DataFrame({"x": ["a"]})).replace("\\end{tabular}", ""))


def test_signs_of_tex_and_of_mathematics_are_text():
    assert escape("50 % of a_b & {c} \\") == r"50 \% of a\_b \& \{c\} \textbackslash{}"
    assert escape("10⁻⁴ \u00d7 2") == r"10\textsuperscript{-4} \ensuremath{\times} 2"


def test_a_caption_names_machine_versions_and_commit():
    origin = {
        "date": "today",
        "cpu": "a CPU",
        "numpy": "2.4",
        "heyoka": "not installed",
        "commit": "0123456789abcdef",
    }
    expected = "Cost. Measured today; a CPU; numpy 2.4; commit 0123456789ab."
    assert caption_of("cost", origin) == expected


@given(st.text(max_size=30))
def test_the_name_of_a_macro_has_letters_only(text):
    assert re.fullmatch("[A-Za-z]*", macro("claim", text))


@pytest.mark.slow(beside="test_the_name_of_a_macro_has_letters_only")
def test_the_numbers_of_a_report_are_macros_that_parse(ask):
    ask("build")
    text = numbers(Path("out"))
    assert text == Path("out/tables/numbers.tex").read_text()
    parsed("\n".join(line.partition(" % ")[0] for line in text.splitlines()))
    names = re.findall(r"\\newcommand\{\\([A-Za-z]+)\}", text)
    assert len(names) == len(set(names)) == len(text.splitlines()) - 1
    assert r"\newcommand{\claimVOneBaseOfTheError}{\num{0.250(10)}}" in text
    assert "galviCommit" in names and any(name.startswith("ratio") for name in names)
    assert "@phdthesis{Hall2013" in Path("out/cite.bib").read_text()
    assert "@software" not in bibliography() and "VERSION" not in bibliography()
