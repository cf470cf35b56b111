"""Error against cost: problems, contenders, settings and fronts."""
