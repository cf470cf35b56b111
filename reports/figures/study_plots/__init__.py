"""How the figures of studies and comparisons are drawn."""
