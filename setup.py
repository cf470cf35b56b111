"""What a wheel holds: galvi, and the suite's folders inside ``galvi/_suite``.

An editable install finds all of them where they are.
"""

import sys

from setuptools import find_packages, setup

SUITE = ("references", "benchmarks", "reports")
DATA = ("py.typed", "*.csv", "*.bib", "*.css", "*.js", "*.j2", "*.mplstyle", "*.png", "data/*.csv")

everything = find_packages(include=[f"{name}{rest}" for name in ("galvi", *SUITE)
                                    for rest in ("", ".*")])  # fmt: skip
if "editable_wheel" in sys.argv:
    setup(packages=everything, package_dir={"": "."})
else:
    names = {
        name: name if name.startswith("galvi") else f"galvi._suite.{name}" for name in everything
    }
    setup(
        packages=list(names.values()),
        package_dir={new: name.replace(".", "/") for name, new in names.items()},
        package_data={new: list(DATA) for new in names.values()},
    )
