"""MuJoCo's integrators."""
