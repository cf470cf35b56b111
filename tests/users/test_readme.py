"""README.md and docs/: the code runs and prints the output shown below it, links and make targets
exist.

Each ```python block is run; if the next block is ```text, it is the output to be output_of. The
blocks of a page run in order and share their names.
"""

from __future__ import annotations

import io
import re
from contextlib import redirect_stdout
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGES = ("README.md", *sorted(f"docs/{page.name}" for page in (ROOT / "docs").glob("*.md")))

LINKED = (*PAGES, *sorted(str(page.relative_to(ROOT)) for page in ROOT.glob("docs/*/*.md")))
TUTORIALS = sorted(
    set((ROOT / "docs" / "tutorials").glob("*.md")) - {ROOT / "docs/tutorials/index.md"}
)
CELL = re.compile(r"^```\{code-cell\}\n((?::[^\n]*\n)*)(.*?)^```$", re.MULTILINE | re.DOTALL)
FENCE = re.compile(r"^```(\w*)[^\n]*\n(.*?)^```[ \t]*$", re.MULTILINE | re.DOTALL)


def examples(page: str) -> list[tuple[int, str, str | None]]:
    """(number of lines before the code, code, output shown or None) of each Python block."""
    blocks = [
        (match.group(1), match.group(2), page.count("\n", 0, match.start(2)))
        for match in FENCE.finditer(page)
    ]
    following = [*blocks[1:], ("", "", 0)][: len(blocks)]
    return [
        (lines_before, code, shown if next_language == "text" else None)
        for (language, code, lines_before), (next_language, shown, _) in zip(
            blocks, following, strict=True
        )
        if language == "python"
    ]


def output_of(code: str, lines_before: int, names: dict[str, object]) -> str:
    """The output of the code; its tracebacks have the line numbers of the page."""
    output = io.StringIO()
    with redirect_stdout(output):
        exec(compile("\n" * lines_before + code, "README.md", "exec"), names)
    return output.getvalue()


@pytest.mark.slow_cases(
    "docs/clocks.md",
    "docs/control.md",
    "docs/events.md",
    "docs/forces.md",
    "docs/judge.md",
    "docs/models.md",
    "docs/multibody.md",
    "docs/restricted.md",
)
@pytest.mark.parametrize("page", PAGES)
def test_the_code_of_a_page_prints_what_the_page_shows(
    page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, suite_in_this_process: None
) -> None:
    (tmp_path / "docs").symlink_to(ROOT / "docs")
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {"__name__": "page"}
    for lines_before, code, shown in examples((ROOT / page).read_text()):
        output = output_of(code, lines_before, names)
        if shown is not None:
            assert output == shown


@pytest.mark.parametrize("page", ["README.md", "docs/models.md"])
def test_a_page_that_shows_output_is_compared_with_it(page: str) -> None:
    assert any(shown for _, _, shown in examples((ROOT / page).read_text()))


@pytest.mark.parametrize("page", [*LINKED, "CONTRIBUTING.md"])
def test_every_link_to_a_file_leads_to_one(page: str) -> None:
    folder, generated = (ROOT / page).parent, ROOT / "docs" / "generated"  # by `make docs`
    links = re.findall(r"\]\((?!https?://|#)([^)#]+)[^)]*\)", (ROOT / page).read_text())
    files = [(folder / link).resolve() for link in links]
    assert [file for file in files if not (file.exists() or generated in file.parents)] == []


BY_TUTORIAL = pytest.mark.parametrize("page", TUTORIALS, ids=lambda page: page.stem)


@BY_TUTORIAL
def test_a_tutorial_has_a_picture_and_ends_in_assertions(page: Path) -> None:
    cells = CELL.findall(page.read_text())
    assert any("plt.subplots(" in code for _, code in cells)  # a picture for its card
    assert "remove-cell" in cells[-1][0]
    checks = cells[-1][1].strip().splitlines()
    assert checks and all(line.startswith("assert ") for line in checks)


@pytest.mark.slow(  # `make docs`, in CI, runs them too
    beside="test_the_code_of_a_page_prints_what_the_page_shows"
)
@BY_TUTORIAL
def test_a_tutorial_runs(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("matplotlib.pyplot.show", lambda: None)
    names: dict[str, object] = {"__name__": "page"}
    with redirect_stdout(io.StringIO()):
        for _, code in CELL.findall(page.read_text()):
            exec(compile(code, page.name, "exec"), names)


def test_an_output_that_differs_from_the_page_would_be_noticed() -> None:
    page = "```python\nx = 1\n```\n\n```python\nprint(x)\n```\nprints\n```text\n2\n```\n"
    (first, second) = examples(page)
    names: dict[str, object] = {}
    assert first == (1, "x = 1\n", None) and output_of(first[1], first[0], names) == ""
    assert second == (5, "print(x)\n", "2\n") and output_of(second[1], second[0], names) == "1\n"


@pytest.mark.parametrize("page", ["README.md", "CONTRIBUTING.md"])
def test_every_make_command_on_the_page_is_a_target(page: str) -> None:
    named = set(
        re.findall(r"^(?:\$ )?make ([a-z]+)|`make ([a-z]+)", (ROOT / page).read_text(), re.M)
    )
    targets = set(re.findall(r"^([a-z]+):", (ROOT / "Makefile").read_text(), re.M))
    names = {command or quoted for command, quoted in named}
    assert {"report", "test"} <= names <= targets


def test_the_life_of_a_call_names_files_and_objects_that_exist() -> None:
    page = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    assert page.startswith("# Working on galvi\n\n## Life of a call\n")
    section = page.partition("## Life of a call\n")[2].partition("\n## ")[0]
    quoted = set(re.findall(r"`([^`\n]+)`", section))
    paths = {word for word in quoted if "/" in word and word.isascii() and "NAME" not in word}
    assert paths and [path for path in paths if not (ROOT / path).exists()] == []
    folders = ("galvi", "references", "benchmarks", "tests")
    files = [path for folder in folders for path in (ROOT / folder).rglob("*.py")]
    defined = {word for x in files for word in re.findall(r"\w+", x.read_text(encoding="utf-8"))}
    names = {word for word in quoted if re.fullmatch(r"[A-Za-z_]\w+", word)}
    assert names and names - defined == set()
