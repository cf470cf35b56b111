"""Steps of point masses, rigid bodies and Lagrangians in vectors of eight or four stages."""
