"""Claims, bounds and verdicts."""
