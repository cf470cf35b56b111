"""Steps of point masses, rigid bodies and Lagrangians on R^d, eight stages to an instruction."""
