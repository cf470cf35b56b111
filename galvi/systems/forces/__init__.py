"""External forces: those that are not the gradient of a potential."""
