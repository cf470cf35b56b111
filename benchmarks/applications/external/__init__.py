"""External integrators: loading, running and checking them."""
