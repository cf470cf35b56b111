"""Models of other programs as problems, and runs for other programs."""
