"""Performance tracking: the benchmark history, and the comparison of two revisions."""
