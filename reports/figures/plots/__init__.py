"""Drawing functions, one kind of plot per file."""
