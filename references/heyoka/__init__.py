"""heyoka's Taylor integrator."""
