"""SciPy's integrators of initial value problems."""
