"""Files that are either whole or not there, as `benchmarks.atomic` writes them."""

from benchmarks.atomic import write

__all__ = ["write"]
