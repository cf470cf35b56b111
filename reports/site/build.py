"""What Sphinx does besides: writes the generated pages, brings MathJax, and checks the links."""

from __future__ import annotations

import os
import shutil
from importlib.util import find_spec
from itertools import chain
from pathlib import Path
from typing import Any

from reports.site import commands, links, peers, reference

FOLDER = "generated"
MATHJAX = "mathjax/tex-svg.js"  # under _static


def write_pages(source: Path) -> None:
    """Write every generated page whose text has changed, and remove those that no longer are."""
    folder = source / FOLDER
    pages = dict(chain(reference.pages(), commands.pages(), peers.pages()))
    for path in folder.rglob("*.md"):
        if str(path.relative_to(folder)) not in pages:
            path.unlink()
    for name, text in pages.items():
        path = folder / name
        if not path.is_file() or path.read_text(encoding="utf-8") != text:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8")


def copy_mathjax(static: Path) -> None:
    """One file of MathJax, so that formulas are read without a network."""
    found = find_spec("mathjax")
    assert found is not None and found.submodule_search_locations is not None
    (folder,) = found.submodule_search_locations
    (static / MATHJAX).parent.mkdir(parents=True, exist_ok=True)
    shutil.copy(Path(folder) / "static" / "mathjax" / "es5" / Path(MATHJAX).name, static / MATHJAX)


def quiet_kernel(folder: Path) -> None:
    """IPython's settings for the code of tutorials: its notices are none of the documentation's."""
    settings = folder / "profile_default" / "ipython_kernel_config.py"
    settings.parent.mkdir(parents=True, exist_ok=True)
    settings.write_text("get_config().IPKernelApp.log_level = 'ERROR'\n", encoding="utf-8")


def begin(app: Any) -> None:
    """Sphinx's `builder-inited`."""
    write_pages(Path(app.srcdir))
    quiet_kernel(Path(os.environ["IPYTHONDIR"]))
    copy_mathjax(Path(app.outdir) / "_static")


def finish(app: Any, error: Exception | None) -> None:
    """Sphinx's `build-finished`."""
    from sphinx.util import logging

    if error is None and app.builder.name == "html":
        for sentence in links.broken(Path(app.outdir), links.anchors_of_report()):
            logging.getLogger(__name__).warning(sentence)


def label_toggles(app: Any, page: str, template: str, context: dict[str, Any], tree: Any) -> None:
    """Sphinx's `html-page-context`: names what opens the pages below one in the navigation."""
    made = context.get("generate_toctree_html")
    if made is not None:
        context["generate_toctree_html"] = lambda *arguments, **options: str(
            made(*arguments, **options)
        ).replace("<summary>", '<summary aria-label="Pages below">')


def setup(app: Any) -> dict[str, bool]:
    """Called by Sphinx."""
    app.connect("builder-inited", begin)
    app.connect("html-page-context", label_toggles, priority=900)  # after the theme's own
    app.connect("build-finished", finish)
    app.connect("autodoc-process-docstring", reference.docstring)
    app.connect("autodoc-process-signature", reference.signature)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
