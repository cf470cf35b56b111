"""Build the site with the tutorials run; exit 1 where Sphinx warns or a link leads nowhere."""

from reports.build.build import publish
from reports.contents import load
from reports.results.options import OUT, Options

if __name__ == "__main__":
    OUT.mkdir(parents=True, exist_ok=True)
    warnings = publish(load(), Options(out=OUT, command="make docs"), tutorials=True)
    raise SystemExit(int(bool(warnings)))
