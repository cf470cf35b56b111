"""Drawing functions for the figures of studies and comparisons, one kind of plot per file."""
