"""Studies that are not claims of a paper: cost, drift, scaling, round-off, engines."""
