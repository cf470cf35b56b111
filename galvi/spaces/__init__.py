"""Function spaces on [0, 1]."""
