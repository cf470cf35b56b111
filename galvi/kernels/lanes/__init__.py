"""Steps of point masses, rigid bodies and Lagrangians on R^d, with vectors of eight or four stages."""
