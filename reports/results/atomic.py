"""Files that are either whole or not there, as `benchmarks.store.atomic` writes them."""

from benchmarks.store.atomic import write

__all__ = ["write"]
