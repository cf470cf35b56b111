"""Steps in vector instructions: of point masses, canonical systems and Lagrangians."""
