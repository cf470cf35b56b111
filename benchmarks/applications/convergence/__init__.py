"""Order and cost tables of methods on a problem, for `galvi.convergence`."""
