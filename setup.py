"""What a wheel holds: galvi, with the suite's folders and the docs inside ``galvi/_suite``, and the
plugin ``pytest_galvi``, which is apart, since pytest imports it in every run and should not import
galvi.

An editable install finds all of them where they are.
"""

import re
import runpy
import sys
from pathlib import Path

from setuptools import find_packages, setup

SUITE = ("references", "benchmarks", "reports")
PLUGIN = "reports.pytest_galvi"
DATA = (
    "py.typed",
    "*.csv",
    "*.md",
    "*.bib",
    "*.css",
    "*.js",
    "*.j2",
    "*.mplstyle",
    "*.png",
    "data/*.csv",
    "mjcf/*.xml",
)

TOP = Path(__file__).parent
INFO = TOP / "PKG-INFO"  # of an unpacked sdist, which git does not know

release = runpy.run_path(str(TOP / "galvi" / "interop" / "release.py"))
version = release["version_in_git"](TOP) or (
    re.search(r"^Version: (.*)$", INFO.read_text(encoding="utf-8"), re.MULTILINE)[1]
    if INFO.is_file()
    else f"{release['RELEASE']}+unknown"
)

everything = find_packages(
    include=[f"{name}{ending}" for name in ("galvi", *SUITE) for ending in ("", ".*")]
)
if "editable_wheel" in sys.argv:
    folders = {"": ".", "pytest_galvi": PLUGIN.replace(".", "/")}
    setup(version=version, packages=[*everything, "pytest_galvi"], package_dir=folders)
else:
    names = {
        name: name if name.startswith("galvi") else f"galvi._suite.{name}" for name in everything
    } | {PLUGIN: "pytest_galvi"}
    docs = "galvi._suite.docs"
    setup(
        version=version,
        packages=[*names.values(), docs],
        package_dir={new: name.replace(".", "/") for name, new in names.items()} | {docs: "docs"},
        package_data={new: list(DATA) for new in names.values()} | {docs: ["**/*"]},
        exclude_package_data={docs: ["generated/*", "generated/**/*"]},
    )
