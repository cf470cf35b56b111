"""Forces by textbook formulas, independent of galvi's kernels."""
