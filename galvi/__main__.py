"""``python -m galvi``: the same as the command ``galvi``."""

import sys

from galvi.command import main

if __name__ == "__main__":
    sys.exit(main())
