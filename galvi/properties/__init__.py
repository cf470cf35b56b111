"""Properties of the method of a space and a rule: exactness, order, symmetry, classical name."""
