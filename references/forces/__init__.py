"""Forces by the textbook's formulas, apart from galvi's own kernels."""
