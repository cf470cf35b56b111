"""The generated pages of the command line and of the compared integrators."""

from __future__ import annotations

import csv
import re
from importlib import metadata
from pathlib import Path
from types import SimpleNamespace

import pandas as pd
import pytest
import typer

from benchmarks.work_precision.problems import work_precision_problems
from reports.cli.commands import application
from reports.cli.commands_page import commands_page
from reports.contents import SECTIONS
from reports.figures.picture import slug
from reports.figures.style.identities import OURS, TABLE, identity
from reports.results.comparison import Comparison
from reports.results.options import Options
from reports.site import build, pages
from reports.site.peers import FACTS_FILE, peers
from reports.site.report import Report
from tests.suite.reports.small_reports import suite_of

ROOT = Path(__file__).parents[3]
COMMANDS = (ROOT / "docs" / "commands.md").read_text(encoding="utf-8")
PINS = dict(re.findall(r"^([\w.-]+)==(\S+)", (ROOT / "constraints.txt").read_text(), re.M))
MACHINE_PATH = re.compile(r"/(?:home|root|tmp|work|opt|mnt|Users)/\w")


def test_the_page_of_commands_holds_every_command_and_exit_status_and_explains_each_option():
    for name in typer.main.get_command(application()).commands:
        assert f"### `galvi {name}`\n" in COMMANDS
    for code in (0, 1, 2, 130):
        assert f"`{code}`\n: " in COMMANDS
    assert not re.search(r"^\* `[^`]*`$", COMMANDS, re.M)


def test_the_page_of_commands_is_what_the_commands_say():
    """`python -m reports.cli.commands_page > docs/commands.md` renews it."""
    if metadata.version("typer") != PINS["typer"]:
        pytest.skip("another typer says it in other words")
    assert commands_page() == COMMANDS


@pytest.fixture(scope="module")
def page():
    """The page of compared integrators, beside comparisons of all problems but one."""
    names = [case.problem.name for case in work_precision_problems(quick=False)]
    compared = pd.DataFrame({"problem": names[:-1]})
    report = Report(suite_of(), Options(), [], Comparison(compared, None), [], {})
    return pages.page("peers", report)


def test_each_contender_of_a_comparison_has_a_section_that_names_its_comparisons(page):
    cases = work_precision_problems(quick=False)
    sections = dict(zip((peer.family for peer in peers()), page.split("\n## ")[1:], strict=True))
    for case in cases:
        for participant in case.participants:
            family = identity(participant.label).family
            assert family in (OURS, *TABLE)
            address = f"results/comparisons.html#{slug(case.problem.name)}"
            assert (address in sections[family]) == (case is not cases[-1])
            assert participant.label.removeprefix(family).lstrip(" ,") in sections[family]


def test_every_section_of_an_integrator_says_what_readers_ask(page):
    for peer, section in zip(peers(), page.split("\n## ")[1:], strict=True):
        assert peer.runs, f"{peer.family} is in peers.csv, and in no comparison"
        for heading in ("Order", "Steps", "Conserves", "Known limits and defects", "Sources"):
            assert re.search(rf"^{heading}\n: \S", section, re.M), (peer.family, heading)
        assert re.search(r"\d+\.\d+|not installed|this repository", peer.package)
        assert f'<a href="#{peer.anchor}">' in page
    assert not MACHINE_PATH.search(page) and not MACHINE_PATH.search(COMMANDS)


def test_the_table_of_facts_names_studies_and_files_that_exist():
    text = FACTS_FILE.read_text(encoding="utf-8")
    assert set(re.findall(r"studies\.html#([\w-]+)", text)) <= {
        section.anchor for section in SECTIONS
    }
    rows = re.findall(r"\]\((data/[\w.]+)\)", text)
    files = re.findall(r"`((?:references|reports|docs)/[\w/]+\.\w+)`", text)
    assert rows and files
    for file in (*files, *(f"docs/{name}" for name in rows)):
        assert (ROOT / file).is_file(), file


def test_a_link_that_leads_nowhere_is_found_and_outside_links_are_listed(tmp_path):
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
    sentences = build.broken_links(tmp_path, files, {"results/claims.html": {"V1"}})
    targets = (
        "../index.html#gone",
        "../odd.html",
        "../results/claims.html#V9",
        "none.html",
        "picture.png",
    )
    assert sentences == [
        f"deep/one.html: the link to {target} leads nowhere." for target in targets
    ]
    assert (tmp_path / build.EXTERNAL_LINKS_FILE).read_text() == "https://example.org/x\n"


def test_a_card_of_the_gallery_has_the_first_picture_of_its_tutorial():
    nodes = pytest.importorskip("docutils.nodes", reason="Sphinx is not installed")
    link = nodes.reference("", "The planets", refuri="planets.html", internal=True)
    card = nodes.container("", nodes.paragraph("", "", link), classes=["sd-card"])
    plots = nodes.section("", *(nodes.image(uri=f"{k}.png") for k in range(2)))
    pages = {"tutorials/planets": plots}
    app = SimpleNamespace(env=SimpleNamespace(get_doctree=pages.__getitem__))
    build.picture_cards(app, nodes.section("", card), "faq")
    assert not list(card.findall(nodes.image))
    build.picture_cards(app, nodes.section("", card), build.GALLERY)
    assert card[0]["uri"] == "0.png" and card[0]["alt"] and plots[0] is not card[0]


HIGH_ORDER = {
    "ias15": "IAS15",
    "bs": "BS",
    "whfast": "WHFast",
    "saba": "SABA",
    "trace": "TRACE",
    "mercurius": "MERCURIUS",
}


def wrong_with_forces(text):
    """Integrator of high order -> where a table such as docs/data/forces.csv says that it is
    wrong."""
    rows = list(csv.DictReader(text.splitlines()))
    wrong = {
        name: "; ".join(
            f"{row['force']}, e = {row['e']}: {row[integrator]}"
            for row in rows
            if row[integrator].startswith("wrong")
        )
        for integrator, name in HIGH_ORDER.items()
    }
    return {name: text for name, text in wrong.items() if text}


def test_an_integrator_that_is_wrong_with_a_force_is_among_the_defects():
    text = (ROOT / "docs" / "data" / "forces.csv").read_text(encoding="utf-8")
    wrong = wrong_with_forces(text)
    assert set(wrong) == {"SABA", "TRACE"} and "J2, e = 0.9: wrong by 6.7 %" in wrong["TRACE"]
    with (ROOT / "docs" / "defects.csv").open(encoding="utf-8", newline="") as file:
        lines = {line["what"].split()[0]: line for line in csv.DictReader(file)}
    assert {name: lines[name]["seen"] for name in wrong} == wrong
    planted = re.sub(r"(\ndrag,.*,refused,)[^,]+(,right for)", r"\1wrong by 9 %\2", text)
    assert planted != text
    assert any("drag" in text for text in wrong_with_forces(planted).values())
