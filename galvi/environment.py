"""The environment variables of galvi, read when it is imported."""

from os import environ

if environ.get("GALVI_FAST", "1") not in ("0", "1"):
    raise ValueError(f"GALVI_FAST must be 0 or 1; received {environ['GALVI_FAST']!r}.")
# If False, the general kernel does all steps and no function is traced; the other engines are
# compared with this one.
FAST = environ.get("GALVI_FAST", "1") != "0"

NOT_INSTALLED = 3  # exit status of the command ``galvi`` where a package is not installed
