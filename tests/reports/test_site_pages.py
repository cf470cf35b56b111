"""The generated pages of the command line and of the compared integrators."""

from __future__ import annotations

import re
from importlib import metadata
from itertools import chain
from pathlib import Path
from types import SimpleNamespace

import pytest
import typer

from benchmarks.work_precision.problems import work_precision_problems
from reports.cli.commands import application
from reports.cli.commands_page import commands_page
from reports.contents import SECTIONS
from reports.figures.style.identities import OURS, TABLE, identity
from reports.site import build, defects, peers
from reports.site.build import write_pages

ROOT = Path(__file__).parents[2]
COMMANDS = (ROOT / "docs" / "commands.md").read_text(encoding="utf-8")
PEERS = dict(peers.pages())
PINS = dict(re.findall(r"^([\w.-]+)==(\S+)", (ROOT / "constraints.txt").read_text(), re.M))
A_MACHINE = re.compile(r"/(?:home|root|tmp|work|opt|mnt|Users)/\w")


def test_the_page_of_commands_holds_every_command_option_and_exit_status() -> None:
    group = typer.main.get_command(application())
    for name, command in group.commands.items():
        _, _, section = COMMANDS.partition(f"### `galvi {name}`\n")
        section = section.partition("\n### ")[0]
        assert command.help.split(".")[0] in section, name
        for one in command.params:
            shown = one.opts[0] if one.param_type_name == "option" else one.metavar
            assert (f"`{shown}" in section) != bool(getattr(one, "hidden", False)), (name, shown)
    for code in (0, 1, 2, 130):
        assert f"`{code}`\n: " in COMMANDS
    assert not re.search(r"^\* `[^`]*`$", COMMANDS, re.M)  # every option says what it does


def test_the_page_of_commands_is_what_the_commands_say() -> None:
    """`python -m reports.cli.commands_page > docs/commands.md` renews it."""
    if metadata.version("typer") != PINS["typer"]:
        pytest.skip("another typer says it in other words")
    assert commands_page() == COMMANDS


def test_each_contender_of_a_comparison_has_a_page_that_names_its_comparisons() -> None:
    pages = {one.family: PEERS[f"peers/{one.file}.md"] for one in peers.peers()}
    for case in work_precision_problems(quick=False):
        for one in case.participants:
            family = identity(one.label).family
            assert family in (OURS, *TABLE)
            page = pages[family]
            assert f"results/comparisons.html#{peers.slug(case.problem.name)}" in page
            assert one.label.removeprefix(family).lstrip(" ,") in page


def test_every_page_of_an_integrator_says_what_readers_ask() -> None:
    for one in peers.peers():
        page = PEERS[f"peers/{one.file}.md"]
        assert one.runs, f"{one.family} is in peers.csv, and in no comparison"
        for heading in ("Order", "Steps", "Conserves", "Known limits and defects", "Sources"):
            assert re.search(rf"^{heading}\n: \S", page, re.M), (one.family, heading)
        assert one.package == "" or re.search(r"\d+\.\d+|not installed", one.package)
        assert f"({one.file}.md)" in PEERS["peers/index.md"]


def test_the_table_of_facts_names_studies_and_files_that_exist() -> None:
    text = peers.FACTS.read_text(encoding="utf-8")
    anchors = {one.name.replace("_", "-") for one in SECTIONS}
    assert set(re.findall(r"studies\.html#([\w-]+)", text)) <= anchors
    rows = re.findall(r"\]\(\.\./\.\./(data/[\w.]+)\)", text)
    for file in (*peers.FILE.findall(text), *(f"docs/{name}" for name in rows)):
        assert (ROOT / file).is_file(), file


def test_settings_are_said_in_short() -> None:
    best = r"- best: \d+ settings: step [\d.]+ to [\d.]+ d, `corrector` 17, "
    assert re.search(best, PEERS["peers/rebound-whfast.md"])


def test_no_generated_page_names_a_place_of_this_machine() -> None:
    for file, text in chain([("commands.md", COMMANDS)], peers.pages()):
        assert not A_MACHINE.search(text) and str(ROOT) not in text, file


def test_a_page_is_written_when_it_changes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(build.peers, "pages", lambda: iter([("peers/one.md", "# One\n")]))
    write_pages(tmp_path)
    page = tmp_path / "generated" / "peers" / "one.md"
    assert page.read_text() == "# One\n"
    before = page.stat().st_mtime_ns
    write_pages(tmp_path)
    assert page.stat().st_mtime_ns == before


def test_a_link_that_leads_nowhere_is_found_and_outside_links_are_listed(tmp_path: Path) -> None:
    texts = {
        "index.html": '<h1 id="top">A</h1><a href="deep/one.html#here">1</a><a href="#top">2</a>'
        '<a href="results/claims.html#V1">3</a><a href="https://example.org/x">4</a>',
        "results/claims.html": "<p>",
        "deep/one.html": '<p id="here"><a href="../index.html#gone">1</a><a href="none.html">2</a>'
        '<img src="picture.png"><a href="../results/claims.html#V9">3</a>'
        '<a href="../odd.html">4</a>',
    }
    for name, text in texts.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    files = [tmp_path / name for name in texts]
    sentences = build.broken(tmp_path, files, {"results/claims.html": {"V1"}})
    targets = ("../index.html#gone", "../odd.html", "../results/claims.html#V9", "none.html",
               "picture.png")  # fmt: skip
    assert sentences == [f"deep/one.html: the link to {one} leads nowhere." for one in targets]
    assert (tmp_path / build.OUTSIDE).read_text() == "https://example.org/x\n"


def test_a_card_of_the_gallery_has_the_first_picture_of_its_tutorial() -> None:
    nodes = pytest.importorskip("docutils.nodes", reason="Sphinx is not installed")
    link = nodes.reference("", "The planets", refuri="planets.html", internal=True)
    card = nodes.container("", nodes.paragraph("", "", link), classes=["sd-card"])
    plots = nodes.section("", *(nodes.image(uri=f"{k}.png") for k in range(2)))
    pages = {"tutorials/planets": plots}
    app = SimpleNamespace(env=SimpleNamespace(get_doctree=pages.__getitem__))
    build.picture_cards(app, nodes.section("", card), "faq")
    assert not list(card.findall(nodes.image))
    without = {"tutorials/planets": nodes.section("")}  # as where the tutorials were not run
    bare = SimpleNamespace(env=SimpleNamespace(get_doctree=without.__getitem__))
    build.picture_cards(bare, nodes.section("", card), build.GALLERY)
    assert not list(card.findall(nodes.image))
    build.picture_cards(app, nodes.section("", card), build.GALLERY)
    assert card[0]["uri"] == "0.png" and card[0]["alt"] and plots[0] is not card[0]


def test_an_integrator_that_is_wrong_with_a_force_is_on_the_page_of_defects() -> None:
    text = defects.FORCES.read_text(encoding="utf-8")
    found = {line["what"].split()[0]: line for line in defects.of_forces(text)}
    assert set(found) == {"SABA", "TRACE"} and "rebound" in found["SABA"]["versions"].lower()
    assert "J2, e = 0.9: wrong by 6.7 %" in found["TRACE"]["seen"]
    ((_, page),) = defects.pages()
    assert found["SABA"]["seen"] in page and page.index("SABA") < page.index("## Reported")
    planted = re.sub(r"(\| drag .* refused \|) [^|]+(\| right for)", r"\1 wrong by 9 % \2", text)
    assert planted != text
    assert any("drag" in line["seen"] for line in defects.of_forces(planted))
