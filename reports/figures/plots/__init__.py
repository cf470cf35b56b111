"""Drawing functions for the figures of claims, one kind of plot per file."""
