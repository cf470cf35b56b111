"""``python -m reports [verify | compare | build | studies | export | track | warm | readme]``."""

import sys

from reports.cli.commands import run
from reports.results.suite import load

if __name__ == "__main__":
    sys.exit(run(load, sys.argv[1:]))
